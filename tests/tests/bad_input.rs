//! Promise: bad input ends with exit status 2 (or 3, where only the attempt shows that the task cannot be done) and one
//! line on standard error that says what, where and what was expected. No panic, no backtrace, nothing else.

use tactus_tests::program::{Ran, run};

const SCENE: &str = include_str!("../../sim-host/scenarios/thesis_box.toml");
const URDF: &str = include_str!("../../common/models/wam7_bh280.urdf");

/// Runs with `--quiet`; exactly one clear line with all of `words`.
fn refused(args: &[&str], status: i32, words: &[&str]) -> Ran {
    let ran = run(&[args, &["--quiet"]].concat());
    print!("{} -> {}  {}", args.join(" "), ran.status, ran.stderr);
    assert_eq!(ran.status, status, "{args:?}: {}", ran.stderr);
    one_clear_line(&ran, args);
    for word in words {
        assert!(ran.stderr.contains(word), "{args:?} does not name {word}: {}", ran.stderr);
    }
    ran
}

fn one_clear_line(ran: &Ran, args: &[&str]) {
    assert_eq!(ran.stderr.lines().count(), 1, "{args:?}: {}", ran.stderr);
    assert!(ran.stderr.ends_with('\n') && ran.stderr.len() > 20, "{args:?}: {}", ran.stderr);
    assert_eq!(ran.stdout, "", "{args:?}");
    for word in ["panicked", "backtrace", "RUST_BACKTRACE", "unwrap", "src/"] {
        assert!(!ran.stderr.contains(word), "{args:?}: {}", ran.stderr);
    }
}

/// A file with this text.
fn file(name: &str, text: &str) -> String {
    let path = format!("{}/bad_input_{name}", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, text).expect("the directory of temporary files can be written");
    path
}

#[test]
fn poses_off_the_table_are_refused_by_name_and_extent() {
    refused(&["run", "--guess", "2.0,0,0"], 2, &["--guess", "off the table", "expected x within"]);
    refused(&["run", "--guess", "0,-0.4,0"], 2, &["--guess", "off the table"]);
    refused(&["run", "--true", "-1,0,0"], 2, &["--true", "off the table"]);
    // The flags mean `run` without its name, too.
    refused(&["--guess", "2.0,0,0"], 2, &["--guess", "off the table"]);
}

#[test]
fn numbers_that_are_none_are_refused() {
    refused(&["run", "--guess", "nan,0,0"], 2, &["--guess", "'nan'", "finite"]);
    refused(&["run", "--true", "0,NaN,0"], 2, &["--true", "'NaN'", "finite"]);
    refused(&["run", "--guess", "inf,0,0"], 2, &["--guess", "'inf'", "finite"]);
    refused(&["run", "--guess", "0,0,-infinity"], 2, &["--guess", "finite"]);
    refused(&["run", "--guess", "1e50,0,0"], 2, &["--guess", "finite"]);
    refused(&["run", "--interval", "nan,0,0"], 2, &["--interval", "finite"]);
    refused(&["trials", "--offset", "inf,0,0"], 2, &["--offset", "finite"]);
}

#[test]
fn malformed_triples_are_refused() {
    refused(&["run", "--guess", "1,2"], 2, &["--guess", "three numbers", "found 2"]);
    refused(&["run", "--guess", "1,2,3,4"], 2, &["--guess", "three numbers", "found 4"]);
    refused(&["run", "--guess", ""], 2, &["--guess"]);
    refused(&["run", "--guess", "a,b,c"], 2, &["--guess", "'a' is not a number"]);
    refused(&["run", "--true", "0.2;-0.1;0"], 2, &["--true", "three numbers"]);
    refused(&["run", "--interval=-0.1,0,0"], 2, &["negative"]);
    refused(&["trials", "--offset=0.1,-0.1,0"], 2, &["negative"]);
}

#[test]
fn unknown_flags_commands_and_values_are_refused() {
    refused(&["run", "--frobnicate"], 2, &["--frobnicate"]);
    refused(&["frobnicate"], 2, &["frobnicate"]);
    refused(&["run", "--seed", "x"], 2, &["--seed", "'x'"]);
    refused(&["run", "--seed", "99999999999999999999"], 2, &["--seed"]);
    refused(&["run", "--dof", "4"], 2, &["--dof", "1..=3"]);
    refused(&["run", "--max-trials", "0"], 2, &["--max-trials"]);
    refused(&["run", "--optimizer", "magic"], 2, &["--optimizer", "magic", "expected"]);
    refused(&["run", "--error", "magic"], 2, &["--error", "magic"]);
    refused(&["run", "--sensors", "magic"], 2, &["--sensors", "magic"]);
    refused(&["trials", "--count", "0"], 2, &["--count"]);
    refused(&["trials", "--jobs", "0"], 2, &["--jobs"]);
    refused(&["trials", "--guess", "0,0,0"], 2, &["--guess"]);
}

#[test]
fn a_method_that_cannot_work_is_refused_by_name() {
    for error in ["contact", "weighted", "modified"] {
        refused(&["run", "--error", error], 2, &["--error", error, "needs --sensors ideal"]);
    }
    refused(&["trials", "--error", "modified"], 2, &["--error modified", "needs --sensors ideal"]);
    refused(&["run", "--optimizer", "magic"], 2, &["levenberg-marquardt", "cma-es", "direct"]);
    refused(&["run", "--predictor", "magic"], 2, &["--predictor", "magic", "simulation"]);
    refused(&["run", "--gradient", "magic"], 2, &["--gradient", "magic", "two-sided"]);
    refused(&["run", "--damping", "0"], 2, &["--damping 0", "above zero"]);
    refused(&["run", "--damping", "nan"], 2, &["--damping", "finite"]);
    refused(&["run", "--instants", "17"], 2, &["--instants", "1..=16"]);
    refused(&["run", "--evaluations", "65536"], 2, &["--evaluations"]);
}

#[test]
fn buses_that_are_not_there_are_refused() {
    refused(&["run", "--bus", "socketcan:nosuch0"], 2, &["--bus socketcan:nosuch0"]);
    refused(&["run", "--bus", "magic"], 2, &["'magic'", "expected", "virtual"]);
    refused(&["trials", "--bus", "socketcan:nosuch0"], 2, &["--bus"]);
}

#[test]
fn a_box_out_of_reach_is_a_failure_with_its_reason() {
    refused(&["run", "--true", "0.85,0.28,0", "--guess", "0.85,0.28,0"], 3, &["OutOfReach"]);
}

#[test]
fn damaged_scene_files_are_refused_by_file_and_place() {
    refused(
        &["run", "--scenario", "/nonexistent/scene.toml"],
        2,
        &["--scenario /nonexistent/scene.toml", "No such file"],
    );
    refused(&["run", "--scenario", "/"], 2, &["--scenario /"]);
    for (name, from, to, words) in [
        ("cut.toml", "size_m = [0.2, 0.1, 0.2]", "size_m = [0.2, 0.1", &["line "][..]),
        ("type.toml", "mass_kg = 0.6", "mass_kg = \"heavy\"", &["line "]),
        ("negative.toml", "mass_kg = 0.6", "mass_kg = -0.6", &["object.mass_kg", "above zero"]),
        ("nan.toml", "friction = 0.8", "friction = nan", &["object.friction", "finite"]),
        ("unknown.toml", "mass_kg = 0.6", "mass_kilograms = 0.6", &["mass_kilograms"]),
        ("off.toml", "true_pose = [0.2, -0.1, 0.0]", "true_pose = [0.2, 3.0, 0.0]", &["off the table"]),
        ("missing.toml", "true_pose = [0.2, -0.1, 0.0]", "", &["true_pose"]),
    ] {
        let text = SCENE.replace(from, to);
        assert_ne!(text, SCENE, "{name}: the shipped scene holds `{from}`");
        let path = file(name, &text);
        refused(&["run", "--scenario", &path], 2, &[&[path.as_str()], words].concat());
    }
    let binary = format!("{}/bad_input_binary.toml", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&binary, [0xff, 0xfe, 0, 1]).unwrap();
    refused(&["run", "--scenario", &binary], 2, &[&binary]);
    let empty = file("empty.toml", "");
    refused(&["trials", "--scenario", &empty], 2, &[&empty]);
}

/// Ten megabytes that are no text.
fn noise() -> Vec<u8> {
    (0..10_000_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 11) as u8).collect()
}

#[test]
fn damaged_meshes_are_refused_by_file_line_and_field() {
    // A cube whose top is dented along its diagonal.
    let dent = "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nv 0 0 0.1\nv 0.1 0 0.1\nv 0.1 0.1 0.1\nv 0 0.1 0.07\n\
                f 4 3 2 1\nf 6 7 8\nf 6 8 5\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let field = "line 13, column 23: object.shape.mesh.file";
    for (name, mesh, bytes, what) in [
        ("mesh_noise.toml", "noise.obj", &noise()[..], "larger than 1024 KiB"),
        ("mesh_less_noise.toml", "less_noise.stl", &noise()[..500_000], "not an STL file"),
        ("mesh_dent.toml", "dent.obj", dent.as_bytes(), "not convex: the corner"),
        ("mesh_open.toml", "open.obj", dent.replace("f 4 3 2 1\n", "").as_bytes(), "not a closed surface"),
        ("mesh_nan.toml", "nan.obj", dent.replace("v 0.1 0 0\n", "v nan 0 0\n").as_bytes(), "finite"),
        ("mesh_empty.toml", "empty.stl", b"", "STL"),
        ("mesh_format.toml", "mesh.ply", dent.as_bytes(), ".obj or .stl"),
    ] {
        std::fs::write(format!("{}/{mesh}", env!("CARGO_TARGET_TMPDIR")), bytes).unwrap();
        let shape = format!("shape.mesh = {{ file = \"{mesh}\" }}");
        let path = file(name, &SCENE.replace("size_m = [0.2, 0.1, 0.2]", &shape));
        refused(&["run", "--scenario", &path], 2, &[&path, field, mesh, what]);
    }
    let nowhere = SCENE.replace("size_m = [0.2, 0.1, 0.2]", "shape.mesh = { file = \"nowhere.obj\" }");
    let path = file("mesh_nowhere.toml", &nowhere);
    refused(&["run", "--scenario", &path], 2, &[&path, field, "nowhere.obj", "No such file"]);
}

#[test]
fn bodies_in_one_another_off_the_table_or_in_the_robot_are_refused_by_line_and_field() {
    for (name, from, to, words) in [
        (
            "within.toml",
            "[object]",
            "[[obstacles]]\nsize_m = [0.1, 0.1, 0.1]\npose = [0.25, -0.1, 0]\n[object]",
            &["line 14, column 8", "obstacles[0].pose", "`object` and `obstacles[0]` overlap", "mm"][..],
        ),
        (
            "in_the_hand.toml",
            "[object]",
            "[[objects]]\nsize_m = [0.1, 0.1, 0.6]\nmass_kg = 1\npose = [-0.05, 0.02, 0]\n[object]",
            &["line 15, column 8", "objects[0].pose", "overlap"],
        ),
        (
            "off_the_table.toml",
            "[object]",
            "[[obstacles]]\nsize_m = [0.1, 0.1, 0.1]\npose = [0, 0.5, 0]\n[object]",
            &["line 14, column 8", "obstacles[0].pose", "off the table"],
        ),
        ("shape.toml", "size_m = [0.2, 0.1, 0.2]", "shape.cone = { radius_m = 0.1 }", &["line 13", "cone", "cylinder"]),
        (
            "base.toml",
            "[table]",
            "robot_base_pose = [0.2, -0.2, 0]\n[table]",
            &["line 7, column 19", "robot_base_pose", "overlap", "mm"],
        ),
    ] {
        let text = SCENE.replacen(from, to, 1);
        assert_ne!(text, SCENE, "{name}");
        let path = file(name, &text);
        refused(&["trials", "--scenario", &path], 2, &[&[path.as_str()], words].concat());
    }
}

#[test]
fn noise_for_a_scene_and_unknown_names_are_refused() {
    let path = format!("{}/bad_input_noise.toml", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, noise()).unwrap();
    refused(&["run", "--scenario", &path], 2, &[&path, "larger than 256 KiB"]);
    refused(&["run", "--scenario", "no-such-scene"], 2, &["--scenario no-such-scene", "No such file", "thesis-box"]);
    let checked = run(&["check", &file("check.toml", "object = 3\n")]);
    one_clear_line(&checked, &["check"]);
    assert!(checked.status == 2 && checked.stderr.contains("line 1, column 10"), "{checked:?}");
    let shown = run(&["scenes", "--show", "magic"]);
    one_clear_line(&shown, &["scenes"]);
    assert!(shown.status == 2 && shown.stderr.contains("hexagonal-prism"), "{shown:?}");
}

#[test]
fn built_in_scenes_are_listed_shown_and_checked() {
    let list = run(&["scenes"]);
    assert_eq!((list.status, list.stderr.as_str()), (0, ""));
    assert!(list.stdout.lines().count() >= 6, "{}", list.stdout);
    for line in list.stdout.lines() {
        let name = line.split_whitespace().next().expect("a name");
        let path = file(&format!("{name}.toml"), &run(&["scenes", "--show", name]).stdout);
        for scene in [name, &path] {
            let checked = run(&["check", scene]);
            assert_eq!((checked.status, checked.stderr.as_str()), (0, ""), "{scene}");
            assert!(checked.stdout.contains("  object  "), "{}", checked.stdout);
        }
    }
    assert_eq!(run(&["scenes", "--show", "thesis-box"]).stdout, SCENE);
}

#[test]
fn a_reader_that_goes_away_ends_nothing_but_the_text() {
    for args in [&["--help"][..], &["scenes"], &["scenes", "--schema"], &["run", "--help"]] {
        let mut child =
            std::process::Command::new(tactus_tests::program::path(tactus_tests::program::Profile::Release))
                .args(args)
                .stdout(std::process::Stdio::piped())
                .stderr(std::process::Stdio::piped())
                .spawn()
                .expect("the command runs");
        drop(child.stdout.take());
        let ended = child.wait_with_output().expect("the command ends");
        assert_eq!((ended.status.code(), String::from_utf8_lossy(&ended.stderr).as_ref()), (Some(0), ""), "{args:?}");
    }
}

#[test]
fn damaged_robot_descriptions_are_refused_by_file() {
    let scene = |name: &str, urdf: &str| {
        file(&format!("{name}.toml"), &SCENE.replacen("name =", &format!("robot_urdf = \"{urdf}\"\nname ="), 1))
    };
    let nowhere = scene("nowhere", "/nonexistent/robot.urdf");
    refused(&["run", "--scenario", &nowhere], 2, &["/nonexistent/robot.urdf"]);
    for (name, text) in [
        ("cut", URDF[..URDF.len() / 2].to_owned()),
        ("empty", String::new()),
        ("not_xml", "not a robot".to_owned()),
        ("other_joint", URDF.replace("wam_joint4", "wam_joint9")),
        ("mass_nan", URDF.replacen("<mass value=\"", "<mass value=\"nan", 1)),
        ("mass_negative", URDF.replacen("<mass value=\"", "<mass value=\"-", 1)),
        ("no_limits", URDF.replace("<limit", "<limits")),
    ] {
        assert_ne!(text, URDF, "{name}");
        let urdf = file(&format!("{name}.urdf"), &text);
        let path = scene(name, &urdf);
        refused(&["run", "--scenario", &path], 2, &[&urdf]);
    }
}

#[test]
fn a_box_inside_the_robot_is_refused_with_what_overlaps() {
    let text = SCENE.replace("size_m = [0.2, 0.1, 0.2]", "size_m = [0.6, 0.6, 0.9]");
    assert_ne!(text, SCENE);
    let tower = file("tower.toml", &text);
    refused(&["run", "--scenario", &tower, "--true", "0,-0.3,0", "--guess", "0,-0.3,0"], 2, &["overlap", "mm"]);
}

#[test]
fn help_and_version_are_no_errors() {
    for args in [&["--help"][..], &["run", "--help"], &["trials", "--help"], &["--version"]] {
        let ran = run(args);
        assert_eq!((ran.status, ran.stderr.as_str()), (0, ""), "{args:?}");
        assert!(!ran.stdout.is_empty());
    }
    let help = run(&["trials", "--help"]).stdout;
    assert!(help.contains("pi/4") && help.contains("[0.0, 0.3]"), "the true poses' distribution is stated: {help}");
}
