//! Promise: the controller never touches a heap. A whole mission is played to its node while every call of the
//! allocator between a frame's arrival and the end of its tick is counted.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use tactus_common::can::CanFrame;
use tactus_common::message::Outcome;
use tactus_controller::node::Node;
use tactus_tests::recording::Recording;
use tactus_tests::rig::Rig;

thread_local! {
    /// Calls of the allocator by this thread while [`COUNTING`].
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static COUNTING: Cell<bool> = const { Cell::new(false) };
}

struct Counting;

fn note() {
    COUNTING.with(|counting| {
        if counting.get() {
            CALLS.with(|calls| calls.set(calls.get() + 1));
        }
    });
}

#[allow(
    unsafe_code,
    reason = "a global allocator cannot be written without; it only counts and hands on to the system's"
)]
// SAFETY: every call goes to `System` unchanged, which keeps the contract. Counting uses const-initialised thread
// locals without destructor, so it never allocates itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller keeps `GlobalAlloc::alloc`'s contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note();
        // SAFETY: the caller keeps `GlobalAlloc::dealloc`'s contract; the pointer came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, bytes: usize) -> *mut u8 {
        note();
        // SAFETY: the caller keeps `GlobalAlloc::realloc`'s contract; the pointer came from `System`.
        unsafe { System.realloc(pointer, layout, bytes) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Calls of the allocator by this thread during `work`.
fn calls_during(work: impl FnOnce()) -> u64 {
    let before = CALLS.with(Cell::get);
    COUNTING.with(|counting| counting.set(true));
    work();
    COUNTING.with(|counting| counting.set(false));
    CALLS.with(Cell::get) - before
}

/// A wire that holds what the node says in one tick.
struct Wire {
    frames: Vec<CanFrame>,
}

impl Wire {
    fn new() -> Self {
        Self { frames: Vec::with_capacity(64) }
    }

    fn take(&mut self, frame: CanFrame) {
        assert!(self.frames.len() < self.frames.capacity(), "the wire itself must not allocate");
        self.frames.push(frame);
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(calls_during(|| ()), 0);
    assert_eq!(calls_during(|| drop(std::hint::black_box(vec![1_u8; 10]))), 2);
}

#[test]
fn a_whole_mission_allocates_nothing_in_the_controller() {
    let recording = Recording::shared();
    assert_eq!(recording.report.outcome, Some(Outcome::Transported), "all phases are passed through");
    // The rig makes the frames; the node under test gets them beside it.
    let mut rig = Rig::new();
    let mut node = Node::new(tactus_common::can::Mtu::Fd);
    let mut wire = Wire::new();
    let (mut frames_in, mut calls) = (0_u64, 0);
    for told in &recording.told {
        for frame in rig.frames_of(told) {
            wire.frames.clear();
            frames_in += 1;
            let in_this = calls_during(|| {
                node.receive(&frame, &mut |said| wire.take(said));
            });
            assert_eq!(in_this, 0, "tick {}, {:?}, {frame:?}", rig.tick(), node.controller().phase());
            calls += in_this;
        }
    }
    println!("{} ticks, {frames_in} frames in, {calls} calls of the allocator", recording.told.len());
    assert_eq!(node.end().map(|(_, digest)| digest), recording.report.digest, "it was the same mission");
    // Silence until safe, and beyond.
    for _ in 0..50 {
        wire.frames.clear();
        assert_eq!(calls_during(|| node.silent_tick(&mut |said| wire.take(said))), 0);
    }
}
