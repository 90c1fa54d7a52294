//! A mission with its controller in view: what had been felt before each update of the belief, and what was believed
//! after it.
//!
//! For experiments on the update: the same evidence, felt in the simulated reality, can be given to any method.

use crate::advisor::roll_out;
use crate::hooks::Hooks;
use crate::mental::MentalModel;
use crate::mission::{self, MissionOptions, MissionReport};
use crate::observer::{Observer, Seen};
use crate::wire::InProcess;
use std::time::{Duration, Instant};
use tactus_common::can::Mtu;
use tactus_common::message::{EventKind, Phase};
use tactus_common::pose::PlanarPose;
use tactus_controller::belief::{Belief, Prior};
use tactus_controller::evidence::EvidenceStore;
use tactus_controller::felt_touch::FeltTouch;
use tactus_controller::update::{Evidence, Progress, Update, UpdateConfig, UpdateStats};
use tactus_controller::work::Work;
use tactus_hil::choice::Pace;

/// How far a mission is carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Task {
    /// The object is found, grasped, carried and put down.
    #[default]
    Transport,
    /// The object is found: the mission ends with the update that would lead to the grasp.
    Locate,
}

/// An update of the belief.
#[derive(Clone, Debug)]
pub struct CapturedUpdate {
    /// All evidence that there was, for the geometric error.
    pub evidence: EvidenceStore,
    /// The same touches as ideal sensors tell of them, for the published errors; none without such sensors.
    pub felt: Vec<FeltTouch>,
    /// What was known before the first touch.
    pub prior: Prior,
    /// The belief before.
    pub before: Belief,
    /// The belief after.
    pub after: Belief,
    /// Where the object truly stood then.
    pub truth: PlanarPose,
    /// The controller takes the belief for good enough.
    pub confident: bool,
    /// Touches so far.
    pub touches: u32,
}

/// A mission and its updates.
#[derive(Clone, Debug)]
pub struct Captured {
    /// What came of it; with [`Task::Locate`], of its part up to the update that would lead to the grasp.
    pub report: MissionReport,
    /// Its updates, first to last.
    pub updates: Vec<CapturedUpdate>,
}

impl Captured {
    /// The update that led to the grasp, or the last one; `None` if nothing was ever touched.
    pub fn last(&self) -> Option<&CapturedUpdate> {
        self.updates.last()
    }
}

/// What an update begins with.
struct Begun {
    evidence: EvidenceStore,
    felt: Vec<FeltTouch>,
    prior: Prior,
    before: Belief,
}

/// What one tick meant for the updates of the belief.
#[derive(Default)]
struct Turn {
    /// One begins.
    begins: bool,
    /// One has ended: is the next step the grasp?
    ends: Option<bool>,
}

impl Observer for Turn {
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()> {
        for event in &seen.heard.events {
            match event.kind {
                EventKind::Phase(Phase::Update) => self.begins = true,
                EventKind::Updated { confident, .. } => self.ends = Some(confident),
                _ => {}
            }
        }
        Ok(())
    }
}

/// Carries out a mission in a world of its own, with the controller in this process.
///
/// # Errors
/// The scene cannot be simulated, or the simulation broke down.
pub fn carry_out(options: &MissionOptions, task: Task) -> anyhow::Result<Captured> {
    let started = Instant::now();
    let mut host = mission::prepare(options, Pace::Lockstep)?;
    let mut wire = InProcess::new(Mtu::Fd, Hooks::NONE);
    host.begin(&mut wire)?;
    let mut updates = Vec::new();
    let mut begun: Option<Begun> = None;
    loop {
        let mut turn = Turn::default();
        let goes_on = host.tick(&mut wire, &mut turn)?;
        let Turn { begins, ends } = turn;
        let mission = wire.node().controller().mission();
        if let Some((confident, Begun { evidence, felt, prior, before })) = ends.and_then(|c| Some((c, begun.take()?)))
        {
            let after = mission.belief().cloned().unwrap_or_default();
            let (truth, touches) = (host.so_far().truth_then, host.so_far().trials);
            updates.push(CapturedUpdate { evidence, felt, prior, before, after, truth, confident, touches });
            if confident && task == Task::Locate {
                break;
            }
        }
        if begins {
            begun = mission.belief().map(|belief| Begun {
                evidence: mission.evidence().clone(),
                felt: mission.felt_touches().to_vec(),
                prior: *mission.prior(),
                before: belief.clone(),
            });
        }
        if !goes_on {
            break;
        }
    }
    let end = host.finish(&mut wire);
    let report = mission::judge(options, &end, &host, started);
    Ok(Captured { report, updates })
}

/// An update made once more, outside the mission.
#[derive(Clone, Debug)]
pub struct Repeated {
    /// The belief after it.
    pub belief: Belief,
    /// Its account.
    pub stats: UpdateStats,
    /// Its wall time.
    pub time: Duration,
}

impl CapturedUpdate {
    /// The update once more, from the belief that it began with.
    pub fn repeat(&self, config: &UpdateConfig, mental: &MentalModel) -> Repeated {
        self.update_from(&self.before, config, mental)
    }

    /// An update on all the evidence at once, from what was known before the first touch.
    pub fn afresh(&self, config: &UpdateConfig, mental: &MentalModel) -> Repeated {
        self.update_from(&Belief::from_prior(&self.prior), config, mental)
    }

    fn update_from(&self, before: &Belief, config: &UpdateConfig, mental: &MentalModel) -> Repeated {
        let started = Instant::now();
        let mut update = Update::new(&self.prior, before, config);
        let evidence = Evidence { store: &self.evidence, touches: &self.felt };
        // Without a limit there is always an end.
        while update.step(&mut Work::unlimited(), evidence) == Progress::Running {
            if let Some(question) = update.question(&self.felt) {
                update.answer(&self.felt, &roll_out(mental, &self.prior.shape, &question, 0));
            }
        }
        Repeated { belief: update.belief().clone(), stats: update.stats(), time: started.elapsed() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::MethodOptions;
    use crate::mission::{Reality, guess_around};
    use crate::scenario::Scenario;
    use tactus_common::pose::Interval;

    #[test]
    fn an_update_repeated_outside_the_mission_gives_the_belief_that_the_mission_had() {
        let scenario = Scenario::thesis_box();
        let truth = scenario.true_pose();
        let interval = Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 };
        let guess = guess_around(&truth, &interval, 1);
        let options = MissionOptions {
            scenario,
            seed: 1,
            truth,
            guess,
            interval,
            trials_max: 8,
            reality: Reality::Mismatched,
            method: MethodOptions::with_ideal_sensors(),
        };
        let captured = carry_out(&options, Task::Locate).unwrap();
        assert!(captured.last().is_some_and(|last| last.confident));
        assert_eq!(captured.updates.len(), captured.report.trials as usize);
        let mental = MentalModel::new().unwrap();
        for update in &captured.updates {
            assert_eq!(update.felt.len(), update.touches as usize, "ideal sensors tell of every touch");
            let Repeated { belief, stats, .. } = update.repeat(&UpdateConfig::default(), &mental);
            assert_eq!((belief.pose(), belief.covariance()), (update.after.pose(), update.after.covariance()));
            assert!(stats.evaluations > 0);
        }
    }

    #[test]
    fn a_finger_at_the_very_edge_does_not_make_a_valley_look_narrow() {
        // With this seed a tip touches the side of the box near its end, and then one comes down on the top near the other end:
        // every x of some 10 mm explains both. Searches slide to the end of that valley, where the tip just touches.
        let scenario = Scenario::thesis_box();
        let options = MissionOptions {
            truth: scenario.true_pose(),
            scenario,
            seed: 477,
            guess: PlanarPose::new(0.240_000_01, -0.040_000_007, 0.0),
            interval: Interval { x_m: 0.1001, y_m: 0.0601, phi_rad: 0.0 },
            trials_max: 8,
            reality: Reality::Mismatched,
            method: MethodOptions::default(),
        };
        let captured = carry_out(&options, Task::Locate).unwrap();
        for update in &captured.updates {
            let off_m = update.after.pose().distance_m(&update.truth);
            let sigma_m = libm::sqrtf(update.after.covariance()[(0, 0)]);
            assert!(off_m < 3.0 * sigma_m, "{off_m} m off, claims {sigma_m} m after touch {}", update.touches);
        }
        assert!(captured.last().is_some_and(|last| last.confident));
    }
}
