//! The command line: a contract with tools outside this repository (see `docs/cli.md`).

mod experiments;
mod recordings;
mod report;
mod reproduce;
mod scenes;
mod view;

use crate::controller_process::ControllerProcess;
use crate::experiment::capture::Task;
use crate::experiment::conduct::Conditions;
use crate::experiment::trials::{self, TrialsOptions};
use crate::hooks::Hooks;
use crate::method::MethodArgs;
use crate::mission::{self, MissionOptions, MissionReport};
use crate::observer::{Both, Observer};
use crate::recording::Recorder;
use crate::report::{explain::explanation, progress::Progress, summary::Summary, terminal};
use crate::scenario::Scenario;
use crate::serve::serve;
use crate::wire::{InProcess, Live, Wire};
use anyhow::Context;
use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use tactus_common::can::Mtu;
use tactus_common::link::CONTROLLER;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_hil::bus_name::BusName;
use tactus_hil::choice::{CanFormat, Pace};
use tactus_hil::say;
use tactus_hil::usage::one_line;

/// Exit status: usage or input error.
const EXIT_USAGE: u8 = 2;
/// How long `run` waits for the controller that it has started.
const START_PATIENCE: Duration = Duration::from_secs(20);

const AFTER_HELP: &str = "\
Examples:
  tactus                                     the main job with its defaults (seed 1)
  tactus run --seed 7 --summary -            another world, the result as JSON on standard output
  tactus run --true 0.1,-0.15,0.4 --guess 0.12,-0.12,0.2
  tactus run --sensors ideal --error modified --optimizer steepest-descent-golden    the published method
  tactus run --bus socketcan:vcan0           the controller as a process of its own, on a CAN interface
  tactus run --record run.mcap               all of the run in one file, for Foxglove, Rerun and the next two
  tactus info run.mcap
  tactus export run.mcap --csv run           its numbers as tables: run/sensors_joints.csv, ...
  tactus serve --bus socketcan:vcan0         the world alone, for tactus-controller or a board on that bus
  tactus trials --count 200 --offset 0.05,0.05,0.35 --csv trials.csv
  tactus scenes                              the built-in scenes; --show NAME prints one, to begin a scene of one's own
  tactus run --scenario cylinder             one of them; or a file: tactus check my.toml, tactus run --scenario my.toml
  tactus surface --error modified --csv results/surface_modified.csv
  tactus converge --csv results/converge.csv
  tactus compare --csv results/compare.csv
  tactus run --record run.mcap && tactus view run.mcap    a run as a file, and as one page for a browser
  tactus report results                      one page of them all: results/report.html

Exit status: 0 done, 2 bad usage or input, 3 the task failed, 4 fault.";

/// A robot hand that finds things by touch, in a simulated world.
#[derive(Parser, Debug)]
#[command(name = "tactus", version, after_help = AFTER_HELP, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// One mission: find the object by touch, grasp it, carry it (0.5 m along -x), put it down (the default command).
    Run(RunArgs),
    /// The world alone: waits for a controller on a bus (tactus-controller, or a board) and carries the mission out
    /// with it. A controller that is lost leaves the arm without torque, and the next one finds the world set up anew.
    Serve(ServeArgs),
    /// Many missions over seeds, with statistics: true poses uniform over x in [0.0, 0.3] m, y in [-0.2, 0.0] m,
    /// phi in [-pi/4, pi/4] rad, or over the scene's own region (`trials`), where the object stands free of all else;
    /// guess = truth + uniform in +-offset; run i uses seed N + i.
    Trials(TrialsArgs),
    /// An error over a grid of poses; the grid of the published experiments by default.
    Surface(experiments::SurfaceArgs),
    /// Regions of convergence: the search from every pose of a grid; 483 starts of the published experiments by default.
    Converge(experiments::ConvergeArgs),
    /// All optimisers and errors on the same problems: the same evidence, bounds, start and budgets.
    Compare(experiments::CompareArgs),
    /// All experiments of docs/results.md into a folder, and their report; what is there already is not made again.
    Reproduce(reproduce::ReproduceArgs),
    /// What is in a recording of `run --record`: channels, times, phases, outcome, digest.
    Info(recordings::InfoArgs),
    /// The numbers of a recording as CSV tables, one for each channel.
    Export(recordings::ExportArgs),
    /// A recording as one page for a browser: arm, hand and object in 3D, time line, plots; it needs no network.
    View(view::ViewArgs),
    /// One self-contained HTML page of all the experiments in a directory.
    Report(report::ReportArgs),
    /// The scenes that the program holds, and the schema of scene files.
    Scenes(scenes::ScenesArgs),
    /// Checks a scene file: says what is wrong with it and where, or what the scene is.
    Check(scenes::CheckArgs),
    /// Time the parts that the README quotes: world, mental rollout, pose update (medians).
    #[command(hide = true)]
    Bench,
}

#[derive(Args, Debug, Clone)]
struct CommonArgs {
    /// Seed of noise, model mismatch and default guess.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the result as JSON; `-` writes it to standard output and nothing else there.
    #[arg(long, value_name = "FILE.json")]
    summary: Option<PathBuf>,
    /// Scene to use: one that `tactus scenes` lists, or a file (docs/scenes.md).
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "thesis-box", hide_default_value = true)]
    scenario: PathBuf,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

/// How world and controller are connected.
#[derive(Args, Debug, Clone)]
struct WireArgs {
    /// Frame format [default: CAN FD where the bus carries it].
    #[arg(long, value_enum, value_name = "FORMAT")]
    can: Option<CanFormat>,
    /// What makes the ticks come.
    #[arg(long, value_enum, default_value_t = Pace::Lockstep)]
    pace: Pace,
}

/// Bus of `run`.
#[derive(Clone, Debug)]
enum RunBus {
    Virtual,
    Live(BusName),
}

impl std::str::FromStr for RunBus {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "virtual" => Ok(Self::Virtual),
            text => text.parse().map(Self::Live).map_err(|error: String| format!("{error}; or virtual")),
        }
    }
}

/// What stands where, and what the controller is told.
#[derive(Args, Debug, Clone)]
struct TaskArgs {
    /// True pose of the object (metres, metres, radians) [default: the scene's].
    #[arg(long = "true", value_name = "X,Y,PHI", value_parser = triple, allow_hyphen_values = true)]
    truth: Option<[f32; 3]>,
    /// Guess that the controller is told [default: the scene's, unless --true is given; else truth + uniform in the
    /// scene's interval or +-(0.05, 0.05, 0.35) by seed].
    #[arg(long, value_name = "X,Y,PHI", value_parser = triple, allow_hyphen_values = true)]
    guess: Option<[f32; 3]>,
    /// Half widths of the interval in which the controller is told the truth lies around the guess
    /// [default: the scene's, or 0.05,0.05,0.35].
    #[arg(long, value_name = "DX,DY,DPHI", value_parser = triple)]
    interval: Option<[f32; 3]>,
}

/// One mission, wherever its controller is.
#[derive(Args, Debug)]
struct MissionArgs {
    #[command(flatten)]
    common: CommonArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    task: TaskArgs,
    #[command(flatten)]
    wire: WireArgs,
}

#[derive(Args, Debug)]
struct RunArgs {
    #[command(flatten)]
    mission: MissionArgs,
    /// Bus between controller and world: `virtual` = both in this process; `socketcan:IFACE`: the controller is started
    /// as a process of its own; `slcan:PATH`: it is at the other end of that serial line already.
    #[arg(long, value_name = "BUS", default_value = "virtual")]
    bus: RunBus,
    /// Write a recording of the run (MCAP, for `tactus info`, `tactus export`, Foxglove, Rerun); see docs/recording.md.
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
}

#[derive(Args, Debug)]
struct ServeArgs {
    #[command(flatten)]
    mission: MissionArgs,
    /// Bus on which the controller is: `socketcan:IFACE`, or `slcan:PATH`.
    #[arg(long, value_name = "BUS")]
    bus: BusName,
    /// End after so many missions (missions whose controller was lost do not count).
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    missions: u32,
}

#[derive(Args, Debug)]
struct TrialsArgs {
    #[command(flatten)]
    common: CommonArgs,
    #[command(flatten)]
    method: MethodArgs,
    /// Missions to carry out.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// Half widths of the error of the guess (metres, metres, radians); also the interval the controller is told.
    #[arg(long, value_name = "DX,DY,DPHI", value_parser = triple, default_value = "0.05,0.05,0.35")]
    offset: [f32; 3],
    /// Write one line per mission.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// How far each mission is carried out.
    #[arg(long, value_enum, default_value_t = Task::Transport)]
    task: Task,
    /// Missions at a time [default: one per processor]; the results do not depend on it.
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

/// Three finite numbers with commas between them.
fn triple(text: &str) -> Result<[f32; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [a, b, c] = parts[..] else {
        return Err(format!("expected three numbers with commas between them, found {}", parts.len()));
    };
    let number = |s: &str| match s.trim().parse::<f32>() {
        Ok(v) if v.is_finite() => Ok(v),
        Ok(_) => Err(format!("'{s}' is not a finite number")),
        Err(_) => Err(format!("'{s}' is not a number")),
    };
    Ok([number(a)?, number(b)?, number(c)?])
}

/// Runs the command line; returns the exit status.
pub fn main(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = with_default_command(args);
    let words = args.iter().skip(1).map(|word| word.to_string_lossy());
    let line = std::iter::once("tactus".into()).chain(words).collect::<Vec<_>>().join(" ");
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => {
            return match say::text(error.render()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => unusable(&error.into()),
            };
        }
        Err(error) => {
            say::complaint(format_args!("{} (see tactus --help)", one_line(&error)));
            return ExitCode::from(EXIT_USAGE);
        }
    };
    match carry_out(cli.command, &line) {
        Ok(status) => ExitCode::from(status),
        Err(error) => unusable(&error),
    }
}

/// Says what was wrong with the input.
fn unusable(error: &anyhow::Error) -> ExitCode {
    say::complaint(format_args!("error: {error:#}"));
    ExitCode::from(EXIT_USAGE)
}

/// Carries out a command, given as `line`; the exit status.
fn carry_out(command: Command, line: &str) -> anyhow::Result<u8> {
    match command {
        Command::Run(args) => run(&args),
        Command::Serve(args) => serve_worlds(&args),
        Command::Trials(args) => trials(&args, line),
        Command::Surface(args) => experiments::surface(&args, line),
        Command::Converge(args) => experiments::converge(&args, line),
        Command::Compare(args) => experiments::compare(&args, line),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Info(args) => args.run(),
        Command::Export(args) => args.run(),
        Command::View(args) => args.run(),
        Command::Report(args) => args.run(),
        Command::Scenes(args) => args.run(),
        Command::Check(args) => args.run(),
        Command::Bench => crate::experiment::bench::run().map(|()| 0),
    }
}

/// `tactus` and `tactus --flag` mean `tactus run`.
fn with_default_command(args: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut args: Vec<OsString> = args.into_iter().collect();
    let first = args.get(1).and_then(|a| a.to_str()).unwrap_or("--run");
    if first.starts_with('-') && !matches!(first, "-h" | "--help" | "-V" | "--version") {
        args.insert(1, "run".into());
    }
    args
}

fn scenario(common: &CommonArgs) -> anyhow::Result<Scenario> {
    Scenario::load(&common.scenario).with_context(|| format!("--scenario {}", common.scenario.display()))
}

/// The interval with the components that `--dof` declares known set to zero.
fn with_dof(interval: [f32; 3], dof: u8) -> anyhow::Result<Interval> {
    let [x_m, y_m, phi_rad] = interval;
    anyhow::ensure!(
        interval.iter().all(|v| *v >= 0.0),
        "interval {x_m},{y_m},{phi_rad}: half widths must not be negative"
    );
    Ok(Interval { x_m, y_m, phi_rad }.of_first(dof))
}

fn mission_options(args: &MissionArgs) -> anyhow::Result<MissionOptions> {
    let MissionArgs { common, method, task, .. } = args;
    let chosen = method.options()?;
    let scenario = scenario(common)?;
    let usual = scenario.object.interval.unwrap_or(mission::DEFAULT_OFFSET);
    let interval = with_dof(task.interval.unwrap_or(usual), method.dof)?;
    let truth = task.truth.map_or(scenario.true_pose(), PlanarPose::from_array);
    // A scene's guess belongs to the scene's truth.
    let told = task.guess.map(PlanarPose::from_array).or(scenario.guess().filter(|_| task.truth.is_none()));
    let guess = match told {
        Some(guess) => guess,
        None => mission::guess_around(&truth, &with_dof(usual, method.dof)?, common.seed),
    };
    scenario.check_on_table("--true", &truth)?;
    scenario.check_on_table("--guess", &guess)?;
    Ok(MissionOptions {
        scenario,
        seed: common.seed,
        truth,
        guess,
        interval,
        trials_max: method.max_trials,
        reality: method.reality,
        method: chosen,
    })
}

/// Nothing is printed but errors: that was asked for, or standard output is for the summary.
fn is_quiet(common: &CommonArgs) -> bool {
    common.quiet || common.summary.as_deref().is_some_and(|p| p.as_os_str() == "-")
}

/// Prints and writes what came of a mission; the exit status.
fn report(common: &CommonArgs, options: &MissionOptions, report: &MissionReport) -> anyhow::Result<u8> {
    let quiet = is_quiet(common);
    if !quiet {
        say::text(terminal::closing(options, report))?;
    }
    if let Some(path) = &common.summary {
        Summary::of(options, report).write(path)?;
    }
    let status = report.exit_status();
    if status != 0 && quiet {
        let why = explanation(report).map_or(String::new(), |why| format!(": {why}"));
        say::complaint(format_args!("failed: {}{why}", report.outcome_text()));
    }
    Ok(status)
}

/// The world's end of a live bus.
fn open(bus: &BusName, wire: &WireArgs) -> anyhow::Result<Live> {
    let opened = bus.open(wire.can.map(Mtu::from), &[CONTROLLER]).with_context(|| format!("--bus {bus}"))?;
    Live::new(bus.to_string(), opened)
}

fn run(args: &RunArgs) -> anyhow::Result<u8> {
    let options = mission_options(&args.mission)?;
    let mut recorder = args.record.as_deref().map(|path| Recorder::create(path, &options)).transpose()?;
    let mut progress = Progress::new(is_quiet(&args.mission.common));
    let result = match &mut recorder {
        Some(recorder) => carry_out_on_bus(args, &options, &mut Both(&mut progress, recorder))?,
        None => carry_out_on_bus(args, &options, &mut progress)?,
    };
    progress.finish();
    if let Some(recorder) = recorder {
        recorder.finish(&options, &result)?;
    }
    report(&args.mission.common, &options, &result)
}

/// Carries a mission out, its controller wherever the bus has it.
fn carry_out_on_bus(
    args: &RunArgs,
    options: &MissionOptions,
    observer: &mut dyn Observer,
) -> anyhow::Result<MissionReport> {
    let pace = args.mission.wire.pace;
    match &args.bus {
        RunBus::Virtual => {
            let mtu = args.mission.wire.can.map_or(Mtu::Fd, Mtu::from);
            mission::run_on(options, pace, &mut InProcess::new(mtu, Hooks::NONE), observer)
        }
        RunBus::Live(bus) => {
            let mut live = open(bus, &args.mission.wire)?;
            let mut process = match bus {
                BusName::SocketCan(_) => Some(ControllerProcess::start(bus, live.mtu(), pace)?),
                BusName::Slcan(_) => None,
            };
            meet(&mut live, bus, process.as_mut())?;
            mission::run_on(options, pace, &mut live, observer)
        }
    }
}

/// Waits for the controller that was started, or is there.
fn meet(live: &mut Live, bus: &BusName, mut process: Option<&mut ControllerProcess>) -> anyhow::Result<()> {
    let started = Instant::now();
    while !live.meet(Duration::from_millis(100))? {
        if let Some(process) = &mut process {
            process.check()?;
        }
        anyhow::ensure!(
            started.elapsed() < START_PATIENCE,
            "--bus {bus}: no controller within {:.0} s; expected one at the other end, announcing itself every second",
            START_PATIENCE.as_secs_f32()
        );
    }
    Ok(())
}

fn serve_worlds(args: &ServeArgs) -> anyhow::Result<u8> {
    let options = mission_options(&args.mission)?;
    let mut live = open(&args.bus, &args.mission.wire)?;
    let quiet = is_quiet(&args.mission.common);
    let mut progress = Progress::new(quiet);
    let mut log = |line: &str| {
        if !quiet {
            say::complaint(format_args!("tactus serve on {}: {line}", args.bus));
        }
    };
    let result = serve(&options, args.mission.wire.pace, args.missions, &mut live, &mut log, &mut progress)?;
    progress.finish();
    report(&args.mission.common, &options, &result)
}

fn trials(args: &TrialsArgs, line: &str) -> anyhow::Result<u8> {
    let method = args.method.options()?;
    let offset = with_dof(args.offset, args.method.dof)?;
    let quiet = is_quiet(&args.common);
    let conditions = Conditions {
        scenario: scenario(&args.common)?,
        reality: args.method.reality,
        seed: args.common.seed,
        trials_max: args.method.max_trials,
        jobs: args.jobs.map_or(0, usize::from),
        quiet,
    };
    let options = TrialsOptions { conditions, count: args.count, offset, task: args.task, method };
    let (statistics, record) = trials::run(&options, args.csv.as_deref())?;
    if !quiet {
        say::line(statistics)?;
    }
    experiments::write(args.csv.as_deref(), args.common.summary.as_deref(), &record.with_command(line))
}
