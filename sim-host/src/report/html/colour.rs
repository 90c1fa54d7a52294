//! Colours of numbers: perceptually uniform maps that colour-blind readers can tell apart, and scales.

use super::number::{percent, quantile, sig, ticks};

/// A colour map by a few of its published points, equally spaced, dark to bright; straight lines between them.
pub type Map = &'static [[u8; 3]];

/// viridis (van der Walt and Smith, public domain).
pub const VIRIDIS: Map = &[
    [0x44, 0x01, 0x54],
    [0x48, 0x24, 0x75],
    [0x41, 0x44, 0x87],
    [0x35, 0x5f, 0x8d],
    [0x2a, 0x78, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x22, 0xa8, 0x84],
    [0x44, 0xbf, 0x70],
    [0x7a, 0xd1, 0x51],
    [0xbd, 0xdf, 0x26],
    [0xfd, 0xe7, 0x25],
];

/// cividis (Nuñez, Anderton and Renslow 2018, public domain).
pub const CIVIDIS: Map = &[
    [0x00, 0x22, 0x4e],
    [0x12, 0x35, 0x70],
    [0x3b, 0x49, 0x6c],
    [0x57, 0x5d, 0x6d],
    [0x70, 0x71, 0x73],
    [0x8a, 0x86, 0x78],
    [0xa5, 0x9c, 0x74],
    [0xc3, 0xb3, 0x69],
    [0xe1, 0xcc, 0x55],
    [0xfe, 0xe8, 0x38],
];

/// The colour at `t` in [0, 1] as `#rrggbb`.
fn colour(map: Map, t: f64) -> String {
    let place = t.clamp(0.0, 1.0) * (map.len() - 1) as f64;
    let i = (place.floor() as usize).min(map.len() - 2);
    let part = place - i as f64;
    let mixed = |c: usize| (f64::from(map[i][c]) * (1.0 - part) + f64::from(map[i + 1][c]) * part).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}

/// Beyond this ratio of its largest to its 10 % value, a range is shown by powers of ten.
const LOG_RATIO: f64 = 100.0;
/// Beyond this multiple of the 98 % value, a range is clipped there.
const CLIP_RATIO: f64 = 3.0;

/// The next lower 1, 2 or 5 times a power of ten.
fn round_down(v: f64) -> f64 {
    let decade = 10f64.powf(v.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|m| m * decade).find(|r| *r <= v * 1.000_001).unwrap_or(decade)
}

/// From numbers to colours.
#[derive(Clone, Debug)]
pub struct Scale {
    low: f64,
    high: f64,
    log: bool,
    map: Map,
    /// Bright means small.
    reversed: bool,
    note: String,
}

impl Scale {
    /// The scale that suits a set of error values: by powers of ten where they span many, clipped where a few are far above all others.
    pub fn fit(values: &[f64]) -> Self {
        let q = |p| quantile(values.iter().map(|v| Some(*v)), p).unwrap_or(0.0);
        let (low, p10, p98, high) = (q(0.0), q(0.1), q(0.98), q(1.0));
        let positive: Vec<f64> = values.iter().copied().filter(|v| *v > 0.0).collect();
        let scale = |low, high, log, note| Self { low, high, log, map: VIRIDIS, reversed: false, note };
        if low >= 0.0 && p10 > 0.0 && p98 / p10 > LOG_RATIO {
            // Below a millionth of the largest nothing is told apart: zero has no logarithm.
            let least = positive.iter().copied().fold(f64::INFINITY, f64::min);
            let floor = least.max(high * 1e-6);
            let below = values.iter().filter(|v| **v < floor).count();
            let note = match below {
                0 => "logarithmic".into(),
                n => format!("logarithmic; {n} smaller value{} in the lowest colour", if n == 1 { "" } else { "s" }),
            };
            return scale(floor, high, true, note);
        }
        if low >= 0.0 && high > CLIP_RATIO * p98 && p98 > low {
            let share = percent(values.iter().filter(|v| **v > p98).count() as f64 / values.len() as f64);
            return scale(low, p98, false, format!("clipped: {share} % lie above, at most {}", sig(high, 3)));
        }
        scale(low, if high > low { high } else { low + 1.0 }, false, "linear".into())
    }

    /// Location errors in millimetres: logarithmic between round numbers, bright = small.
    pub fn location(values_mm: &[f64]) -> Self {
        let q = |p| quantile(values_mm.iter().map(|v| Some(*v)), p).filter(|v| v.is_finite() && *v > 0.0);
        let low = round_down(q(0.02).unwrap_or(0.1)).clamp(1e-3, 10.0);
        // 1 is the mantissa below 2, 2 below 5, 5 below 10.
        let high = (round_down(q(0.99).unwrap_or(100.0)) * 2.5).clamp(low * 10.0, 1e4);
        let high = if high < 1e4 { round_down(high * 1.001) } else { high };
        let outside = values_mm.iter().filter(|v| **v < low || **v > high).count();
        let note = if outside == 0 { "logarithmic".into() } else { "logarithmic, clipped at both ends".to_string() };
        Self { low, high, log: true, map: CIVIDIS, reversed: true, note }
    }

    /// Where `v` lies between the ends: 0..1, clipped.
    pub fn place(&self, v: f64) -> f64 {
        let t = if self.log {
            if v <= self.low { 0.0 } else { (v / self.low).ln() / (self.high / self.low).ln() }
        } else {
            (v - self.low) / (self.high - self.low)
        };
        t.clamp(0.0, 1.0)
    }

    /// The colour of `v`.
    pub fn colour(&self, v: f64) -> String {
        self.colour_at(self.place(v))
    }

    /// The colour at a place on the bar (0..1).
    pub fn colour_at(&self, place: f64) -> String {
        colour(self.map, if self.reversed { 1.0 - place } else { place })
    }

    /// What is to be said on the bar.
    pub fn note(&self) -> &str {
        &self.note
    }

    /// Values with a number on the bar.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if !self.log {
            return ticks(self.low, self.high, 5).0.into_iter().map(|v| (v, sig(v, 3))).collect();
        }
        let decades = (self.high / self.low).log10();
        let factors: &[f64] = if decades <= 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let from = self.low.log10().floor() as i32;
        let to = self.high.log10().ceil() as i32;
        (from..=to)
            .flat_map(|e| factors.iter().map(move |f| f * 10f64.powi(e)))
            .filter(|v| *v >= self.low * 0.999 && *v <= self.high * 1.001)
            .map(|v| (v, sig(v, 2)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_the_map_are_its_published_ones() {
        assert_eq!(colour(VIRIDIS, 0.0), "#440154");
        assert_eq!(colour(VIRIDIS, 1.0), "#fde725");
        assert_eq!(colour(CIVIDIS, 2.0), "#fee838");
    }

    #[test]
    fn the_scale_follows_the_range() {
        let even: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(Scale::fit(&even).note(), "linear");
        let wide: Vec<f64> = (0..100).map(|i| 10f64.powf(f64::from(i) / 20.0)).collect();
        assert_eq!(Scale::fit(&wide).note(), "logarithmic");
        let mut spiked = even;
        spiked.push(1e6);
        assert!(Scale::fit(&spiked).note().starts_with("clipped: 2 %"), "{}", Scale::fit(&spiked).note());
        assert_eq!(Scale::fit(&[2.0, 2.0]).place(2.0), 0.0);
    }

    #[test]
    fn a_log_scale_has_a_place_for_zero() {
        let scale = Scale::location(&[0.1, 1.0, 10.0]);
        assert_eq!(scale.place(0.0), 0.0);
        let places = [0.1, 1.0, 10.0].map(|v| scale.place(v));
        assert!(places[0] == 0.0 && places[1] > 0.3 && places[2] > places[1] && places[2] < 1.0, "{places:?}");
        assert_eq!(scale.ticks().first().map(|t| t.1.as_str()), Some("0.1"));
    }
}
