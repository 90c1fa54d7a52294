//! `tactus reproduce`: all experiments of docs/results.md, one after the other, by the very commands that it prints.

use super::report::ReportArgs;
use super::{Cli, carry_out};
use anyhow::{Context, ensure};
use clap::{Args, Parser};
use std::path::{Path, PathBuf};
use tactus_hil::say;

/// An experiment: the stem of its files, and the command line without its output, in full and in short.
struct Experiment {
    stem: &'static str,
    full: &'static str,
    quick: &'static str,
}

/// A coarse grid over table 3's region.
const COARSE: &str = "--x 0.1,0.3,0.05 --y -0.15,-0.04,0.055";

/// Every second pose of table 3's grid in x and y; every fourth.
const SECOND: &str = "--x 0.1,0.3,0.02 --y -0.15,-0.04,0.01";
const FOURTH: &str = "--x 0.1,0.3,0.04 --y -0.15,-0.04,0.02";

/// All experiments, in the order of docs/results.md.
const EXPERIMENTS: &[Experiment] = &[
    Experiment { stem: "surface_geometric", full: "surface", quick: "surface" },
    Experiment { stem: "surface_modified", full: "surface --error modified", quick: "surface --error modified" },
    Experiment { stem: "surface_weighted", full: "surface --error weighted", quick: "surface --error weighted" },
    Experiment { stem: "surface_contact", full: "surface --error contact", quick: "surface --error contact" },
    Experiment {
        stem: "converge_published_nominal",
        full: "converge --error modified --reality nominal",
        quick: "converge --error modified --reality nominal COARSE",
    },
    Experiment {
        stem: "converge_published",
        full: "converge --error modified",
        quick: "converge --error modified COARSE",
    },
    Experiment {
        stem: "converge_nominal",
        full: "converge --reality nominal",
        quick: "converge --reality nominal COARSE",
    },
    Experiment { stem: "converge", full: "converge", quick: "converge COARSE" },
    Experiment {
        stem: "sensitivity_two_sided",
        full: "converge --error modified SECOND",
        quick: "converge --error modified COARSE",
    },
    Experiment {
        stem: "sensitivity_one_sided",
        full: "converge --error modified --gradient one-sided SECOND",
        quick: "converge --error modified --gradient one-sided COARSE",
    },
    Experiment {
        stem: "sensitivity_damping_1",
        full: "converge --error modified --damping 1 SECOND",
        quick: "converge --error modified --damping 1 COARSE",
    },
    Experiment {
        stem: "sensitivity_instants_8",
        full: "converge --error modified --instants 8 SECOND",
        quick: "converge --error modified --instants 8 COARSE",
    },
    Experiment {
        stem: "sensitivity_dof_1",
        full: "converge --error modified --dof 1",
        quick: "converge --error modified --dof 1 COARSE",
    },
    Experiment {
        stem: "sensitivity_dof_3",
        full: "converge --error modified --dof 3 FOURTH",
        quick: "converge --error modified --dof 3 COARSE",
    },
    Experiment {
        stem: "locate_nominal",
        full: "trials --task locate --reality nominal --count 300 --offset 0.10,0.10,0.7854 --max-trials 4",
        quick: "trials --task locate --reality nominal --count 20 --offset 0.10,0.10,0.7854 --max-trials 4",
    },
    Experiment {
        stem: "locate",
        full: "trials --task locate --count 300 --offset 0.10,0.10,0.7854 --max-trials 4",
        quick: "trials --task locate --count 20 --offset 0.10,0.10,0.7854 --max-trials 4",
    },
    Experiment { stem: "compare", full: "compare --count 100", quick: "compare --count 4 --budget 100" },
];

/// `tactus reproduce`.
#[derive(Args, Debug)]
pub(super) struct ReproduceArgs {
    /// Folder for the results; those that are there already are not made again.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Coarse grids and few missions: minutes instead of an hour.
    #[arg(long)]
    quick: bool,
    /// How many poses, starts or missions at a time [default: one per processor]; the results do not depend on it.
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

pub(super) fn run(args: &ReproduceArgs) -> anyhow::Result<u8> {
    std::fs::create_dir_all(&args.folder).with_context(|| args.folder.display().to_string())?;
    for (number, experiment) in EXPERIMENTS.iter().enumerate() {
        let csv = args.folder.join(experiment.stem).with_extension("csv");
        say::line(format_args!("[{} of {}] {}", number + 1, EXPERIMENTS.len(), command(experiment, args.quick)))?;
        if is_made(&csv) {
            say::line(format_args!("  is there already: {}", csv.display()))?;
            continue;
        }
        let line = command(experiment, args.quick);
        let mut words: Vec<String> = std::iter::once("tactus").chain(line.split(' ')).map(str::to_owned).collect();
        words.extend(["--csv".to_owned(), csv.display().to_string()]);
        if let Some(jobs) = args.jobs {
            words.extend(["--jobs".to_owned(), jobs.to_string()]);
        }
        let line = words.join(" ");
        let cli = Cli::try_parse_from(words).context("a command of this program's own list")?;
        let status = carry_out(cli.command, &line)?;
        ensure!(status == 0, "`{line}` ended with status {status}");
    }
    ReportArgs::of(&args.folder).run()
}

fn command(experiment: &Experiment, quick: bool) -> String {
    let line = if quick { experiment.quick } else { experiment.full };
    [("COARSE", COARSE), ("SECOND", SECOND), ("FOURTH", FOURTH)]
        .iter()
        .fold(line.to_owned(), |line, (name, grid)| line.replace(name, grid))
}

/// The record is written last.
fn is_made(csv: &Path) -> bool {
    csv.exists() && csv.with_extension("json").exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_of_the_list_is_a_command_that_is_understood_and_has_files_of_its_own() {
        let mut stems = Vec::new();
        for experiment in EXPERIMENTS {
            for quick in [false, true] {
                let line = format!("tactus {} --csv x.csv --jobs 1", command(experiment, quick));
                assert!(Cli::try_parse_from(line.split(' ')).is_ok(), "{line}");
            }
            assert!(!stems.contains(&experiment.stem), "{}", experiment.stem);
            stems.push(experiment.stem);
        }
    }
}
