//! The subject of a design: a vehicle, its gains and its actuator, from the command line.

use anyhow::{Context as _, Result, anyhow};
use brunner_1988::controllers::pitch;
use clap::{Args, ValueEnum};
use depth_controller::ControllerParameters;
use depth_controller::design::dive_loop::{DiveLoop, DivePlant, Path};
use depth_controller::gains::LoopGains;
use dha_actuator::ActuatorParameters;
use planesman_linear::{Complex, DMatrix, StateSpace, pair_text};
use planesman_units::FOOT;
use planesman_vehicle::Vehicle;
use planesman_vehicle::linearised;
use planesman_vehicle::vehicle_file;

use crate::arguments::within;

/// The report's vehicle in pitch alone (Table 3): it goes where it points, and its planes' moment does not know
/// the speed.
pub const TABLE_3: &str = "table_3";

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
    /// actuator or actuator file for its dead time in small motion
    #[arg(long, default_value = "auv")]
    pub actuator: String,
    /// Sampling rate of the zero-order hold (Hz); 0: continuous
    #[arg(long, default_value_t = 20.0, value_parser = within(0.0, 1e4))]
    pub rate: f64,
}

/// The gains of the depth and pitch loops, the controller's defaults where not given.
#[derive(Args, Clone)]
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

impl Subject {
    /// The vehicle, where it is not [`TABLE_3`].
    ///
    /// # Errors
    /// A vehicle that is refused.
    pub fn loaded(&self) -> Result<Vehicle> {
        Ok(vehicle_file::load_on(&self.vehicle, &self.base)?)
    }

    /// The vehicle about level flight at a speed, m/s.
    ///
    /// # Errors
    /// A vehicle that is refused, or numbers that overflow.
    pub fn plant(&self, speed: f64) -> Result<DivePlant> {
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

    /// The path from the control law to the planes: the hold of a sampled command, half a sample late, and
    /// of a digital hydraulic actuator the dead time from an error to the middle of the flow that answers it.
    ///
    /// # Errors
    /// An actuator that is refused.
    pub fn path(&self) -> Result<Path> {
        let hold = if self.rate > 0.0 {
            0.5 / self.rate
        } else {
            0.0
        };
        let (lag, delay) = match self.actuator.as_str() {
            "ideal" => (0.0, 0.0),
            "first_order" => (1.0 / ActuatorParameters::default().first_order.omega, 0.0),
            name => {
                let set = dha_actuator::actuator_file::load(name).map_err(|e| anyhow!("{e}"))?;
                (0.0, dha_actuator::linearised::dead_time(&set))
            }
        };
        Ok(Path {
            lag,
            delay: hold + delay,
        })
    }

    /// The loop with these gains at a speed, m/s.
    ///
    /// # Errors
    /// As [`Subject::plant`] and [`Subject::path`].
    pub fn dive_loop(&self, gains: LoopGains, speed: f64) -> Result<DiveLoop> {
        Ok(DiveLoop {
            plant: self.plant(speed)?,
            gains,
            path: self.path()?,
        })
    }
}

/// A speed in both units.
#[must_use]
pub fn speed_text(speed: f64) -> String {
    format!("{speed:.4} m/s ({:.3} ft/s)", speed / FOOT)
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

/// Poles in the order given, each pair once.
#[must_use]
pub fn poles_text(poles: &[Complex<f64>]) -> String {
    let once = poles.iter().filter(|pole| pole.im >= 0.0);
    once.map(pole_text).collect::<Vec<_>>().join("  ")
}
