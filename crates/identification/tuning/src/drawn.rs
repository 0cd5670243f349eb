//! Model files of random plants within a model's uncertainty.

use nalgebra::{DMatrix, DVector};
use planesman_identification::noise;
use planesman_model_file::ModelFile;

use crate::model::factor;

/// `count` model files with coefficients drawn from the file's covariance: the coefficients of the vehicle's equations if the file has them,
/// otherwise those of the difference equation. The result depends only on the seed; without a covariance it is empty.
#[must_use]
pub fn drawn(file: &ModelFile, count: usize, seed: u32) -> Vec<ModelFile> {
    let physical = file.physical.as_ref();
    let (centre, covariance) = match physical {
        Some(it) => (
            vec![it.kappa, it.beta, it.mu],
            DMatrix::from_fn(3, 3, |i, j| it.covariance[i][j]),
        ),
        None => {
            let values: Vec<f64> = file.den[1..].iter().chain(&file.num).copied().collect();
            let count = values.len();
            (
                values,
                DMatrix::from_fn(count, count, |i, j| file.covariance[i][j]),
            )
        }
    };
    let factor = factor(&covariance);
    let directions = factor.ncols();
    if directions == 0 {
        return Vec::new();
    }
    let centre = DVector::from_vec(centre);
    let numbers = noise(seed, count * directions);
    let each = numbers.chunks(directions);
    each.map(|it| {
        let values = &centre + &factor * DVector::from_row_slice(it);
        let mut drawn = file.clone();
        match &mut drawn.physical {
            Some(physical) => {
                physical.kappa = values[0];
                physical.beta = values[1];
                physical.mu = values[2];
            }
            None => {
                let poles = file.order();
                drawn.den = std::iter::once(1.0)
                    .chain(values.iter().take(poles).copied())
                    .collect();
                drawn.num = values.iter().skip(poles).copied().collect();
            }
        }
        drawn
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_files_have_the_covariance_of_the_file() {
        let mut file = ModelFile::exact("u", "y", 0.1, vec![0.2], vec![1.0, -0.9]);
        file.covariance = vec![vec![4e-4, -3e-4], vec![-3e-4, 9e-4]];
        let files = drawn(&file, 4000, 3);
        let sum = |of: &dyn Fn(&ModelFile) -> f64| files.iter().map(of).sum::<f64>() / 4000.0;
        let (a, b) = (sum(&|it| it.den[1]), sum(&|it| it.num[0]));
        assert!((a + 0.9).abs() < 2e-3 && (b - 0.2).abs() < 2e-3);
        let common = sum(&|it| (it.den[1] - a) * (it.num[0] - b));
        assert!((common + 3e-4).abs() < 4e-5, "{common}");
        assert!(
            drawn(
                &ModelFile::exact("u", "y", 0.1, vec![0.2], vec![1.0, -0.9]),
                5,
                1
            )
            .is_empty()
        );
    }
}
