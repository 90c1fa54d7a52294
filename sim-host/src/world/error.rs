//! What can go wrong with a simulated world.

/// Why a world cannot be built or cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// Two bodies overlap before the first step, so that the simulation would start with an explosion.
    #[error("`{a}` and `{b}` overlap by {:.1} mm at the start; move the object, the arm or the hand apart", .depth_m * 1e3)]
    Interpenetration {
        /// The one body.
        a: String,
        /// The other body.
        b: String,
        /// How deep they overlap, metres.
        depth_m: f32,
    },
    /// A body's state is no longer a finite number.
    #[error("the state of `{body}` is not finite at tick {tick}: the simulation diverged")]
    NonFinite {
        /// The body.
        body: String,
        /// The tick after which it was noticed.
        tick: u32,
    },
    /// The robot description cannot be used.
    #[error("robot description: {0}")]
    Model(String),
    /// The scene asks for something impossible.
    #[error("scene: {what} is {value}, expected {expected}")]
    Scene {
        /// Which quantity.
        what: String,
        /// Its value.
        value: String,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A command that is not a finite number, or of a value outside what the drives accept.
    #[error("command for {drive} at tick {tick} is not finite")]
    Command {
        /// Which drive.
        drive: &'static str,
        /// At which tick.
        tick: u32,
    },
    /// A snapshot that this world did not make.
    #[error("snapshot cannot be restored: {0}")]
    Snapshot(String),
}
