//! Promises of slip detection, on made readings.

use super::*;
use crate::testing::{home, readings};
use proptest::prelude::*;
use tactus_common::limits::{PAD_CELLS, PAD_PERIOD_TICKS, TICK_S};
use tactus_common::random::Random;

/// Noise as the model of the hand has it at its worst: of a cell, N/cm^2, of a gauge, Nm, and of a motor, a count, radians.
const CELL_NOISE_N_CM2: f32 = 0.015;
const GAUGE_NOISE_NM: f32 = 0.002;
const MOTOR_COUNT_RAD: f32 = 1.3e-5;
/// Cells below this read 0, N/cm^2.
const CELL_THRESHOLD_N_CM2: f32 = 0.03;
/// Width of a contact's print in the rubber, metres.
const PRINT_M: f32 = 0.0025;
/// Where the middle of a pad is pressed when a flat face is held, tip frame, metres.
const PRESSED_AT_M: [f32; 3] = [0.0522, 0.0065, 0.0];

/// What a hand that holds something feels, made tick by tick.
struct Hold {
    slip: Slip,
    random: Random,
    tick: u32,
    /// Middle of the pressure on each pad, tip frame, metres.
    pressed_at_m: [Vector3<f32>; FINGERS],
    force_n: [f32; FINGERS],
    torque_nm: [f32; FINGERS],
    motor_rad: [f32; FINGERS],
}

impl Hold {
    fn new(seed: u64) -> Self {
        Self {
            slip: Slip::default(),
            random: Random::new(seed),
            tick: 0,
            pressed_at_m: [Vector3::from(PRESSED_AT_M); FINGERS],
            force_n: [4.0, 4.0, 8.0],
            torque_nm: [0.3, 0.3, 0.65],
            motor_rad: [1.05; FINGERS],
        }
    }

    /// Mean 0, standard deviation 1, light tails.
    fn normal(&mut self) -> f32 {
        (0..4).map(|_| self.random.symmetric()).sum::<f32>() * 0.866
    }

    fn image(&mut self, finger: usize) -> TactileImage {
        let mut weights = FINGERTIP_TAXELS.map(|cell| {
            let off = Vector3::from(cell.centre_m) - self.pressed_at_m[finger];
            libm::expf(-off.norm_squared() / (2.0 * PRINT_M * PRINT_M))
        });
        let covered_cm2: f32 = weights.iter().zip(&FINGERTIP_TAXELS).map(|(w, cell)| w * cell.area_m2 * 1e4).sum();
        for weight in &mut weights {
            *weight *= self.force_n[finger] / covered_cm2;
        }
        let pressure_n_cm2 = weights.map(|pressure| {
            let felt = pressure + CELL_NOISE_N_CM2 * self.normal();
            if felt < CELL_THRESHOLD_N_CM2 { 0.0 } else { felt }
        });
        TactileImage { pad: finger as u8, stamp: self.tick, pressure_n_cm2 }
    }

    /// One tick; pads in turn, as the hand scans them.
    fn feel(&mut self) -> Option<Slipping> {
        let mut r = readings(self.tick, home());
        for f in 0..FINGERS {
            r.tip_torque_nm[f] = self.torque_nm[f] + GAUGE_NOISE_NM * self.normal();
            r.motor_q_rad[f] = libm::roundf(self.motor_rad[f] / MOTOR_COUNT_RAD) * MOTOR_COUNT_RAD;
        }
        let mut images = [None; PADS];
        let turn = self.tick % PAD_PERIOD_TICKS;
        if turn.is_multiple_of(3) && turn < 9 {
            let finger = (turn / 3) as usize;
            images[finger] = Some(self.image(finger));
        }
        self.tick += 1;
        self.slip.feel(&r, &images)
    }

    /// Ticks until slip is felt, while `change` makes the hold what it is `tick` ticks from now.
    fn felt_after(&mut self, ticks: u32, change: impl Fn(&mut Self, u32)) -> Option<(u32, Slipping)> {
        (0..ticks).find_map(|tick| {
            change(self, tick);
            self.feel().map(|slipping| (tick, slipping))
        })
    }

    /// A second in which nothing moves.
    fn settle(&mut self) {
        assert_eq!(self.felt_after(500, |_, _| ()), None);
    }
}

#[test]
fn noise_alone_is_never_slip_in_ten_minutes() {
    for seed in 0..4 {
        assert_eq!(Hold::new(seed).felt_after(75_000, |_, _| ()), None, "seed {seed}");
    }
    // Pads that are hardly pressed are the noisiest that count.
    let mut light = Hold::new(4);
    light.force_n = [1.1 * PRESSED_N; FINGERS];
    assert_eq!(light.felt_after(75_000, |_, _| ()), None);
}

/// All pads are pressed at `from_m`, and from then on the pressure moves by `moved_m` within a fifth of a second.
fn slide(seed: u64, from_m: Vector3<f32>, moved_m: Vector3<f32>) -> Option<(u32, Slipping)> {
    let mut hold = Hold::new(seed);
    hold.pressed_at_m = [from_m; FINGERS];
    hold.settle();
    hold.felt_after(150, |hold, tick| {
        hold.pressed_at_m = [from_m + moved_m * (tick as f32 * TICK_S / 0.2).min(1.0); FINGERS];
    })
}

#[test]
fn a_slide_of_a_millimetre_in_a_fifth_of_a_second_is_felt_where_two_cells_share_the_pressure() {
    let between_m = Vector3::new(0.0372, 0.0092, 0.0026);
    for seed in 0..20 {
        for moved_m in [Vector3::x(), -Vector3::x(), Vector3::z(), -Vector3::z()].map(|axis| axis * 1e-3) {
            let (_, slipping) = slide(seed, between_m - 0.5 * moved_m, moved_m)
                .unwrap_or_else(|| panic!("seed {seed}: {moved_m:?} is not felt"));
            assert!(slipping.sureness >= 0.5 && slipping.sureness < 1.0, "{slipping:?}");
        }
    }
}

#[test]
fn a_slide_of_two_millimetres_is_felt_wherever_the_pad_is_pressed() {
    // In the middle of a cell its neighbours take least of the pressure: there, the centre moves by half of the slide.
    for seed in 0..20 {
        for cell in &FINGERTIP_TAXELS[10..14] {
            for moved_m in [Vector3::x(), -Vector3::x(), Vector3::z(), -Vector3::z()].map(|axis| axis * 2e-3) {
                let middle_m = Vector3::new(cell.centre_m[0], cell.centre_m[1], 0.0);
                assert!(slide(seed, middle_m, moved_m).is_some(), "seed {seed}: {moved_m:?} is not felt");
            }
        }
    }
}

#[test]
fn a_finger_whose_hold_gives_way_is_slip_within_a_tenth_of_a_second_and_named() {
    for finger in 0..FINGERS {
        let mut hold = Hold::new(7);
        hold.settle();
        let give = |hold: &mut Hold, _: u32| hold.motor_rad[finger] += 0.1 * TICK_S;
        let (ticks, slipping) = hold.felt_after(500, give).expect("felt");
        assert!(ticks < 50 && usize::from(slipping.finger) == finger, "{ticks} {slipping:?}");
    }
}

#[test]
fn a_torque_that_has_stood_still_and_changes_for_good_is_slip_and_one_that_has_not_is_a_load() {
    for step_nm in [-0.1, 0.1] {
        let change = |hold: &mut Hold, _: u32| hold.torque_nm[1] = 0.3 + step_nm;
        let mut held = Hold::new(3);
        held.settle();
        let (ticks, slipping) = held.felt_after(500, change).expect("felt");
        assert!(ticks < 30 && slipping.finger == 1, "{ticks} {slipping:?}");
        let mut lifting = Hold::new(3);
        assert_eq!(lifting.felt_after(u32::from(STILL_TICKS) / 2, |_, _| ()), None);
        assert_eq!(lifting.felt_after(500, change), None, "the weight is taken over");
    }
}

#[test]
fn a_hit_that_does_not_move_the_object_is_not_slip() {
    for seed in 0..20 {
        let mut hold = Hold::new(seed);
        hold.settle();
        // 10 ms of a hard push: every gauge, and one image of every pad, with the pressure 3 mm off.
        let hit = |hold: &mut Hold, tick: u32| {
            let hits = (100..105).contains(&tick);
            hold.torque_nm = [0.3, 0.3, 0.65].map(|nm| if hits { nm + 0.25 } else { nm });
            let shaken_m = if (100..112).contains(&tick) { 3e-3 } else { 0.0 };
            hold.pressed_at_m = [Vector3::from(PRESSED_AT_M) + Vector3::z() * shaken_m; FINGERS];
        };
        assert_eq!(hold.felt_after(1_000, hit), None, "seed {seed}");
    }
}

#[test]
fn what_was_felt_before_a_reset_is_forgotten() {
    let mut hold = Hold::new(1);
    hold.settle();
    for centre_m in &mut hold.pressed_at_m {
        centre_m.z += 3e-3;
    }
    hold.torque_nm = [0.5; FINGERS];
    hold.motor_rad = [1.1; FINGERS];
    hold.slip.reset();
    assert_eq!(hold.felt_after(5_000, |_, _| ()), None);
}

#[test]
fn a_pad_that_loses_its_contact_says_nothing() {
    let mut hold = Hold::new(2);
    hold.settle();
    let lifted = |hold: &mut Hold, _: u32| {
        hold.force_n[0] = 0.2 * PRESSED_N;
        hold.pressed_at_m[0].z = 5e-3;
    };
    assert_eq!(hold.felt_after(2_000, lifted), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_readings_and_images_give_a_finger_of_the_hand_and_a_share(
        torques in prop::collection::vec(any::<f32>().prop_filter("finite", |v| v.is_finite()), 60),
        pressures in prop::collection::vec(0.0_f32..16.0, PAD_CELLS),
    ) {
        let mut slip = Slip::default();
        for (tick, nm) in torques.iter().enumerate() {
            let mut r = readings(tick as u32, home());
            r.tip_torque_nm[tick % FINGERS] = *nm;
            let mut pressure_n_cm2 = [0.0; PAD_CELLS];
            pressure_n_cm2.copy_from_slice(&pressures);
            pressure_n_cm2.rotate_left(tick % PAD_CELLS);
            let mut images = [None; PADS];
            let pad = tick % PADS;
            images[pad] = Some(TactileImage { pad: pad as u8, stamp: tick as u32, pressure_n_cm2 });
            if let Some(slipping) = slip.feel(&r, &images) {
                prop_assert!(usize::from(slipping.finger) < FINGERS);
                prop_assert!((0.5..=1.0).contains(&slipping.sureness), "{}", slipping.sureness);
            }
        }
    }
}
