//! Promise: a recording is the run: a reader that shares no code with ours finds it in the file, recording changes nothing, and
//! what was cut off is read up to the cut.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tactus_tests::program::{self, Profile, run};

/// Time limit for a few seconds of a run in real time.
const LIMIT: Duration = Duration::from_secs(60);

/// A run without a recording and one with it.
struct Runs {
    /// Summary of the run without.
    plain: Value,
    /// Summary of the run with.
    recorded: Value,
    /// The recording.
    file: PathBuf,
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("paths of tests are text")
}

/// The main job, once for all tests.
fn runs() -> &'static Runs {
    static RUNS: OnceLock<Runs> = OnceLock::new();
    RUNS.get_or_init(|| {
        let file = path("recording.mcap");
        let job = ["run", "--seed", "1"];
        let (plain, _) = program::summary(Profile::Release, &job);
        let (recorded, ran) = program::summary(Profile::Release, &[&job[..], &["--record", text(&file)]].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        Runs { plain, recorded, file }
    })
}

/// What the MCAP library for Python finds in a recording.
fn independently_read(recording: &Path) -> Value {
    // `cargo xtask setup` makes this environment.
    let python = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../python/bin/python");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("recording/read.py");
    let output = Command::new(&python)
        .args([&script, recording])
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}; `cargo xtask setup` makes it", python.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

/// `tactus info`, which succeeds.
fn info(recording: &Path) -> String {
    let ran = run(&["info", text(recording)]);
    assert_eq!((ran.status, ran.stderr.as_str()), (0, ""), "{}", recording.display());
    ran.stdout
}

fn count(found: &Value, topic: &str) -> u64 {
    found["counts"][topic].as_u64().unwrap_or(0)
}

#[test]
fn recording_changes_neither_the_digest_nor_the_ticks_nor_where_the_object_ends() {
    let Runs { plain, recorded, .. } = runs();
    for name in ["digest", "digest_ticks", "final_object_pose", "trials", "evaluations", "outcome"] {
        assert_eq!(plain[name], recorded[name], "{name}");
    }
    assert_eq!(plain["outcome"], "transported");
}

#[test]
fn an_independent_reader_finds_the_same_run() {
    let Runs { plain, file, .. } = runs();
    let found = independently_read(file);
    assert_eq!(found["whole"], true);
    let counted: u64 = found["counts"].as_object().unwrap().values().filter_map(Value::as_u64).sum();
    assert_eq!(found["indexed_messages"], counted, "the index at the end counts what is there");
    assert_eq!(found["empty_chunks"], 0, "older readers refuse a chunk without messages");

    let end = &found["last"]["/controller/end"];
    assert_eq!((&end["digest"], &end["digest_ticks"]), (&plain["digest"], &plain["digest_ticks"]));
    assert_eq!(end["outcome"], "Transported");
    assert_eq!(found["metadata"]["tactus.result"]["digest"], plain["digest"]);
    assert_eq!(found["metadata"]["tactus.run"]["seed"], "1");
    for name in ["outcome", "digest", "final_object_pose", "believed_pose", "goal_pose", "method", "trials"] {
        assert_eq!(found["attachments"]["summary.json"][name], plain[name], "{name}");
    }
    assert_eq!(found["attachments"]["settings.json"]["seed"], 1);

    // The last picture is at most ten ticks old, and the object has been at rest for long.
    let (truth, last) = (&plain["final_object_pose"], &found["last"]["/truth/object"]);
    for (of_summary, of_recording) in [("x", "x_m"), ("y", "y_m"), ("z", "z_m"), ("phi", "phi_rad")] {
        let difference = truth[of_summary].as_f64().unwrap() - last[of_recording].as_f64().unwrap();
        assert!(difference.abs() < 1e-5, "{of_summary}: {difference}");
    }
    let [in_tf, in_numbers] = [&found["last"]["/tf"]["object"][0], &last["x_m"]].map(|x| x.as_f64().unwrap());
    assert!((in_tf - in_numbers).abs() < 1e-6, "{in_tf} {in_numbers}");

    assert_eq!(count(&found, "/controller/touch"), plain["trials"].as_u64().unwrap());
    let phases: Vec<&str> =
        found["all"]["/controller/phase"].as_array().unwrap().iter().filter_map(|p| p["phase"].as_str()).collect();
    assert_eq!(phases.first(), Some(&"Plan"));
    assert_eq!(phases[phases.len() - 4..], ["Grasp", "Transport", "Release", "Done"]);
    let trials = phases.iter().filter(|phase| **phase == "Trial").count() as u64;
    assert_eq!(trials, plain["trials"].as_u64().unwrap());
    assert!(!found["all"]["/controller/contact"].as_array().unwrap().is_empty());
    assert!(found["all"]["/log"].as_array().unwrap().iter().any(|line| line == "Transported"));
}

#[test]
fn a_recording_shows_the_robot_by_itself_and_holds_every_tick() {
    let Runs { plain, file, .. } = runs();
    let found = independently_read(file);
    let frames: Vec<&str> = found["frames"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let entities = found["entities"].as_object().unwrap();
    assert_eq!(frames.len(), 20, "17 links, table, object, believed object: {frames:?}");
    for frame in &frames {
        let shown = entities.values().any(|entity| entity[0] == *frame && entity[1].as_u64() > Some(0));
        assert!(shown, "{frame} has no shape");
        assert!(found["points"][frame].as_u64() > Some(50), "{frame} has no points");
    }
    let ticks = (plain["sim_time_s"].as_f64().unwrap() * 500.0).round() as u64;
    for (topic, every) in [("/sensors/joints", 1), ("/controller/command", 1), ("/tf", 10), ("/joint_states", 10)] {
        // The tick after the last step is seen too.
        assert_eq!(count(&found, topic), ticks / every + 1, "{topic}");
    }
    assert!(count(&found, "/sensors/tactile").abs_diff(ticks / 3) <= 1);
    let listed = info(file);
    for topic in found["topics"].as_array().unwrap().iter().filter_map(Value::as_str) {
        let line = listed.lines().find(|line| line.split_whitespace().nth(1) == Some(topic)).expect(topic);
        assert_eq!(line.split_whitespace().next(), Some(count(&found, topic).to_string().as_str()), "{line}");
    }
    for word in ["whole", "seed 1", "transported", plain["digest"].as_str().unwrap(), "Transport"] {
        assert!(listed.contains(word), "{word}: {listed}");
    }
}

#[test]
fn a_recording_cut_anywhere_is_readable_up_to_a_second_before_the_cut() {
    let bytes = std::fs::read(&runs().file).unwrap();
    let mut before_s = -1.0;
    for (part, whole_parts) in [(1, 100), (1, 10), (1, 3), (1, 2), (9, 10), (99, 100)] {
        let cut = path(&format!("cut_{part}_{whole_parts}.mcap"));
        std::fs::write(&cut, &bytes[..bytes.len() * part / whole_parts]).unwrap();
        let found = independently_read(&cut);
        assert_eq!(found["whole"], false);
        let listed = info(&cut);
        assert!(listed.contains("cut off") && listed.contains("seed 1"), "{listed}");
        let joints = listed.lines().find(|line| line.contains("/sensors/joints ")).map(|line| line.split_whitespace());
        let ours = joints.and_then(|mut words| words.next()).and_then(|word| word.parse().ok()).unwrap_or(0);
        assert_eq!(ours, count(&found, "/sensors/joints"), "both readers come to the same place");
        let last_s = found["last_time_s"].as_f64().unwrap();
        assert!(last_s >= before_s, "{last_s} s after {before_s} s");
        before_s = last_s;
    }
    assert!(before_s > 34.0, "{before_s} s of 35.8 s");
}

#[test]
fn a_run_that_is_killed_leaves_all_but_its_last_second() {
    let file = path("killed.mcap");
    // An earlier run's would be long enough at once.
    let _ = std::fs::remove_file(&file);
    let mut run = Command::new(program::path(Profile::Release))
        .args(["run", "--seed", "1", "--quiet", "--pace", "realtime", "--record", text(&file)])
        .stdout(Stdio::null())
        .spawn()
        .expect("the command starts");
    let started = Instant::now();
    // Two seconds of a run and more.
    while std::fs::metadata(&file).map_or(0, |file| file.len()) < 300_000 {
        assert!(started.elapsed() < LIMIT && run.try_wait().unwrap().is_none(), "it is being recorded");
        std::thread::sleep(Duration::from_millis(50));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    let found = independently_read(&file);
    assert_eq!(found["whole"], false);
    // In real time a tick does not come before its time; on a busy machine it may come much later.
    let (last_s, ran_s) = (found["last_time_s"].as_f64().unwrap(), started.elapsed().as_secs_f64());
    assert!(last_s >= 1.0 && last_s <= ran_s, "{last_s} s of {ran_s} s");
    assert_eq!(count(&found, "/sensors/joints"), (last_s * 500.0).round() as u64 + 1, "whole seconds, every tick");
    assert!(info(&file).contains("no outcome"));
}

#[test]
fn its_numbers_come_out_as_tables_with_units() {
    let Runs { plain, file, .. } = runs();
    let folder = path("recording_tables");
    let ran = run(&["export", text(file), "--csv", text(&folder)]);
    assert_eq!((ran.status, ran.stderr.as_str()), (0, ""));
    let table = |name: &str| {
        let mut reader = csv::Reader::from_path(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        (names, rows)
    };
    let found = independently_read(file);
    for (name, topic, column) in [
        ("sensors_joints.csv", "/sensors/joints", "arm_q_rad_7"),
        ("controller_command.csv", "/controller/command", "arm_tau_nm_1"),
        ("controller_status.csv", "/controller/status", "covariance_phiphi_rad2"),
        ("sensors_tactile.csv", "/sensors/tactile", "pressure_n_cm2_24"),
        ("controller_contact.csv", "/controller/contact", "inner_rad"),
        ("truth_object.csv", "/truth/object", "x_m"),
    ] {
        let (names, rows) = table(name);
        assert_eq!(names[..2], ["time_s", "tick"], "{name}");
        assert!(names.iter().any(|n| n == column), "{name}: {names:?}");
        assert_eq!(rows.len() as u64, count(&found, topic), "{name}");
    }
    let (names, rows) = table("truth_object.csv");
    let x = names.iter().position(|name| name == "x_m").unwrap();
    let last_x_m: f64 = rows.last().unwrap()[x].parse().unwrap();
    assert!((last_x_m - plain["final_object_pose"]["x"].as_f64().unwrap()).abs() < 1e-5);
}

#[test]
fn what_is_no_recording_or_cannot_be_written_is_refused_in_one_line() {
    let scene = path("no_recording.toml");
    std::fs::write(&scene, "name = \"none\"\n").unwrap();
    let refused = |args: &[&str], words: &[&str]| {
        let ran = run(args);
        assert_eq!((ran.status, ran.stdout.as_str()), (2, ""), "{args:?}: {}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{args:?}: {}", ran.stderr);
        words.iter().for_each(|word| assert!(ran.stderr.contains(word), "{args:?}: {}", ran.stderr));
    };
    refused(&["info", text(&scene)], &["no_recording.toml", "expected an MCAP file"]);
    refused(&["info", "/no/such/file.mcap"], &["/no/such/file.mcap", "No such file"]);
    refused(&["info", env!("CARGO_TARGET_TMPDIR")], &["directory"]);
    refused(&["export", text(&scene), "--csv", env!("CARGO_TARGET_TMPDIR")], &["expected an MCAP file"]);
    refused(&["export", text(&runs().file), "--csv", text(&scene)], &["no_recording.toml"]);
    refused(&["run", "--record", "/no/such/folder/run.mcap"], &["--record /no/such/folder/run.mcap", "No such file"]);
}
