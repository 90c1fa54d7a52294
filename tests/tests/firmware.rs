//! Promise: the controller as a Cortex-M4F image does exactly what it does in the process of the world, and is as safe.

use std::path::PathBuf;
use std::time::Duration;
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::message::{Event, EventKind, FaultReason, Outcome};
use tactus_tests::emulator::{Emulator, Told as Measured, image, measurements};
use tactus_tests::program::{Profile, run, summary};
use tactus_tests::recording::Recording;
use tactus_tests::rig::{Rig, Told, is_limp};
use tactus_tests::serial_world::{Heard, SerialWorld};

/// For anything that the image has to do.
const PATIENCE: Duration = Duration::from_secs(60);
/// At one instruction a nanosecond, of a clock of 25 MHz.
const INSTRUCTIONS_PER_COUNT: u64 = 40;
/// Ticks of the shortened missions: the set-up, the choice of the first touch, and the first trajectory are in them.
const TICKS: usize = 150;

/// What the world says in a mission's first ticks.
fn beginning() -> &'static [Told] {
    &Recording::shared().told[..TICKS]
}

/// Plays the beginning to the image and to a node on the host: the same commands.
fn play(world: &mut SerialWorld, mut between: impl FnMut(&mut SerialWorld, usize)) {
    let mut host = Rig::new();
    for (n, told) in beginning().iter().enumerate() {
        between(world, n);
        assert_eq!(world.tell(told), host.tell(told).commands(), "first difference");
    }
}

/// Leaves what the image measured of itself for `cargo xtask cross`.
fn keep(mission: &Measured) {
    let instructions = |name| mission.number(name) * INSTRUCTIONS_PER_COUNT;
    let text = format!(
        "digest = \"{}\"\nticks = {}\nstack = {}\nworst_tick = {}\nmean_tick = {}\n",
        mission.values["digest"],
        mission.number("ticks"),
        mission.number("stack"),
        instructions("worst_counts"),
        instructions("mean_counts"),
    );
    let path = measurements();
    std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn the_whole_main_job_ends_at_the_goal_with_the_digest_that_it_has_in_process() {
    let args = ["run", "--seed", "1"];
    let (in_process, _) = summary(Profile::Release, &args);
    let emulator = Emulator::start(&image(), "job");
    let bus = format!("slcan:{}", emulator.socket().display());
    let (with_image, ran) = summary(Profile::Release, &[&args[..], &["--bus", &bus]].concat());
    assert_eq!((ran.status, &with_image["outcome"]), (0, &"transported".into()), "{}", ran.stderr);
    assert_eq!(with_image["digest"], in_process["digest"]);
    let calibration = emulator.told("calibration", PATIENCE);
    let per_count = calibration.number("instructions") as f64 / calibration.number("counts") as f64;
    assert!((per_count - INSTRUCTIONS_PER_COUNT as f64).abs() < 0.01, "{per_count} instructions a count");
    let mission = emulator.told("mission", PATIENCE);
    assert_eq!(with_image["digest"], mission.values["digest"].as_str());
    assert_eq!(mission.number("lost"), 0, "bytes lost on the serial line");
    keep(&mission);
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn a_mission_begins_command_by_command_as_on_the_host_whatever_else_is_on_the_line() {
    let emulator = Emulator::start(&image(), "noise");
    let mut world = SerialWorld::join(emulator.socket());
    // Half a line, one too long, bytes that no line has, a bell, frames of others, answers, commands.
    let noises: [&[u8]; 6] =
        [b"T00001\r", &[b'T'; 1_500], b"\xff\x00\x80#\r", b"\x07", b"r1230\rt1231FF\r\r\r", b"z\rC\rS8\rO\r"];
    let foreign = CanFrame::new(0x1fff_ffff, &[0xff; 8], Mtu::Classic).expect("a frame");
    play(&mut world, |world, n| {
        world.write(noises[n % noises.len()]);
        world.write(b"\r");
        world.send_frame(&foreign);
    });
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn a_world_that_falls_silent_leaves_a_safe_controller_and_the_next_one_finds_it_ready() {
    let emulator = Emulator::start(&image(), "silence");
    let mut world = SerialWorld::join(emulator.socket());
    play(&mut world, |_, _| {});
    let heard = world.listen_for(Duration::from_secs(8));
    let silent = EventKind::Finished(Outcome::Fault(FaultReason::HostSilent));
    assert!(heard.iter().any(|h| matches!(h, Heard::Event(Event { kind, .. }) if *kind == silent)), "{heard:?}");
    let commands: Vec<_> =
        heard.iter().filter_map(|h| if let Heard::Command(c) = h { Some(c) } else { None }).collect();
    let limp = commands.iter().position(|c| is_limp(c)).expect("commands without torque");
    assert!(commands[limp..].iter().all(|c| is_limp(c)) && commands.len() <= 21, "{commands:?}");
    let later = world.listen_for(Duration::from_secs(3));
    assert!(!later.iter().any(|h| matches!(h, Heard::Command(_))), "commands to nobody: {later:?}");
    assert!(later.contains(&Heard::Hello), "it says that it is free: {later:?}");
    drop(world);
    play(&mut SerialWorld::join(emulator.socket()), |_, _| {});
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn an_optimiser_that_the_image_lacks_is_refused_and_the_way_to_one_that_has_it_told() {
    let emulator = Emulator::start(&image(), "lacking");
    let bus = format!("slcan:{}", emulator.socket().display());
    let ran = run(&["run", "--quiet", "--optimizer", "direct", "--bus", &bus]);
    assert_eq!(ran.status, 4, "{}", ran.stderr);
    assert!(ran.stderr.contains("NotInImage") && ran.stderr.contains("--features optimizers"), "{}", ran.stderr);
}

/// The image with one of its 32-bit words at the beginning of flash (the vectors) changed.
fn with_vector(name: &str, vector: usize, value: impl Fn(&[u8]) -> [u8; 4]) -> PathBuf {
    let mut bytes = std::fs::read(image()).expect("the image: cargo xtask cross");
    let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize;
    // ELF32: e_phoff at 28; the program header that holds address 0: p_type 1 at 0, p_offset at 4, p_vaddr at 8.
    let headers = (0..16).map(|n| word(28) + 32 * n);
    let vectors =
        headers.filter(|&h| word(h) == 1 && word(h + 8) == 0).map(|h| word(h + 4)).next().expect("a vector table");
    let changed = value(&bytes[vectors..vectors + 0x80]);
    bytes[vectors + 4 * vector..][..4].copy_from_slice(&changed);
    let path = std::env::temp_dir().join(format!("tactus-{name}-{}.elf", std::process::id()));
    std::fs::write(&path, bytes).expect("a place for temporary files");
    path
}

/// Runs an image that cannot go on, at the latest when these bytes come: it says where it stopped, by its serial line and
/// by its emulator, which ends with a status of failure; not one frame leaves it afterwards.
fn stops(image: PathBuf, name: &str, bytes: &[u8], place: &str) {
    let mut emulator = Emulator::start(&image, name);
    let mut world = SerialWorld::join(emulator.socket());
    world.write(bytes);
    let (lines, status) = emulator.end(PATIENCE);
    let _ = std::fs::remove_file(image);
    assert!(!status.success(), "{status}");
    assert!(lines.iter().any(|line| line.contains("tactus stopped at") && line.contains(place)), "{lines:?}");
    let text = world.rest();
    let said = text.find("#tactus stopped at").unwrap_or_else(|| panic!("no word on the line: {text:?}"));
    assert!(text[said..].lines().count() == 1 && text[said..].contains(place), "{text:?}");
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn an_image_that_panics_says_where_and_sends_nothing_any_more() {
    // The clock's vector leads to the handler of an interrupt that nobody asked for.
    let image = with_vector("panic", 15, |vectors| vectors[4 * 17..4 * 18].try_into().expect("four bytes"));
    stops(image, "panic", b"", "src/uart.rs:");
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask cross runs it"]
fn an_image_whose_processor_faults_says_so_and_sends_nothing_any_more() {
    // The receiver's vector leads to no code.
    stops(with_vector("fault", 16, |_| [0; 4]), "fault", b"C\r", "src/stop.rs:");
}
