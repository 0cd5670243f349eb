//! The colour of a residual: the autoregression that whitens it.

use planesman_record::filter;

use super::sums::dot;

/// The largest order tried.
const ORDERS: usize = 20;
/// The largest lag at which a residual is assumed to be correlated.
const MEMORY: usize = 200;
/// The minimum number of samples for each order.
const SAMPLES: usize = 10;

/// `1, d1, ..., dk` with which `D e` is white: the order, up to 20, with the lowest Bayesian criterion. `[1]` for a white residual. By
/// Burg's recursion (1967; Kay, *Modern Spectral Estimation*, 1988, sec. 7.7): a lattice that minimises forward and backward errors
/// together. Levinson's recursion is not used: its covariances end with the record, which hides all but the slowest pole of slow noise.
pub(crate) fn whitening<'a>(residuals: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    // A constant belongs to the offset: as noise it would have a pole at z = 1.
    let centred = residuals.map(|of| {
        let mean = of.iter().sum::<f64>() / of.len().max(1) as f64;
        of.iter().map(|e| e - mean).collect::<Vec<f64>>()
    });
    let mut errors: Vec<(Vec<f64>, Vec<f64>)> = centred.map(|of| (of.clone(), of)).collect();
    let samples: usize = errors.iter().map(|(of, _)| of.len()).sum();
    let most = ORDERS.min(samples / SAMPLES);
    let squares = |of: &[f64]| dot(of, of);
    let mut variance: f64 = errors.iter().map(|(of, _)| squares(of)).sum();
    if !(variance > 0.0 && variance.is_finite()) {
        return vec![1.0];
    }
    let n = samples as f64;
    let criterion =
        |variance: f64, order: usize| n * libm::log(variance) + order as f64 * libm::log(n);
    let mut best = (criterion(variance, 0), vec![1.0]);
    let mut d = vec![1.0];
    for order in 1..=most {
        let (mut product, mut sum) = (0.0, 0.0);
        for (forwards, backwards) in &mut errors {
            // The forward error of each sample beside the backward one of the sample before.
            forwards.drain(..1.min(forwards.len()));
            backwards.pop();
            product += dot(forwards, backwards);
            sum += squares(forwards) + squares(backwards);
        }
        let reflection = -2.0 * product / sum;
        for (forwards, backwards) in &mut errors {
            for (f, b) in forwards.iter_mut().zip(backwards.iter_mut()) {
                (*f, *b) = (*f + reflection * *b, *b + reflection * *f);
            }
        }
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

/// `D e` without the first samples, for which earlier errors are needed.
pub(crate) fn whitened(d: &[f64], values: &[f64]) -> Vec<f64> {
    filter(d, &[1.0], values).split_off((d.len() - 1).min(values.len()))
}

/// The effective share of samples with `D e` white, `D = 1 + d1 q^-1 + ...`, when mean squares are compared: `1 / (1 + 2 sum rho_k^2)` with
/// their autocorrelation `rho` (Bartlett 1946).
pub(crate) fn independent_share(d: &[f64]) -> f64 {
    let mut impulse = vec![0.0; 2 * MEMORY];
    impulse[0] = 1.0;
    let response = filter(&[1.0], d, &impulse);
    let covariance = |lag: usize| -> f64 {
        let pairs = response.iter().zip(&response[lag..]);
        pairs.map(|(now, later)| now * later).sum()
    };
    let variance = covariance(0);
    let squares: f64 = (1..=MEMORY)
        .map(|lag| (covariance(lag) / variance).powi(2))
        .sum();
    1.0 / (1.0 + 2.0 * squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_record::noise;

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

    #[test]
    fn noise_with_a_pole_at_one_hides_no_other() {
        let slow = filter(&[1.0], &[1.0, -1.9, 0.9], &noise(5, 1000));
        let found = whitening([slow.as_slice()].into_iter());
        assert!(
            (found[1] + 1.9).abs() < 0.1 && (found[2] - 0.9).abs() < 0.1,
            "{found:?}"
        );
    }

    #[test]
    fn samples_of_slow_noise_are_worth_less() {
        assert_eq!(independent_share(&[1.0]), 1.0);
        // (1 - rho^2) / (1 + rho^2) of a first-order autoregression.
        let found = independent_share(&[1.0, -0.9]);
        assert!((found - 0.19 / 1.81).abs() < 1e-3, "{found}");
    }
}
