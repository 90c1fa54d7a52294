//! Monte Carlo study: finding an object by touch in a kinematic world with noise.
//!
//! `TOUCH_STUDY_COUNT=500 cargo test --release -p tactus-controller --test touch_study -- --nocapture`
//!
//! The world has the same hand, but an object of slightly different size, joint and arm noise, late onsets, and the object
//! gives way to every finger. Policy: choose, touch, update, until confident or six touches. Default: a small count.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::time::Instant;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::{HandLink, hand_prism};
use tactus_common::shape::{Hull, ObjectShape};
use tactus_controller::belief::{Belief, Prior, Readiness, Tolerance};
use tactus_controller::evidence::{ContactKind, EvidenceStore, Toucher};
use tactus_controller::touch::{Chooser, TouchHistory, TouchPlan};
use tactus_controller::update::{Progress, Update, UpdateConfig};
use tactus_controller::work::Work;

const TOUCHES_MAX: usize = 6;

/// What is wrong with the world, one-sided ranges or standard deviations.
#[derive(Clone, Copy)]
struct Noise {
    joint_rad: f32,
    arm_m: f32,
    arm_rad: f32,
    /// Depth at onset, metres, uniform between these.
    late_m: [f32; 2],
    /// Share of contacts that are late by 2-5 mm.
    very_late: f32,
    /// Half extents are off by at most this, metres.
    size_m: f32,
    /// The box gives way by at most this per finger, metres.
    shift_m: f32,
    /// A finger that lands ends the touch; else it is opened fully and the hand goes on down.
    landing_ends: bool,
}

const NOISE: Noise = Noise {
    joint_rad: 0.0006,
    arm_m: 0.2e-3,
    arm_rad: 0.0005,
    late_m: [0.3e-3, 0.9e-3],
    very_late: 0.0,
    size_m: 0.5e-3,
    shift_m: 0.15e-3,
    landing_ends: true,
};

/// Splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn uniform(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 40) as f32 / (1u64 << 24) as f32)
    }
    fn sign(&mut self, half: f32) -> f32 {
        self.uniform(-half, half)
    }
    fn normal(&mut self, sigma: f32) -> f32 {
        // Sum of twelve uniforms.
        sigma * ((0..12).map(|_| self.uniform(0.0, 1.0)).sum::<f32>() - 6.0)
    }
}

struct World {
    pose: PlanarPose,
    shape: ObjectShape,
    noise: Noise,
    random: Random,
    landings: usize,
}

impl World {
    /// Separation of a finger, and the direction in which it pushes the box (world, horizontal).
    fn finger(&self, world_from_hand: &Isometry3<f32>, angles: &HandAngles, finger: usize) -> (f32, Vector3<f32>) {
        let object_from_world = self.pose.isometry(self.shape.rest_height_m()).inverse();
        let poses = hand::link_poses(world_from_hand, angles);
        let mut nearest = (f32::MAX, Vector3::zeros());
        for link in HandLink::ALL.iter().filter(|l| l.finger() == Some(finger)) {
            let pose = object_from_world * poses[link.index()];
            let s = self.shape.separation(&pose, hand_prism(*link)).expect("finite");
            if s.distance_m < nearest.0 {
                nearest = (s.distance_m, -(object_from_world.rotation.inverse() * s.normal_object));
            }
        }
        nearest
    }

    fn measured(&mut self, angles: &HandAngles) -> HandAngles {
        let sigma = self.noise.joint_rad;
        let inner = angles.inner_rad.map(|q| q + self.random.normal(sigma));
        HandAngles::engaged(inner, angles.spread_rad + self.random.normal(sigma))
    }

    /// Carries out a touch; everything that is felt goes into the store.
    fn touch(&mut self, plan: &TouchPlan, believed: &PlanarPose, model: &ObjectShape, store: &mut EvidenceStore) {
        store.begin_touch();
        let nominal = plan.world_from_hand(believed, model);
        let (m, r) = (self.noise.arm_m, self.noise.arm_rad);
        let slip = Isometry3::from_parts(
            Translation3::new(self.random.normal(m), self.random.normal(m), self.random.normal(m)),
            UnitQuaternion::new(Vector3::new(self.random.normal(r), self.random.normal(r), self.random.normal(r))),
        );
        let origin = Isometry3::from(nominal.translation);
        let real = origin * slip * origin.inverse() * nominal;
        let (mut inner, mut closes) = (plan.preopen_rad, plan.closes);
        // Guarded descent: a finger that lands is opened fully and the hand goes on.
        for _ in 0..3 {
            let angles = HandAngles::engaged(inner, plan.spread_rad);
            let deepest = (0..3).map(|f| (self.finger(&real, &angles, f).0, f)).min_by(|a, b| a.0.total_cmp(&b.0));
            let (depth, finger) = deepest.expect("three fingers");
            if depth > -1e-4 {
                break;
            }
            self.landings += 1;
            let (mut low, mut high) = (0.0_f32, 0.3_f32);
            for _ in 0..20 {
                let middle = 0.5 * (low + high);
                let raised = Translation3::new(0.0, 0.0, middle) * real;
                if self.finger(&raised, &angles, finger).0 < 0.0 { low = middle } else { high = middle }
            }
            let late = self.random.uniform(0.0, 1e-3);
            let seen = Translation3::new(0.0, 0.0, high - late) * nominal;
            let measured = self.measured(&angles);
            let _ = store.add_contact(&seen, &measured, Toucher::Finger(finger), ContactKind::Landing);
            if inner[finger] == 0.0 || self.noise.landing_ends {
                let clear = std::array::from_fn(|f| {
                    self.finger(&(Translation3::new(0.0, 0.0, high) * real), &angles, f).0 > 1e-3
                });
                let _ = store.add_free(&seen, &measured, clear);
                return;
            }
            inner[finger] = 0.0;
            closes[finger] = false;
        }
        let angles = HandAngles::engaged(inner, plan.spread_rad);
        let measured = self.measured(&angles);
        let _ = store.add_free(&nominal, &measured, [true; 3]);
        // All fingers close together; which one meets the object first depends on where it stands.
        for finger in [0, 1, 2] {
            if closes[finger] {
                self.close(&real, &nominal, &mut inner, plan.spread_rad, finger, store);
            }
        }
    }

    fn close(
        &mut self,
        real: &Isometry3<f32>,
        nominal: &Isometry3<f32>,
        inner: &mut [f32; 3],
        spread_rad: f32,
        finger: usize,
        store: &mut EvidenceStore,
    ) {
        let start = HandAngles::engaged(*inner, spread_rad);
        let late_m = if self.random.uniform(0.0, 1.0) < self.noise.very_late {
            self.random.uniform(2e-3, 5e-3)
        } else {
            self.random.uniform(self.noise.late_m[0], self.noise.late_m[1])
        };
        loop {
            inner[finger] += 0.001;
            if inner[finger] > 2.0 {
                let measured = self.measured(&start);
                let _ = store.add_free_sweep(nominal, &measured, finger, 2.0);
                inner[finger] = start.inner_rad[finger];
                return;
            }
            let angles = HandAngles::engaged(*inner, spread_rad);
            let (distance_m, push) = self.finger(real, &angles, finger);
            if distance_m < -late_m {
                let measured = self.measured(&angles);
                let _ = store.add_contact(nominal, &measured, Toucher::Finger(finger), ContactKind::Closing);
                let shift_m = self.random.uniform(0.0, self.noise.shift_m);
                self.pose.x_m += push.x * shift_m;
                self.pose.y_m += push.y * shift_m;
                self.pose.phi_rad += self.random.sign(shift_m / 0.1);
                return;
            }
        }
    }
}

#[derive(Default)]
struct Outcome {
    position_m: f32,
    yaw_rad: f32,
    touches: usize,
    confident: bool,
    /// Error less the reported 99 % half width, beyond which the belief is confidently wrong.
    excess_m: f32,
    /// The truth is within the reported 99 % half widths.
    covered: bool,
    landings: usize,
    evaluations: Vec<u16>,
    update_s: Vec<f64>,
    choose_s: Vec<f64>,
    last: Option<Readiness>,
    after: Vec<bool>,
}

/// The shape with each of its dimensions off by at most `by_m`, metres.
fn perturbed(shape: &ObjectShape, by_m: f32, random: &mut Random) -> ObjectShape {
    match shape {
        ObjectShape::Cuboid { half_extents_m } => {
            ObjectShape::Cuboid { half_extents_m: half_extents_m.map(|h| h + random.sign(by_m)) }
        }
        ObjectShape::Cylinder { radius_m, half_height_m } => ObjectShape::Cylinder {
            radius_m: radius_m + random.sign(by_m),
            half_height_m: half_height_m + random.sign(by_m),
        },
        ObjectShape::Sphere { radius_m } => ObjectShape::Sphere { radius_m: radius_m + random.sign(by_m) },
        ObjectShape::Capsule { radius_m, half_length_m } => ObjectShape::Capsule {
            radius_m: radius_m + random.sign(by_m),
            half_length_m: half_length_m + random.sign(by_m),
        },
        ObjectShape::Convex(hull) => {
            let half_m = hull.half_extents_m();
            let [wider, higher] = [half_m[0], half_m[2]].map(|half_m| 1.0 + random.sign(by_m) / half_m);
            let corners_m: Vec<_> =
                hull.corners_m().iter().map(|[x, y, z]| [x * wider, y * wider, z * higher]).collect();
            ObjectShape::Convex(Hull::new(&corners_m, hull.faces()).expect("still convex"))
        }
    }
}

fn trial(seed: u64, model: ObjectShape, offset: Interval, noise: Noise) -> Outcome {
    let mut random = Random(seed.wrapping_mul(0x1234_5678_9abc_def1));
    let truth =
        PlanarPose::new(random.uniform(0.0, 0.3), random.uniform(-0.2, 0.0), random.sign(core::f32::consts::FRAC_PI_4));
    let guess = PlanarPose::new(
        truth.x_m + random.sign(offset.x_m),
        truth.y_m + random.sign(offset.y_m),
        truth.phi_rad + random.sign(offset.phi_rad),
    );
    let shape = perturbed(&model, noise.size_m, &mut random);
    let mut world = World { pose: truth, shape, noise, random, landings: 0 };
    let prior = Prior::new(&guess, &offset, &model);
    let mut belief = Belief::from_prior(&prior);
    let mut store = EvidenceStore::new(model.top_height_m());
    let mut history = TouchHistory::default();
    let mut outcome = Outcome::default();
    let tolerance = Tolerance::of(&model);
    let verbose = std::env::var("TOUCH_STUDY_SEED").is_ok();
    for _ in 0..TOUCHES_MAX {
        let begun = Instant::now();
        let mut chooser = Chooser::new(&belief, &prior, &history);
        let choice = chooser.step(&mut Work::unlimited()).expect("no end of work")[0];
        outcome.choose_s.push(begun.elapsed().as_secs_f64());
        history.note(choice.plan.id, &belief.pose());
        world.touch(&choice.plan, &belief.pose(), &model, &mut store);
        let begun = Instant::now();
        let mut update = Update::new(&prior, &belief, &UpdateConfig::default());
        assert_eq!(update.step(&mut Work::unlimited(), &store), Progress::Done);
        belief = update.belief().clone();
        outcome.update_s.push(begun.elapsed().as_secs_f64());
        outcome.evaluations.push(update.stats().evaluations);
        outcome.touches += 1;
        let (dx, dy) = (belief.pose().x_m - world.pose.x_m, belief.pose().y_m - world.pose.y_m);
        outcome.position_m = libm::sqrtf(dx * dx + dy * dy);
        outcome.yaw_rad = belief.pose().turn_from_rad(&world.pose, model.yaw_symmetry_rad()).abs();
        let ready = belief.readiness(&tolerance);
        outcome.last = Some(ready);
        outcome.after.push(outcome.position_m <= 3e-3 && outcome.yaw_rad <= 1.5_f32.to_radians());
        if verbose {
            println!(
                "touch {} id {} gain {:.2} landings {:.2}: error {:.2} mm {:.2} deg, 99 % {:.2} mm {:.2} deg, {ready:?}, modes {} evals {} chi2 {:.1} {:?}",
                outcome.touches,
                choice.plan.id,
                choice.gain,
                choice.landings,
                outcome.position_m * 1e3,
                outcome.yaw_rad.to_degrees(),
                belief.half_widths_99().0 * 1e3,
                belief.half_widths_99().1.to_degrees(),
                belief.modes().len(),
                update.stats().evaluations,
                update.stats().error,
                belief.residuals(),
            );
        }
        if ready == Readiness::Ready {
            outcome.confident = true;
            break;
        }
    }
    outcome.excess_m = outcome.position_m - belief.half_widths_99().0;
    let (half_m, half_rad) = belief.half_widths_99();
    outcome.covered = outcome.position_m <= half_m && outcome.yaw_rad <= half_rad;
    outcome.landings = world.landings;
    outcome
}

fn quantile<T: PartialOrd + Copy>(values: &mut [T], q: f32) -> T {
    values.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
    values[((values.len() - 1) as f32 * q) as usize]
}

struct Summary {
    good: f32,
    within_2_mm: f32,
    fine: f32,
    touches: f32,
    confidently_wrong: f32,
}

fn study(name: &str, model: ObjectShape, offset: Interval, noise: Noise, count: u64) -> Summary {
    let first = std::env::var("TOUCH_STUDY_SEED").ok().and_then(|s| s.parse().ok());
    let seeds = first.map_or(0..count, |s: u64| s..s + 1);
    let outcomes: Vec<(u64, Outcome)> = seeds.map(|seed| (seed, trial(seed + 1, model, offset, noise))).collect();
    let n = outcomes.len() as f32;
    let share = |f: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|(_, o)| f(o)).count() as f32 / n;
    let within = |o: &Outcome, mm: f32, deg: f32| o.position_m <= mm * 1e-3 && o.yaw_rad.to_degrees() <= deg;
    let good = share(&|o| within(o, 3.0, 1.5));
    let within_2_mm = share(&|o| within(o, 2.0, 180.0));
    let fine = share(&|o| within(o, 1.5, 1.0));
    // Declared confident, and more than 3 mm outside the region that it reported.
    let confidently_wrong = share(&|o| o.confident && (o.excess_m > 3e-3 || !within(o, 6.0, 3.0)));
    let touches = outcomes.iter().map(|(_, o)| o.touches as f32).sum::<f32>() / n;
    let mut position: Vec<f32> = outcomes.iter().map(|(_, o)| o.position_m * 1e3).collect();
    let mut yaw: Vec<f32> = outcomes.iter().map(|(_, o)| o.yaw_rad.to_degrees()).collect();
    let mut evaluations: Vec<u16> = outcomes.iter().flat_map(|(_, o)| o.evaluations.clone()).collect();
    let mut update: Vec<f64> = outcomes.iter().flat_map(|(_, o)| o.update_s.clone()).map(|s| s * 1e3).collect();
    let mut choose: Vec<f64> = outcomes.iter().flat_map(|(_, o)| o.choose_s.clone()).map(|s| s * 1e3).collect();
    println!(
        "{name}: n {n}, within 2 mm {:.1} %, within 3 mm and 1.5 deg {:.1} %, within 1.5 mm and 1 deg {:.1} %, not confident {:.1} %, confidently wrong {:.1} %",
        within_2_mm * 100.0,
        good * 100.0,
        fine * 100.0,
        share(&|o| !o.confident) * 100.0,
        confidently_wrong * 100.0
    );
    println!(
        "  error median / 95 %: {:.2} / {:.2} mm, {:.2} / {:.2} deg; touches {touches:.2}, landings {:.2}; evaluations {} / {}, update {:.2} / {:.2} ms, choice {:.2} / {:.2} ms",
        quantile(&mut position, 0.5),
        quantile(&mut position, 0.95),
        quantile(&mut yaw, 0.5),
        quantile(&mut yaw, 0.95),
        outcomes.iter().map(|(_, o)| o.landings as f32).sum::<f32>() / n,
        quantile(&mut evaluations, 0.5),
        quantile(&mut evaluations, 0.95),
        quantile(&mut update, 0.5),
        quantile(&mut update, 0.95),
        quantile(&mut choose, 0.5),
        quantile(&mut choose, 0.95),
    );
    let after = |k: usize| share(&|o| o.after.get(k).or(o.after.last()).copied().unwrap_or(false)) * 100.0;
    println!("  within the reported 99 % region: {:.1} %", share(&|o| o.covered) * 100.0);
    println!("  right after 1..4 touches: {:.0} {:.0} {:.0} {:.0} %", after(0), after(1), after(2), after(3));
    for (seed, o) in outcomes.iter().filter(|(_, o)| !within(o, 3.0, 1.5) || !o.confident).take(12) {
        println!(
            "  seed {seed}: {:.1} mm {:.1} deg, confident {}, {} touches, {:?}",
            o.position_m * 1e3,
            o.yaw_rad.to_degrees(),
            o.confident,
            o.touches,
            o.last
        );
    }
    Summary { good, within_2_mm, fine, touches, confidently_wrong }
}

fn count(default: u64) -> u64 {
    std::env::var("TOUCH_STUDY_COUNT").ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

#[test]
fn a_small_offset_is_found_within_three_touches() {
    let s = study("small", ObjectShape::THESIS_BOX, Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 }, NOISE, count(40));
    assert!(s.good >= 0.95 && s.touches <= 3.0 && s.confidently_wrong <= 0.03 && s.fine > 0.8);
}

#[test]
fn a_big_offset_is_found_within_four_touches() {
    let s = study("big", ObjectShape::THESIS_BOX, Interval { x_m: 0.10, y_m: 0.10, phi_rad: 0.78 }, NOISE, count(40));
    assert!(s.good >= 0.9 && s.touches <= 4.0 && s.confidently_wrong <= 0.05);
}

#[test]
fn contacts_that_are_very_late_now_and_then_rarely_deceive() {
    let noise = Noise { very_late: 0.05, ..NOISE };
    let s = study("late", ObjectShape::THESIS_BOX, Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 }, noise, count(40));
    assert!(s.good >= 0.85 && s.confidently_wrong <= 0.1);
}

#[test]
fn other_shapes_are_found_to_two_millimetres() {
    for (name, shape) in [
        ("cylinder", ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.08 }),
        ("hexagonal prism", ObjectShape::Convex(Hull::regular_prism(6, 0.0577, 0.075).expect("convex"))),
        ("tall thin box", ObjectShape::Cuboid { half_extents_m: [0.03, 0.03, 0.15] }),
    ] {
        let s = study(name, shape, Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 }, NOISE, count(40));
        assert!(s.within_2_mm >= 0.95 && s.confidently_wrong <= 0.03, "{name}");
    }
}

/// Which error of the model hurts: `cargo test --release --test touch_study sensitivity -- --ignored --nocapture`.
#[test]
#[ignore = "a table to read, not a promise"]
fn sensitivity() {
    let small = Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 };
    for (name, noise) in [
        ("arm 0.5 mm", Noise { arm_m: 0.5e-3, ..NOISE }),
        ("arm 1 mm", Noise { arm_m: 1.0e-3, ..NOISE }),
        ("size +-1 mm a side", Noise { size_m: 1.0e-3, ..NOISE }),
        ("gives way 0.5 mm a finger", Noise { shift_m: 0.5e-3, ..NOISE }),
        ("gives way 1 mm a finger", Noise { shift_m: 1.0e-3, ..NOISE }),
        ("late by 0.5-1.5 mm", Noise { late_m: [0.5e-3, 1.5e-3], ..NOISE }),
        ("early, exact", Noise { late_m: [0.0, 0.0], ..NOISE }),
        ("joints 0.2 deg", Noise { joint_rad: 0.0035, ..NOISE }),
    ] {
        study(name, ObjectShape::THESIS_BOX, small, noise, count(200));
    }
}
