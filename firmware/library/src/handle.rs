//! Where C's raw pointers become references, checked as far as a pointer can be.
//!
//! The contract that no check can replace, stated in the header: a pointer that is not NULL points to what its type
//! says, stays valid during the call, is used by one thread at a time, and what is written to is not also passed as
//! something to read.

use crate::result::TactusResult;
use core::ffi::c_void;
use core::mem::{align_of, size_of};

/// What `create` puts in front of a value, so that memory which never saw `create` is told apart.
#[repr(C)]
pub(crate) struct Marked<T> {
    mark: u32,
    value: T,
}

/// A value that C holds by a handle.
pub(crate) trait Handled: Sized {
    /// Four bytes of this kind: not zero, so that static memory is no handle, and not those of another kind.
    const MARK: u32;
    /// What the handle points to as C knows it: nothing but a name.
    type Opaque;
    /// Bytes that `create` needs.
    const BYTES: usize = size_of::<Marked<Self>>();
    /// Alignment that `create` needs.
    const ALIGN: usize = align_of::<Marked<Self>>();
}

/// Makes a value in the caller's memory: `write` gets the place, field by field, since a whole value would pass over the
/// stack.
///
/// # Safety
/// `memory` is NULL or points to `bytes` writable bytes that nothing else uses from now on. `write` writes every field.
pub(crate) unsafe fn place<T: Handled>(
    memory: *mut c_void,
    bytes: usize,
    write: impl FnOnce(*mut T),
) -> Result<*mut T::Opaque, TactusResult> {
    let place = memory.cast::<Marked<T>>();
    aligned(place)?;
    if bytes < T::BYTES {
        return Err(TactusResult::TooSmall);
    }
    // SAFETY: not NULL, aligned and large enough (checked above); writable and unused (the caller's promise). The mark
    // comes last: before it, this is no handle.
    unsafe {
        write(&raw mut (*place).value);
        (&raw mut (*place).mark).write(T::MARK);
    }
    Ok(place.cast())
}

/// The value behind a handle, to change.
///
/// # Safety
/// `handle` is NULL, or points to memory as large as `create` demands that outlives `'a` and that nothing else uses
/// in the meantime.
pub(crate) unsafe fn exclusive<'a, T: Handled>(handle: *mut T::Opaque) -> Result<&'a mut T, TactusResult> {
    // SAFETY: the same promise; the shared reference ends before the exclusive one begins.
    unsafe { shared::<T>(handle) }?;
    // SAFETY: the mark says that `create` wrote a whole value here; exclusive by the caller's promise.
    Ok(unsafe { &mut (*handle.cast::<Marked<T>>()).value })
}

/// The value behind a handle, to look at.
///
/// # Safety
/// As [`exclusive`], but others may read it in the meantime.
pub(crate) unsafe fn shared<'a, T: Handled>(handle: *const T::Opaque) -> Result<&'a T, TactusResult> {
    let handle = handle.cast::<Marked<T>>();
    aligned(handle)?;
    // SAFETY: not NULL and aligned; the mark's bytes are there, since handles point to memory as large as `create`
    // demands. Read as a field only: the value may not exist yet.
    let mark = unsafe { (&raw const (*handle).mark).read() };
    if mark != T::MARK {
        return Err(TactusResult::NotCreated);
    }
    // SAFETY: the mark says that `create` wrote a whole value here.
    Ok(unsafe { &(*handle).value })
}

/// A struct of C's to read; `None` for NULL.
///
/// # Safety
/// `pointer` is NULL or points to a `T` with every field set, which nobody changes during `'a`.
pub(crate) unsafe fn optional<'a, T: Plain>(pointer: *const T) -> Result<Option<&'a T>, TactusResult> {
    match aligned(pointer) {
        // SAFETY: not NULL and aligned (checked); set and unchanged (the caller's promise).
        Ok(()) => Ok(Some(unsafe { &*pointer })),
        Err(TactusResult::NullPointer) => Ok(None),
        Err(error) => Err(error),
    }
}

/// A struct of C's to read.
///
/// # Safety
/// As [`optional`].
pub(crate) unsafe fn needed<'a, T: Plain>(pointer: *const T) -> Result<&'a T, TactusResult> {
    // SAFETY: the same promise.
    unsafe { optional(pointer) }?.ok_or(TactusResult::NullPointer)
}

/// An array of C's to read; NULL is allowed for none.
///
/// # Safety
/// `pointer` is NULL or points to `count` elements as in [`optional`].
pub(crate) unsafe fn array<'a, T: Plain>(pointer: *const T, count: usize) -> Result<&'a [T], TactusResult> {
    if count == 0 {
        return Ok(&[]);
    }
    aligned(pointer)?;
    // SAFETY: not NULL and aligned (checked); `count` elements that are set and unchanged (the caller's promise).
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// Writes an answer to C's memory, whatever was there.
///
/// # Safety
/// `pointer` is NULL or points to a `T` that may be overwritten and that nobody else uses now.
pub(crate) unsafe fn put<T>(pointer: *mut T, value: T) -> Result<(), TactusResult> {
    aligned(pointer)?;
    // SAFETY: not NULL and aligned (checked); writable (the caller's promise). What was there needs no drop.
    unsafe { pointer.write(value) };
    Ok(())
}

fn aligned<T>(pointer: *const T) -> Result<(), TactusResult> {
    if pointer.is_null() {
        Err(TactusResult::NullPointer)
    } else if !pointer.addr().is_multiple_of(align_of::<T>()) {
        Err(TactusResult::Misaligned)
    } else {
        Ok(())
    }
}

/// A struct for which every bit pattern is a value: numbers, pointers that are checked before use, and arrays of such.
/// No Rust enumeration and no `bool`, which C could set to what is none.
///
/// # Safety
/// Only for types of which this is true.
pub(crate) unsafe trait Plain: Copy {}

#[cfg(test)]
mod tests {
    use super::*;

    struct Thing(u64);
    impl Handled for Thing {
        const MARK: u32 = 0x1234_5678;
        type Opaque = u8;
    }
    struct Other;
    impl Handled for Other {
        const MARK: u32 = 0x8765_4321;
        type Opaque = u8;
    }

    fn place_in(memory: &mut [u64; 4], skip: usize, bytes: usize) -> Result<*mut u8, TactusResult> {
        let start = memory.as_mut_ptr().cast::<u8>().wrapping_add(skip).cast::<c_void>();
        // SAFETY: inside the array where `place` gets as far as writing.
        unsafe { place(start, bytes, |place: *mut Thing| place.write(Thing(7))) }
    }

    #[test]
    fn a_value_is_found_where_it_was_placed() {
        let mut memory = [0_u64; 4];
        let handle = place_in(&mut memory, 0, 32).expect("room");
        // SAFETY: just placed, used by this thread alone.
        let thing = unsafe { exclusive::<Thing>(handle) }.expect("placed");
        assert_eq!(thing.0, 7);
    }

    #[test]
    fn memory_that_is_null_crooked_or_small_is_refused() {
        let mut memory = [0_u64; 4];
        // SAFETY: NULL is allowed.
        let nowhere = unsafe { place::<Thing>(core::ptr::null_mut(), 32, |_| ()) };
        assert_eq!(nowhere.err(), Some(TactusResult::NullPointer));
        assert_eq!(place_in(&mut memory, 4, 24).err(), Some(TactusResult::Misaligned));
        assert_eq!(place_in(&mut memory, 0, 15).err(), Some(TactusResult::TooSmall));
        assert_eq!(memory, [0; 4], "nothing was written");
    }

    #[test]
    fn memory_that_never_saw_create_or_holds_another_kind_is_no_handle() {
        let mut memory = [0_u64; 4];
        let blank = memory.as_mut_ptr().cast::<u8>();
        // SAFETY: large enough and set.
        assert_eq!(unsafe { shared::<Thing>(blank) }.err(), Some(TactusResult::NotCreated));
        let handle = place_in(&mut memory, 0, 32).expect("room");
        // SAFETY: large enough and set.
        assert_eq!(unsafe { shared::<Other>(handle) }.err(), Some(TactusResult::NotCreated));
    }
}
