//! The long repeats on a real bus, by seed: `cargo xtask soak`. The seed decides the world and all that happens to the bus.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::time::Duration;
use tactus_tests::can_bench::{
    Ear, INTERFACE, MISSION, in_process, in_two_processes, ready_controller, set_link, world,
};
use tactus_tests::process::Process;

/// The variables that `cargo xtask soak` sets.
const SEED: &str = "TACTUS_SOAK_SEED";
const COUNT: &str = "TACTUS_SOAK_COUNT";
/// A mission lasts about so many ticks.
const TICKS: u32 = 15_000;

fn variable(name: &str) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// A mission in two processes with `trouble` at a moment of the seed's choice ends with this digest.
fn survives(what: &str, seed: &str, digest: &str, random: &mut Pcg32, trouble: impl FnOnce(&mut Process, &mut Pcg32)) {
    let mut controller = ready_controller(&[]);
    let mut ear = Ear::open();
    let world = world(&["--seed", seed, "--summary", "-"]);
    let tick = random.next_u32() % TICKS;
    ear.wait_for_tick(tick, MISSION);
    trouble(&mut controller, random);
    let (status, lines) = world.end(MISSION * 2);
    assert_eq!(status.code(), Some(0), "{what} at tick {tick}: {lines:?}");
    assert!(lines.iter().any(|line| line.contains(digest)), "{what} at tick {tick}: not {digest}: {lines:?}");
}

fn repeat(seed: u64) {
    let mut random = Pcg32::seed_from_u64(seed);
    let seed = seed.to_string();
    let reference = in_process(&["--seed", &seed]);
    let digest = reference["digest"].as_str().expect("a digest");
    for format in ["fd", "classic"] {
        let summary = in_two_processes(&["--seed", &seed, "--can", format]);
        assert_eq!(summary["digest"], digest, "{format}");
    }
    survives("interface down", &seed, digest, &mut random, |_, random| {
        set_link("down");
        std::thread::sleep(Duration::from_millis(u64::from(random.next_u32() % 800)));
        set_link("up");
    });
    survives("controller frozen", &seed, digest, &mut random, |controller, random| {
        controller.signal("STOP");
        std::thread::sleep(Duration::from_millis(u64::from(random.next_u32() % 1_000)));
        controller.signal("CONT");
    });
    let mut floods = Vec::new();
    survives("flood", &seed, digest, &mut random, |_, random| {
        let gap_ms = (random.next_u32() % 10 + 1).to_string();
        let args = [INTERFACE, "-g", &gap_ms, "-m", "-e", "-I", "r", "-L", "r", "-D", "r", "-i"];
        floods.push(Process::start("cangen", &args));
    });
    drop(floods);
    let mut next = None;
    survives("controller killed", &seed, digest, &mut random, |controller, _| {
        controller.kill();
        next = Some(ready_controller(&[]));
    });
}

#[test]
#[ignore = "long: cargo xtask soak runs it"]
fn whatever_the_seed_does_to_the_bus_the_digest_is_that_of_one_process() {
    let first = variable(SEED);
    for seed in first..first + variable(COUNT) {
        println!("seed {seed}");
        if let Err(panic) = std::panic::catch_unwind(|| repeat(seed)) {
            println!("failed; replay: cargo xtask soak --seed {seed} --count 1");
            std::panic::resume_unwind(panic);
        }
    }
}
