//! Test procedures of the report on a simulated flight control (Sections III and IV).
//!
//! - **Maximum stable step**: N_y steering pulses from rest; the largest whole number of pulses in either direction without loss of the missile.
//! - **Gain margin**: N_y = psi_0 = 0, the ram within a quantum of the middle; all gains are multiplied by K_g, raised in steps of 0.5 until the
//!   missile is lost.
//! - **Limit cycle**: psi_0 = -1/2 degree; the motion that remains after twenty seconds.
//!
//! The report does not say how it judged a run. Here a missile is lost when it has turned by 20 degrees (a step of ten pulses is 0.75 degrees, and
//! this missile diverges beyond about 4 degrees). It is stable if that does not happen within half a minute. Near its stability limit the loop is
//! chaotic: compare a row with the report only to within one test step.

use crate::ibm_1966::analog_loop::AnalogLoop;
use crate::ibm_1966::autopilot::Gains;
use crate::ibm_1966::case::Case;
use crate::ibm_1966::digital_loop::Start;
use crate::ibm_1966::missile::Surrogate;
use crate::ibm_1966::tables::Outcome;
use planesman_units::{DEGREE, INCH};

/// Time without loss after which a missile counts as stable, s.
const TRIAL: f64 = 30.0;

/// Yaw angle beyond which a missile counts as lost, rad.
const LOST: f64 = 20.0 * DEGREE;

/// Largest step tried, pulses.
const LARGEST_STEP: i32 = 16;

/// Increment of K_g for the digital flight control.
pub const GAIN_STEP: f64 = 0.5;

/// Largest K_g tried for the digital flight control.
const LARGEST_GAIN: f64 = 10.0;

/// Largest K_g tried for the analog flight control.
const LARGEST_ANALOG_GAIN: f64 = 25.0;

/// A search for the gain margin of the analog flight control (Table 4-3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnalogGainTest {
    /// Number of the runs, without A (stable) and B (unstable).
    pub run: &'static str,
    /// Steering N_y, pulses.
    pub steering: f64,
    /// Increment of K_g.
    pub gain_step: f64,
}

/// Runs C-13, C-19 and C-20.
pub const ANALOG_GAIN_TESTS: [AnalogGainTest; 3] = [
    AnalogGainTest {
        run: "C-13",
        steering: 0.0,
        gain_step: 0.7,
    },
    AnalogGainTest {
        run: "C-19",
        steering: 1.0,
        gain_step: 0.25,
    },
    AnalogGainTest {
        run: "C-20",
        steering: 2.0,
        gain_step: 0.25,
    },
];

/// Initial ram position for the gain margin without leakage, m: half of the drift of a leaking actuator per cycle.
const NUDGE: f64 = -0.0003 * INCH;

/// Motion that remains long after a disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitCycle {
    /// Peak-to-peak psi, rad.
    pub yaw: f64,
    /// Mean of psi, rad.
    pub mean_yaw: f64,
    /// Peak-to-peak delta_a, rad.
    pub nozzle: f64,
    /// Volume pulses per second.
    pub pulses: f64,
}

impl Case {
    /// Whether the missile is not lost with `steering` pulses.
    #[must_use]
    pub fn is_stable(&self, steering: f64, start: Start) -> bool {
        let mut flight = self.fly(start);
        while flight.time() < TRIAL {
            flight.cycle(steering, |_| ());
            if flight.yaw().angle.abs() > LOST {
                return false;
            }
        }
        true
    }

    /// Whether the row's numbers can be within one test step of `printed`. Each number is tested on both sides; the tests most likely to fail run first.
    #[must_use]
    pub fn is_near(&self, printed: &Outcome, start: Start) -> bool {
        let stable = |step: i32| self.is_stable(f64::from(step), start);
        let at_rest = Start { yaw: 0.0, ..start };
        let held = |gain: f64| self.with_gain(gain).is_stable(0.0, at_rest);
        let (plus, minus) = (printed.plus, printed.minus);
        !stable(plus + 2)
            && !stable(minus - 2)
            && !held(printed.gain + 2.0 * GAIN_STEP)
            && stable(plus - 1)
            && stable(minus + 1)
            && held(printed.gain - GAIN_STEP)
    }

    /// Largest stable step in the direction `sign`, +1 or -1, in pulses, signed.
    #[must_use]
    pub fn step_limit(&self, sign: i32) -> i32 {
        self.step_limit_from(sign, Start::default())
    }

    /// Like [`Case::step_limit`], from an initial state.
    pub(crate) fn step_limit_from(&self, sign: i32, start: Start) -> i32 {
        let largest = (1..=LARGEST_STEP)
            .rev()
            .find(|n| self.is_stable(f64::from(sign * n), start));
        sign * largest.unwrap_or(0)
    }

    /// Unstable steps below the largest stable one.
    #[must_use]
    pub fn gaps_below(&self, largest: i32) -> Vec<i32> {
        (1..largest.abs())
            .map(|n| n * largest.signum())
            .filter(|n| !self.is_stable(f64::from(*n), Start::default()))
            .collect()
    }

    /// Largest K_g, from 1 on in steps of 0.5, up to which the loop is stable with the ram at `ram`, m, and no other disturbance.
    #[must_use]
    pub fn gain_limit_from(&self, ram: f64) -> f64 {
        let start = Start { yaw: 0.0, ram };
        last_stable(GAIN_STEP, LARGEST_GAIN, |gain| {
            self.with_gain(gain).is_stable(0.0, start)
        })
    }

    /// Gain margin as in the tables: the run starts as the drifting ram passes the middle. Without leakage a loop at rest in the middle is never
    /// disturbed; it then starts slightly off the middle.
    #[must_use]
    pub fn gain_limit(&self) -> f64 {
        let tight = self.set.rate_gain == 0.0 && self.set.error_rate == 0.0;
        self.gain_limit_from(if tight { NUDGE } else { 0.0 })
    }

    /// Lowest and highest gain margin for seven ram positions within half a quantum of the middle: its scatter due to the initial condition alone.
    #[must_use]
    pub fn gain_limit_scatter(&self) -> (f64, f64) {
        let mut gains = Span::NONE;
        for sixths in -3..=3 {
            let ram = f64::from(sixths) / 6.0 * self.set.ram_quantum();
            gains.add(if sixths == 0 {
                self.gain_limit()
            } else {
                self.gain_limit_from(ram)
            });
        }
        (gains.0, gains.1)
    }

    /// Limit cycle after psi_0 = -1/2 degree, from 20 to 80 s.
    #[must_use]
    pub fn limit_cycle(&self) -> LimitCycle {
        let mut flight = self.fly(Start {
            yaw: -0.5 * DEGREE,
            ram: 0.0,
        });
        while flight.time() < 20.0 {
            flight.cycle(0.0, |_| ());
        }
        let begin = flight.time();
        let (mut yaw, mut nozzle) = (Span::NONE, Span::NONE);
        let (mut sum, mut instants, mut pulses) = (0.0, 0, 0);
        while flight.time() < 80.0 {
            let quanta = flight.cycle(0.0, |now| {
                yaw.add(now.yaw.angle);
                nozzle.add(now.nozzle);
                sum += now.yaw.angle;
                instants += 1;
            });
            pulses += i32::from(quanta != 0);
        }
        LimitCycle {
            yaw: yaw.width(),
            mean_yaw: sum / f64::from(instants),
            nozzle: nozzle.width(),
            pulses: f64::from(pulses) / (flight.time() - begin),
        }
    }
}

/// Whether the analog flight control does not lose the missile, and its actuator does not end in an oscillation at its rate limit.
#[must_use]
pub fn analog_is_stable(surrogate: Surrogate, overall: f64, steering: f64, yaw: f64) -> bool {
    let gains = Gains {
        overall,
        ..Gains::new(surrogate)
    };
    let mut flight = AnalogLoop::new(surrogate, gains, yaw);
    let mut fastest: f64 = 0.0;
    while flight.time() < TRIAL {
        flight.step(steering);
        if flight.yaw().angle.abs() > LOST {
            return false;
        }
        if flight.time() > TRIAL - 2.0 {
            fastest = fastest.max(flight.nozzle_rate().abs());
        }
    }
    fastest < 0.5 * surrogate.analog_rate_limit()
}

/// Largest stable step of the analog flight control, pulses.
#[must_use]
pub fn analog_step_limit(surrogate: Surrogate) -> i32 {
    (1..=LARGEST_STEP)
        .rev()
        .find(|n| analog_is_stable(surrogate, 1.0, f64::from(*n), 0.0))
        .unwrap_or(0)
}

/// Largest K_g, in multiples of `step` from 1 on, up to which the analog flight control is stable with `steering` pulses.
#[must_use]
pub fn analog_gain_limit(surrogate: Surrogate, step: f64, steering: f64) -> f64 {
    // Nothing else disturbs an analog loop at rest.
    let nudge = if steering == 0.0 { 1e-9 } else { 0.0 };
    last_stable(step, LARGEST_ANALOG_GAIN, |gain| {
        analog_is_stable(surrogate, gain, steering, nudge)
    })
}

/// Last multiple of `step`, from 1 on, before the first at which `stable` is false; `largest` if there is none. Gains below 1 are not tried, since an
/// unstable missile needs a minimum gain.
fn last_stable(step: f64, largest: f64, stable: impl Fn(f64) -> bool) -> f64 {
    (1..)
        .map(|i| f64::from(i) * step)
        .skip_while(|gain| *gain < 1.0)
        .take_while(|gain| *gain <= largest)
        .find(|gain| !stable(*gain))
        .map_or(largest, |unstable| unstable - step)
}

/// Range of values: smallest and largest.
struct Span(f64, f64);

impl Span {
    const NONE: Self = Self(f64::INFINITY, f64::NEG_INFINITY);

    fn add(&mut self, value: f64) {
        *self = Self(self.0.min(value), self.1.max(value));
    }

    fn width(&self) -> f64 {
        self.1 - self.0
    }
}
