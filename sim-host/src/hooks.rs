//! What system tests may do to the wire between world and controller. A mission that people run has [`Hooks::NONE`].

use tactus_common::can::CanFrame;
use tactus_hil::virtual_bus::Faults;

/// Whom a frame is about to reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// The controller.
    Controller,
    /// The world's end.
    World,
}

/// A frame that the bus has carried and its receiver has not seen yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passing {
    /// The world's tick.
    pub tick: u32,
    /// Its receiver.
    pub to: To,
    /// The frame.
    pub frame: CanFrame,
}

/// Decides what arrives instead of a frame: what it pushes, in that order. It sees every frame, so it may also only
/// watch.
pub type Tamper = Box<dyn FnMut(&Passing, &mut Vec<CanFrame>)>;

/// What is done to the wire.
pub struct Hooks {
    /// Faults of the virtual bus.
    pub faults: Faults,
    /// Someone between the bus and its receivers.
    pub tamper: Option<Tamper>,
}

impl Hooks {
    /// Nothing is done.
    pub const NONE: Self = Self { faults: Faults::NONE, tamper: None };

    /// What arrives instead of a frame.
    pub(crate) fn pass(&mut self, tick: u32, to: To, frame: CanFrame) -> Vec<CanFrame> {
        let Some(tamper) = &mut self.tamper else { return vec![frame] };
        let mut arrived = Vec::new();
        tamper(&Passing { tick, to, frame }, &mut arrived);
        arrived
    }
}
