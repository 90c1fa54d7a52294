//! Random numbers of the world.

use tactus_common::random::Random;

/// A stream of random numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise(Random);

impl Noise {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(Random::new(seed))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.0.unit()
    }

    /// Uniform in [-1, 1).
    pub fn symmetric(&mut self) -> f32 {
        self.0.symmetric()
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
        self.0.clone().bits()
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
}
