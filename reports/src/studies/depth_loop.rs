//! The AUV's depth loop with a digital hydraulic actuator: the limit cycle caused by quantum, friction and leakage after a dive.
//!
//! The vehicle is taken from program T6 (Brunner, NPS thesis, 1988, App. C), optionally with the thesis' righting moment (`M_theta`). The controller
//! is the depth controller with its default gains, which are the program's, and the program's sampling time of 0.05 s. The valves have their own
//! clock. The simulation is compared with the harmonic balance of [`DepthLoop`]. `limit_cycles.json` lists the configurations, each with the results
//! of an independent simulation of the same loop.

use planesman_control::LimitError;
use planesman_control::gains::PitchModel;
use planesman_hydraulics::actuator_file::{ActuatorFileError, load};
use planesman_hydraulics::{ActuatorSet, Demand, Dha, Options};
use planesman_show::design::{DepthLoop, Describing, Prediction};
use planesman_units::{DEGREE, INCH};
use serde::Deserialize;

pub use crate::studies::dive::{Diving, Loop};
use crate::studies::dive::{Flight, TICK};
use crate::studies::orbit::{Actuation, Lags, Orbit, range};
use crate::studies::watched::{Motion, Watched};

/// Relative difference, and depth difference in inches, within which results count as equal.
const SAME: (f64, f64) = (0.15, 0.002);
/// First and last tick of the observation after a dive, the same as in the independent simulation.
const OBSERVED: (i64, i64) = (5_000, 10_000);
/// Tick at which all transients have settled.
const SETTLED: i64 = 2 * OBSERVED.1;
/// Initial ram positions, quanta.
pub const STARTS: [f64; 3] = [0.0, -0.375, 0.25];

/// The reason why a dive cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum DiveError {
    /// Error of the actuator file.
    #[error(transparent)]
    Actuator(#[from] ActuatorFileError),
    /// Error of the controller's limits.
    #[error(transparent)]
    Controller(#[from] LimitError),
}

/// Leakage of the actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Leakage {
    /// No leakage.
    None,
    /// About a thirtieth of the file's leakage: q_L = 0.01 deg/s, q_LC = -0.001 deg/s at the planes.
    Tight,
    /// Leakage of the file.
    Scaled,
}

/// Pulse logic of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Logic {
    /// One volume.
    SingleSpeed,
    /// A large and a small volume.
    TwoSpeed,
    /// One volume; the drift is steered by the error.
    Precision,
    /// Two volumes, and drift steered by the error.
    TwoSpeedPrecision,
}

/// A configuration of the comparison.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the configuration.
    pub name: String,
    /// Actuator file or built-in actuator.
    pub actuator: String,
    /// The pulse logic.
    pub logic: Logic,
    /// Whether the position loop is closed.
    pub position_loop: bool,
    /// The leakages.
    pub leakage: Leakage,
    /// Whether there is Coulomb friction.
    pub friction: bool,
    /// Integral gain K_i, 1/s.
    pub integral: f64,
    /// Righting moment M_theta, ft lb.
    pub restoring: f64,
    /// Results of the independent simulation.
    pub expected: Option<Expected>,
}

/// Results of the independent simulation, in the units of the file; `None` if the file has no results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Expected {
    /// Peak-to-peak depth, in.
    pub depth: Option<f64>,
    /// Mean depth minus the setpoint, in.
    pub error: Option<f64>,
    /// Peak-to-peak plane angle, deg.
    pub planes: Option<f64>,
    /// Volumes per second.
    pub pulses: Option<f64>,
    /// Time until the depth is first within 5 % of the step, s.
    pub reached: Option<f64>,
}

/// A result with its expected value, in the file's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Name and unit.
    pub name: &'static str,
    /// Result of this simulation; `None` if the run does not show it.
    pub found: Option<f64>,
    /// Result of the independent simulation.
    pub expected: Option<f64>,
    /// Difference that always counts as agreement.
    floor: f64,
}

impl Figure {
    /// Whether the two differ by less than 15 %, or both are below the resolution. A result without an expected value agrees.
    #[must_use]
    pub fn agrees(&self) -> bool {
        match (self.found, self.expected) {
            (Some(found), Some(expected)) => {
                (found - expected).abs() <= SAME.0 * expected.abs() + self.floor
            }
            (None, Some(_)) => false,
            (_, None) => true,
        }
    }
}

/// Result of a dive.
#[derive(Clone, Debug)]
pub struct Dive {
    /// Limit cycle observed at its end.
    pub cycle: LimitCycle,
    /// The observed motion, sample by sample.
    pub watched: Watched<Diving>,
    flight: Flight,
}

impl Dive {
    /// Whether the depth is still settling between 250 and 500 s: its amplitude later is smaller by more than [`Figure::agrees`] allows.
    #[must_use]
    pub fn settles(&self) -> bool {
        let last = LimitCycle::of(&self.watched).depth;
        self.cycle.depth > last + SAME.0 * last + SAME.1 * INCH
    }
}

/// Limit cycle after a dive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitCycle {
    /// Peak-to-peak depth, m.
    pub depth: f64,
    /// Mean depth minus the setpoint, m.
    pub error: f64,
    /// Peak-to-peak plane angle, rad.
    pub planes: f64,
    /// Commanded volumes per second.
    pub pulses: f64,
    /// Frequency of the depth about its mean, Hz; 0 if it crosses the mean less than twice.
    pub frequency: f64,
    /// Time until the depth is first within 5 % of the step, s.
    pub reached: Option<f64>,
}

impl LimitCycle {
    /// Limit cycle of an observed motion; quantities that need more data are 0.
    fn of(watched: &Watched<Diving>) -> Self {
        let depths = &watched.outputs;
        let mean = depths.iter().sum::<f64>() / depths.len() as f64;
        let (low, high) = range(depths.iter().copied());
        let rising: Vec<usize> = depths
            .windows(2)
            .enumerate()
            .filter(|(_, pair)| pair[0] < mean && pair[1] >= mean)
            .map(|(i, _)| i)
            .collect();
        let frequency = match rising[..] {
            [first, .., last] => {
                (rising.len() - 1) as f64 / ((last - first) as f64 * watched.interval)
            }
            _ => 0.0,
        };
        let planes = range(watched.angles.iter().copied());
        Self {
            depth: high - low,
            error: mean,
            planes: planes.1 - planes.0,
            pulses: 0.0,
            frequency,
            reached: None,
        }
    }

    /// Columns of the table with expected values.
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
            figure("depth, in", Some(self.depth / INCH), e.depth, SAME.1),
            figure("error, in", Some(self.error / INCH), e.error, 0.002),
            figure("planes, deg", Some(self.planes / DEGREE), e.planes, 0.01),
            figure("volumes/s", Some(self.pulses), e.pulses, 0.01),
            figure("t95, s", self.reached, e.reached, 0.05),
        ]
    }
}

/// Cases of `limit_cycles.json`.
///
/// # Errors
/// The file cannot be read, which a test excludes.
pub fn cases() -> Result<Vec<Case>, serde_json::Error> {
    #[derive(Deserialize)]
    struct File {
        #[serde(rename = "note")]
        _note: String,
        cases: Vec<Case>,
    }
    let file: File = serde_json::from_str(include_str!("../../data/studies/limit_cycles.json"))?;
    Ok(file.cases)
}

impl Case {
    /// The actuator with the leakage and friction of the case.
    ///
    /// # Errors
    /// Errors of its file.
    pub fn set(&self) -> Result<ActuatorSet, ActuatorFileError> {
        let mut set = load(&self.actuator)?;
        let per_radian = set.area * set.load.moment_arm;
        match self.leakage {
            Leakage::None => (set.rate_gain, set.error_rate) = (0.0, 0.0),
            Leakage::Tight => {
                set.rate_gain = 0.01 * DEGREE * per_radian;
                set.error_rate = -0.001 * DEGREE * per_radian;
            }
            Leakage::Scaled => {}
        }
        if !self.friction {
            set.load.coulomb = 0.0;
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

    fn around(&self) -> Loop {
        Loop {
            integral: self.integral,
            restoring: self.restoring,
        }
    }

    /// Simulates a dive by 3 ft and observes it from 250 to 500 s.
    ///
    /// # Errors
    /// Errors of the actuator file and of [`Loop::dive`].
    pub fn run(&self) -> Result<Dive, DiveError> {
        self.run_from(0.0)
    }

    /// Like [`Case::run`], with the ram initially at `ram`, m.
    ///
    /// # Errors
    /// As for [`Case::run`].
    pub fn run_from(&self, ram: f64) -> Result<Dive, DiveError> {
        Ok(self
            .around()
            .dive(&self.set()?, |_| self.demand(0.0), ram)?)
    }

    /// The loop's actuator and logic, in the form needed to find orbits.
    ///
    /// # Errors
    /// Errors of the actuator file.
    pub fn actuation(&self) -> Result<Actuation, ActuatorFileError> {
        let set = self.set()?;
        Ok(Actuation {
            lags: Lags::of(TICK, set.cycle()),
            set,
            logic: self.demand(0.0).logic,
            position_loop: self.position_loop,
        })
    }

    /// Classifies the motion. For that the dive continues to 1000 s; its second half becomes the observed motion.
    ///
    /// # Errors
    /// Errors of the actuator file.
    pub fn motion(&self, dive: &mut Dive) -> Result<Motion, ActuatorFileError> {
        self.settle(dive);
        Ok(dive.watched.motion(&self.actuation()?))
    }

    fn settle(&self, dive: &mut Dive) {
        if dive.flight.tick < SETTLED {
            dive.watched = dive.flight.watch(SETTLED, &|_| self.demand(0.0));
        }
    }

    /// Dives from several ram positions, in quanta, with their motions. An orbit found from one start is tried for all starts.
    ///
    /// # Errors
    /// As for [`Case::run`].
    pub fn motions(&self, places: &[f64]) -> Result<Vec<(Dive, Motion)>, DiveError> {
        let quantum = self.set()?.ram_quantum();
        let mut known: Vec<Orbit> = Vec::new();
        let follows = |known: &[Orbit], dive: &Dive| {
            let orbit = known.iter().find(|orbit| dive.watched.follows(orbit));
            orbit.cloned().map(Motion::Orbit)
        };
        let mut all: Vec<(Dive, Motion)> = Vec::new();
        for place in places {
            let mut dive = self.run_from(place * quantum)?;
            // Where the first comes to an orbit, others come to it soon; where it is irregular, they may pass by one.
            let soon = matches!(all.first(), Some((_, Motion::Orbit(_))));
            let mut motion = follows(&known, &dive).filter(|_| soon);
            if motion.is_none() {
                self.settle(&mut dive);
                motion = follows(&known, &dive);
            }
            let motion = match motion {
                Some(motion) => motion,
                None => self.motion(&mut dive)?,
            };
            let orbit = motion.orbit().filter(|orbit| !known.contains(orbit));
            known.extend(orbit.cloned());
            all.push((dive, motion));
        }
        for (dive, motion) in &mut all {
            if let (Motion::Irregular(_), Some(orbit)) = (&*motion, follows(&known, dive)) {
                *motion = orbit;
            }
        }
        Ok(all)
    }

    /// Whether another configuration has the same actuator and logic, with another vehicle or control law.
    #[must_use]
    pub fn same_actuator(&self, other: &Self) -> bool {
        let actuator = |case: &Self| (case.logic, case.position_loop, case.leakage, case.friction);
        self.actuator == other.actuator && actuator(self) == actuator(other)
    }

    /// The limit cycle predicted by [`Loop::predict`]; `known`: earlier measurements of the same actuator.
    ///
    /// # Errors
    /// Errors of the actuator file.
    pub fn predict(&self, known: &Describing) -> Result<Prediction, ActuatorFileError> {
        let set = self.set()?;
        let finest = set.small.map_or(set.threshold, |small| small.threshold);
        let smallest = match self.logic {
            Logic::SingleSpeed => set.threshold,
            Logic::TwoSpeed => finest,
            Logic::Precision | Logic::TwoSpeedPrecision => 0.1 * finest,
        };
        let amplitudes = (smallest, 4.0 * set.threshold);
        Ok(self
            .around()
            .predict(&set, amplitudes, known, |amplitude| self.demand(amplitude)))
    }
}

impl Loop {
    /// Simulates a dive by 3 ft with the ram initially at `ram`, m, and observes it from 250 to 500 s; `demand`: the demand on the actuator as a
    /// function of time in s, without the angle.
    ///
    /// # Errors
    /// An invalid limit, which the controller's defaults exclude.
    pub fn dive(
        &self,
        set: &ActuatorSet,
        demand: impl Fn(f64) -> Demand,
        ram: f64,
    ) -> Result<Dive, LimitError> {
        let mut flight = Flight::begin(self, Dha::resting_at(set, 1, ram))?;
        flight.until(OBSERVED.0, &demand);
        let pulses_before = flight.dha.pulses();
        let watched = flight.watch(OBSERVED.1, &demand);
        let seconds = (OBSERVED.1 - OBSERVED.0) as f64 * TICK;
        let cycle = LimitCycle {
            pulses: (flight.dha.pulses() - pulses_before) as f64 / seconds,
            reached: flight.reached,
            ..LimitCycle::of(&watched)
        };
        Ok(Dive {
            cycle,
            watched,
            flight,
        })
    }

    /// The limit cycle predicted by harmonic balance, the same as in [`DepthLoop::predict`].
    #[must_use]
    pub fn predict(
        &self,
        set: &ActuatorSet,
        amplitudes: (f64, f64),
        known: &Describing,
        demand: impl Fn(f64) -> Demand,
    ) -> Prediction {
        let plant = self.plant();
        let axis = plant.axis;
        let around = DepthLoop {
            model: PitchModel {
                plane: axis.plane_moment / axis.inertia,
                damping: axis.damping / axis.inertia,
                restoring: axis.restoring / axis.inertia,
            },
            speed: plant.speed,
            integral: self.integral,
        };
        around.predict(set, amplitudes, known, demand)
    }
}
