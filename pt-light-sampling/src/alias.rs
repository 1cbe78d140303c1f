use pt_shaders::records::AliasRecord;

/// Resolution of [`AliasRecord::keep`]: the random numbers it is compared with are multiples of 2^-24.
const STEPS: u64 = 1 << 24;

/// A discrete distribution with constant-time picks (Walker 1977, construction of Vose 1991).
///
/// `keep` is rounded to what a 24-bit random number can tell apart, and the probabilities are counted off the rounded
/// table: they are exactly the frequencies of the picks. Every entry with a weight keeps a probability above zero, every
/// entry without one has probability zero.
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    entries: Vec<AliasRecord>,
    /// Of 2^24 x number of entries.
    counts: Vec<u64>,
}

impl AliasTable {
    /// A table for the given weights; `None` when none is positive or one is negative or not finite, or when there are
    /// more than 2^32 - 1.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        let usable = weights.iter().all(|w| *w >= 0.0) && sum > 0.0 && sum.is_finite();
        if !usable || weights.len() >= u32::MAX as usize {
            return None;
        }
        let n = weights.len();
        let mut share: Vec<f64> = weights.iter().map(|w| w / sum * n as f64).collect();
        let heaviest = (0..n).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
        // What rounding leaves over at the end has a share of 1, or never had a weight.
        let mut keep: Vec<u64> = weights.iter().map(|w| if *w > 0.0 { STEPS } else { 0 }).collect();
        let mut alias: Vec<usize> = (0..n).map(|i| if weights[i] > 0.0 { i } else { heaviest }).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| share[i] < 1.0);
        while let (Some(&giver), Some(taker)) = (large.last(), small.pop()) {
            alias[taker] = giver;
            keep[taker] = (share[taker] * STEPS as f64).ceil() as u64;
            share[giver] -= 1.0 - share[taker];
            if share[giver] < 1.0 {
                large.pop();
                small.push(giver);
            }
        }
        let mut counts = keep.clone();
        for (&keep, &alias) in keep.iter().zip(&alias) {
            counts[alias] += STEPS - keep;
        }
        let total = (STEPS * n as u64) as f64;
        let entries = (0..n)
            .map(|i| AliasRecord {
                keep: keep[i] as f32 / STEPS as f32,
                alias: alias[i] as u32,
                pmf: (counts[i] as f64 / total) as f32,
            })
            .collect();
        Some(Self { entries, counts })
    }

    /// The table as the GPU reads it.
    pub fn entries(&self) -> &[AliasRecord] {
        &self.entries
    }

    /// Exact probability of an entry.
    ///
    /// # Panics
    /// When `index` is out of range.
    pub fn pmf(&self, index: usize) -> f64 {
        self.counts[index] as f64 / (STEPS as f64 * self.counts.len() as f64)
    }

    /// Host twin of `alias_pick` (lights.glsl): 32 random bits for the entry, a number in [0, 1) against `keep`.
    pub fn pick(&self, bits: u32, xi: f32) -> usize {
        let entry = (u64::from(bits) * self.entries.len() as u64) >> 32;
        let record = &self.entries[entry as usize];
        if xi < record.keep { entry as usize } else { record.alias as usize }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn refuses_what_is_no_distribution() {
        for weights in [&[][..], &[0.0, 0.0], &[1.0, -1.0], &[f64::NAN], &[f64::INFINITY]] {
            assert_eq!(AliasTable::new(weights), None, "{weights:?}");
        }
    }

    /// Entries that differ by 1e12 keep their order and none vanishes.
    #[test]
    fn no_weight_is_lost() {
        let table = AliasTable::new(&[1e-12, 0.0, 1.0, 3.0]).unwrap();
        assert!(table.pmf(0) > 0.0 && table.entries()[0].pmf > 0.0);
        assert_eq!(table.pmf(1), 0.0);
        assert!((table.pmf(3) - 0.75).abs() < 1e-6);
    }

    proptest! {
        /// The probabilities sum to one exactly, follow the weights, and equal the share of (entry, xi) that picks them.
        #[test]
        fn pmf_is_the_pick_frequency(weights in prop::collection::vec(prop_oneof![Just(0.0), 1e-3..1e3f64], 1..40)) {
            prop_assume!(weights.iter().sum::<f64>() > 0.0);
            let table = AliasTable::new(&weights).unwrap();
            let n = weights.len();
            prop_assert_eq!(table.counts.iter().sum::<u64>(), STEPS * n as u64);
            let sum: f64 = weights.iter().sum();
            let mut picked = vec![0u64; n];
            for (i, entry) in table.entries().iter().enumerate() {
                let kept = (f64::from(entry.keep) * STEPS as f64) as u64;
                picked[i] += kept;
                picked[entry.alias as usize] += STEPS - kept;
                // The bits that select entry i, in the middle of its range.
                let bits = ((2 * i as u64 + 1) * (1 << 31) / n as u64) as u32;
                let before = (entry.keep - 1.0 / STEPS as f32).max(0.0);
                if entry.keep > 0.0 {
                    prop_assert_eq!(table.pick(bits, before), i);
                }
                if entry.keep < 1.0 {
                    prop_assert_eq!(table.pick(bits, entry.keep), entry.alias as usize);
                }
            }
            prop_assert_eq!(&picked, &table.counts);
            for (i, w) in weights.iter().enumerate() {
                prop_assert!((table.pmf(i) - w / sum).abs() < 1e-6, "{} {}", table.pmf(i), w / sum);
                prop_assert_eq!(table.pmf(i) == 0.0, *w == 0.0);
            }
        }
    }
}
