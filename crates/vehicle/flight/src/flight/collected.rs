//! Data kept of each topic's messages.

use planesman_hydraulics::Energy;
use planesman_linear::{StepMetrics, TimeHistory};
use planesman_msgs::Message;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, PlaneCommand, PlaneMotion, ThrusterCommand, VehicleState,
};

use crate::in_order::{InOrder, Next};
use crate::model_summary::identified;

/// Time range of the close-up of the planes, s.
const CLOSE_UP: f64 = 5.0;
/// Only one of this many samples of a tick's plane motion is drawn.
const DRAWN_SAMPLES: usize = 5;
/// Upper limit of the number of actuators; no vehicle has that many.
pub(super) const ACTUATORS: usize = 16;

/// A message with a stamp.
pub(super) trait Stamped: Message {
    /// Nanoseconds.
    fn stamp(&self) -> i64;
}

macro_rules! stamped {
    ($($message:ty),*) => {
        $(impl Stamped for $message {
            fn stamp(&self) -> i64 {
                self.header.stamp.nanos()
            }
        })*
    };
}

stamped!(
    VehicleState,
    ControlState,
    PlaneCommand,
    PlaneMotion,
    DhaState,
    ModelEstimate,
    ThrusterCommand
);

/// Points of a time history: s since the first state, and the quantity.
pub type Points = Vec<(f64, f64)>;

/// Data collected from one topic's messages, in their order.
pub(super) trait Collected: Default {
    type Message: Stamped;

    /// Adds the next message; `t` is its stamp, s.
    fn take(&mut self, t: f64, message: &Self::Message);
}

/// One topic's messages, and the data collected from them.
#[derive(Default)]
pub(super) struct Line<T: Collected> {
    pub(super) order: InOrder<T::Message>,
    pub(super) data: T,
}

impl<T: Collected> Line<T> {
    pub(super) fn push(&mut self, origin: i64, message: T::Message) {
        let next = self.order.take(message.stamp(), message);
        self.take(origin, next);
    }

    pub(super) fn finish(&mut self, origin: i64) {
        let next = self.order.finish();
        self.take(origin, next);
    }

    fn take(&mut self, origin: i64, next: Option<Next<T::Message>>) {
        let (stamp, message) = match next {
            None => return,
            Some(Next::On(stamp, message)) => (stamp, message),
            Some(Next::Restarted(stamp, message)) => {
                self.data = T::default();
                (stamp, message)
            }
        };
        self.data.take(seconds(origin, stamp), &message);
    }
}

/// Seconds from `origin` to `stamp`, both in ns.
pub(super) fn seconds(origin: i64, stamp: i64) -> f64 {
    (stamp - origin) as f64 * 1e-9
}

/// True states of the vehicle.
#[derive(Default)]
pub(super) struct States {
    /// Stamps of the first and the last state, ns.
    pub(super) span: Option<(i64, i64)>,
    pub(super) ticks: u64,
    pub(super) planes_held: u64,
    pub(super) last_depth: f64,
    pub(super) depth: TimeHistory,
    pub(super) pitch: TimeHistory,
    pub(super) place: [TimeHistory; 2],
    pub(super) roll: TimeHistory,
    pub(super) yaw: TimeHistory,
    pub(super) speed: TimeHistory,
}

impl Collected for States {
    type Message = VehicleState;

    fn take(&mut self, t: f64, state: &VehicleState) {
        let stamp = state.stamp();
        let (first, _) = self.span.unwrap_or((stamp, stamp));
        self.span = Some((first, stamp));
        self.ticks += 1;
        self.planes_held += u64::from(state.planes_source == VehicleState::PLANES_HELD);
        self.last_depth = state.depth;
        self.depth.take(t, state.depth);
        self.pitch.take(t, state.pitch);
        self.place[0].take(t, state.distance);
        self.place[1].take(t, state.cross_track);
        self.roll.take(t, state.roll);
        self.yaw.take(t, state.yaw);
        self.speed.take(t, state.surge);
    }
}

/// The held depth, and the part of the flight in which the response to the last depth change can be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeldDepth<T> {
    /// m
    pub(crate) depth: f64,
    /// Time of the last change.
    pub(crate) since: T,
    /// Time of the first test signal after the step. A signal that starts by the tick after the change disturbs the whole response. In this case
    /// `signal` is `None` and `is_disturbed` is set.
    pub(crate) signal: Option<T>,
    /// Whether a test signal was active from the change on.
    pub(crate) is_disturbed: bool,
    ticks: u32,
}

impl<T: Copy> HeldDepth<T> {
    /// Updates the held depth by one state of the controller at `now`; `None` while no depth is held.
    pub(crate) fn after(held: Option<Self>, control: &ControlState, now: T) -> Option<Self> {
        if control.feedback_stale {
            return held;
        }
        let depth = control.depth_target;
        let holds = [ControlState::MODE_DEPTH, ControlState::MODE_HOVER].contains(&control.mode);
        if !holds {
            return None;
        }
        let mut held = (held.filter(|it| it.depth == depth)).unwrap_or(Self::from(depth, now));
        held.ticks = held.ticks.saturating_add(1);
        if is_tested(control) && held.signal.is_none() && !held.is_disturbed {
            held.is_disturbed = held.ticks <= 2;
            held.signal = (!held.is_disturbed).then_some(now);
        }
        Some(held)
    }

    /// A depth held from a time on, without a test signal.
    pub(crate) fn from(depth: f64, since: T) -> Self {
        Self {
            depth,
            since,
            signal: None,
            is_disturbed: false,
            ticks: 0,
        }
    }
}

impl<T: Copy + PartialOrd> HeldDepth<T> {
    /// Evaluates the response with a function of its end: up to the test signal, or up to the end of the flight if it has not settled by
    /// then. Returns the response, its end, and whether a test signal was active before the end.
    pub(crate) fn judged<E>(
        &self,
        end: T,
        response: impl Fn(T) -> Result<Option<StepMetrics>, E>,
    ) -> (Result<Option<StepMetrics>, E>, T, bool) {
        let signal = self.signal.filter(|it| *it < end);
        let to = signal.unwrap_or(end);
        let found = response(to);
        match &found {
            Ok(Some(it)) if signal.is_some() && it.settling_time_5.is_none() => {
                (response(end), end, true)
            }
            _ => (found, to, self.is_disturbed),
        }
    }
}

/// Whether a test signal or a manoeuvre moves the planes.
fn is_tested(control: &ControlState) -> bool {
    control.identification != 0.0 || control.manoeuvre != 0.0
}

/// States of the controller.
#[derive(Default)]
pub(super) struct Controls {
    /// Times in ns; `None` while no depth is held.
    pub(super) depth_held: Option<HeldDepth<i64>>,
    pub(super) depth_setpoint: TimeHistory,
    pub(super) pitch_command: TimeHistory,
    pub(super) heading_setpoint: TimeHistory,
}

impl Collected for Controls {
    type Message = ControlState;

    fn take(&mut self, t: f64, control: &ControlState) {
        self.depth_setpoint.take(t, control.depth_setpoint);
        self.pitch_command.take(t, control.pitch_command);
        if control.heading_held {
            self.heading_setpoint.take(t, control.heading_setpoint);
        }
        self.depth_held = HeldDepth::after(self.depth_held, control, control.stamp());
    }
}

/// A plane angle over the flight, and over its first seconds.
#[derive(Default)]
pub(super) struct Angle {
    pub(super) began: Option<f64>,
    pub(super) all: TimeHistory,
    pub(super) first: TimeHistory,
}

impl Angle {
    fn take(&mut self, t: f64, angle: f64) {
        self.all.take(t, angle);
        if t <= *self.began.get_or_insert(t) + CLOSE_UP {
            self.first.take(t, angle);
        }
    }

    pub(super) fn points(&self, shift: f64) -> [Points; 2] {
        let mut first = points(&self.first, shift);
        first.retain(|(t, _)| *t <= CLOSE_UP);
        [points(&self.all, shift), first]
    }
}

#[derive(Default)]
pub(super) struct Commands {
    pub(super) planes: Angle,
    pub(super) rudder: TimeHistory,
    pub(super) thrust: TimeHistory,
}

impl Collected for Commands {
    type Message = PlaneCommand;

    fn take(&mut self, t: f64, command: &PlaneCommand) {
        self.planes.take(t, command.dive_planes);
        self.rudder.take(t, command.rudder);
        self.thrust.take(t, command.thrust);
    }
}

/// Commands of the thrusters, by name.
#[derive(Default)]
pub(super) struct Thrusters(pub(super) Vec<(String, TimeHistory)>);

impl Collected for Thrusters {
    type Message = ThrusterCommand;

    fn take(&mut self, t: f64, command: &ThrusterCommand) {
        for (name, value) in command.name.iter().zip(&command.command) {
            if self.0.len() < ACTUATORS && self.0.iter().all(|(known, _)| known != name) {
                self.0.push((name.clone(), TimeHistory::default()));
            }
            if let Some((_, history)) = self.0.iter_mut().find(|(known, _)| known == name) {
                history.take(t, *value);
            }
        }
    }
}

/// Plane angle of the actuator, with several points per tick.
#[derive(Default)]
pub(super) struct Motions(pub(super) Angle);

impl Collected for Motions {
    type Message = PlaneMotion;

    fn take(&mut self, t: f64, motion: &PlaneMotion) {
        let duration = motion.duration.nanos() as f64 * 1e-9;
        let last = motion.dive_planes.len().saturating_sub(1).max(1) as f64;
        for (i, angle) in motion.dive_planes.iter().enumerate().step_by(DRAWN_SAMPLES) {
            self.0.take(t + duration * i as f64 / last, *angle);
        }
    }
}

#[derive(Default)]
pub(super) struct Rams {
    pub(super) pulses: u64,
    pub(super) energy: Energy,
    pub(super) ram: f64,
    pub(super) pressure: TimeHistory,
}

impl Collected for Rams {
    type Message = DhaState;

    fn take(&mut self, t: f64, state: &DhaState) {
        self.pulses = state.pulses;
        self.energy = Energy::from(state);
        self.ram = state.ram;
        self.pressure.take(t, state.pressure);
    }
}

/// Estimates of one pair of signals.
#[derive(Default)]
pub(super) struct Models {
    pub(super) valid: Option<ModelEstimate>,
    pub(super) reason: String,
    pub(super) pole: [TimeHistory; 2],
}

impl Collected for Models {
    type Message = ModelEstimate;

    fn take(&mut self, t: f64, model: &ModelEstimate) {
        self.reason.clone_from(&model.reason);
        if !model.valid {
            return;
        }
        if let Some(pole) = identified(model).dominant() {
            self.pole[0].take(t, pole.re);
            self.pole[1].take(t, pole.im);
        }
        self.valid = Some(model.clone());
    }
}

/// Points of a time history, `shift` seconds earlier.
pub(super) fn points(history: &TimeHistory, shift: f64) -> Points {
    history.points().map(|(t, y)| (t - shift, y)).collect()
}
