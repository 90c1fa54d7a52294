//! Promise: the whole controller with its end of the wire takes at most 56 KiB of fixed memory, and what one tick hands
//! on by value is small, so that 96 KiB of a microcontroller leave enough for its stack. A set-up that names a hull and
//! four obstacles takes 5 KiB of it, where it waits for its tick and where the mission keeps it.

use std::mem::size_of;
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::message::{PlanAnswer, SensorFrame};
use tactus_common::trajectory::Trajectory;
use tactus_controller::belief::Belief;
use tactus_controller::controller::{Controller, Inputs, Outputs};
use tactus_controller::evidence::EvidenceStore;
use tactus_controller::executor::Executor;
use tactus_controller::mission::Mission;
use tactus_controller::node::Node;
use tactus_controller::onset::Onset;
use tactus_controller::touch::{Chooser, TouchHistory};
use tactus_controller::update::Update;

/// Bytes that the whole may take.
const BUDGET_BYTES: usize = 56 * 1024;
/// Bytes that pass through the arguments and the result of one tick.
const TICK_BYTES: usize = 1_536;

#[test]
fn controller_and_node_fit_56_kib_and_a_tick_moves_little() {
    println!("Memory, bytes:");
    for (name, bytes) in [
        ("Node (the controller with its end of the wire)", size_of::<Node>()),
        ("  Controller", size_of::<Controller>()),
        ("    Executor (a trajectory)", size_of::<Executor>()),
        ("    Onset", size_of::<Onset>()),
        ("    Mission", size_of::<Mission>()),
        ("      EvidenceStore", size_of::<EvidenceStore>()),
        ("      TouchHistory", size_of::<TouchHistory>()),
        ("      Belief", size_of::<Belief>()),
        ("      Chooser", size_of::<Chooser>()),
        ("      Update", size_of::<Update>()),
        ("  buffer of the longest transfer", PAYLOAD_BYTES_MAX),
        ("  PlanAnswer, waiting for its tick", size_of::<PlanAnswer>()),
        ("    Trajectory", size_of::<Trajectory>()),
        ("  SensorFrame", size_of::<SensorFrame>()),
        ("On the stack of one tick: Inputs + Outputs", size_of::<Inputs>() + size_of::<Outputs>()),
    ] {
        println!("{bytes:>8}  {name}");
    }
    assert!(size_of::<Controller>() <= BUDGET_BYTES, "Controller: {}", size_of::<Controller>());
    let moved = size_of::<Inputs>() + size_of::<Outputs>();
    assert!(moved <= TICK_BYTES, "Inputs and Outputs: {moved}");
    assert!(size_of::<Node>() <= BUDGET_BYTES, "Node: {}", size_of::<Node>());
}
