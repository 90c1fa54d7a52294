//! What `cargo xtask bench` runs: pose updates by every optimiser of ours and, with the feature `rivals`, by those of
//! other crates, on the same problems; world and mental rollouts on one thread and two.
//!
//! * Without an argument: times, as tables.
//! * `--json FILE`: the same, to a file too.
//! * `--count`: no clock; each contender once, inside [`measured`], for callgrind. Says on each line what was counted
//!   and how often it was done.

mod ours;
#[cfg(feature = "rivals")]
mod rivals;
mod table;

use anyhow::{Context, bail, ensure};
use serde_json::{Value, json};
use std::hint::black_box;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;
use table::Row;
use tactus_common::pose::PlanarPose;
use tactus_controller::error::ErrorFunction;
use tactus_controller::optimise::start;
use tactus_sim_host::experiment::bench::{self, Rates, median};
use tactus_tests::problems::{self, Problem};

/// Problems: enough that one of them is 3 % of a share.
const PROBLEMS: usize = 30;
/// Evaluations that a search may make.
const BUDGETS: [u16; 2] = [100, 300];
/// Rounds of every contender on every problem, in turn; the fastest counts, for what else the machine does only adds.
const ROUNDS: usize = 7;
/// Poses at which the error is counted, for each problem.
const POSES: u16 = 20;

/// What an update comes to.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// The pose found.
    pub pose: PlanarPose,
    /// Evaluations of the error; one = value and slope at one pose.
    pub evaluations: u32,
}

/// Does an update of a problem within a number of evaluations.
type Update = Box<dyn Fn(&Problem, u16) -> Outcome>;

/// A way to do an update, with its name.
pub struct Contender {
    /// The crate it is of.
    pub origin: &'static str,
    /// Its name there.
    pub name: &'static str,
    /// Bytes of its state, where it is known and all of it.
    pub bytes: Option<usize>,
    /// What must be known to compare it fairly.
    pub note: &'static str,
    /// Does it.
    pub update: Update,
}

impl Contender {
    fn label(&self) -> String {
        format!("{} {}", self.origin, self.name)
    }
}

/// Ours first: the default at the head, then the searches of which it could be made.
fn contenders() -> Vec<Contender> {
    #[allow(unused_mut, reason = "without rivals nothing is added")]
    let mut all = ours::all();
    #[cfg(feature = "rivals")]
    all.extend(rivals::all());
    all
}

fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["--count"] => count(),
        [] => compare(None),
        ["--json", file] => compare(Some(file.into())),
        // What `cargo bench` adds.
        ["--bench"] => compare(None),
        _ => bail!("{}: expected --count, --json FILE or nothing", args.join(" ")),
    }
    .context("bench")
}

/// Where callgrind counts. The object keeps the call from being the function's end, which would be a jump.
#[inline(never)]
fn measured(work: &mut dyn FnMut()) {
    work();
    black_box(work);
}

/// Everything once, for callgrind.
fn count() -> anyhow::Result<()> {
    let problems = problems::seeded(PROBLEMS);
    // Poses all over the region, as a search meets them.
    let poses: Vec<PlanarPose> = (0..POSES).map(|i| problems[0].prior.bounds().at(start(i))).collect();
    measured(&mut || {
        for problem in &problems {
            let error = problem.error();
            for pose in &poses {
                black_box(error.evaluate(black_box(pose)));
            }
        }
    });
    println!("evaluation of the error\t{}", problems.len() * poses.len());
    for contender in contenders() {
        measured(&mut || {
            for problem in &problems {
                black_box((contender.update)(problem, BUDGETS[0]));
            }
        });
        println!("{}\t{}", contender.label(), problems.len());
    }
    Ok(())
}

/// Everything with a clock.
fn compare(file: Option<PathBuf>) -> anyhow::Result<()> {
    let started = Instant::now();
    let problems = problems::seeded(PROBLEMS);
    let contenders = contenders();
    println!(
        "{PROBLEMS} pose updates: 3 touches, 9 contacts, noise {:.1} mm, truth within {:.2} m, {:.2} m, {:.2} rad of the guess;",
        problems::NOISE_M * 1e3,
        problems::INTERVAL.x_m,
        problems::INTERVAL.y_m,
        problems::INTERVAL.phi_rad
    );
    println!("the fastest of {ROUNDS} rounds on each problem, then the median over the problems");
    let mut rows = Vec::new();
    for budget in BUDGETS {
        let of_budget = race(&contenders, &problems, budget)?;
        table::print(&of_budget, budget);
        rows.extend(of_budget);
    }
    println!();
    for note in table::notes(&contenders) {
        println!("{note}");
    }
    println!();
    progress("world and rollouts");
    let (world, rollouts) = (bench::world_ticks()?, bench::rollouts()?);
    progress("");
    print_rates("world ticks of 2 ms, all sensors", &world);
    print_rates("mental rollouts of a touch", &rollouts);
    let medians = bench::medians()?;
    if let Some(file) = file {
        let mut figures = vec![
            figure("world, one thread", medians.world_speed, "x real time", "median of runs of 2 s, all sensors"),
            figure("mental rollout", medians.rollout_ms, "ms", "median; 0.6 s of closing"),
            figure("pose update in missions", medians.update_ms, "ms", "median of the updates of 5 missions"),
        ];
        figures.extend(rates_figures("world ticks", "ticks/s", &world));
        figures.extend(rates_figures("mental rollouts", "rollouts/s", &rollouts));
        let told = json!({
            "experiment": "bench",
            "title": "Time and evaluations of a pose update, every optimiser and those of other crates",
            "settings": { "error": "geometric", "problems": PROBLEMS, "touches": problems::TOUCHES,
                "noise": true, "noise_mm": (f64::from(problems::NOISE_M) * 1e5).round() / 1e2, "budgets": BUDGETS, "rounds": ROUNDS },
            "figures": figures,
            "table": rows.iter().map(Row::json).collect::<Vec<_>>(),
            "wall_time_s": started.elapsed().as_secs_f64(),
        });
        std::fs::write(&file, format!("{told:#}\n")).with_context(|| format!("{}", file.display()))?;
    }
    Ok(())
}

/// Every contender on every problem, in turn.
fn race(contenders: &[Contender], problems: &[Problem], budget: u16) -> anyhow::Result<Vec<Row>> {
    let mut best_s = vec![vec![f64::INFINITY; problems.len()]; contenders.len()];
    let mut outcomes = vec![Vec::new(); contenders.len()];
    for round in 0..ROUNDS {
        progress(&format!("budget {budget}: round {} of {ROUNDS}", round + 1));
        for (at, problem) in problems.iter().enumerate() {
            for (who, contender) in contenders.iter().enumerate() {
                let started = Instant::now();
                let outcome = black_box((contender.update)(black_box(problem), budget));
                best_s[who][at] = best_s[who][at].min(started.elapsed().as_secs_f64());
                if round == 0 {
                    outcomes[who].push(outcome);
                }
            }
        }
    }
    progress("");
    let mut rows = Vec::new();
    for ((contender, times_s), outcomes) in contenders.iter().zip(best_s).zip(outcomes) {
        let errors_m: Vec<f64> = outcomes.iter().zip(problems).map(|(o, p)| p.location_error_m(&o.pose)).collect();
        ensure!(errors_m.iter().all(|e| e.is_finite()), "{}: a pose that is no number", contender.label());
        let within = errors_m.iter().filter(|e| **e <= 2e-3).count();
        rows.push(Row {
            origin: contender.origin,
            name: contender.name,
            budget,
            bytes: contender.bytes,
            note: contender.note,
            location_error_median_m: median(errors_m),
            within_2mm: within as f64 / problems.len() as f64,
            evaluations_median: median(outcomes.iter().map(|o| f64::from(o.evaluations)).collect()),
            time_median_s: median(times_s),
            to_default: f64::NAN,
            to_search: f64::NAN,
        });
    }
    table::set_ratios(&mut rows);
    Ok(rows)
}

fn print_rates(what: &str, rates: &Rates) {
    println!("{what}: {:.0}/s on one thread, {:.0}/s on two: {:.2} x", rates.one, rates.two, rates.gain());
}

/// A number of the report, with as many decimals as it deserves.
fn figure(name: &str, value: f64, unit: &str, note: &str) -> Value {
    json!({ "name": name, "value": (value * 100.0).round() / 100.0, "unit": unit, "note": note })
}

fn rates_figures(name: &str, unit: &str, rates: &Rates) -> [Value; 3] {
    [
        figure(&format!("{name}, 1 thread"), rates.one, unit, "the fastest of a few rounds"),
        figure(&format!("{name}, 2 threads"), rates.two, unit, "two that share nothing, together"),
        figure(&format!("{name}, 2 threads to 1"), rates.gain(), "ratio", "2 at best"),
    ]
}

/// On a terminal: what is being done; nothing ends it.
fn progress(what: &str) {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{what}");
    }
}
