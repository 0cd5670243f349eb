//! The controller's parameters: the only place where its defaults and ranges stand.
//!
//! The gains are those of program T6 (Brunner, NPS thesis, 1988, App. C): Kpz = 0.25 rad/ft,
//! Kdz = 0.6 rad·s/ft, Kpy = 0.70, Kr = 2 s; the limits those of its ch. II.B. With these defaults the
//! dive loops are the report's: no integral, no filter, no rate limits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};

use planesman_parameters::{Declaration, Value, Values};

use crate::allocation::Allocation;
use crate::angle_loop::AngleLoop;
use crate::autopilot::{Derivative, DiveRules, Gains, Mode};
use crate::depth_loop::DepthLoop;
use crate::estimator::{self, Calibration, DeadBand, Tuning};
use crate::gains::{self, LoopGains, PitchModel, SpeedLaw};
use crate::integral::AntiWindup;
use crate::limits::Limit;
use crate::manoeuvre::{Manoeuvre, Signal, TestSignal};
use crate::pitch_loop::PitchLoop;
use crate::safety::Envelope;
use crate::schedule::Schedule;
use crate::setpoint::Bounds;
use crate::speed_loop::SpeedLoop;

/// The speed that full thrust is to give, m/s: 5 ft/s (Brunner 1988, p. 57).
const DESIGN_SPEED: f64 = 5.0 * METRES_PER_FOOT;

/// Metres in a foot (exact, by definition).
pub(crate) const METRES_PER_FOOT: f64 = 0.3048;

/// The declarations of one part of the controller.
type Part = Vec<Declaration>;

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    [
        setpoints(),
        depth(),
        pitch(),
        planes(),
        regulators(),
        safety(),
        schedule(),
        identification(),
        feedback(),
        gains(),
    ]
    .concat()
}

/// What is held, and where.
fn setpoints() -> Part {
    vec![
        Declaration::new(
            "mode",
            "depth",
            "What is held: off (everything neutral), open_loop (test signals alone on the planes), pitch, or depth.",
        )
        .choices(Mode::NAMES),
        Declaration::new(
            "depth_setpoint",
            0.0,
            "Depth to hold, positive down, until the schedule or the topic says otherwise; within depth.min and depth.max.",
        )
        .unit("m")
        .range(-1e4, 1e4),
        Declaration::new(
            "pitch_setpoint",
            0.0,
            "Pitch to hold in mode pitch, bow up positive; behind depth.pitch_limit.",
        )
        .unit("rad")
        .range(-FRAC_PI_2, FRAC_PI_2),
        Declaration::new(
            "course_setpoint",
            0.0,
            "Course to hold when course.active, from the first course, positive to starboard.",
        )
        .unit("rad")
        .range(-PI, PI),
        Declaration::new(
            "speed_setpoint",
            0.3048,
            "Speed through the water to hold when speed.active; 1 ft/s, the report's reference.",
        )
        .unit("m/s")
        .range(0.0, 10.0),
        Declaration::new(
            "setpoint_timeout",
            0.0,
            "A setpoint from a topic holds this long, then the parameter's or the schedule's again; 0: for good.",
        )
        .unit("s")
        .range(0.0, 1e6),
        Declaration::new(
            "lockstep",
            false,
            "Every tick waits for the instruments, asked for until they have come: for a plant_sim in lockstep.",
        )
        .read_only(),
        Declaration::new(
            "state_timeout",
            0.5,
            "Silence of the state topic after which the planes are put to neutral.",
        )
        .unit("s")
        .range(1e-3, 3600.0),
    ]
}

/// The outer loop.
fn depth() -> Part {
    vec![
        Declaration::new(
            "depth.p",
            0.25 / METRES_PER_FOOT,
            "Dive angle per metre of depth error, Kpz = 0.25 rad/ft (Brunner 1988, program T6).",
        )
        .unit("rad/m")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.d",
            0.6 / METRES_PER_FOOT,
            "Dive angle taken away per m/s of depth rate, Kdz = 0.6 rad s/ft (Brunner 1988, program T6).",
        )
        .unit("rad s/m")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.i",
            0.0,
            "Dive angle per metre of depth error and second; the report has none.",
        )
        .unit("rad/(m s)")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.i_limit",
            0.2,
            "Largest integral share of the dive angle to either side.",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "depth.derivative",
            "measurement",
            "What depth.d acts on: the measured depth, as DERIV of program T6 without an impulse, or the error.",
        )
        .choices(Derivative::NAMES),
        Declaration::new(
            "depth.derivative_filter",
            0.0,
            "Time constant of a filter on the derivative; 0: none.",
        )
        .unit("s")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.pitch_limit",
            FRAC_PI_4,
            "Largest pitch command to either side, 45 degrees (Brunner 1988, ch. II.B).",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new("depth.min", -1e4, "Least depth that is held, whatever is asked for.")
            .unit("m")
            .range(-1e4, 1e4),
        Declaration::new("depth.max", 1e4, "Largest depth that is held, whatever is asked for.")
            .unit("m")
            .range(-1e4, 1e4),
        Declaration::new(
            "depth.setpoint_rate",
            0.0,
            "How fast the depth held moves to the one asked for; 0: at once.",
        )
        .unit("m/s")
        .range(0.0, 1e3),
    ]
}

/// The inner loop.
fn pitch() -> Part {
    vec![
        Declaration::new(
            "pitch.p",
            0.7,
            "Plane angle per pitch error, Kpy = 0.70 (Brunner 1988, program T6).",
        )
        .unit("rad/rad")
        .range(0.0, 1e3),
        Declaration::new(
            "pitch.rate",
            2.0,
            "Plane angle per pitch rate, Kr = 2 s (Brunner 1988, program T6).",
        )
        .unit("s")
        .range(0.0, 1e3),
        Declaration::new(
            "pitch.i",
            0.0,
            "Plane angle per pitch error and second; the report has none.",
        )
        .unit("1/s")
        .range(0.0, 1e3),
        Declaration::new(
            "pitch.i_limit",
            0.2,
            "Largest integral share of the plane angle to either side.",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "pitch.setpoint_rate",
            0.0,
            "How fast the pitch held in mode pitch moves to the one asked for; 0: at once.",
        )
        .unit("rad/s")
        .range(0.0, 1e3),
        Declaration::new(
            "anti_windup.strategy",
            "conditional_integration",
            "Anti-windup of the integrals, as in control_toolbox: none, conditional_integration (no integration further into a limit), or back_calculation.",
        )
        .choices(AntiWindup::NAMES),
        Declaration::new(
            "anti_windup.tracking_time_constant",
            1.0,
            "Time constant of back_calculation: how fast it takes an integral out of saturation.",
        )
        .unit("s")
        .range(0.0, 1e3),
    ]
}

/// Where the loops' command goes.
fn planes() -> Part {
    vec![
        Declaration::new(
            "planes.limit",
            FRAC_PI_6,
            "Largest plane command to either side, 30 degrees (Brunner 1988, ch. II.B).",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "planes.rate_limit",
            0.0,
            "Fastest that the plane command moves; 0: at once.",
        )
        .unit("rad/s")
        .range(0.0, 1e3),
        Declaration::new(
            "planes.allocation",
            "together",
            "Who dives: bow and stern planes together, the bow or the stern planes alone, or both in the ratio planes.bow_to_stern.",
        )
        .choices(Allocation::NAMES),
        Declaration::new(
            "planes.bow_to_stern",
            1.0,
            "Bow over stern plane angle, for the allocation ratio; the larger of the two gets the command.",
        )
        .range(0.0, 1e3),
        Declaration::new(
            "transfer.time",
            1.0,
            "Time constant with which the step that a change of mode would make on the planes fades; 0: the step.",
        )
        .unit("s")
        .range(0.0, 1e3),
    ]
}

/// Roll, course and speed.
fn regulators() -> Part {
    vec![
        Declaration::new("roll.active", true, "Hold the vehicle level by the bow planes, in every mode but off."),
        Declaration::new(
            "roll.p",
            10.0,
            "Bow plane differential per roll error, Kpx = 10 (Brunner 1988, p. 30).",
        )
        .unit("rad/rad")
        .range(0.0, 1e3),
        Declaration::new(
            "roll.rate",
            10.0,
            "Bow plane differential per roll rate, Kdx = 10 s (Brunner 1988, p. 30).",
        )
        .unit("s")
        .range(0.0, 1e3),
        Declaration::new(
            "roll.limit",
            FRAC_PI_6,
            "Largest differential to either side; planes.limit for bow planes and differential together, the dive first.",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "course.active",
            true,
            "Hold course_setpoint by the rudder; a setpoint on the topic is held in any case.",
        ),
        Declaration::new(
            "course.p",
            1.0,
            "Rudder per course error, Kpy = 1 (Brunner 1988, p. 32).",
        )
        .unit("rad/rad")
        .range(0.0, 1e3),
        Declaration::new(
            "course.rate",
            3.0,
            "Rudder per yaw rate, Kdy = 3 s (Brunner 1988, p. 32).",
        )
        .unit("s")
        .range(0.0, 1e3),
        Declaration::new(
            "course.limit",
            FRAC_PI_6,
            "Largest rudder to either side, as the planes'; the report states none.",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "course.setpoint_rate",
            0.0,
            "How fast the course held moves to the one asked for, the short way round; 0: at once.",
        )
        .unit("rad/s")
        .range(0.0, 1e3),
        Declaration::new(
            "speed.active",
            false,
            "Hold speed_setpoint by the thrust; a setpoint on the topic is held in any case.",
        ),
        Declaration::new(
            "speed.feed_forward",
            1.0 / DESIGN_SPEED,
            "Share of full thrust per m/s asked for: all of it at the design speed, 5 ft/s (Brunner 1988, p. 57).",
        )
        .unit("s/m")
        .range(0.0, 1e3),
        Declaration::new(
            "speed.p",
            2.0,
            "Share of full thrust per m/s of speed error; the report's gain is lost.",
        )
        .unit("s/m")
        .range(0.0, 1e3),
        Declaration::new("speed.limit", 1.0, "Largest share of full thrust to either side.")
            .range(0.0, 1.0),
        Declaration::new(
            "speed.setpoint_rate",
            0.0,
            "How fast the speed held moves to the one asked for; 0: at once.",
        )
        .unit("m/s^2")
        .range(0.0, 1e3),
    ]
}

/// The envelope.
fn safety() -> Part {
    vec![
        Declaration::new(
            "safety.ceiling",
            -1e4,
            "Shallower than this is a fault: everything neutral, until it is reset; depth.min lies no higher.",
        )
        .unit("m")
        .range(-1e4, 1e4),
        Declaration::new(
            "safety.floor",
            1e4,
            "Deeper than this is a fault: planes to climb, then neutral, until it is reset; depth.max lies no deeper.",
        )
        .unit("m")
        .range(-1e4, 1e4),
        Declaration::new(
            "safety.margin",
            0.3,
            "How far above the floor the climb ends.",
        )
        .unit("m")
        .range(0.0, 1e4),
        Declaration::new(
            "safety.pitch",
            PI,
            "Pitched further to either side is a fault: bow down, planes to climb until level, then neutral; bow up, neutral; depth.pitch_limit is no larger.",
        )
        .unit("rad")
        .range(0.0, PI),
        Declaration::new(
            "safety.climb_planes",
            10.0_f64.to_radians(),
            "Plane angle of the climb, without any loop; within planes.limit.",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new("safety.climb_time", 20.0, "Longest climb; then neutral in any case.")
            .unit("s")
            .range(0.0, 3600.0),
        Declaration::new(
            "safety.latch_silence",
            false,
            "Whether a silence of the state longer than state_timeout is a fault too; otherwise the loops take up the next state.",
        ),
    ]
}

/// Way-depths.
fn schedule() -> Part {
    vec![
        Declaration::new(
            "schedule.times",
            Value::DoubleArray(Vec::new()),
            "When each scheduled depth begins, since the first state; increasing.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "schedule.distances",
            Value::DoubleArray(Vec::new()),
            "Or where each begins, along the first course since the first state; increasing.",
        )
        .unit("m")
        .range(0.0, 1e9),
        Declaration::new(
            "schedule.depths",
            Value::DoubleArray(Vec::new()),
            "The scheduled depths, one for each time or distance; a setpoint from the topic ends the schedule.",
        )
        .unit("m")
        .range(-1e4, 1e4),
    ]
}

/// The test signal.
fn identification() -> Part {
    vec![
        Declaration::new(
            "identification.signal",
            "none",
            "Test signal added to the plane command in every mode but off, so that sysid has something to learn from.",
        )
        .choices(Signal::NAMES),
        Declaration::new(
            "identification.amplitude",
            5.0_f64.to_radians(),
            "The test signal's amplitude, positive dive; within planes.limit.",
        )
        .unit("rad")
        .range(-FRAC_PI_2, FRAC_PI_2),
        Declaration::new(
            "identification.period",
            1.0,
            "A pulse's length; a doublet's, square wave's or sinusoid's period; the prbs' shortest interval; the chirp's first period.",
        )
        .unit("s")
        .range(1e-3, 1e6),
        Declaration::new(
            "identification.period_end",
            0.2,
            "The chirp's last period; its first is identification.period.",
        )
        .unit("s")
        .range(1e-3, 1e6),
        Declaration::new(
            "identification.start",
            0.0,
            "When the test signal begins, since the first state.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "identification.duration",
            0.0,
            "How long the test signal lasts; 0 for without end, but a chirp needs one.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "identification.seed",
            1_i64,
            "Where in its cycle of 1023 intervals the pseudo-random sequence starts.",
        ),
    ]
}

/// Where feedback comes from.
fn feedback() -> Part {
    vec![
        Declaration::new(
            "feedback.source",
            "truth",
            "Where the dive loops take pitch, depth and their rates from: the true state, the gyro behind a dead band and integrated (Brunner 1988, p. 91), or a Kalman filter on gyro, depth and speed.",
        )
        .choices(estimator::Source::NAMES)
        .read_only(),
        Declaration::new(
            "feedback.speed_source",
            "nominal",
            "Where the estimators and the gain schedule on estimates take the speed from: feedback.speed, as the report's stopwatch, or the speed cell.",
        )
        .choices(&["nominal", "cell"])
        .read_only(),
        Declaration::new("feedback.speed", METRES_PER_FOOT, "The nominal speed through the water.")
            .unit("m/s")
            .range(0.0, 100.0),
        Declaration::new(
            "feedback.depth_range",
            0.0,
            "Largest depth that the depth cell measures: readings from here on are not used; 0: all are used.",
        )
        .unit("m")
        .range(0.0, 11_000.0),
        Declaration::new(
            "feedback.surface_pressure",
            101_325.0,
            "Absolute pressure at the surface, taken off the depth cell's.",
        )
        .unit("Pa")
        .range(0.0, 2e5),
        Declaration::new(
            "feedback.density",
            999.835,
            "Of the water, for depth and speed from pressures; the report's 1.94 slug/ft^3.",
        )
        .unit("kg/m^3")
        .range(900.0, 1200.0),
        Declaration::new(
            "feedback.gravity",
            9.81456,
            "For depth from pressure; the report's 32.2 ft/s^2.",
        )
        .unit("m/s^2")
        .range(9.0, 10.0),
        Declaration::new(
            "integrator.dead_band",
            "comparator",
            "Before the integrator: the report's one relay comparator, which passes the bow's fall alone, or a band to both sides.",
        )
        .choices(&["comparator", "two_sided"]),
        Declaration::new(
            "integrator.width",
            2.0_f64.to_radians(),
            "The comparator's offset or the band's half width: the 25 mV that the gyro's zero drifts within (p. 90).",
        )
        .unit("rad/s")
        .range(0.0, 10.0),
        Declaration::new(
            "integrator.depth_lag",
            0.5,
            "Time constant of the depth's derivative beside the integrator.",
        )
        .unit("s")
        .range(1e-3, 100.0),
        Declaration::new(
            "kalman.gyro_noise",
            0.007,
            "Standard deviation of a gyro reading; 5 mV at 12.5 mV per deg/s.",
        )
        .unit("rad/s")
        .range(1e-9, 10.0),
        Declaration::new(
            "kalman.bias_walk",
            0.0014,
            "Standard deviation of the gyro zero's walk after 1 s; 1 mV.",
        )
        .unit("rad/s^1.5")
        .range(0.0, 10.0),
        Declaration::new(
            "kalman.depth_noise",
            0.0005,
            "Standard deviation of a depth reading; 5 mV at 10.1 V/m.",
        )
        .unit("m")
        .range(1e-9, 100.0),
        Declaration::new(
            "kalman.stray_rate",
            0.01,
            "Standard deviation of the depth rate that pitch does not explain: heave, currents.",
        )
        .unit("m/s")
        .range(0.0, 100.0),
        Declaration::new(
            "kalman.stray_time",
            2.0,
            "How long such a depth rate lasts: its correlation time.",
        )
        .unit("s")
        .range(1e-3, 1e6),
        Declaration::new(
            "kalman.initial_pitch",
            0.05,
            "Standard deviation of the pitch at the start, about level.",
        )
        .unit("rad")
        .range(0.0, 3.0),
        Declaration::new(
            "kalman.initial_bias",
            2.0_f64.to_radians(),
            "Standard deviation of the gyro's zero at the start; 25 mV.",
        )
        .unit("rad/s")
        .range(0.0, 10.0),
    ]
}

/// Where gains come from. The vehicle is that of Table 1: M'delta, M'q and W BG over its inertia at 1 ft/s.
fn gains() -> Part {
    vec![
        Declaration::new(
            "gains.source",
            "fixed",
            "Gains of the dive loops: fixed, scheduled over speed by gains.model, adaptive: the schedule on what sysid identifies while that can be trusted, or file: the schedule on the model in gains.file.",
        )
        .choices(gains::Source::NAMES),
        Declaration::new(
            "gains.file",
            "",
            "For gains.source file: an identified model from dive_planes to pitch_rate (sysid fit --model), trusted on the terms of gains.adaptive.",
        ),
        Declaration::new(
            "gains.reference_speed",
            METRES_PER_FOOT,
            "The speed that the fixed gains are right for.",
        )
        .unit("m/s")
        .range(1e-3, 100.0),
        Declaration::new(
            "gains.lowest_speed",
            0.5 * METRES_PER_FOOT,
            "Below this speed scheduled gains grow no further.",
        )
        .unit("m/s")
        .range(1e-3, 100.0),
        Declaration::new(
            "gains.model.plane",
            0.283 / 0.6,
            "K/J at the reference speed: dive moment per plane angle over inertia (Brunner 1988, Table 1).",
        )
        .unit("1/s^2")
        .range(1e-6, 1e6),
        Declaration::new(
            "gains.model.damping",
            0.718 / 0.6,
            "B/J at the reference speed (Brunner 1988, Table 1).",
        )
        .unit("1/s")
        .range(0.0, 1e6),
        Declaration::new(
            "gains.model.plane_exponent",
            2.0,
            "K/J goes with this power of the speed: 2 in water, 0 as in the report's Table 3.",
        )
        .range(0.0, 4.0),
        Declaration::new(
            "gains.model.damping_exponent",
            1.0,
            "B/J goes with this power of the speed: 1 in water, 0 as in the report's Table 3.",
        )
        .range(0.0, 4.0),
        Declaration::new(
            "gains.adaptive.delay",
            1.0,
            "From an identified model's stamp to its effect, so that no message's way decides.",
        )
        .unit("s")
        .range(0.0, 60.0),
        Declaration::new(
            "gains.adaptive.oldest",
            5.0,
            "Identified models older than this are not followed.",
        )
        .unit("s")
        .range(0.0, 3600.0),
        Declaration::new(
            "gains.adaptive.uncertainty",
            0.25,
            "Largest relative standard deviation of K/J and B/J in a model that is followed.",
        )
        .range(0.0, 10.0),
        Declaration::new(
            "gains.adaptive.factor",
            4.0,
            "Largest factor between identified and scheduled K/J, B/J and gains.",
        )
        .range(1.0, 100.0),
        Declaration::new(
            "gains.adaptive.rate",
            0.1,
            "Largest change of a gain, in scheduled gains per second.",
        )
        .unit("1/s")
        .range(0.0, 100.0),
    ]
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
    /// The loops that a set of [`declarations`]' values describes.
    ///
    /// # Errors
    /// A sentence naming the parameter, when values that are each in range do not go
    /// together: a limit of zero, setpoints beyond their bounds, a schedule whose lists do not match or do not
    /// increase, a test signal beyond the plane limit.
    pub(crate) fn from_values(values: &Values) -> Result<Self, String> {
        let dive = dive_rules(values)?;
        let depth_bounds = Bounds {
            min: values.double("depth.min"),
            max: values.double("depth.max"),
            rate: values.double("depth.setpoint_rate"),
        };
        let schedule = schedule_of(values)?;
        check_depths(values, &schedule, depth_bounds)?;
        let envelope = envelope(values, depth_bounds)?;
        let angle_loop = |axis: &str| {
            Ok::<_, String>(AngleLoop {
                p: values.double(&format!("{axis}.p")),
                rate: values.double(&format!("{axis}.rate")),
                limit: limit(values, &format!("{axis}.limit"))?,
            })
        };
        let pitch_limit = limit(values, "depth.pitch_limit")?;
        let gains = Gains {
            depth: DepthLoop {
                p: values.double("depth.p"),
                d: values.double("depth.d"),
                pitch_limit,
            },
            depth_i: values.double("depth.i"),
            pitch: PitchLoop {
                p: values.double("pitch.p"),
                rate: values.double("pitch.rate"),
            },
            pitch_i: values.double("pitch.i"),
        };
        Ok(Self {
            mode: Mode::named(values.string("mode"))?,
            depth_setpoint: values.double("depth_setpoint"),
            pitch_setpoint: values.double("pitch_setpoint"),
            course_setpoint: values.double("course_setpoint"),
            speed_setpoint: values.double("speed_setpoint"),
            setpoint_timeout: values.double("setpoint_timeout"),
            state_timeout: values.double("state_timeout"),
            envelope,
            depth_bounds,
            pitch_bounds: Bounds {
                min: -pitch_limit.bound(),
                max: pitch_limit.bound(),
                rate: values.double("pitch.setpoint_rate"),
            },
            gains,
            allocation: Allocation::named(
                values.string("planes.allocation"),
                values.double("planes.bow_to_stern"),
            )?,
            roll_active: values.bool("roll.active"),
            roll: angle_loop("roll")?,
            course_active: values.bool("course.active"),
            course: angle_loop("course")?,
            course_rate: values.double("course.setpoint_rate"),
            speed_active: values.bool("speed.active"),
            speed: SpeedLoop {
                feed_forward: values.double("speed.feed_forward"),
                p: values.double("speed.p"),
                limit: values.double("speed.limit"),
            },
            speed_rate: values.double("speed.setpoint_rate"),
            schedule,
            identification: test_signal(values, dive.planes_limit)?,
            feedback: estimator_rules(values)?,
            following: gain_rules(values, &gains)?,
            dive,
        })
    }
}

fn limit(values: &Values, name: &str) -> Result<Limit, String> {
    Limit::new(values.double(name)).map_err(|reason| format!("parameter '{name}': {reason}"))
}

fn dive_rules(values: &Values) -> Result<DiveRules, String> {
    Ok(DiveRules {
        derivative: match values.string("depth.derivative") {
            "error" => Derivative::Error,
            _ => Derivative::Measurement,
        },
        derivative_filter: values.double("depth.derivative_filter"),
        depth_i_limit: limit(values, "depth.i_limit")?,
        pitch_i_limit: limit(values, "pitch.i_limit")?,
        anti_windup: AntiWindup::named(
            values.string("anti_windup.strategy"),
            values.double("anti_windup.tracking_time_constant"),
        )
        .map_err(|reason| format!("parameters 'anti_windup.*': {reason}"))?,
        planes_limit: limit(values, "planes.limit")?,
        planes_rate_limit: values.double("planes.rate_limit"),
        transfer_time: values.double("transfer.time"),
    })
}

fn estimator_rules(values: &Values) -> Result<estimator::Rules, String> {
    let width = values.double("integrator.width");
    let source = values.string("feedback.source");
    Ok(estimator::Rules {
        source: estimator::Source::named(source)
            .ok_or_else(|| format!("parameter 'feedback.source': '{source}' refused"))?,
        calibration: Calibration {
            density: values.double("feedback.density"),
            gravity: values.double("feedback.gravity"),
            surface_pressure: values.double("feedback.surface_pressure"),
            depth_range: values.double("feedback.depth_range"),
            speed: (values.string("feedback.speed_source") == "nominal")
                .then(|| values.double("feedback.speed")),
        },
        dead_band: match values.string("integrator.dead_band") {
            "two_sided" => DeadBand::TwoSided(width),
            _ => DeadBand::Comparator(width),
        },
        lag: values.double("integrator.depth_lag"),
        tuning: Tuning {
            gyro_noise: values.double("kalman.gyro_noise"),
            bias_walk: values.double("kalman.bias_walk"),
            depth_noise: values.double("kalman.depth_noise"),
            stray_rate: values.double("kalman.stray_rate"),
            stray_time: values.double("kalman.stray_time"),
            initial_pitch: values.double("kalman.initial_pitch"),
            initial_bias: values.double("kalman.initial_bias"),
        },
    })
}

/// How gains follow the vehicle, from the `fixed` ones at the reference speed.
fn gain_rules(values: &Values, fixed: &Gains) -> Result<gains::Rules, String> {
    let schedule = gains::Schedule {
        reference: LoopGains {
            depth_p: fixed.depth.p,
            depth_d: fixed.depth.d,
            pitch_p: fixed.pitch.p,
            pitch_rate: fixed.pitch.rate,
        },
        law: SpeedLaw {
            model: PitchModel {
                plane: values.double("gains.model.plane"),
                damping: values.double("gains.model.damping"),
                // Held by neither gain: it stays in the closed loop as it is.
                restoring: 0.0,
            },
            reference_speed: values.double("gains.reference_speed"),
            plane_exponent: values.double("gains.model.plane_exponent"),
            damping_exponent: values.double("gains.model.damping_exponent"),
        },
        lowest_speed: values.double("gains.lowest_speed"),
    };
    let trust = gains::Trust {
        oldest: values.double("gains.adaptive.oldest"),
        uncertainty: values.double("gains.adaptive.uncertainty"),
        factor: values.double("gains.adaptive.factor"),
        rate: values.double("gains.adaptive.rate"),
    };
    let file = || {
        gains::FromFile::read(values.string("gains.file"), &schedule, &trust)
            .map_err(|reason| format!("parameter 'gains.file': {reason}"))
    };
    Ok(gains::Rules {
        source: gains::Source::named(values.string("gains.source"), file)?,
        schedule,
        trust,
        delay: values.double("gains.adaptive.delay"),
    })
}

fn schedule_of(values: &Values) -> Result<Schedule, String> {
    let [times, distances, depths] =
        ["times", "distances", "depths"].map(|list| doubles(values, &format!("schedule.{list}")));
    if !times.is_empty() && !distances.is_empty() {
        return Err(
            "parameters 'schedule.times', 'schedule.distances': refused: a schedule is over time or \
             over distance, not both"
                .to_owned(),
        );
    }
    let (list, schedule) = match distances {
        [] => ("times", Schedule::over_time(times, depths)),
        _ => ("distances", Schedule::over_distance(distances, depths)),
    };
    schedule.map_err(|reason| format!("parameters 'schedule.{list}', 'schedule.depths': {reason}"))
}

/// Refuses depths that could not be held.
fn check_depths(values: &Values, schedule: &Schedule, bounds: Bounds) -> Result<(), String> {
    let Bounds { min, max, .. } = bounds;
    if min > max {
        return Err(format!(
            "parameters 'depth.min', 'depth.max': {min} m refused: it lies below {max} m"
        ));
    }
    let standing = ("depth_setpoint", values.double("depth_setpoint"));
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

fn envelope(values: &Values, bounds: Bounds) -> Result<Envelope, String> {
    let envelope = Envelope {
        ceiling: values.double("safety.ceiling"),
        floor: values.double("safety.floor"),
        margin: values.double("safety.margin"),
        pitch: values.double("safety.pitch"),
        climb_planes: values.double("safety.climb_planes"),
        climb_time: values.double("safety.climb_time"),
        latch_silence: values.bool("safety.latch_silence"),
    };
    let pitch_limit = values.double("depth.pitch_limit");
    for (name, inner, outer_name, outer) in [
        ("safety.ceiling", envelope.ceiling, "depth.min", bounds.min),
        ("depth.max", bounds.max, "safety.floor", envelope.floor),
        (
            "depth.pitch_limit",
            pitch_limit,
            "safety.pitch",
            envelope.pitch,
        ),
    ] {
        if inner > outer {
            return Err(format!(
                "parameter '{name}': {inner} refused: at most {outer_name}, {outer}"
            ));
        }
    }
    Ok(envelope)
}

fn test_signal(values: &Values, planes_limit: Limit) -> Result<TestSignal, String> {
    let manoeuvre = Manoeuvre {
        signal: Signal::named(values.string("identification.signal"))?,
        amplitude: values.double("identification.amplitude"),
        period: values.double("identification.period"),
        period_end: values.double("identification.period_end"),
        start: values.double("identification.start"),
        duration: values.double("identification.duration"),
        seed: values.integer("identification.seed"),
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

fn doubles<'v>(values: &'v Values, name: &str) -> &'v [f64] {
    match values.get(name) {
        Some(Value::DoubleArray(list)) => list,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn with(changes: &[(&str, Value)]) -> Result<Config, String> {
        let values = Values::defaults(declarations())
            .with(
                changes
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), value.clone())),
            )
            .map_err(|refusal| refusal.to_string())?;
        Config::from_values(&values)
    }

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
            assert!(!declaration.description.is_empty());
        }
        let config = with(&[]).unwrap();
        assert_eq!(config.mode, Mode::Depth);
        assert!((config.gains.depth.p * METRES_PER_FOOT - 0.25).abs() < 1e-15);
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
