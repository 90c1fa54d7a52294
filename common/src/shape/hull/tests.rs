//! What is a hull and what is not, and what is known of one.

use super::*;
use core::f32::consts::{FRAC_PI_2, PI};
use proptest::prelude::*;

extern crate std;
use std::vec::Vec as List;

const BOX_FACES: [&[u8]; 6] =
    [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];

fn box_corners(half: [f32; 3]) -> List<[f32; 3]> {
    let side = |bit: usize, i: usize| if i >> bit & 1 == 1 { half[bit] } else { -half[bit] };
    (0..8).map(|i| [side(0, i), side(1, i), side(2, i)]).collect()
}

/// The edges, each once, with the faces to the left and to the right seen from outside, and where each begins and ends, metres.
fn edges(hull: &Hull) -> impl Iterator<Item = ([usize; 2], [Vector3<f32>; 2])> {
    let slots = hull
        .ranges()
        .flat_map(|(from, to)| (from..to).map(move |slot| (slot, if slot + 1 < to { slot + 1 } else { from })));
    let face_of = |slot: usize| hull.ranges().position(|(_, to)| slot < to).unwrap();
    let corner_of = |slot: usize| hull.corner(hull.slots[slot]).unwrap();
    slots.filter_map(move |(slot, next)| {
        let faces = [face_of(slot), usize::from(hull.across[slot])];
        (faces[1] > faces[0]).then(|| (faces, [corner_of(slot), corner_of(next)]))
    })
}

fn over_the_wire(hull: &Hull) -> Hull {
    let mut buffer = [0; 512];
    let bytes = postcard::to_slice(hull, &mut buffer).unwrap();
    postcard::from_bytes(bytes).unwrap()
}

#[test]
fn a_box_is_a_hull_with_its_extents_edges_and_symmetry() {
    let hull = Hull::new(&box_corners([0.1, 0.05, 0.08]), BOX_FACES).unwrap();
    assert_eq!(hull.half_extents_m(), [0.1, 0.05, 0.08]);
    assert_eq!(hull.z_m(), [-0.08, 0.08]);
    assert_eq!(
        (edges(&hull).count(), hull.edge_count(), hull.faces().count(), hull.yaw_symmetry_rad()),
        (12, 12, 6, PI)
    );
    for ([left, right], [from, to]) in edges(&hull) {
        let turn = hull.normal(left).unwrap().cross(&hull.normal(right).unwrap());
        assert!((turn - (to - from).normalize()).norm() < 1e-5, "left and right, seen from outside");
    }
}

#[test]
fn a_prism_repeats_after_the_turn_from_one_side_to_the_next() {
    for n in 3..=12 {
        let hull = Hull::regular_prism(n, 0.05, 0.075).unwrap();
        assert!((hull.yaw_symmetry_rad() - TAU / f32::from(n)).abs() < 1e-6, "{n}");
    }
    let square = Hull::new(&box_corners([0.04, 0.04, 0.1]), BOX_FACES).unwrap();
    assert!((square.yaw_symmetry_rad() - FRAC_PI_2).abs() < 1e-6);
    let wedge = [[-0.04, -0.03, -0.03], [0.06, -0.03, -0.03], [-0.02, 0.05, -0.03], [0.0, 0.01, 0.05]];
    let wedge = Hull::new(&wedge, [&[0_u8, 2, 1][..], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]]).unwrap();
    assert_eq!(wedge.yaw_symmetry_rad(), TAU);
}

#[test]
fn a_hull_comes_back_from_the_wire_as_it_was_and_what_is_none_is_not_valid() {
    for n in 3..=12 {
        let hull = Hull::regular_prism(n, 0.05, 0.075).unwrap();
        assert_eq!(over_the_wire(&hull), hull);
    }
    assert!(!over_the_wire(&Hull::NONE).is_valid());
}

#[test]
fn what_is_no_closed_convex_body_within_the_bounds_is_refused_by_reason() {
    let corners = box_corners([0.1, 0.05, 0.08]);
    let of = |corners: &[[f32; 3]], faces: &[&[u8]]| Hull::new(corners, faces.iter().copied()).unwrap_err();
    assert_eq!(of(&[[0.0; 3]; 25], &BOX_FACES), HullFault::Corners);
    assert_eq!(of(&corners[..3], &[]), HullFault::Corners);
    assert_eq!(of(&corners, &BOX_FACES[..3]), HullFault::Faces);
    assert_eq!(of(&corners, &[BOX_FACES[0]; 25]), HullFault::Edges);
    assert_eq!(of(&corners, &[&[0_u8, 1, 2][..]; 25]), HullFault::Faces);
    assert_eq!(of(&corners, &BOX_FACES[..5]), HullFault::NotClosed { face: 0 });
    assert_eq!(of(&corners, &[&[0, 1]]), HullFault::BadFace { face: 0 });
    assert_eq!(of(&corners, &[&[0, 1, 8]]), HullFault::BadFace { face: 0 });
    let mut bad = corners.clone();
    bad[5][1] = f32::NAN;
    assert_eq!(of(&bad, &BOX_FACES), HullFault::NotFinite { corner: 5 });
    let mut dented = corners.clone();
    dented[7] = [0.02, 0.01, 0.02];
    assert!(matches!(of(&dented, &BOX_FACES), HullFault::NotConvex { .. }));
    let inward: List<List<u8>> = BOX_FACES.iter().map(|face| face.iter().rev().copied().collect()).collect();
    let inward: List<&[u8]> = inward.iter().map(List::as_slice).collect();
    assert!(matches!(of(&corners, &inward), HullFault::NotConvex { .. } | HullFault::OriginOutside { .. }));
    let aside: List<_> = corners.iter().map(|[x, y, z]| [x + 0.2, *y, *z]).collect();
    assert!(matches!(of(&aside, &BOX_FACES), HullFault::OriginOutside { .. }));
    let mut lonely = corners.clone();
    lonely.push([0.0; 3]);
    assert_eq!(of(&lonely, &BOX_FACES), HullFault::NotClosed { face: 0 });
    assert_eq!(Hull::regular_prism(13, 0.05, 0.05).unwrap_err(), HullFault::Corners);
}

proptest! {
    #[test]
    fn whatever_the_bytes_a_hull_is_valid_or_said_not_to_be(bytes in proptest::collection::vec(0_u8..9, 0..140)) {
        if let Ok(hull) = postcard::from_bytes::<Hull>(&bytes) {
            prop_assert_eq!(hull.is_valid(), edges(&hull).count() > 0);
        }
    }

    #[test]
    fn faces_in_any_wrong_order_never_pass(swap in (0_usize..24, 0_usize..24)) {
        let mut flat: List<u8> = BOX_FACES.concat();
        flat.swap(swap.0, swap.1);
        let faces: List<&[u8]> = flat.chunks(4).collect();
        let hull = Hull::new(&box_corners([0.1, 0.05, 0.08]), faces);
        let same = flat == BOX_FACES.concat();
        prop_assert_eq!(hull.is_ok(), same);
    }
}
