//! Simulates the loop tick by tick: steps of setpoint and load, with limits of the input.

use std::collections::VecDeque;

use crate::controller::Controller;
use crate::plant::Plant;

/// A disturbance of the loop, which is at rest before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The step of the setpoint, output unit.
    pub setpoint: f64,
    /// The step of a load at the plant's input, input unit.
    pub load: f64,
    /// The allowed change of the input from its initial value, down and up.
    pub limit: Option<(f64, f64)>,
}

/// Output and input at the ticks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Output unit.
    pub output: Vec<f64>,
    /// The controller's command, within the limits, input unit.
    pub input: Vec<f64>,
    /// Ticks at which the command was at a limit.
    pub at_limit: usize,
}

impl Motion {
    /// Simulates the loop for this many ticks. While the command is at a limit, the integral is not updated (conditional integration).
    #[must_use]
    pub fn new(plant: &Plant, controller: &Controller, trial: &Trial, ticks: usize) -> Self {
        let Plant { a, b, delay, tick } = plant;
        let mut motion = Self {
            output: Vec::with_capacity(ticks),
            input: Vec::with_capacity(ticks),
            at_limit: 0,
        };
        // The latest first.
        let (mut inputs, mut outputs) = (VecDeque::new(), VecDeque::new());
        let (mut integral, mut derivative, mut before) = (0.0, 0.0, 0.0);
        let lead = controller.filter + tick;
        for _ in 0..ticks {
            // With a delay of 1 the latest input is that of the tick before.
            let driving: f64 = (b.iter().enumerate())
                .filter_map(|(j, b)| Some(b * inputs.get((delay + j).checked_sub(1)?)?))
                .sum();
            let own: f64 = a
                .iter()
                .zip(&outputs)
                .map(|(a, y): (&f64, &f64)| a * y)
                .sum();
            let y = driving - own;
            let error = trial.setpoint - y;
            if controller.kd != 0.0 {
                derivative = (controller.filter * derivative - controller.kd * (y - before)) / lead;
            }
            before = y;
            let grown = integral + controller.ki * tick * error;
            let asked = controller.kp * error + grown + derivative;
            let (low, high) = trial.limit.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let input = asked.clamp(low, high);
            motion.at_limit += usize::from(input != asked);
            let winds_up = (asked - input) * (grown - integral) > 0.0;
            if !winds_up {
                integral = grown;
            }
            inputs.push_front(input + trial.load);
            inputs.truncate(delay + b.len());
            outputs.push_front(y);
            outputs.truncate(a.len());
            motion.output.push(y);
            motion.input.push(input);
        }
        motion
    }

    /// The integral of the output's absolute deviation from a value, output unit times s.
    #[must_use]
    pub fn absolute_error(&self, from: f64, tick: f64) -> f64 {
        tick * self.output.iter().map(|y| (y - from).abs()).sum::<f64>()
    }

    /// The total travel of the input, input unit.
    #[must_use]
    pub fn travel(&self) -> f64 {
        let first = self.input.first().map_or(0.0, |u| u.abs());
        first
            + self
                .input
                .windows(2)
                .map(|u| (u[1] - u[0]).abs())
                .sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_is_taken_away_and_its_error_has_the_integral_of_the_textbook() {
        // Astrom and Hagglund 2006, ch. 4: the integral of the error after a unit step of load is 1/ki; without overshoot IAE too.
        let plant = Plant::of_z(&[0.1], &[1.0, -0.9], 0.1, 2);
        let pi = Controller::ideal(1.0, 2.0, 0.0);
        let trial = Trial {
            setpoint: 0.0,
            load: 1.0,
            limit: None,
        };
        let motion = Motion::new(&plant, &pi, &trial, 2000);
        assert!(motion.output.last().unwrap().abs() < 1e-9);
        assert!((motion.absolute_error(0.0, 0.1) - 2.0).abs() < 1e-6);
        assert!((motion.input.last().unwrap() + 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_plant_by_itself_follows_its_difference_equation() {
        // y_k = 0.5 y_(k-1) + 0.3 u_(k-2) + 0.1 u_(k-3), u = 1 by load alone.
        let plant = Plant {
            a: vec![-0.5],
            b: vec![0.3, 0.1],
            delay: 2,
            tick: 1.0,
        };
        let none = Controller {
            kp: 0.0,
            ki: 0.0,
            kd: 0.0,
            filter: 0.0,
        };
        let trial = Trial {
            setpoint: 0.0,
            load: 1.0,
            limit: None,
        };
        let found = Motion::new(&plant, &none, &trial, 5).output;
        for (y, expected) in found.iter().zip([0.0, 0.0, 0.3, 0.55, 0.675]) {
            assert!((y - expected).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn an_input_at_its_limit_does_not_wind_up() {
        let plant = Plant::of_z(&[0.1], &[1.0, -0.9], 0.1, 1);
        let pi = Controller::ideal(2.0, 0.5, 0.0);
        let motion = |limit| {
            Motion::new(
                &plant,
                &pi,
                &Trial {
                    setpoint: 1.0,
                    load: 0.0,
                    limit,
                },
                300,
            )
        };
        let (free, held) = (motion(None), motion(Some((-1.2, 1.2))));
        assert!(held.at_limit > 3 && free.at_limit == 0);
        assert!(held.input.iter().all(|u| u.abs() <= 1.2));
        let highest = |m: &Motion| m.output.iter().fold(0.0_f64, |most, y| most.max(*y));
        assert!(highest(&held) < highest(&free));
        assert!((held.output.last().unwrap() - 1.0).abs() < 1e-3);
    }
}
