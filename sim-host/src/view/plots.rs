//! Curves over time, as they are read.

use super::packed::Packed;
use super::payload::{Line, Plot, Scale};

/// Curves with common times.
#[derive(Clone, Debug)]
pub struct Curves {
    title: &'static str,
    unit: &'static str,
    scale: Scale,
    names: &'static [&'static str],
    times_s: Vec<f32>,
    values: Vec<Vec<f32>>,
}

impl Curves {
    /// None yet.
    pub fn new(title: &'static str, unit: &'static str, scale: Scale, names: &'static [&'static str]) -> Self {
        Self { title, unit, scale, names, times_s: Vec::new(), values: vec![Vec::new(); names.len()] }
    }

    /// The next value of each.
    pub fn push(&mut self, at_s: f32, values: &[f32]) {
        self.times_s.push(at_s);
        for (track, value) in self.values.iter_mut().zip(values) {
            track.push(*value);
        }
    }

    /// As the page takes them.
    pub fn finish(self) -> Plot {
        let line = |(name, values): (&&str, &Vec<f32>)| Line {
            name: (*name).to_owned(),
            values: match self.scale {
                Scale::Linear => Packed::quantised(values),
                Scale::Log => Packed::exact(values.iter().copied()),
            },
        };
        Plot {
            lines: self.names.iter().zip(&self.values).map(line).collect(),
            title: self.title.to_owned(),
            unit: self.unit.to_owned(),
            scale: self.scale,
            times_s: Packed::exact(self.times_s),
        }
    }
}
