//! Random numbers of the world: PCG, and floats through `libm` only, so that a seed means the same everywhere.

use rand_core::Rng;
use rand_pcg::Pcg32;

/// A stream of random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise(Pcg32);

impl Noise {
    /// The stream of `seed`. Neighbouring seeds are scrambled first: PCG's own seeding leaves them alike.
    pub fn new(seed: u64) -> Self {
        let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self(Pcg32::new(z ^ (z >> 31), 0x00a0_2bdb_f7bb_3c0a))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform in [-1, 1).
    pub fn symmetric(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// A factor uniform in 1 +- `fraction`.
    pub fn factor(&mut self, fraction: f32) -> f32 {
        1.0 + fraction * self.symmetric()
    }

    /// Mean 0, standard deviation 1, within +-3.5 (twelve uniforms would reach +-6; four give light tails, which
    /// suits electronics that clip).
    pub fn normal(&mut self) -> f32 {
        let sum = self.unit() + self.unit() + self.unit() + self.unit();
        (sum - 2.0) * 1.732_050_8
    }

    /// Bits that tell one state of the stream from another, for a digest.
    pub fn fingerprint(&self) -> u32 {
        self.0.clone().next_u32()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_have_the_moments_they_promise() {
        let mut noise = Noise::new(7);
        let n = 20_000;
        let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
        for _ in 0..n {
            let x = f64::from(noise.normal());
            sum += x;
            squares += x * x;
        }
        let mean = sum / f64::from(n);
        assert!(mean.abs() < 0.03, "{mean}");
        assert!((squares / f64::from(n) - 1.0).abs() < 0.05);
    }

    #[test]
    fn neighbouring_seeds_differ() {
        let first: Vec<u32> = (0..50).map(|s| (Noise::new(s).unit() * 1000.0) as u32).collect();
        let mut sorted = first.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert!(sorted.len() > 40, "{first:?}");
    }
}
