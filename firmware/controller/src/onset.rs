//! Contact onset: when does a finger, or the palm, begin to feel something?
//!
//! Every tick: fingertip torque and the bend between motor and inner link, each against its own slow baseline,
//! so that the link's weight and the sensors' offsets drop out. At 40 Hz: the tactile pads, which say where.

use tactus_common::limits::{FINGERS, PADS};
use tactus_common::reading::{JointReadings, TactileImage};

/// Rise of the fingertip torque that counts as contact, Nm: about 0.3 N at the pad, a third of what moves the lightest
/// box on the smoothest table of the expected range; seven times the sensor's noise.
const TIP_RISE_NM: f32 = 0.015;
/// Rise of the bend between motor and inner link that counts as contact, radians.
const BEND_RISE_RAD: f32 = 4.0e-4;
/// Rises that count as a knock even while the arm travels: its accelerations, up to 3 m/s^2 at the hand, make 3 mNm,
/// and the weight of a tip that turns over 19 mNm.
const TIP_KNOCK_NM: f32 = 0.06;
const BEND_KNOCK_RAD: f32 = 1.5e-3;
/// Pressure of one cell that counts as contact, N/cm^2.
const PRESSURE_N_CM2: f32 = 1.0;
/// Share of the newest value in the baseline, per tick: time constant 0.5 s. Slow enough that a contact that builds up
/// gently does not hide in it, fast enough for the weight of a tip that turns with its finger (3 mNm/s).
const BASELINE_SHARE: f32 = 0.004;
/// Ticks in a row that a rise must last.
const CONFIRM_TICKS: u8 = 2;

/// One signal against its slow baseline.
#[derive(Clone, Copy, Debug, Default)]
struct Rise {
    baseline: Option<f32>,
    above: u8,
}

impl Rise {
    /// How far `value` is above the baseline.
    fn rise(&self, value: f32) -> f32 {
        value - self.baseline.unwrap_or(value)
    }

    /// `true` once `value` has been above the baseline by `threshold` for [`CONFIRM_TICKS`].
    fn feel(&mut self, value: f32, threshold: f32) -> bool {
        let baseline = self.baseline.unwrap_or(value);
        let rise = value - baseline;
        if rise > threshold {
            self.above = (self.above + 1).min(CONFIRM_TICKS);
        } else {
            self.above = 0;
            // Only below the threshold: a contact that lasts must not become its own baseline.
            self.baseline = Some(baseline + BASELINE_SHARE * rise);
        }
        self.above >= CONFIRM_TICKS
    }
}

/// What was felt at this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Felt {
    /// Per finger F1, F2, F3: in contact.
    pub fingers: [bool; FINGERS],
    /// Palm in contact.
    pub palm: bool,
    /// Per finger: knocked against something, harder than any motion of the hand in free air can feel.
    pub knocked: [bool; FINGERS],
}

impl Felt {
    /// Anything at all?
    pub fn any(&self) -> bool {
        self.palm || self.fingers.contains(&true)
    }
}

/// Contact detection for the whole hand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Onset {
    tip: [Rise; FINGERS],
    bend: [Rise; FINGERS],
    pad_pressed: [bool; PADS],
}

impl Onset {
    /// Forgets the baselines; call when a guarded motion begins, with the hand free.
    pub fn reset(&mut self) {
        *self = Self { pad_pressed: self.pad_pressed, ..Self::default() };
    }

    /// Takes one tick of readings and whatever pad images came with it.
    pub fn feel(&mut self, readings: &JointReadings, images: &[Option<TactileImage>; PADS]) -> Felt {
        for image in images.iter().flatten() {
            if let Some(pressed) = self.pad_pressed.get_mut(usize::from(image.pad)) {
                *pressed = image.pressure_n_cm2.iter().any(|&p| p > PRESSURE_N_CM2);
            }
        }
        let mut felt = Felt { palm: self.pad_pressed[PADS - 1], ..Felt::default() };
        for f in 0..FINGERS {
            let bend_rad = readings.motor_q_rad[f] - readings.inner_q_rad[f];
            felt.knocked[f] = self.tip[f].rise(readings.tip_torque_nm[f]).abs() > TIP_KNOCK_NM
                || self.bend[f].rise(bend_rad).abs() > BEND_KNOCK_RAD;
            let tip = self.tip[f].feel(readings.tip_torque_nm[f], TIP_RISE_NM);
            let bend = self.bend[f].feel(bend_rad, BEND_RISE_RAD);
            felt.fingers[f] = tip || bend || self.pad_pressed[f];
        }
        felt
    }
}

#[cfg(test)]
mod tests;
