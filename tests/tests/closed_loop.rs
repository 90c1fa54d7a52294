//! Promise: `tactus` finds the box by touch and carries it to its goal, and says so in a summary that tools can rely on.

use serde_json::Value;
use tactus_tests::program::{Profile, run, summary};

/// How near its goal the box must stand.
const GOAL_POSITION_M: f64 = 0.015;
const GOAL_YAW_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// The displacement of the main job.
const DISPLACEMENT_M: [f64; 2] = [-0.5, 0.0];

/// A number of the summary, by path.
fn number(summary: &Value, path: &str) -> f64 {
    summary.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} is a number in {summary:#}"))
}

/// Yaw difference modulo the box's half-turn symmetry.
fn yaw_between(a: f64, b: f64) -> f64 {
    let half_turns = ((a - b) / std::f64::consts::PI).round();
    (a - b - half_turns * std::f64::consts::PI).abs()
}

/// The box stands at its goal by the summary's poses, not by its verdict.
fn stands_at_its_goal(summary: &Value) {
    let [x, y] = ["x", "y"].map(|axis| {
        let moved =
            number(summary, &format!("/final_object_pose/{axis}")) - number(summary, &format!("/true_pose/{axis}"));
        moved - DISPLACEMENT_M[usize::from(axis == "y")]
    });
    let off_m = (x * x + y * y).sqrt();
    let yaw = yaw_between(number(summary, "/final_object_pose/phi"), number(summary, "/true_pose/phi"));
    println!(
        "seed {}: {:.1} mm, {:.2} deg off; belief {:.2} mm, {:.2} deg off after {} touches",
        number(summary, "/seed"),
        off_m * 1e3,
        yaw.to_degrees(),
        number(summary, "/position_error_m") * 1e3,
        number(summary, "/yaw_error_rad").to_degrees(),
        number(summary, "/trials")
    );
    assert!(off_m <= GOAL_POSITION_M, "{off_m} m off");
    assert!(yaw <= GOAL_YAW_RAD, "{yaw} rad off");
    assert!((number(summary, "/final_object_pose/z") - 0.1).abs() < 0.003, "it stands on the table");
}

fn transported(summary: &Value) {
    assert_eq!(summary["outcome"], "transported");
    stands_at_its_goal(summary);
    // By touch, not by luck: the belief is far better than the guess.
    assert!(number(summary, "/position_error_m") < 0.01, "{summary:#}");
    assert!(number(summary, "/trials") >= 1.0 && number(summary, "/evaluations") >= 1.0);
}

#[test]
fn the_main_job_ends_transported_and_its_summary_holds_what_the_contract_names() {
    let file = format!("{}/closed_loop_summary.json", env!("CARGO_TARGET_TMPDIR"));
    let ran = run(&["--summary", &file]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert!(ran.stdout.contains("transported"), "a closing summary for people: {}", ran.stdout);
    let summary: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    println!("{summary:#}");
    transported(&summary);

    assert!(summary["outcome"].is_string());
    assert_eq!(summary["seed"].as_u64(), Some(1));
    let digest = summary["digest"].as_str().unwrap();
    assert!(digest.len() == 16 && digest.bytes().all(|b| b.is_ascii_hexdigit()), "{digest}");
    for pose in ["true_pose", "guess", "believed_pose", "final_object_pose", "goal_pose"] {
        for part in ["x", "y", "z", "phi"] {
            assert!(number(&summary, &format!("/{pose}/{part}")).is_finite());
        }
    }
    for key in ["position_error_m", "yaw_error_rad", "update_time_s", "sim_time_s", "wall_time_s"] {
        assert!(number(&summary, &format!("/{key}")) >= 0.0, "{key}");
    }
    for key in ["/trials", "/evaluations", "/deadline_misses", "/bus/frames"] {
        assert!(summary.pointer(key).is_some_and(Value::is_u64), "{key} is a count");
    }
    assert_eq!(summary["deadline_misses"], 0, "in lockstep none is missed");
    let load = number(&summary, "/bus/load_max");
    assert!(load > 0.05 && load <= 0.8, "a share of the bus: {load}");
    // The goal is the true pose plus the displacement.
    assert!((number(&summary, "/goal_pose/x") - number(&summary, "/true_pose/x") + 0.5).abs() < 1e-6);
    assert!((number(&summary, "/goal_pose/y") - number(&summary, "/true_pose/y")).abs() < 1e-6);
    // Two frames a tick at least.
    assert!(number(&summary, "/bus/frames") > 2.0 * 500.0 * (number(&summary, "/sim_time_s") - 1.0));
}

#[test]
fn other_seeds_end_transported_with_other_digests() {
    let mut digests = Vec::new();
    for seed in ["2", "3", "4"] {
        let (summary, ran) = summary(Profile::Release, &["run", "--seed", seed]);
        assert_eq!(ran.status, 0, "seed {seed}: {}", ran.stderr);
        assert_eq!(summary["seed"].to_string(), seed);
        transported(&summary);
        digests.push(summary["digest"].as_str().unwrap().to_owned());
    }
    digests.sort();
    digests.dedup();
    assert_eq!(digests.len(), 3);
}

#[test]
fn a_box_told_in_words_is_found_where_it_stands() {
    let args = ["run", "--seed", "7", "--true", "0.1,-0.15,0.4", "--guess", "0.13,-0.13,0.2"];
    let (summary, ran) = summary(Profile::Release, &args);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert!(
        (number(&summary, "/guess/x") - 0.13).abs() < 1e-6 && (number(&summary, "/true_pose/phi") - 0.4).abs() < 1e-6
    );
    transported(&summary);
}

/// A mission by another method, twice: the same both times, and as the summary says.
fn by_method(args: &[&str]) -> (Value, i32) {
    let args = [&["run"], args].concat();
    let [(first, ran), (second, _)] = [0, 1].map(|_| summary(Profile::Release, &args));
    assert!(first["digest"].is_string(), "{args:?} ends: {}", ran.stderr);
    assert_eq!(first["digest"], second["digest"], "{args:?} twice");
    println!(
        "{args:?}: {}, {} touches, {} evaluations, {:.1} mm off",
        first["outcome"],
        first["trials"],
        first["evaluations"],
        number(&first, "/position_error_m") * 1e3
    );
    assert!(number(&first, "/evaluations") >= 1.0);
    (first, ran.status)
}

#[test]
fn the_published_method_comes_to_an_end_that_its_exit_status_tells() {
    // A weak criterion: it may carry the box although the belief is 20 mm off along the faces, or fail; both are ends.
    let published = ["--sensors", "ideal", "--error", "modified", "--optimizer", "steepest-descent-golden"];
    for predictor in ["kinematic", "simulation"] {
        let (summary, status) = by_method(&[&published[..], &["--predictor", predictor, "--max-trials", "3"]].concat());
        let outcome = summary["outcome"].as_str().expect("a text");
        assert_eq!(status, if outcome == "transported" { 0 } else { 3 }, "{outcome}");
        assert!(
            ["transported", "misplaced", "toppled", "NotConfident", "GraspMissed", "ObjectLost"].contains(&outcome),
            "{outcome}"
        );
        for (key, value) in
            [("error", "modified"), ("optimizer", published[5]), ("predictor", predictor), ("sensors", "ideal")]
        {
            assert_eq!(summary["method"][key], value);
        }
    }
}

#[test]
fn another_optimiser_finds_the_box_by_the_geometric_error() {
    let (summary, status) = by_method(&["--optimizer", "cma-es"]);
    assert_eq!((status, &summary["method"]["optimizer"]), (0, &Value::from("cma-es")));
    transported(&summary);
}

#[test]
fn ideal_sensors_change_nothing_for_our_own_method() {
    let [real, ideal] = ["real", "ideal"].map(|sensors| summary(Profile::Release, &["run", "--sensors", sensors]).0);
    for key in ["trials", "evaluations", "digest_ticks", "believed_pose", "final_object_pose"] {
        assert_eq!(real[key], ideal[key], "{key}");
    }
    assert_ne!(real["digest"], ideal["digest"], "what the controller hears is hashed");
}

#[test]
fn a_summary_on_standard_output_has_nothing_beside_it() {
    let (summary, ran) = summary(Profile::Release, &["--seed", "1"]);
    assert!(summary.is_object());
    assert!(ran.stdout.trim_start().starts_with('{') && ran.stdout.trim_end().ends_with('}'));
}
