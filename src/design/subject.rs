//! The subject of a design: a vehicle, its gains and its actuator, from the command line.

use anyhow::{Context as _, Result, anyhow, bail};
use brunner_1988::controllers::pitch;
use clap::{Args, ValueEnum};
use planesman_control::ControllerParameters;
use planesman_control::design::dive_loop::{DiveLoop, DivePlant, Memory, Path};
use planesman_control::gains::LoopGains;
use planesman_hydraulics::ActuatorParameters;
use planesman_hydraulics::linearised as actuator_model;
use planesman_linear::sampled::AT_ONCE;
use planesman_linear::{Complex, DMatrix, StateSpace, pair_text};
use planesman_units::FOOT;
use planesman_vehicle::Vehicle;
use planesman_vehicle::linearised;
use planesman_vehicle::vehicle_file;

use crate::arguments::within;

/// The report's vehicle in pitch alone (Table 3): it goes where it points, and its planes' moment does not know
/// the speed.
pub const TABLE_3: &str = "table_3";

/// The defaults of `--actuator` and `--rate`: those of a dive.
const AUV: &str = "auv";
const RATE: f64 = 20.0;

/// The most ticks over which a command moves the planes: each is a state of the sampled loop.
const MOST_TICKS: f64 = 400.0;

/// A vehicle behind an actuator.
#[derive(Args, Clone)]
#[command(next_help_heading = "Vehicle and actuator")]
pub struct Subject {
    /// A built-in vehicle, a vehicle file, a model file, or table_3: the report's damped inertia, with the same
    /// plane moment at every speed
    #[arg(default_value = vehicle_file::BRUNNER)]
    pub vehicle: String,
    /// Base vehicle of an identified model: gives all but the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    pub base: String,
    /// What moves the planes: ideal, first_order with the bandwidth of dha_actuator's default, or a built-in
    /// actuator or actuator file for its motion at the slew rate
    #[arg(long, default_value = AUV)]
    pub actuator: String,
    /// Ticks of the controller per second (Hz); 0: the continuous loop alone
    #[arg(long, default_value_t = RATE, value_parser = within(0.0, 1e4))]
    pub rate: f64,
    /// Delay from a state to the command that answers it (s): 0 in lockstep and in sim
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 10.0))]
    pub computing_delay: f64,
}

/// As declared above.
impl Default for Subject {
    fn default() -> Self {
        Self {
            vehicle: vehicle_file::BRUNNER.to_owned(),
            base: vehicle_file::BRUNNER.to_owned(),
            actuator: AUV.to_owned(),
            rate: RATE,
            computing_delay: 0.0,
        }
    }
}

/// What is between a command and the planes.
pub struct Drive {
    /// In the continuous loop.
    pub path: Path,
    /// In the sampled loop; `None` for `--rate 0`.
    pub sampling: Option<Sampling>,
}

/// The command at the ticks, and the planes that follow it.
pub struct Sampling {
    /// s
    pub tick: f64,
    /// As [`planesman_linear::Sampled::new`] takes it.
    pub motion: Vec<(f64, f64)>,
    /// The conditions of this motion, a sentence a line; empty where there are none.
    pub note: String,
}

/// The gains of the depth and pitch loops, the controller's defaults where not given.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = "Gains")]
pub struct GainArgs {
    /// Kpz, dive angle per depth error (rad/m) [default: depth_controller's depth.p]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pub depth_p: Option<f64>,
    /// Kdz, dive angle per depth rate (rad s/m) [default: its depth.d]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pub depth_d: Option<f64>,
    /// Kpy, plane angle per pitch error [default: its pitch.p]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pub pitch_p: Option<f64>,
    /// Kr, plane angle per pitch rate (s) [default: its pitch.rate]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pub pitch_rate: Option<f64>,
    /// Kiz, dive angle per depth error and second (rad/(m s))
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    pub depth_i: f64,
    /// Kiy, plane angle per pitch error and second (1/s)
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    pub pitch_i: f64,
    /// Time constant of the filter of the depth loop's derivative (s)
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    pub derivative_filter: f64,
}

/// One of the gains, or the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Varied {
    /// Kpz (rad/m)
    DepthP,
    /// Kdz (rad s/m)
    DepthD,
    /// Kpy
    PitchP,
    /// Kr (s)
    PitchRate,
    /// U (m/s)
    Speed,
}

/// The depth controller's default gains: those of program T6.
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

impl GainArgs {
    /// The gains, and the controller's declared defaults for the rest.
    #[must_use]
    pub fn gains(&self) -> LoopGains {
        let default = default_gains();
        LoopGains {
            depth_p: self.depth_p.unwrap_or(default.depth_p),
            depth_d: self.depth_d.unwrap_or(default.depth_d),
            pitch_p: self.pitch_p.unwrap_or(default.pitch_p),
            pitch_rate: self.pitch_rate.unwrap_or(default.pitch_rate),
        }
    }
}

impl GainArgs {
    /// Integrals and filter.
    #[must_use]
    pub fn memory(&self) -> Memory {
        Memory {
            depth_i: self.depth_i,
            pitch_i: self.pitch_i,
            derivative_filter: self.derivative_filter,
        }
    }
}

impl Subject {
    /// The vehicle, where it is not [`TABLE_3`].
    ///
    /// # Errors
    /// A vehicle that is refused.
    pub fn loaded(&self) -> Result<Vehicle> {
        Ok(vehicle_file::load_on(&self.vehicle, &self.base)?)
    }

    /// The vehicle about level flight at a speed, m/s, behind the drive.
    ///
    /// # Errors
    /// A vehicle that is refused, or numbers that overflow.
    pub fn plant(&self, drive: &Drive, speed: f64) -> Result<DivePlant> {
        let plant = self.continuous_plant(speed)?;
        match &drive.sampling {
            Some(Sampling { tick, motion, .. }) => {
                Ok(plant.sampled(drive.path.lag, motion, *tick)?)
            }
            None => Ok(plant),
        }
    }

    fn continuous_plant(&self, speed: f64) -> Result<DivePlant> {
        if self.vehicle == TABLE_3 {
            return Ok(DivePlant::of_pitch(&pitch::model(), speed)?);
        }
        let vehicle = self.loaded()?;
        let StateSpace { a, b, .. } = linearised::state_space(&vehicle, speed)
            .with_context(|| format!("vehicle '{}' at {speed} m/s", vehicle.name))?;
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

    /// The way from the control law to the planes. In the sampled loop it is the command's hold over the tick and the actuator's own motion;
    /// in the continuous one the hold is half a tick of dead time, and a digital hydraulic actuator the dead time from an error to
    /// the middle of the flow that answers it.
    ///
    /// # Errors
    /// An actuator that is refused, or that does not follow a command as large as its slew rate allows.
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
                    "Holds while the planes move by less than their rate limit, {:.0} deg/s.",
                    law.rate.to_degrees()
                );
            }
            name => {
                let set =
                    planesman_hydraulics::actuator_file::load(name).map_err(|e| anyhow!("{e}"))?;
                delay = actuator_model::dead_time(&set);
                if let Some(tick) = tick {
                    motion = actuator_model::slew_response(&set, tick).with_context(|| {
                        format!("actuator '{name}' does not follow a step of its command")
                    })?;
                    let volumes = actuator_model::volumes_in_a_tick(&set, tick);
                    let quantum = set.plane_quantum().to_degrees();
                    note = format!(
                        "Holds for commands that change by about {:.1} deg from tick to tick, {volumes} volumes of {quantum:.2} deg.\n\
                         Smaller ones end in a limit cycle of a quantum or two, larger ones exceed the slew rate.",
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
            bail!(
                "the planes follow a command within {ticks:.0} ticks, and at most {MOST_TICKS} are analysed: choose a lower --rate or \
                 --computing-delay"
            );
        }
        Ok(Drive {
            path: Path {
                lag,
                delay: delay + self.computing_delay + tick.map_or(0.0, |tick| 0.5 * tick),
            },
            sampling: tick.map(|tick| Sampling { tick, motion, note }),
        })
    }

    /// The loop with these gains at a speed, m/s.
    ///
    /// # Errors
    /// As [`Subject::plant`].
    pub fn dive_loop(
        &self,
        drive: &Drive,
        (gains, memory): (LoopGains, Memory),
        speed: f64,
    ) -> Result<DiveLoop> {
        Ok(DiveLoop {
            plant: self.plant(drive, speed)?,
            gains,
            memory,
            path: drive.path,
        })
    }

    /// Vehicle, actuator and sampling in a line.
    #[must_use]
    pub fn title(&self) -> String {
        let (vehicle, actuator) = (&self.vehicle, &self.actuator);
        match self.rate > 0.0 {
            true => format!("{vehicle} behind {actuator}, sampled at {} Hz", self.rate),
            false => format!("{vehicle} behind {actuator}, continuous"),
        }
    }
}

/// A speed in both units.
#[must_use]
pub fn speed_text(speed: f64) -> String {
    format!("{speed:.4} m/s ({:.3} ft/s)", speed / FOOT)
}

/// Gains in SI, those of the depth loop in the report's feet too; integrals and filter where there are any.
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

/// Gains in SI, and those of the depth loop in the report's feet.
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

/// A pole; of a conjugate pair both at once.
#[must_use]
pub fn pole_text(pole: &Complex<f64>) -> String {
    if pole.im == 0.0 {
        pair_text(*pole, 4)
    } else {
        let ratio = -pole.re / pole.norm();
        format!("{} (zeta {ratio:.3})", pair_text(*pole, 4))
    }
}

/// Poles in `s` in the order given, each pair once.
#[must_use]
pub fn poles_text(poles: &[Complex<f64>]) -> String {
    once(poles, pole_text)
}

/// Poles in `z`, likewise.
#[must_use]
pub fn discrete_poles_text(poles: &[Complex<f64>]) -> String {
    once(poles, |pole| pair_text(*pole, 5))
}

fn once(poles: &[Complex<f64>], text: impl Fn(&Complex<f64>) -> String) -> String {
    let once = poles.iter().filter(|pole| pole.im >= 0.0);
    once.map(text).collect::<Vec<_>>().join("  ")
}
