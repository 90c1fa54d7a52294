//! Promises of the experiments: their columns, that results depend neither on `--jobs` nor on an interruption, and that
//! the two methods do on a small grid what they do on the large one.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tactus_tests::program::{self, Profile, run};

/// Columns that the contract fixes.
const CONVERGE: &str = "x,y,phi,class,final_error,location_error_m,yaw_error_rad,evaluations,time_s,stop_reason";

fn file(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    for left_over in [path.clone(), partial(&path)] {
        let _ = std::fs::remove_file(left_over);
    }
    path
}

fn partial(path: &Path) -> PathBuf {
    PathBuf::from(format!("{}.partial", path.display()))
}

/// The lines of a table without wall times, which no two runs share.
fn untimed(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let time = reader.headers().expect("a table").iter().position(|h| h == "time_s").expect("a column of times");
    let line = |record: csv::StringRecord| {
        record.iter().enumerate().filter(|(i, _)| *i != time).map(|(_, value)| value.to_owned()).collect()
    };
    reader.records().map(|record| line(record.expect("a table"))).collect()
}

fn column(path: &Path, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let at = reader.headers().expect("a table").iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}"));
    reader.records().map(|record| record.expect("a table")[at].to_owned()).collect()
}

const OURS: [&str; 8] = ["converge", "--quiet", "--x", "0.12,0.28,0.08", "--y", "-0.14,-0.06,0.08", "--seed", "5"];
const PUBLISHED: [&str; 10] = [
    "converge",
    "--quiet",
    "--error",
    "modified",
    "--reality",
    "nominal",
    "--x",
    "0.18,0.22,0.02",
    "--y",
    "-0.11,-0.09,0.01",
];

fn converge(args: &[&str], csv: &Path, jobs: &str) {
    let ran = run(&[args, &["--csv", csv.to_str().expect("a path in UTF-8"), "--jobs", jobs]].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert_eq!(std::fs::read_to_string(csv).expect("a table").lines().next(), Some(CONVERGE));
    assert!(!partial(csv).exists(), "no journal is left behind");
}

#[test]
fn ours_finds_the_box_from_every_start_whatever_the_number_of_jobs_and_although_interrupted() {
    let (whole, broken) = (file("converge_whole.csv"), file("converge_broken.csv"));
    converge(&OURS, &whole, "2");
    let (classes, errors_m) = (column(&whole, "class"), column(&whole, "location_error_m"));
    assert_eq!(classes, ["converged"; 6]);
    assert!(errors_m.iter().all(|e| e.parse::<f32>().unwrap() < 3e-3), "{errors_m:?}");

    let mut child = Command::new(program::path(Profile::Release))
        .args(OURS)
        .args(["--jobs", "1", "--csv"])
        .arg(&broken)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let lines = || std::fs::read_to_string(partial(&broken)).map_or(0, |text| text.lines().count());
    // The settings and at least one start.
    while lines() < 2 {
        assert!(begun.elapsed() < Duration::from_secs(60), "no start was carried out");
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = lines();
    assert!((2..7).contains(&kept), "interrupted in the middle: {kept} lines");
    converge(&OURS, &broken, "1");
    assert_eq!(untimed(&whole), untimed(&broken));
}

#[test]
fn a_journal_of_other_settings_is_refused_by_name() {
    let csv = file("converge_other.csv");
    std::fs::write(partial(&csv), "{\"experiment\":\"converge\",\"settings\":{\"seed\":99}}\n").unwrap();
    let ran = run(&[&OURS[..], &["--csv", csv.to_str().unwrap()]].concat());
    assert_eq!(ran.status, 2);
    assert!(ran.stderr.contains("converge_other.csv.partial: begun with other settings"), "{}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
}

#[test]
fn the_published_method_stays_where_the_readings_agree_and_comes_nearer_from_close_by() {
    let csv = file("converge_published.csv");
    converge(&PUBLISHED, &csv, "2");
    let errors: Vec<f32> = column(&csv, "final_error").iter().map(|e| e.parse().unwrap()).collect();
    let (classes, evaluations) = (column(&csv, "class"), column(&csv, "evaluations"));
    // The middle of the grid is the truth: nothing differs there.
    assert_eq!((errors[4], evaluations[4].as_str(), classes[4].as_str()), (0.0, "1", "converged"));
    for (error, class) in errors.iter().zip(&classes) {
        assert_eq!(*error < 1.0, class == "converged", "E < 1 is the published criterion: {error} {class}");
    }
}

#[test]
fn every_method_is_given_the_same_problems_and_keeps_to_its_budget() {
    let csv = file("compare.csv");
    let ran = run(&[
        "compare",
        "--quiet",
        "--count",
        "1",
        "--dof",
        "2",
        "--budget",
        "30,100",
        "--error",
        "geometric",
        "--csv",
        csv.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let (optimizers, budgets, evaluations) =
        (column(&csv, "optimizer"), column(&csv, "budget"), column(&csv, "evaluations"));
    assert_eq!(optimizers.len(), 22, "11 optimisers at 2 budgets: {optimizers:?}");
    for ((optimizer, budget), evaluations) in optimizers.iter().zip(&budgets).zip(&evaluations) {
        let (budget, evaluations): (u32, u32) = (budget.parse().unwrap(), evaluations.parse().unwrap());
        assert!((1..=budget).contains(&evaluations), "{optimizer}: {evaluations} of {budget}");
    }
}
