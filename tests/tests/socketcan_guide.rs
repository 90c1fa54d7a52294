//! The guide's commands that need a CAN interface.

use tactus_tests::guide::{self, WITH_CAN};

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn every_command_of_the_guide_that_needs_a_bus_does_the_job() {
    let commands: Vec<&str> = guide::commands().into_iter().filter_map(|line| line.strip_prefix(WITH_CAN)).collect();
    assert!(commands.len() >= 2, "{commands:?}");
    commands.into_iter().for_each(guide::run);
}
