//! Promise: the bus.

use tactus_tests::recording::Recording;
#[test]
fn nothing_is_late_on_a_sound_bus() {
    let recording = Recording::shared();
    let rig = recording.play(|_, _| true);
    let setup = recording.told.iter().position(|t| t.setup.is_some());
    let plans: Vec<_> = recording.told.iter().enumerate().filter_map(|(i, t)| t.plan.as_ref().map(|p| (i, p.effective))).collect();
    println!("{:?} {setup:?} {plans:?}", rig.node.stats());
    assert_eq!(rig.node.stats(), Default::default());
}
