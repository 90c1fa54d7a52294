//! What lies between the world's end and the controller: a bus within this process with the controller at its other
//! end, or a bus outside, with the controller wherever it may be.

mod in_process;
mod keep_alive;
mod live;

pub use in_process::InProcess;
pub use live::Live;

use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};

/// How the controller took one tick.
#[derive(Clone, Copy, Debug)]
pub struct Answered {
    /// All that it said has come.
    pub complete: bool,
    /// How long that took: the controller's own time within this process, from readings to command on a bus outside.
    pub took: Duration,
}

/// What a wire has carried and suffered in a mission.
#[derive(Clone, Copy, Debug, Default)]
pub struct WireStats {
    /// Frames, both ways.
    pub frames: u64,
    /// Largest share of busy time in any 100 ms of a bus at 500 Hz, 0..1 (more than 1: the bus could not keep up).
    pub load_max: f32,
    /// Frames lost in queues.
    pub lost: u64,
    /// Error frames, and frames that are none of ours.
    pub foreign: u64,
    /// Times at which the bus was down.
    pub downs: u64,
}

/// The world's access to a controller.
pub trait Wire {
    /// Format of the frames to send.
    fn mtu(&self) -> Mtu;

    /// Waits until a controller is there that has no mission; a mission begins, its figures at zero. `false` if none
    /// came within `patience`.
    ///
    /// # Errors
    /// It speaks another version of the messages.
    fn meet(&mut self, patience: Duration) -> anyhow::Result<bool>;

    /// How long a missing answer is worth waiting for. Zero: what has not come will not come.
    fn patience(&self) -> Duration;

    /// Puts a frame on its way.
    ///
    /// # Errors
    /// The bus does not take it, and will not.
    fn send(&mut self, frame: CanFrame) -> anyhow::Result<()>;

    /// What was sent so far will arrive before what is sent from now on.
    fn settle(&mut self);

    /// The readings of `tick` have been sent: its period begins.
    fn begin_period(&mut self, tick: u32);

    /// Lets the controller answer, at most until `until`. Each frame that comes is given to `hear`, which says whether
    /// the answer is whole.
    ///
    /// # Errors
    /// The controller's frames cannot be put on the bus.
    fn answer(
        &mut self,
        tick: u32,
        until: Instant,
        hear: &mut dyn FnMut(&CanFrame) -> bool,
    ) -> anyhow::Result<Answered>;

    /// Does `work`, which may take long; whoever is at the other end is told that the world is still there.
    fn busy(&mut self, work: &mut dyn FnMut());

    /// Figures of this mission.
    fn stats(&self) -> WireStats;
}
