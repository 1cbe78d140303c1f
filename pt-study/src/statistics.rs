//! Means with intervals, and whether a difference is more than noise.
//!
//! The cells of a variant fall into *strata*: a stratum is a scene with a camera, a size and a backend, and its values differ in the seed alone. Scenes are
//! chosen, not drawn, so that only the spread within strata is noise: the variance of the mean is the sum over strata of w^2 s^2 / n,
//! where n values with the variance s^2 have the part w of all cells.
//!
//! * **Interval.** A percentile bootstrap covers too little with few seeds (at 5 values about 84 instead of 95 %). With 5 values or more in each
//!   stratum the interval is a bootstrap-t (Efron and Tibshirani 1993, section 12.5): the quantiles of the studentized mean over resamples within
//!   the strata. With 2 to 4 values resamples have too often no spread, and the interval is Student's, with the degrees of freedom of
//!   Welch and Satterthwaite. With one value a stratum there is none.
//! * **p-value.** Two-sided, Student's distribution of the same statistic.
//! * **Many comparisons.** [`holm`] corrects the p-values of all comparisons of a study together.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Resamples of the bootstrap.
const RESAMPLES: usize = 1999;

/// Seed of the resamples: the same values give the same interval.
const SEED: u64 = 0x05ee_d0f5_7a71_5717;

/// Fewest values of a stratum for the bootstrap.
pub(crate) const FEWEST_FOR_BOOTSTRAP: usize = 5;

/// Probability that an interval misses the mean, and largest p-value of a difference that is shown.
pub const LEVEL: f64 = 0.05;

/// A range that contains the mean of the population with a probability of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Mean of a sample in strata.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean over all values.
    pub mean: f64,
    /// 95 % interval of the mean; `None` unless each stratum has two values.
    pub interval: Option<Interval>,
    /// Probability of a mean this far from 0 if the true mean is 0; `None` as the interval.
    pub p: Option<f64>,
}

/// Estimates the mean of values in strata; `None` without values. Empty strata do not count.
pub fn estimate<S: AsRef<[f64]>>(strata: &[S]) -> Option<Estimate> {
    let strata: Vec<&[f64]> = strata.iter().map(AsRef::as_ref).filter(|values| !values.is_empty()).collect();
    let Studentized { mean, error, freedom } =
        Studentized::of(strata.iter().map(|values| moments(values.iter().copied())))?;
    let Some(freedom) = freedom else { return Some(Estimate { mean, interval: None, p: None }) };
    if error == 0.0 {
        let p = if mean == 0.0 { 1.0 } else { 0.0 };
        return Some(Estimate { mean, interval: Some(Interval { low: mean, high: mean }), p: Some(p) });
    }
    let student = StudentsT::new(0.0, 1.0, freedom).ok();
    let p = student.map(|student| (2.0 * student.cdf(-(mean / error).abs())).min(1.0));
    let quantiles = if strata.iter().all(|values| values.len() >= FEWEST_FOR_BOOTSTRAP) {
        Some(bootstrap_quantiles(&strata, mean))
    } else {
        student.map(|student| [LEVEL / 2.0, 1.0 - LEVEL / 2.0].map(|q| student.inverse_cdf(q)))
    };
    let interval =
        quantiles.map(|[low, high]| Interval { low: mean - high * error, high: mean - low * error });
    Some(Estimate { mean, interval, p })
}

/// Mean of errors, ratios or times in strata and its interval, as [`estimate`]. Where no value is negative, neither is the interval: of values with
/// a heavy tail it would reach below 0.
pub(crate) fn mean_and_interval<S: AsRef<[f64]>>(strata: &[S]) -> (Option<f64>, Option<Interval>) {
    let lowest = strata.iter().flat_map(AsRef::as_ref).fold(0.0f64, |low, v| low.min(*v));
    let found = estimate(strata);
    let cut = |i: Interval| if lowest < 0.0 { i } else { Interval { low: i.low.max(0.0), ..i } };
    (found.map(|e| e.mean), found.and_then(|e| e.interval).map(cut))
}

/// A p-value among others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corrected {
    /// The p-value, corrected for their number.
    pub p: f64,
    /// Error rate of an interval that excludes 0 where the corrected p-value is below the error rate of all, and contains it otherwise.
    pub level: f64,
}

/// Corrects p-values for their number (Holm 1979); the order stays. `rate`: probability of any error among all of them.
pub fn holm(p: &[f64], rate: f64) -> Vec<Corrected> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut corrected = vec![Corrected { p: 1.0, level: rate }; p.len()];
    let mut last = Corrected { p: 0.0, level: rate };
    for (rank, &i) in order.iter().enumerate() {
        let comparisons = (p.len() - rank) as f64;
        // From the first difference that is not shown on, none is, and all have its level.
        let level = if last.p < rate { rate / comparisons } else { last.level };
        last = Corrected { p: last.p.max((comparisons * p[i]).min(1.0)), level };
        corrected[i] = last;
    }
    corrected
}

/// Number, mean and variance of values.
#[derive(Clone, Copy)]
struct Moments {
    count: f64,
    mean: f64,
    variance: f64,
}

/// Of at least one value (Welford 1962); the variance of a single one is 0.
fn moments(values: impl Iterator<Item = f64>) -> Moments {
    let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        count += 1.0;
        let difference = value - mean;
        mean += difference / count;
        squares += difference * (value - mean);
    }
    Moments { count, mean, variance: if count > 1.0 { squares / (count - 1.0) } else { 0.0 } }
}

/// A mean over strata and its standard error.
struct Studentized {
    mean: f64,
    error: f64,
    /// Degrees of freedom; `None` where a stratum has one value.
    freedom: Option<f64>,
}

impl Studentized {
    fn of(strata: impl Iterator<Item = Moments> + Clone) -> Option<Self> {
        let total: f64 = strata.clone().map(|m| m.count).sum();
        if total == 0.0 {
            return None;
        }
        let mean = strata.clone().map(|m| m.count / total * m.mean).sum();
        // w^2 s^2 / n, with w = n / total.
        let part = |m: &Moments| m.count * m.variance / (total * total);
        let variance: f64 = strata.clone().map(|m| part(&m)).sum();
        let single = strata.clone().any(|m| m.count < 2.0);
        let below: f64 = strata.map(|m| part(&m).powi(2) / (m.count - 1.0).max(1.0)).sum();
        let freedom = (!single).then(|| if below > 0.0 { variance * variance / below } else { 1.0 });
        Some(Self { mean, error: variance.sqrt(), freedom })
    }
}

/// Quantiles of (mean* - mean) / error* over resamples within the strata.
fn bootstrap_quantiles(strata: &[&[f64]], mean: f64) -> [f64; 2] {
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut resample = Vec::new();
    let mut drawn: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            resample.clear();
            for values in strata {
                resample.push(moments(values.iter().map(|_| values[random.usize(..values.len())])));
            }
            let Some(Studentized { mean: m, error, .. }) = Studentized::of(resample.iter().copied()) else {
                return 0.0;
            };
            match (m - mean, error) {
                (0.0, _) => 0.0,
                (difference, 0.0) => difference.signum() * f64::INFINITY,
                (difference, error) => difference / error,
            }
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let rank = ((RESAMPLES + 1) as f64 * LEVEL / 2.0).round() as usize;
    [drawn[rank - 1], drawn[RESAMPLES - rank]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source of random values whose mean is 1, from one uniform generator.
    type Draw = fn(&mut fastrand::Rng) -> f64;

    fn normal(random: &mut fastrand::Rng) -> f64 {
        (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (std::f64::consts::TAU * random.f64()).cos()
    }

    /// Errors of pictures: normal, and skewed with a spread of 30 % and of 50 %.
    const SOURCES: [(&str, Draw); 3] = [
        ("normal", |random| 1.0 + normal(random)),
        ("log-normal", |random| (0.3 * normal(random) - 0.045).exp()),
        ("gamma", |random| -(0..4).map(|_| (1.0 - random.f64()).ln()).sum::<f64>() / 4.0),
    ];

    /// Standard error of a coverage from 1000 intervals: 0.7 %.
    const RUNS: usize = 1000;

    #[test]
    fn intervals_cover_the_mean_in_95_of_100_studies() {
        for (name, draw) in SOURCES {
            // Strata and seeds of each; the strata differ by a constant, as scenes do.
            for (strata, seeds) in [(1, 5), (1, 20), (2, 5), (3, 3)] {
                let mut random = fastrand::Rng::with_seed(strata as u64 * 100 + seeds as u64);
                let truth = 1.0 + (strata - 1) as f64 / 2.0;
                let covered = (0..RUNS)
                    .filter(|_| {
                        let sample: Vec<Vec<f64>> = (0..strata)
                            .map(|s| (0..seeds).map(|_| s as f64 + draw(&mut random)).collect())
                            .collect();
                        let found = estimate(&sample).and_then(|e| e.interval).unwrap();
                        (found.low..=found.high).contains(&truth)
                    })
                    .count();
                let share = covered as f64 / RUNS as f64;
                assert!((0.93..=0.97).contains(&share), "{name}, {strata} strata of {seeds}: {share}");
            }
        }
    }

    #[test]
    fn intervals_of_errors_are_not_negative() {
        let heavy = [0.1, 0.11, 0.12, 9.0, 0.1];
        assert!(estimate(&[heavy]).unwrap().interval.unwrap().low < 0.0);
        let (mean, interval) = mean_and_interval(&[heavy]);
        assert_eq!(interval.map(|i| i.low), Some(0.0));
        assert!((mean.unwrap() - 1.886).abs() < 1e-9);
        let signed = heavy.map(|v| v - 0.2);
        assert_eq!(mean_and_interval(&[signed]).1, estimate(&[signed]).unwrap().interval);
    }

    /// With two values Student's interval is wide, and in several strata, whose degrees of freedom are not known well, a little too wide.
    #[test]
    fn intervals_of_two_seeds_cover_at_least_as_often() {
        for (name, draw) in SOURCES {
            for strata in [1, 2, 4] {
                let mut random = fastrand::Rng::with_seed(strata as u64);
                let covered = (0..RUNS)
                    .filter(|_| {
                        let sample: Vec<[f64; 2]> =
                            (0..strata).map(|_| [0, 1].map(|_| draw(&mut random))).collect();
                        let found = estimate(&sample).and_then(|e| e.interval).unwrap();
                        (found.low..=found.high).contains(&1.0)
                    })
                    .count();
                let share = covered as f64 / RUNS as f64;
                assert!((0.93..=0.99).contains(&share), "{name}, {strata} strata of 2: {share}");
            }
        }
    }

    /// Without a difference p-values are uniform: 5 % of them are below 0.05.
    #[test]
    fn p_values_of_noise_are_uniform() {
        for (name, draw) in SOURCES {
            let mut random = fastrand::Rng::with_seed(7);
            let p: Vec<f64> = (0..RUNS)
                .map(|_| {
                    let pair = |_| draw(&mut random) - draw(&mut random);
                    let sample: Vec<f64> = (0..4).map(pair).collect();
                    estimate(&[sample]).and_then(|e| e.p).unwrap()
                })
                .collect();
            for level in [0.05, 0.5] {
                let share = p.iter().filter(|&&p| p < level).count() as f64 / RUNS as f64;
                // Student's test keeps its level for differences, which are symmetric, and is a little cautious where tails are heavy.
                assert!((0.7 * level..=1.2 * level).contains(&share), "{name}: {share} below {level}");
            }
        }
    }

    #[test]
    fn holm_is_as_worked_by_hand() {
        let found = holm(&[0.01, 0.04, 0.03, 0.005], 0.05);
        assert_eq!(found.iter().map(|c| c.p).collect::<Vec<_>>(), [0.03, 0.06, 0.06, 0.02]);
        let levels: Vec<_> = found.iter().map(|c| c.level).collect();
        assert_eq!(levels, [0.05 / 3.0, 0.025, 0.025, 0.0125], "0.03 is the first one that is not shown");
        assert_eq!(holm(&[0.9, 0.8], 0.05), [Corrected { p: 1.0, level: 0.025 }; 2]);
        assert!(holm(&[], 0.05).is_empty());
    }

    /// Of 20 comparisons without a difference, one is wrongly shown in at most 5 % of the studies.
    #[test]
    fn many_comparisons_raise_few_false_alarms() {
        let mut random = fastrand::Rng::with_seed(11);
        let alarms = (0..RUNS)
            .filter(|_| {
                let p: Vec<f64> = (0..20)
                    .map(|_| {
                        let sample: Vec<f64> = (0..4).map(|_| normal(&mut random)).collect();
                        estimate(&[sample]).and_then(|e| e.p).unwrap()
                    })
                    .collect();
                holm(&p, LEVEL).iter().any(|corrected| corrected.p < LEVEL)
            })
            .count();
        assert!(alarms as f64 <= 0.065 * RUNS as f64, "{alarms} of {RUNS}");
    }

    #[test]
    fn what_cannot_be_told_is_absent() {
        assert_eq!(estimate::<Vec<f64>>(&[]), None);
        let one = estimate(&[vec![2.0], vec![4.0]]).unwrap();
        assert_eq!((one.mean, one.interval, one.p), (3.0, None, None));
        // The same picture each time.
        let same = estimate(&[vec![0.0, 0.0], vec![0.0, 0.0]]).unwrap();
        assert_eq!((same.mean, same.p), (0.0, Some(1.0)));
        let certain = estimate(&[vec![0.5, 0.5]]).unwrap();
        assert_eq!((certain.interval, certain.p), (Some(Interval { low: 0.5, high: 0.5 }), Some(0.0)));
    }

    /// Values of a table of Student's distribution: three values, two degrees of freedom, quantile 4.303.
    #[test]
    fn few_values_have_students_interval() {
        let found = estimate(&[vec![1.0, 2.0, 3.0]]).unwrap();
        let Interval { low, high } = found.interval.unwrap();
        let half = 4.303 / 3f64.sqrt();
        assert!((low - (2.0 - half)).abs() < 1e-3 && (high - (2.0 + half)).abs() < 1e-3, "{low} {high}");
        assert!((found.p.unwrap() - 0.0742).abs() < 1e-3);
    }
}
