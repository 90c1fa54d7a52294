//! Numbers in a page: many in little room, and as typed arrays at once where they are read.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Largest quantised value: 16 bits.
const STEPS: f32 = 65_535.0;

/// An array of numbers: value i = `offset + scale * raw[i]`, where `raw` are `kind`s, little-endian, in base64.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Packed {
    kind: &'static str,
    offset: f32,
    scale: f32,
    data: String,
}

impl Packed {
    /// Values that keep all their digits, such as times.
    pub fn exact(values: impl IntoIterator<Item = f32>) -> Self {
        let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        Self { kind: "f32", offset: 0.0, scale: 1.0, data: STANDARD.encode(&bytes) }
    }

    /// Counts and indices.
    pub fn counts(values: impl IntoIterator<Item = u32>) -> Self {
        let bytes: Vec<u8> = values.into_iter().flat_map(u32::to_le_bytes).collect();
        Self { kind: "u32", offset: 0.0, scale: 1.0, data: STANDARD.encode(&bytes) }
    }

    /// Values for the eye: 16 bits each over their range, so that none is off by more than a 131,000th of it. What is
    /// not finite becomes the least of them.
    pub fn quantised(values: &[f32]) -> Self {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let low = finite().fold(f32::INFINITY, f32::min);
        let high = finite().fold(f32::NEG_INFINITY, f32::max);
        let (offset, span) = if low <= high { (low, high - low) } else { (0.0, 0.0) };
        let raw = |v: &f32| if v.is_finite() && span > 0.0 { ((v - offset) / span * STEPS).round() as u16 } else { 0 };
        let bytes: Vec<u8> = values.iter().flat_map(|v| raw(v).to_le_bytes()).collect();
        Self { kind: "u16", offset, scale: span / STEPS, data: STANDARD.encode(&bytes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes(packed: &Packed) -> Vec<u8> {
        STANDARD.decode(&packed.data).unwrap()
    }

    fn unpacked(packed: &Packed) -> Vec<f32> {
        let raw = bytes(packed);
        let values = raw.chunks(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]])));
        values.map(|raw| packed.offset + packed.scale * raw).collect()
    }

    #[test]
    fn values_that_are_all_the_same_come_back_and_what_is_no_number_is_the_least() {
        assert_eq!(unpacked(&Packed::quantised(&[0.3, 0.3])), [0.3, 0.3]);
        assert_eq!(unpacked(&Packed::quantised(&[f32::NAN, 2.0, 1.0])), [1.0, 2.0, 1.0]);
        assert_eq!(unpacked(&Packed::quantised(&[f32::NAN])), [0.0]);
        assert_eq!(Packed::quantised(&[]).data, "");
    }

    proptest! {
        #[test]
        fn no_value_moves_by_more_than_half_a_step(values in prop::collection::vec(-3.0f32..50.0, 1..200)) {
            let span = values.iter().copied().fold(f32::MIN, f32::max) - values.iter().copied().fold(f32::MAX, f32::min);
            for (before, after) in values.iter().zip(unpacked(&Packed::quantised(&values))) {
                prop_assert!((before - after).abs() <= 0.51 * span / STEPS + 1e-5, "{before} {after}");
            }
        }

        #[test]
        fn exact_values_keep_every_bit(values in prop::collection::vec(any::<f32>(), 0..50)) {
            let raw = bytes(&Packed::exact(values.iter().copied()));
            let read = raw.chunks(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            prop_assert!(read.eq(values.iter().map(|v| v.to_bits())));
        }
    }
}
