//! The pose estimator by itself, for loops that have their own motion and safety: evidence in, belief out.

use crate::geometry::{TactusBelief, TactusInterval, TactusMode, TactusPose, TactusShape};
use crate::handle::{Handled, Plain, exclusive, needed, place, put, shared};
use crate::result::{TactusResult, answer};
use crate::robot::{TACTUS_FINGERS, TactusHand};
use core::ffi::c_void;
use nalgebra::Isometry3;
use tactus_common::robot::hand::HandAngles;
use tactus_controller::belief::{Belief, Prior};
use tactus_controller::evidence::{ContactKind, EvidenceStore, StoreError, Toucher};
use tactus_controller::update::{Progress, Update, UpdateConfig};
use tactus_controller::work::Work;

/// Bytes that are enough for an estimator on every target; `tactus_estimator_size` says how many one takes here.
pub const TACTUS_ESTIMATOR_SIZE: usize = 28672;
/// `TACTUS_ESTIMATOR_SIZE` in words of 64 bits.
pub const TACTUS_ESTIMATOR_WORDS: usize = 3584;
/// Alignment that an estimator's memory needs, bytes.
pub const TACTUS_ESTIMATOR_ALIGN: usize = 8;
/// Lengths, metres, and angles, radians, beyond this make no sense on a table.
const PRIOR_MAX: f32 = 10.0;

const _: () = {
    assert!(<State as Handled>::BYTES <= TACTUS_ESTIMATOR_SIZE, "raise TACTUS_ESTIMATOR_SIZE");
    assert!(<State as Handled>::ALIGN <= TACTUS_ESTIMATOR_ALIGN, "raise TACTUS_ESTIMATOR_ALIGN");
    assert!(size_of::<TactusEstimatorMemory>() == TACTUS_ESTIMATOR_SIZE);
    assert!(align_of::<TactusEstimatorMemory>() == TACTUS_ESTIMATOR_ALIGN);
};

/// A pose estimator; lives in memory of yours, from `tactus_estimator_create` on.
pub struct TactusEstimator {
    _only_a_name: (),
}

/// Memory for one estimator. Its content is not yours: `tactus_estimator_create` gives the handle.
#[repr(C)]
pub struct TactusEstimatorMemory {
    /// Not to be used.
    pub words: [u64; TACTUS_ESTIMATOR_WORDS],
}

/// What is behind a [`TactusEstimator`].
struct State {
    prior: Prior,
    belief: Belief,
    store: EvidenceStore,
    update: Update,
    running: bool,
}

impl State {
    /// The store, to add to: an update in the middle must not see its evidence change.
    fn open(&mut self) -> Result<&mut EvidenceStore, TactusResult> {
        if self.running { Err(TactusResult::Busy) } else { Ok(&mut self.store) }
    }
}

impl Handled for State {
    /// "TacE".
    const MARK: u32 = u32::from_le_bytes(*b"TacE");
    type Opaque = TactusEstimator;
}

/// What is known before the first touch: the pose lies in guess +- interval, all equally likely.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusPrior {
    /// What the object is.
    pub shape: TactusShape,
    /// Middle of the region.
    pub guess: TactusPose,
    /// Half widths of the region; a component with 0 is known exactly.
    pub interval: TactusInterval,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusPrior {}

impl TactusPrior {
    fn to_rust(self) -> Result<Prior, TactusResult> {
        let (guess, interval) = (self.guess.to_rust(), self.interval.to_rust());
        let shape = self.shape.to_rust()?;
        // False for what is no number.
        let near = |v: &f32| v.abs() <= PRIOR_MAX;
        let sound = guess.to_array().iter().all(near)
            && interval.to_array().iter().all(|w| *w >= 0.0 && near(w))
            && shape.half_extents_m().iter().all(near);
        if sound { Ok(Prior::new(&guess, &interval, &shape)) } else { Err(TactusResult::BadValue) }
    }
}

/// What felt a contact.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusToucher {
    /// A link of finger 1.
    F1 = 0,
    /// A link of finger 2.
    F2 = 1,
    /// A link of finger 3.
    F3 = 2,
    /// The palm.
    Palm = 3,
}

/// How a contact came about, which says how exact it is.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusContactKind {
    /// A finger closed until it felt something (0.6 mm standard deviation).
    Closing = 0,
    /// The hand came down until something was felt (1.5 mm).
    Landing = 1,
    /// A finger of a closed grasp, pressed harder (1.0 mm).
    Grasp = 2,
}

fn toucher(code: u8) -> Result<Toucher, TactusResult> {
    match code {
        0..=2 => Ok(Toucher::Finger(usize::from(code))),
        3 => Ok(Toucher::Palm),
        _ => Err(TactusResult::BadValue),
    }
}

fn contact_kind(code: u8) -> Result<ContactKind, TactusResult> {
    match code {
        0 => Ok(ContactKind::Closing),
        1 => Ok(ContactKind::Landing),
        2 => Ok(ContactKind::Grasp),
        _ => Err(TactusResult::BadValue),
    }
}

fn refused(error: StoreError) -> TactusResult {
    match error {
        StoreError::Full => TactusResult::Full,
        StoreError::Invalid => TactusResult::BadValue,
    }
}

/// Bytes that an estimator takes on this target, at most `TACTUS_ESTIMATOR_SIZE`.
#[unsafe(no_mangle)]
pub extern "C" fn tactus_estimator_size() -> usize {
    <State as Handled>::BYTES
}

/// Makes an estimator in your memory, with no evidence yet. There is nothing to destroy.
///
/// `memory` has `memory_bytes` bytes (`TACTUS_ESTIMATOR_SIZE` are enough) and is aligned to `TACTUS_ESTIMATOR_ALIGN`;
/// it must not move while the handle is in use. `estimator` receives the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_create(
    memory: *mut c_void,
    memory_bytes: usize,
    prior: *const TactusPrior,
    estimator: *mut *mut TactusEstimator,
) -> TactusResult {
    // SAFETY: the header's contract for all pointers.
    answer(unsafe { put(estimator, core::ptr::null_mut()) }.and_then(|()| unsafe {
        let prior = needed(prior)?.to_rust()?;
        let write = |state: *mut State| {
            (&raw mut (*state).prior).write(prior);
            (&raw mut (*state).belief).write(Belief::from_prior(&prior));
            (&raw mut (*state).store).write(EvidenceStore::new(prior.shape.top_height_m()));
            (&raw mut (*state).update).write(Update::default());
            (&raw mut (*state).running).write(false);
        };
        put(estimator, place(memory, memory_bytes, write)?)
    }))
}

/// Begins a touch: evidence added from now on belongs to it. The touch 8 back is forgotten.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_begin_touch(estimator: *mut TactusEstimator) -> TactusResult {
    // SAFETY: the header's contract.
    answer(unsafe { exclusive::<State>(estimator) }.and_then(|state| {
        state.open()?.begin_touch();
        Ok(())
    }))
}

/// Forgets all evidence and starts from the prior again: the object was moved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_clear(estimator: *mut TactusEstimator) -> TactusResult {
    // SAFETY: the header's contract.
    answer(unsafe { exclusive::<State>(estimator) }.map(|state| {
        state.store.begin(state.prior.shape.top_height_m());
        state.belief = Belief::from_prior(&state.prior);
        state.running = false;
    }))
}

/// Evidence: with the hand like this, `toucher` (a `TactusToucher`) felt the object; `kind` (a `TactusContactKind`)
/// says how.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_add_contact(
    estimator: *mut TactusEstimator,
    hand: *const TactusHand,
    toucher: u8,
    kind: u8,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe {
        add(estimator, hand, |store, world_from_hand, angles| {
            store.add_contact(world_from_hand, angles, self::toucher(toucher)?, contact_kind(kind)?).map_err(refused)
        })
    })
}

/// Evidence: with the hand like this, the palm and the fingers marked in `fingers` (bits 0, 1, 2 = F1, F2, F3) were
/// clear of the object.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_add_free(
    estimator: *mut TactusEstimator,
    hand: *const TactusHand,
    fingers: u8,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe {
        add(estimator, hand, |store, world_from_hand, angles| {
            if fingers >> TACTUS_FINGERS != 0 {
                return Err(TactusResult::BadValue);
            }
            let marked = [fingers & 1 != 0, fingers & 2 != 0, fingers & 4 != 0];
            store.add_free(world_from_hand, angles, marked).map_err(refused)
        })
    })
}

/// Evidence: from the hand like this, `finger` (0, 1, 2 = F1, F2, F3) closed to the inner angle `end_inner_rad`,
/// radians, without touching anything.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_add_free_sweep(
    estimator: *mut TactusEstimator,
    hand: *const TactusHand,
    finger: u8,
    end_inner_rad: f32,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe {
        add(estimator, hand, |store, world_from_hand, angles| {
            store.add_free_sweep(world_from_hand, angles, usize::from(finger), end_inner_rad).map_err(refused)
        })
    })
}

/// Hands the checked hand and the open store to `how`.
///
/// # Safety
/// The header's contract for both pointers.
unsafe fn add(
    estimator: *mut TactusEstimator,
    hand: *const TactusHand,
    how: impl FnOnce(&mut EvidenceStore, &Isometry3<f32>, &HandAngles) -> Result<(), TactusResult>,
) -> Result<(), TactusResult> {
    // SAFETY: the caller's promise.
    let (state, hand) = unsafe { (exclusive::<State>(estimator)?, needed(hand)?) };
    let world_from_hand = hand.world_from_hand.to_rust()?;
    how(state.open()?, &world_from_hand, &hand.angles())
}

/// Fits the pose to all evidence, a slice at a time: `work_max` (1 or more) bounds a slice, in units of about a hundred
/// instructions of a Cortex-M4F; a slice may take one evaluation of the error more. The first slice begins an update;
/// `done` becomes true when it is finished and the belief is new. How it is sliced changes nothing in the result.
///
/// While an update runs no evidence can be added (`TACTUS_RESULT_BUSY`).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_update(
    estimator: *mut TactusEstimator,
    work_max: u32,
    done: *mut bool,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { exclusive::<State>(estimator) }.and_then(|state| {
        // SAFETY: as above.
        unsafe { put(done, false) }?;
        if work_max == 0 {
            return Err(TactusResult::BadValue);
        }
        if !state.running {
            state.update.begin(&state.prior, &state.belief, &UpdateConfig::default());
            state.running = true;
        }
        if state.update.step(&mut Work::units(work_max), &state.store) == Progress::Done {
            state.belief.clone_from(state.update.belief());
            state.running = false;
            // SAFETY: as above.
            unsafe { put(done, true) }?;
        }
        Ok(())
    }))
}

/// Where the object is believed to stand: after the last whole update, or from the prior alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_belief(
    estimator: *const TactusEstimator,
    belief: *mut TactusBelief,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { shared::<State>(estimator).and_then(|state| put(belief, (&state.belief).into())) })
}

/// One of the distinct poses that explain the evidence, the best first; `index` is below `modes` of the belief.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_estimator_mode(
    estimator: *const TactusEstimator,
    index: u8,
    mode: *mut TactusMode,
) -> TactusResult {
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { shared::<State>(estimator) }.and_then(|state| {
        let found = state.belief.modes().get(usize::from(index)).ok_or(TactusResult::BadValue)?;
        // SAFETY: as above.
        unsafe { put(mode, found.into()) }
    }))
}
