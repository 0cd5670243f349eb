//! The model of the planes' actuator: the digital hydraulic actuator, or a simpler model for comparison.

use planesman_circuit as circuit;

use crate::actuator_set::ActuatorFile;

use crate::dha::{Demand, Dha};
use crate::energy::Energy;
use crate::first_order::{FirstOrder, Lag};
use crate::hydraulics::Reading;

/// Largest error of one integration step of a circuit, relative to each quantity's scale.
const ACCURACY: f64 = 1e-8;

/// Seed of the scatter of a circuit's valve times.
const SEED: u64 = 1;

/// Choice of the actuator model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Model {
    /// The digital hydraulic actuator.
    Dha,
    /// A lag of first order with a rate limit.
    FirstOrder,
    /// Planes without delay.
    Ideal,
}

/// The demand on an actuator, for every model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Request {
    /// The commanded angle, and the settings of the digital actuator.
    pub demand: Demand,
    /// The force on the ram of a circuit, against positive motion, N.
    pub load_force: f64,
    /// Parameters of the first-order model.
    pub lag: Lag,
}

/// State of an actuator of any model. A clone behaves identically from then on.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // a few live in a node, and they are copied, not boxed
pub(crate) enum ActuatorModel {
    /// The digital hydraulic actuator of metered volumes.
    Dha(Dha),
    /// An actuator of parallel on/off valves, and its moment arm, m.
    Circuit(Box<circuit::Actuator>, f64),
    /// A lag of first order with a rate limit.
    FirstOrder(FirstOrder),
    /// Planes without delay: their angle, rad.
    Ideal(f64),
}

/// State of the planes and their actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Planes {
    /// Plane angle, rad.
    pub angle: f64,
    /// Plane rate, rad/s.
    pub rate: f64,
    /// Reading of the metering hydraulics; `None` for other actuators.
    pub reading: Option<Reading>,
    /// State of a circuit of on/off valves; `None` for other actuators.
    pub chambers: Option<Chambers>,
}

/// State of a circuit of on/off valves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chambers {
    /// p_A and p_B, gauge, Pa; p_B is 0 if there is no chamber B.
    pub pressures: [f64; 2],
    /// The ram moves.
    pub sliding: bool,
    /// The ram lies on a stop.
    pub at_stop: bool,
    /// Net volume taken from the supply levels, m^3.
    pub volume: f64,
    /// Commanded switchings since the start.
    pub switchings: u64,
}

impl Chambers {
    fn of(actuator: &circuit::Actuator, nanos: i64, pressures: [f64; 2]) -> Self {
        let simulation = actuator.simulation();
        // A single-acting cylinder has no pressure on its other side.
        let [a, b] = pressures;
        let b = if simulation.circuit().chambers[1].area > 0.0 {
            b
        } else {
            0.0
        };
        Self {
            pressures: [a, b],
            sliding: matches!(simulation.mode(), circuit::Mode::Sliding(_)),
            at_stop: simulation.at_stop(),
            volume: actuator.volume_and_proportional(nanos)[0],
            switchings: simulation.total_switchings(),
        }
    }
}

impl ActuatorModel {
    /// Returns an actuator at rest with neutral planes.
    #[must_use]
    pub(crate) fn new(model: Model, file: &ActuatorFile, lag: Lag) -> Self {
        match model {
            Model::Dha => match file {
                ActuatorFile::Metering(set) => Self::Dha(Dha::new(set).keeping_energy()),
                ActuatorFile::Circuit(circuit) => {
                    let actuator = circuit::Actuator::new(circuit, ACCURACY, 0.0, 0.0, SEED);
                    Self::Circuit(Box::new(actuator), circuit.load.moment_arm)
                }
            },
            Model::FirstOrder => Self::FirstOrder(FirstOrder::new(lag)),
            Model::Ideal => Self::Ideal(0.0),
        }
    }

    /// Applies a demand at the instant `nanos`, up to which the actuator must have been advanced. The ideal and the first-order model
    /// follow at once, the digital actuator from its next valve cycle; a circuit's load force changes at once.
    pub(crate) fn ask(&mut self, nanos: i64, request: &Request) {
        match self {
            Self::Ideal(angle) => *angle = request.demand.angle,
            Self::Circuit(actuator, _) => actuator.push(nanos, request.load_force),
            Self::Dha(_) | Self::FirstOrder(_) => {}
        }
    }

    /// Runs to the instant `nanos` after the start under `request`.
    pub(crate) fn advance_to(&mut self, nanos: i64, request: &Request) {
        match self {
            Self::Dha(dha) => dha.advance_to(nanos, request.demand),
            Self::Circuit(actuator, arm) => {
                let travel = actuator.simulation().circuit().load.travel;
                let position = (request.demand.angle * *arm).clamp(-travel, travel);
                let reference = circuit::Reference {
                    position,
                    speed: 0.0,
                };
                let force = circuit::Force {
                    begin: request.load_force,
                    rate: 0.0,
                };
                actuator.advance_to(nanos, circuit::Demand { reference, force });
            }
            Self::FirstOrder(servo) => servo.advance_to(nanos, request.demand.angle, request.lag),
            Self::Ideal(angle) => *angle = request.demand.angle,
        }
    }

    /// Returns the field of the actuator's file that prevented a solution of the motion; `None` if it was solved.
    #[must_use]
    pub(crate) fn unsolved(&self) -> Option<String> {
        match self {
            Self::Dha(dha) => dha.hydraulics().unsolved().map(str::to_owned),
            Self::Circuit(actuator, _) => {
                let simulation = actuator.simulation();
                (simulation.unsolved()).then(|| simulation.circuit().fastest_field())
            }
            Self::FirstOrder(_) | Self::Ideal(_) => None,
        }
    }

    /// Energies since the start. For a circuit, the energies at `nanos`; for metered volumes, the energies at the last change of flow or law. `None`
    /// for an actuator without hydraulics.
    #[must_use]
    pub(crate) fn energy(&self, nanos: i64) -> Option<Energy> {
        match self {
            Self::Dha(dha) => dha.energy(),
            Self::Circuit(actuator, _) => Some(Energy::of_circuit(
                &actuator.ledger(nanos),
                actuator.volume_and_proportional(nanos)[1],
            )),
            Self::FirstOrder(_) | Self::Ideal(_) => None,
        }
    }

    /// Appends the plane angle, rad, at `nanos`, up to which the actuator has been advanced. Appends also the angles known for later times,
    /// `interval` s apart; at most `count` values in total.
    pub(crate) fn sample(&self, nanos: i64, interval: f64, count: usize, angles: &mut Vec<f64>) {
        match self {
            Self::Dha(dha) => dha.sample(nanos, interval, count, angles),
            Self::Circuit(..) | Self::FirstOrder(_) | Self::Ideal(_) => {
                angles.push(self.planes(nanos).angle);
            }
        }
    }

    /// State of the planes at `nanos`, up to which the actuator has been advanced.
    #[must_use]
    pub(crate) fn planes(&self, nanos: i64) -> Planes {
        let bare = |angle, rate| Planes {
            angle,
            rate,
            reading: None,
            chambers: None,
        };
        match self {
            Self::Dha(dha) => {
                let reading = dha.reading(nanos);
                Planes {
                    reading: Some(reading),
                    ..bare(dha.plane_angle(&reading), dha.plane_rate(&reading))
                }
            }
            Self::Circuit(actuator, arm) => {
                let [x, v, a, b] = actuator.at(nanos);
                Planes {
                    chambers: Some(Chambers::of(actuator, nanos, [a, b])),
                    ..bare(x / arm, v / arm)
                }
            }
            Self::FirstOrder(servo) => {
                let (angle, rate) = servo.at(nanos);
                bare(angle, rate)
            }
            Self::Ideal(angle) => bare(*angle, 0.0),
        }
    }
}
