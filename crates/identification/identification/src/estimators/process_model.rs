//! The forms of process models, their responses with slopes, and an estimated model (`process` lists the forms).

use nalgebra::{DMatrix, DVector};
use planesman_linear::polynomial::product;

use crate::structure::{Structure, monic};

/// The transfer function of a form.
macro_rules! equation {
    (First) => {
        "K e^(-theta s) / (T1 s + 1)"
    };
    (Second) => {
        "K e^(-theta s) / ((T1 s + 1) (T2 s + 1))"
    };
    (Underdamped) => {
        "K e^(-theta s) / ((s/wn)^2 + 2 zeta s/wn + 1)"
    };
    (Integrator) => {
        "K e^(-theta s) / s"
    };
    (IntegratorWithLag) => {
        "K e^(-theta s) / (s (T1 s + 1))"
    };
}

planesman_wording::choices! {
    /// The form of a process model.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Form {
        First = "1": concat!("One time constant: ", equation!(First)),
        Second = "2": concat!("Two time constants: ", equation!(Second)),
        Underdamped = "2u": concat!("Underdamped: ", equation!(Underdamped)),
        Integrator = "i": concat!("Integrator: ", equation!(Integrator)),
        IntegratorWithLag = "1i": concat!("Integrator with a time constant: ", equation!(IntegratorWithLag)),
    }
}

impl Form {
    /// The transfer function as text.
    #[must_use]
    pub const fn equation(self) -> &'static str {
        match self {
            Self::First => equation!(First),
            Self::Second => equation!(Second),
            Self::Underdamped => equation!(Underdamped),
            Self::Integrator => equation!(Integrator),
            Self::IntegratorWithLag => equation!(IntegratorWithLag),
        }
    }

    /// The parameters, each with its unit; the gain is in the output's unit per the input's, and per s for an integrator.
    #[must_use]
    pub const fn parameters(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::First => &[("K", ""), ("T1", "s"), ("theta", "s")],
            Self::Second => &[("K", ""), ("T1", "s"), ("T2", "s"), ("theta", "s")],
            Self::Underdamped => &[("K", ""), ("wn", "rad/s"), ("zeta", ""), ("theta", "s")],
            Self::Integrator => &[("K", "per s"), ("theta", "s")],
            Self::IntegratorWithLag => &[("K", "per s"), ("T1", "s"), ("theta", "s")],
        }
    }

    /// Whether it integrates.
    #[must_use]
    pub const fn integrates(self) -> bool {
        matches!(self, Self::Integrator | Self::IntegratorWithLag)
    }

    /// The number of poles, without the integrator.
    pub(super) const fn poles(self) -> usize {
        match self {
            Self::Integrator => 0,
            Self::First | Self::IntegratorWithLag => 1,
            Self::Second | Self::Underdamped => 2,
        }
    }

    /// The sampled model's structure for a dead time below one sample.
    pub(super) fn structure(self, of: &Structure) -> Structure {
        let poles = self.poles();
        let structure = Structure {
            offset: of.offset,
            start: of.start,
            numerator: poles + 1,
            ..Structure::of_order(poles)
        };
        match self.integrates() {
            false => structure,
            true => Structure {
                numerator: poles + 2,
                known_denominator: vec![1.0, -1.0],
                ..structure
            },
        }
    }

    /// The response to a unit step at a time, for a gain of 1; `shape` contains `ln T1`, or `ln wn` and `ln zeta`.
    pub(super) fn step(self, shape: &[f64], time: f64) -> f64 {
        match self {
            Self::Integrator => time,
            Self::First => -libm::expm1(-time / libm::exp(shape[0])),
            Self::IntegratorWithLag => {
                let constant = libm::exp(shape[0]);
                time + constant * libm::expm1(-time / constant)
            }
            Self::Second | Self::Underdamped => {
                let (decay, even, odd) = motion(shape, time);
                1.0 - even - decay * odd
            }
        }
    }

    /// `a1 ... an` of the sampled model.
    pub(super) fn denominator(self, shape: &[f64], sample_time: f64) -> Vec<f64> {
        match self {
            Self::Integrator => Vec::new(),
            Self::First | Self::IntegratorWithLag => {
                vec![-libm::exp(-sample_time / libm::exp(shape[0]))]
            }
            Self::Second | Self::Underdamped => {
                let (decay, even, _) = motion(shape, sample_time);
                vec![-2.0 * even, libm::exp(-2.0 * decay * sample_time)]
            }
        }
    }

    /// `a1 ... an` and `b1 ... bm` for a gain of 1 and a fractional dead time, samples.
    pub(super) fn sampled(
        self,
        shape: &[f64],
        fraction: f64,
        sample_time: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let a = self.denominator(shape, sample_time);
        let mut through = product(&monic(&a), &[1.0, -1.0]);
        if self.integrates() {
            through = product(&through, &[1.0, -1.0]);
        }
        let count = through.len() - 1;
        let steps: Vec<f64> = (1..=count)
            .map(|k| self.step(shape, (k as f64 - fraction) * sample_time))
            .collect();
        let b = (0..count).map(|i| (0..=i).map(|j| through[j] * steps[i - j]).sum());
        (a, b.collect())
    }

    /// The parameters in the order of [`Form::parameters`], and their slopes by gain, shape and dead time in samples. Two time constants
    /// separate like a square root where they coincide: there the slope uses the damping ratio's own `spread`.
    pub(super) fn natural(
        self,
        gain: f64,
        shape: &[f64],
        delay: f64,
        dt: f64,
        spread: f64,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let mut values = vec![gain];
        let count = shape.len() + 2;
        let mut slopes = DMatrix::identity(count, count);
        let exponentials: Vec<f64> = shape.iter().map(|it| libm::exp(*it)).collect();
        for (i, value) in exponentials.iter().enumerate() {
            slopes[(i + 1, i + 1)] = *value;
        }
        values.extend(&exponentials);
        if let (Self::Second, [omega, zeta]) = (self, &exponentials[..]) {
            let root = (zeta * zeta - 1.0).max(0.0).sqrt();
            let slow = (zeta + root) / omega;
            let fast = 1.0 / (omega * omega * slow);
            (values[1], values[2]) = (slow, fast);
            // d ln T = d ln zeta zeta/root - d ln wn, of the fast one with the other sign.
            let by_zeta = zeta / root.max(spread.sqrt()).max(f64::MIN_POSITIVE);
            for (row, value, by_zeta) in [(1, slow, by_zeta), (2, fast, -by_zeta)] {
                slopes[(row, 1)] = -value;
                slopes[(row, 2)] = value * by_zeta;
            }
        }
        values.push(delay * dt);
        slopes[(count - 1, count - 1)] = dt;
        (values, slopes)
    }
}

/// For two poles: the decay rate, and the free motion `e^(-decay t)` times cos and sin (or cosh and sinh) over their rate.
fn motion(shape: &[f64], time: f64) -> (f64, f64, f64) {
    let (omega, zeta) = (libm::exp(shape[0]), libm::exp(shape[1]));
    let decay = zeta * omega;
    let rate = omega * (zeta * zeta - 1.0).abs().sqrt();
    let envelope = libm::exp(-decay * time);
    if rate * time.abs() < 1e-6 {
        return (decay, envelope, envelope * time);
    }
    if zeta < 1.0 {
        let (sin, cos) = libm::sincos(rate * time);
        return (decay, envelope * cos, envelope * sin / rate);
    }
    let slow = libm::exp(-omega * time / (zeta + (zeta * zeta - 1.0).sqrt()));
    let fast = libm::exp(-(decay + rate) * time);
    (decay, (slow + fast) / 2.0, (slow - fast) / (2.0 * rate))
}

/// An estimated process model.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessModel {
    /// Its form.
    pub form: Form,
    /// Parameters in the order of [`Form::parameters`].
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// The number of all estimated values, including input level and initial states.
    pub sought: usize,
}

impl ProcessModel {
    /// Name, unit, value and standard deviation of each parameter.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &'static str, f64, f64)> {
        let values = self.values.iter().enumerate();
        let each = self.form.parameters().iter().zip(values);
        each.map(|((name, unit), (i, value))| {
            let deviation = self.covariance[(i, i)].max(0.0).sqrt();
            (*name, *unit, *value, deviation)
        })
    }

    /// Numerator and denominator in s, highest power first, and the dead time, s.
    #[must_use]
    pub fn transfer(&self) -> (Vec<f64>, Vec<f64>, f64) {
        let v = self.values.as_slice();
        let den = match self.form {
            Form::First => vec![v[1], 1.0],
            Form::Second => vec![v[1] * v[2], v[1] + v[2], 1.0],
            Form::Underdamped => vec![v[1].powi(-2), 2.0 * v[2] / v[1], 1.0],
            Form::Integrator => vec![1.0, 0.0],
            Form::IntegratorWithLag => vec![v[1], 1.0, 0.0],
        };
        (vec![v[0]], den, v[v.len() - 1])
    }
}
