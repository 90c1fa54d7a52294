use super::*;

const THESIS_BOX: &str = built_in::ALL[0].text;

fn refusal(text: &str) -> String {
    let message = format!("{:#}", Scenario::parse(text, Path::new("")).expect_err(text));
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

#[test]
fn the_built_in_scenes_are_sound_and_say_what_they_are() {
    for scene in built_in::ALL {
        let read = Scenario::load(Path::new(scene.name)).map_err(|e| format!("{}: {e:#}", scene.name)).unwrap();
        assert!(!read.summary.is_empty(), "{}", scene.name);
    }
    assert_eq!(Scenario::thesis_box().shape(), ObjectShape::THESIS_BOX);
    assert_eq!(Scenario::thesis_box().trials, Region::default());
}

#[test]
fn the_built_in_mesh_is_a_hexagon_across_flats() {
    let ObjectShape::Convex(hull) = Scenario::load(Path::new("hexagonal-prism")).unwrap().shape() else {
        panic!("a convex solid")
    };
    assert_eq!((hull.corners_m().len(), hull.faces().count()), (12, 8));
    let [x, _, z] = hull.half_extents_m();
    assert!((x - 0.05).abs() < 1e-5 && (z - 0.075).abs() < 1e-5);
}

#[test]
fn size_alone_is_a_box_and_everything_but_the_object_has_a_default() {
    let scene = Scenario::parse(
        "[object]\nsize_m = [0.1, 0.06, 0.2]\nmass_kg = 0.5\ntrue_pose = [0.2, -0.1, 0.3]\n",
        Path::new(""),
    )
    .unwrap();
    assert_eq!(scene.shape(), ObjectShape::Cuboid { half_extents_m: [0.05, 0.03, 0.1] });
    assert_eq!(scene.table.size_m, Scenario::thesis_box().table.size_m);
    assert_eq!(scene.displacement_m, [-0.5, 0.0]);
    assert_eq!((scene.noise, scene.mismatch), (NoiseScales::ONE, MismatchScales::ONE));
}

#[test]
fn a_bad_scene_is_refused_by_field_and_line() {
    for (from, to, expected) in [
        (
            "mass_kg = 0.6",
            "mass_kg = -1",
            "line 14, column 11: object.mass_kg: -1: expected a finite number above zero",
        ),
        ("mass_kg = 0.6", "mass_kg = nan", "object.mass_kg: NaN"),
        ("mass_kg = 0.6", "mass_kg = \"heavy\"", "line 14, column 11: "),
        ("mass_kg = 0.6", "mass = 0.6", "unknown field `mass`"),
        ("true_pose = [0.2,", "true_pose = [2.0,", "off the table"),
        ("true_pose = [0.2,", "true_pose = [inf,", "object.true_pose: inf"),
        ("size_m = [0.2, 0.1, 0.2]", "size_m = [0.6, 0.4, 0.9]", "object.true_pose: `object` and `"),
        ("size_m = [0.2, 0.1, 0.2]", "size_m = [0.2, 0.1, 2.0]", "object.size_m: 2: "),
        ("size_m = [0.2, 0.1, 0.2]", "shape.ball = { radius_m = 0.05 }", "unknown variant `ball`"),
        ("size_m = [0.2, 0.1, 0.2]", "shape.sphere = { radius_m = -0.05 }", "object.shape.sphere.radius_m: -0.05"),
        ("size_m = [0.2, 0.1, 0.2]", "shape.sphere = { radius = 0.05 }", "unexpected keys in table: radius"),
        (
            "size_m = [0.2, 0.1, 0.2]",
            "shape.capsule = { radius_m = 0.05, length_m = 0.1 }",
            "object.shape.capsule.length_m: 0.1: expected more than twice the radius, 0.1 m",
        ),
        ("size_m = [0.2, 0.1, 0.2]", "", "object: no shape"),
        ("[object]", "[object]\nshape.sphere = { radius_m = 0.05 }", "object.size_m: given beside shape"),
        ("[table]", "robot_base_pose = [0, nan, 0]\n[table]", "robot_base_pose: NaN: expected a finite number"),
        ("[object]", "[noise]\ntactile = -1\n[object]", "noise.tactile: -1: expected a finite number, from 0 to 10"),
        ("[object]", "[mismatch]\nsize = 3\n[object]", "mismatch.size: 3"),
        ("[object]", "[trials]\nx_m = [0.2, 0.1]\n[object]", "trials.x_m: [0.2, 0.1]"),
        ("[object]", "[trials]\ny_m = [0.0, 0.4]\n[object]", "trials.y_m: 0,0.4,0: off the table"),
        (
            "[object]",
            "[[objects]]\nsize_m = [0.1, 0.1, 0.1]\nmass_kg = 0\npose = [0, 0, 0]\n[object]",
            "objects[0].mass_kg: 0",
        ),
        (
            "[object]",
            "[[obstacles]]\nsize_m = [0.1, 0.1, 0.1]\npose = [0.2, -0.1, 0]\n[object]",
            "obstacles[0].pose: `",
        ),
        (
            "[object]",
            "[[obstacles]]\nsize_m = [0.1, 0.1, 0.1]\npose = [0, 1, 0]\n[object]",
            "obstacles[0].pose: 0,1,0: off",
        ),
    ] {
        let text = THESIS_BOX.replace(from, to);
        assert_ne!(text, THESIS_BOX, "{from}");
        let message = refusal(&text);
        assert!(message.contains(expected), "{message}");
        assert!(message.starts_with("line "), "{message}");
    }
}

#[test]
fn more_bodies_than_the_controller_can_be_told_of_are_refused() {
    let obstacle = |x: usize| format!("[[obstacles]]\nsize_m = [0.05, 0.05, 0.05]\npose = [-0.{x}, 0.2, 0]\n");
    let scene = |count: usize| THESIS_BOX.to_owned() + &(1..=count).map(obstacle).collect::<String>();
    assert!(Scenario::parse(&scene(OBSTACLES_MAX), Path::new("")).is_ok());
    assert!(refusal(&scene(OBSTACLES_MAX + 1)).contains("obstacles[4]: 5 objects and obstacles; expected at most 4"));
}

#[test]
fn a_mesh_is_meant_from_the_scenes_folder_and_refused_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let tetrahedron = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 30 30 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::fs::write(folder.path().join("a.obj"), tetrahedron).unwrap();
    let file = folder.path().join("scene.toml");
    let load = |mesh: &str| {
        let shape = format!("shape.mesh = {{ {mesh} }}");
        std::fs::write(&file, THESIS_BOX.replace("size_m = [0.2, 0.1, 0.2]", &shape)).unwrap();
        Scenario::load(&file).map_err(|e| format!("{e:#}"))
    };
    assert!(matches!(load("file = \"a.obj\", scale = 0.001").unwrap().shape(), ObjectShape::Convex(_)));
    let told = load("file = \"a.obj\"").unwrap_err();
    assert!(told.contains("object.shape.mesh.file: a.obj: ") && told.contains("scale?"), "{told}");
    assert!(load("file = \"b.obj\"").unwrap_err().contains("b.obj: No such file"));
    assert!(load("file = \"a.obj\", scale = -1").unwrap_err().contains("object.shape.mesh.scale: -1"));
}

#[test]
fn a_scene_file_of_noise_is_refused_before_it_is_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("noise.toml");
    let noise: Vec<u8> = (0..10_000_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 11) as u8).collect();
    std::fs::write(&file, noise).unwrap();
    assert_eq!(format!("{:#}", Scenario::load(&file).unwrap_err()), "larger than 256 KiB, the most that is read");
    let unknown = format!("{:#}", Scenario::load(Path::new("no-such-scene")).unwrap_err());
    assert!(unknown.contains("No such file") && unknown.contains("thesis-box"), "{unknown}");
}
