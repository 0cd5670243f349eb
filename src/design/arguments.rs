//! Arguments shared by the commands of `planesman design`.

use clap::Args;
use planesman_control::design::dive_loop::Memory;
use planesman_control::gains::LoopGains;
use planesman_show::design::{ACTUATOR, Body, Law, RATE, Subject, TABLE_3, default_gains};
use planesman_vehicle::vehicle_file;

use crate::arguments::within;

/// The name of [`TABLE_3`].
const IN_PITCH_ALONE: &str = "table_3";

/// A vehicle and the actuator that moves its planes.
#[derive(Args, Clone)]
#[command(next_help_heading = "Vehicle and actuator")]
pub(super) struct SubjectArgs {
    /// A built-in vehicle, a vehicle file, a model file, or table_3 (the report's damped inertia, with the same plane moment at every speed)
    #[arg(default_value = vehicle_file::BRUNNER)]
    vehicle: String,
    /// Base vehicle of an identified model: supplies everything except the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Actuator of the planes: ideal, first_order (with the bandwidth of dha_actuator's default), or a built-in actuator or actuator file (its
    /// motion at the slew rate)
    #[arg(long, default_value = ACTUATOR)]
    actuator: String,
    /// Controller rate (ticks per second, Hz); 0: only the continuous loop
    #[arg(long, default_value_t = RATE, value_parser = within(0.0, 1e4))]
    rate: f64,
    /// Delay from a measured state to the command computed from that state (s); 0 in lockstep and in sim
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 10.0))]
    computing_delay: f64,
}

impl SubjectArgs {
    pub(super) fn subject(&self) -> Subject {
        Subject {
            body: match self.vehicle.as_str() {
                IN_PITCH_ALONE => Body::Pitch {
                    name: IN_PITCH_ALONE,
                    model: TABLE_3,
                },
                name => Body::Vehicle {
                    name: name.to_owned(),
                    base: self.base.clone(),
                },
            },
            actuator: self.actuator.clone(),
            rate: self.rate,
            computing_delay: self.computing_delay,
        }
    }
}

/// The gains of the depth and pitch loops; gains that are not given have the controller's defaults.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = "Gains")]
pub(super) struct GainArgs {
    /// Kpz, pitch command per depth error (rad/m) [default: depth_controller's depth.p]
    #[arg(long, value_parser = within(0.0, 1e3))]
    depth_p: Option<f64>,
    /// Kdz, pitch command per depth rate (rad s/m) [default: depth_controller's depth.d]
    #[arg(long, value_parser = within(0.0, 1e3))]
    depth_d: Option<f64>,
    /// Kpy, plane angle per pitch error [default: depth_controller's pitch.p]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pitch_p: Option<f64>,
    /// Kr, plane angle per pitch rate (s) [default: depth_controller's pitch.rate]
    #[arg(long, value_parser = within(0.0, 1e3))]
    pitch_rate: Option<f64>,
    /// Kiz, pitch command per depth error and second (rad/(m s))
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    depth_i: f64,
    /// Kiy, plane angle per pitch error and second (1/s)
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    pitch_i: f64,
    /// Time constant of the derivative filter of the depth loop (s)
    #[arg(long, default_value_t = 0.0, value_parser = within(0.0, 1e3))]
    derivative_filter: f64,
}

impl GainArgs {
    /// The control law; gains not given are the controller's declared defaults.
    pub(super) fn law(&self) -> Law {
        let default = default_gains();
        let gains = LoopGains {
            depth_p: self.depth_p.unwrap_or(default.depth_p),
            depth_d: self.depth_d.unwrap_or(default.depth_d),
            pitch_p: self.pitch_p.unwrap_or(default.pitch_p),
            pitch_rate: self.pitch_rate.unwrap_or(default.pitch_rate),
        };
        let memory = Memory {
            depth_i: self.depth_i,
            pitch_i: self.pitch_i,
            derivative_filter: self.derivative_filter,
        };
        (gains, memory)
    }
}

/// The gains as options of `planesman dive`.
pub(super) fn set_gains(gains: &LoopGains) -> String {
    [
        ("depth.p", gains.depth_p),
        ("depth.d", gains.depth_d),
        ("pitch.p", gains.pitch_p),
        ("pitch.rate", gains.pitch_rate),
    ]
    .map(|(name, value)| format!(" --set depth_controller.{name}={value:.4}"))
    .concat()
}
