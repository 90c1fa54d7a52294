//! Properties of the box-prism separation, against differences and an independent distance.

use super::*;
use crate::shape::axis::{PARALLEL_SINE_SQ, cross_with_axis};
use crate::shape::tests::TIP;
use nalgebra::{Point3, Translation3, UnitQuaternion};
use proptest::prelude::*;

const HALF: [f32; 3] = [0.1, 0.05, 0.1];
const BAR: Prism = Prism::new(&[[-0.02, -0.01], [0.08, -0.01], [0.08, 0.015], [-0.02, 0.015]], [-0.01, 0.01]);

fn pose(t: [f32; 3], axis_angle: [f32; 3]) -> Isometry3<f32> {
    Isometry3::from_parts(Translation3::new(t[0], t[1], t[2]), UnitQuaternion::new(Vector3::from(axis_angle)))
}

/// World-from-link of the link as seen from an object at `(x, y, phi)`.
fn seen_from(object: [f32; 3], world_from_link: &Isometry3<f32>) -> Isometry3<f32> {
    pose([object[0], object[1], 0.0], [0.0, 0.0, object[2]]).inverse() * world_from_link
}

/// Nearest point of the prism (link frame) to `p`.
fn project_on_prism(prism: &Prism, p: Point3<f32>) -> Point3<f32> {
    let z = p.z.clamp(prism.z_m[0], prism.z_m[1]);
    let n = prism.corners_m.len();
    let mut inside = true;
    let mut nearest = (f32::MAX, [p.x, p.y]);
    for i in 0..n {
        let (a, b) = (prism.corners_m[i], prism.corners_m[(i + 1) % n]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        if dx * (p.y - a[1]) - dy * (p.x - a[0]) < 0.0 {
            inside = false;
        }
        let t = ((dx * (p.x - a[0]) + dy * (p.y - a[1])) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        let q = [a[0] + t * dx, a[1] + t * dy];
        let d = (q[0] - p.x) * (q[0] - p.x) + (q[1] - p.y) * (q[1] - p.y);
        if d < nearest.0 {
            nearest = (d, q);
        }
    }
    let [x, y] = if inside { [p.x, p.y] } else { nearest.1 };
    Point3::new(x, y, z)
}

/// The true distance of the two bodies (0 if they overlap) by alternating projections.
fn true_distance_m(object_from_link: &Isometry3<f32>, prism: &Prism) -> f32 {
    let mut p = Point3::new(0.0, 0.0, 0.0);
    let mut distance = 0.0;
    for _ in 0..3000 {
        let on_prism = object_from_link * project_on_prism(prism, object_from_link.inverse() * p);
        let on_box = Point3::from(Vector3::from_fn(|i, _| on_prism[i].clamp(-HALF[i], HALF[i])));
        distance = (on_prism - on_box).norm();
        p = on_box;
    }
    distance
}

fn separation(object_from_link: &Isometry3<f32>, prism: &Prism) -> Separation {
    separation_below(&HALF, object_from_link, prism, f32::INFINITY).expect("finite pose")
}

fn any_pose() -> impl Strategy<Value = Isometry3<f32>> {
    ([-0.2_f32..0.2, -0.15_f32..0.15, -0.15_f32..0.2], [-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0])
        .prop_map(|(t, r)| pose(t, r))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn the_gradient_agrees_with_differences(link in any_pose(), phi in -1.0_f32..1.0) {
        let object = [0.02, -0.01, phi];
        let here = separation(&seen_from(object, &link), &TIP);
        let gradient = here.gradient_world(libm::sincosf(phi));
        for axis in 0..3 {
            let step = 2e-4;
            let at = |by: f32| {
                let mut moved = object;
                moved[axis] += by;
                separation(&seen_from(moved, &link), &TIP)
            };
            let (low, high) = (at(-step), at(step));
            // Where the winning axis changes within the step the gradient jumps: no difference to compare with.
            let smooth = (low.gradient_object[2] - high.gradient_object[2]).abs() < 2e-3
                && (low.normal_object - high.normal_object).norm() < 2e-3;
            if smooth {
                let slope = (high.distance_m - low.distance_m) / (2.0 * step);
                prop_assert!((slope - gradient[axis]).abs() < 4e-3, "axis {axis}: {slope} against {}", gradient[axis]);
            }
        }
    }

    #[test]
    fn the_sign_and_the_bound_agree_with_the_true_distance(link in any_pose()) {
        let distance = separation(&link, &TIP).distance_m;
        let truth = true_distance_m(&link, &TIP);
        prop_assert!(distance <= truth + 2e-5, "never more than the true distance: {distance} > {truth}");
        if truth > 1e-3 {
            prop_assert!(distance > 0.0, "apart by {truth} but {distance}");
        }
        if truth < 1e-6 {
            prop_assert!(distance < 1e-4, "overlap but {distance}");
        }
    }

    #[test]
    fn the_sphere_bound_is_never_more_than_the_separation(link in any_pose()) {
        let shape = crate::shape::ObjectShape::Cuboid { half_extents_m: HALF };
        let bound = shape.separation_lower_bound_m(&link, &BAR);
        prop_assert!(bound <= separation(&link, &BAR).distance_m + 1e-6);
    }

    #[test]
    fn a_limit_only_cuts_off_what_lies_beyond_it(link in any_pose(), limit in -0.02_f32..0.05) {
        let full = separation(&link, &BAR);
        match separation_below(&HALF, &link, &BAR, limit) {
            Some(found) => prop_assert_eq!(found, full),
            None => prop_assert!(full.distance_m >= limit),
        }
    }
}

#[test]
fn a_bar_above_before_and_beside_the_box_is_as_far_as_its_nearest_face() {
    for (t, expected, normal) in [
        ([0.0, 0.0, 0.15], 0.04, Vector3::z()),
        ([0.15, 0.0, 0.0], 0.03, Vector3::x()),
        ([-0.2, 0.0, 0.0], 0.02, -Vector3::x()),
        ([0.0, 0.1, 0.0], 0.04, Vector3::y()),
        ([0.0, -0.1, 0.0], 0.035, -Vector3::y()),
    ] {
        let s = separation(&pose(t, [0.0; 3]), &BAR);
        assert!((s.distance_m - expected).abs() < 1e-6, "{t:?}: {}", s.distance_m);
        assert!((s.normal_object - normal).norm() < 1e-6);
        assert!((s.gradient_object[0] + normal.x).abs() < 1e-6 && (s.gradient_object[1] + normal.y).abs() < 1e-6);
    }
}

#[test]
fn crossed_edges_touch_along_their_common_normal() {
    // A bar turned by 45 degrees about its length, lying across a top edge of the box that runs along x.
    let quarter = core::f32::consts::FRAC_PI_4;
    let square: Prism = Prism::new(&[[-0.1, -0.01], [0.1, -0.01], [0.1, 0.01], [-0.1, 0.01]], [-0.01, 0.01]);
    let lean = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -quarter)
        * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f32::consts::FRAC_PI_2)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), quarter);
    let out = Vector3::new(0.0, 1.0, 1.0).normalize();
    let half_diagonal_m = 0.01 * core::f32::consts::SQRT_2;
    for gap in [-0.002_f32, 0.0, 0.003] {
        let centre = Vector3::new(0.0, 0.05, 0.1) + out * (half_diagonal_m + gap);
        let s = separation(&Isometry3::from_parts(centre.into(), lean), &square);
        assert!((s.distance_m - gap).abs() < 1e-5, "gap {gap}: {}", s.distance_m);
        assert!((s.normal_object - out).norm() < 1e-3, "{}", s.normal_object);
    }
}

#[test]
fn an_edge_along_the_prisms_own_axis_touches_an_edge_of_the_box() {
    // As above, with the post's length along its own z.
    let post: Prism = Prism::new(&[[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]], [-0.1, 0.1]);
    let quarter = core::f32::consts::FRAC_PI_4;
    let lean = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), quarter)
        * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), quarter);
    let out = Vector3::new(0.0, 1.0, 1.0).normalize();
    let half_diagonal_m = 0.01 * core::f32::consts::SQRT_2;
    for gap in [-0.002_f32, 0.0, 0.003] {
        let centre = Vector3::new(0.0, 0.05, 0.1) + out * (half_diagonal_m + gap);
        let s = separation(&Isometry3::from_parts(centre.into(), lean), &post);
        assert!((s.distance_m - gap).abs() < 1e-5, "gap {gap}: {}", s.distance_m);
        assert!((s.normal_object - out).norm() < 1e-3, "{}", s.normal_object);
    }
}

proptest! {
    #[test]
    fn the_winning_axis_is_found_without_looking_at_all_as_well(
        t in [-0.3_f32..0.3, -0.3_f32..0.3, -0.3_f32..0.3], axis_angle in [-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0],
    ) {
        let (placed, body) = (Placed::new(&pose(t, axis_angle), &TIP).unwrap(), Cuboid(&HALF));
        let mut pruned = Best::none();
        box_faces(&HALF, &placed, &mut pruned);
        pruned.offer_prism_faces(&body, &placed);
        pruned.offer_cap_edges(&body, &EDGES, &placed);
        // Every axis of `offer_cap_edges` worked out, root and division included.
        for (side, corner) in placed.sides() {
            for box_axis in 0..3 {
                let cross = cross_with_axis(box_axis, &side.along);
                if cross.norm_squared() >= PARALLEL_SINE_SQ {
                    let sign = if cross.dot(&side.outward) > 0.0 { -1.0 } else { 1.0 };
                    let normal = cross * (sign / libm::sqrtf(cross.norm_squared()));
                    let rise = normal.dot(&placed.axes[2]);
                    let lowest_m = normal.dot(corner) + rise * placed.prism.z_m[usize::from(rise <= 0.0)];
                    prop_assert!(lowest_m - body.reach_m(&normal) <= pruned.distance_m);
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn beside_a_face_the_other_axes_need_no_look(
        t in [-0.3_f32..0.3, -0.3_f32..0.3, -0.3_f32..0.3], axis_angle in [-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0],
    ) {
        let (placed, body) = (Placed::new(&pose(t, axis_angle), &TIP).unwrap(), Cuboid(&HALF));
        let mut best = Best::none();
        box_faces(&HALF, &placed, &mut best);
        if is_opposite_face(&HALF, &placed, &best) {
            let of_face_m = best.distance_m;
            best.offer_prism_faces(&body, &placed);
            best.offer_cap_edges(&body, &EDGES, &placed);
            best.offer_side_edges(&body, &EDGES, &placed);
            prop_assert!(best.distance_m < of_face_m + 1e-6, "{} {of_face_m}", best.distance_m);
        }
    }
}

#[test]
fn parallel_edges_give_finite_numbers() {
    for tilt in [0.0_f32, 1e-7, 1e-4, 5e-3, 0.0101] {
        for t in [[0.15, 0.0, 0.0], [0.0, 0.06, 0.11], [0.1, 0.05, 0.1], [0.0, 0.0, 0.0]] {
            let s = separation(&pose(t, [tilt, -tilt, tilt]), &BAR);
            let numbers = [s.distance_m, s.gradient_object[0], s.gradient_object[1], s.gradient_object[2]];
            assert!(numbers.iter().all(|v| v.is_finite()), "tilt {tilt}: {numbers:?}");
        }
    }
}

#[test]
fn a_pose_that_is_no_number_gives_none() {
    assert!(separation_below(&HALF, &pose([f32::NAN, 0.0, 0.0], [0.0; 3]), &BAR, f32::INFINITY).is_none());
    let nothing = Prism::new(&[], [0.0, 0.0]);
    assert!(separation_below(&HALF, &pose([0.0; 3], [0.0; 3]), &nothing, f32::INFINITY).is_none());
}
