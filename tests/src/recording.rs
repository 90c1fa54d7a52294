//! A mission in the simulated world, with all that crossed the wire.

use crate::rig::{Rig, Said, Told};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::OnceLock;
use tactus_common::can::CanFrame;
use tactus_common::cyphal::{Header, Session};
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::link::{self, WORLD, subject};
use tactus_common::message::{Phase, PlanAnswer, RolloutResult, SensorFrame, Setup, TactileSlice};
use tactus_common::pose::Interval;
use tactus_sim_host::hooks::{Hooks, Passing, To};
use tactus_sim_host::method::MethodOptions;
use tactus_sim_host::mission::{self, DEFAULT_OFFSET, MissionOptions, MissionReport, Reality, guess_around};
use tactus_sim_host::observer::Nobody;
use tactus_sim_host::scenario::Scenario;

/// Bytes of the largest transfer, padding included.
const RX_BYTES: usize = PAYLOAD_BYTES_MAX + 16;

/// The options of `tactus run --seed N`.
pub fn options(seed: u64) -> MissionOptions {
    let scenario = Scenario::thesis_box();
    let truth = scenario.true_pose();
    let [x_m, y_m, phi_rad] = DEFAULT_OFFSET;
    let interval = Interval { x_m, y_m, phi_rad };
    MissionOptions {
        guess: guess_around(&truth, &interval, seed),
        scenario,
        seed,
        truth,
        interval,
        trials_max: 8,
        reality: Reality::default(),
        method: MethodOptions::default(),
    }
}

/// Runs a mission; `tamper` decides what arrives instead of each frame (see [`tactus_sim_host::hooks::Tamper`]).
///
/// # Panics
/// If the simulation breaks down: a mission ends with a reason, whatever happens on the wire.
pub fn run_tampered(
    options: &MissionOptions,
    tamper: impl FnMut(&Passing, &mut Vec<CanFrame>) + 'static,
) -> MissionReport {
    run_hooked(options, Hooks { tamper: Some(Box::new(tamper)), ..Hooks::NONE })
}

/// Runs a mission on a wire with hooks.
///
/// # Panics
/// As [`run_tampered`].
pub fn run_hooked(options: &MissionOptions, hooks: Hooks) -> MissionReport {
    mission::run_hooked(options, &mut Nobody, hooks).unwrap_or_else(|error| panic!("no end with a reason: {error:#}"))
}

/// A mission and what the controller was told in each of its ticks.
#[derive(Debug)]
pub struct Recording {
    /// What was to be done.
    pub options: MissionOptions,
    /// What came of it.
    pub report: MissionReport,
    /// By tick: what the controller was told.
    pub told: Vec<Told>,
}

/// Puts together what frames to the controller mean.
struct Listener {
    setup: Session<RX_BYTES>,
    plan: Session<RX_BYTES>,
    rollout: Session<RX_BYTES>,
    image: Session<RX_BYTES>,
    sensors: Session<RX_BYTES>,
    told: Vec<Told>,
    open: Told,
}

impl Listener {
    fn new() -> Self {
        Self {
            setup: Session::new(subject::<Setup>(), WORLD, 0),
            plan: Session::new(subject::<PlanAnswer>(), WORLD, 0),
            rollout: Session::new(subject::<RolloutResult>(), WORLD, 0),
            image: Session::new(subject::<TactileSlice>(), WORLD, 0),
            sensors: Session::new(subject::<SensorFrame>(), WORLD, 0),
            told: Vec::new(),
            open: Told::default(),
        }
    }

    fn listen(&mut self, frame: &CanFrame) {
        let header = Header::parse(frame.id()).expect("the world sends messages");
        let data = frame.data();
        macro_rules! hear {
            ($($name:ident)*) => {$(
                if let Ok(Some(transfer)) = self.$name.accept(&header, data, 0) {
                    self.open.$name = Some(link::decode(transfer.payload).expect("the world's messages decode"));
                }
            )*};
        }
        hear!(setup plan rollout image sensors);
        if self.open.sensors.is_some() {
            self.told.push(std::mem::take(&mut self.open));
        }
    }
}

impl Recording {
    /// Records a mission.
    pub fn of(options: MissionOptions) -> Self {
        let listener = Rc::new(RefCell::new(Listener::new()));
        let tap = Rc::clone(&listener);
        let report = run_tampered(&options, move |passing, arrives| {
            if passing.to == To::Controller {
                tap.borrow_mut().listen(&passing.frame);
            }
            arrives.push(passing.frame);
        });
        let told = std::mem::take(&mut listener.borrow_mut().told);
        Self { options, report, told }
    }

    /// The default mission, recorded once in a process.
    pub fn shared() -> &'static Self {
        static SHARED: OnceLock<Recording> = OnceLock::new();
        SHARED.get_or_init(|| Self::of(options(1)))
    }

    /// Plays it to a new rig as long as `watch` wants more; `watch` sees the rig after each tick, and what it said.
    pub fn play(&self, mut watch: impl FnMut(&Rig, &Said) -> bool) -> Rig {
        let mut rig = Rig::new();
        for told in &self.told {
            let said = rig.tell(told);
            if !watch(&rig, &said) {
                break;
            }
        }
        rig
    }

    /// Rigs stopped all along the mission: before its set-up came, at every first tick of a phase, and at every
    /// `every`-th tick.
    pub fn stops(&self, every: u32) -> Vec<Rig> {
        let mut before = Rig::new();
        before.tell(&Told { sensors: self.told[0].sensors, ..Told::default() });
        let mut phase = before.phase();
        let mut stops = vec![before];
        self.play(|rig, _| {
            if rig.phase() != phase || rig.tick().is_multiple_of(every) {
                phase = rig.phase();
                stops.push(rig.clone());
            }
            true
        });
        stops
    }
}

/// The phases of a mission that succeeds.
pub const PHASES: [Phase; 8] = [
    Phase::Initialise,
    Phase::Plan,
    Phase::Trial,
    Phase::Update,
    Phase::Grasp,
    Phase::Transport,
    Phase::Release,
    Phase::Done,
];
