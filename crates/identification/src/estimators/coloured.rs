//! The colour of a residual: the autoregression that whitens it.

/// Largest order tried.
const ORDERS: usize = 20;
/// Samples for each order at least.
const SAMPLES: usize = 10;

/// `1, d1, ..., dk` with which `D e` is white: of the orders up to 20 the one of the least Bayesian criterion
/// (Levinson's recursion on the covariances; Ljung 1999, sec. 10.1). `[1]` for a white residual.
pub(crate) fn whitening<'a>(residuals: impl Iterator<Item = &'a [f64]> + Clone) -> Vec<f64> {
    let samples: usize = residuals.clone().map(<[f64]>::len).sum();
    let most = ORDERS.min(samples / SAMPLES);
    let covariance = |lag: usize| -> f64 {
        let of = |values: &[f64]| -> f64 {
            let later = values.get(lag..).unwrap_or_default();
            values.iter().zip(later).map(|(e, f)| e * f).sum()
        };
        residuals.clone().map(of).sum()
    };
    let covariances: Vec<f64> = (0..=most).map(covariance).collect();
    let mut variance = covariances[0];
    if !(variance > 0.0 && variance.is_finite()) {
        return vec![1.0];
    }
    let n = samples as f64;
    let criterion = |variance: f64, order: usize| n * variance.ln() + order as f64 * n.ln();
    let mut best = (criterion(variance, 0), vec![1.0]);
    let mut d = vec![1.0];
    for order in 1..=most {
        let sum: f64 = (0..order).map(|i| d[i] * covariances[order - i]).sum();
        let reflection = -sum / variance;
        let mut next = d.clone();
        next.push(0.0);
        for i in 1..=order {
            next[i] += reflection * d[order - i];
        }
        d = next;
        variance *= 1.0 - reflection * reflection;
        if variance.is_nan() || variance <= 0.0 {
            break;
        }
        let value = criterion(variance, order);
        if value < best.0 {
            best = (value, d.clone());
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::noise;
    use crate::structure::filter;

    #[test]
    fn the_autoregression_of_a_residual_is_found_and_white_noise_has_none() {
        let white = noise(3, 4000);
        assert_eq!(whitening([white.as_slice()].into_iter()), vec![1.0]);
        let coloured = filter(&[1.0], &[1.0, -1.2, 0.5], &white);
        let found = whitening([&coloured[..2000], &coloured[2000..]].into_iter());
        assert_eq!(found.len(), 3);
        assert!(
            (found[1] + 1.2).abs() < 0.05 && (found[2] - 0.5).abs() < 0.05,
            "{found:?}"
        );
    }
}
