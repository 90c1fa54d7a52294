//! Where all frames were, sample by sample.

use super::packed::Packed;
use super::payload::Frames;
use crate::recording::scene::{BELIEVED, WORLD};
use anyhow::ensure;
use foxglove::messages::{FrameTransform, FrameTransforms};

/// x, y, z and a quaternion x, y, z, w.
pub type Pose = [f32; 7];

/// Frames as they are read.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    times_s: Vec<f32>,
    tracks: Vec<(String, Vec<Pose>)>,
    believed_z_m: f32,
}

impl Tracks {
    /// The next sample. A frame that is missing in it is where it was; one that is new was always there.
    ///
    /// # Errors
    /// A frame is not posed in the world's.
    pub fn take(&mut self, at_s: f32, message: &FrameTransforms) -> anyhow::Result<()> {
        let before = self.times_s.len();
        self.times_s.push(at_s);
        for transform in &message.transforms {
            let FrameTransform { child_frame_id: child, parent_frame_id: parent, .. } = transform;
            ensure!(parent == WORLD, "the frame {child} is posed in {parent}; expected {WORLD}");
            let pose = pose_of(transform);
            if child == BELIEVED {
                self.believed_z_m = pose[2];
                continue;
            }
            match self.tracks.iter_mut().find(|(name, _)| name == child) {
                Some((_, track)) => track.push(pose),
                None => self.tracks.push((child.clone(), vec![pose; before + 1])),
            }
        }
        for (_, track) in &mut self.tracks {
            // Never empty: it began with a pose.
            let last = track[track.len() - 1];
            track.resize(before + 1, last);
        }
        Ok(())
    }

    /// Height of the believed object's frame above the table, metres.
    pub fn believed_z_m(&self) -> f32 {
        self.believed_z_m
    }

    /// The number of a frame.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.tracks.iter().position(|(known, _)| known == name)
    }

    /// As the page takes them.
    pub fn finish(self) -> Frames {
        Frames {
            times_s: Packed::exact(self.times_s),
            poses: self.tracks.iter().map(|(_, track)| packed(track)).collect(),
            names: self.tracks.into_iter().map(|(name, _)| name).collect(),
        }
    }
}

fn packed(track: &[Pose]) -> Packed {
    let still = track.iter().all(|pose| *pose == track[0]);
    if still { Packed::exact(track[0]) } else { Packed::quantised(track.as_flattened()) }
}

fn pose_of(transform: &FrameTransform) -> Pose {
    let at = transform.translation.unwrap_or_default();
    let turn = transform.rotation.unwrap_or_default();
    [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w].map(|v| v as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use foxglove::messages::Vector3;

    fn sample(frames: &[(&str, f64)]) -> FrameTransforms {
        let transform = |(child, x): &(&str, f64)| FrameTransform {
            parent_frame_id: WORLD.into(),
            child_frame_id: (*child).into(),
            translation: Some(Vector3 { x: *x, y: 0.0, z: 0.1 }),
            ..FrameTransform::default()
        };
        FrameTransforms { transforms: frames.iter().map(transform).collect() }
    }

    #[test]
    fn every_frame_has_a_pose_in_every_sample() {
        let mut tracks = Tracks::default();
        tracks.take(0.0, &sample(&[("a", 1.0)])).unwrap();
        tracks.take(0.1, &sample(&[("a", 2.0), ("b", 5.0), (BELIEVED, 9.0)])).unwrap();
        tracks.take(0.2, &sample(&[("b", 6.0)])).unwrap();
        let xs = |i: usize| tracks.tracks[i].1.iter().map(|pose| pose[0]).collect::<Vec<_>>();
        assert_eq!((xs(0), xs(1)), (vec![1.0, 2.0, 2.0], vec![5.0, 5.0, 6.0]));
        assert_eq!((tracks.find("b"), tracks.find(BELIEVED), tracks.believed_z_m()), (Some(1), None, 0.1));
    }

    #[test]
    fn a_frame_that_is_not_posed_in_the_world_is_refused_by_name() {
        let mut message = sample(&[("tip", 1.0)]);
        message.transforms[0].parent_frame_id = "palm".into();
        let refused = Tracks::default().take(0.0, &message).unwrap_err().to_string();
        assert_eq!(refused, "the frame tip is posed in palm; expected world");
    }
}
