//! Random numbers: PCG, and floats through `libm` only, so that a seed means the same everywhere.

use rand_core::Rng;
use rand_pcg::Pcg32;

/// A stream of random numbers. 16 bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Random(Pcg32);

impl Random {
    /// The stream of `seed`. Neighbouring seeds are scrambled first (Steele, Lea & Flood 2014, SplitMix64): PCG's own
    /// seeding leaves them alike.
    pub fn new(seed: u64) -> Self {
        let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self(Pcg32::new(z ^ (z >> 31), 0x00a0_2bdb_f7bb_3c0a))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform in [-1, 1).
    pub fn symmetric(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// Mean 0, standard deviation 1 (Box & Muller 1958), within +-5.8.
    pub fn normal(&mut self) -> f32 {
        let radius = libm::sqrtf(-2.0 * libm::logf(1.0 - self.unit()));
        radius * libm::cosf(core::f32::consts::TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_seeds_differ() {
        let mut first = [0_u32; 50];
        for (seed, unit) in first.iter_mut().enumerate() {
            *unit = (Random::new(seed as u64).unit() * 1000.0) as u32;
        }
        first.sort_unstable();
        let distinct = 1 + first.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(distinct > 40, "{first:?}");
    }

    #[test]
    fn normals_have_the_moments_they_promise() {
        let mut random = Random::new(7);
        let n = 20_000;
        let (mut sum, mut squares, mut fourths) = (0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..n {
            let x = f64::from(random.normal());
            sum += x;
            squares += x * x;
            fourths += x * x * x * x;
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < 0.03 && (squares / n - 1.0).abs() < 0.04, "{} {}", sum / n, squares / n);
        assert!((fourths / n - 3.0).abs() < 0.3, "{}", fourths / n);
    }
}
