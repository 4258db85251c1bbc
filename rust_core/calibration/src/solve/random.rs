//! Reproducible random numbers: SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators",
//! 2014).

#[derive(Debug, Clone)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    /// Creates a generator for a seed and one of its streams.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut generator = Self(seed ^ stream.wrapping_mul(0xa076_1d64_78bd_642f));
        generator.next();
        generator
    }

    /// Next 64 bits.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// Integer from 0 to `end`, exclusive.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.next()) * end as u128) >> 64) as usize
    }

    /// Number from 0 to 1, exclusive.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Distinct integers below `end`, which must be at least `N`.
    pub(crate) fn distinct<const N: usize>(&mut self, end: usize) -> [usize; N] {
        let mut drawn = [0; N];
        for count in 0..N {
            let mut number = self.below(end);
            while drawn[..count].contains(&number) {
                number = self.below(end);
            }
            drawn[count] = number;
        }
        drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_repeat_and_streams_differ() {
        let draw = |seed, stream| {
            let mut random = SplitMix64::new(seed, stream);
            [random.next(), random.next(), random.next()]
        };
        assert_eq!(draw(7, 0), draw(7, 0));
        assert_ne!(draw(7, 0), draw(7, 1));
        assert_ne!(draw(7, 0), draw(8, 0));
    }

    #[test]
    fn drawn_numbers_are_different_and_even() {
        let mut random = SplitMix64::new(1, 0);
        let mut counts = [0; 8];
        for _ in 0..1000 {
            let drawn = random.distinct::<6>(8);
            for (i, number) in drawn.iter().enumerate() {
                assert!(!drawn[..i].contains(number));
                counts[*number] += 1;
            }
        }
        assert!(counts.iter().all(|count| (680..820).contains(count)), "{counts:?}");
        let mean = (0..10_000).map(|_| random.unit()).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01);
    }
}
