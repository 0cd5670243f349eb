//! The subject of a design: a vehicle with its actuator, and the control law around them.

use planesman_control::ControllerParameters;
use planesman_control::design::dive_loop::{DiveLoop, DivePlant, Memory, Path};
use planesman_control::gains::{LoopGains, PitchModel};
use planesman_flight::During as _;
use planesman_hydraulics::linearised as actuator_model;
use planesman_hydraulics::{ActuatorParameters, actuator_file};
use planesman_linear::sampled::AT_ONCE;
use planesman_linear::{Complex, ComplexFunctions as _, DMatrix, StateSpace, pair_text};
use planesman_units::FOOT;
use planesman_vehicle::Vehicle;
use planesman_vehicle::linearised;
use planesman_vehicle::pitch::without_heave;
use planesman_vehicle::vehicle_file;

use crate::design::error::{Error, Result};

/// Default actuator.
pub const ACTUATOR: &str = "auv";
/// Default tick rate, Hz.
pub const RATE: f64 = 20.0;

/// Largest number of ticks over which a command may move the planes: each is a state of the sampled loop.
const MOST_TICKS: f64 = 400.0;

/// Brunner's vehicle without heave (NPS thesis, 1988, Table 3): J = 0.6 ft lbf s^2, By = 0.06 ft lbf s, Ky = 0.14 ft lbf/rad, with the same plane
/// moment at every speed; `Ky` has the sign of program T6.
pub const TABLE_3: PitchModel = PitchModel {
    plane: 0.14 / 0.6,
    damping: 0.06 / 0.6,
    restoring: 0.0,
};

/// The body that the planes move.
#[derive(Clone, Debug)]
pub enum Body {
    /// A built-in vehicle, a vehicle file or a model file.
    Vehicle {
        /// Name or path of the vehicle.
        name: String,
        /// The base vehicle of an identified model, which supplies everything except the pitch dynamics.
        base: String,
    },
    /// A loaded vehicle.
    Given {
        /// Name in texts.
        name: String,
        /// The vehicle.
        vehicle: Box<Vehicle>,
    },
    /// A damped inertia in pitch only: its path follows its pitch, and the plane moment does not depend on the speed.
    Pitch {
        /// Name in texts.
        name: &'static str,
        /// Its coefficients.
        model: PitchModel,
    },
}

/// A vehicle with its actuator.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The body.
    pub body: Body,
    /// The actuator that moves the planes: `ideal`, `first_order` (with the bandwidth of `dha_actuator`'s default), or a built-in actuator or actuator
    /// file (its motion at the slew rate).
    pub actuator: String,
    /// Controller rate (ticks per second, Hz); with 0 only the continuous loop is analysed.
    pub rate: f64,
    /// Delay from a measured state to the command computed from this state, s: 0 in lockstep and in `sim`.
    pub computing_delay: f64,
}

/// The default vehicle and actuator of `planesman dive`.
impl Default for Subject {
    fn default() -> Self {
        Self {
            body: Body::vehicle(vehicle_file::BRUNNER),
            actuator: ACTUATOR.to_owned(),
            rate: RATE,
            computing_delay: 0.0,
        }
    }
}

/// The control law: gains of the depth and pitch loops; integral gains and filter.
pub type Law = (LoopGains, Memory);

/// Dynamics between a command and the planes.
pub struct Drive {
    /// The dynamics for the continuous loop.
    pub path: Path,
    /// The dynamics for the sampled loop; `None` for `--rate 0`.
    pub sampling: Option<Sampling>,
}

/// Sampling of the command, and the planes' motion that follows it.
pub struct Sampling {
    /// Sampling interval, s.
    pub tick: f64,
    /// The planes' motion, in the form of [`planesman_linear::Sampled::new`].
    pub motion: Vec<(f64, f64)>,
    /// The conditions under which this motion is valid, one sentence per line; may be empty.
    pub note: String,
}

/// The depth controller's default gains, which are those of program T6.
#[must_use]
pub fn default_gains() -> LoopGains {
    let ControllerParameters { depth, pitch, .. } = ControllerParameters::default();
    LoopGains {
        depth_p: depth.p,
        depth_d: depth.d,
        pitch_p: pitch.p,
        pitch_rate: pitch.rate,
    }
}

impl Body {
    /// The subject with a vehicle given by name or file.
    #[must_use]
    pub fn vehicle(name: &str) -> Self {
        Self::Vehicle {
            name: name.to_owned(),
            base: vehicle_file::BRUNNER.to_owned(),
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Vehicle { name, .. } | Self::Given { name, .. } => name,
            Self::Pitch { name, .. } => name,
        }
    }

    /// The pitch dynamics at a speed, m/s, in the form that the pole-placement formula needs.
    ///
    /// # Errors
    /// A refused vehicle.
    pub fn pitch_model(&self, speed: f64) -> Result<PitchModel> {
        match self {
            Self::Pitch { model, .. } => Ok(*model),
            Self::Vehicle { .. } | Self::Given { .. } => {
                let vehicle = self.loaded()?;
                let [kappa, damping, restoring] = without_heave(&vehicle.derivatives(speed));
                Ok(PitchModel {
                    plane: -kappa,
                    damping,
                    restoring,
                })
            }
        }
    }

    /// The vehicle with its coefficients. A body in pitch only has no heave; its name is refused like that of a missing file.
    fn loaded(&self) -> Result<Vehicle> {
        match self {
            Self::Vehicle { name, base } => Ok(vehicle_file::load_on(name, base)?),
            Self::Given { vehicle, .. } => Ok((**vehicle).clone()),
            Self::Pitch { name, .. } => Ok(vehicle_file::load(name)?),
        }
    }

    /// The plant for level flight at a speed, m/s.
    fn plant(&self, speed: f64) -> Result<DivePlant> {
        if let Self::Pitch { model, .. } = self {
            return Ok(DivePlant::of_pitch(model, speed)?);
        }
        let vehicle = self.loaded()?;
        let StateSpace { a, b, .. } = linearised::state_space(&vehicle, speed)
            .during(|| format!("vehicle '{}' at {speed} m/s", vehicle.name))?;
        // x = (w, q, theta, z); out: q, theta, z, z' = w - U theta.
        #[rustfmt::skip]
        let c = [
            0.0, 1.0, 0.0,    0.0,
            0.0, 0.0, 1.0,    0.0,
            0.0, 0.0, 0.0,    1.0,
            1.0, 0.0, -speed, 0.0,
        ];
        let seen = StateSpace::new(
            a,
            b,
            DMatrix::from_row_slice(4, 4, &c),
            DMatrix::zeros(4, 1),
        )?;
        Ok(DivePlant::new(seen)?)
    }
}

impl Subject {
    /// The vehicle in level flight at a speed, m/s, driven through the actuator.
    ///
    /// # Errors
    /// A refused vehicle, or numerical overflow.
    pub fn plant(&self, drive: &Drive, speed: f64) -> Result<DivePlant> {
        let plant = self.body.plant(speed)?;
        match &drive.sampling {
            Some(Sampling { tick, motion, .. }) => {
                Ok(plant.sampled(drive.path.lag, motion, *tick)?)
            }
            None => Ok(plant),
        }
    }

    /// The dynamics from the control law to the planes. In the sampled loop: the hold of the command over the tick, and the actuator's own motion.
    /// In the continuous loop: half a tick of dead time for the hold; for a digital hydraulic actuator also the dead time from an error to the
    /// middle of the flow that corrects it.
    ///
    /// # Errors
    /// A refused actuator, or one that cannot follow a command as large as its slew rate allows.
    pub fn drive(&self) -> Result<Drive> {
        let tick = (self.rate > 0.0).then(|| 1.0 / self.rate);
        let mut motion = AT_ONCE.to_vec();
        let (mut lag, mut delay, mut note) = (0.0, 0.0, String::new());
        match self.actuator.as_str() {
            "ideal" => {}
            "first_order" => {
                let law = ActuatorParameters::default().first_order;
                lag = 1.0 / law.omega;
                note = format!(
                    "Valid while the planes move more slowly than their rate limit, {:.0} deg/s.",
                    law.rate.to_degrees()
                );
            }
            name => {
                let set = actuator_file::load(name)?;
                delay = actuator_model::dead_time(&set);
                if let Some(tick) = tick {
                    motion = actuator_model::slew_response(&set, tick)
                        .ok_or_else(|| Error::NoStep(name.to_owned()))?;
                    let volumes = actuator_model::volumes_in_a_tick(&set, tick);
                    let quantum = set.plane_quantum().to_degrees();
                    note = format!(
                        "Valid for commands that change by about {:.1} deg per tick, which is {volumes} volumes of {quantum:.2} deg.\n\
                         Smaller changes end in a limit cycle of one or two quanta; larger changes exceed the slew rate.",
                        f64::from(volumes) * quantum
                    );
                }
            }
        }
        for (time, _) in &mut motion {
            *time += self.computing_delay;
        }
        let last = motion.last().map_or(0.0, |knot| knot.0);
        if let Some(ticks) = tick.map(|tick| last / tick).filter(|it| *it > MOST_TICKS) {
            return Err(Error::Ticks {
                needed: ticks,
                most: MOST_TICKS,
            });
        }
        Ok(Drive {
            path: Path {
                lag,
                delay: delay + self.computing_delay + tick.map_or(0.0, |tick| 0.5 * tick),
            },
            sampling: tick.map(|tick| Sampling { tick, motion, note }),
        })
    }

    /// The closed loop with these gains at a speed, m/s.
    ///
    /// # Errors
    /// Same as [`Subject::plant`].
    pub fn dive_loop(&self, drive: &Drive, (gains, memory): Law, speed: f64) -> Result<DiveLoop> {
        Ok(DiveLoop {
            plant: self.plant(drive, speed)?,
            gains,
            memory,
            path: drive.path,
        })
    }

    /// Vehicle, actuator and sampling in one line.
    #[must_use]
    pub fn title(&self) -> String {
        let (vehicle, actuator) = (self.body.name(), &self.actuator);
        match self.rate > 0.0 {
            true => format!(
                "{vehicle} with actuator {actuator}, sampled at {} Hz",
                self.rate
            ),
            false => format!("{vehicle} with actuator {actuator}, continuous"),
        }
    }
}

/// A speed in m/s and ft/s.
#[must_use]
pub fn speed_text(speed: f64) -> String {
    format!("{speed:.4} m/s ({:.3} ft/s)", speed / FOOT)
}

/// Gains in SI; the gains of the depth loop also in feet, as in the report; integral gains and filter only if they are not 0.
#[must_use]
pub fn law_text(gains: &LoopGains, memory: &Memory) -> String {
    let mut text = gains_text(gains);
    for (name, value, unit) in [
        ("Kiz", memory.depth_i, "rad/(m s)"),
        ("Kiy", memory.pitch_i, "1/s"),
        ("derivative filter", memory.derivative_filter, "s"),
    ] {
        if value != 0.0 {
            text += &format!(", {name} {value:.4} {unit}");
        }
    }
    text
}

/// Gains in SI; the gains of the depth loop also in feet, as in the report.
#[must_use]
pub fn gains_text(g: &LoopGains) -> String {
    format!(
        "Kpz {:.4} rad/m ({:.4} rad/ft), Kdz {:.4} rad s/m ({:.4} rad s/ft), Kpy {:.4}, Kr {:.4} s",
        g.depth_p,
        g.depth_p * FOOT,
        g.depth_d,
        g.depth_d * FOOT,
        g.pitch_p,
        g.pitch_rate
    )
}

/// A pole as text; a conjugate pair is written once.
fn pole_text(pole: &Complex<f64>) -> String {
    if pole.im == 0.0 {
        pair_text(*pole, 4)
    } else {
        let ratio = -pole.re / pole.modulus();
        format!("{} (zeta {ratio:.3})", pair_text(*pole, 4))
    }
}

/// Poles in `s` in the given order, each pair once.
pub(crate) fn poles_text(poles: &[Complex<f64>]) -> String {
    once(poles, pole_text)
}

/// Poles in `z`, each pair once.
pub(crate) fn discrete_poles_text(poles: &[Complex<f64>]) -> String {
    once(poles, |pole| pair_text(*pole, 5))
}

fn once(poles: &[Complex<f64>], text: impl Fn(&Complex<f64>) -> String) -> String {
    let once = poles.iter().filter(|pole| pole.im >= 0.0);
    once.map(text).collect::<Vec<_>>().join("  ")
}
