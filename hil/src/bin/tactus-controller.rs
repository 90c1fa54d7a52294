//! The Tactus controller as a process on a bus.

use clap::Parser;
use std::process::ExitCode;
use tactus_common::can::Mtu;
use tactus_common::link::{CONTROLLER, WORLD};
use tactus_common::message::{EventKind, Outcome};
use tactus_hil::bus_name::BusName;
use tactus_hil::choice::{CanFormat, Pace};
use tactus_hil::say;
use tactus_hil::shell::{Shell, ShellEnd, ShellOptions};
use tactus_hil::usage::one_line;

const AFTER_HELP: &str = "\
Examples:
  tactus-controller --bus socketcan:vcan0          serves one mission after the other; the world: tactus serve
  tactus-controller --bus slcan:/dev/ttyACM0       the same on a serial CAN adapter

With --once, exit status: 0 mission done, 2 bad usage, bus, version, or another controller is there, 3 the task failed,
4 fault or the world fell silent.";

/// The controller: waits on a bus for a world (or a robot's gateway) and carries out its missions.
#[derive(Parser, Debug)]
#[command(name = "tactus-controller", version, after_help = AFTER_HELP)]
struct Cli {
    /// Bus to the world: `socketcan:IFACE`, or `slcan:PATH`.
    #[arg(long, value_name = "BUS")]
    bus: BusName,
    /// Frame format [default: CAN FD where the bus carries it].
    #[arg(long, value_enum, value_name = "FORMAT")]
    can: Option<CanFormat>,
    /// What makes the ticks come, and how long the world may be silent.
    #[arg(long, value_enum, default_value_t = Pace::Lockstep)]
    pace: Pace,
    /// End with the first mission, or after 30 s without one.
    #[arg(long)]
    once: bool,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => {
            return match say::text(error.render()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    say::complaint(format_args!("error: {error}"));
                    ExitCode::from(2)
                }
            };
        }
        Err(error) => {
            say::complaint(format_args!("{} (see tactus-controller --help)", one_line(&error)));
            return ExitCode::from(2);
        }
    };
    let mut bus = match cli.bus.open(cli.can.map(Mtu::from), &[WORLD, CONTROLLER]) {
        Ok(bus) => bus,
        Err(error) => {
            say::complaint(format_args!("error: --bus {}: {error}", cli.bus));
            return ExitCode::from(2);
        }
    };
    let options = ShellOptions { pace: cli.pace, once: cli.once };
    let mut shell = Shell::new(bus.as_mut(), options);
    let end = shell.run(&mut |said| {
        if !cli.quiet {
            say::complaint(format_args!("tactus-controller on {}: {said}", cli.bus));
        }
    });
    match end {
        ShellEnd::MissionOver(EventKind::Finished(Outcome::Transported)) => ExitCode::SUCCESS,
        ShellEnd::MissionOver(EventKind::Finished(Outcome::Failed(_))) => ExitCode::from(3),
        ShellEnd::MissionOver(_) | ShellEnd::Silence => ExitCode::from(4),
        ShellEnd::Twin => fail(&cli, "another controller is on this bus; stop it first"),
        ShellEnd::NoWorld => fail(&cli, "no world began a mission within 30 s; expected: tactus serve on the same bus"),
        ShellEnd::Version(_) => fail(&cli, "the world speaks another version of the messages"),
    }
}

fn fail(cli: &Cli, why: &str) -> ExitCode {
    say::complaint(format_args!("error: --bus {}: {why}", cli.bus));
    ExitCode::from(2)
}
