//! Pearson's chi-squared test of samples against a density.

/// Chance of a false alarm in a whole test program.
pub const SIGNIFICANCE: f64 = 0.01;

/// What each of `tests` independent tests may take of [`SIGNIFICANCE`] (Sidak 1967).
pub fn sidak(tests: usize) -> f64 {
    1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / tests as f64)
}

/// Probability of counts at least as far from `expected` as `observed`, were they drawn from it. Bins that expect fewer
/// than five samples are pooled. A sample where none is expected gives zero.
pub fn chi_squared(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    let mut bins: Vec<(f64, f64)> = Vec::new();
    let mut pool = (0.0, 0.0);
    for (&o, &e) in observed.iter().zip(expected) {
        if e == 0.0 && o > 0 {
            return 0.0;
        }
        if e >= 5.0 {
            bins.push((o as f64, e));
            continue;
        }
        pool = (pool.0 + o as f64, pool.1 + e);
        if pool.1 >= 5.0 {
            bins.push(std::mem::take(&mut pool));
        }
    }
    // What is left is too little for a bin of its own.
    if let Some(last) = bins.last_mut() {
        *last = (last.0 + pool.0, last.1 + pool.1);
    }
    assert!(bins.len() > 1, "one bin tests nothing");
    let statistic: f64 = bins.iter().map(|(o, e)| (o - e) * (o - e) / e).sum();
    upper_gamma(0.5 * (bins.len() - 1) as f64, 0.5 * statistic)
}

/// Regularised upper incomplete gamma function Q(a, x): series below a + 1, Lentz's continued fraction above (Abramowitz
/// and Stegun 6.5.29, 6.5.31).
fn upper_gamma(a: f64, x: f64) -> f64 {
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x <= 0.0 {
        return 1.0;
    }
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= c * d;
        if (c * d - 1.0).abs() < 1e-14 {
            break;
        }
    }
    front * h
}

/// Stirling's series after shifting the argument above 10.
fn ln_gamma(mut a: f64) -> f64 {
    let mut shift = 0.0;
    while a < 10.0 {
        shift += a.ln();
        a += 1.0;
    }
    let series = 1.0 / (12.0 * a) - 1.0 / (360.0 * a.powi(3)) + 1.0 / (1260.0 * a.powi(5));
    (a - 0.5) * a.ln() - a + 0.5 * std::f64::consts::TAU.ln() + series - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tail_probabilities_are_the_tabulated_ones() {
        // 95 % quantiles of the chi-squared distribution.
        for (freedom, quantile) in
            [(1.0, 3.841_459), (2.0, 5.991_465), (10.0, 18.307_038), (100.0, 124.342_113)]
        {
            assert!((upper_gamma(0.5 * freedom, 0.5 * quantile) - 0.05).abs() < 1e-7, "{freedom}");
        }
        assert!(chi_squared(&[10, 10, 10], &[10.0, 10.0, 10.0]) > 0.999);
        assert!(chi_squared(&[30, 0, 0], &[10.0, 10.0, 10.0]) < 1e-9);
        assert_eq!(chi_squared(&[10, 1], &[11.0, 0.0]), 0.0);
    }
}
