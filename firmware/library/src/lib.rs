//! Tactus for C and C++: the controller ([`controller`]) and, by itself, its pose estimator ([`estimator`]).
//!
//! Everything that C sees is named `Tactus...` or `tactus_...` and stands in `include/tactus.h`, which cbindgen writes
//! from these files: their documentation comments are the header's, so they speak C. [`handle`] is where raw pointers
//! become references; nothing else here has to think about them.
//!
//! No heap, no globals, no clock, and no panic that passes into C: [`panic`] says where one ends.
#![cfg_attr(not(any(test, doctest)), no_std)]
// The header states the one contract of all functions (valid pointers, one thread per handle) for C's readers.
#![allow(clippy::missing_safety_doc, reason = "include/tactus.h says it once for all functions")]

pub mod controller;
pub mod estimator;
pub mod event;
pub mod geometry;
pub mod handle;
#[cfg(feature = "freestanding")]
pub mod panic;
pub mod plan;
pub mod result;
pub mod robot;
pub mod rollout;
pub mod setup;

/// Version of this interface: it grows by one whenever a struct, a constant or a function changes its meaning.
pub const TACTUS_ABI_VERSION: u32 = 3;

/// `TACTUS_ABI_VERSION` of the library that is linked; compare it with the header's before anything else.
#[unsafe(no_mangle)]
pub extern "C" fn tactus_abi_version() -> u32 {
    TACTUS_ABI_VERSION
}
