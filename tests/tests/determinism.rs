//! Promise: a run is a pure function of scenario and seed. Same digest on repeated runs, in debug and release, and with
//! any number of jobs.

use tactus_tests::program::{Profile, run, run_in, summary};

fn digest(profile: Profile, seed: &str) -> String {
    let (summary, ran) = summary(profile, &["run", "--seed", seed]);
    println!("{profile:?}, seed {seed}: {} {}", summary["digest"], summary["outcome"]);
    assert!([0, 3].contains(&ran.status), "{}", ran.stderr);
    summary["digest"].as_str().expect("a digest").to_owned()
}

#[test]
fn the_same_seed_gives_the_same_digest_again_and_another_seed_another() {
    let first = digest(Profile::Release, "1");
    assert_eq!(first, digest(Profile::Release, "1"));
    assert_ne!(first, digest(Profile::Release, "2"));
}

#[test]
fn debug_and_release_give_the_same_digest() {
    assert_eq!(digest(Profile::Debug, "5"), digest(Profile::Release, "5"));
}

#[test]
fn trials_do_not_depend_on_the_number_of_jobs_nor_on_the_build() {
    let table = |profile, jobs: &str, name: &str| {
        let file = format!("{}/determinism_{name}.csv", env!("CARGO_TARGET_TMPDIR"));
        let args = ["trials", "--count", "3", "--seed", "40", "--jobs", jobs, "--csv", &file, "--quiet"];
        let ran = run_in(profile, &args);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        without_wall_time(&file)
    };
    let one = table(Profile::Release, "1", "one");
    assert_eq!(one.len(), 4, "a heading and three missions");
    assert_eq!(one, table(Profile::Release, "2", "two"));
}

/// The lines of a CSV without the columns that tell wall time.
fn without_wall_time(file: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(file).expect("a CSV");
    let heading: Vec<String> = reader.headers().expect("a heading").iter().map(str::to_owned).collect();
    let keep: Vec<usize> = (0..heading.len())
        .filter(|i| !heading[*i].contains("wall_time") && !heading[*i].contains("update_time"))
        .collect();
    assert_eq!(keep.len() + 1, heading.len(), "one column tells wall time: {heading:?}");
    let mut lines = vec![heading];
    lines.extend(reader.records().map(|r| r.expect("a line").iter().map(str::to_owned).collect()));
    lines.iter().map(|line| keep.iter().map(|i| line[*i].clone()).collect()).collect()
}

#[test]
fn a_mission_of_a_batch_is_the_mission_that_run_carries_out() {
    let file = format!("{}/determinism_batch.csv", env!("CARGO_TARGET_TMPDIR"));
    let ran = run(&["trials", "--count", "1", "--seed", "41", "--csv", &file, "--quiet"]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let mut reader = csv::Reader::from_path(&file).unwrap();
    let heading = reader.headers().unwrap().clone();
    let line = reader.records().next().unwrap().unwrap();
    let value = |name: &str| line[heading.iter().position(|h| h == name).unwrap()].to_owned();
    let pose = |kind: &str| ["x_m", "y_m", "phi_rad"].map(|part| value(&format!("{kind}_{part}"))).join(",");
    let (summary, _) =
        summary(Profile::Release, &["run", "--seed", "41", "--true", &pose("true"), "--guess", &pose("guess")]);
    assert_eq!(summary["digest"], value("digest").as_str(), "poses {} and {}", pose("true"), pose("guess"));
    assert_eq!(summary["outcome"], value("outcome").as_str());
}
