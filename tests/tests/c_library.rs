//! Promise: C and C++ programs can be built against the static library as docs/library.md says, see the structs that
//! Rust sees, and get what Rust gets, to the bit.

use std::mem::{offset_of, size_of};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tactus::controller::*;
use tactus::estimator::*;
use tactus::event::TactusEvent;
use tactus::geometry::*;
use tactus::plan::*;
use tactus::result::TactusResult;
use tactus::robot::*;
use tactus::rollout::*;
use tactus::setup::*;
use tactus_common::limits::OBSTACLES_MAX;
use tactus_common::message::{SCHEMA_VERSION, Setup};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{JointReadings, Validity};
use tactus_common::shape::ObjectShape;
use tactus_controller::controller::{Controller, Inputs};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// What a command prints, in the repository's root and with its `target/`, whatever this test was started with.
fn run(command: &mut Command) -> String {
    let shown = format!("{command:?}");
    let output = command
        .current_dir(root())
        .env_remove("CARGO_TARGET_DIR")
        .output()
        .unwrap_or_else(|error| panic!("{shown}: {error} (Debian's package gcc brings cc, g++ brings c++)"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{shown}: {}\n{stderr}", output.status);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The output of the lines that docs/library.md tells people to type; they build the library on the way.
fn as_the_page_says() -> &'static str {
    static PRINTED: OnceLock<String> = OnceLock::new();
    PRINTED.get_or_init(|| {
        let page = std::fs::read_to_string(root().join("docs/library.md")).expect("docs/library.md is there");
        let (_, block) = page.split_once("```sh\n").expect("the page has commands");
        let (lines, _) = block.split_once("```").expect("the block ends");
        run(Command::new("sh").args(["-e", "-c", lines]))
    })
}

/// Compiles a file of the library's folder as strictly as compilers can, and runs it.
fn compile_and_run(compiler: &str, language: &[&str], source: &str) -> String {
    as_the_page_says();
    let name = source.rsplit('/').next().expect("a name").replace('.', "_");
    let program = format!("target/{name}_{compiler}");
    let strict = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-I", "firmware/library/include"];
    let source = format!("firmware/library/{source}");
    let link = ["-x", "none", "target/library/libtactus.a", "-o", &program];
    run(Command::new(compiler).args(language).args(strict).arg(source).args(link));
    run(&mut Command::new(root().join(&program)))
}

/// The numbers of a line that starts with `what`.
fn numbers<'a>(printed: &'a str, what: &'a str) -> impl Iterator<Item = f32> + use<'a> {
    let words = printed.lines().filter(move |line| line.starts_with(what)).flat_map(str::split_whitespace);
    words.filter_map(|word| word.trim_end_matches(',').parse().ok())
}

#[test]
fn one_tick_in_c_commands_the_torques_and_believes_what_one_tick_in_rust_does() {
    let printed = as_the_page_says();
    let joints: Vec<f32> =
        (1..=7).flat_map(|j| numbers(printed, ["J1", "J2", "J3", "J4", "J5", "J6", "J7"][j - 1])).collect();
    let (arm_q_rad, tau_nm): (Vec<_>, Vec<_>) = joints.chunks(2).map(|pair| (pair[0], pair[1])).unzip();
    let setup = Setup {
        schema_version: SCHEMA_VERSION.to_le_bytes(),
        shape: ObjectShape::Cuboid { half_extents_m: [0.1, 0.05, 0.1] },
        guess: PlanarPose::new(0.21, -0.108, 0.0),
        interval: Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 },
        obstacles: [None; OBSTACLES_MAX],
        displacement_m: [-0.5, 0.0],
        mass_kg: 0.6,
        trials_max: 12,
        robot_base: tactus_common::robot::MOUNT,
        method: Method::default(),
    };
    let readings = JointReadings {
        tick: 0,
        arm_q_rad: arm_q_rad.try_into().expect("seven joints"),
        motor_q_rad: [0.0; 4],
        inner_q_rad: [0.0; 3],
        effort_nm: [0.0; 4],
        tip_torque_nm: [0.0; 3],
        valid: Validity::ALL,
    };
    let mut controller = Controller::default();
    let said = controller.tick(0, &Inputs { setup: Some(&setup), readings: Some(readings), ..Inputs::default() });
    assert_eq!(tau_nm, said.commands.arm_tau_nm, "to the bit: nine digits hold a float");
    assert!(tau_nm[1] < -10.0, "the shoulder bears the arm");
    let belief = controller.mission().belief().expect("a mission has begun");
    let pose: Vec<f32> = numbers(printed, "belief").collect();
    assert_eq!(pose, belief.pose().to_array());
    let covariance: Vec<f32> = numbers(printed, "covariance").collect();
    assert_eq!(covariance, belief.covariance().as_slice());
    // The library holds the default method's optimiser alone, these tests all of them.
    let (_, takes) = printed.split_once("a controller takes ").expect("its size");
    let (takes, rest) = takes.split_once(' ').expect("a number");
    let takes: usize = takes.parse().expect("a number");
    assert!((30_000..=tactus_controller_size()).contains(&takes), "{takes} of {} bytes", tactus_controller_size());
    assert!(rest.starts_with(&format!("of {TACTUS_CONTROLLER_SIZE} bytes")), "{printed}");
}

#[test]
fn three_touches_given_from_c_find_the_box() {
    let printed = as_the_page_says();
    let last: Vec<f32> = numbers(printed, "touch 3:").collect();
    let [x_m, y_m, phi_rad] = [last[0], last[1], last[2]];
    assert!((x_m - 0.22).abs() < 1e-3 && (y_m + 0.08).abs() < 1e-3 && (phi_rad - 0.15).abs() < 0.01, "{printed}");
    assert!(printed.contains("ready to grasp"), "{printed}");
}

#[test]
fn c_and_cpp_compile_the_header_without_a_warning_and_do_the_same() {
    for example in ["one_tick", "fit_touches"] {
        let source = format!("examples/{example}.c");
        let c = compile_and_run("cc", &["-std=c11"], &source);
        let cpp = compile_and_run("c++", &["-std=c++11", "-x", "c++"], &source);
        assert_eq!(c, cpp);
        assert!(as_the_page_says().contains(&c), "{example} as the page builds it");
    }
}

#[test]
fn c_sees_the_structs_that_rust_sees() {
    let mut expected = String::new();
    macro_rules! size {
        ($($type:ty),*) => { $(expected += &format!("{} {}\n", stringify!($type), size_of::<$type>());)* };
    }
    macro_rules! field {
        ($type:ty, $($field:ident),*) => {
            $(expected += &format!("{}.{} {}\n", stringify!($type), stringify!($field), offset_of!($type, $field));)*
        };
    }
    size!(TactusResult, TactusPhase, TactusPose, TactusInterval, TactusShape, TactusTransform, TactusBelief);
    field!(TactusBelief, covariance, readiness, collisions);
    size!(TactusMode, TactusReadings);
    field!(TactusReadings, tip_torque_nm, valid);
    size!(TactusImage);
    field!(TactusImage, pad);
    size!(TactusHandCommand, TactusCommands, TactusHand);
    field!(TactusHand, spread_rad);
    size!(TactusSetup);
    field!(TactusSetup, trials_max);
    size!(TactusOutcome, TactusPlanRequest);
    field!(TactusPlanRequest, touch);
    size!(TactusKnot, TactusPlanAnswer);
    field!(TactusPlanAnswer, refusal);
    size!(TactusRolloutRequest, TactusRollout);
    field!(TactusRollout, request);
    size!(TactusEvent);
    field!(TactusEvent, belief);
    size!(TactusInputs);
    field!(TactusInputs, image_count);
    size!(TactusOutputs);
    field!(TactusOutputs, event_count, outcome);
    size!(TactusPrior, TactusControllerMemory, TactusEstimatorMemory);
    assert_eq!(compile_and_run("cc", &["-std=c11"], "tests/layout.c"), expected);
}

#[test]
fn the_library_has_no_allocator_and_needs_nothing_but_memory_functions_and_the_panic_hook() {
    as_the_page_says();
    let symbols = run(Command::new("nm").args(["--no-sort", "target/library/libtactus.a"]));
    assert!(!symbols.contains("__rust_alloc") && !symbols.contains("malloc"), "an allocator");
    let header = std::fs::read_to_string(root().join("firmware/library/include/tactus.h")).expect("the header");
    let mut exported = 0;
    for line in symbols.lines() {
        if let Some((_, name)) = line.split_once(" T tactus_") {
            exported += 1;
            assert!(header.contains(&format!("tactus_{name}(")), "tactus_{name} is not in the header");
        }
    }
    assert_eq!(exported, header.matches("\nTactusResult tactus_").count() + 4, "the header declares what is not there");
    // The archive also holds the compiler's own runtime, which answers itself; only the first object is ours.
    let ours = symbols.split(".o:\n").find(|object| object.contains(" T tactus_controller_tick")).expect("our object");
    let needs: Vec<&str> = ours.lines().filter_map(|line| line.trim_start().strip_prefix("U ")).collect();
    for need in &needs {
        assert!(["memcpy", "memmove", "memset", "memcmp", "bcmp", "tactus_panic"].contains(need), "needs {need}");
    }
    assert!(!needs.is_empty(), "the compiler's runtime copies memory");
}
