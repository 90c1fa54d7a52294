//! An error function of your own, on evidence that a whole mission has felt, minimised by any of the optimisers.
//!
//! `cargo run --release --package tactus-tests --example own_error`

use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::hand_prism;
use tactus_common::shape::ObjectShape;
use tactus_controller::error::{ErrorFunction, Evaluation};
use tactus_controller::evidence::EvidenceStore;
use tactus_controller::optimise::{AnyOptimiser, Gradient, Method, SearchOptions, carry_through};
use tactus_sim_host::experiment::capture::{Task, carry_out};
use tactus_sim_host::method::MethodOptions;
use tactus_sim_host::mission::{MissionOptions, Reality};
use tactus_sim_host::scenario::Scenario;

/// The sum of the distances between what touched and the surface of the object, millimetres. Free links count for nothing,
/// and no contact for more than another, however exact it is.
struct SumOfDistances<'a> {
    evidence: &'a EvidenceStore,
    shape: &'a ObjectShape,
}

impl ErrorFunction for SumOfDistances<'_> {
    fn evaluate(&self, pose: &PlanarPose) -> Evaluation {
        let object_from_world = pose.isometry(self.shape.rest_height_m()).inverse();
        let mut sum_mm = 0.0;
        for contact in self.evidence.contacts() {
            // It is known which finger touched, not with which of its links: the nearest one.
            let distances_m = contact.links.iter().filter_map(|posed| {
                let object_from_link = object_from_world * posed.world_from_link;
                let separation = self.shape.separation(&object_from_link, hand_prism(posed.link))?;
                Some(separation.distance_m.abs())
            });
            sum_mm += 1e3 * distances_m.fold(f32::INFINITY, f32::min);
        }
        // Without a slope: optimisers that need one take differences.
        Evaluation { error: sum_mm, slope: None }
    }
}

fn main() -> anyhow::Result<()> {
    let scenario = Scenario::thesis_box();
    let (truth, shape) = (scenario.true_pose(), scenario.shape());
    let mission = MissionOptions {
        scenario,
        seed: 1,
        truth,
        guess: PlanarPose::new(0.23, -0.07, 0.2),
        interval: Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 },
        trials_max: 8,
        reality: Reality::Mismatched,
        method: MethodOptions::default(),
    };
    let captured = carry_out(&mission, Task::Locate)?;
    let update = captured.last().ok_or_else(|| anyhow::anyhow!("nothing was touched"))?;
    let off_mm = |pose: &PlanarPose| 1e3 * pose.distance_m(&update.truth);
    println!("{} touches, {} contacts", update.touches, update.evidence.contacts().len());
    println!("{:24} {:5.2} mm off", "the controller's belief", off_mm(&update.after.pose()));

    let error = SumOfDistances { evidence: &update.evidence, shape: &shape };
    let options = SearchOptions { evaluations_max: 300, gradient: Gradient::TwoSided, ..SearchOptions::default() };
    for method in Method::ALL {
        let mut optimiser = AnyOptimiser::new(method, &update.prior.guess, &update.prior.bounds(), &options)
            .ok_or_else(|| anyhow::anyhow!("{} was not compiled in", method.name()))?;
        let mut evaluations = 0;
        let ended = carry_through(&mut optimiser, |pose| {
            evaluations += 1;
            error.evaluate(pose)
        });
        if let Some((found, why)) = ended {
            let (error_mm, off_mm) = (found.evaluation.error, off_mm(&found.pose));
            println!(
                "{:24} {off_mm:5.2} mm off, error {error_mm:5.2} mm, {evaluations:3} evaluations, {}",
                method.name(),
                why.name()
            );
        }
    }
    Ok(())
}
