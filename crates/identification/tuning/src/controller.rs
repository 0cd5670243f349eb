//! PI and PID controllers: their forms and their discrete equations.

use nalgebra::Complex;
use planesman_linear::polar;

/// The derivative's filter is this many times faster than `Td`.
pub const FILTER_RATIO: f64 = 10.0;

/// A PI or PID controller in parallel form, evaluated at every tick of `T` seconds:
///
/// ```text
/// u_k = kp e_k + I_k + D_k           e = setpoint - y
/// I_k = I_(k-1) + ki T e_k
/// D_k = (filter D_(k-1) - kd (y_k - y_(k-1))) / (filter + T)
/// ```
/// (Astrom and Hagglund, *Advanced PID Control*, 2006, ch. 13: backward differences.) The derivative acts on the output alone, so a step of
/// the setpoint causes no impulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Proportional gain, input unit per output unit.
    pub kp: f64,
    /// Integral gain, input unit per output unit and s.
    pub ki: f64,
    /// Derivative gain, input unit per output unit times s; 0 for a PI controller.
    pub kd: f64,
    /// Time constant of the derivative's filter, s.
    pub filter: f64,
}

impl Controller {
    /// Converts the ideal (ISA) form `K (1 + 1/(Ti s) + Td s / (Td/N s + 1))` with N = [`FILTER_RATIO`]; an infinite `Ti` means no integral.
    #[must_use]
    pub fn ideal(k: f64, ti: f64, td: f64) -> Self {
        Self {
            kp: k,
            ki: k / ti,
            kd: k * td,
            filter: td / FILTER_RATIO,
        }
    }

    /// Converts the series form `Kc (1 + 1/(tau_i s)) (tau_d s + 1)`.
    #[must_use]
    pub fn series(kc: f64, tau_i: f64, tau_d: f64) -> Self {
        let both = 1.0 + tau_d / tau_i;
        Self::ideal(kc * both, tau_i + tau_d, tau_d / both)
    }

    /// `Ti` of the ideal form, s; infinite without an integral.
    #[must_use]
    pub fn ti(&self) -> f64 {
        self.kp / self.ki
    }

    /// `Td` of the ideal form, s.
    #[must_use]
    pub fn td(&self) -> f64 {
        self.kd / self.kp
    }

    /// The controller with every gain multiplied by a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            kp: factor * self.kp,
            ki: factor * self.ki,
            kd: factor * self.kd,
            filter: self.filter,
        }
    }

    /// The controller's frequency response at a frequency, rad/s, for ticks of `tick` seconds.
    #[must_use]
    pub fn at(&self, frequency: f64, tick: f64) -> Complex<f64> {
        let q = polar(1.0, -frequency * tick);
        let mut sum = Complex::from(self.kp);
        if self.ki != 0.0 {
            sum += (1.0 - q).inv() * (self.ki * tick);
        }
        if self.kd != 0.0 {
            sum += (1.0 - q) * self.kd / (self.filter + tick - q * self.filter);
        }
        sum
    }

    /// Numerator and denominator in `1/z`, lowest power first.
    pub(crate) fn backward(&self, tick: f64) -> (Vec<f64>, Vec<f64>) {
        let lead = self.filter + tick;
        // kp + ki T / (1 - q) + kd (1 - q) / (lead - filter q)
        let integral = match self.ki {
            0.0 => vec![1.0],
            _ => vec![1.0, -1.0],
        };
        let lag = match self.kd {
            0.0 => vec![1.0],
            _ => vec![1.0, -self.filter / lead],
        };
        let product = planesman_linear::polynomial::product;
        let den = product(&integral, &lag);
        let mut num: Vec<f64> = den.iter().map(|c| self.kp * c).collect();
        let mut add = |part: Vec<f64>| {
            num.resize(num.len().max(part.len()), 0.0);
            num.iter_mut().zip(part).for_each(|(sum, c)| *sum += c);
        };
        if self.ki != 0.0 {
            add(lag.iter().map(|c| self.ki * tick * c).collect());
        }
        if self.kd != 0.0 {
            let slope = [self.kd / lead, -self.kd / lead];
            add(product(&integral, &slope));
        }
        (num, den)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::backward;
    use planesman_linear::ComplexFunctions as _;

    #[test]
    fn the_series_form_has_the_gains_of_the_ideal_one() {
        // Skogestad 2003, (27): K' = Kc (1 + tau_d/tau_i), tau_i' = tau_i + tau_d, tau_d' = tau_d / (1 + tau_d/tau_i).
        let pid = Controller::series(1.3, 2.0, 1.2);
        assert!((pid.kp - 2.08).abs() < 1e-12);
        assert!((pid.ti() - 3.2).abs() < 1e-12 && (pid.td() - 0.75).abs() < 1e-12);
        assert_eq!(Controller::series(2.0, 4.0, 0.0).ti(), 4.0);
    }

    #[test]
    fn the_ratio_of_polynomials_is_the_response() {
        for pid in [
            Controller::ideal(2.0, 3.0, 0.0),
            Controller::ideal(2.0, 3.0, 0.7),
            Controller::ideal(2.0, f64::INFINITY, 0.7),
        ] {
            let (num, den) = pid.backward(0.1);
            for w in [0.01, 1.0, 20.0] {
                let q = polar(1.0, -w * 0.1);
                let found = backward(&num, q) / backward(&den, q);
                assert!((found - pid.at(w, 0.1)).modulus() < 1e-9 * found.modulus());
            }
        }
    }
}
