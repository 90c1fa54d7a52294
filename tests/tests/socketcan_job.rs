//! Promise: the main job with controller and world as two processes on SocketCAN is the job in one process, to the bit.

use serde_json::Value;
use std::path::Path;
use tactus_common::can::{CanFrame, Mtu};
use tactus_sim_host::recording::{Channel, Entry, Log};
use tactus_tests::can_bench::{BUS, MISSION, SHORT, Witness, in_process, in_two_processes, short_digest, world};
use tactus_tests::eavesdropper::Eavesdropper;
use tactus_tests::process::Process;

fn digest(summary: &Value) -> u64 {
    let text = summary["digest"].as_str().unwrap_or_else(|| panic!("a digest in {summary:#}"));
    u64::from_str_radix(text, 16).expect("sixteen hexadecimal digits")
}

/// Runs the job beside a witness; all three tell the same digest. Returns the summary and what was on the wire.
fn witnessed(format: &str, args: &[&str]) -> (Value, Vec<CanFrame>) {
    let reference = in_process(args);
    let witness = Witness::begin(&format!("candump-{format}.log"));
    let summary = in_two_processes(&[args, &["--can", format]].concat());
    let frames = witness.end();
    assert_eq!(summary["outcome"], "transported");
    assert_eq!(digest(&summary), digest(&reference), "two processes and one");
    let overheard = Eavesdropper::listen(&frames);
    assert_eq!(overheard.digest, digest(&reference), "what candump saw: {overheard:?}");
    assert_eq!(overheard.reported, Some((overheard.digest, overheard.ticks)));
    assert_eq!((overheard.bad, overheard.foreign), (0, 0), "{overheard:?}");
    assert_eq!(summary["deadline_misses"], 0);
    println!(
        "{format}: {} ticks, {} frames, busiest 100 ms {}, {:.1} s (one process: {:.1} s)",
        overheard.ticks,
        frames.len(),
        summary["bus"]["load_max"],
        summary["wall_time_s"],
        reference["wall_time_s"]
    );
    (summary, frames)
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn the_main_job_over_can_fd_has_the_digest_of_one_process_and_an_independent_witness_finds_it_too() {
    let (_, frames) = witnessed("fd", &[]);
    assert!(frames.iter().all(CanFrame::is_fd));
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn over_classic_can_too() {
    let (_, frames) = witnessed("classic", &SHORT);
    assert!(frames.iter().all(|frame| frame.mtu() == Mtu::Classic));
}

/// All messages of a recording but those about the bus: topic, time, bytes.
fn recorded(file: &str) -> Vec<(String, u64, Vec<u8>)> {
    let entries = Log::open(Path::new(file)).expect("a recording").map(|entry| entry.expect("it can be read"));
    let messages = entries.filter_map(|entry| match entry {
        Entry::Message(message) if message.source.channel != Some(Channel::Bus) => {
            Some((message.source.topic.clone(), message.time_ns, message.bytes))
        }
        _ => None,
    });
    messages.collect()
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_recording_of_two_processes_is_that_of_one_but_for_the_bus() {
    let [one, two] = ["/dev/shm/one.mcap", "/dev/shm/two.mcap"];
    in_process(&[&SHORT[..], &["--record", one]].concat());
    in_two_processes(&[&SHORT[..], &["--record", two]].concat());
    let [one, two] = [one, two].map(recorded);
    assert!(one.len() > 10_000, "{}", one.len());
    assert_eq!(one.len(), two.len());
    for (one, two) in one.iter().zip(&two) {
        assert!(one == two, "{} at {} ns, {} at {} ns", one.0, one.1, two.0, two.1);
    }
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_controller_whose_one_constant_differs_is_found_out_by_its_digest() {
    let world = world(&[&SHORT[..], &["--quiet", "--summary", "-"]].concat());
    let _controller = Process::start(env!("CARGO_BIN_EXE_broken-controller"), &[BUS]);
    let (status, lines) = world.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    let broken: Value = serde_json::from_str(&lines.concat()).unwrap();
    assert_eq!(broken["outcome"], "transported", "a micrometre is not felt");
    assert_ne!(broken["digest"], short_digest(), "but seen");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn in_real_time_the_job_reports_its_round_trips_and_what_it_missed() {
    let (summary, ran) = tactus_tests::program::summary(
        tactus_tests::program::Profile::Release,
        &[&["run", "--quiet", "--bus", BUS, "--pace", "realtime"], &SHORT[..]].concat(),
    );
    // On a shared machine ticks may be missed; then the job may fail, but with a reason.
    println!(
        "real time: {}, round trips {} us, {} deadline misses, busiest 100 ms {}",
        summary["outcome"], summary["round_trip_us"], summary["deadline_misses"], summary["bus"]["load_max"]
    );
    assert!(matches!(ran.status, 0 | 3 | 4), "{}", ran.stderr);
    let sim_time_s = summary["sim_time_s"].as_f64().unwrap();
    let wall_time_s = summary["wall_time_s"].as_f64().unwrap();
    assert!(wall_time_s >= sim_time_s * 0.98, "by the clock: {wall_time_s} s for {sim_time_s} s");
    assert!(summary["deadline_misses"].is_u64() && summary["bus"]["load_max"].is_number());
    let [min, median, p99, max] = ["min", "median", "p99", "max"].map(|name| {
        summary["round_trip_us"][name].as_f64().unwrap_or_else(|| panic!("round_trip_us.{name}: {summary:#}"))
    });
    assert!(0.0 < min && min <= median && median <= p99 && p99 <= max, "{summary:#}");
}
