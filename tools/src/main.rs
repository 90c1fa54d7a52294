//! `cargo xtask`: the same commands for people and for CI. Here: the command line. [`setup`]: what the commands need
//! from the machine. [`lint`], [`tests`]: what must be green before a change lands. [`vcan`]: a CAN interface for any command.
//! [`page`]: the script of the replay page. [`cross`]: firmware images. [`mod@bench`]: what a pose update costs. [`cargo`]: calls of cargo.

mod bench;
mod cargo;
mod cross;
mod lint;
mod page;
mod setup;
mod tests;
mod vcan;

use clap::{Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Developer commands of Tactus.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Say what is missing for building and testing, and install it where that is possible.
    Setup,
    /// Format, lint, test: all that must be green before a change lands.
    Test {
        /// Only the tests that cargo itself cannot run and whose files' names begin so: `socketcan`, `firmware`.
        #[arg(long, value_name = "FILES")]
        only: Option<String>,
    },
    /// Run the ignored tests of these binaries, and write the number of those that passed to a file.
    #[command(hide = true)]
    RunIgnored {
        /// The file.
        counts: PathBuf,
        /// The binaries.
        binaries: Vec<PathBuf>,
    },
    /// Build the firmware images and hold them against firmware/budget.toml: size, stack, instructions, panic sites; the
    /// whole main job runs in an emulator.
    Cross {
        /// Only what needs no emulator: build, size, panic sites.
        #[arg(long)]
        no_run: bool,
    },
    /// Formatting, clippy and documentation, warnings as errors.
    Lint,
    /// Bundle the script of the replay page from sim-host/view (needs Node, which nothing else does).
    Page,
    /// Make the README's picture, docs/replay.png, from a run recorded now.
    Picture,
    /// Repeat the long tests on a CAN interface: world, times and troubles by seed. A failure prints the line that
    /// repeats it.
    Soak {
        /// First seed.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// How many seeds.
        #[arg(long, default_value_t = 10)]
        count: u64,
    },
    /// Run a command with an interface vcan0 (CAN FD), on this machine's own CAN or in user-mode Linux; the exit status
    /// is the command's, 124 after the time limit.
    Vcan {
        /// Seconds after which the command is killed.
        #[arg(long, default_value_t = 900)]
        timeout: u64,
        /// Do not say where it runs.
        #[arg(long)]
        quiet: bool,
        /// The command and its arguments.
        #[arg(required = true, last = true)]
        command: Vec<OsString>,
    },
    /// What a pose update costs: every optimiser beside those of other crates, times as ratios and instructions beside
    /// their reference; world and mental rollouts on one thread and two.
    Bench {
        /// Only count instructions, and fail where one is more than 5 % above firmware/instructions.toml.
        #[arg(long, conflicts_with_all = ["accept", "json"])]
        check: bool,
        /// Only count instructions, and write them to firmware/instructions.toml.
        #[arg(long, conflicts_with = "json")]
        accept: bool,
        /// Write everything to this file too.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let started = Instant::now();
    let (name, done) = match Cli::parse().command {
        Task::Setup => ("setup", setup::everything()),
        Task::Test { only: None } => ("test", tests::run()),
        Task::Test { only: Some(files) } => ("test", tests::run_only(&files)),
        Task::RunIgnored { counts, binaries } => ("run-ignored", tests::run_ignored(&counts, &binaries)),
        Task::Cross { no_run } => ("cross", cross::run(no_run)),
        Task::Lint => ("lint", lint::run()),
        Task::Page => ("page", page::script()),
        Task::Picture => ("picture", page::picture()),
        Task::Soak { seed, count } => ("soak", tests::soak(seed, count)),
        Task::Vcan { timeout, quiet, command } => {
            return vcan::main(&command, vcan::Options { limit: Duration::from_secs(timeout), quiet });
        }
        Task::Bench { check, accept, json } => ("bench", bench::run(&bench::Options { check, accept, json })),
    };
    match done {
        Ok(()) => {
            eprintln!("xtask {name}: passed in {:.0} s", started.elapsed().as_secs_f32());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("xtask {name}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
