//! Ranks of variants that never order what the noise does not.

use crate::summary::{SummaryRow, Verdict};

/// The rank of each row: 1 is nearest to the perfect value. Two variants have different ranks only if every variant up to the one is
/// clearly apart from every variant after it, so that variants inside the noise of each other share a rank.
/// `None`: the variant has no difference to the baseline.
pub fn ranks(rows: &[SummaryRow]) -> Vec<Option<usize>> {
    let place = |row: &SummaryRow| match row.verdict {
        Verdict::Baseline => Some(0.0),
        _ => row.difference,
    };
    let mut order: Vec<(usize, f64)> =
        rows.iter().enumerate().filter_map(|(index, row)| Some((index, place(row)?))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut ranks = vec![None; rows.len()];
    let mut rank = 1;
    for (position, &(index, _)) in order.iter().enumerate() {
        let (before, after) = order.split_at(position);
        let apart = |&(a, _): &(usize, f64)| after.iter().all(|&(b, _)| clearly_better(&rows[a], &rows[b]));
        if before.iter().all(apart) {
            rank = position + 1;
        }
        ranks[index] = Some(rank);
    }
    ranks
}

/// Whether the difference of two variants is outside the noise. Against the baseline the verdict decides, which is corrected for the
/// number of comparisons. Two others are apart if the verdicts differ in sign, or if both have the same verdict and the intervals of their
/// differences to the baseline do not touch, which asks for more than a test of 95 %.
fn clearly_better(a: &SummaryRow, b: &SummaryRow) -> bool {
    use Verdict::{Baseline, Better, NoDifference, Worse};
    match (a.verdict, b.verdict) {
        (Better, Baseline | Worse) | (Baseline, Worse) => true,
        (NoDifference, NoDifference) | (Baseline, _) | (_, Baseline) => false,
        _ => match (a.difference_interval, b.difference_interval) {
            (Some(a), Some(b)) => a.high < b.low,
            _ => false,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Interval;

    fn row(verdict: Verdict, difference: f64, half: f64) -> SummaryRow {
        let others = verdict != Verdict::Baseline;
        SummaryRow {
            variant: String::new(),
            cells: 3,
            mean: Some(1.0 + difference),
            interval: None,
            difference: others.then_some(difference),
            difference_interval: others
                .then_some(Interval { low: difference - half, high: difference + half }),
            p: None,
            verdict,
        }
    }

    #[test]
    fn noise_is_never_ranked() {
        use Verdict::{Baseline, Better, NoDifference, Worse};
        let cases: [(&[SummaryRow], &[usize]); 5] = [
            // Clearly worse: last. The placebo shares the baseline's rank.
            (&[row(Baseline, 0.0, 0.0), row(NoDifference, -0.01, 0.1), row(Worse, 1.0, 0.1)], &[1, 1, 3]),
            (
                &[row(Worse, 1.0, 0.1), row(Worse, 1.1, 0.1), row(Worse, 2.0, 0.1), row(Baseline, 0.0, 0.0)],
                &[2, 2, 4, 1],
            ),
            // The second touches the baseline and the third: all three share a rank, although the third is worse than the baseline.
            (&[row(Baseline, 0.0, 0.0), row(NoDifference, 0.1, 0.2), row(Worse, 0.3, 0.1)], &[1, 1, 1]),
            (&[row(Better, -1.0, 0.1), row(Baseline, 0.0, 0.0)], &[1, 2]),
            // Without a difference shown there is no order, even if the intervals of single comparisons do not touch.
            (
                &[row(NoDifference, -1.0, 0.1), row(Baseline, 0.0, 0.0), row(NoDifference, 1.0, 0.1)],
                &[1, 1, 1],
            ),
        ];
        for (rows, expected) in cases {
            assert_eq!(ranks(rows).into_iter().flatten().collect::<Vec<_>>(), expected);
        }
        let lost = SummaryRow { difference: None, difference_interval: None, ..row(NoDifference, 0.0, 0.0) };
        assert_eq!(ranks(&[row(Baseline, 0.0, 0.0), lost]), [Some(1), None]);
    }
}
