//! What has arrived and waits for the tick at which it takes effect.

use tactus_common::limits::PADS;
use tactus_common::link;
use tactus_common::message::{Digest, LinkContact, PlanAnswer, RolloutResult, Setup, TactileSlice};
use tactus_common::reading::TactileImage;

/// What waits; the newest of each kind.
#[derive(Clone, Debug, Default)]
pub struct Pending {
    /// A mission, for the next tick whichever it is.
    pub setup: Option<Setup>,
    /// Images by pad, with the tick at which each takes effect.
    pub images: [Option<(u32, TactileImage)>; PADS],
    /// Link contacts by parity of the tick at which they take effect: those of one tick are there while those of the
    /// tick before still wait.
    links: [Option<LinkContact>; 2],
    /// An answer of the planner.
    pub plan: Option<PlanAnswer>,
    /// An answer of the mental world.
    pub rollout: Option<RolloutResult>,
}

impl Pending {
    /// Nothing waits. In place: a new value would pass over the stack.
    pub fn forget(&mut self) {
        (self.setup, self.images, self.links) = (None, [None; PADS], [None; 2]);
        (self.plan, self.rollout) = (None, None);
    }

    /// Keeps link contacts until their tick.
    pub fn put_links(&mut self, links: LinkContact) {
        let [even, odd] = &mut self.links;
        *(if links.effective().is_multiple_of(2) { even } else { odd }) = Some(links);
    }

    /// What takes effect at tick `now`, or should have done so before.
    pub fn due(&self, now: u32) -> Due<'_> {
        Due {
            setup: self.setup.as_ref(),
            images: self.images.each_ref().map(|image| image.as_ref().filter(|(effective, _)| *effective <= now)),
            links: self.links.each_ref().map(|links| links.as_ref().filter(|links| links.effective() <= now)),
            plan: self.plan.as_ref().filter(|plan| plan.effective <= now),
            rollout: self.rollout.as_ref().filter(|rollout| rollout.effective <= now),
        }
    }

    /// What has taken effect at tick `now` waits no more.
    pub fn forget_until(&mut self, now: u32) {
        self.setup = None;
        for slot in &mut self.images {
            if slot.is_some_and(|(effective, _)| effective <= now) {
                *slot = None;
            }
        }
        for slot in &mut self.links {
            if slot.is_some_and(|links| links.effective() <= now) {
                *slot = None;
            }
        }
        if self.plan.as_ref().is_some_and(|p| p.effective <= now) {
            self.plan = None;
        }
        if self.rollout.as_ref().is_some_and(|r| r.effective <= now) {
            self.rollout = None;
        }
    }
}

/// What takes effect at one tick.
pub struct Due<'a> {
    /// A mission.
    pub setup: Option<&'a Setup>,
    /// Images by pad, with the tick at which each should take effect.
    pub images: [Option<&'a (u32, TactileImage)>; PADS],
    links: [Option<&'a LinkContact>; 2],
    /// An answer of the planner.
    pub plan: Option<&'a PlanAnswer>,
    /// An answer of the mental world.
    pub rollout: Option<&'a RolloutResult>,
}

impl Due<'_> {
    /// Which hand links touch; the newer where one was late.
    pub fn links(&self) -> Option<u16> {
        self.links.iter().flatten().max_by_key(|links| links.effective()).map(|links| links.links())
    }

    /// Adds all of it to a digest, in order of subject.
    pub fn hash(&self, digest: &mut Digest) {
        // Encoding into a digest cannot run out of room.
        if let Some(setup) = self.setup {
            let _ = link::digest(setup, digest);
        }
        for (effective, image) in self.images.iter().flatten() {
            let _ = link::digest(&TactileSlice::pack(image, *effective), digest);
        }
        for links in self.links.iter().flatten() {
            let _ = link::digest(*links, digest);
        }
        if let Some(plan) = self.plan {
            let _ = link::digest(plan, digest);
        }
        if let Some(rollout) = self.rollout {
            let _ = link::digest(rollout, digest);
        }
    }

    /// How many of it should have taken effect before tick `now`.
    pub fn late(&self, now: u32) -> u32 {
        let images = self.images.iter().flatten().map(|(effective, _)| *effective);
        let links = self.links.iter().flatten().map(|links| links.effective());
        let answers = self.plan.map(|p| p.effective).into_iter().chain(self.rollout.map(|r| r.effective));
        images.chain(links).chain(answers).map(|effective| u32::from(effective < now)).sum()
    }
}
