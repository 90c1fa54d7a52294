//! What every function answers.

/// What a function answers. Anything but `TACTUS_RESULT_OK` is a mistake of the caller; the handle stays as it was.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusResult {
    /// Done.
    Ok = 0,
    /// A pointer that is needed is NULL.
    NullPointer = 1,
    /// A pointer is not aligned for what it points to.
    Misaligned = 2,
    /// The memory is smaller than what is to live in it.
    TooSmall = 3,
    /// The handle was not made by the `create` function of its kind.
    NotCreated = 4,
    /// A value makes no sense: not finite, out of its range, or no constant of its enumeration.
    BadValue = 5,
    /// Not now: an update is running. Finish it first.
    Busy = 6,
    /// No room for more evidence: begin a new touch (the oldest is forgotten) or clear the estimator.
    Full = 7,
    /// Nothing to tell yet: no mission has begun.
    NotYet = 8,
}

/// Turns `Ok(())` and errors into what C gets.
pub(crate) fn answer(done: Result<(), TactusResult>) -> TactusResult {
    match done {
        Ok(()) => TactusResult::Ok,
        Err(error) => error,
    }
}
