//! The AUV's depth loop through a digital hydraulic actuator: what its quantum, friction and leakage
//! leave of a dive once it is over.
//!
//! Vehicle and gains are those of program T6 (Brunner, NPS thesis, 1988, App. C), in feet, pounds
//! and radians, here with theta and delta positive to dive:
//!
//! ```text
//! J theta'' = K_y delta - B_y theta' - M_theta sin theta,      z' = U sin theta
//! theta_c = 0.25 (z_c - z) - 0.6 z',                           |theta_c| <= 45 degrees
//! delta_c = 0.7 (1 + K_i/s)(theta_c - theta) - 2.0 theta',     |delta_c| <= 30 degrees
//! ```
//! J = 0.6, B_y = 0.06, K_y = 0.14 ft lb/rad, U = 1 ft/s, M_theta = 0 in the program and 0.163 with the
//! thesis's righting moment. The control computer samples every 0.05 s; the valves run on their own clock.
//!
//! `data/limit_cycles.json` lists the configurations compared, each with what an independent simulation of
//! the same loop found.

use std::f64::consts::TAU;

use planesman_linear::Complex;
use serde::Deserialize;

use crate::actuator_file::{ActuatorFileError, load};
use crate::actuator_set::ActuatorSet;
use crate::describing_function::{Search, balance};
use crate::dha::{Demand, Dha};
use crate::frequency_response::{self, Periods};
use crate::pulse_logic::Options;
use crate::units::{DEGREE, INCH};

/// The control computer's sampling time, s.
const TICK: f64 = 0.05;
/// The vehicle's steps in a tick.
const STEPS: i64 = 50;
/// z_c, ft.
const STEP: f64 = 3.0;
/// When a dive is over, and when the watch ends, in ticks.
const WATCH: (i64, i64) = (5_000, 10_000);

const INERTIA: f64 = 0.6;
const DAMPING: f64 = 0.06;
const PLANES: f64 = 0.14;
const SPEED: f64 = 1.0;
const DEPTH_GAIN: f64 = 0.25;
const DEPTH_RATE_GAIN: f64 = 0.6;
const PITCH_GAIN: f64 = 0.7;
const PITCH_RATE_GAIN: f64 = 2.0;
const MOST_PITCH: f64 = 45.0 * DEGREE;
const MOST_PLANES: f64 = 30.0 * DEGREE;

/// How much the actuator leaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Leakage {
    /// Not at all.
    None,
    /// About a thirtieth of its file: q_L = 0.01 deg/s, q_LC = -0.001 deg/s at the planes.
    Tight,
    /// As its file says.
    Scaled,
}

/// The pulse logic of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Logic {
    /// One volume.
    SingleSpeed,
    /// A large and a small volume.
    TwoSpeed,
    /// One volume, the drift following the error.
    Precision,
    /// Both.
    TwoSpeedPrecision,
}

/// One row of the comparison.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// What it is called.
    pub name: String,
    /// The actuator's file or built-in name.
    pub actuator: String,
    /// The pulse logic.
    pub logic: Logic,
    /// Whether the position loop is closed.
    pub position_loop: bool,
    /// The leakages.
    pub leakage: Leakage,
    /// Whether there is Coulomb friction.
    pub friction: bool,
    /// K_i, 1/s.
    pub integral: f64,
    /// M_theta, ft lb.
    pub restoring: f64,
    /// What the independent simulation found.
    pub expected: Option<Expected>,
}

/// What a run is expected to show, in the units of the file; a figure that is not there is not expected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Expected {
    /// Depth, peak to peak, in.
    pub depth: Option<f64>,
    /// Mean depth less the depth asked for, in.
    pub error: Option<f64>,
    /// Planes, peak to peak, deg.
    pub planes: Option<f64>,
    /// Volumes a second.
    pub pulses: Option<f64>,
    /// Until the depth first comes within 5 % of the step, s.
    pub reached: Option<f64>,
}

/// A figure found beside what was expected, in the file's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// What, and its unit.
    pub name: &'static str,
    /// By this simulation; none where the run does not show it.
    pub found: Option<f64>,
    /// By the independent one.
    pub expected: Option<f64>,
    /// What is too small to matter.
    floor: f64,
}

impl Figure {
    /// Whether the two are within 15 % of one another, or both too small to tell. What is not expected
    /// cannot deviate.
    #[must_use]
    pub fn agrees(&self) -> bool {
        match (self.found, self.expected) {
            (Some(found), Some(expected)) => {
                (found - expected).abs() <= 0.15 * expected.abs() + self.floor
            }
            (None, Some(_)) => false,
            (_, None) => true,
        }
    }
}

/// What a dive leaves behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitCycle {
    /// Depth, peak to peak, m.
    pub depth: f64,
    /// Mean depth less the depth asked for, m.
    pub error: f64,
    /// Plane angle, peak to peak, rad.
    pub planes: f64,
    /// Volumes commanded in a second.
    pub pulses: f64,
    /// Of the depth about its mean, Hz; 0 without two crossings.
    pub frequency: f64,
    /// When the depth first comes within 5 % of the step, s.
    pub reached: Option<f64>,
}

impl LimitCycle {
    /// The table's columns beside what was expected.
    #[must_use]
    pub fn figures(&self, expected: &Expected) -> [Figure; 5] {
        let figure = |name, found, expected, floor| Figure {
            name,
            found,
            expected,
            floor,
        };
        let e = expected;
        [
            figure("depth, in", Some(self.depth / INCH), e.depth, 0.002),
            figure("error, in", Some(self.error / INCH), e.error, 0.002),
            figure("planes, deg", Some(self.planes / DEGREE), e.planes, 0.01),
            figure("volumes/s", Some(self.pulses), e.pulses, 0.01),
            figure("t95, s", self.reached, e.reached, 0.05),
        ]
    }
}

/// A cycle that harmonic balance predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Hz.
    pub frequency: f64,
    /// Depth, peak to peak, m.
    pub depth: f64,
    /// What remains of 1 + N H: 0 where the balance holds.
    pub residual: f64,
}

/// The cases of `data/limit_cycles.json`.
///
/// # Errors
/// Where the file does not read, which a test excludes.
pub fn cases() -> Result<Vec<Case>, serde_json::Error> {
    #[derive(Deserialize)]
    struct File {
        #[serde(rename = "note")]
        _note: String,
        cases: Vec<Case>,
    }
    let file: File = serde_json::from_str(include_str!("../data/limit_cycles.json"))?;
    Ok(file.cases)
}

impl Case {
    /// The actuator, leaking and rubbing as the case says.
    ///
    /// # Errors
    /// Those of its file.
    pub fn set(&self) -> Result<ActuatorSet, ActuatorFileError> {
        let mut set = load(&self.actuator)?;
        let per_radian = set.area * set.moment_arm;
        match self.leakage {
            Leakage::None => (set.rate_gain, set.error_rate) = (0.0, 0.0),
            Leakage::Tight => {
                set.rate_gain = 0.01 * DEGREE * per_radian;
                set.error_rate = -0.001 * DEGREE * per_radian;
            }
            Leakage::Scaled => {}
        }
        if !self.friction {
            set.coulomb = 0.0;
        }
        Ok(set)
    }

    fn demand(&self, angle: f64) -> Demand {
        Demand {
            position_loop: self.position_loop,
            logic: match self.logic {
                Logic::SingleSpeed => Options::SINGLE_SPEED,
                Logic::TwoSpeed => Options::TWO_SPEED,
                Logic::Precision => Options::PRECISION,
                Logic::TwoSpeedPrecision => Options::TWO_SPEED_PRECISION,
            },
            ..Demand::angle(angle)
        }
    }

    /// Dives by 3 ft and watches from 250 to 500 s.
    ///
    /// # Errors
    /// Those of the actuator's file.
    pub fn run(&self) -> Result<LimitCycle, ActuatorFileError> {
        let loop_around = Loop {
            integral: self.integral,
            restoring: self.restoring,
        };
        Ok(loop_around.dive(&self.set()?, |_| self.demand(0.0)))
    }

    /// The cycle that [`Loop::foresee`] finds for the case.
    ///
    /// # Errors
    /// Those of the actuator's file.
    pub fn predict(&self) -> Result<Prediction, ActuatorFileError> {
        let set = self.set()?;
        let finest = set.small.map_or(set.threshold, |small| small.threshold);
        let smallest = match self.logic {
            Logic::SingleSpeed => set.threshold,
            Logic::TwoSpeed => finest,
            Logic::Precision | Logic::TwoSpeedPrecision => 0.1 * finest,
        };
        let loop_around = Loop {
            integral: self.integral,
            restoring: self.restoring,
        };
        Ok(
            loop_around.foresee(&set, (smallest, 4.0 * set.threshold), |amplitude| {
                self.demand(amplitude)
            }),
        )
    }
}

/// What may be changed about the loop of program T6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loop {
    /// K_i, 1/s.
    pub integral: f64,
    /// M_theta, ft lb.
    pub restoring: f64,
}

impl Loop {
    /// Dives by 3 ft with an actuator and watches from 250 to 500 s; `asked` is how it is asked for the
    /// angle of the control computer, by the time in s.
    #[must_use]
    pub fn dive(&self, set: &ActuatorSet, asked: impl Fn(f64) -> Demand) -> LimitCycle {
        let mut dha = Dha::new(set);
        let mut vehicle = Vehicle {
            restoring: self.restoring,
            ..Vehicle::default()
        };
        let mut control = Control {
            integral_gain: self.integral,
            integral: 0.0,
        };
        let mut watched = Watched::default();
        let (mut planes, mut reached, mut pulses_before) = (0.0, None, 0);
        for k in 0..WATCH.1 {
            if k == WATCH.0 {
                pulses_before = dha.pulses();
            }
            let demand = Demand {
                angle: control.plane_command(&vehicle),
                ..asked(k as f64 * TICK)
            };
            for j in 1..=STEPS {
                let time = (k * STEPS + j) as f64 * (TICK / STEPS as f64);
                let nanos = (k * STEPS + j) * 1_000_000;
                dha.advance_to(nanos, demand);
                let angle = dha.plane_angle(&dha.reading(nanos));
                vehicle.advance(0.5 * (planes + angle), TICK / STEPS as f64);
                planes = angle;
                let error = vehicle.depth - STEP;
                if reached.is_none() && error >= -0.05 * STEP {
                    reached = Some(time);
                }
                if k >= WATCH.0 {
                    watched.add(error, angle);
                }
            }
        }
        let seconds = (WATCH.1 - WATCH.0) as f64 * TICK;
        LimitCycle {
            pulses: (dha.pulses() - pulses_before) as f64 / seconds,
            reached,
            ..watched.cycle(TICK / STEPS as f64)
        }
    }

    /// The cycle for which harmonic balance holds best, 1 + N(A, w) H(jw) = 0, with amplitudes (rad, of
    /// what is asked of the actuator) from and to. The actuator's describing function is taken from the
    /// full model under a sinusoid, friction, leakage and delays included; `asked` is how it is asked for
    /// an amplitude.
    #[must_use]
    pub fn foresee(
        &self,
        set: &ActuatorSet,
        amplitudes: (f64, f64),
        asked: impl Fn(f64) -> Demand,
    ) -> Prediction {
        let periods = Periods {
            settling: 1,
            measured: 3,
        };
        let describing_function = |amplitude: f64, frequency: f64| {
            frequency_response::actuator(set, asked(amplitude), frequency, periods)
        };
        let search = Search {
            amplitudes,
            frequencies: (0.01 * TAU, 0.5 * TAU),
        };
        let found = balance(&search, describing_function, |w| self.around_the_planes(w));
        let planes = found.amplitude * describing_function(found.amplitude, found.frequency).norm();
        let depth_feet = planes * (self.pitch(found.frequency) * SPEED).norm() / found.frequency;
        Prediction {
            frequency: found.frequency / TAU,
            depth: 2.0 * depth_feet * 12.0 * INCH,
            residual: found.residual,
        }
    }

    /// theta/delta of the vehicle in small motion, at a frequency, rad/s.
    fn pitch(&self, frequency: f64) -> Complex<f64> {
        let s = Complex::new(0.0, frequency);
        Complex::from(PLANES) / (s * s * INERTIA + s * DAMPING + self.restoring)
    }

    /// H = -delta_c/delta of vehicle and control computer, at a frequency, rad/s: the loop without the
    /// actuator. The computer's sampling is a dead time of half a tick.
    fn around_the_planes(&self, frequency: f64) -> Complex<f64> {
        let s = Complex::new(0.0, frequency);
        let integral = self.integral / s + 1.0;
        let pitch_error = DEPTH_GAIN * SPEED / s + DEPTH_RATE_GAIN * SPEED + 1.0;
        let feedback = PITCH_GAIN * integral * pitch_error + PITCH_RATE_GAIN * s;
        feedback * self.pitch(frequency) * (-s * (0.5 * TICK)).exp()
    }
}

/// The vehicle of program T6, ft and rad.
#[derive(Clone, Copy, Debug, Default)]
struct Vehicle {
    restoring: f64,
    pitch: f64,
    pitch_rate: f64,
    depth: f64,
}

impl Vehicle {
    /// Heun's step of `h` s with the planes at `delta`, rad.
    fn advance(&mut self, delta: f64, h: f64) {
        let rates = |pitch: f64, pitch_rate: f64| {
            let moment = PLANES * delta - DAMPING * pitch_rate - self.restoring * pitch.sin();
            [pitch_rate, moment / INERTIA, SPEED * pitch.sin()]
        };
        let k1 = rates(self.pitch, self.pitch_rate);
        let k2 = rates(self.pitch + h * k1[0], self.pitch_rate + h * k1[1]);
        let mean = |i: usize| 0.5 * h * (k1[i] + k2[i]);
        self.pitch += mean(0);
        self.pitch_rate += mean(1);
        self.depth += mean(2);
    }
}

/// The control computer of program T6, with an integral that the program does not have.
#[derive(Clone, Copy, Debug)]
struct Control {
    /// K_i, 1/s.
    integral_gain: f64,
    /// rad s
    integral: f64,
}

impl Control {
    /// delta_c, rad.
    fn plane_command(&mut self, vehicle: &Vehicle) -> f64 {
        let pitch_command =
            DEPTH_GAIN * (STEP - vehicle.depth) - DEPTH_RATE_GAIN * SPEED * vehicle.pitch.sin();
        let pitch_error = pitch_command.clamp(-MOST_PITCH, MOST_PITCH) - vehicle.pitch;
        let proportional_integral = pitch_error + self.integral_gain * self.integral;
        let planes = PITCH_GAIN * proportional_integral - PITCH_RATE_GAIN * vehicle.pitch_rate;
        if planes.abs() <= MOST_PLANES {
            self.integral += pitch_error * TICK;
        }
        planes.clamp(-MOST_PLANES, MOST_PLANES)
    }
}

/// What is watched.
#[derive(Debug, Default)]
struct Watched {
    /// Depth errors, ft.
    depths: Vec<f64>,
    /// Plane angles, rad: the least and the largest.
    planes: Option<(f64, f64)>,
}

impl Watched {
    fn add(&mut self, depth: f64, planes: f64) {
        self.depths.push(depth);
        let (low, high) = self.planes.unwrap_or((planes, planes));
        self.planes = Some((low.min(planes), high.max(planes)));
    }

    /// Of samples `dt` s apart; what needs more than them is left 0.
    fn cycle(&self, dt: f64) -> LimitCycle {
        let foot = 12.0 * INCH;
        let mean = self.depths.iter().sum::<f64>() / self.depths.len() as f64;
        let (low, high) = self
            .depths
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), z| {
                (low.min(*z), high.max(*z))
            });
        let rising: Vec<usize> = self
            .depths
            .windows(2)
            .enumerate()
            .filter(|(_, pair)| pair[0] < mean && pair[1] >= mean)
            .map(|(i, _)| i)
            .collect();
        let frequency = match rising[..] {
            [first, .., last] => (rising.len() - 1) as f64 / ((last - first) as f64 * dt),
            _ => 0.0,
        };
        let planes = self.planes.map_or(0.0, |(low, high)| high - low);
        LimitCycle {
            depth: (high - low) * foot,
            error: mean * foot,
            planes,
            pulses: 0.0,
            frequency,
            reached: None,
        }
    }
}
