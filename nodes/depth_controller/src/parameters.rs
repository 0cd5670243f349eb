//! The controller's parameters: the only place where its defaults and ranges stand.
//!
//! The gains are those of program T6 (Brunner, NPS thesis, 1988, App. C): Kpz = 0.25 rad/ft,
//! Kdz = 0.6 rad·s/ft, Kpy = 0.70, Kr = 2 s; the limits those of its ch. II.B. With these defaults the
//! dive loops are the report's: no integral, no filter, no rate limits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};

use planesman_parameters::{Choice, Parameters};
use planesman_units::FOOT;

use crate::allocation::{Allocation, DivePlanes};
use crate::angle_loop::AngleLoop;
use crate::autopilot::{Derivative, DiveRules, Gains, Mode};
use crate::depth_loop::DepthLoop;
use crate::estimator::{self, Calibration, DeadBand, Tuning};
use crate::gains::{self, LoopGains, PitchModel, SpeedLaw};
use crate::integral::{AntiWindup, Strategy};
use crate::limits::Limit;
use crate::manoeuvre::{Manoeuvre, Signal, TestSignal};
use crate::pitch_loop::PitchLoop;
use crate::safety::Envelope;
use crate::schedule::Schedule;
use crate::setpoint::Bounds;
use crate::speed_loop::SpeedLoop;

/// The speed that full thrust is to give, m/s: 5 ft/s (Brunner 1988, p. 57).
const DESIGN_SPEED: f64 = 5.0 * FOOT;

/// Every parameter of `depth_controller`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ControllerParameters {
    /// What is held: off (everything neutral), open_loop (test signals alone on the planes), pitch, or depth.
    #[parameter(default = Mode::Depth)]
    pub mode: Mode,
    /// Depth to hold, positive down, until the schedule or the topic says otherwise; within depth.min and
    /// depth.max.
    #[parameter(default = 0.0, unit = "m", range = -1e4..=1e4)]
    pub depth_setpoint: f64,
    /// Pitch to hold in mode pitch, bow up positive; behind depth.pitch_limit.
    #[parameter(default = 0.0, unit = "rad", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub pitch_setpoint: f64,
    /// Course to hold when course.active, from the first course, positive to starboard.
    #[parameter(default = 0.0, unit = "rad", range = -PI..=PI)]
    pub course_setpoint: f64,
    /// Speed through the water to hold when speed.active; 1 ft/s, the report's reference.
    #[parameter(default = 0.3048, unit = "m/s", range = 0.0..=10.0)]
    pub speed_setpoint: f64,
    /// A setpoint from a topic holds this long, then the parameter's or the schedule's again; 0: for good.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e6)]
    pub setpoint_timeout: f64,
    /// Every tick waits for the instruments, asked for until they have come: for a plant_sim in lockstep.
    #[parameter(default = false, read_only)]
    pub lockstep: bool,
    /// Silence of the state topic after which the planes are put to neutral.
    #[parameter(default = 0.5, unit = "s", range = 1e-3..=3600.0)]
    pub state_timeout: f64,
    /// `depth.*`.
    pub depth: Depth,
    /// `pitch.*`.
    pub pitch: Pitch,
    /// `anti_windup.*`.
    pub anti_windup: AntiWindupParameters,
    /// `planes.*`.
    pub planes: Planes,
    /// `transfer.*`.
    pub transfer: Transfer,
    /// `roll.*`.
    pub roll: Roll,
    /// `course.*`.
    pub course: Course,
    /// `speed.*`.
    pub speed: Speed,
    /// `safety.*`.
    pub safety: Envelope,
    /// `schedule.*`.
    pub schedule: ScheduleParameters,
    /// `identification.*`.
    pub identification: Identification,
    /// `feedback.*`.
    pub feedback: Feedback,
    /// `integrator.*`.
    pub integrator: Integrator,
    /// `kalman.*`.
    pub kalman: Tuning,
    /// `gains.*`.
    pub gains: GainsParameters,
}

/// The parameters `depth.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Depth {
    /// Dive angle per metre of depth error, Kpz = 0.25 rad/ft (Brunner 1988, program T6).
    #[parameter(default = 0.25 / FOOT, unit = "rad/m", range = 0.0..=1e3)]
    pub p: f64,
    /// Dive angle taken away per m/s of depth rate, Kdz = 0.6 rad s/ft (Brunner 1988, program T6).
    #[parameter(default = 0.6 / FOOT, unit = "rad s/m", range = 0.0..=1e3)]
    pub d: f64,
    /// Dive angle per metre of depth error and second; the report has none.
    #[parameter(default = 0.0, unit = "rad/(m s)", range = 0.0..=1e3)]
    pub i: f64,
    /// Largest integral share of the dive angle to either side.
    #[parameter(default = 0.2, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub i_limit: f64,
    /// What depth.d acts on: the measured depth, as DERIV of program T6 without an impulse, or the error.
    #[parameter(default = Derivative::Measurement)]
    pub derivative: Derivative,
    /// Time constant of a filter on the derivative; 0: none.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e3)]
    pub derivative_filter: f64,
    /// Largest pitch command to either side, 45 degrees (Brunner 1988, ch. II.B).
    #[parameter(default = FRAC_PI_4, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub pitch_limit: f64,
    /// Least depth that is held, whatever is asked for.
    #[parameter(default = -1e4, unit = "m", range = -1e4..=1e4)]
    pub min: f64,
    /// Largest depth that is held, whatever is asked for.
    #[parameter(default = 1e4, unit = "m", range = -1e4..=1e4)]
    pub max: f64,
    /// How fast the depth held moves to the one asked for; 0: at once.
    #[parameter(default = 0.0, unit = "m/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `pitch.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Pitch {
    /// Plane angle per pitch error, Kpy = 0.70 (Brunner 1988, program T6).
    #[parameter(default = 0.7, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Plane angle per pitch rate, Kr = 2 s (Brunner 1988, program T6).
    #[parameter(default = 2.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Plane angle per pitch error and second; the report has none.
    #[parameter(default = 0.0, unit = "1/s", range = 0.0..=1e3)]
    pub i: f64,
    /// Largest integral share of the plane angle to either side.
    #[parameter(default = 0.2, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub i_limit: f64,
    /// How fast the pitch held in mode pitch moves to the one asked for; 0: at once.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `anti_windup.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct AntiWindupParameters {
    /// Anti-windup of the integrals, as in control_toolbox: none, conditional_integration (no integration further
    /// into a limit), or back_calculation.
    #[parameter(default = Strategy::ConditionalIntegration)]
    pub strategy: Strategy,
    /// Time constant of back_calculation: how fast it takes an integral out of saturation.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=1e3)]
    pub tracking_time_constant: f64,
}

/// The parameters `planes.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Planes {
    /// Largest plane command to either side, 30 degrees (Brunner 1988, ch. II.B).
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
    /// Fastest that the plane command moves; 0: at once.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub rate_limit: f64,
    /// Who dives: bow and stern planes together, the bow or the stern planes alone, or both in the ratio
    /// planes.bow_to_stern.
    #[parameter(default = DivePlanes::Together)]
    pub allocation: DivePlanes,
    /// Bow over stern plane angle, for the allocation ratio; the larger of the two gets the command.
    #[parameter(default = 1.0, range = 0.0..=1e3)]
    pub bow_to_stern: f64,
}

/// The parameters `transfer.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Transfer {
    /// Time constant with which the step that a change of mode would make on the planes fades; 0: the step.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=1e3)]
    pub time: f64,
}

/// The parameters `roll.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Roll {
    /// Hold the vehicle level by the bow planes, in every mode but off.
    #[parameter(default = true)]
    pub active: bool,
    /// Bow plane differential per roll error, Kpx = 10 (Brunner 1988, p. 30).
    #[parameter(default = 10.0, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Bow plane differential per roll rate, Kdx = 10 s (Brunner 1988, p. 30).
    #[parameter(default = 10.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Largest differential to either side; planes.limit for bow planes and differential together, the dive
    /// first.
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
}

/// The parameters `course.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Course {
    /// Hold course_setpoint by the rudder; a setpoint on the topic is held in any case.
    #[parameter(default = true)]
    pub active: bool,
    /// Rudder per course error, Kpy = 1 (Brunner 1988, p. 32).
    #[parameter(default = 1.0, unit = "rad/rad", range = 0.0..=1e3)]
    pub p: f64,
    /// Rudder per yaw rate, Kdy = 3 s (Brunner 1988, p. 32).
    #[parameter(default = 3.0, unit = "s", range = 0.0..=1e3)]
    pub rate: f64,
    /// Largest rudder to either side, as the planes'; the report states none.
    #[parameter(default = FRAC_PI_6, unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub limit: f64,
    /// How fast the course held moves to the one asked for, the short way round; 0: at once.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `speed.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Speed {
    /// Hold speed_setpoint by the thrust; a setpoint on the topic is held in any case.
    #[parameter(default = false)]
    pub active: bool,
    /// Share of full thrust per m/s asked for: all of it at the design speed, 5 ft/s (Brunner 1988, p. 57).
    #[parameter(default = 1.0 / DESIGN_SPEED, unit = "s/m", range = 0.0..=1e3)]
    pub feed_forward: f64,
    /// Share of full thrust per m/s of speed error; the report's gain is lost.
    #[parameter(default = 2.0, unit = "s/m", range = 0.0..=1e3)]
    pub p: f64,
    /// Largest share of full thrust to either side.
    #[parameter(default = 1.0, range = 0.0..=1.0)]
    pub limit: f64,
    /// How fast the speed held moves to the one asked for; 0: at once.
    #[parameter(default = 0.0, unit = "m/s^2", range = 0.0..=1e3)]
    pub setpoint_rate: f64,
}

/// The parameters `schedule.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ScheduleParameters {
    /// When each scheduled depth begins, since the first state; increasing.
    #[parameter(default = Vec::new(), unit = "s", range = 0.0..=1e9)]
    pub times: Vec<f64>,
    /// Or where each begins, along the first course since the first state; increasing.
    #[parameter(default = Vec::new(), unit = "m", range = 0.0..=1e9)]
    pub distances: Vec<f64>,
    /// The scheduled depths, one for each time or distance; a setpoint from the topic ends the schedule.
    #[parameter(default = Vec::new(), unit = "m", range = -1e4..=1e4)]
    pub depths: Vec<f64>,
}

/// The parameters `identification.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Identification {
    /// Test signal added to the plane command in every mode but off, so that sysid has something to learn from.
    #[parameter(default = Signal::None)]
    pub signal: Signal,
    /// The test signal's amplitude, positive dive; within planes.limit.
    #[parameter(default = 5.0_f64.to_radians(), unit = "rad", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub amplitude: f64,
    /// A pulse's length; a doublet's, square wave's or sinusoid's period; the prbs' shortest interval; the
    /// chirp's first period.
    #[parameter(default = 1.0, unit = "s", range = 1e-3..=1e6)]
    pub period: f64,
    /// The chirp's last period; its first is identification.period.
    #[parameter(default = 0.2, unit = "s", range = 1e-3..=1e6)]
    pub period_end: f64,
    /// When the test signal begins, since the first state.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e9)]
    pub start: f64,
    /// How long the test signal lasts; 0 for without end, but a chirp needs one.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e9)]
    pub duration: f64,
    /// Where in its cycle of 1023 intervals the pseudo-random sequence starts.
    #[parameter(default = 1)]
    pub seed: i64,
}

/// The parameters `feedback.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Feedback {
    /// Where the dive loops take pitch, depth and their rates from: the true state, the gyro behind a dead band
    /// and integrated (Brunner 1988, p. 91), or a Kalman filter on gyro, depth and speed.
    #[parameter(default = estimator::Source::Truth, read_only)]
    pub source: estimator::Source,
    /// Where the estimators and the gain schedule on estimates take the speed from: feedback.speed, as the
    /// report's stopwatch, or the speed cell.
    #[parameter(default = SpeedSource::Nominal, read_only)]
    pub speed_source: SpeedSource,
    /// The nominal speed through the water.
    #[parameter(default = FOOT, unit = "m/s", range = 0.0..=100.0)]
    pub speed: f64,
    /// Largest depth that the depth cell measures: readings from here on are not used; 0: all are used.
    #[parameter(default = 0.0, unit = "m", range = 0.0..=11_000.0)]
    pub depth_range: f64,
    /// Absolute pressure at the surface, taken off the depth cell's.
    #[parameter(default = 101_325.0, unit = "Pa", range = 0.0..=2e5)]
    pub surface_pressure: f64,
    /// Of the water, for depth and speed from pressures; the report's 1.94 slug/ft^3.
    #[parameter(default = 999.835, unit = "kg/m^3", range = 900.0..=1200.0)]
    pub density: f64,
    /// For depth from pressure; the report's 32.2 ft/s^2.
    #[parameter(default = 9.81456, unit = "m/s^2", range = 9.0..=10.0)]
    pub gravity: f64,
}

/// The parameters `integrator.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Integrator {
    /// Before the integrator: the report's one relay comparator, which passes the bow's fall alone, or a band to
    /// both sides.
    #[parameter(default = DeadBandKind::Comparator)]
    pub dead_band: DeadBandKind,
    /// The comparator's offset or the band's half width: the 25 mV that the gyro's zero drifts within (p. 90).
    #[parameter(default = 2.0_f64.to_radians(), unit = "rad/s", range = 0.0..=10.0)]
    pub width: f64,
    /// Time constant of the depth's derivative beside the integrator.
    #[parameter(default = 0.5, unit = "s", range = 1e-3..=100.0)]
    pub depth_lag: f64,
}

/// The parameters `gains.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct GainsParameters {
    /// Gains of the dive loops: fixed, scheduled over speed by gains.model, adaptive: the schedule on what sysid
    /// identifies while that can be trusted, or file: the schedule on the model in gains.file.
    #[parameter(default = GainSource::Fixed)]
    pub source: GainSource,
    /// For gains.source file: an identified model from dive_planes to pitch_rate (sysid fit --model), trusted on
    /// the terms of gains.adaptive.
    #[parameter(default = "")]
    pub file: String,
    /// The speed that the fixed gains are right for.
    #[parameter(default = FOOT, unit = "m/s", range = 1e-3..=100.0)]
    pub reference_speed: f64,
    /// Below this speed scheduled gains grow no further.
    #[parameter(default = 0.5 * FOOT, unit = "m/s", range = 1e-3..=100.0)]
    pub lowest_speed: f64,
    /// `gains.model.*`.
    pub model: ModelParameters,
    /// `gains.adaptive.*`.
    pub adaptive: Adaptive,
}

/// The parameters `gains.model.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct ModelParameters {
    /// K/J at the reference speed: dive moment per plane angle over inertia (Brunner 1988, Table 1).
    #[parameter(default = 0.283 / 0.6, unit = "1/s^2", range = 1e-6..=1e6)]
    pub plane: f64,
    /// B/J at the reference speed (Brunner 1988, Table 1).
    #[parameter(default = 0.718 / 0.6, unit = "1/s", range = 0.0..=1e6)]
    pub damping: f64,
    /// K/J goes with this power of the speed: 2 in water, 0 as in the report's Table 3.
    #[parameter(default = 2.0, range = 0.0..=4.0)]
    pub plane_exponent: f64,
    /// B/J goes with this power of the speed: 1 in water, 0 as in the report's Table 3.
    #[parameter(default = 1.0, range = 0.0..=4.0)]
    pub damping_exponent: f64,
}

/// The parameters `gains.adaptive.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Adaptive {
    /// From an identified model's stamp to its effect, so that no message's way decides.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=60.0)]
    pub delay: f64,
    /// Identified models older than this are not followed.
    #[parameter(default = 5.0, unit = "s", range = 0.0..=3600.0)]
    pub oldest: f64,
    /// Largest relative standard deviation of K/J and B/J in a model that is followed.
    #[parameter(default = 0.25, range = 0.0..=10.0)]
    pub uncertainty: f64,
    /// Largest factor between identified and scheduled K/J, B/J and gains.
    #[parameter(default = 4.0, range = 1.0..=100.0)]
    pub factor: f64,
    /// Largest change of a gain, in scheduled gains per second.
    #[parameter(default = 0.1, unit = "1/s", range = 0.0..=100.0)]
    pub rate: f64,
}

/// The source of the speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum SpeedSource {
    /// The nominal speed.
    Nominal,
    /// The speed cell.
    Cell,
}

/// The dead band before the integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum DeadBandKind {
    /// The report's relay comparator.
    Comparator,
    /// A band to both sides.
    TwoSided,
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

/// The parameters as the loops take them: checked each and together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Config {
    /// What is held.
    pub mode: Mode,
    /// The standing depth setpoint, m.
    pub depth_setpoint: f64,
    /// The standing pitch setpoint, rad, bow up.
    pub pitch_setpoint: f64,
    /// The standing course setpoint, rad.
    pub course_setpoint: f64,
    /// The standing speed setpoint, m/s.
    pub speed_setpoint: f64,
    /// How long a setpoint from a topic holds, s; 0 for good.
    pub setpoint_timeout: f64,
    /// Silence of the state after which the planes are put to neutral, s.
    pub state_timeout: f64,
    /// What the vehicle is kept within.
    pub envelope: Envelope,
    /// What the depth setpoint is kept within.
    pub depth_bounds: Bounds,
    /// What the pitch setpoint is kept within.
    pub pitch_bounds: Bounds,
    /// The gains of the dive loops.
    pub gains: Gains,
    /// Everything else about the dive loops.
    pub dive: DiveRules,
    /// Bow and stern planes.
    pub allocation: Allocation,
    /// Whether roll is held level.
    pub roll_active: bool,
    /// The roll regulator.
    pub roll: AngleLoop,
    /// Whether the standing course is held.
    pub course_active: bool,
    /// The course regulator.
    pub course: AngleLoop,
    /// How fast the course setpoint moves, rad/s; 0 at once.
    pub course_rate: f64,
    /// Whether the standing speed is held.
    pub speed_active: bool,
    /// The speed regulator.
    pub speed: SpeedLoop,
    /// How fast the speed setpoint moves, m/s^2; 0 at once.
    pub speed_rate: f64,
    /// Depth setpoints over time or distance.
    pub schedule: Schedule,
    /// The test signal.
    pub identification: TestSignal,
    /// What is fed back.
    pub feedback: estimator::Rules,
    /// How the gains follow the vehicle.
    pub following: gains::Rules,
}

impl Config {
    /// The loops that the parameters describe.
    ///
    /// # Errors
    /// A sentence naming the parameter, when values that are each in range do not go
    /// together: a limit of zero, setpoints beyond their bounds, a schedule whose lists do not match or do not
    /// increase, a test signal beyond the plane limit.
    pub(crate) fn new(parameters: &ControllerParameters) -> Result<Self, String> {
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
            mode: p.mode,
            depth_setpoint: p.depth_setpoint,
            pitch_setpoint: p.pitch_setpoint,
            course_setpoint: p.course_setpoint,
            speed_setpoint: p.speed_setpoint,
            setpoint_timeout: p.setpoint_timeout,
            state_timeout: p.state_timeout,
            envelope: p.safety,
            depth_bounds,
            pitch_bounds: Bounds {
                min: -pitch_limit.bound(),
                max: pitch_limit.bound(),
                rate: p.pitch.setpoint_rate,
            },
            gains,
            allocation: Allocation::new(p.planes.allocation, p.planes.bow_to_stern),
            roll_active: p.roll.active,
            roll: AngleLoop {
                p: p.roll.p,
                rate: p.roll.rate,
                limit: limit("roll.limit", p.roll.limit)?,
            },
            course_active: p.course.active,
            course: AngleLoop {
                p: p.course.p,
                rate: p.course.rate,
                limit: limit("course.limit", p.course.limit)?,
            },
            course_rate: p.course.setpoint_rate,
            speed_active: p.speed.active,
            speed: SpeedLoop {
                feed_forward: p.speed.feed_forward,
                p: p.speed.p,
                limit: p.speed.limit,
            },
            speed_rate: p.speed.setpoint_rate,
            schedule,
            identification: test_signal(&p.identification, dive.planes_limit)?,
            feedback: estimator_rules(p),
            following: gain_rules(&p.gains, &gains)?,
            dive,
        })
    }
}

fn limit(name: &str, bound: f64) -> Result<Limit, String> {
    Limit::new(bound).map_err(|reason| format!("parameter '{name}': {reason}"))
}

fn dive_rules(p: &ControllerParameters) -> Result<DiveRules, String> {
    Ok(DiveRules {
        derivative: p.depth.derivative,
        derivative_filter: p.depth.derivative_filter,
        depth_i_limit: limit("depth.i_limit", p.depth.i_limit)?,
        pitch_i_limit: limit("pitch.i_limit", p.pitch.i_limit)?,
        anti_windup: AntiWindup::new(p.anti_windup.strategy, p.anti_windup.tracking_time_constant)
            .map_err(|reason| format!("parameters 'anti_windup.*': {reason}"))?,
        planes_limit: limit("planes.limit", p.planes.limit)?,
        planes_rate_limit: p.planes.rate_limit,
        transfer_time: p.transfer.time,
    })
}

fn estimator_rules(p: &ControllerParameters) -> estimator::Rules {
    let width = p.integrator.width;
    estimator::Rules {
        source: p.feedback.source,
        calibration: Calibration {
            density: p.feedback.density,
            gravity: p.feedback.gravity,
            surface_pressure: p.feedback.surface_pressure,
            depth_range: p.feedback.depth_range,
            speed: (p.feedback.speed_source == SpeedSource::Nominal).then_some(p.feedback.speed),
        },
        dead_band: match p.integrator.dead_band {
            DeadBandKind::TwoSided => DeadBand::TwoSided(width),
            DeadBandKind::Comparator => DeadBand::Comparator(width),
        },
        lag: p.integrator.depth_lag,
        tuning: p.kalman,
    }
}

/// How gains follow the vehicle, from the `fixed` ones at the reference speed.
fn gain_rules(p: &GainsParameters, fixed: &Gains) -> Result<gains::Rules, String> {
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
    let trust = gains::Trust {
        oldest: p.adaptive.oldest,
        uncertainty: p.adaptive.uncertainty,
        factor: p.adaptive.factor,
        rate: p.adaptive.rate,
    };
    let file = || {
        gains::FromFile::read(&p.file, &schedule, &trust)
            .map_err(|reason| format!("parameter 'gains.file': {reason}"))
    };
    Ok(gains::Rules {
        source: match p.source {
            GainSource::Fixed => gains::Source::Fixed,
            GainSource::Scheduled => gains::Source::Scheduled,
            GainSource::Adaptive => gains::Source::Adaptive,
            GainSource::File => gains::Source::File(file()?),
        },
        schedule,
        trust,
        delay: p.adaptive.delay,
    })
}

fn schedule_of(schedule: &ScheduleParameters) -> Result<Schedule, String> {
    let ScheduleParameters {
        times,
        distances,
        depths,
    } = schedule;
    if !times.is_empty() && !distances.is_empty() {
        return Err(
            "parameters 'schedule.times', 'schedule.distances': refused: a schedule is over time or \
             over distance, not both"
                .to_owned(),
        );
    }
    let (list, schedule) = match distances.as_slice() {
        [] => ("times", Schedule::over_time(times, depths)),
        _ => ("distances", Schedule::over_distance(distances, depths)),
    };
    schedule.map_err(|reason| format!("parameters 'schedule.{list}', 'schedule.depths': {reason}"))
}

/// Refuses depths that could not be held.
fn check_depths(
    p: &ControllerParameters,
    schedule: &Schedule,
    bounds: Bounds,
) -> Result<(), String> {
    let Bounds { min, max, .. } = bounds;
    if min > max {
        return Err(format!(
            "parameters 'depth.min', 'depth.max': {min} m refused: it lies below {max} m"
        ));
    }
    let standing = ("depth_setpoint", p.depth_setpoint);
    let depths = schedule.depths().into_iter();
    let scheduled = depths.map(|depth| ("schedule.depths", depth));
    for (name, depth) in std::iter::once(standing).chain(scheduled) {
        if !(min..=max).contains(&depth) {
            return Err(format!(
                "parameter '{name}': {depth} m refused: only depths from depth.min ({min} m) to \
                 depth.max ({max} m) are held"
            ));
        }
    }
    Ok(())
}

/// Rejects an envelope narrower than what the loops are allowed.
fn check_envelope(p: &ControllerParameters) -> Result<(), String> {
    let Envelope {
        ceiling,
        floor,
        pitch,
        ..
    } = p.safety;
    for (name, inner, outer_name, outer) in [
        ("safety.ceiling", ceiling, "depth.min", p.depth.min),
        ("depth.max", p.depth.max, "safety.floor", floor),
        (
            "depth.pitch_limit",
            p.depth.pitch_limit,
            "safety.pitch",
            pitch,
        ),
    ] {
        if inner > outer {
            return Err(format!(
                "parameter '{name}': {inner} refused: at most {outer_name}, {outer}"
            ));
        }
    }
    Ok(())
}

fn test_signal(p: &Identification, planes_limit: Limit) -> Result<TestSignal, String> {
    let manoeuvre = Manoeuvre {
        signal: p.signal,
        amplitude: p.amplitude,
        period: p.period,
        period_end: p.period_end,
        start: p.start,
        duration: p.duration,
        seed: p.seed,
    };
    if manoeuvre.signal != Signal::None && manoeuvre.amplitude.abs() > planes_limit.bound() {
        return Err(format!(
            "parameter 'identification.amplitude': {} rad refused: planes.limit ({} rad) \
             would clip the signal",
            manoeuvre.amplitude,
            planes_limit.bound()
        ));
    }
    manoeuvre
        .build()
        .map_err(|reason| format!("parameters 'identification.*': {reason}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Value;

    fn with(changes: &[(&str, Value)]) -> Result<Config, String> {
        let parameters = ControllerParameters::default()
            .with(changes)
            .map_err(|refusal| refusal.to_string())?;
        Config::new(&parameters)
    }

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in ControllerParameters::declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
            assert!(!declaration.description.is_empty());
        }
        let config = with(&[]).unwrap();
        assert_eq!(config.mode, Mode::Depth);
        assert!((config.gains.depth.p * FOOT - 0.25).abs() < 1e-15);
    }

    #[test]
    fn values_that_do_not_go_together_are_refused_by_name() {
        for (changes, word) in [
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
            assert!(refusal.contains(word), "{refusal}");
        }
    }
}
