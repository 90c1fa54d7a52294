//! Evidence: what was touched and what is known to be free, over the touches of a mission, in fixed memory.
//!
//! A contact says that one of a finger's links touched the object, a free link that it was clear of it. Both are kept
//! as posed links, so that evaluating a hypothesis needs no hand kinematics.

use heapless::Vec;
use nalgebra::{Isometry3, Point3, Vector3};
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::{HandLink, hand_prism};

/// Touches that are remembered; the oldest is forgotten when one more begins.
pub const TOUCHES_MAX: usize = 8;
/// Contacts that are remembered: three fingers and a landing for each touch.
pub const CONTACTS_MAX: usize = 4 * TOUCHES_MAX;
/// Free links that are remembered: two links of three fingers, and two sweeps of four samples, for each touch.
pub const FREE_LINKS_MAX: usize = 16 * TOUCHES_MAX;
/// Links that one contact may be of: knuckle, inner link, tip.
pub const CONTACT_LINKS_MAX: usize = 3;
/// Configurations kept of a finger that closed without contact; the box is thicker than the steps between them.
pub const SWEEP_SAMPLES: usize = 4;

/// A link above the object's top face by more than this cannot have touched it, metres: height error of the arm.
const HEIGHT_MARGIN_M: f32 = 0.005;

/// A hand link at a place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PosedLink {
    /// World-from-link transform.
    pub world_from_link: Isometry3<f32>,
    /// Centre of the link's bounding sphere in the world, metres.
    pub centre_world_m: Vector3<f32>,
    /// Which link.
    pub link: HandLink,
}

impl PosedLink {
    fn new(world_from_link: Isometry3<f32>, link: HandLink) -> Self {
        let centre = hand_prism(link).bounding_sphere().0;
        Self { world_from_link, centre_world_m: (world_from_link * Point3::from(centre)).coords, link }
    }

    /// Height of the link's lowest point above the table, metres.
    fn lowest_m(&self) -> f32 {
        let prism = hand_prism(self.link);
        let mut lowest_m = f32::MAX;
        for corner in prism.corners_m {
            for z in prism.z_m {
                lowest_m = lowest_m.min((self.world_from_link * Point3::new(corner[0], corner[1], z)).z);
            }
        }
        lowest_m
    }
}

/// How a contact came about: what its residual is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactKind {
    /// A finger closed until it felt something.
    Closing,
    /// The hand came down until something was felt, mostly the top face.
    Landing,
    /// A finger of a closed grasp: pressed harder, so deeper and less exact.
    Grasp,
}

/// What felt a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toucher {
    /// One of the links of finger 0, 1 or 2.
    Finger(usize),
    /// The palm.
    Palm,
}

impl Toucher {
    /// Can it have been this link that felt the contact?
    pub fn has(self, link: HandLink) -> bool {
        match self {
            Self::Finger(finger) => link.finger() == Some(finger),
            Self::Palm => link == HandLink::Palm,
        }
    }
}

/// One of these links touched the object.
#[derive(Clone, Debug)]
pub struct Contact {
    /// The links that it can have been.
    pub links: Vec<PosedLink, CONTACT_LINKS_MAX>,
    /// Running number of the touch.
    pub touch: u8,
    /// How it came about.
    pub kind: ContactKind,
}

/// This link did not touch the object.
#[derive(Clone, Copy, Debug)]
pub struct FreeLink {
    /// The link and where it was.
    pub posed: PosedLink,
    /// Running number of the touch.
    pub touch: u8,
}

/// Why a piece of evidence was not stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// No room left; counted in [`EvidenceStore::dropped`].
    Full,
    /// A pose or an angle was not a finite number, or there is no such finger.
    Invalid,
}

/// All evidence about one object that stands still but for small shifts. About 11 KiB.
#[derive(Clone, Debug, Default)]
pub struct EvidenceStore {
    contacts: Vec<Contact, CONTACTS_MAX>,
    free: Vec<FreeLink, FREE_LINKS_MAX>,
    top_height_m: f32,
    touch: u8,
    dropped: u16,
}

impl EvidenceStore {
    /// An empty store for an object whose highest point stands `top_height_m` above the table, metres.
    pub fn new(top_height_m: f32) -> Self {
        Self { contacts: Vec::new(), free: Vec::new(), top_height_m, touch: 0, dropped: 0 }
    }

    /// Starts a new touch; what follows belongs to it. Forgets the touch that is [`TOUCHES_MAX`] back.
    pub fn begin_touch(&mut self) {
        self.touch = self.touch.saturating_add(1);
        let oldest = self.touch.saturating_sub(TOUCHES_MAX as u8 - 1);
        self.forget_before(oldest);
    }

    /// Forgets all evidence of touches before `touch`: the object was moved.
    pub fn forget_before(&mut self, touch: u8) {
        self.contacts.retain(|c| c.touch >= touch);
        self.free.retain(|f| f.touch >= touch);
    }

    /// Forgets everything: what follows is about an object whose highest point stands `top_height_m` above the table,
    /// metres.
    pub fn begin(&mut self, top_height_m: f32) {
        self.contacts.clear();
        self.free.clear();
        (self.top_height_m, self.touch, self.dropped) = (top_height_m, 0, 0);
    }

    /// Number of the touch under way; 0 before the first.
    pub fn touch(&self) -> u8 {
        self.touch
    }

    /// The contacts, oldest first.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The free links, oldest first.
    pub fn free(&self) -> &[FreeLink] {
        &self.free
    }

    /// Pieces of evidence that found no room.
    pub fn dropped(&self) -> u16 {
        self.dropped
    }

    /// Touches ago that `touch` was; 0 = the one under way.
    pub fn age(&self, touch: u8) -> u8 {
        self.touch.saturating_sub(touch)
    }

    /// Records that `toucher` felt the object with the hand at `world_from_hand` and these angles.
    ///
    /// # Errors
    /// [`StoreError::Invalid`] for numbers that are not finite or no such finger, [`StoreError::Full`] without room.
    pub fn add_contact(
        &mut self,
        world_from_hand: &Isometry3<f32>,
        angles: &HandAngles,
        toucher: Toucher,
        kind: ContactKind,
    ) -> Result<(), StoreError> {
        let poses = checked_poses(world_from_hand, angles)?;
        let mut links: Vec<PosedLink, CONTACT_LINKS_MAX> = Vec::new();
        let mut lowest: Option<(f32, PosedLink)> = None;
        for (link, pose) in HandLink::ALL.iter().zip(poses) {
            if !toucher.has(*link) {
                continue;
            }
            let posed = PosedLink::new(pose, *link);
            let height_m = posed.lowest_m();
            if lowest.as_ref().is_none_or(|(least_m, _)| height_m < *least_m) {
                lowest = Some((height_m, posed));
            }
            if height_m < self.top_height_m + HEIGHT_MARGIN_M {
                // Three links at most belong to one toucher.
                let _ = links.push(posed);
            }
        }
        let (_, lowest_link) = lowest.ok_or(StoreError::Invalid)?;
        if links.is_empty() {
            let _ = links.push(lowest_link);
        }
        self.contacts.push(Contact { links, touch: self.touch, kind }).map_err(|_| self.count_drop())
    }

    /// Records that the links of the fingers marked in `fingers`, and the palm, were clear of the object in this
    /// configuration. Links above the object's top say nothing and take no room.
    ///
    /// # Errors
    /// As [`Self::add_contact`].
    pub fn add_free(
        &mut self,
        world_from_hand: &Isometry3<f32>,
        angles: &HandAngles,
        fingers: [bool; 3],
    ) -> Result<(), StoreError> {
        let poses = checked_poses(world_from_hand, angles)?;
        for (link, pose) in HandLink::ALL.iter().zip(poses) {
            let wanted = match link.finger() {
                Some(finger) => fingers.get(finger).copied().unwrap_or(false),
                None => true,
            };
            let posed = PosedLink::new(pose, *link);
            if wanted && posed.lowest_m() < self.top_height_m {
                self.free.push(FreeLink { posed, touch: self.touch }).map_err(|_| self.count_drop())?;
            }
        }
        Ok(())
    }

    /// Records that `finger` closed from `angles` to the inner angle `end_inner_rad` without touching anything.
    ///
    /// # Errors
    /// As [`Self::add_contact`].
    pub fn add_free_sweep(
        &mut self,
        world_from_hand: &Isometry3<f32>,
        angles: &HandAngles,
        finger: usize,
        end_inner_rad: f32,
    ) -> Result<(), StoreError> {
        let start_rad = *angles.inner_rad.get(finger).ok_or(StoreError::Invalid)?;
        let mut only = [false; 3];
        only[finger] = true;
        for sample in 1..=SWEEP_SAMPLES {
            let share = sample as f32 / SWEEP_SAMPLES as f32;
            let mut inner_rad = angles.inner_rad;
            inner_rad[finger] = start_rad + share * (end_inner_rad - start_rad);
            self.add_free(world_from_hand, &HandAngles::engaged(inner_rad, angles.spread_rad), only)?;
        }
        Ok(())
    }

    fn count_drop(&mut self) -> StoreError {
        self.dropped = self.dropped.saturating_add(1);
        StoreError::Full
    }
}

/// The poses of all links, if every number that comes in is finite.
fn checked_poses(world_from_hand: &Isometry3<f32>, angles: &HandAngles) -> Result<[Isometry3<f32>; 9], StoreError> {
    let numbers = world_from_hand.translation.vector.iter().chain(world_from_hand.rotation.coords.iter());
    let angles_finite = angles.inner_rad.iter().chain(&angles.distal_rad).all(|a| a.is_finite());
    if numbers.chain([&angles.spread_rad]).all(|v| v.is_finite()) && angles_finite {
        Ok(hand::link_poses(world_from_hand, angles))
    } else {
        Err(StoreError::Invalid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::{candidate, rehearse::rehearse};
    use tactus_common::pose::PlanarPose;
    use tactus_common::shape::ObjectShape;

    const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;

    fn hand_pose() -> Isometry3<f32> {
        candidate(0, &SHAPE).expect("listed").world_from_hand(&PlanarPose::default(), &SHAPE)
    }

    #[test]
    fn a_touch_across_the_box_gives_three_contacts_and_the_links_below_its_top() {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        let plan = candidate(0, &SHAPE).expect("listed");
        rehearse(&mut store, &plan, &PlanarPose::default(), &PlanarPose::default(), &SHAPE);
        assert_eq!(store.contacts().len(), 3);
        assert_eq!(store.free().len(), 3, "opened, only the tips hang below the top");
        assert!(store.free().iter().all(|f| HandLink::TIPS.contains(&f.posed.link)));
    }

    #[test]
    fn the_oldest_touch_is_forgotten_and_a_full_store_counts_what_it_drops() {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        let angles = HandAngles::engaged([1.0; 3], 0.0);
        for _ in 0..20 {
            store.begin_touch();
            for finger in 0..3 {
                let added = store.add_contact(&hand_pose(), &angles, Toucher::Finger(finger), ContactKind::Closing);
                assert_eq!(added, Ok(()));
            }
        }
        assert_eq!(store.contacts().len(), 3 * TOUCHES_MAX);
        assert_eq!(store.contacts()[0].touch as usize, 20 - TOUCHES_MAX + 1);
        for _ in 0..100 {
            let _ = store.add_free(&hand_pose(), &angles, [true; 3]);
        }
        assert!(store.dropped() > 0 && store.free().len() == FREE_LINKS_MAX);
    }

    #[test]
    fn a_number_that_is_none_never_becomes_evidence() {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        let bad = HandAngles::engaged([f32::NAN, 1.0, 1.0], 0.0);
        let good = HandAngles::engaged([1.0; 3], 0.0);
        let nowhere = Isometry3::translation(f32::INFINITY, 0.0, 0.0);
        let closing = ContactKind::Closing;
        assert_eq!(store.add_contact(&hand_pose(), &bad, Toucher::Finger(0), closing), Err(StoreError::Invalid));
        assert_eq!(store.add_contact(&nowhere, &good, Toucher::Palm, closing), Err(StoreError::Invalid));
        assert_eq!(store.add_contact(&hand_pose(), &good, Toucher::Finger(3), closing), Err(StoreError::Invalid));
        assert_eq!(store.add_free(&hand_pose(), &bad, [true; 3]), Err(StoreError::Invalid));
        assert!(store.contacts().is_empty() && store.free().is_empty());
    }

    #[test]
    fn all_state_of_the_estimator_fits_its_budget() {
        use core::mem::size_of;
        let total = size_of::<EvidenceStore>()
            + size_of::<crate::update::Update>()
            + size_of::<crate::touch::Chooser>()
            + size_of::<crate::belief::Belief>();
        assert!(total <= 40 * 1024, "{total} bytes");
    }
}
