//! Slip: does the held object move in the hand?
//!
//! The real hand has no sensor for it; pads, strain gauges and finger encoders tell. What holds still in the hand is
//! felt unchanged, so every lasting change counts, each in units of what noise and loads of a firm grip can make of it:
//!
//! * **Pads**, at 40 Hz: the centre of pressure moves over the pad. While a contact sticks, each of its points carries
//!   what the squeeze has left it with; as it slides, all of them rub the same way and the pressure shares itself out
//!   anew. A flat face that slides along the pad shows itself by that alone: where it touches along the pad stays the same.
//! * **Fingertip torque**, at 500 Hz: it changes for good after having stood still. The weight that a grip takes over while
//!   the arm lifts changes it as much, therefore not before.
//! * **Finger motor**, at 500 Hz: a finger that pushes goes on closing, because what it pushed against gives way.
//!
//! What they cannot tell: a flat face that slides evenly along pads which lie square on it feels like one that stands,
//! until it comes out of the hand.
//!
//! Idea: a grip is corrected by changes of what fingertips feel, not by a friction that is known (Romano, Hsiao,
//! Niemeyer, Chitta and Kuchenbecker, *Human-inspired robotic grasp control with tactile sensing*, IEEE Transactions on
//! Robotics 27(6), 2011); an array together with a measured force or torque shows slip (Melchiorri, *Slip detection and
//! control using tactile and force sensors*, IEEE/ASME Transactions on Mechatronics 5(3), 2000).

use nalgebra::Vector3;
use tactus_common::limits::{FINGERS, PADS};
use tactus_common::reading::{JointReadings, TactileImage};
use tactus_common::robot::FINGERTIP_TAXELS;

/// Images of a pad that are compared: 12, 0.29 s. The medians of their ends are then 0.22 s apart.
const IMAGES: usize = 12;
/// Images at either end of them of which the median counts: one that a hit has shaken decides nothing.
const ENDS: usize = 3;
/// Force on a pad below which its centre of pressure says nothing, newtons. At this force noise of 0.015 N/cm^2 in nine
/// pressed cells of 26 mm^2, 6 mm from the centre, moves the centre by 0.14 mm.
const PRESSED_N: f32 = 0.5;
/// Shift of the centres of pressure of all pads (root of the sum of squares) that is slip, metres. Taking over the weight
/// tilts the fingertips: in 20 carried thesis boxes it made 0.8 mm at most, in boxes of 1.5 kg that were held 1.1 mm.
/// In nine boxes that slid, it passed 2.8 mm within 0.2 s, and this after a slide of 5 mm in the mean.
const SHIFT_M: f32 = 1.2e-3;
/// Lasting change of a fingertip torque that is slip, newton-metres: 20 times the noise of the gauge. Accelerations of
/// the arm with a load of 1.8 kg made 20 mNm of it.
const TORQUE_NM: f32 = 0.04;
/// Lasting advance of a finger motor that is slip, radians: 40 mrad/s over the baseline's time constant. A firm grip creeps
/// by a tenth of that.
const ADVANCE_RAD: f32 = 2.0e-3;
/// Shares of the newest value in what is taken for now (8 ms) and for before (50 ms).
const NOW_SHARE: f32 = 0.25;
const BEFORE_SHARE: f32 = 0.04;
/// Ticks that a change must last: 30 ms, more than a hit.
const LASTING_TICKS: u8 = 15;
/// Ticks that a torque must stand still before its changes count: 0.2 s, longer than any pause while a weight is taken over.
const STILL_TICKS: u8 = 100;

/// Something slips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slipping {
    /// The finger that feels it most: 0, 1, 2 = F1, F2, F3.
    pub finger: u8,
    /// How sure that is, 0.5 at the threshold to 1: `1 - 1 / (1 + e^2)` for the change `e` in units of the thresholds.
    pub sureness: f32,
}

/// Centres of pressure of one pad's newest images.
#[derive(Clone, Copy, Debug, Default)]
struct Centres {
    /// Oldest first, tip frame, metres; as many as `count`.
    centres_m: [Vector3<f32>; IMAGES],
    count: usize,
}

impl Centres {
    /// Takes an image.
    fn feel(&mut self, image: &TactileImage) {
        let Some(centre_m) = centre_of_pressure(image) else {
            self.count = 0;
            return;
        };
        if self.count == IMAGES {
            self.centres_m.rotate_left(1);
        } else {
            self.count += 1;
        }
        if let Some(newest) = self.count.checked_sub(1).and_then(|last| self.centres_m.get_mut(last)) {
            *newest = centre_m;
        }
    }

    /// How far the centre has moved within the images, metres; 0 while there are too few of them.
    fn shift_m(&self) -> f32 {
        let seen = self.centres_m.get(..self.count).unwrap_or_default();
        match (seen.first_chunk::<ENDS>(), seen.last_chunk::<ENDS>()) {
            (Some(oldest), Some(newest)) => (median(newest) - median(oldest)).norm(),
            _ => 0.0,
        }
    }
}

/// Median by components.
fn median([a, b, c]: &[Vector3<f32>; ENDS]) -> Vector3<f32> {
    a.sup(b).inf(&a.inf(b).sup(c))
}

/// Centre of the forces on a fingertip's cells, tip frame, metres; `None` if hardly anything presses.
fn centre_of_pressure(image: &TactileImage) -> Option<Vector3<f32>> {
    let (mut force_n, mut moment_n_m) = (0.0, Vector3::zeros());
    for (pressure_n_cm2, cell) in image.pressure_n_cm2.iter().zip(&FINGERTIP_TAXELS) {
        let cell_n = pressure_n_cm2 * 1e4 * cell.area_m2;
        force_n += cell_n;
        moment_n_m += Vector3::from(cell.centre_m) * cell_n;
    }
    (force_n >= PRESSED_N).then(|| moment_n_m / force_n)
}

/// A signal now against the same signal shortly before.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    now_and_before: Option<(f32, f32)>,
    still: u8,
    above: u8,
}

impl Change {
    /// Takes a value. The change in units of `threshold`; 0 unless it lasts, and unless the signal has once stood still for
    /// `still_ticks`, within half the threshold.
    fn feel(&mut self, value: f32, threshold: f32, still_ticks: u8) -> f32 {
        let (mut now, mut before) = self.now_and_before.unwrap_or((value, value));
        now += NOW_SHARE * (value - now);
        before += BEFORE_SHARE * (value - before);
        self.now_and_before = Some((now, before));
        let change = (now - before).abs() / threshold;
        if self.still < still_ticks {
            self.still = if change > 0.5 { 0 } else { self.still + 1 };
            return 0.0;
        }
        self.above = if change > 1.0 { (self.above + 1).min(LASTING_TICKS) } else { 0 };
        if self.above >= LASTING_TICKS { change } else { 0.0 }
    }
}

/// What one finger feels of the object.
#[derive(Clone, Copy, Debug, Default)]
struct Finger {
    pad: Centres,
    torque: Change,
    motor: Change,
}

/// Slip detection for the hand that holds something.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slip {
    fingers: [Finger; FINGERS],
}

impl Slip {
    /// Forgets what was felt: call when a hold begins and whenever the grip or the motion of the arm is changed on purpose.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Takes one tick of readings and whatever pad images came with it; what slips, if anything does.
    pub fn feel(&mut self, readings: &JointReadings, images: &[Option<TactileImage>; PADS]) -> Option<Slipping> {
        let (mut evidence, mut most, mut finger) = (0.0, 0.0, 0);
        for (f, felt) in self.fingers.iter_mut().enumerate() {
            for image in images.iter().flatten().filter(|image| usize::from(image.pad) == f) {
                felt.pad.feel(image);
            }
            let shift = felt.pad.shift_m() / SHIFT_M;
            let torque = felt.torque.feel(readings.tip_torque_nm[f], TORQUE_NM, STILL_TICKS);
            let advance = felt.motor.feel(readings.motor_q_rad[f], ADVANCE_RAD, 0);
            let own = shift * shift + torque * torque + advance * advance;
            evidence += own;
            if own > most {
                (most, finger) = (own, f as u8);
            }
        }
        (evidence >= 1.0).then(|| Slipping { finger, sureness: 1.0 - 1.0 / (1.0 + evidence) })
    }
}

#[cfg(test)]
mod tests;
