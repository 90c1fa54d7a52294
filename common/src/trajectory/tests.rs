//! Properties of [`Trajectory`].

use super::*;
use proptest::prelude::*;

const LIMITS: [JointLimit; ARM_JOINTS] =
    [JointLimit { lower_rad: -2.0, upper_rad: 2.0, velocity_rad_s: 1.5, torque_nm: 10.0 }; ARM_JOINTS];

fn rest(t_s: f32, q_rad: f32) -> Knot {
    Knot { t_s, q_rad: [q_rad; ARM_JOINTS], ..Knot::default() }
}

fn trajectory(knots: &[Knot]) -> Trajectory {
    Trajectory { request: 7, knots: Vec::from_slice(knots).unwrap(), guarded_from: 255 }
}

fn good() -> Trajectory {
    trajectory(&[rest(0.0, 0.0), rest(1.5, 0.5), rest(3.0, -0.2)])
}

fn any_knot(t_s: f32) -> impl Strategy<Value = Knot> {
    (prop::array::uniform7(-2.0f32..2.0), prop::array::uniform7(-1.0f32..1.0), prop::array::uniform7(-3.0f32..3.0))
        .prop_map(move |(q_rad, qd_rad_s, qdd_rad_s2)| Knot { t_s, q_rad, qd_rad_s, qdd_rad_s2 })
}

proptest! {
    #[test]
    fn position_velocity_and_acceleration_meet_both_knots(a in any_knot(0.0), b in any_knot(0.8), c in any_knot(1.3)) {
        let t = trajectory(&[a, b, c]);
        for (knot, before, after) in [(a, 0.0, 0.0), (b, 0.8 - 1e-5, 0.8), (c, 1.3 - 1e-5, 1.3 - 1e-5)] {
            for s in [t.sample(before).unwrap(), t.sample(after).unwrap()] {
                for j in 0..ARM_JOINTS {
                    prop_assert!((s.q_rad[j] - knot.q_rad[j]).abs() < 1e-4);
                    prop_assert!((s.qd_rad_s[j] - knot.qd_rad_s[j]).abs() < 2e-3);
                    prop_assert!((s.qdd_rad_s2[j] - knot.qdd_rad_s2[j]).abs() < 0.1);
                }
            }
        }
    }

    #[test]
    fn velocity_and_acceleration_are_the_derivatives(a in any_knot(0.0), b in any_knot(1.0), at in 0.1f32..0.9) {
        let t = trajectory(&[a, b]);
        let h = 5e-3;
        let (l, m, r) = (t.sample(at - h).unwrap(), t.sample(at).unwrap(), t.sample(at + h).unwrap());
        for j in 0..ARM_JOINTS {
            prop_assert!(((r.q_rad[j] - l.q_rad[j]) / (2.0 * h) - m.qd_rad_s[j]).abs() < 0.02);
            prop_assert!(((r.qd_rad_s[j] - l.qd_rad_s[j]) / (2.0 * h) - m.qdd_rad_s2[j]).abs() < 0.1);
        }
    }

    #[test]
    fn what_barely_passes_the_check_stays_within_limits_at_any_instant(a in any_knot(0.0), b in any_knot(2.0), at in 0.0f32..4.0) {
        // The largest amplitude that passes, by bisection: the motion is linear in it.
        let scaled = |k: f32| {
            let part = |knot: Knot| Knot {
                q_rad: knot.q_rad.map(|x| k * x),
                qd_rad_s: knot.qd_rad_s.map(|x| k * x),
                qdd_rad_s2: knot.qdd_rad_s2.map(|x| k * x),
                ..knot
            };
            trajectory(&[part(a), part(b), rest(4.0, 0.0)])
        };
        let (mut low, mut high) = (0.0_f32, 1.0_f32);
        for _ in 0..12 {
            let k = 0.5 * (low + high);
            if scaled(k).check(&LIMITS).is_ok() { low = k } else { high = k }
        }
        let s = scaled(low).sample(at).unwrap();
        for (j, max) in ARM_ACCELERATION_MAX_RAD_S2.iter().enumerate() {
            // Between two of the instants looked at a quintic rises at most a little higher.
            prop_assert!(s.q_rad[j].abs() < 2.01 && s.qd_rad_s[j].abs() < 1.51);
            prop_assert!(s.qdd_rad_s2[j].abs() < 1.01 * max);
        }
    }

    #[test]
    fn any_bits_are_sampled_and_checked_without_panic(bits in prop::collection::vec(any::<u32>(), 44), at in any::<u32>()) {
        let number = |i: usize| f32::from_bits(bits[i % bits.len()]);
        let knot = |k: usize| Knot {
            t_s: number(22 * k),
            q_rad: core::array::from_fn(|j| number(22 * k + 1 + j)),
            qd_rad_s: core::array::from_fn(|j| number(22 * k + 8 + j)),
            qdd_rad_s2: core::array::from_fn(|j| number(22 * k + 15 + j)),
        };
        let t = trajectory(&[knot(0), knot(1)]);
        let _ = t.check(&LIMITS);
        prop_assert!(t.sample(f32::from_bits(at)).is_some());
    }

    #[test]
    fn postcard_carries_it_unchanged(a in any_knot(0.0), b in any_knot(0.8)) {
        let t = trajectory(&[a, b]);
        let mut buffer = [0; 256];
        let bytes = postcard::to_slice(&t, &mut buffer).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Trajectory>(bytes).unwrap(), t);
    }
}

#[test]
fn a_full_trajectory_fits_the_largest_payload() {
    let mut t = good();
    t.request = u16::MAX;
    t.knots = core::iter::repeat_n(rest(1.0, 1.0), KNOTS_MAX).collect();
    let mut buffer = [0; crate::limits::PAYLOAD_BYTES_MAX];
    let len = postcard::to_slice(&t, &mut buffer).unwrap().len();
    assert_eq!(len, KNOTS_MAX * 88 + 3 + 1 + 1);
}

#[test]
fn a_list_longer_than_the_capacity_is_refused_by_the_decoder() {
    let mut bytes = [0_u8; 8 + 49 * 88];
    bytes[1] = KNOTS_MAX as u8 + 1; // request, then the length
    assert!(postcard::from_bytes::<Trajectory>(&bytes).is_err());
}

#[test]
fn outside_its_time_the_arm_rests_at_the_ends() {
    let t = good();
    assert_eq!(t.sample(-1.0).unwrap(), Sample { q_rad: [0.0; 7], ..Sample::default() });
    assert_eq!(t.sample(9.0).unwrap(), Sample { q_rad: [-0.2; 7], ..Sample::default() });
    assert_eq!(t.duration(), 3.0);
    assert_eq!(Trajectory::default().sample(0.0), None);
}

#[test]
fn the_guarded_part_starts_at_its_knot_or_nowhere() {
    let mut t = good();
    assert_eq!(t.guarded_from_s(), None);
    t.guarded_from = 1;
    assert_eq!(t.guarded_from_s(), Some(1.5));
    t.guarded_from = 2; // the last knot starts no segment
    assert_eq!(t.guarded_from_s(), None);
}

#[test]
fn a_good_trajectory_passes() {
    assert_eq!(good().check(&LIMITS), Ok(()));
}

#[test]
fn each_fault_is_refused_by_its_name() {
    let fault = |spoil: fn(&mut Trajectory)| {
        let mut t = good();
        spoil(&mut t);
        t.check(&LIMITS).unwrap_err()
    };
    assert_eq!(fault(|t| t.knots.clear()), TrajectoryError::Empty);
    assert_eq!(fault(|t| t.knots[1].qd_rad_s[3] = f32::NAN), TrajectoryError::NotFinite { knot: 1 });
    assert_eq!(fault(|t| t.knots[2].t_s = f32::INFINITY), TrajectoryError::NotFinite { knot: 2 });
    assert_eq!(fault(|t| t.knots[0].t_s = 0.1), TrajectoryError::LateStart);
    assert_eq!(fault(|t| t.knots[2].t_s = 1.5), TrajectoryError::Time { knot: 2 });
    assert_eq!(fault(|t| t.knots[2].t_s = 31.0), TrajectoryError::Time { knot: 2 });
    assert_eq!(fault(|t| t.knots[0].q_rad[6] = -2.1), TrajectoryError::Position { knot: 0, joint: 6 });
    assert_eq!(fault(|t| t.knots[1].qd_rad_s[2] = 1.6), TrajectoryError::Velocity { knot: 0, joint: 2 });
    assert_eq!(fault(|t| t.knots[1].qdd_rad_s2[1] = 3.1), TrajectoryError::Acceleration { knot: 0, joint: 1 });
    assert_eq!(fault(|t| t.knots[2].qd_rad_s[4] = 0.1), TrajectoryError::NoRest { joint: 4 });
    assert_eq!(fault(|t| t.knots[2].qdd_rad_s2[5] = 0.1), TrajectoryError::NoRest { joint: 5 });
}

#[test]
fn a_fault_between_two_good_knots_is_seen() {
    let mut fast = trajectory(&[rest(0.0, -1.9), rest(2.0, 1.9)]);
    assert_eq!(fast.check(&LIMITS), Err(TrajectoryError::Acceleration { knot: 0, joint: 1 }));
    fast.knots[1].t_s = 4.0; // peak speed 1.875 * 3.8 / 4 = 1.78
    assert_eq!(fast.check(&LIMITS), Err(TrajectoryError::Velocity { knot: 0, joint: 0 }));
    fast.knots[1].t_s = 5.0;
    assert_eq!(fast.check(&LIMITS), Ok(()));
}
