//! Starts of a multi-start search: a low-discrepancy sequence, the same on every machine.

/// Point `index` of the Halton sequence in bases 2, 3, 5 (each component in 0..1), the first being the middle.
///
/// Low discrepancy: any few successive points cover the cube evenly (Halton 1960).
pub fn start(index: u16) -> [f32; 3] {
    if index == 0 {
        return [0.5; 3];
    }
    // Point 1 of the sequence has the middle of x; from 2 on all components differ.
    let n = u32::from(index) + 1;
    [radical_inverse(n, 2), radical_inverse(n, 3), radical_inverse(n, 5)]
}

/// The digits of `n` in `base`, mirrored at the point: in (0, 1).
fn radical_inverse(mut n: u32, base: u32) -> f32 {
    let (mut value, mut weight) = (0.0, 1.0 / base as f32);
    // 17 bits at most come in: 17 digits in base 2.
    for _ in 0..17 {
        value += (n % base) as f32 * weight;
        weight /= base as f32;
        n /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_starts_visit_every_octant() {
        let mut seen = [false; 8];
        for index in 1..17 {
            let p = start(index);
            assert!(p.iter().all(|c| (0.0..1.0).contains(c)), "{p:?}");
            seen[p.iter().enumerate().map(|(axis, c)| usize::from(*c >= 0.5) << axis).sum::<usize>()] = true;
        }
        assert_eq!(seen, [true; 8]);
    }
}
