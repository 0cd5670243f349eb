//! Converts the sampled model to the continuous one, and to the vehicle's pitch equation.
//!
//! A model with zero-order hold is decomposed into modes
//! ```text
//! G(z) = sum r_i / (z - p_i)   <->   G(s) = sum R_i / (s - s_i)
//! s_i = ln(p_i) / T,   r_i = R_i (p_i - 1) / s_i   (R_i T at s_i = 0)
//! ```
//! which is exact. A pole on the negative real axis or at 0 cannot be converted, because no continuous-time system has such a sampled pole.

use nalgebra::{Complex, DMatrix, DVector, Matrix3};
use planesman_linear::{
    ComplexFunctions as _, TransferFunction, discrete_to_continuous, polynomial,
};

use crate::error::{IdentificationError, Result};
use crate::estimators::{Estimate, Physical};
use crate::model::Model;

/// Poles nearer than this count as equal: their residues would be rounding error.
const APART: f64 = 1e-7;

/// A continuous model with a delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Continuous {
    /// `G(s)`, the highest power first.
    pub transfer: TransferFunction,
    /// The delay, s.
    pub delay: f64,
}

/// The continuous model whose response under zero-order hold equals the sampled model's.
///
/// # Errors
/// [`IdentificationError`]: a pole without a continuous counterpart, poles too near each other.
pub fn continuous(model: &Model) -> Result<Continuous> {
    let dt = model.sample_time;
    let (mut a, mut b) = (model.a.clone(), model.b.clone());
    let mut delay = 0.0;
    while model.feedthrough == 0.0
        && a.len() > 1
        && a.last() == Some(&0.0)
        && b.first() == Some(&0.0)
    {
        a.pop();
        b.remove(0);
        delay += dt;
    }
    if model.feedthrough != 0.0 {
        b.insert(0, model.feedthrough);
    }
    let den: Vec<f64> = std::iter::once(1.0).chain(a).collect();
    let poles = polynomial::roots(&den)?;
    let derivative = polynomial::derivative(&den);
    let mut modes = Vec::with_capacity(poles.len());
    let refuse = |reason| Err(IdentificationError::Model(reason));
    for (i, p) in poles.iter().enumerate() {
        if p.im == 0.0 && p.re <= 0.0 {
            return refuse(format!(
                "no continuous-time system has a sampled pole at z = {:.4}",
                p.re
            ));
        }
        if poles[..i].iter().any(|q| (p - q).modulus() < APART) {
            return refuse(format!("two poles coincide at z = {:.4}", p.re));
        }
        let s = discrete_to_continuous(*p, dt)
            .ok_or_else(|| IdentificationError::Model("a pole without a logarithm".to_owned()))?;
        let residue = polynomial::evaluate(&b, *p) / polynomial::evaluate(&derivative, *p);
        let share = if (p - 1.0).modulus() < APART {
            Complex::new(1.0 / dt, 0.0)
        } else {
            s / (p - 1.0)
        };
        modes.push((s, residue * share));
    }
    let s_poles: Vec<Complex<f64>> = modes.iter().map(|(s, _)| *s).collect();
    let mut num = vec![0.0; poles.len()];
    for (i, (_, residue)) in modes.iter().enumerate() {
        // residue * prod over the others of (s - s_j)
        let mut term = vec![*residue];
        for (j, s) in s_poles.iter().enumerate() {
            if i != j {
                term.push(Complex::new(0.0, 0.0));
                for k in (1..term.len()).rev() {
                    let before = term[k - 1];
                    term[k] -= s * before;
                }
            }
        }
        for (sum, c) in num.iter_mut().zip(term) {
            *sum += c.re;
        }
    }
    let den = polynomial::from_roots(&s_poles)?;
    if model.feedthrough != 0.0 {
        num.insert(0, 0.0);
        for (sum, c) in num.iter_mut().zip(&den) {
            *sum += model.feedthrough * c;
        }
    }
    // A numerator's leading coefficients that are rounding are none.
    let size = num.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let first = num
        .iter()
        .position(|c| c.abs() > 1e-12 * size)
        .unwrap_or(num.len() - 1);
    let transfer = TransferFunction::new(num[first..].to_vec(), den)?;
    Ok(Continuous { transfer, delay })
}

/// The pitch equation that corresponds to a second-order model with a zero at z = 1:
/// ```text
/// b (1 - q^-1) q^-1 / (1 + a1 q^-1 + a2 q^-2)   <->   kappa s / (s^2 + beta s + mu)
/// beta = -ln(a2) / T,   mu = s1 s2,   kappa = b (s1 - s2) / (p1 - p2)
/// ```
/// with the propagated covariance (slopes by central differences).
///
/// # Errors
/// [`IdentificationError`], if the estimate has another structure, or poles that no continuous system has.
pub fn pitch_equation(estimate: &Estimate) -> Result<Physical> {
    let s = &estimate.layout.structure;
    if (s.poles, s.numerator, s.delay) != (2, 1, 1)
        || s.known_numerator != [1.0, -1.0]
        || s.known_denominator != [1.0]
    {
        return Err(IdentificationError::Model(
            "the pitch equation needs a second-order model with a zero at z = 1".to_owned(),
        ));
    }
    let dt = estimate.sample_time;
    let unknowns = |theta: [f64; 3]| -> Option<[f64; 3]> {
        let [a1, a2, b] = theta;
        let root = Complex::new(a1 * a1 - 4.0 * a2, 0.0).sqrt();
        let p = [(-a1 + root) / 2.0, (-a1 - root) / 2.0];
        if p.iter().any(|p| p.im == 0.0 && p.re <= 0.0) {
            return None;
        }
        let s = p.map(|p| p.ln() / dt);
        let apart = p[0] - p[1];
        let slope = if apart.modulus() > APART {
            (s[0] - s[1]) / apart
        } else {
            (p[0] * dt).inv()
        };
        let found = [(slope * b).re, -(s[0] + s[1]).re, (s[0] * s[1]).re];
        found.iter().all(|v| v.is_finite()).then_some(found)
    };
    let theta = [0, 1, 2].map(|i| estimate.theta[i]);
    let none =
        || IdentificationError::Model("a pole has no equivalent in continuous time".to_owned());
    let parameters = unknowns(theta).ok_or_else(none)?;
    let mut slopes = Matrix3::zeros();
    for column in 0..3 {
        let deviation = estimate.covariance[(column, column)].max(0.0).sqrt();
        let by = (1e-3 * deviation)
            .max(1e-9 * theta[column].abs())
            .max(1e-12);
        let moved = |sign: f64| {
            let mut theta = theta;
            theta[column] += sign * by;
            unknowns(theta)
        };
        let (up, down) = (moved(1.0).ok_or_else(none)?, moved(-1.0).ok_or_else(none)?);
        for row in 0..3 {
            slopes[(row, column)] = (up[row] - down[row]) / (2.0 * by);
        }
    }
    let p = estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let covariance = slopes * p * slopes.transpose();
    Ok(Physical {
        values: DVector::from_row_slice(&parameters),
        covariance: DMatrix::from_fn(3, 3, |i, j| covariance[(i, j)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::{SAMPLE_TIME, pulses};
    use crate::estimators::{Estimator, OutputError, VehicleSearch};
    use crate::structure::{Problem, Structure};
    use planesman_record::Run;
    use planesman_record::with_noise;

    #[test]
    fn the_way_there_and_back_is_the_zero_order_hold() {
        // With a pair of complex poles, and an integrator.
        let g = TransferFunction::new(vec![2.0, 3.0], vec![1.0, 1.2, 4.0, 0.0]).unwrap();
        let held = g.companion().unwrap().zero_order_hold(0.1).unwrap();
        let sampled = held.transfer_function(0, 0).unwrap();
        let lead = sampled.den[0];
        let mut b: Vec<f64> = sampled.num.iter().map(|c| c / lead).collect();
        let a: Vec<f64> = sampled.den[1..].iter().map(|c| c / lead).collect();
        while b.len() > a.len() {
            b.remove(0);
        }
        while b.len() < a.len() {
            b.insert(0, 0.0);
        }
        let model = Model {
            sample_time: 0.1,
            a,
            feedthrough: 0.0,
            b,
            c: vec![],
            bias: 0.0,
        };
        let back = continuous(&model).unwrap();
        let point = Complex::new(0.3, 1.7);
        let off = back.transfer.value_at(point) - g.value_at(point);
        assert!(off.modulus() < 1e-6, "{off}");
        assert_eq!(back.delay, 0.0);
    }

    #[test]
    fn a_delay_comes_out_as_time_and_a_smoothers_pole_is_refused() {
        let late = Model {
            sample_time: 0.1,
            a: vec![-0.9, 0.0, 0.0],
            feedthrough: 0.0,
            b: vec![0.0, 0.0, 1.0],
            c: vec![],
            bias: 0.0,
        };
        let found = continuous(&late).unwrap();
        assert!((found.delay - 0.2).abs() < 1e-12);
        let smoother = Model {
            a: vec![-0.45, -0.4],
            b: vec![0.06, 0.09],
            ..late
        };
        assert!(
            continuous(&smoother)
                .unwrap_err()
                .to_string()
                .contains("no continuous-time system has a sampled pole")
        );
    }

    #[test]
    fn the_pitch_equation_of_the_discrete_fit_is_that_of_the_direct_one() {
        let inputs = pulses();
        let b = 0.1;
        let clean = planesman_record::filter(&[0.0, b, -b], &[1.0, -1.75, 0.76], &inputs);
        let outputs = with_noise(&clean, 3, 0.005);
        let record = Run {
            inputs: &inputs,
            outputs: &outputs,
            ..Run::default()
        };
        let structure = Structure::of_order(2).with_zero_at_one();
        let problem = Problem::new(structure, SAMPLE_TIME, vec![record]).unwrap();
        let converted = pitch_equation(&OutputError.fit(&problem).unwrap()).unwrap();
        let direct = VehicleSearch::default().fit(&problem).unwrap();
        let direct = direct.physical.unwrap();
        for i in 0..3 {
            assert!((converted.values[i] / direct.values[i] - 1.0).abs() < 1e-5);
            let ratio = converted.covariance[(i, i)] / direct.covariance[(i, i)];
            assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
        }
    }
}
