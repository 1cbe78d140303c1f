//! The error of a frame split over its stages.
//!
//! The stages are fed with ground truth one after the other, in the order of the frame: e_0 is the error of the frame, e_k that of the frame whose first k
//! stages of the ledger have ground truth for their output. The part of stage k is e_(k-1) - e_k: what the frame loses when its output is perfect, too. The
//! parts add up to e_0 - e_n, and e_n, what no stage of the ledger explains, is the interaction: the error of later stages with perfect input.

use crate::record::LedgerRecord;

/// Splits the errors of measured frames, without the noise of the reference; `fed`: each stage, with the errors of the frames when it and those before it are fed. `None` if an error is
/// missing, or there are no frames.
pub fn split(
    metric: &str,
    errors: &[Option<f64>],
    fed: &[(String, Vec<Option<f64>>)],
) -> Option<LedgerRecord> {
    let of_frame = |i: usize| -> Option<LedgerRecord> {
        let total = (*errors.get(i)?)?;
        let mut before = total;
        let mut parts = Vec::new();
        for (stage, errors) in fed {
            let error = (*errors.get(i)?)?;
            parts.push((stage.clone(), before - error));
            before = error;
        }
        Some(record(metric, total, parts, Vec::new()))
    };
    let frames: Vec<LedgerRecord> = (0..errors.len()).map(of_frame).collect::<Option<_>>()?;
    if frames.is_empty() {
        return None;
    }
    let mean =
        |value: &dyn Fn(&LedgerRecord) -> f64| frames.iter().map(value).sum::<f64>() / frames.len() as f64;
    let parts = (0..fed.len()).map(|k| (fed[k].0.clone(), mean(&|frame| frame.parts[k].1))).collect();
    Some(record(metric, mean(&|frame| frame.total), parts, frames))
}

/// The interaction is what is missing from the parts to the total.
fn record(metric: &str, total: f64, parts: Vec<(String, f64)>, frames: Vec<LedgerRecord>) -> LedgerRecord {
    let interaction = total - parts.iter().map(|(_, part)| part).sum::<f64>();
    LedgerRecord { metric: metric.into(), total, parts, interaction, reference_noise: None, frames }
}

/// Where the noise of the reference is in a ledger.
pub const COUNTS_AS: &str = "it is within the part of the first stage that is fed with the reference, such as denoise, and is no error of that stage";

/// Mean noise of the reference over ledgers; `None` where it is not known of all, or there are none.
pub fn reference_noise<'a>(ledgers: impl Iterator<Item = &'a LedgerRecord>) -> Option<f64> {
    let noise = ledgers.map(|ledger| ledger.reference_noise).collect::<Option<Vec<f64>>>()?;
    (!noise.is_empty()).then(|| noise.iter().sum::<f64>() / noise.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_interaction_are_the_total() {
        let fed = |name: &str, errors: [f64; 2]| (name.to_owned(), errors.map(Some).to_vec());
        let stages = [fed("denoise", [0.3, 0.1]), fed("taa", [0.05, 0.07])];
        let found = split("relmse", &[Some(1.0), Some(0.4)], &stages).unwrap();
        assert_eq!(found.frames[0].parts[0], ("denoise".into(), 0.7));
        for ledger in found.frames.iter().chain([&found]) {
            let sum = ledger.parts.iter().map(|(_, part)| part).sum::<f64>() + ledger.interaction;
            assert!((sum - ledger.total).abs() < 1e-15, "{ledger:?}");
        }
        assert!((found.interaction - 0.06).abs() < 1e-12 && (found.total - 0.7).abs() < 1e-12, "{found:?}");
        assert_eq!(split("relmse", &[Some(1.0), None], &stages), None);
        assert_eq!(split("relmse", &[], &stages), None);
    }
}
