//! Promise: `tactus trials` carries out a batch and reports it: a CSV line for each mission, one line of statistics, exit
//! status 0 whatever the outcomes. (That results do not depend on `--jobs` is in `determinism.rs`.)

use serde_json::Value;
use std::f32::consts::FRAC_PI_4;
use tactus_tests::program::run;

/// Columns that the command line's contract names: seed, true, guess, believed, errors, trials, outcome, wall time.
const COLUMNS: [&str; 15] = [
    "seed",
    "true_x_m",
    "true_y_m",
    "true_phi_rad",
    "guess_x_m",
    "guess_y_m",
    "guess_phi_rad",
    "believed_x_m",
    "believed_y_m",
    "believed_phi_rad",
    "position_error_m",
    "yaw_error_rad",
    "trials",
    "outcome",
    "wall_time_s",
];

#[test]
fn a_batch_writes_a_line_for_each_mission_and_a_line_of_statistics() {
    let dir = env!("CARGO_TARGET_TMPDIR");
    let (table, json) = (format!("{dir}/trials.csv"), format!("{dir}/trials.json"));
    let offset = [0.03_f32, 0.02, 0.2];
    let args =
        ["trials", "--count", "4", "--seed", "100", "--offset", "0.03,0.02,0.2", "--csv", &table, "--summary", &json];
    let ran = run(&args);
    assert_eq!(ran.status, 0, "{}", ran.stderr);

    let mut reader = csv::Reader::from_path(&table).unwrap();
    let heading = reader.headers().unwrap().clone();
    for column in COLUMNS {
        assert!(heading.iter().any(|h| h == column), "column {column} in {heading:?}");
    }
    let records: Vec<csv::StringRecord> = reader.records().map(|r| r.unwrap()).collect();
    assert_eq!(records.len(), 4);
    let text = |line: usize, name: &str| records[line][heading.iter().position(|h| h == name).unwrap()].to_owned();
    let number = |line: usize, name: &str| -> f32 { text(line, name).parse().unwrap_or_else(|_| panic!("{name}")) };
    let mut transported = 0;
    for line in 0..4 {
        assert_eq!(text(line, "seed"), (100 + line).to_string(), "in order of seed");
        assert!((0.0..=0.3).contains(&number(line, "true_x_m")));
        assert!((-0.2..=0.0).contains(&number(line, "true_y_m")));
        assert!(number(line, "true_phi_rad").abs() <= FRAC_PI_4);
        for (part, half_width) in ["x_m", "y_m", "phi_rad"].iter().zip(offset) {
            let off = number(line, &format!("guess_{part}")) - number(line, &format!("true_{part}"));
            assert!(off.abs() <= half_width + 1e-6, "guess {part} off by {off}");
        }
        assert!((0..=8).contains(&(number(line, "trials") as i32)));
        assert!(number(line, "wall_time_s") > 0.0);
        transported += u32::from(text(line, "outcome") == "transported");
    }
    let poses: std::collections::BTreeSet<String> = (0..4).map(|line| text(line, "true_x_m")).collect();
    assert_eq!(poses.len(), 4, "each mission has its own true pose");

    println!("{}", ran.stdout);
    let first = ran.stdout.lines().next().unwrap();
    assert!(first.starts_with("4 missions: ") && first.contains("% transported"), "{first}");
    let statistics: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!(statistics["missions"], 4);
    let share = statistics["transported_share"].as_f64().unwrap();
    assert!((share - f64::from(transported) / 4.0).abs() < 1e-9, "{statistics:#}");
    assert!(transported >= 3, "easy offsets: {transported} of 4 transported");
}

#[test]
fn a_batch_of_failures_exits_0_and_says_so() {
    // The object stands where the arm cannot reach over it.
    let file = format!("{}/far_away.toml", env!("CARGO_TARGET_TMPDIR"));
    let scene = include_str!("../../sim-host/scenarios/thesis_box.toml")
        .replace("displacement_m = [-0.5, 0.0]", "displacement_m = [-0.5, 1.2]");
    assert!(scene.contains("1.2"), "the shipped scene names its displacement");
    std::fs::write(&file, scene).unwrap();
    let ran = run(&["trials", "--count", "2", "--seed", "7", "--scenario", &file]);
    assert_eq!(ran.status, 0, "{}{}", ran.stdout, ran.stderr);
    println!("{}", ran.stdout);
    assert!(ran.stdout.starts_with("2 missions: 0.0 % transported"), "{}", ran.stdout);
    assert!(ran.stdout.contains("2 x no plan"), "failures by cause: {}", ran.stdout);
}

#[test]
fn a_table_that_cannot_be_written_is_refused_before_the_work() {
    let begun = std::time::Instant::now();
    let ran = run(&["trials", "--count", "1000000", "--csv", "/nonexistent/table.csv", "--quiet"]);
    assert_eq!(ran.status, 2);
    assert!(ran.stderr.contains("--csv /nonexistent/table.csv"), "{}", ran.stderr);
    assert!(begun.elapsed().as_secs() < 60);
}
