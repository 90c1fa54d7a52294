//! What one mission was told and has learnt.

use super::obstructed::may_have_touched;
use crate::belief::{Belief, Prior};
use crate::evidence::{ContactKind, EvidenceStore, Toucher};
use crate::felt_touch::FeltTouches;
use crate::touch::TouchHistory;
use crate::update::UpdateConfig;
use nalgebra::Isometry3;
use tactus_common::limits::OBSTACLES_MAX;
use tactus_common::message::{FaultReason, SCHEMA_VERSION, Setup};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::MOUNT;
use tactus_common::robot::hand::HandAngles;
use tactus_common::shape::ObjectShape;

/// Lengths (metres), angles (radians) and masses (kilograms) of a set-up beyond this make no sense on a table.
pub const SETUP_MAX: f32 = 10.0;

/// What one mission was told and has learnt.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// As told.
    pub setup: Setup,
    /// Where the object may be at all.
    pub prior: Prior,
    /// Where it is believed to be.
    pub belief: Belief,
    /// What was felt.
    pub store: EvidenceStore,
    /// What the links of the hand told, where they can.
    pub felt: FeltTouches,
    /// How the pose is found.
    pub method: UpdateConfig,
    /// The touches made.
    pub history: TouchHistory,
    /// Where the object is to stand, once it has been grasped for the first time.
    pub goal: Option<PlanarPose>,
}

/// A set-up that has not come yet.
const NO_SETUP: Setup = Setup {
    schema_version: [0; 8],
    shape: ObjectShape::THESIS_BOX,
    guess: PlanarPose { x_m: 0.0, y_m: 0.0, phi_rad: 0.0 },
    interval: Interval { x_m: 0.0, y_m: 0.0, phi_rad: 0.0 },
    obstacles: [None; OBSTACLES_MAX],
    displacement_m: [0.0; 2],
    mass_kg: 0.0,
    trials_max: 0,
    robot_base: MOUNT,
    method: Method::DEFAULT,
};

impl Default for Knowledge {
    /// Nothing yet.
    fn default() -> Self {
        Self {
            setup: NO_SETUP,
            prior: Prior::default(),
            belief: Belief::default(),
            store: EvidenceStore::default(),
            felt: FeltTouches::default(),
            method: UpdateConfig::default(),
            history: TouchHistory::default(),
            goal: None,
        }
    }
}

impl Knowledge {
    /// Takes what a set-up tells, and forgets the rest.
    ///
    /// # Errors
    /// [`FaultReason::SchemaMismatch`], [`FaultReason::NotInImage`] for an optimiser that this image lacks, or
    /// [`FaultReason::BadSetup`] for values that make no sense; nothing has changed
    /// then.
    pub fn begin(&mut self, setup: &Setup) -> Result<(), FaultReason> {
        check(setup)?;
        self.method = UpdateConfig::of(&setup.method).ok_or(FaultReason::BadSetup)?;
        self.setup = *setup;
        self.goal = None;
        self.search_anew(setup.guess, setup.interval);
        Ok(())
    }

    /// Forgets where the object was: it lies somewhere in `guess +- interval`.
    pub fn search_anew(&mut self, guess: PlanarPose, interval: Interval) {
        self.prior = Prior::new(&guess, &interval, &self.setup.shape);
        self.belief = Belief::from_prior(&self.prior);
        self.store.begin(self.setup.shape.top_height_m());
        self.felt.forget();
        self.history = TouchHistory::default();
    }

    /// Records that `toucher` felt the object; `false` if it may have been an obstacle: then it tells nothing about the object
    /// and is not kept.
    pub fn note_contact(
        &mut self,
        world_from_hand: &Isometry3<f32>,
        angles: &HandAngles,
        toucher: Toucher,
        kind: ContactKind,
    ) -> bool {
        if may_have_touched(self.setup.obstacles.iter().flatten(), world_from_hand, angles, toucher) {
            return false;
        }
        // A full store drops the newest and counts it; the touch still counts with what it has.
        let _ = self.store.add_contact(world_from_hand, angles, toucher, kind);
        true
    }

    /// Displacement of the object that remains, metres.
    pub fn displacement_m(&self) -> [f32; 2] {
        match self.goal {
            None => self.setup.displacement_m,
            Some(goal) => [goal.x_m - self.belief.pose().x_m, goal.y_m - self.belief.pose().y_m],
        }
    }

    /// Upper triangle of the belief's covariance: xx, xy, xphi, yy, yphi, phiphi.
    pub fn covariance(&self) -> [f32; 6] {
        let c = self.belief.covariance();
        [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]]
    }
}

/// Whether a set-up makes sense.
///
/// # Errors
/// [`FaultReason::SchemaMismatch`], [`FaultReason::NotInImage`] for an optimiser that this image lacks, or
/// [`FaultReason::BadSetup`] for values that make no sense.
pub fn check(setup: &Setup) -> Result<(), FaultReason> {
    if u64::from_le_bytes(setup.schema_version) != SCHEMA_VERSION {
        return Err(FaultReason::SchemaMismatch);
    }
    if !is_sound(setup) {
        return Err(FaultReason::BadSetup);
    }
    let is_built_in = UpdateConfig::of(&setup.method).is_some_and(|config| config.optimiser.is_built_in());
    if is_built_in { Ok(()) } else { Err(FaultReason::NotInImage) }
}

/// Finite and of a size that a table has. Comparisons with a NaN are false.
fn is_sound(setup: &Setup) -> bool {
    let near = |v: &f32| v.abs() <= SETUP_MAX;
    let is_shape = |shape: &ObjectShape| shape.is_valid() && shape.half_extents_m().iter().all(near);
    is_shape(&setup.shape)
        && setup.obstacles.iter().flatten().all(|o| is_shape(&o.shape) && o.pose.to_array().iter().all(near))
        && setup.guess.to_array().iter().all(near)
        && setup.interval.to_array().iter().all(|w| *w >= 0.0 && near(w))
        && setup.displacement_m.iter().all(near)
        && (0.0..=SETUP_MAX).contains(&setup.mass_kg)
        && setup.trials_max > 0
        && setup.robot_base.to_array().iter().all(near)
        && UpdateConfig::of(&setup.method).is_some()
}
