//! The AUV's depth loop through a digital hydraulic actuator: the limit cycle that its quantum, friction and
//! leakage leave after a dive.
//!
//! The vehicle is program T6's (Brunner, NPS thesis, 1988, App. C), with the thesis's righting moment where a case
//! has one (`M_theta`); the control computer is the depth controller with its default gains, which are the
//! program's, at its sampling time of 0.05 s. The valves run on their own clock. Beside the simulation stands the harmonic
//! balance of [`DepthLoop`].
//! `limit_cycles.json` lists the configurations compared, each with the results of an independent simulation of
//! the same loop.

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

/// Figures are the same within this share, and depths beyond this many in.
const SAME: (f64, f64) = (0.15, 0.002);
/// When a dive is over, and when the observation ends, in ticks: that of the independent simulation.
const OBSERVED: (i64, i64) = (5_000, 10_000);
/// When everything has settled, in ticks.
const SETTLED: i64 = 2 * OBSERVED.1;
/// Where the ram rests at first, in quanta: in the middle, and elsewhere.
pub const STARTS: [f64; 3] = [0.0, -0.375, 0.25];

/// Why a dive is not flown.
#[derive(Debug, thiserror::Error)]
pub enum DiveError {
    /// The actuator's file.
    #[error(transparent)]
    Actuator(#[from] ActuatorFileError),
    /// The controller.
    #[error(transparent)]
    Controller(#[from] LimitError),
}

/// The leakage of the actuator.
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
    /// Its name.
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
    /// The results of the independent simulation.
    pub expected: Option<Expected>,
}

/// The results of the independent simulation, in the units of the file; `None` where it has none.
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
    /// Its name and unit.
    pub name: &'static str,
    /// By this simulation; none where the run does not show it.
    pub found: Option<f64>,
    /// By the independent one.
    pub expected: Option<f64>,
    /// Smaller differences do not matter.
    floor: f64,
}

impl Figure {
    /// Whether the two are within 15 % of one another, or both are below the resolution. What is not expected
    /// cannot deviate.
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

/// A dive, over.
#[derive(Clone, Debug)]
pub struct Dive {
    /// What was observed at its end.
    pub cycle: LimitCycle,
    /// That time, sample by sample.
    pub watched: Watched<Diving>,
    flight: Flight,
}

impl Dive {
    /// Whether the depth still settles from 250 to 500 s: in the time watched last it swings by less, beyond what
    /// [`Figure::agrees`] allows.
    #[must_use]
    pub fn settles(&self) -> bool {
        let last = LimitCycle::of(&self.watched).depth;
        self.cycle.depth > last + SAME.0 * last + SAME.1 * INCH
    }
}

/// The limit cycle after a dive.
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
    /// Of what was watched; what needs more than that is left 0.
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
            figure("depth, in", Some(self.depth / INCH), e.depth, SAME.1),
            figure("error, in", Some(self.error / INCH), e.error, 0.002),
            figure("planes, deg", Some(self.planes / DEGREE), e.planes, 0.01),
            figure("volumes/s", Some(self.pulses), e.pulses, 0.01),
            figure("t95, s", self.reached, e.reached, 0.05),
        ]
    }
}

/// The cases of `limit_cycles.json`.
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
    let file: File = serde_json::from_str(include_str!("../../data/studies/limit_cycles.json"))?;
    Ok(file.cases)
}

impl Case {
    /// The actuator, leaking and rubbing as the case says.
    ///
    /// # Errors
    /// Those of its file.
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

    /// Dives by 3 ft and observes from 250 to 500 s.
    ///
    /// # Errors
    /// Those of the actuator's file and of [`Loop::dive`].
    pub fn run(&self) -> Result<Dive, DiveError> {
        self.run_from(0.0)
    }

    /// As [`Case::run`], the ram resting at `ram`, m, at first.
    ///
    /// # Errors
    /// As of [`Case::run`].
    pub fn run_from(&self, ram: f64) -> Result<Dive, DiveError> {
        Ok(self
            .around()
            .dive(&self.set()?, |_| self.demand(0.0), ram)?)
    }

    /// The loop's actuator and logic, as an orbit is sought with them.
    ///
    /// # Errors
    /// Those of the actuator's file.
    pub fn actuation(&self) -> Result<Actuation, ActuatorFileError> {
        let set = self.set()?;
        Ok(Actuation {
            lags: Lags::of(TICK, set.cycle()),
            set,
            logic: self.demand(0.0).logic,
            position_loop: self.position_loop,
        })
    }

    /// What the motion is. The dive goes on to 1000 s for that, and what was watched becomes its second half.
    ///
    /// # Errors
    /// Those of the actuator's file.
    pub fn motion(&self, dive: &mut Dive) -> Result<Motion, ActuatorFileError> {
        self.settle(dive);
        Ok(dive.watched.motion(&self.actuation()?))
    }

    fn settle(&self, dive: &mut Dive) {
        if dive.flight.tick < SETTLED {
            dive.watched = dive.flight.watch(SETTLED, &|_| self.demand(0.0));
        }
    }

    /// The dives from places of the ram, in quanta, and what their motions are. An orbit that is found from one of them is known to all.
    ///
    /// # Errors
    /// As of [`Case::run`].
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

    /// Whether another configuration is of the same actuator and logic, in another vehicle or control law.
    #[must_use]
    pub fn same_actuator(&self, other: &Self) -> bool {
        let actuator = |case: &Self| (case.logic, case.position_loop, case.leakage, case.friction);
        self.actuator == other.actuator && actuator(self) == actuator(other)
    }

    /// The cycle that [`Loop::predict`] finds for the case; `known` is what was measured of the same actuator before.
    ///
    /// # Errors
    /// Those of the actuator's file.
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
    /// Dives by 3 ft with an actuator whose ram rests at `ram`, m, at first, and observes from 250 to 500 s; `demand` is the
    /// demand on the actuator but for the angle, by the time in s.
    ///
    /// # Errors
    /// A limit that is none, which the controller's defaults exclude.
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

    /// The cycle that harmonic balance predicts, as of [`DepthLoop::predict`].
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
