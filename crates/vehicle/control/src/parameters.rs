//! The controller's parameters, with their defaults and ranges, which are defined only here.
//!
//! The gains are those of program T6 (Brunner, NPS thesis, 1988, App. C): Kpz = 0.25 rad/ft,
//! Kdz = 0.6 rad·s/ft, Kpy = 0.70, Kr = 2 s; the limits those of its ch. II.B. With these defaults the
//! dive loops are the report's: no integral, no filter, no rate limits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, TAU};

use planesman_parameters::{Choice, Parameters};
use planesman_units::FOOT;

use crate::allocation::{Allocation, DivePlanes};
use crate::angle_loop::AngleLoop;
use crate::autopilot::{Derivative, DiveRules, Gains, Mode};
use crate::depth_loop::DepthLoop;
use crate::error::ParameterError;
use crate::estimator::{self, Calibration, IntegratorRules, Tuning};
use crate::gains::{self, LoopGains, PitchModel, SpeedLaw};
use crate::guidance::{Path, TurningManoeuvre};
use crate::hover::{HoverParameters, Thrusters};
use crate::integral::AntiWindup;
use crate::limits::Limit;
use crate::manoeuvre::{Manoeuvre, Signal, TestSignal};
use crate::pitch_loop::PitchLoop;
use crate::safety::Envelope;
use crate::schedule::Schedule;
use crate::setpoint::Bounds;
use crate::speed_loop::SpeedLoop;

/// Every parameter of `depth_controller`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ControllerParameters {
    /// Control mode: off (neutral planes, no thrust), open_loop (test signal only), pitch, depth, or hover (place, depth and heading by the thrusters of
    /// hover.vehicle).
    #[parameter(default = Mode::Depth)]
    pub mode: Mode,
    /// Depth setpoint, positive down, until the schedule or the topic gives another setpoint; within depth.min and depth.max.
    #[parameter(default = 0.0, unit = "m", positive = "down", range = 0.0..=1e4)]
    pub depth_setpoint: f64,
    /// Pitch setpoint in mode pitch, positive bow up; limited by depth.pitch_limit.
    #[parameter(default = 0.0, unit = "rad", positive = "bow up", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub pitch_setpoint: f64,
    /// Heading setpoint if heading.active, relative to the initial heading, positive to starboard.
    #[parameter(default = 0.0, unit = "rad", positive = "to starboard", range = -TAU..=TAU)]
    pub heading_setpoint: f64,
    /// Speed setpoint if speed.active, through the water; default 1 ft/s, the report's reference.
    #[parameter(default = 0.3048, unit = "m/s", range = 0.0..=10.0)]
    pub speed_setpoint: f64,
    /// Lifetime of a setpoint from a topic; afterwards the parameter or the schedule applies again. 0: no limit.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e6)]
    pub setpoint_timeout: f64,
    /// Wait in every tick until the instruments of its stamp have arrived; for a plant_sim in lockstep.
    #[parameter(default = false, read_only)]
    pub lockstep: bool,
    /// Run as a managed node (`ros2 lifecycle`), which commands only while it is active.
    #[parameter(default = false, read_only)]
    pub managed: bool,
    /// Time without a state message after which the planes go to neutral.
    #[parameter(default = 0.5, unit = "s", range = 1e-3..=3600.0)]
    pub state_timeout: f64,
    /// `depth.*`.
    pub depth: Depth,
    /// `pitch.*`.
    pub pitch: Pitch,
    /// `anti_windup.*`.
    pub anti_windup: AntiWindup,
    /// `planes.*`.
    pub planes: Planes,
    /// `transfer.*`.
    pub transfer: Transfer,
    /// `roll.*`.
    pub roll: Roll,
    /// `heading.*`.
    pub heading: Heading,
    /// `turning.*`.
    pub turning: TurningManoeuvre,
    /// `waypoints.*`.
    pub waypoints: WayPoints,
    /// `hover.*`.
    pub hover: HoverParameters,
    /// `speed.*`.
    pub speed: SpeedLoop,
    /// `safety.*`.
    pub safety: Envelope,
    /// `schedule.*`.
    pub schedule: ScheduleParameters,
    /// `identification.*`.
    pub identification: Manoeuvre,
    /// `feedback.*`.
    pub feedback: Feedback,
    /// `integrator.*`.
    pub integrator: IntegratorRules,
    /// `kalman.*`.
    pub kalman: Tuning,
    /// `gains.*`.
    pub gains: GainsParameters,
    /// Prefix of the frames in its messages' headers, to distinguish vehicles: 'auv2/'; the same as plant_sim's.
    #[parameter(default = "", read_only)]
    pub frame_prefix: String,
}

/// The parameters `depth.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Depth {
    /// Proportional gain of the depth loop: dive angle per depth error, Kpz = 0.25 rad/ft (Brunner 1988, program
    /// T6).
    #[parameter(default = 0.25 / FOOT, unit = "rad/m", range = 0.0..=1e3)]
    pub p: f64,
    /// Derivative gain of the depth loop: dive angle per depth rate, subtracted, Kdz = 0.6 rad s/ft (Brunner
    /// 1988, program T6).
    #[parameter(default = 0.6 / FOOT, unit = "rad s/m", range = 0.0..=1e3)]
    pub d: f64,
    /// Integral gain of the depth loop: dive angle per depth error and second; 0 in the report.
    #[parameter(default = 0.0, unit = "rad/(m s)", range = 0.0..=1e3)]
    pub i: f64,
    /// Limit of the integral term of the depth loop, to either side.
    #[parameter(default = 0.2, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub i_limit: f64,
    /// Signal that depth.d acts on: the measured depth (no kick at a setpoint step; DERIV of program T6) or the depth error.
    #[parameter(default = Derivative::Measurement)]
    pub derivative: Derivative,
    /// Time constant of the derivative filter; 0: no filter.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e3)]
    pub derivative_filter: f64,
    /// Limit of the pitch command to either side, 45 degrees (Brunner 1988, ch. II.B).
    #[parameter(default = FRAC_PI_4, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub pitch_limit: f64,
    /// Least depth setpoint from any source, positive down.
    #[parameter(default = 0.0, unit = "m", positive = "down", range = 0.0..=1e4)]
    pub min: f64,
    /// Largest depth setpoint from any source, positive down.
    #[parameter(default = 1e4, unit = "m", positive = "down", range = 0.0..=1e4)]
    pub max: f64,
    /// Rate limit of the depth setpoint; 0: no limit.
    #[parameter(default = 0.0, unit = "m/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `pitch.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Pitch {
    /// Proportional gain of the pitch loop: plane angle per pitch error, Kpy = 0.70 (Brunner 1988, program T6).
    #[parameter(default = 0.7, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Rate gain of the pitch loop: plane angle per pitch rate, Kr = 2 s (Brunner 1988, program T6).
    #[parameter(default = 2.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Integral gain of the pitch loop: plane angle per pitch error and second; 0 in the report.
    #[parameter(default = 0.0, unit = "1/s", range = 0.0..=1e3)]
    pub i: f64,
    /// Limit of the integral term of the pitch loop, to either side.
    #[parameter(default = 0.2, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub i_limit: f64,
    /// Rate limit of the pitch setpoint in mode pitch; 0: no limit.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `planes.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Planes {
    /// Limit of the plane command to either side, 30 degrees (Brunner 1988, ch. II.B).
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
    /// Rate limit of the plane command; 0: no limit.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub rate_limit: f64,
    /// Allocation of the dive command: bow and stern planes together, bow only, stern only, or in the ratio
    /// planes.bow_to_stern.
    #[parameter(default = DivePlanes::Together)]
    pub allocation: DivePlanes,
    /// Ratio of bow to stern plane angle, for allocation ratio; the pair with the larger angle gets the complete command.
    #[parameter(default = 1.0, range = 0.0..=1e3)]
    pub bow_to_stern: f64,
}

/// The parameters `transfer.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Transfer {
    /// Time constant of bumpless transfer: the step of a change of mode decays with it; 0: no bumpless transfer.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=1e3)]
    pub time: f64,
}

/// The parameters `roll.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Roll {
    /// Whether the bow planes control roll to zero, in every mode except off.
    #[parameter(default = true)]
    pub active: bool,
    /// Proportional gain of the roll loop: bow plane differential per roll error, Kpx = 10 (Brunner 1988, p. 30).
    #[parameter(default = 10.0, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Rate gain of the roll loop: bow plane differential per roll rate, Kdx = 10 s (Brunner 1988, p. 30).
    #[parameter(default = 10.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Limit of the differential to either side; the sum with the bow plane command is limited by planes.limit,
    /// and the dive command has priority.
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
}

/// The parameters `heading.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Heading {
    /// Whether the rudder controls the heading to heading_setpoint; a setpoint on the topic is always followed.
    #[parameter(default = true)]
    pub active: bool,
    /// Proportional gain of the heading loop: rudder angle per heading error, Kpy = 1 (Brunner 1988, p. 32).
    #[parameter(default = 1.0, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Rate gain of the heading loop: rudder angle per yaw rate, Kdy = 3 s (Brunner 1988, p. 32).
    #[parameter(default = 3.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Limit of the rudder command to either side; the default equals the planes' limit, because the report states no limit.
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
    /// Rate limit of the heading setpoint, which turns the shorter way; 0: no limit.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `waypoints.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct WayPoints {
    /// Way-points along the initial heading; with waypoints.y they give the heading by line of sight, in place of heading_setpoint until one comes on
    /// its topic, and in mode hover the place.
    #[parameter(default = Vec::new(), unit = "m", range = -1e6..=1e6)]
    pub x: Vec<f64>,
    /// Way-points to starboard of the initial heading, one per waypoints.x.
    #[parameter(default = Vec::new(), unit = "m", range = -1e6..=1e6)]
    pub y: Vec<f64>,
    /// Look-ahead distance on the leg toward which the vehicle steers.
    #[parameter(default = 5.0, unit = "m", range = 0.01..=1e4)]
    pub lookahead: f64,
    /// Radius about a way-point within which the next leg begins.
    #[parameter(default = 2.0, unit = "m", range = 0.01..=1e4)]
    pub acceptance: f64,
}

impl WayPoints {
    fn path(&self) -> Result<Path, ParameterError> {
        let (x, y) = (self.x.len(), self.y.len());
        if x != y {
            return Err(ParameterError::WayPoints { x, y });
        }
        let mut points: Vec<[f64; 2]> = (self.x.iter().zip(&self.y))
            .map(|(x, y)| [*x, *y])
            .collect();
        // A leg of no length has no course.
        points.dedup();
        Ok(Path {
            points,
            lookahead: self.lookahead,
            acceptance: self.acceptance,
        })
    }
}

/// The parameters `schedule.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ScheduleParameters {
    /// Start times of the scheduled depths since the first state; increasing.
    #[parameter(default = Vec::new(), unit = "s", range = 0.0..=1e9)]
    pub times: Vec<f64>,
    /// Start distances of the scheduled depths along the initial heading since the first state; increasing; instead
    /// of schedule.times.
    #[parameter(default = Vec::new(), unit = "m", range = 0.0..=1e9)]
    pub distances: Vec<f64>,
    /// Scheduled depths, positive down, one per time or distance; a setpoint from the topic ends the schedule.
    #[parameter(default = Vec::new(), unit = "m", positive = "down", range = 0.0..=1e4)]
    pub depths: Vec<f64>,
}

/// The parameters `feedback.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Feedback {
    /// Source of pitch, depth and their rates for the dive loops: the true state, the integrated gyro after a dead band (Brunner 1988, p. 91), or a
    /// Kalman filter on gyro, depth and speed.
    #[parameter(default = estimator::Source::Truth, read_only)]
    pub source: estimator::Source,
    /// Source of the speed for the estimators and the gain scheduling: feedback.speed (nominal) or the speed
    /// cell.
    #[parameter(default = SpeedSource::Nominal, read_only)]
    pub speed_source: SpeedSource,
    /// Nominal speed through the water.
    #[parameter(default = FOOT, unit = "m/s", range = 0.0..=100.0)]
    pub speed: f64,
    /// Range of the depth cell, positive down; deeper readings are ignored. 0: no limit.
    #[parameter(default = 0.0, unit = "m", positive = "down", range = 0.0..=11_000.0)]
    pub depth_range: f64,
    /// Absolute pressure at the surface, subtracted from the depth cell's pressure.
    #[parameter(default = 101_325.0, unit = "Pa", range = 0.0..=2e5)]
    pub surface_pressure: f64,
    /// Density of the water, for depth and speed from pressure; the report's 1.94 slug/ft^3.
    #[parameter(default = 999.835, unit = "kg/m^3", range = 900.0..=1200.0)]
    pub density: f64,
    /// Acceleration of gravity, for depth from pressure; the report's 32.2 ft/s^2.
    #[parameter(default = 9.81456, unit = "m/s^2", range = 9.0..=10.0)]
    pub gravity: f64,
}

/// The parameters `gains.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct GainsParameters {
    /// Source of the gains of the dive loops: fixed, scheduled (on speed by gains.model), adaptive (scheduled on the identified model while this
    /// model is trusted) or file (scheduled on the model in gains.file).
    #[parameter(default = GainSource::Fixed)]
    pub source: GainSource,
    /// Path of an identified model from dive_planes to pitch_rate (sysid fit --model), for gains.source file;
    /// trusted within gains.adaptive.
    #[parameter(default = "")]
    pub file: String,
    /// Speed for which the fixed gains were designed.
    #[parameter(default = FOOT, unit = "m/s", range = 1e-3..=100.0)]
    pub reference_speed: f64,
    /// Speed below which scheduled gains no longer increase.
    #[parameter(default = 0.5 * FOOT, unit = "m/s", range = 1e-3..=100.0)]
    pub lowest_speed: f64,
    /// `gains.model.*`.
    pub model: ModelParameters,
    /// `gains.adaptive.*`.
    pub adaptive: gains::Trust,
}

/// The parameters `gains.model.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ModelParameters {
    /// Plane moment over inertia, K/J, at the reference speed, positive dive (Brunner 1988, Table 1).
    #[parameter(default = 0.283 / 0.6, unit = "1/s^2", positive = "dive", range = 1e-6..=1e6)]
    pub plane: f64,
    /// Pitch damping over inertia, B/J, at the reference speed (Brunner 1988, Table 1).
    #[parameter(default = 0.718 / 0.6, unit = "1/s", range = 0.0..=1e6)]
    pub damping: f64,
    /// Exponent of the speed in K/J: 2 in water, 0 as in the report's Table 3.
    #[parameter(default = 2.0, range = 0.0..=4.0)]
    pub plane_exponent: f64,
    /// Exponent of the speed in B/J: 1 in water, 0 as in the report's Table 3.
    #[parameter(default = 1.0, range = 0.0..=4.0)]
    pub damping_exponent: f64,
}

/// The source of the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum SpeedSource {
    /// The nominal speed.
    Nominal,
    /// The speed cell.
    Cell,
}

/// The source of the gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum GainSource {
    /// The parameters, at any speed.
    Fixed,
    /// The schedule over speed.
    Scheduled,
    /// The schedule on the model that sysid identifies.
    Adaptive,
    /// The schedule on a model file.
    File,
}

/// The parameters, checked individually and together, with the derived settings of the loops.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Config {
    /// The parameters.
    pub parameters: ControllerParameters,
    /// The limits of the depth setpoint.
    pub depth_bounds: Bounds,
    /// The limits of the pitch setpoint.
    pub pitch_bounds: Bounds,
    /// The gains of the dive loops.
    pub gains: Gains,
    /// All other settings of the dive loops.
    pub dive: DiveRules,
    /// Bow and stern planes.
    pub allocation: Allocation,
    /// The roll regulator.
    pub roll: AngleLoop,
    /// The heading regulator.
    pub heading: AngleLoop,
    /// Depth setpoints over time or distance.
    pub schedule: Schedule,
    /// The test signal.
    pub identification: TestSignal,
    /// The feedback.
    pub feedback: estimator::Rules,
    /// The rules for gains that follow the vehicle.
    pub following: gains::Rules,
    /// The way-points.
    pub path: Path,
    /// The thrusters that mode hover commands.
    pub thrusters: Option<Thrusters>,
}

impl Config {
    /// The configuration that the parameters describe.
    ///
    /// # Errors
    /// [`ParameterError`], if values that are each in range conflict.
    pub(crate) fn new(parameters: &ControllerParameters) -> Result<Self, ParameterError> {
        let p = parameters;
        let dive = dive_rules(p)?;
        let depth_bounds = Bounds {
            min: p.depth.min,
            max: p.depth.max,
            rate: p.depth.setpoint_rate,
        };
        let schedule = schedule_of(&p.schedule)?;
        check_depths(p, &schedule, depth_bounds)?;
        check_envelope(p)?;
        let pitch_limit = limit("depth.pitch_limit", p.depth.pitch_limit)?;
        let gains = Gains {
            depth: DepthLoop {
                p: p.depth.p,
                d: p.depth.d,
                pitch_limit,
            },
            depth_i: p.depth.i,
            pitch: PitchLoop {
                p: p.pitch.p,
                rate: p.pitch.rate,
            },
            pitch_i: p.pitch.i,
        };
        Ok(Self {
            parameters: p.clone(),
            depth_bounds,
            pitch_bounds: Bounds {
                min: -pitch_limit.bound(),
                max: pitch_limit.bound(),
                rate: p.pitch.setpoint_rate,
            },
            gains,
            allocation: Allocation::new(p.planes.allocation, p.planes.bow_to_stern),
            roll: AngleLoop {
                p: p.roll.p,
                rate: p.roll.rate,
                limit: limit("roll.limit", p.roll.limit)?,
            },
            heading: AngleLoop {
                p: p.heading.p,
                rate: p.heading.rate,
                limit: limit("heading.limit", p.heading.limit)?,
            },
            schedule,
            identification: test_signal(&p.identification, dive.planes_limit)?,
            feedback: estimator_rules(p),
            following: gain_rules(&p.gains, &gains)?,
            path: p.waypoints.path()?,
            thrusters: thrusters(p)?,
            dive,
        })
    }
}

/// The thrusters, if a vehicle with thrusters is named.
fn thrusters(p: &ControllerParameters) -> Result<Option<Thrusters>, ParameterError> {
    match p.hover.vehicle.as_str() {
        "" if p.mode == Mode::Hover => Err(ParameterError::NothingHovers),
        "" => Ok(None),
        vehicle => Thrusters::load(vehicle).map(Some),
    }
}

fn limit(name: &'static str, bound: f64) -> Result<Limit, ParameterError> {
    Limit::new(bound).map_err(|reason| ParameterError::Limit(name, reason))
}

fn dive_rules(p: &ControllerParameters) -> Result<DiveRules, ParameterError> {
    Ok(DiveRules {
        derivative: p.depth.derivative,
        derivative_filter: p.depth.derivative_filter,
        depth_i_limit: limit("depth.i_limit", p.depth.i_limit)?,
        pitch_i_limit: limit("pitch.i_limit", p.pitch.i_limit)?,
        anti_windup: p.anti_windup.checked()?,
        planes_limit: limit("planes.limit", p.planes.limit)?,
        planes_rate_limit: p.planes.rate_limit,
        transfer_time: p.transfer.time,
    })
}

fn estimator_rules(p: &ControllerParameters) -> estimator::Rules {
    estimator::Rules {
        source: p.feedback.source,
        calibration: Calibration {
            density: p.feedback.density,
            gravity: p.feedback.gravity,
            surface_pressure: p.feedback.surface_pressure,
            depth_range: p.feedback.depth_range,
            speed: (p.feedback.speed_source == SpeedSource::Nominal).then_some(p.feedback.speed),
        },
        integrator: p.integrator,
        tuning: p.kalman,
    }
}

/// The rules for gains that follow the vehicle, from the `fixed` gains at the reference speed.
fn gain_rules(p: &GainsParameters, fixed: &Gains) -> Result<gains::Rules, ParameterError> {
    let schedule = gains::Schedule {
        reference: LoopGains {
            depth_p: fixed.depth.p,
            depth_d: fixed.depth.d,
            pitch_p: fixed.pitch.p,
            pitch_rate: fixed.pitch.rate,
        },
        law: SpeedLaw {
            model: PitchModel {
                plane: p.model.plane,
                damping: p.model.damping,
                // Held by neither gain: it stays in the closed loop as it is.
                restoring: 0.0,
            },
            reference_speed: p.reference_speed,
            plane_exponent: p.model.plane_exponent,
            damping_exponent: p.model.damping_exponent,
        },
        lowest_speed: p.lowest_speed,
    };
    let file = || {
        gains::FromFile::read(&p.file, &schedule, &p.adaptive).map_err(ParameterError::GainsFile)
    };
    Ok(gains::Rules {
        source: match p.source {
            GainSource::Fixed => gains::Source::Fixed,
            GainSource::Scheduled => gains::Source::Scheduled,
            GainSource::Adaptive => gains::Source::Adaptive,
            GainSource::File => gains::Source::File(file()?),
        },
        schedule,
        trust: p.adaptive,
    })
}

fn schedule_of(schedule: &ScheduleParameters) -> Result<Schedule, ParameterError> {
    let ScheduleParameters {
        times,
        distances,
        depths,
    } = schedule;
    if !times.is_empty() && !distances.is_empty() {
        return Err(ParameterError::TwoSchedules);
    }
    let (list, schedule) = match distances.as_slice() {
        [] => ("times", Schedule::over_time(times, depths)),
        _ => ("distances", Schedule::over_distance(distances, depths)),
    };
    schedule.map_err(|reason| ParameterError::Schedule { list, reason })
}

/// Refuses depths outside the bounds.
fn check_depths(
    p: &ControllerParameters,
    schedule: &Schedule,
    bounds: Bounds,
) -> Result<(), ParameterError> {
    let Bounds { min, max, .. } = bounds;
    if min > max {
        return Err(ParameterError::DepthBounds { min, max });
    }
    let standing = ("depth_setpoint", p.depth_setpoint);
    let depths = schedule.depths().into_iter();
    let scheduled = depths.map(|depth| ("schedule.depths", depth));
    for (name, depth) in std::iter::once(standing).chain(scheduled) {
        if !(min..=max).contains(&depth) {
            return Err(ParameterError::Depth {
                name,
                depth,
                min,
                max,
            });
        }
    }
    Ok(())
}

/// Refuses an envelope narrower than the range allowed for the loops.
fn check_envelope(p: &ControllerParameters) -> Result<(), ParameterError> {
    let Envelope {
        ceiling,
        floor,
        pitch,
        ..
    } = p.safety;
    for (name, value, other, bound) in [
        ("safety.ceiling", ceiling, "depth.min", p.depth.min),
        ("depth.max", p.depth.max, "safety.floor", floor),
        (
            "depth.pitch_limit",
            p.depth.pitch_limit,
            "safety.pitch",
            pitch,
        ),
    ] {
        if value > bound {
            return Err(ParameterError::Envelope {
                name,
                value,
                other,
                bound,
            });
        }
    }
    Ok(())
}

fn test_signal(manoeuvre: &Manoeuvre, planes_limit: Limit) -> Result<TestSignal, ParameterError> {
    if manoeuvre.signal != Signal::None && manoeuvre.amplitude.abs() > planes_limit.bound() {
        return Err(ParameterError::Clipped {
            amplitude: manoeuvre.amplitude,
            limit: planes_limit.bound(),
        });
    }
    manoeuvre.build().map_err(ParameterError::TestSignal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Value;

    fn with(changes: &[(&str, Value)]) -> Result<Config, String> {
        let parameters = ControllerParameters::default()
            .with(changes)
            .map_err(|refusal| refusal.to_string())?;
        Config::new(&parameters).map_err(|refusal| refusal.to_string())
    }

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in ControllerParameters::declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
            assert!(!declaration.description.is_empty());
        }
        let config = with(&[]).unwrap();
        assert_eq!(config.parameters.mode, Mode::Depth);
        assert!((config.gains.depth.p * FOOT - 0.25).abs() < 1e-15);
    }

    #[test]
    fn values_that_do_not_go_together_are_refused_by_name() {
        for (changes, reason) in [
            (vec![("planes.limit", Value::Double(0.0))], "planes.limit"),
            (vec![("depth.min", Value::Double(1.0))], "depth_setpoint"),
            (vec![("safety.floor", Value::Double(3.0))], "depth.max"),
            (vec![("safety.ceiling", Value::Double(3.0))], "depth.min"),
            (
                vec![("safety.pitch", Value::Double(0.5))],
                "depth.pitch_limit",
            ),
            (
                vec![
                    ("depth.max", Value::Double(2.0)),
                    ("schedule.times", Value::DoubleArray(vec![1.0])),
                    ("schedule.depths", Value::DoubleArray(vec![3.0])),
                ],
                "schedule.depths",
            ),
            (
                vec![
                    ("schedule.times", Value::DoubleArray(vec![1.0])),
                    ("schedule.distances", Value::DoubleArray(vec![1.0])),
                    ("schedule.depths", Value::DoubleArray(vec![3.0])),
                ],
                "not both",
            ),
            (
                vec![
                    ("anti_windup.strategy", Value::from("back_calculation")),
                    ("anti_windup.tracking_time_constant", Value::Double(0.0)),
                ],
                "tracking time",
            ),
            (
                vec![("depth.pitch_limit", Value::Double(0.0))],
                "depth.pitch_limit",
            ),
            (
                vec![("schedule.times", Value::DoubleArray(vec![1.0]))],
                "schedule.depths",
            ),
            (
                vec![
                    ("identification.signal", Value::from("square")),
                    ("identification.amplitude", Value::Double(0.6)),
                ],
                "planes.limit",
            ),
            (
                vec![
                    ("gains.source", Value::from("file")),
                    ("gains.file", Value::from("no/such/model.yaml")),
                ],
                "'gains.file': model file 'no/such/model.yaml'",
            ),
            (vec![("depth.p", Value::Double(f64::NAN))], "depth.p"),
            (vec![("mode", Value::from("climb"))], "mode"),
        ] {
            let refusal = with(&changes).unwrap_err();
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
