//! The linear model of Section V of IBM 66-L03-005, for signals that are large relative to the quantum and slow relative to the slew rate.
//!
//! A volume that is commanded at t = 0 flows from T_D + T_v over T_f:
//!
//! ```text
//! V/command = (V_c/s) e^-(T_D + T_v)s (1 - e^(-T_f s))/(T_f s),    (1 - e^(-T_f s))/(T_f s) ~ e^(-T_f s/2)
//! ```
//! and the pulse logic with its accumulator is a zero-order hold over T, about e^(-T s/2). Quantizer and inner loop have unit gain, so the
//! planes follow the command with a dead time (Figure 5-5):
//!
//! ```text
//! A(s) = e^(-tau s) [omega_n^2/(s^2 + 2 zeta omega_n s + omega_n^2)],    tau = T_D + T_v + T_f/2 + T/2
//! ```
//! The bracket is the ram on its oil column without friction; the report omits it. **Do not take gain margins from this model**: friction
//! and the force limit halve them.
//!
//! A sampled loop uses the actuator's own motion instead ([`slew_response`]): the step response of the full model, including friction and
//! force limit. The step is the largest one that the actuator can follow within a tick.

use planesman_linear::{DelayedLoop, Error, TransferFunction};

use crate::actuator_set::ActuatorSet;
use crate::dha::{Demand, Dha};

/// Model of the ram in the linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ram {
    /// The ram follows the metered oil, the same as in the report.
    Rigid,
    /// The ram moves on its oil column with omega_n and zeta.
    OnItsOil,
}

/// tau, s: dead time from the commanded angle to the planes.
#[must_use]
pub fn dead_time(set: &ActuatorSet) -> f64 {
    set.delay() + 0.5 * set.flow_time + 0.5 * set.cycle()
}

/// Transfer function from the commanded plane angle to the plane angle, both rad, with static gain 1. [`DelayedLoop::at`] uses the exact
/// dead time, [`DelayedLoop::rational`] a Pade approximation.
///
/// # Errors
/// [`Error::NotFinite`], if the constants are too large or too small.
pub fn actuator(set: &ActuatorSet, ram: Ram) -> Result<DelayedLoop, Error> {
    let (wn, zeta) = (set.natural_frequency(), set.damping_ratio());
    let transfer_function = match ram {
        Ram::Rigid => TransferFunction::new(vec![1.0], vec![1.0])?,
        Ram::OnItsOil => TransferFunction::new(vec![wn * wn], vec![1.0, 2.0 * zeta * wn, wn * wn])?,
    };
    Ok(DelayedLoop {
        transfer_function,
        delay: dead_time(set),
    })
}

/// Samples of [`slew_response`] in a tick.
const SAMPLES_PER_TICK: u32 = 50;
/// Number of steps that are averaged, and of the steps before them.
const STEPS: (u32, u32) = (32, 8);
/// A motion within this share of its end value counts as ended.
const ENDED: f64 = 1e-4;

/// Largest change of command that the actuator follows within a tick of `tick` \[s\], in volumes: one for each of its valve cycles, at
/// least two. A single volume could be half within the dead zone.
#[must_use]
pub fn volumes_in_a_tick(set: &ActuatorSet, tick: f64) -> u32 {
    ((tick / set.cycle() + 1e-9) as u32).max(2)
}

/// Response of the planes to such a step at a tick, as a share of the final value: knots (time after the tick in s, share), linear in
/// between.
///
/// The response is computed by [`Dha`] without leakage, in its position loop, for a square wave of this size. The response includes delay, metered
/// flow, and the ram with friction and force limit. If a tick is not a whole number of valve cycles, the valves begin at different times in each
/// tick; the result is then the mean of such steps, up and down. `None` if the planes do not complete half of the step.
#[must_use]
pub fn slew_response(set: &ActuatorSet, tick: f64) -> Option<Vec<(f64, f64)>> {
    let mut set = set.clone();
    (set.rate_gain, set.error_rate) = (0.0, 0.0);
    let volumes = volumes_in_a_tick(&set, tick);
    let amplitude = 0.5 * f64::from(volumes) * set.plane_quantum();
    // Long enough for every volume to come, one late decision and the ram's rest.
    let ticks = (f64::from(volumes + 12) * set.cycle() / tick).ceil() as u32 + 4;
    let samples = (ticks * SAMPLES_PER_TICK) as usize;
    let interval = tick / f64::from(SAMPLES_PER_TICK);
    let nanos = |sample: u64| (sample as f64 * interval * 1e9).round() as i64;
    let mut dha = Dha::new(&set);
    let mut sums = vec![0.0; samples];
    let mut begin = 0;
    for step in 0..STEPS.0 + STEPS.1 {
        let side = if step % 2 == 0 { 1.0 } else { -1.0 };
        // Lengths that take turns bring every phase of the valves, whatever their frequency.
        let length = (ticks + step / 2 % 2) * SAMPLES_PER_TICK;
        for sample in begin..begin + u64::from(length) {
            if step >= STEPS.1
                && let Some(sum) = sums.get_mut((sample - begin) as usize)
            {
                *sum += side * dha.plane_angle(&dha.reading(nanos(sample)));
            }
            dha.advance_to(nanos(sample + 1), Demand::angle(side * amplitude));
        }
        begin += u64::from(length);
    }
    let (from, to) = (sums[0], sums[samples - 1]);
    if to - from < amplitude * f64::from(STEPS.0) {
        return None;
    }
    let shares = sums.iter().map(|sum| (sum - from) / (to - from));
    let knots = shares
        .enumerate()
        .map(|(i, share)| (i as f64 * interval, share));
    let mut knots: Vec<_> = knots.collect();
    let moving = knots.iter().rposition(|knot| (knot.1 - 1.0).abs() > ENDED);
    knots.truncate(moving.map_or(1, |last| last + 2));
    Some(knots)
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use planesman_linear::ComplexFunctions as _;
    use planesman_testing::near;

    #[track_caller]
    #[test]
    fn the_dead_times_of_the_three_actuators() {
        for (name, milliseconds) in [
            ("table_3_1", 16.5606),
            ("table_4_1", 16.5606),
            ("auv", 14.75),
        ] {
            near(dead_time(&load(name).unwrap()) * 1e3, milliseconds, 1e-4);
        }
    }

    /// Four volumes in four cycles, each half in the middle of its flow, 5.5 + 3 ms after its cycle's begin: on the mean 27.25 ms; the
    /// ram's damping adds 2 zeta/omega_n = 4 ms (2.0/(500 1/s)), friction a little.
    #[test]
    fn four_volumes_take_the_auvs_actuator_a_tick_and_its_delay() {
        let set = load("auv").unwrap();
        let knots = slew_response(&set, 0.05).unwrap();
        let mean = |knots: &[(f64, f64)]| -> f64 {
            let pairs = knots.windows(2);
            pairs
                .map(|it| (it[1].0 - it[0].0) * (1.0 - 0.5 * (it[0].1 + it[1].1)))
                .sum()
        };
        assert_eq!(volumes_in_a_tick(&set, 0.05), 4);
        assert!((mean(&knots) - 0.03125).abs() < 1e-3, "{}", mean(&knots));
        assert!(
            knots
                .iter()
                .take_while(|it| it.0 < 0.0055)
                .all(|it| it.1.abs() < 1e-9)
        );
        // Friction first holds the ram back, and the fifth volume that answers it is then taken back.
        let furthest = knots.iter().map(|it| it.1).fold(0.0, f64::max);
        assert!((1.0..1.25).contains(&furthest), "{furthest}");
    }

    #[test]
    fn the_linear_actuator_only_delays_until_the_column_rings() {
        let set = load("table_4_1").unwrap();
        let slow = actuator(&set, Ram::OnItsOil).unwrap().at(5.0);
        near(slow.modulus(), 1.0, 1e-3);
        near(slow.argument(), -5.0 * 0.0165606, 3e-3);
        let ringing = actuator(&set, Ram::OnItsOil).unwrap();
        near(
            ringing.at(set.natural_frequency()).modulus(),
            0.5 / set.damping_ratio(),
            1e-9,
        );
    }
}
