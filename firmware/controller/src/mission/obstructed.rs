//! What known obstacles have to do with what is felt and with where the hand may go.

use crate::evidence::Toucher;
use nalgebra::Isometry3;
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::{HandLink, hand_prism};
use tactus_common::shape::Obstacle;

/// How exactly it is known where an obstacle stands, its size and the hand's errors included, metres.
const OBSTACLE_UNCERTAINTY_M: f32 = 3e-3;

/// Can what `toucher` felt in this configuration have been an obstacle? One of its links is on the surface of one then, or
/// inside; whether it touches the object as well is not asked: what may be either tells nothing.
pub fn may_have_touched<'o>(
    obstacles: impl IntoIterator<Item = &'o Obstacle>,
    world_from_hand: &Isometry3<f32>,
    angles: &HandAngles,
    toucher: Toucher,
) -> bool {
    is_near(obstacles, world_from_hand, angles, |link| toucher.has(link))
}

/// Does any link of the hand come nearer to an obstacle than it is known?
pub fn meets<'o>(
    obstacles: impl IntoIterator<Item = &'o Obstacle>,
    world_from_hand: &Isometry3<f32>,
    angles: &HandAngles,
) -> bool {
    is_near(obstacles, world_from_hand, angles, |_| true)
}

/// Is one of these links nearer to an obstacle than that is known? Bounding spheres first: few pairs need more.
fn is_near<'o>(
    obstacles: impl IntoIterator<Item = &'o Obstacle>,
    world_from_hand: &Isometry3<f32>,
    angles: &HandAngles,
    is_meant: impl Fn(HandLink) -> bool,
) -> bool {
    let poses = hand::link_poses(world_from_hand, angles);
    obstacles.into_iter().any(|obstacle| {
        let obstacle_from_world = obstacle.isometry().inverse();
        HandLink::ALL.into_iter().zip(&poses).filter(|(link, _)| is_meant(*link)).any(|(link, pose)| {
            let (pose, prism) = (obstacle_from_world * pose, hand_prism(link));
            obstacle.shape.separation_lower_bound_m(&pose, prism) < OBSTACLE_UNCERTAINTY_M
                && obstacle.shape.separation_below(&pose, prism, OBSTACLE_UNCERTAINTY_M).is_some()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BOX, TRUTH};
    use crate::touch::candidate;
    use tactus_common::pose::PlanarPose;
    use tactus_common::shape::ObjectShape;

    /// A cylinder whose side is so far from the finger's nearest point, beyond it along the hand's x.
    fn beside(world_from_hand: &Isometry3<f32>, angles: &HandAngles, gap_m: f32) -> Obstacle {
        let shape = ObjectShape::Cylinder { radius_m: 0.03, half_height_m: 0.15 };
        let out = world_from_hand.rotation * nalgebra::Vector3::x();
        let origin = world_from_hand.translation;
        let at = |along_m: f32| Obstacle {
            shape,
            pose: PlanarPose::new(origin.x + along_m * out.x, origin.y + along_m * out.y, 0.0),
        };
        let distance_m = |obstacle: &Obstacle| {
            let from_world = obstacle.isometry().inverse();
            let poses = hand::link_poses(world_from_hand, angles);
            let of_finger = HandLink::ALL.into_iter().zip(poses).filter(|(link, _)| link.finger() == Some(0));
            let found = of_finger.filter_map(|(link, pose)| shape.separation(&(from_world * pose), hand_prism(link)));
            found.fold(f32::MAX, |least, s| least.min(s.distance_m))
        };
        // From far outside towards the finger.
        let mut along_m = 0.4;
        for _ in 0..100 {
            along_m -= 0.5 * (distance_m(&at(along_m)) - gap_m);
        }
        assert!((distance_m(&at(along_m)) - gap_m).abs() < 1e-4);
        at(along_m)
    }

    #[test]
    fn what_is_felt_on_an_obstacles_surface_is_the_obstacles_and_what_is_felt_off_it_is_not() {
        let plan = candidate(0, &BOX).unwrap();
        let world_from_hand = plan.world_from_hand(&TRUTH, &BOX);
        let angles = HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
        for (gap_m, expected) in [(0.0, true), (0.002, true), (-0.002, true), (0.004, false), (0.02, false)] {
            let obstacle = beside(&world_from_hand, &angles, gap_m);
            let felt = |toucher| may_have_touched([&obstacle], &world_from_hand, &angles, toucher);
            assert_eq!(felt(Toucher::Finger(0)), expected, "{gap_m}");
            assert!(!felt(Toucher::Finger(2)) && !felt(Toucher::Palm), "the other side of the hand");
            assert_eq!(meets([&obstacle], &world_from_hand, &angles), expected, "{gap_m}");
        }
        assert!(!may_have_touched([], &world_from_hand, &angles, Toucher::Finger(0)));
    }
}
