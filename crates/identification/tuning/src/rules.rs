//! Closed-form tuning rules.
//!
//! | rule | for | source |
//! |---|---|---|
//! | [`simc`] | a lag, two lags, one or two integrators, with dead time | Skogestad, *J. Process Control* 13, 2003, Table 1 |
//! | [`lambda`] | the same, except two integrators | Rivera, Morari and Skogestad 1986; for integrators Chien and Fruehauf 1990 |
//! | [`placement`] | first order (PI), second order (PID), also unstable and oscillating models | Astrom and Hagglund, *Advanced PID Control*, 2006, ch. 6 |
//! | [`crossover`] | any plant with a known frequency response of the loop | the same, ch. 6: phase margin at a given frequency |

use planesman_linear::{ComplexFunctions as _, polar};

use crate::closed_loop::PlantResponse;
use crate::controller::{Controller, FILTER_RATIO};
use crate::reduction::Reduced;

/// The ratio of `Ti` to `Td` if the required phase does not determine both; the controller's zeros are then equal.
const TI_PER_TD: f64 = 4.0;

/// SIMC: the loop shall respond with the time constant `tau_c` (s) after the dead time. With a second time constant it gives a PID
/// controller (in the series form, returned in the ideal one).
#[must_use]
pub fn simc(model: &Reduced, tau_c: f64) -> Controller {
    let pace = tau_c + model.delay;
    let slowest = 4.0 * pace;
    match model.integrators() {
        0 => Controller::series(
            model.first() / (model.gain * pace),
            model.first().min(slowest),
            model.second(),
        ),
        1 => Controller::series(1.0 / (model.gain * pace), slowest, model.second()),
        _ => Controller::series(1.0 / (model.gain * slowest * pace), slowest, slowest),
    }
}

/// Lambda tuning: the closed loop shall be a lag of `lambda` seconds after the dead time; for an integrating plant it rejects a load
/// without overshoot. `None` for two integrators.
#[must_use]
pub fn lambda(model: &Reduced, lambda: f64) -> Option<Controller> {
    let pace = lambda + model.delay;
    let (first, second) = (model.first(), model.second());
    match model.integrators() {
        0 => {
            let both = first + second;
            Some(Controller::ideal(
                both / (model.gain * pace),
                both,
                first * second / both,
            ))
        }
        1 => {
            let ti = 2.0 * lambda + model.delay;
            Some(Controller::series(
                ti / (model.gain * pace * pace),
                ti,
                second,
            ))
        }
        _ => None,
    }
}

/// Places the poles of `gain / (a_n s^n + ... + a_0)`, n 1 or 2, with a PI or PID controller at the roots of `(s + wn)^(n - 1) (s^2 + 2 zeta wn s +
/// wn^2)`, without dead time:
///
/// ```text
/// n = 1   K kp = 2 zeta wn a_1 - a_0             K ki = wn^2 a_1
/// n = 2   K kp = (1 + 2 zeta) wn^2 a_2 - a_0     K ki = wn^3 a_2     K kd = (1 + 2 zeta) wn a_2 - a_1
/// ```
/// `None` for another order.
#[must_use]
pub fn placement(gain: f64, den: &[f64], frequency: f64, damping_ratio: f64) -> Option<Controller> {
    match *den {
        [a_1, a_0] => Some(Controller {
            kp: (2.0 * damping_ratio * frequency * a_1 - a_0) / gain,
            ki: frequency.powi(2) * a_1 / gain,
            kd: 0.0,
            filter: 0.0,
        }),
        [a_2, a_1, a_0] => {
            let sum = 1.0 + 2.0 * damping_ratio;
            let kp = (sum * frequency.powi(2) * a_2 - a_0) / gain;
            let kd = (sum * frequency * a_2 - a_1) / gain;
            Some(Controller {
                kp,
                ki: frequency.powi(3) * a_2 / gain,
                kd,
                filter: kd / kp / FILTER_RATIO,
            })
        }
        _ => None,
    }
}

/// The controller that gives the loop its gain crossover at a frequency (rad/s) with a phase margin (rad): PI, or PID with `Ti = 4 Td`.
/// `sign` is the sign of the plant's gain.
///
/// # Errors
/// The missing phase, degrees: above 0 if the controller would need more lead than possible, below 0 if it would need more lag.
pub fn crossover(
    seen: &PlantResponse,
    is_pid: bool,
    sign: f64,
    frequency: f64,
    margin: f64,
) -> Result<Controller, f64> {
    let tick = seen.plant.tick;
    let plant = seen.plant.at(frequency) * sign;
    // What the controller is to be there.
    let wanted = -polar(1.0, margin) / plant;
    let degrees = wanted.argument().to_degrees();
    if !is_pid {
        let integral = (1.0 - polar(1.0, -frequency * tick)).inv() * tick;
        let ki = wanted.im / integral.im;
        let kp = wanted.re - ki * integral.re;
        return match ki >= 0.0 && kp > 0.0 {
            true => Ok(Controller {
                kp,
                ki,
                kd: 0.0,
                filter: 0.0,
            }
            .times(sign)),
            false if degrees > 0.0 => Err(degrees),
            false => Err((degrees + 90.0).min(-f64::MIN_POSITIVE)),
        };
    }
    let shape = |td: f64| Controller::ideal(1.0, TI_PER_TD * td, td);
    let phase = |td: f64| shape(td).at(frequency, tick).argument();
    let (mut low, mut high) = (1e-4 / frequency, 1e4 / frequency);
    // The most lead lies between; beyond it the filter takes it away.
    let mut best = low;
    for k in 0..=160 {
        let td = low * libm::pow(high / low, f64::from(k) / 160.0);
        if phase(td) > phase(best) {
            best = td;
        }
    }
    high = best;
    match wanted.argument() {
        arg if arg > phase(high) => return Err((arg - phase(high)).to_degrees()),
        arg if arg < phase(low) => return Err((arg - phase(low)).to_degrees()),
        _ => {}
    }
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        if phase(middle) < wanted.argument() {
            low = middle;
        } else {
            high = middle;
        }
    }
    let shape = shape(high);
    Ok(shape.times(sign * wanted.modulus() / shape.at(frequency, tick).modulus()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Plant;
    use planesman_linear::{TransferFunction, polynomial};

    /// Skogestad 2003, Table 4 (tau_c = theta): Kc, tau_I, tau_D in the series form of the models of Table 2.
    #[test]
    fn simc_gives_the_settings_of_the_papers_table() {
        let inf = f64::INFINITY;
        for (name, gain, constants, delay, [kc, tau_i, tau_d]) in [
            ("E1 PI", 1.0, vec![1.1], 0.1, [5.5, 0.8, 0.0]),
            ("E2 PI", 1.0, vec![2.5], 1.47, [0.85, 2.5, 0.0]),
            ("E2 PID", 1.0, vec![2.0, 1.2], 0.77, [1.30, 2.0, 1.2]),
            ("E3 PI", 1.5, vec![1.05], 0.15, [2.33, 1.05, 0.0]),
            ("E3 PID", 1.5, vec![1.0, 0.15], 0.05, [6.67, 0.4, 0.15]),
            ("E4 PI", 1.0, vec![1.5], 2.5, [0.3, 1.5, 0.0]),
            ("E4 PID", 1.0, vec![1.5, 1.0], 1.5, [0.5, 1.5, 1.0]),
            ("E5 PI", 1.0, vec![1.1], 0.148, [3.72, 1.1, 0.0]),
            ("E5 PID", 1.0, vec![1.0, 0.22], 0.028, [17.9, 0.224, 0.22]),
            ("E8 PI", 1.0, vec![inf], 1.5, [0.33, 12.0, 0.0]),
            ("E8 PID", 1.0, vec![inf, 1.5], 0.5, [1.0, 4.0, 1.5]),
            ("E10 PI", 1.0, vec![21.0], 2.0, [5.25, 16.0, 0.0]),
            ("E10 PID", 1.0, vec![20.0, 2.0], 1.0, [10.0, 8.0, 2.0]),
            ("E11 PID", 1.0, vec![6.0, 3.0], 3.0, [1.0, 6.0, 3.0]),
            ("E12 PI", 0.225, vec![1.0], 0.3, [7.41, 1.0, 0.0]),
            ("E14 PI", 1.0, vec![inf], 1.0, [0.5, 8.0, 0.0]),
        ] {
            let found = simc(
                &Reduced {
                    gain,
                    time_constants: constants,
                    delay,
                },
                delay,
            );
            let expected = Controller::series(kc, tau_i, tau_d);
            let near = |a: f64, b: f64| (a - b).abs() <= 0.015 * b.abs();
            assert!(
                near(found.kp, expected.kp)
                    && near(found.ki, expected.ki)
                    && near(found.kd, expected.kd),
                "{name}: {found:?} {expected:?}"
            );
        }
        // Two integrators: Kc = 1/(4 k'' (tau_c + theta)^2), tau_I = tau_D = 4 (tau_c + theta).
        let found = simc(
            &Reduced {
                gain: 2.0,
                time_constants: vec![inf, inf],
                delay: 1.0,
            },
            1.0,
        );
        let expected = Controller::series(1.0 / 32.0, 8.0, 8.0);
        assert!((found.kp - expected.kp).abs() < 1e-12 && (found.kd - expected.kd).abs() < 1e-12);
    }

    #[test]
    fn lambda_cancels_the_lags() {
        let found = lambda(
            &Reduced {
                gain: 2.0,
                time_constants: vec![5.0],
                delay: 1.0,
            },
            4.0,
        )
        .unwrap();
        assert!((found.kp - 0.5).abs() < 1e-12 && (found.ti() - 5.0).abs() < 1e-12);
        let pid = lambda(
            &Reduced {
                gain: 2.0,
                time_constants: vec![5.0, 3.0],
                delay: 1.0,
            },
            4.0,
        )
        .unwrap();
        // (5 s + 1)(3 s + 1) = 15 s^2 + 8 s + 1
        assert!((pid.ti() - 8.0).abs() < 1e-12 && (pid.td() - 15.0 / 8.0).abs() < 1e-12);
        let level = lambda(
            &Reduced {
                gain: 0.1,
                time_constants: vec![f64::INFINITY],
                delay: 2.0,
            },
            6.0,
        )
        .unwrap();
        assert!(
            (level.kp - 14.0 / (0.1 * 64.0)).abs() < 1e-12 && (level.ti() - 14.0).abs() < 1e-12
        );
    }

    #[test]
    fn poles_come_out_where_they_are_placed() {
        for (gain, den) in [
            (2.0, vec![3.0, 1.0]),
            (0.5, vec![1.0, 0.0]),
            (-2.0, vec![-2.0, 1.0]),
            (1.5, vec![4.0, 0.4, 1.0]),
        ] {
            let pid = placement(gain, &den, 1.5, 0.6).unwrap();
            let closed = polynomial::sum(
                &[&den[..], &[0.0]].concat(),
                &[gain * pid.kd, gain * pid.kp, gain * pid.ki],
            );
            for root in polynomial::roots(&closed).unwrap() {
                let wanted = root.im == 0.0 && (root.re + 1.5).abs() < 1e-9
                    || (root.modulus() - 1.5).abs() < 1e-9 && (root.re + 0.9).abs() < 1e-9;
                assert!(wanted, "{root}");
            }
        }
        assert_eq!(placement(1.0, &[1.0], 1.0, 0.7), None);
    }

    #[test]
    fn the_crossover_is_where_it_is_asked_for_and_has_the_margin() {
        let transfer = TransferFunction::new(vec![-2.0], vec![3.0, 1.0]).unwrap();
        let seen = PlantResponse::new(Plant::held(&transfer, 0.4, 0.1).unwrap());
        for (is_pid, frequency) in [(false, 0.8), (true, 2.0)] {
            let found = crossover(&seen, is_pid, -1.0, frequency, 1.0).unwrap();
            assert!(found.kp < 0.0);
            let margins = seen.margins(&found);
            assert!(
                (margins.phase - 1.0).abs() < 1e-6
                    && (margins.crossover.unwrap() - frequency).abs() < 1e-6
            );
        }
        assert!(crossover(&seen, false, -1.0, 4.0, 1.0).unwrap_err() > 0.0);
        assert!(crossover(&seen, true, -1.0, 0.001, 1.0).unwrap_err() < 0.0);
    }
}
