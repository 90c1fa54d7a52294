//! What every shape's separation from a prism promises, against the definition: the largest gap over all directions.

use super::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

extern crate std;
use std::vec::Vec as List;

/// About a fingertip: eight corners.
pub(super) const TIP: Prism = Prism::new(
    &[
        [-0.0095, -0.0095],
        [0.02, -0.0095],
        [0.055, -0.0045],
        [0.0575, 0.0],
        [0.0545, 0.0065],
        [0.045, 0.009],
        [0.03, 0.0095],
        [-0.0095, 0.0095],
    ],
    [-0.0115, 0.0115],
);

fn regular(n: u8, radius_m: f32, half_height_m: f32) -> ObjectShape {
    ObjectShape::Convex(Hull::regular_prism(n, radius_m, half_height_m).unwrap())
}

fn box_hull([a, b, c]: [f32; 3]) -> ObjectShape {
    let side = |i: u8, bit: u8, half: f32| if i >> bit & 1 == 1 { half } else { -half };
    let corners: List<_> = (0..8).map(|i| [side(i, 0, a), side(i, 1, b), side(i, 2, c)]).collect();
    let faces: [&[u8]; 6] = [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];
    ObjectShape::Convex(Hull::new(&corners, faces).unwrap())
}

fn wedge() -> ObjectShape {
    let corners = [[-0.05, -0.04, -0.04], [0.07, -0.03, -0.04], [-0.02, 0.06, -0.04], [0.0, -0.003, 0.06]];
    ObjectShape::Convex(Hull::new(&corners, [&[0_u8, 2, 1][..], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]]).unwrap())
}

fn shapes() -> List<ObjectShape> {
    std::vec![
        ObjectShape::THESIS_BOX,
        ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.08 },
        ObjectShape::Cylinder { radius_m: 0.07, half_height_m: 0.02 },
        ObjectShape::Sphere { radius_m: 0.05 },
        ObjectShape::Capsule { radius_m: 0.03, half_length_m: 0.06 },
        regular(6, 0.0577, 0.075),
        regular(12, 0.05, 0.03),
        wedge(),
    ]
}

fn any_shape() -> impl Strategy<Value = ObjectShape> {
    proptest::sample::select(shapes())
}

fn pose(t: [f32; 3], axis_angle: [f32; 3]) -> Isometry3<f32> {
    Isometry3::from_parts(Translation3::new(t[0], t[1], t[2]), UnitQuaternion::new(Vector3::from(axis_angle)))
}

fn any_pose() -> impl Strategy<Value = Isometry3<f32>> {
    ([-0.12_f32..0.12, -0.12_f32..0.12, -0.15_f32..0.15], [-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0])
        .prop_map(|(t, r)| pose(t, r))
}

/// World-from-link of the link as seen from an object at `(x, y, phi)`.
fn seen_from(object: [f32; 3], world_from_link: &Isometry3<f32>) -> Isometry3<f32> {
    pose([object[0], object[1], 0.0], [0.0, 0.0, object[2]]).inverse() * world_from_link
}

/// How far a shape reaches along a direction, by its definition.
fn reach(shape: &ObjectShape, n: &Vector3<f64>) -> f64 {
    let level = n.x.hypot(n.y);
    match shape {
        ObjectShape::Cuboid { half_extents_m } => (0..3).map(|i| n[i].abs() * f64::from(half_extents_m[i])).sum(),
        ObjectShape::Cylinder { radius_m, half_height_m } => {
            level * f64::from(*radius_m) + n.z.abs() * f64::from(*half_height_m)
        }
        ObjectShape::Sphere { radius_m } => f64::from(*radius_m),
        ObjectShape::Capsule { radius_m, half_length_m } => {
            f64::from(*radius_m) + n.x.abs() * f64::from(*half_length_m)
        }
        ObjectShape::Convex(hull) => {
            hull.corners_m().iter().map(|c| n.dot(&Vector3::from(c.map(f64::from)))).fold(f64::MIN, f64::max)
        }
    }
}

/// The largest gap over all directions: the distance if the bodies are apart, minus the least translation that parts them
/// otherwise. Directions all over the sphere, the best of them climbed from.
fn largest_gap_m(shape: &ObjectShape, object_from_link: &Isometry3<f32>, prism: &Prism) -> f64 {
    let mut corners = List::new();
    for [x, y] in prism.corners_m {
        for z in prism.z_m {
            let corner = object_from_link * nalgebra::Point3::new(*x, *y, z);
            corners.push(corner.coords.map(f64::from));
        }
    }
    let gap = |n: &Vector3<f64>| corners.iter().map(|c| n.dot(c)).fold(f64::MAX, f64::min) - reach(shape, n);
    let golden = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let count = 700;
    let mut tried: List<(f64, Vector3<f64>)> = (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (level, turn) = ((1.0 - z * z).sqrt(), golden * f64::from(i));
            let n = Vector3::new(level * libm::cos(turn), level * libm::sin(turn), z);
            (gap(&n), n)
        })
        .collect();
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best = f64::MIN;
    for (mut value, mut n) in tried.into_iter().take(12) {
        let mut step = 0.08;
        while step > 1e-7 {
            let across = if n.z.abs() < 0.9 { n.cross(&Vector3::z()) } else { n.cross(&Vector3::x()) }.normalize();
            let other = n.cross(&across);
            let mut moved = false;
            for i in 0..12 {
                let (s, c) = libm::sincos(f64::from(i) * core::f64::consts::TAU / 12.0 + step * 1e3);
                let next = (n + (across * c + other * s) * step).normalize();
                let there = gap(&next);
                if there > value {
                    (value, n, moved) = (there, next, true);
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        best = best.max(value);
    }
    best
}

fn separation(shape: &ObjectShape, object_from_link: &Isometry3<f32>) -> Separation {
    shape.separation(object_from_link, &TIP).expect("finite pose")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 160, ..ProptestConfig::default() })]

    #[test]
    fn inside_it_is_the_penetration_and_outside_never_more_than_the_distance(shape in any_shape(), link in any_pose()) {
        let (found, truth) = (f64::from(separation(&shape, &link).distance_m), largest_gap_m(&shape, &link, &TIP));
        prop_assert!(found <= truth + 2e-5, "{found} > {truth}");
        if truth <= 0.0 {
            prop_assert!(found >= truth - 3e-5, "penetration {found}, {truth}");
        }
        if truth > 2e-5 {
            prop_assert!(found > 0.0, "apart by {truth} but {found}");
        }
        if matches!(shape, ObjectShape::Sphere { .. } | ObjectShape::Capsule { .. }) {
            prop_assert!((found - truth).abs() < 2e-5, "the distance itself: {found}, {truth}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn the_gradient_agrees_with_differences(shape in any_shape(), link in any_pose(), phi in -1.0_f32..1.0) {
        let object = [0.02, -0.01, phi];
        let at = |axis: usize, by: f32| {
            let mut moved = object;
            moved[axis] += by;
            let found = separation(&shape, &seen_from(moved, &link));
            (found.distance_m, found.gradient_world(libm::sincosf(moved[2])))
        };
        let (_, gradient) = at(0, 0.0);
        for axis in 0..3 {
            let step = 2e-4;
            let ((low_m, low), (high_m, high)) = (at(axis, -step), at(axis, step));
            let slope = (high_m - low_m) / (2.0 * step);
            // Where the gradient changes within the step, the difference lies between its values at both ends.
            let slack = 4e-3 + (high[axis] - low[axis]).abs();
            prop_assert!((slope - gradient[axis]).abs() < slack, "axis {axis}: {slope} against {}", gradient[axis]);
        }
    }

    #[test]
    fn it_changes_by_at_most_what_the_link_is_shifted_by(
        shape in any_shape(), link in any_pose(), by in [-0.004_f32..0.004, -0.004_f32..0.004, -0.004_f32..0.004],
    ) {
        let moved = Isometry3::from_parts((link.translation.vector + Vector3::from(by)).into(), link.rotation);
        let change = (separation(&shape, &link).distance_m - separation(&shape, &moved).distance_m).abs();
        prop_assert!(change <= Vector3::from(by).norm() + 2e-6, "{change}");
    }

    #[test]
    fn a_limit_only_cuts_off_what_lies_beyond_it(shape in any_shape(), link in any_pose(), limit in -0.02_f32..0.05) {
        let full = separation(&shape, &link);
        match shape.separation_below(&link, &TIP, limit) {
            Some(found) => prop_assert_eq!(found, full),
            None => prop_assert!(full.distance_m >= limit),
        }
    }

    #[test]
    fn bounds_by_a_point_or_a_sphere_are_never_more_than_the_separation(shape in any_shape(), link in any_pose()) {
        let found = separation(&shape, &link).distance_m;
        prop_assert!(shape.separation_lower_bound_m(&link, &TIP) <= found + 1e-6);
        let corner = link * nalgebra::Point3::new(0.0575, 0.0, 0.0115);
        prop_assert!(found <= shape.point_separation_m(&corner.coords).max(0.0) + 0.2);
    }

    #[test]
    fn a_turn_by_the_symmetry_changes_nothing(shape in any_shape(), link in any_pose(), any_turn in -3.0_f32..3.0) {
        let symmetry_rad = shape.yaw_symmetry_rad();
        let turn = if symmetry_rad > 0.0 { symmetry_rad } else { any_turn };
        let turned = pose([0.0; 3], [0.0, 0.0, turn]) * link;
        let (here, there) = (separation(&shape, &link), separation(&shape, &turned));
        prop_assert!((here.distance_m - there.distance_m).abs() < 3e-6, "{} {}", here.distance_m, there.distance_m);
        if symmetry_rad == 0.0 {
            prop_assert_eq!(here.gradient_object[2], 0.0);
        }
    }

    #[test]
    fn the_hull_of_a_box_is_as_far_as_the_box(link in any_pose(), half in [0.03_f32..0.1, 0.03_f32..0.1, 0.03_f32..0.1]) {
        let (a, b) = (ObjectShape::Cuboid { half_extents_m: half }, box_hull(half));
        let (a, b) = (separation(&a, &link), separation(&b, &link));
        prop_assert!((a.distance_m - b.distance_m).abs() < 1e-5, "{} {}", a.distance_m, b.distance_m);
        if (a.normal_object - b.normal_object).norm() < 1e-3 {
            for i in 0..3 {
                prop_assert!((a.gradient_object[i] - b.gradient_object[i]).abs() < 2e-3, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_tip_that_points_at_a_round_side_or_stands_on_an_end_is_as_far_as_its_corner() {
    let cylinder = ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.08 };
    let sphere = ObjectShape::Sphere { radius_m: 0.04 };
    for phi in [0.0_f32, 0.4, 2.0, -1.0] {
        let (s, c) = libm::sincosf(phi);
        // The tip's end, 0.0575 m along its x axis, 3 mm before the side.
        let at = 0.04 + 0.003 + 0.0575;
        let inwards = pose([at * c, at * s, 0.0], [0.0, 0.0, phi + core::f32::consts::PI]);
        for shape in [cylinder, sphere] {
            let found = separation(&shape, &inwards);
            assert!((found.distance_m - 0.003).abs() < 2e-6, "{shape:?}: {}", found.distance_m);
            assert!((found.normal_object - Vector3::new(c, s, 0.0)).norm() < 1e-3, "{}", found.normal_object);
        }
    }
    let above = separation(&cylinder, &pose([0.0, 0.0, 0.1], [0.0; 3]));
    assert!((above.distance_m - (0.02 - 0.0115)).abs() < 1e-6 && above.normal_object == Vector3::z());
}

#[test]
fn parallel_and_level_edges_give_finite_numbers_and_no_number_gives_none() {
    for shape in shapes() {
        for tilt in [0.0_f32, 1e-7, 1e-4, 5e-3, 0.0101, core::f32::consts::FRAC_PI_2] {
            for t in [[0.15, 0.0, 0.0], [0.0, 0.06, 0.11], [0.1, 0.05, 0.1], [0.0, 0.0, 0.0]] {
                let found = separation(&shape, &pose(t, [tilt, -tilt, tilt]));
                let numbers = [found.distance_m, found.gradient_object[0], found.gradient_object[2]];
                assert!(numbers.iter().all(|v| v.is_finite()), "{shape:?} tilt {tilt}: {numbers:?}");
            }
        }
        assert!(shape.separation(&pose([f32::NAN, 0.0, 0.0], [0.0; 3]), &TIP).is_none());
        assert!(shape.separation(&pose([0.0; 3], [0.0; 3]), &Prism::new(&[], [0.0, 0.0])).is_none());
    }
}
