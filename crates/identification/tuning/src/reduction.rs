//! Reduces models to first or second order with dead time by Skogestad's half rule.
//!
//! ```text
//! k prod(T_j s + 1) / prod(tau_i s + 1) e^(-theta s)   ->   k e^(-theta' s) / ((tau_1 s + 1)(tau_2 s + 1))
//! first order   tau_1 = tau_10 + tau_20/2                   theta' = theta + tau_20/2 + sum from 3 of tau_i0 + sum of inverse responses + T/2
//! second order  tau_1 = tau_10, tau_2 = tau_20 + tau_30/2    theta' = theta + tau_30/2 + sum from 4 of tau_i0 + sum of inverse responses + T/2
//! ```
//! with half a tick `T/2` for the hold. Zeros in the left half plane are first cancelled against a nearby time constant, by the rules T1 to
//! T3 (Skogestad, *J. Process Control* 13, 2003, sec. 2 and 3). If these rules change the gain, the longest remaining lag is scaled with
//! it: `k / tau_1`, which the rules preserve, stays the same, and `k` is the model's gain. An integrator counts as an infinite time constant, which no
//! zero cancels.

use nalgebra::Complex;
use planesman_linear::ComplexFunctions as _;

use crate::dynamics::Dynamics;

/// Number of rounds in which the dead time used by the rules for zeros converges.
const ROUNDS: usize = 30;
/// A pair with at least this damping ratio counts as two equal time constants.
const DAMPED: f64 = 0.7;
/// A time constant is close to a zero's if it is smaller by a factor of less than this value, just below 1.6 (Skogestad 2003, sec. 3.2).
const CLOSE: f64 = 1.6 * 0.999;
/// Gains within this share of each other count as equal.
const SAME: f64 = 1e-9;

/// The number of remaining time constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// One time constant, for a PI controller.
    First,
    /// Two time constants, for a PID controller.
    Second,
}

/// `gain e^(-delay s) / ((time_constants[0] s + 1) (time_constants[1] s + 1))`; with an integrator the first is infinite and means `1/s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    /// `k`; with integrators `k'` of `k'/s`, `k''` of `k''/s^2`.
    pub gain: f64,
    /// `tau_1`, and for second order `tau_2`, s.
    pub time_constants: Vec<f64>,
    /// `theta`, s.
    pub delay: f64,
}

impl Reduced {
    /// `tau_1`, s; infinite for an integrator.
    #[must_use]
    pub fn first(&self) -> f64 {
        self.time_constants.first().copied().unwrap_or(0.0)
    }

    /// `tau_2`, s; 0 for first order.
    #[must_use]
    pub fn second(&self) -> f64 {
        self.time_constants.get(1).copied().unwrap_or(0.0)
    }

    /// The number of integrators.
    #[must_use]
    pub fn integrators(&self) -> usize {
        let constants = self.time_constants.iter();
        constants.filter(|tau| tau.is_infinite()).count()
    }
}

/// The feature of a model that makes this reduction impossible.
pub type Unfit = String;

/// Reduces a model that a controller sees through a hold of `hold` seconds (half of it counts as dead time).
///
/// # Errors
/// A feature that the rule does not cover: unstable poles, lightly damped pairs, complex zeros, more integrators than time constants, a
/// zero that no lag of the reduced model compensates.
pub fn half_rule(of: &Dynamics, order: Order, hold: f64) -> Result<Reduced, Unfit> {
    let mut constants = vec![f64::INFINITY; of.integrators];
    for pole in &of.poles {
        constants.push(time_constant(*pole)?);
    }
    let (mut leads, mut inverse) = (Vec::new(), 0.0);
    for zero in &of.zeros {
        match (zero.re, zero.im) {
            (0.0, 0.0) => {
                return Err("a zero at s = 0, so its input has no steady effect".to_owned());
            }
            (re, 0.0) if re < 0.0 => leads.push(-1.0 / re),
            // To the right they are dead time, a pair as the sum of its time constants.
            (re, _) if re > 0.0 => inverse += re / zero.norm_sqr(),
            _ => return Err(format!("complex zeros at {:.4} rad/s", zero.modulus())),
        }
    }
    let kept = match order {
        Order::First => 1,
        Order::Second => 2,
    };
    if of.integrators > kept {
        return Err(format!("{} integrators", of.integrators));
    }
    let begin = of.delay + inverse + 0.5 * hold;
    let mut reduced = reduced(of.gain, &constants, &leads, begin, begin, kept);
    for _ in 0..ROUNDS {
        let again = self::reduced(of.gain, &constants, &leads, begin, reduced.delay, kept);
        let settled = (again.delay - reduced.delay).abs() <= 1e-9 * again.delay;
        reduced = again;
        if settled {
            break;
        }
    }
    let longest = reduced
        .time_constants
        .iter_mut()
        .find(|tau| tau.is_finite());
    let factor = of.gain / reduced.gain;
    match longest {
        Some(tau) => *tau *= factor,
        None if (factor - 1.0).abs() > SAME => {
            return Err(format!(
                "a zero of time constant {:.4} s, which no reduced model with the same gain can \
                 represent",
                leads.iter().copied().fold(0.0, f64::max)
            ));
        }
        None => {}
    }
    reduced.gain = of.gain;
    reduced.time_constants.sort_by(|a, b| b.total_cmp(a));
    Ok(reduced)
}

fn time_constant(pole: Complex<f64>) -> Result<f64, Unfit> {
    let size = pole.modulus();
    let damping = -pole.re / size;
    match pole.im {
        _ if pole.re >= 0.0 && pole.im == 0.0 => Err(format!(
            "an unstable pole of time constant {:.4} s",
            1.0 / size
        )),
        0.0 => Ok(1.0 / size),
        _ if damping >= DAMPED => Ok(damping / size),
        _ => Err(format!(
            "a mode of {size:.4} rad/s with damping ratio {damping:.3}"
        )),
    }
}

/// One round: `theta` is the dead time used by the rules for zeros.
fn reduced(
    gain: f64,
    constants: &[f64],
    leads: &[f64],
    begin: f64,
    theta: f64,
    kept: usize,
) -> Reduced {
    let (mut gain, mut lags) = (gain, constants.to_vec());
    let slowest_first = |lags: &mut Vec<f64>| lags.sort_by(|a, b| b.total_cmp(a));
    slowest_first(&mut lags);
    let mut leads = leads.to_vec();
    slowest_first(&mut leads);
    for lead in leads {
        let tau = neighbour(&lags, lead).map_or(0.0, |lag| lags.remove(lag));
        let (factor, left) = cancelled(lead, tau, theta);
        gain *= factor;
        lags.extend(left);
        slowest_first(&mut lags);
    }
    let mut delay = begin;
    let mut time_constants: Vec<f64> = lags.iter().take(kept).copied().collect();
    if let Some(next) = lags.get(kept) {
        delay += next / 2.0;
        if let Some(last) = time_constants.last_mut() {
            *last += next / 2.0;
        }
    }
    delay += lags.iter().skip(kept + 1).sum::<f64>();
    time_constants.sort_by(|a, b| b.total_cmp(a));
    Reduced {
        gain,
        time_constants,
        delay,
    }
}

/// The lag to cancel a lead with: the nearest larger one, or the nearest smaller one if it is close.
fn neighbour(lags: &[f64], lead: f64) -> Option<usize> {
    let larger = lags.iter().rposition(|tau| *tau >= lead && tau.is_finite());
    let smaller = lags.iter().position(|tau| *tau < lead);
    match (larger, smaller) {
        (Some(a), Some(b)) => {
            let is_close = lead / lags[b] < lags[a] / lead && lead / lags[b] < CLOSE;
            Some(if is_close { b } else { a })
        }
        (one, other) => one.or(other),
    }
}

/// Replaces `(lead s + 1) / (tau s + 1)` by a factor and a remaining lag.
fn cancelled(lead: f64, tau: f64, theta: f64) -> (f64, Option<f64>) {
    if lead >= tau {
        return match () {
            _ if tau >= theta => (lead / tau, None),    // T1
            _ if lead >= theta => (lead / theta, None), // T1a
            _ => (1.0, None),                           // T1b
        };
    }
    let within = tau.min(5.0 * theta);
    match lead >= within {
        true => (lead / tau, None),                   // T2
        false => (within / tau, Some(within - lead)), // T3
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::{TransferFunction, polynomial::product};

    fn dynamics(leads: &[f64], lags: &[f64], gain: f64, delay: f64) -> Dynamics {
        let of = |constants: &[f64]| {
            let factors = constants.iter().map(|t| match t.is_infinite() {
                true => vec![1.0, 0.0],
                false => vec![*t, 1.0],
            });
            factors.fold(vec![1.0], |all, it| product(&all, &it))
        };
        let num = of(leads).iter().map(|c| gain * c).collect();
        Dynamics::new(&TransferFunction::new(num, of(lags)).unwrap(), delay).unwrap()
    }

    /// Skogestad 2003, Table 2 and Table 4: (leads, lags, gain, dead time), then tau_1 and theta of first order, gain of first
    /// order, then tau_1, tau_2 and theta of second order.
    #[test]
    fn the_half_rule_gives_the_models_of_the_papers_table() {
        let inf = f64::INFINITY;
        type Case<'a> = (
            &'a str,
            &'a [f64],
            &'a [f64],
            f64,
            f64,
            [f64; 3],
            Option<[f64; 3]>,
        );
        let cases: [Case<'_>; 13] = [
            (
                "E1",
                &[],
                &[1.0, 0.2],
                1.0,
                0.0,
                [1.0, 1.1, 0.1],
                Some([1.0, 0.2, 0.0]),
            ),
            (
                "E2",
                &[-0.3, 0.08],
                &[2.0, 1.0, 0.4, 0.2, 0.05, 0.05, 0.05],
                1.0,
                0.0,
                [1.0, 2.5, 1.47],
                Some([2.0, 1.2, 0.77]),
            ),
            (
                "E3",
                &[15.0],
                &[20.0, 1.0, 0.1, 0.1],
                2.0,
                0.0,
                [1.5, 1.05, 0.15],
                Some([1.0, 0.15, 0.05]),
            ),
            (
                "E4",
                &[],
                &[1.0, 1.0, 1.0, 1.0],
                1.0,
                0.0,
                [1.0, 1.5, 2.5],
                Some([1.5, 1.0, 1.5]),
            ),
            (
                "E5",
                &[],
                &[1.0, 0.2, 0.04, 0.008],
                1.0,
                0.0,
                [1.0, 1.1, 0.148],
                Some([1.0, 0.22, 0.028]),
            ),
            (
                "E7",
                &[-2.0],
                &[1.0, 1.0, 1.0],
                1.0,
                0.0,
                [1.0, 1.5, 3.5],
                Some([1.5, 1.0, 2.5]),
            ),
            (
                "E8",
                &[],
                &[inf, 1.0, 1.0],
                1.0,
                0.0,
                [1.0, inf, 1.5],
                Some([inf, 1.5, 0.5]),
            ),
            (
                "E9",
                &[],
                &[1.0, 1.0],
                1.0,
                1.0,
                [1.0, 1.5, 1.5],
                Some([1.0, 1.0, 1.0]),
            ),
            (
                "E10",
                &[],
                &[20.0, 2.0],
                1.0,
                1.0,
                [1.0, 21.0, 2.0],
                Some([20.0, 2.0, 1.0]),
            ),
            (
                "E11",
                &[-1.0],
                &[6.0, 2.0, 2.0],
                1.0,
                1.0,
                [1.0, 7.0, 5.0],
                Some([6.0, 3.0, 3.0]),
            ),
            (
                "E12",
                &[6.0, 3.0],
                &[10.0, 8.0, 1.0],
                1.0,
                0.3,
                [0.225, 1.0, 0.3],
                None,
            ),
            (
                "E13",
                &[2.0],
                &[10.0, 0.5],
                1.0,
                1.0,
                [0.625, 4.5, 1.25],
                None,
            ),
            ("E14", &[-1.0], &[inf], 1.0, 0.0, [1.0, inf, 1.0], None),
        ];
        let near = |found: f64, expected: f64| {
            found == expected || (found - expected).abs() < 2e-3 * (1.0 + expected.abs())
        };
        for (name, leads, lags, gain, delay, first, second) in cases {
            let of = dynamics(leads, lags, gain, delay);
            let found = half_rule(&of, Order::First, 0.0).unwrap();
            let [k, tau, theta] = first;
            // The paper changes the gain where a zero cancels a lag; here it is the model's, and the lag is as much longer.
            assert_eq!(found.gain, of.gain, "{name}");
            let tau = tau * gain / k;
            assert!(
                near(found.first(), tau) && near(found.delay, theta),
                "{name}: {found:?}"
            );
            if let Some([tau_1, tau_2, theta]) = second {
                let found = half_rule(&of, Order::Second, 0.0).unwrap();
                let tau_1 = tau_1 * gain / k;
                assert!(
                    near(found.first(), tau_1)
                        && near(found.second(), tau_2)
                        && near(found.delay, theta),
                    "{name}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn half_a_tick_of_hold_is_dead_time() {
        let found = half_rule(&dynamics(&[], &[3.0], 2.0, 0.4), Order::First, 0.2).unwrap();
        assert!((found.delay - 0.5).abs() < 1e-12);
    }

    /// 2/((5 s + 1)(s + 1)) at 20 Hz, as it was identified: sampling left a zero near z = -1, which is a lead of 0.3 ms.
    #[test]
    fn a_zero_shorter_than_a_sample_is_dead_time_and_the_gain_stays() {
        let late = dynamics(&[0.03], &[5.0, 1.0], 2.0, 0.1).with_short_zeros_as_delay(0.05);
        assert!(late.zeros.is_empty() && (late.delay - 0.07).abs() < 1e-12);
        let early = dynamics(&[-0.03], &[5.0, 1.0], 2.0, 0.0).with_short_zeros_as_delay(0.05);
        assert!((early.delay - 0.03).abs() < 1e-12);
        let none = dynamics(&[3.07e-4], &[5.0, 1.0], 2.0, 0.0).with_short_zeros_as_delay(0.05);
        let found = half_rule(&none, Order::Second, 0.05).unwrap();
        assert!(
            (found.gain - 2.0).abs() < 1e-9 && (found.delay - 0.025).abs() < 1e-9,
            "{found:?}"
        );
        assert!(
            (found.first() - 5.0).abs() < 1e-6 && (found.second() - 1.0).abs() < 1e-6,
            "{found:?}"
        );
        // Longer ones are no dead time.
        let lead = dynamics(&[0.6], &[5.0, 1.0], 1.0, 0.2).with_short_zeros_as_delay(0.05);
        assert_eq!(lead.zeros.len(), 1);
        let gain = half_rule(&lead, Order::First, 0.0).unwrap().gain;
        assert!((gain - 1.0).abs() < 1e-12, "{gain}");
        // An integrator has no lag to grow.
        let refusal = half_rule(
            &dynamics(&[2.0], &[f64::INFINITY, 5.0], 1.0, 0.1),
            Order::First,
            0.0,
        );
        assert!(refusal.unwrap_err().contains("zero of time constant 2"));
    }

    #[test]
    fn what_the_rule_does_not_know_is_said() {
        let of = |num: &[f64], den: &[f64]| {
            let transfer = TransferFunction::new(num.to_vec(), den.to_vec()).unwrap();
            half_rule(&Dynamics::new(&transfer, 0.0).unwrap(), Order::Second, 0.0).unwrap_err()
        };
        assert!(of(&[1.0], &[1.0, -0.5]).contains("unstable pole of time constant 2"));
        assert!(of(&[1.0], &[1.0, 0.2, 1.0]).contains("damping ratio 0.100"));
        assert!(of(&[1.0, 0.2, 1.0], &[1.0, 2.0, 1.0]).contains("complex zeros"));
        assert!(of(&[1.0, 0.0], &[1.0, 2.0, 1.0]).contains("zero at s = 0"));
    }
}
