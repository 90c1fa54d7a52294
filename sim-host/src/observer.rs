//! Who watches a run from the world's end of the wire: progress on a terminal, a recording, an experiment.

use crate::host::Lost;
use crate::post::Heard;
use crate::wire::Wire;
use crate::world::World;
use tactus_common::message::Setup;

/// What there is to see in one tick, once the controller has answered and before the world goes on.
pub struct Seen<'a> {
    /// The tick.
    pub tick: u32,
    /// The world at this tick: its readings and images are those that were sent.
    pub world: &'a World,
    /// What the controller was told of its mission.
    pub setup: &'a Setup,
    /// What the controller said in this tick. A mission ends once: ends that repeat are left out.
    pub heard: &'a Heard,
    /// The controller was given up in this tick.
    pub lost: Option<Lost>,
    /// What connects the two.
    pub wire: &'a dyn Wire,
}

/// Sees every tick of a run and changes nothing of it.
pub trait Observer {
    /// Sees one tick.
    ///
    /// # Errors
    /// What was seen cannot be kept; the run ends with this error.
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()>;
}

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nobody;

impl Observer for Nobody {
    fn see(&mut self, _seen: &Seen) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Two watch; the second also when the first could not keep what it saw.
pub struct Both<'a>(pub &'a mut dyn Observer, pub &'a mut dyn Observer);

impl Observer for Both<'_> {
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()> {
        let first = self.0.see(seen);
        self.1.see(seen).and(first)
    }
}
