//! Limits of metrics, and numbers as they are printed.

use super::args::{CompareArgs, Limit};
use anyhow::Result;
use pt_image::metrics::SequenceMetric;
use serde_json::{Value, json};
use std::io::Write;

/// Limits and what became of them.
pub struct Checks(Vec<Check>);

struct Check {
    limit: Limit,
    /// `<=` or `>=`
    relation: &'static str,
    passed: bool,
}

impl Checks {
    /// Checks all limits. A metric without a value passes none.
    pub fn new(args: &CompareArgs, value: impl Fn(SequenceMetric) -> Option<f64>) -> Self {
        let check = |limit: Limit, relation, is_kept: fn(&f64, &f64) -> bool| {
            let passed = value(limit.metric).is_some_and(|value| is_kept(&value, &limit.value));
            Check { limit, relation, passed }
        };
        let upper = args.max.iter().map(|&limit| check(limit, "<=", f64::le));
        let lower = args.min.iter().map(|&limit| check(limit, ">=", f64::ge));
        Self(upper.chain(lower).collect())
    }

    /// Whether all limits are kept.
    pub fn passed(&self) -> bool {
        self.0.iter().all(|check| check.passed)
    }

    /// A line for each.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn print(&self, out: &mut impl Write) -> Result<()> {
        for Check { limit, relation, passed } in &self.0 {
            let outcome = if *passed { "ok" } else { "FAILED" };
            writeln!(out, "check {} {relation} {}: {outcome}", limit.metric.name(), limit.value)?;
        }
        Ok(())
    }

    /// An object for each.
    pub fn json(&self) -> Vec<Value> {
        let one = |Check { limit, relation, passed }: &Check| {
            json!({
                "metric": limit.metric.name(),
                "relation": relation,
                "limit": number(limit.value),
                "passed": passed,
            })
        };
        self.0.iter().map(one).collect()
    }
}

/// Six digits.
pub fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.6e}")
    }
}

/// JSON has no infinity (PSNR of equal images): it is written as the string `inf`.
pub fn number(value: f64) -> Value {
    if value.is_finite() { value.into() } else { value.to_string().into() }
}
