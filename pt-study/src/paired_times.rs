//! Whether a pass has become slower: times of two runs, compared round by round.
//!
//! Times of successive frames are correlated, and the clock of a device drifts, so that frames are no independent samples. A run is therefore
//! a number of rounds, each of which repeats the same frames, and the statistic is the logarithm of the ratio of both medians of a round (the
//! method of batch means). Rounds of the same number are paired: what drifts alike in both runs cancels. The mean over rounds is trimmed, so
//! that a round that another program has disturbed does not decide, with the interval of Tukey and McLaughlin (1963). The passes of a frame
//! are many comparisons: their p-values are corrected by the method of Holm (1979).
//!
//! A difference between two whole runs, such as another clock throughout or other places in memory, cannot be told from a change of the
//! program. The threshold of [`judge`] stands for it, or the rounds come from several runs of both programs in turns: then each run is a round
//! (Kalibera and Jones 2013: repeat at the highest level at which times vary).

use crate::statistics::{Corrected, holm};

/// Share of the rounds that is trimmed at each end.
const TRIM: f64 = 0.1;
/// Fewest rounds that make an interval.
pub const LEAST_ROUNDS: usize = 3;
/// Least standard error of a logarithm of a ratio: medians of a few ticks of a clock can be equal in all rounds.
const LEAST_ERROR: f64 = 1e-4;

/// Probability of an error of [`judge`]: that any pass is called slower or faster where none is.
pub const ERROR_RATE: f64 = 0.05;

/// How the time of a pass has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Median over all frames, before and after, milliseconds.
    pub median_ms: [f64; 2],
    /// Logarithm of the ratio after / before.
    log_ratio: f64,
    /// Its standard error.
    error: f64,
    /// Degrees of freedom of the error.
    freedom: u32,
}

impl Change {
    /// Of a pass whose times, in milliseconds, are given by round. `None`: fewer than [`LEAST_ROUNDS`] rounds with the pass in both runs, or a
    /// median of 0, which a clock that is too coarse shows.
    pub fn of(before: &[Vec<f64>], after: &[Vec<f64>]) -> Option<Self> {
        let ratio = |(before, after): (&Vec<f64>, &Vec<f64>)| {
            let (before, after) = (median(before)?, median(after)?);
            (before > 0.0 && after > 0.0).then(|| (after / before).ln())
        };
        let mut ratios: Vec<f64> = before.iter().zip(after).filter_map(ratio).collect();
        if ratios.len() < LEAST_ROUNDS {
            return None;
        }
        ratios.sort_by(f64::total_cmp);
        let count = ratios.len();
        let trimmed = (TRIM * count as f64) as usize;
        let kept = &ratios[trimmed..count - trimmed];
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        // The variance of the winsorised ratios: those beyond the kept ones count as the last kept one.
        let winsorised = |ratio: &f64| ratio.clamp(kept[0], kept[kept.len() - 1]);
        let centre = ratios.iter().map(winsorised).sum::<f64>() / count as f64;
        let squares: f64 = ratios.iter().map(|ratio| (winsorised(ratio) - centre).powi(2)).sum();
        let variance = squares / (count - 1) as f64;
        let share = kept.len() as f64 / count as f64;
        Some(Self {
            median_ms: [median(&before.concat())?, median(&after.concat())?],
            log_ratio: mean,
            error: (variance / count as f64).sqrt().max(LEAST_ERROR) / share,
            freedom: kept.len() as u32 - 1,
        })
    }

    /// Time after over time before.
    pub fn ratio(&self) -> f64 {
        self.log_ratio.exp()
    }

    /// Probability of a difference at least that large, up or down, if there is none.
    pub fn p_value(&self) -> f64 {
        1.0 - student_within(self.log_ratio.abs() / self.error, self.freedom)
    }

    /// Interval that holds the ratio unless an event of probability `error_rate` has happened.
    pub fn interval(&self, error_rate: f64) -> [f64; 2] {
        let half = student_quantile(error_rate, self.freedom) * self.error;
        [(self.log_ratio - half).exp(), (self.log_ratio + half).exp()]
    }
}

/// What is said of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Slower by more than the threshold, and the interval excludes no change.
    Regression,
    /// Faster by more than the threshold, and the interval excludes no change.
    Improvement,
    /// The interval excludes no change, but the change is not larger than the threshold.
    BelowThreshold,
    /// The interval contains no change.
    NotShown,
}

/// The smallest change that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// As a share: 0.02 = 2 %.
    pub share: f64,
    /// In milliseconds: what a clock and the launch of a pass leave uncertain.
    pub ms: f64,
}

/// Verdicts of all changes together, with the interval that each stands on. Its error rate is the one of the method of Holm
/// ([`Corrected::level`]).
pub fn judge(changes: &[Change], threshold: Threshold) -> Vec<(Verdict, [f64; 2])> {
    let p: Vec<f64> = changes.iter().map(Change::p_value).collect();
    let corrected = holm(&p, ERROR_RATE);
    let judged = changes.iter().zip(corrected).map(|(change, Corrected { p, level })| {
        let is_large = |more: f64| {
            more > threshold.share && (change.median_ms[1] - change.median_ms[0]).abs() > threshold.ms
        };
        let verdict = match change.ratio() {
            _ if p >= ERROR_RATE => Verdict::NotShown,
            ratio if is_large(ratio - 1.0) => Verdict::Regression,
            ratio if is_large(1.0 / ratio - 1.0) => Verdict::Improvement,
            _ => Verdict::BelowThreshold,
        };
        (verdict, change.interval(level))
    });
    judged.collect()
}

/// The mean of both middle values where their number is even; `None` of nothing.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

/// Probability that Student's t lies between -t and t (Abramowitz and Stegun 1964, 26.7.3 and 26.7.4).
fn student_within(t: f64, freedom: u32) -> f64 {
    let angle = (t / f64::from(freedom).sqrt()).atan();
    let (sin, cos) = angle.sin_cos();
    let is_odd = freedom % 2 == 1;
    // Even: 1, 1/2 cos^2, (1 3)/(2 4) cos^4, ...; odd: cos, 2/3 cos^3, (2 4)/(3 5) cos^5, ...
    let mut term = if is_odd { cos } else { 1.0 };
    let mut sum = 0.0;
    let mut next = if is_odd { 2 } else { 1 };
    for _ in 0..freedom / 2 {
        sum += term;
        term *= f64::from(next) / f64::from(next + 1) * cos * cos;
        next += 2;
    }
    if is_odd { std::f64::consts::FRAC_2_PI * (angle + sin * sum) } else { sin * sum }
}

/// The t beyond which Student's distribution has `error_rate` at both ends together.
fn student_quantile(error_rate: f64, freedom: u32) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while 1.0 - student_within(high, freedom) > error_rate && high < 1e9 {
        high *= 2.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if 1.0 - student_within(middle, freedom) > error_rate { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known quantiles of Student's distribution (Abramowitz and Stegun 1964, table 26.10).
    #[test]
    fn quantiles_are_those_of_the_table() {
        for (rate, freedom, t) in [
            (0.05, 1, 12.706),
            (0.05, 2, 4.303),
            (0.05, 7, 2.365),
            (0.01, 4, 4.604),
            (0.05, 30, 2.042),
            (0.001, 9, 4.781),
        ] {
            let found = student_quantile(rate, freedom);
            assert!((found - t).abs() < 6e-4, "{rate}, {freedom}: {found}, not {t}");
        }
    }

    /// Random numbers of splitmix64, and normal ones by the method of Box and Muller.
    struct Random(u64);

    impl Random {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        fn normal(&mut self) -> f64 {
            (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
        }
    }

    const PASSES: usize = 40;
    const ROUNDS: usize = 10;
    const FRAMES: usize = 32;

    /// Times of a run by pass, round and frame: correlated frames, a clock that drifts during the run by a share of about `of_runs` and wanders
    /// from round to round, frames and rounds that something else disturbs, and passes that are each a little faster or slower throughout the run,
    /// by `of_runs` too.
    fn run(random: &mut Random, of_runs: f64, slowed: Option<(usize, f64)>) -> Vec<Vec<Vec<f64>>> {
        let drift = of_runs * random.normal();
        let clocks: Vec<f64> = (0..ROUNDS)
            .map(|round| {
                let disturbed = if random.uniform() < 0.03 { 0.05 } else { 0.0 };
                drift * round as f64 / ROUNDS as f64 + 0.002 * random.normal() + disturbed
            })
            .collect();
        (0..PASSES)
            .map(|pass| {
                let base = 0.01 * 1.15f64.powi(pass as i32) * (of_runs * random.normal()).exp();
                let factor = slowed.filter(|(slow, _)| *slow == pass).map_or(1.0, |(_, factor)| factor);
                let mut noise = 0.0;
                let mut frame = |clock: f64| {
                    noise = 0.9 * noise + 0.004 * random.normal();
                    let outlier = if random.uniform() < 0.02 { 1.0 + random.uniform() } else { 1.0 };
                    base * factor * (clock + noise).exp() * outlier
                };
                clocks.iter().map(|clock| (0..FRAMES).map(|_| frame(*clock)).collect()).collect()
            })
            .collect()
    }

    fn verdicts(before: &[Vec<Vec<f64>>], after: &[Vec<Vec<f64>>], share: f64) -> Vec<Verdict> {
        let pairs = before.iter().zip(after);
        let changes: Vec<_> = pairs.map(|(a, b)| Change::of(a, b).unwrap()).collect();
        judge(&changes, Threshold { share, ms: 0.0 }).into_iter().map(|(verdict, _)| verdict).collect()
    }

    /// Two runs of one program, which differ by some 0.3 % throughout: at most one of 20 comparisons may find a regression.
    #[test]
    fn runs_of_one_program_show_no_regression() {
        let mut random = Random(1);
        let alarms = (0..100).filter(|_| {
            let (before, after) = (run(&mut random, 0.003, None), run(&mut random, 0.003, None));
            verdicts(&before, &after, 0.02).contains(&Verdict::Regression)
        });
        let alarms = alarms.count();
        println!("{alarms} of 100 comparisons of equal runs with an alarm");
        assert!(alarms <= 5, "{alarms} of 100");
    }

    /// A pass of 40 that takes 5 % longer is found, and no other one.
    #[test]
    fn a_pass_that_is_slower_by_5_per_cent_is_found() {
        let mut random = Random(2);
        let mut others = 0;
        for trial in 0..100 {
            let slow = trial % PASSES;
            let before = run(&mut random, 0.003, None);
            let after = run(&mut random, 0.003, Some((slow, 1.05)));
            let found = verdicts(&before, &after, 0.02);
            assert_eq!(found[slow], Verdict::Regression, "trial {trial}");
            others += found.iter().filter(|verdict| **verdict == Verdict::Regression).count() - 1;
        }
        println!("{others} other passes of {} called slower", 100 * (PASSES - 1));
        assert!(others <= 5, "{others} passes that are not slower");
    }

    /// Where runs differ by 1 % throughout, ten runs of each program in turns show what one run of each can't: no regression where there is none,
    /// and that of 5 %.
    #[test]
    fn runs_in_turns_stand_for_rounds() {
        let mut random = Random(4);
        let mut runs = |slowed: Option<(usize, f64)>| -> Vec<Vec<Vec<f64>>> {
            let mut passes = vec![Vec::new(); PASSES];
            for _ in 0..10 {
                let once = run(&mut random, 0.01, slowed);
                passes.iter_mut().zip(once).for_each(|(pass, rounds)| pass.push(rounds.concat()));
            }
            passes
        };
        let (mut alarms, mut found) = (0, 0);
        for _ in 0..8 {
            let before = runs(None);
            alarms += u32::from(verdicts(&before, &runs(None), 0.02).contains(&Verdict::Regression));
            found += u32::from(verdicts(&before, &runs(Some((7, 1.05))), 0.02)[7] == Verdict::Regression);
        }
        println!("of 8: {alarms} alarms, {found} found");
        assert!(alarms <= 1 && found >= 7, "of 8: {alarms} alarms, {found} found");
    }

    /// Without any threshold, and with rounds that are independent, the method of Holm keeps its error rate: of 400 families of 40 equal passes
    /// 20 are expected with an error. 33: three standard deviations (4.4) more.
    #[test]
    fn the_error_rate_of_the_family_is_kept() {
        let mut random = Random(3);
        let mut rounds = |spread: f64| -> Vec<Vec<f64>> {
            (0..ROUNDS).map(|_| vec![(spread * random.normal()).exp()]).collect()
        };
        let families = (0..400).filter(|_| {
            let changes: Vec<_> =
                (0..PASSES).map(|_| Change::of(&rounds(0.01), &rounds(0.01)).unwrap()).collect();
            let verdicts = judge(&changes, Threshold { share: 0.0, ms: 0.0 });
            verdicts.iter().any(|(verdict, _)| *verdict != Verdict::NotShown)
        });
        let families = families.count();
        println!("{families} of 400 families of equal passes with an error");
        assert!(families <= 33, "{families} of 400");
    }

    #[test]
    fn intervals_and_thresholds_decide() {
        let rounds = |ms: f64| -> Vec<Vec<f64>> {
            (0..5).map(|round| vec![ms * (1.0 + 0.001 * f64::from(round % 2))]).collect()
        };
        let change = |ratio: f64| Change::of(&rounds(2.0), &rounds(2.0 * ratio)).unwrap();
        let judged = |ratio: f64, share, ms| judge(&[change(ratio)], Threshold { share, ms })[0].0;
        assert_eq!(judged(1.05, 0.02, 0.001), Verdict::Regression);
        assert_eq!(judged(1.05, 0.06, 0.001), Verdict::BelowThreshold);
        assert_eq!(judged(1.05, 0.02, 0.2), Verdict::BelowThreshold);
        assert_eq!(judged(1.0 / 1.05, 0.02, 0.001), Verdict::Improvement);
        assert_eq!(judged(1.0, 0.02, 0.001), Verdict::NotShown);
        let [low, high] = change(1.05).interval(0.05);
        assert!(low < 1.05 && 1.05 < high && low > 1.0, "{low} {high}");
        // A pass that is missing in a run, too few rounds, and a clock that shows nothing.
        assert_eq!(Change::of(&rounds(2.0)[..2], &rounds(2.0)[..2]), None);
        assert_eq!(Change::of(&[vec![], vec![], vec![]], &rounds(2.0)), None);
        assert_eq!(Change::of(&rounds(0.0), &rounds(2.0)), None);
    }
}
