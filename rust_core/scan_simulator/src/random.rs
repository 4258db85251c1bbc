//! Reproducible random numbers, on every machine and in any order of threads.
//!
//! SplitMix64 (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", 2014), and normal deviates by Box
//! and Muller's method.

use std::f64::consts::TAU;

/// Random number generator.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
    /// Second normal deviate of a pair.
    second: Option<f64>,
}

impl Random {
    /// Creates the generator of a list of numbers, such as a seed, an image and a row.
    pub fn new(seeds: &[u64]) -> Self {
        let state = seeds.iter().fold(0x9e37_79b9_7f4a_7c15, |state: u64, seed| mixed(state ^ mixed(*seed)));
        Self { state, second: None }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.state)
    }

    /// Number from `low` to `high`, exclusive.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * unit(self.bits())
    }

    /// Integer from `low` to `high`, inclusive.
    pub fn integer(&mut self, low: u32, high: u32) -> u32 {
        let count = f64::from(high.saturating_sub(low)) + 1.0;
        (low + self.uniform(0.0, count) as u32).min(high)
    }

    /// `true` with a probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// Normal deviate: mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        if let Some(second) = self.second.take() {
            return second;
        }
        // 1 - x is never 0.
        let radius = (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt();
        let (sine, cosine) = self.uniform(0.0, TAU).sin_cos();
        self.second = Some(radius * sine);
        radius * cosine
    }
}

/// Number from 0 to 1, exclusive.
pub(crate) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// SplitMix64's finaliser.
pub(crate) fn mixed(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_deviates_have_mean_0_and_deviation_1() {
        let mut random = Random::new(&[7]);
        let all: Vec<f64> = (0..100_000).map(|_| random.normal()).collect();
        let mean = all.iter().sum::<f64>() / 1e5;
        let variance = all.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 1e5;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
        assert!(all.iter().filter(|value| value.abs() > 2.0).count().abs_diff(4550) < 400);
    }

    #[test]
    fn numbers_follow_from_the_seeds_and_their_order() {
        let first = |seeds: &[u64]| Random::new(seeds).bits();
        assert_eq!(first(&[1, 2]), first(&[1, 2]));
        assert_ne!(first(&[1, 2]), first(&[2, 1]));
        assert_ne!(first(&[0]), first(&[0, 0]));
        let mut random = Random::new(&[3]);
        let drawn: Vec<u32> = (0..200).map(|_| random.integer(4, 6)).collect();
        assert!((4..=6).all(|value| drawn.contains(&value)) && drawn.iter().all(|value| (4..=6).contains(value)));
    }
}
