//! Promise: every built-in scene is a job that can be done, and a scene of one's own may have the robot stand elsewhere.

use tactus_tests::program::{Profile, run, summary};

/// How near its goal an object must stand, metres.
const GOAL_POSITION_M: f64 = 0.015;

#[test]
fn the_object_of_every_built_in_scene_is_carried_to_its_goal() {
    let listed = run(&["scenes"]).stdout;
    let names: Vec<_> = listed.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 7, "{listed}");
    std::thread::scope(|scope| {
        for share in names.chunks(names.len().div_ceil(2)) {
            scope.spawn(move || share.iter().for_each(|name| carried(&["run", "--scenario", name])));
        }
    });
}

#[test]
fn a_robot_at_the_other_side_of_the_table_carries_round_an_obstacle_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("other_side.toml");
    // Nearly half a turn about the table's middle: nothing is where it is in the built-in scenes.
    let scene = "displacement_m = [0.4, 0.05]\nrobot_base_pose = [0.05, 0.6, -1.5]\n\
                 [object]\nsize_m = [0.2, 0.1, 0.2]\nmass_kg = 0.6\ntrue_pose = [-0.2, 0.1, 0.3]\n\
                 [[obstacles]]\nsize_m = [0.1, 0.1, 0.12]\npose = [-0.02, 0.02, 0.2]\n";
    std::fs::write(&file, scene).expect("a file in it");
    carried(&["run", "--scenario", file.to_str().expect("a plain name")]);
}

/// The mission ends transported, by the verdict and by where the object stands.
fn carried(args: &[&str]) {
    let (result, ran) = summary(Profile::Release, args);
    let off_m = result["goal_position_error_m"].as_f64();
    assert_eq!((ran.status, result["outcome"].as_str()), (0, Some("transported")), "{args:?}: {}", ran.stderr);
    assert!(off_m.is_some_and(|off_m| off_m <= GOAL_POSITION_M), "{args:?}: {off_m:?} m off");
}
