//! The controller's answer as messages: the only place that fills [`ControlState`].

use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand};
use planesman_msgs::std_msgs::msg::Header;

use crate::autopilot::{DiveTerms, Gains, Mode};
use crate::estimator::Source;
use crate::fault::Fault;
use crate::loops::{DepthSource, LoopTerms};

/// The answer to a state.
pub type Answer = (PlaneCommand, ControlState);

/// The feedback and the gains of a tick's commands.
pub(crate) struct Basis {
    /// The depth rate used for feedback, m/s.
    pub depth_rate: f64,
    /// The source of the feedback.
    pub source: Source,
    /// Whether the reading of an instrument for this stamp is missing.
    pub instruments_missing: bool,
    /// The current gains.
    pub gains: Gains,
    /// Whether the gains come from an identified model.
    pub adapted: bool,
}

/// The commands with all intermediate terms; `basis` is `None` without feedback.
pub(crate) fn answer(
    header: Header,
    mode: Mode,
    fault: Option<Fault>,
    basis: Option<&Basis>,
    terms: &LoopTerms,
) -> Answer {
    let axes = [terms.roll, terms.heading, terms.speed];
    let [roll, heading, speed] = axes.map(Option::unwrap_or_default);
    let command = PlaneCommand {
        header: header.clone(),
        dive_planes: terms.planes.mean,
        bow_stern_differential: terms.planes.differential,
        roll_differential: roll.command,
        rudder: heading.command,
        thrust: speed.command,
    };
    let DiveTerms { depth, pitch, .. } = &terms.dive;
    let mut control = ControlState {
        header,
        mode: match mode {
            Mode::Off => ControlState::MODE_OFF,
            Mode::OpenLoop => ControlState::MODE_OPEN_LOOP,
            Mode::Pitch => ControlState::MODE_PITCH,
            Mode::Depth => ControlState::MODE_DEPTH,
            Mode::Hover => ControlState::MODE_HOVER,
        },
        depth_setpoint_source: match terms.depth_source {
            DepthSource::Parameter => ControlState::SETPOINT_PARAMETER,
            DepthSource::Schedule => ControlState::SETPOINT_SCHEDULE,
            DepthSource::Topic => ControlState::SETPOINT_TOPIC,
        },
        depth_target: terms.depth_target,
        depth_setpoint: terms.depth_setpoint,
        depth_error: depth.error,
        depth_p: depth.p,
        depth_i: terms.dive.depth_i,
        depth_d: depth.d,
        pitch_command: terms.dive.pitch_command.value,
        pitch_command_limited: terms.dive.pitch_command.at_limit,
        pitch_error: pitch.error,
        planes_p: pitch.p,
        planes_i: terms.dive.pitch_i,
        planes_rate: pitch.rate,
        transfer: terms.dive.transfer,
        identification: terms.identification,
        manoeuvre: terms.manoeuvre,
        dive_planes: terms.planes.mean,
        dive_planes_limited: terms.dive.planes.at_limit,
        bow_stern_differential: terms.planes.differential,
        roll_held: terms.roll.is_some(),
        roll_error: roll.error,
        roll_differential: roll.command,
        heading_held: terms.heading.is_some(),
        heading_setpoint: heading.setpoint,
        heading_error: heading.error,
        rudder: heading.command,
        speed_held: terms.speed.is_some(),
        speed_setpoint: speed.setpoint,
        speed_error: speed.error,
        thrust: speed.command,
        fault: match fault {
            None => ControlState::FAULT_NONE,
            Some(Fault::Floor) => ControlState::FAULT_FLOOR,
            Some(Fault::Ceiling) => ControlState::FAULT_CEILING,
            Some(Fault::BowDown) => ControlState::FAULT_BOW_DOWN,
            Some(Fault::BowUp) => ControlState::FAULT_BOW_UP,
            Some(Fault::Silence) => ControlState::FAULT_SILENCE,
        },
        climbing: terms.climbing,
        feedback_stale: basis.is_none(),
        ..ControlState::default()
    };
    if let Some(basis) = basis {
        control.depth_rate = basis.depth_rate;
        control.feedback_source = feedback_constant(basis.source);
        control.instruments_missing = basis.instruments_missing;
        control.gain_depth_p = basis.gains.depth.p;
        control.gain_depth_d = basis.gains.depth.d;
        control.gain_pitch_p = basis.gains.pitch.p;
        control.gain_pitch_rate = basis.gains.pitch.rate;
        control.gains_adapted = basis.adapted;
    }
    (command, control)
}

/// The constant for a source in `ControlState` and `MotionEstimate`.
pub(crate) fn feedback_constant(source: Source) -> u8 {
    match source {
        Source::Truth => ControlState::FEEDBACK_TRUTH,
        Source::Integrator => ControlState::FEEDBACK_INTEGRATOR,
        Source::Kalman => ControlState::FEEDBACK_KALMAN,
    }
}
