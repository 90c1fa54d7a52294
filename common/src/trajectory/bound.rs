//! A segment's extremes, bounded from above without looking at instants one by one.
//!
//! A polynomial in Bernstein form stays between its least and its largest coefficient; of its halves (de Casteljau's
//! algorithm) this is nearly exact for the smooth curves of a motion. So most segments need no further look.

use super::{Knot, POSITION_SLACK_RAD};
use crate::limits::ARM_ACCELERATION_MAX_RAD_S2;
use crate::robot::JointLimit;

/// Share of a limit that a bound must leave free: more than rounding can make of it.
const MARGIN: f32 = 1e-3;
/// Times that a curve is halved before the bound gives up.
const HALVINGS: usize = 2;

/// Is it certain that the joint keeps to its limits all the way from one knot to the other? `false` says nothing.
pub(super) fn keeps_within(from: &Knot, to: &Knot, joint: usize, limit: &JointLimit) -> bool {
    let state = |k: &Knot| Some((*k.q_rad.get(joint)?, *k.qd_rad_s.get(joint)?, *k.qdd_rad_s2.get(joint)?));
    let (Some((q0, v0, a0)), Some((q1, v1, a1)), Some(acceleration_max)) =
        (state(from), state(to), ARM_ACCELERATION_MAX_RAD_S2.get(joint))
    else {
        return false;
    };
    let t = to.t_s - from.t_s;
    // Coefficients of the quintic, relative to its start: those of knots and their derivatives.
    let (d, e0, e1, f0, f1) = (q1 - q0, v0 * t / 5.0, v1 * t / 5.0, a0 * t * t / 20.0, a1 * t * t / 20.0);
    let position = [0.0, e0, 2.0 * e0 + f0, d - 2.0 * e1 + f1, d - e1, d];
    let velocity = slopes::<6, 5>(&position, 5.0 / t);
    let acceleration = slopes::<5, 4>(&velocity, 4.0 / t);
    let symmetric = |max: f32| (-max * (1.0 - MARGIN), max * (1.0 - MARGIN));
    let range =
        (limit.lower_rad - POSITION_SLACK_RAD + MARGIN - q0, limit.upper_rad + POSITION_SLACK_RAD - MARGIN - q0);
    stays(position, range)
        && stays(velocity, symmetric(limit.velocity_rad_s))
        && stays(acceleration, symmetric(*acceleration_max))
}

/// Coefficients of the derivative.
fn slopes<const N: usize, const M: usize>(coefficients: &[f32; N], scale: f32) -> [f32; M] {
    let mut slopes = [0.0; M];
    for (slope, pair) in slopes.iter_mut().zip(coefficients.windows(2)) {
        if let [before, after] = pair {
            *slope = (after - before) * scale;
        }
    }
    slopes
}

/// Are all coefficients, at some level of halving, within the range? Of a NaN they are not.
fn stays<const N: usize>(coefficients: [f32; N], (low, high): (f32, f32)) -> bool {
    let within = |c: &[f32; N]| c.iter().all(|v| (low..=high).contains(v));
    let mut pieces = [coefficients; 1 << HALVINGS];
    let mut count = 1;
    for _ in 0..HALVINGS {
        if pieces.iter().take(count).all(within) {
            return true;
        }
        // From the last, so that no piece is overwritten before it is halved.
        for i in (0..count).rev() {
            let Some((left, right)) = pieces.get(i).map(halves) else { return false };
            for (at, half) in [(2 * i, left), (2 * i + 1, right)] {
                if let Some(piece) = pieces.get_mut(at) {
                    *piece = half;
                }
            }
        }
        count *= 2;
    }
    pieces.iter().all(within)
}

/// The two halves of a curve (de Casteljau).
fn halves<const N: usize>(coefficients: &[f32; N]) -> ([f32; N], [f32; N]) {
    let (mut left, mut right) = (*coefficients, *coefficients);
    for (level, next) in left.iter_mut().enumerate().skip(1) {
        // `right` holds the triangle's row; its first entry is the left half's next coefficient.
        for i in 0..N - level {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
        *next = right[0];
    }
    (left, right)
}

#[cfg(test)]
mod tests {
    use super::super::{CHECKS_PER_SEGMENT, Sample, between, check_state};
    use super::*;
    use crate::limits::ARM_JOINTS;
    use crate::robot::ARM_LIMITS;
    use proptest::prelude::*;

    #[test]
    fn the_halves_of_a_curve_meet_in_its_middle() {
        let (left, right) = halves(&[0.0, 0.0, 5.0, 0.0, 0.0]);
        assert_eq!((left, right), ([0.0, 0.0, 1.25, 1.875, 1.875], [1.875, 1.875, 1.25, 0.0, 0.0]));
    }

    fn knot(t_s: f32, q: f32, v: f32, a: f32) -> Knot {
        Knot { t_s, q_rad: [q; ARM_JOINTS], qd_rad_s: [v; ARM_JOINTS], qdd_rad_s2: [a; ARM_JOINTS] }
    }

    proptest! {
        #[test]
        fn what_is_certain_is_seen_at_every_instant_as_well(
            t_s in 0.02_f32..2.0, q in -1.0_f32..1.0, d in -0.5_f32..0.5, v in prop::array::uniform2(-1.0_f32..1.0),
            a in prop::array::uniform2(-4.0_f32..4.0),
        ) {
            let (from, to) = (knot(0.0, q, v[0], a[0]), knot(t_s, q + d, v[1], a[1]));
            let certain = |joint: usize| keeps_within(&from, &to, joint, &ARM_LIMITS[joint]);
            for k in 0..=CHECKS_PER_SEGMENT {
                let sample = between(&from, &to, t_s * (k as f32 / CHECKS_PER_SEGMENT as f32));
                for joint in (0..ARM_JOINTS).filter(|j| certain(*j)) {
                    // The other joints stand where they may.
                    let middle = |j: usize| 0.5 * (ARM_LIMITS[j].lower_rad + ARM_LIMITS[j].upper_rad);
                    let mut alone = Sample { q_rad: core::array::from_fn(middle), ..Sample::default() };
                    alone.q_rad[joint] = sample.q_rad[joint];
                    alone.qd_rad_s[joint] = sample.qd_rad_s[joint];
                    alone.qdd_rad_s2[joint] = sample.qdd_rad_s2[joint];
                    prop_assert_eq!(check_state(&alone, &ARM_LIMITS, 0), Ok(()));
                }
            }
        }

        #[test]
        fn a_motion_from_rest_to_rest_at_nine_tenths_of_the_limits_needs_no_further_look(
            d in 0.05_f32..0.8, joint in 0..ARM_JOINTS,
        ) {
            let limit = &ARM_LIMITS[joint];
            let by_speed = 1.875 * d / (0.9 * limit.velocity_rad_s);
            let t_s = by_speed.max(libm::sqrtf(5.774 * d / (0.9 * ARM_ACCELERATION_MAX_RAD_S2[joint])));
            let start = 0.5 * (limit.lower_rad + limit.upper_rad) - 0.5 * d;
            prop_assert!(keeps_within(&knot(0.0, start, 0.0, 0.0), &knot(t_s, start + d, 0.0, 0.0), joint, limit));
        }
    }
}
