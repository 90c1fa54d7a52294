//! The whole controller: a mission from its set-up to the object at its goal, one call a tick.

use crate::event::TactusEvent;
use crate::geometry::TactusBelief;
use crate::handle::{Handled, Plain, array, exclusive, needed, optional, place, put, shared};
use crate::plan::{TactusPlanAnswer, TactusPlanRequest};
use crate::result::{TactusResult, answer};
use crate::robot::{TACTUS_PADS, TactusCommands, TactusImage, TactusReadings};
use crate::rollout::{TactusRollout, TactusRolloutRequest};
use crate::setup::{TactusOutcome, TactusPhase, TactusSetup};
use core::ffi::c_void;
use tactus_common::message::{PlanAnswer, RefusalReason, Setup};
use tactus_controller::controller::{Controller, EVENTS_MAX, Inputs, Outputs};
use tactus_controller::mission::Mission;

/// Bytes that are enough for a controller on every target; `tactus_controller_size` says how many one takes here.
pub const TACTUS_CONTROLLER_SIZE: usize = 53248;
/// `TACTUS_CONTROLLER_SIZE` in words of 64 bits.
pub const TACTUS_CONTROLLER_WORDS: usize = 6656;
/// Alignment that a controller's memory needs, bytes.
pub const TACTUS_CONTROLLER_ALIGN: usize = 8;
/// Most events of one tick.
pub const TACTUS_EVENTS_MAX: usize = 8;

const _: () = {
    assert!(<State as Handled>::BYTES <= TACTUS_CONTROLLER_SIZE, "raise TACTUS_CONTROLLER_SIZE");
    assert!(<State as Handled>::ALIGN <= TACTUS_CONTROLLER_ALIGN, "raise TACTUS_CONTROLLER_ALIGN");
    assert!(size_of::<TactusControllerMemory>() == TACTUS_CONTROLLER_SIZE);
    assert!(align_of::<TactusControllerMemory>() == TACTUS_CONTROLLER_ALIGN);
    assert!(TACTUS_EVENTS_MAX == EVENTS_MAX);
};

/// A controller; lives in memory of yours, from `tactus_controller_create` on.
pub struct TactusController {
    _only_a_name: (),
}

/// Memory for one controller, static or part of a struct of yours; too large for most stacks. Its content is not
/// yours: `tactus_controller_create` gives the handle.
#[repr(C)]
pub struct TactusControllerMemory {
    /// Not to be used.
    pub words: [u64; TACTUS_CONTROLLER_WORDS],
}

/// What is behind a [`TactusController`].
struct State {
    controller: Controller,
    begun: Option<Setup>,
    /// Where a planner's answer is put together: static memory instead of the stack of every tick.
    answer: PlanAnswer,
}

impl Handled for State {
    /// "TacC".
    const MARK: u32 = u32::from_le_bytes(*b"TacC");
    type Opaque = TactusController;
}

/// What came in since the last tick. Everything may be missing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusInputs {
    /// Joint readings; NULL if none came. After `TACTUS_SILENCE_TICKS_MAX` ticks without, the controller lets go.
    pub readings: *const TactusReadings,
    /// New images of the pads, `image_count` of them, each of another pad.
    pub images: *const TactusImage,
    /// The planner's answer, or NULL.
    pub plan: *const TactusPlanAnswer,
    /// The simulation's answer, or NULL.
    pub rollout: *const TactusRollout,
    /// Number of images, at most `TACTUS_PADS`.
    pub image_count: u32,
}

// SAFETY: numbers, and pointers that are checked before use.
unsafe impl Plain for TactusInputs {}

/// What goes out after a tick.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusOutputs {
    /// Joint commands.
    pub commands: TactusCommands,
    /// A question to the planner, if `has_plan_request`.
    pub plan_request: TactusPlanRequest,
    /// A question to the simulation, if `has_rollout_request`.
    pub rollout_request: TactusRolloutRequest,
    /// What happened, `event_count` entries; the rest is empty.
    pub events: [TactusEvent; TACTUS_EVENTS_MAX],
    /// Number of events.
    pub event_count: u32,
    /// Is there a question to the planner?
    pub has_plan_request: bool,
    /// Is there a question to the simulation?
    pub has_rollout_request: bool,
    /// Ten times a second: time to report status (`tactus_controller_belief`).
    pub status_due: bool,
    /// Phase of the mission after this tick.
    pub phase: TactusPhase,
    /// How the mission ended, if it did.
    pub outcome: TactusOutcome,
}

impl TactusOutputs {
    /// Commands that do nothing, and nothing to say.
    fn idle() -> Self {
        Self {
            commands: TactusCommands::default(),
            plan_request: TactusPlanRequest::default(),
            rollout_request: TactusRolloutRequest::default(),
            events: [TactusEvent::NONE; TACTUS_EVENTS_MAX],
            event_count: 0,
            has_plan_request: false,
            has_rollout_request: false,
            status_due: false,
            phase: TactusPhase::Initialise,
            outcome: TactusOutcome::NOT_YET,
        }
    }

    fn fill(&mut self, said: &Outputs, controller: &Controller) {
        self.commands = (&said.commands).into();
        if let Some(request) = &said.plan_request {
            self.plan_request = request.into();
            self.has_plan_request = true;
        }
        if let Some(request) = &said.rollout_request {
            self.rollout_request = request.into();
            self.has_rollout_request = true;
        }
        for (slot, event) in self.events.iter_mut().zip(&said.events) {
            *slot = event.into();
            self.event_count += 1;
        }
        self.status_due = said.status.is_some();
        self.phase = controller.phase().into();
        self.outcome = controller.outcome().into();
    }
}

/// Bytes that a controller takes on this target, at most `TACTUS_CONTROLLER_SIZE`.
#[unsafe(no_mangle)]
pub extern "C" fn tactus_controller_size() -> usize {
    <State as Handled>::BYTES
}

/// Alignment that a controller's memory needs on this target, bytes, at most `TACTUS_CONTROLLER_ALIGN`.
#[unsafe(no_mangle)]
pub extern "C" fn tactus_controller_align() -> usize {
    <State as Handled>::ALIGN
}

/// Makes a controller in your memory. There is nothing to destroy: when the handle is not used any more, the memory is
/// yours again.
///
/// `memory` has `memory_bytes` bytes (`TACTUS_CONTROLLER_SIZE` are enough) and is aligned to
/// `TACTUS_CONTROLLER_ALIGN`; it must not move while the handle is in use. `controller` receives the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_create(
    memory: *mut c_void,
    memory_bytes: usize,
    controller: *mut *mut TactusController,
) -> TactusResult {
    let write = |state: *mut State| {
        // SAFETY: `place` gives room for a state; nothing that was there needs a drop.
        unsafe {
            (&raw mut (*state).controller).write(Controller::default());
            (&raw mut (*state).begun).write(None);
            (&raw mut (*state).answer.effective).write(0);
            (&raw mut (*state).answer.request).write(0);
            (&raw mut (*state).answer.result).write(Err(RefusalReason::NoPath));
        }
    };
    // SAFETY: the header's contract for both pointers.
    answer(unsafe {
        put(controller, core::ptr::null_mut())
            .and_then(|()| place(memory, memory_bytes, write))
            .and_then(|handle| put(controller, handle))
    })
}

/// Begins a mission at the next tick and forgets any before it.
///
/// `TACTUS_RESULT_BAD_VALUE` if it makes no sense: not finite, half extents of 0, anything beyond 10 m or 10 kg, no
/// touch allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_begin(
    controller: *mut TactusController,
    setup: *const TactusSetup,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { exclusive::<State>(controller) }.and_then(|state| {
        // SAFETY: as above.
        let setup = unsafe { needed(setup) }?.to_rust()?;
        Mission::check(&setup).map_err(|_| TactusResult::BadValue)?;
        state.begun = Some(setup);
        Ok(())
    }))
}

/// One tick. Call it every `TACTUS_TICK_US`, also when no readings came: silence is what it watches for.
///
/// `now` counts ticks from the first one of a mission on; each call's is larger than the one before. Unless the answer
/// is `TACTUS_RESULT_OK`, nothing was done and `outputs`, if it can be written at all, holds commands that do nothing
/// (no torque, hand idle): stop the robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_tick(
    controller: *mut TactusController,
    now: u32,
    inputs: *const TactusInputs,
    outputs: *mut TactusOutputs,
) -> TactusResult {
    // SAFETY: the header's contract for the pointers; `outputs` holds a whole value once it was put.
    answer(unsafe { put(outputs, TactusOutputs::idle()) }.and_then(|()| unsafe {
        let state = exclusive::<State>(controller)?;
        tick(state, now, needed(inputs)?, &mut *outputs)
    }))
}

/// # Safety
/// The header's contract for the pointers in `given`.
unsafe fn tick(state: &mut State, now: u32, given: &TactusInputs, out: &mut TactusOutputs) -> Result<(), TactusResult> {
    let mut images = [None; TACTUS_PADS];
    if given.image_count as usize > TACTUS_PADS {
        return Err(TactusResult::BadValue);
    }
    // SAFETY: the caller's promise.
    for image in unsafe { array(given.images, given.image_count as usize) }? {
        let slot = images.get_mut(usize::from(image.pad)).ok_or(TactusResult::BadValue)?;
        *slot = Some(image.to_rust());
    }
    // SAFETY: the caller's promise.
    let readings = unsafe { optional(given.readings) }?.map(|r| r.to_rust(now));
    // SAFETY: the caller's promise.
    let rollout = unsafe { optional(given.rollout) }?.map(|r| r.to_rust(now));
    // SAFETY: the caller's promise.
    let plan = match unsafe { optional(given.plan) }? {
        Some(plan) => {
            // SAFETY: the caller's promise.
            unsafe { plan.fill(now, &mut state.answer) }?;
            Some(&state.answer)
        }
        None => None,
    };
    // Everything is known to be in order: from here on nothing fails.
    let setup = state.begun.take();
    let inputs = Inputs { setup: setup.as_ref(), readings, images, links: None, plan, rollout: rollout.as_ref() };
    let said = state.controller.tick(now, &inputs);
    out.fill(&said, &state.controller);
    Ok(())
}

/// Where the object is believed to stand. `TACTUS_RESULT_NOT_YET` before the first tick of a mission.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_belief(
    controller: *const TactusController,
    belief: *mut TactusBelief,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { shared::<State>(controller) }.and_then(|state| {
        let found = state.controller.mission().belief().ok_or(TactusResult::NotYet)?;
        // SAFETY: as above.
        unsafe { put(belief, found.into()) }
    }))
}

/// Phase of the mission.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_phase(
    controller: *const TactusController,
    phase: *mut TactusPhase,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { shared::<State>(controller).and_then(|state| put(phase, state.controller.phase().into())) })
}

/// How the mission ended, if it did.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_controller_outcome(
    controller: *const TactusController,
    outcome: *mut TactusOutcome,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { shared::<State>(controller).and_then(|state| put(outcome, state.controller.outcome().into())) })
}
