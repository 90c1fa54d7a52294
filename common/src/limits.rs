//! Every capacity, period and timeout of the system, and the relations between them.

/// Length of one control tick, microseconds (500 Hz).
pub const TICK_US: u32 = 2_000;
/// Length of one control tick, seconds.
pub const TICK_S: f32 = 0.002;
/// Arm joints of the WAM.
pub const ARM_JOINTS: usize = 7;
/// Motors of the hand: F1, F2, F3, spread.
pub const HAND_MOTORS: usize = 4;
/// Fingers of the hand: F1, F2, F3.
pub const FINGERS: usize = 3;
/// Links of the hand that can touch something: the columns of a contact matrix (facts section 5.4).
pub const HAND_LINKS: usize = 9;
/// Tactile pads: three fingertips and the palm.
pub const PADS: usize = 4;
/// Cells of one tactile pad.
pub const PAD_CELLS: usize = 24;
/// Ticks between two images of one pad: 40 Hz, the real hand's fastest rate.
pub const PAD_PERIOD_TICKS: u32 = 12;
/// Most bodies beside the object that a set-up names: each may be a hull of a kilobyte.
pub const OBSTACLES_MAX: usize = 4;
/// Most knots in one trajectory: 48 x 88 B = 4.2 KiB in the controller.
pub const KNOTS_MAX: usize = 48;
/// Largest acceleration a trajectory may ask of each arm joint, rad/s^2. Ours: with the OpenRAVE velocities
/// (facts 1.2) it gives full speed in about 0.3 s and leaves more than half of the motors' torque for contact and gravity.
pub const ARM_ACCELERATION_MAX_RAD_S2: [f32; ARM_JOINTS] = [4.0, 3.0, 6.0, 6.0, 12.0, 12.0, 12.0];
/// Ticks without a sensor message after which the controller makes the robot safe.
pub const SILENCE_TICKS_MAX: u32 = 20;
/// Bytes of the largest payload that crosses the wire (a full trajectory).
pub const PAYLOAD_BYTES_MAX: usize = 4_400;

const _: () = {
    assert!(TICK_US * PAD_PERIOD_TICKS >= 24_000, "the hand scans a pad at 40 Hz at most (12 ticks: 41.7 Hz, rounded)");
    assert!(KNOTS_MAX * 88 + 64 <= PAYLOAD_BYTES_MAX, "a full trajectory must fit one transfer");
    assert!(KNOTS_MAX <= u8::MAX as usize, "knot index is one byte");
};
