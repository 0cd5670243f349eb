//! Filtering by a difference equation.

/// The response of `num(q^-1) / den(q^-1)` from rest; `den` begins with 1.
#[must_use]
pub fn filter(num: &[f64], den: &[f64], input: &[f64]) -> Vec<f64> {
    let mut output: Vec<f64> = Vec::with_capacity(input.len());
    let weighted = |coefficients: &[f64], past: &[f64]| -> f64 {
        let pairs = coefficients.iter().zip(past.iter().rev());
        pairs.map(|(c, value)| c * value).sum()
    };
    let back = den.get(1..).unwrap_or_default();
    for k in 0..input.len() {
        let forward = weighted(num, &input[(k + 1).saturating_sub(num.len())..=k]);
        let past = weighted(back, &output[k.saturating_sub(back.len())..]);
        output.push(forward - past);
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_is_its_difference_equation_from_rest() {
        assert_eq!(
            filter(&[1.0, -1.0], &[1.0, -0.5], &[1.0, 1.0, 0.0]),
            vec![1.0, 0.5, -0.75]
        );
    }
}
