use super::super::tables::{FINGERTIP_TAXELS, HAND_INERTIALS, PAD_POINT_M, PALM_FACE_Z_M, PALM_TAXELS, TIP_LENGTH_M};
use super::*;
use core::f32::consts::{FRAC_PI_2, PI};
use nalgebra::{Point3, Translation3};

fn at_origin(jf_rad: f32, spread_rad: f32) -> [Isometry3<f32>; 9] {
    link_poses(&Isometry3::identity(), &HandAngles::engaged([jf_rad; 3], spread_rad))
}

fn pad_point(poses: &[Isometry3<f32>; 9], finger: usize) -> Point3<f32> {
    poses[HandLink::TIPS[finger].index()] * Point3::new(PAD_POINT_M[0], PAD_POINT_M[1], 0.0)
}

/// Facts 2.6, column 280: JF, opening at the pad point, opening at mid-pad (20 mm from the PIP axis), depth of the tip.
const OPENING: [[f32; 4]; 8] = [
    [0.0, 0.304, 0.258, 0.035],
    [0.2, 0.278, 0.243, 0.059],
    [0.3, 0.261, 0.233, 0.070],
    [0.4, 0.242, 0.222, 0.079],
    [0.5, 0.222, 0.210, 0.087],
    [0.6, 0.201, 0.196, 0.094],
    [0.8, 0.156, 0.167, 0.104],
    [1.0, 0.110, 0.136, 0.107],
];

#[test]
fn the_fingers_open_and_reach_as_far_as_published() {
    for [jf, opening, middle, depth] in OPENING {
        let poses = at_origin(jf, 0.0);
        let across = |p: [f32; 2]| {
            let on = |link: HandLink| (poses[link.index()] * Point3::new(p[0], p[1], 0.0)).x;
            on(HandLink::F1Tip) - on(HandLink::F3Tip)
        };
        let end = (poses[HandLink::F1Tip.index()] * Point3::new(TIP_LENGTH_M, 0.0, 0.0)).z - PALM_FACE_Z_M;
        assert!(
            (across(PAD_POINT_M) - opening).abs() < 0.001,
            "JF {jf}: opening {} for {opening}",
            across(PAD_POINT_M)
        );
        assert!(
            (across([0.020, 0.0095]) - middle).abs() < 0.001,
            "JF {jf}: middle {} for {middle}",
            across([0.020, 0.0095])
        );
        assert!((end - depth).abs() < 0.001, "JF {jf}: depth {end} for {depth}");
    }
}

#[test]
fn pointing_down_over_a_box_f1_and_f2_close_on_one_face_and_f3_on_the_other() {
    // Hand straight down above (0.2, -0.1), its x along the world's y: F1 and F2 must be at +y, F3 at -y, and closing
    // must bring all three pads towards the middle plane y = -0.1 from above the table.
    let x_to_y = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2);
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let hand = Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.3), x_to_y * down);
    assert!((hand * Vector3::z() + Vector3::z()).norm() < 1e-6);
    let at = |jf: f32| link_poses(&hand, &HandAngles::engaged([jf; 3], 0.0));
    let (open, closed) = (at(0.2), at(0.6));
    for (finger, side) in [(0, 1.0), (1, 1.0), (2, -1.0)] {
        let before = pad_point(&open, finger);
        let after = pad_point(&closed, finger);
        assert!(side * (before.y + 0.1) > 0.12 && side * (after.y + 0.1) > 0.09, "finger {finger}: {before} {after}");
        assert!(side * (before.y - after.y) > 0.03, "finger {finger} closes");
        assert!(before.z < 0.3 - PALM_FACE_Z_M && after.z < before.z, "finger {finger} is below the palm");
    }
    // Hand x = world +y and hand z = world -z make hand y = world +x: F1 (hand -y) is at smaller x than F2.
    assert!((pad_point(&open, 0).x - 0.175).abs() < 1e-6 && (pad_point(&open, 1).x - 0.225).abs() < 1e-6);
    assert!((pad_point(&open, 2).x - 0.2).abs() < 1e-6);
}

#[test]
fn the_gripping_side_of_every_pad_faces_the_other_fingers() {
    for finger in 0..3 {
        let poses = at_origin(0.55, 0.0);
        let tip = poses[HandLink::TIPS[finger].index()];
        let side = if finger == 2 { -1.0 } else { 1.0 };
        assert!(side * (tip * Vector3::y()).x < -0.9, "finger {finger}: pad normal {}", tip * Vector3::y());
    }
}

#[test]
fn spread_turns_f1_and_f2_symmetrically_until_they_stand_beside_f3() {
    for spread in [0.0, 0.4, 1.1, FRAC_PI_2, 2.5] {
        let poses = at_origin(0.3, spread);
        let (a, b) = (pad_point(&poses, 0), pad_point(&poses, 1));
        assert!((a.x - b.x).abs() < 1e-6 && (a.y + b.y).abs() < 1e-6 && (a.z - b.z).abs() < 1e-6);
        assert!(a.y < -0.0249, "F1 opens towards -y: {a}");
    }
    let beside = at_origin(0.0, PI);
    let finger3 = pad_point(&beside, 2);
    for finger in 0..2 {
        assert!((pad_point(&beside, finger).x - finger3.x).abs() < 1e-5);
    }
}

#[test]
fn a_tip_follows_by_a_third_and_alone_by_four_thirds_after_breaking_away() {
    let engaged = HandAngles::from_readings(&[0.9, 0.6, 0.3, 0.1], &[0.9, 0.6, 0.3]);
    let expected = HandAngles::engaged([0.9, 0.6, 0.3], 0.1);
    for finger in 0..3 {
        assert!((engaged.distal_rad[finger] - expected.distal_rad[finger]).abs() < 1e-6);
        assert!((expected.distal_rad[finger] - expected.inner_rad[finger] / 3.0).abs() < 1e-6);
    }
    let broken = HandAngles::from_readings(&[1.2, 0.6, 0.3, 0.1], &[0.9, 0.6, 0.3]);
    assert!((broken.distal_rad[0] - engaged.distal_rad[0] - 0.3 * 4.0 / 3.0).abs() < 1e-6);
    assert_eq!(broken.inner_rad[0], 0.9);
}

#[test]
fn pads_have_the_published_area_and_lie_on_their_links() {
    let tip: f32 = FINGERTIP_TAXELS.iter().map(|t| t.area_m2).sum();
    let palm: f32 = PALM_TAXELS.iter().map(|t| t.area_m2).sum();
    assert!((tip - 514e-6).abs() < 1e-6, "fingertip {tip}");
    assert!((palm - 2328e-6).abs() < 1e-6, "palm {palm}");
    for (link, taxels) in [(HandLink::F2Tip, FINGERTIP_TAXELS), (HandLink::Palm, PALM_TAXELS)] {
        let prism = hand_prism(link);
        for t in taxels {
            assert!((Vector3::from(t.normal).norm() - 1.0).abs() < 1e-6);
            let outside = |d: f32| {
                let p = Vector3::from(t.centre_m) + d * Vector3::from(t.normal);
                let n = prism.corners_m.len();
                let beyond = (0..n).any(|i| {
                    let (a, b) = (prism.corners_m[i], prism.corners_m[(i + 1) % n]);
                    (b[0] - a[0]) * (p.y - a[1]) - (b[1] - a[1]) * (p.x - a[0]) < 0.0
                });
                beyond || p.z < prism.z_m[0] || p.z > prism.z_m[1]
            };
            assert!(outside(2e-4) && !outside(-2e-4), "{link:?}: {:?}", t.centre_m);
        }
    }
}

#[test]
fn the_hand_weighs_what_its_maker_says() {
    let total: f32 = HAND_INERTIALS.iter().map(|i| i.mass_kg).sum();
    assert!((total - 1.202).abs() < 0.001, "{total}");
}

#[test]
fn links_know_their_place_and_finger() {
    for (index, link) in HandLink::ALL.into_iter().enumerate() {
        assert_eq!(link.index(), index);
        assert_eq!(HandLink::from_index(index), Some(link));
    }
    assert_eq!(HandLink::from_index(9), None);
    assert_eq!(HandLink::Palm.finger(), None);
    for finger in 0..3 {
        assert_eq!(HandLink::INNERS[finger].finger(), Some(finger));
        assert_eq!(HandLink::TIPS[finger].finger(), Some(finger));
    }
}

#[test]
fn straight_down_on_a_wide_box_the_inner_links_stop_the_palm_where_published() {
    // Facts 2.6, lower table, column 280: for a face 0.2 m wide, how low the palm can go before an inner link touches
    // the box's top edges. Found here from the shapes: the highest corner of the box that clears every inner link.
    for [jf, palm_above] in [[0.0, 0.011], [0.2, 0.022], [0.3, 0.028], [0.4, 0.034], [0.5, 0.041]] {
        let poses = at_origin(jf, 0.0);
        let prism = hand_prism(HandLink::F1Inner);
        // Walk the top edge point (x = 0.1) away from the palm until it leaves the inner link's cross-section.
        let mut edge = PALM_FACE_Z_M;
        for step in 0..1000 {
            let z = PALM_FACE_Z_M + 0.0001 * step as f32;
            // The top face is the half line x <= 0.1 at z: free if no point of it is inside.
            let hit = (0..200).any(|k| {
                let p = poses[HandLink::F1Inner.index()].inverse() * Point3::new(0.1 - 0.0005 * k as f32, -0.025, z);
                let n = prism.corners_m.len();
                (0..n).all(|i| {
                    let (a, b) = (prism.corners_m[i], prism.corners_m[(i + 1) % n]);
                    (b[0] - a[0]) * (p.y - a[1]) - (b[1] - a[1]) * (p.x - a[0]) >= 0.0
                })
            });
            if hit {
                edge = z;
            }
        }
        let found = edge - PALM_FACE_Z_M;
        assert!((found - palm_above).abs() < 0.003, "JF {jf}: palm {found} above the box, published {palm_above}");
    }
}
