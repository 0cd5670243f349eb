//! The independent share of each input: the effects of inputs that move together cannot be separated.

use nalgebra::{DMatrix, DVector};
use planesman_record::Segment;

use crate::batch::Triangle;

/// Number of earlier and later samples of the other inputs that may explain an input.
const LAGS: usize = 5;
/// Maximum number of rows used.
const ROWS: usize = 10_000;
/// Minimum number of rows for each parameter.
const ROWS_PER_PARAMETER: usize = 2;

/// The share of an input's variation that the others do not explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndependentShare {
    /// From 0 to 1.
    pub share: f64,
    /// The number of the other input that explains most; `None` for a single input.
    pub other: Option<usize>,
}

/// For each input of the records: the remainder after regression on the others, up to five samples earlier and later.
pub(super) fn own(segments: &[Segment]) -> Vec<IndependentShare> {
    let inputs = segments.first().map_or(0, |it| it.inputs.len());
    (0..inputs)
        .map(|input| {
            let others: Vec<usize> = (0..inputs).filter(|it| *it != input).collect();
            let by = |others: &[usize]| left(segments, input, others);
            let each = others.iter().map(|other| (by(&[*other]), *other));
            let most = each.min_by(|p, q| p.0.total_cmp(&q.0));
            IndependentShare {
                share: most.map_or(1.0, |most| by(&others).min(most.0)),
                other: most.map(|it| it.1),
            }
        })
        .collect()
}

/// The share of an input's sum of squares that the others do not explain, per degree of freedom.
fn left(segments: &[Segment], input: usize, others: &[usize]) -> f64 {
    let samples: usize = segments.iter().map(Segment::len).sum();
    let most = samples / (ROWS_PER_PARAMETER * others.len()).max(1);
    let lags = LAGS.min(most.saturating_sub(1) / 2);
    let columns = others.len() * (2 * lags + 1);
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for segment in segments {
        let centred = |values: &[f64]| -> Vec<f64> {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            values.iter().map(|v| v - mean).collect()
        };
        let u = centred(&segment.inputs[input]);
        let others: Vec<Vec<f64>> = others
            .iter()
            .map(|it| centred(&segment.inputs[*it]))
            .collect();
        for k in lags..u.len().saturating_sub(lags) {
            if values.len() < ROWS {
                values.push(u[k]);
                rows.extend(others.iter().flat_map(|it| &it[k - lags..=k + lags]));
            }
        }
    }
    let total: f64 = values.iter().map(|v| v * v).sum();
    if total == 0.0 || values.len() <= columns {
        return 1.0;
    }
    let phi = DMatrix::from_row_slice(values.len(), columns, &rows);
    let freedom = (values.len() - columns) as f64 / values.len() as f64;
    let cost = Triangle::new(&phi, &DVector::from_vec(values)).map_or(total, |it| it.cost);
    (cost / freedom / total).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_record::{noise, with_noise};

    #[test]
    fn the_share_that_is_an_inputs_own_is_found() {
        let (u, v) = (noise(1, 1000), noise(2, 1000));
        // w is u two samples later, and noise of a tenth of its size.
        let late: Vec<f64> = [&[0.0, 0.0], &u[..998]].concat();
        let segment = Segment {
            inputs: vec![u, v, with_noise(&late, 3, 0.1)],
            outputs: vec![vec![0.0; 1000]],
            ..Segment::default()
        };
        let found = own(&[segment]);
        assert!((found[2].share / 0.01 - 1.0).abs() < 0.3, "{found:?}");
        assert_eq!((found[0].other, found[2].other), (Some(2), Some(0)));
        assert!(found[1].share > 0.95, "{found:?}");
    }
}
