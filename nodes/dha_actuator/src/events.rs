//! Where the ram's motion changes its law: each event as the zero of a margin, located.
//!
//! Every event has a margin that is positive as long as the event has not come: the speed left
//! before a halt, the force left before a break-away, the travel left before a stop. The first
//! zero is searched on the closed form, in steps short enough that a margin turns at most once in
//! each, so that one that only dips below zero between two steps is found too.
//!
//! Two margins are opened by a hair, so that an event is never its own cause: a break-away
//! needs 1e-10 more than Delta F, and a clamp takes hold 1e-12 beyond its pressure.

use crate::modes::{ClosedForm, Constants, Load, Mode, Side, State};

/// A change of the ram's law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The sliding load comes to rest.
    Halt,
    /// The pressure overcomes friction on this side.
    BreakAway(Side),
    /// The auxiliary piston of this side starts to hold the pressure.
    ClampOn(Side),
    /// The auxiliary piston has given its oil back.
    ClampOff,
    /// V_T reaches its limit on this side.
    VolumeLimit(Side),
    /// The net flow at the volume limit turns inwards.
    VolumeRelease,
    /// The ram reaches a stop.
    Stop(Side),
}

/// The most events that can come next in any mode.
const MOST_EVENTS: usize = 7;

/// How much more than Delta F breaks the load away, relative.
const BREAK_AWAY_EXCESS: f64 = 1e-10;

/// How far beyond its pressure a clamp takes hold, relative.
const CLAMP_EXCESS: f64 = 1e-12;

/// The force, N, that breaks the load away.
#[must_use]
pub fn break_away_force(constants: &Constants) -> f64 {
    constants.coulomb * (1.0 + BREAK_AWAY_EXCESS)
}

/// A margin and its rate of change.
#[derive(Clone, Copy)]
struct Margin {
    value: f64,
    rate: f64,
}

/// A motion with the events that may end it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The motion.
    pub motion: ClosedForm,
    mode: Mode,
    flow: f64,
    start: State,
    events: [Option<Event>; MOST_EVENTS],
}

impl Segment {
    /// The motion from `start` in `mode` under the flow `flow`, m^3/s.
    #[must_use]
    pub fn new(constants: &Constants, mode: Mode, flow: f64, start: State) -> Self {
        Self {
            motion: ClosedForm::new(constants, mode, flow, start),
            mode,
            flow,
            start,
            events: possible(constants, mode),
        }
    }

    /// The first event within `horizon` seconds of the start, and when.
    #[must_use]
    pub fn next_event(&self, constants: &Constants, horizon: f64) -> Option<(f64, Event)> {
        if self.nothing_can_happen(constants, horizon) {
            return None;
        }
        let step = self.motion.turning_time().min(horizon);
        let mut from = 0.0;
        let mut margins = self.margins(constants, from);
        while from < horizon {
            let to = if from + 1.001 * step >= horizon {
                horizon
            } else {
                from + step
            };
            let margins_after = self.margins(constants, to);
            let mut first: Option<(f64, Event)> = None;
            for (i, event) in self.events.iter().enumerate() {
                let Some(event) = *event else { break };
                let zero =
                    self.zero_between(constants, event, (from, margins[i]), (to, margins_after[i]));
                if let Some(t) = zero
                    && first.is_none_or(|(earliest, _)| t < earliest)
                {
                    first = Some((t, event));
                }
            }
            if first.is_some() {
                return first;
            }
            (from, margins) = (to, margins_after);
        }
        None
    }

    /// Whether the energy bound of the motion alone excludes every event: the common case of a
    /// load that creeps on its drift.
    fn nothing_can_happen(&self, m: &Constants, horizon: f64) -> bool {
        let Load::Sliding(side) = self.mode.load else {
            return false;
        };
        let Some(((v, v_reach), (w, w_reach))) = self.motion.bounds() else {
            return false;
        };
        if self.mode.limited.is_some() {
            return false;
        }
        let pressure = m.stiffness * (w.abs() + w_reach);
        let keeps_sliding = m.coulomb == 0.0 || side.sign() * v > v_reach;
        let keeps_below_clamp = pressure < m.clamp_positive.min(m.clamp_negative);
        let travel = self.start.position.abs() + (v.abs() + v_reach) * horizon;
        let volume = self.start.volume.abs() + (self.flow.abs() + m.leakage * pressure) * horizon;
        keeps_sliding && keeps_below_clamp && travel < m.stop && volume < m.volume_limit
    }

    fn margins(&self, constants: &Constants, t: f64) -> [Margin; MOST_EVENTS] {
        let state = self.motion.at(t);
        let rates = self.motion.rates(&state);
        self.events.map(|event| match event {
            Some(event) => self.margin(constants, event, &state, rates),
            None => Margin {
                value: f64::INFINITY,
                rate: 0.0,
            },
        })
    }

    fn margin_at(&self, constants: &Constants, event: Event, t: f64) -> Margin {
        let state = self.motion.at(t);
        self.margin(constants, event, &state, self.motion.rates(&state))
    }

    fn margin(
        &self,
        m: &Constants,
        event: Event,
        state: &State,
        (v_dot, w_dot): (f64, f64),
    ) -> Margin {
        let (v, w) = (state.velocity, state.squeezed);
        let margin = |value, rate| Margin { value, rate };
        match event {
            Event::Halt => {
                let direction = match self.mode.load {
                    Load::Sliding(side) => side.sign(),
                    Load::Stuck | Load::AtStop(_) => 0.0,
                };
                margin(direction * v, direction * v_dot)
            }
            Event::BreakAway(side) => {
                let force_per_oil = side.sign() * m.area * m.stiffness;
                margin(
                    break_away_force(m) - force_per_oil * w,
                    -force_per_oil * w_dot,
                )
            }
            Event::ClampOn(side) => {
                let held = m.clamp(side) / m.stiffness * (1.0 + CLAMP_EXCESS);
                margin(held - side.sign() * w, -side.sign() * w_dot)
            }
            Event::ClampOff => {
                let side = self.mode.clamped.unwrap_or(Side::Positive);
                let held = m.clamp(side) / m.stiffness;
                margin(side.sign() * w - held, side.sign() * w_dot)
            }
            Event::VolumeLimit(side) => margin(
                m.volume_limit - side.sign() * state.volume,
                -side.sign() * (w_dot + m.area * v),
            ),
            Event::VolumeRelease => {
                let side = self.mode.limited.unwrap_or(Side::Positive);
                let pressure_rate = if self.mode.clamped.is_some() {
                    0.0
                } else {
                    m.stiffness * w_dot
                };
                margin(
                    outward_flow(m, side, self.flow, state),
                    -side.sign() * m.leakage * pressure_rate,
                )
            }
            Event::Stop(side) => margin(m.stop - side.sign() * state.position, -side.sign() * v),
        }
    }

    /// The first zero of a margin between two times over which it turns at most once.
    fn zero_between(
        &self,
        constants: &Constants,
        event: Event,
        (from, before): (f64, Margin),
        (to, after): (f64, Margin),
    ) -> Option<f64> {
        let value = |t| self.margin_at(constants, event, t);
        if after.value < 0.0 {
            return Some(first_below_zero(from, to, value));
        }
        let dips = before.rate < 0.0 && after.rate > 0.0;
        if !dips {
            return None;
        }
        // The lowest point, by halving on the rate.
        let (mut low, mut high) = (from, to);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let margin = value(middle);
            if margin.value < 0.0 {
                return Some(first_below_zero(from, middle, value));
            }
            if margin.rate < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
            // Even falling at its first rate it would not reach zero from here.
            if margin.value > -before.rate.min(margin.rate) * (high - low) {
                return None;
            }
        }
        None
    }
}

/// The net flow outwards at the volume limit, m^3/s: while it is positive, V_T stays there.
#[must_use]
pub fn outward_flow(constants: &Constants, side: Side, flow: f64, state: &State) -> f64 {
    side.sign() * (flow - constants.leakage * constants.pressure(state.squeezed))
}

/// The events that can end a mode.
fn possible(constants: &Constants, mode: Mode) -> [Option<Event>; MOST_EVENTS] {
    use Side::{Negative, Positive};
    let mut events = [None; MOST_EVENTS];
    let mut count = 0;
    let mut add = |event| {
        events[count] = Some(event);
        count += 1;
    };
    match mode.load {
        Load::Stuck => {
            add(Event::BreakAway(Positive));
            add(Event::BreakAway(Negative));
        }
        Load::AtStop(side) => add(Event::BreakAway(side.opposite())),
        Load::Sliding(_) => {
            if constants.coulomb > 0.0 {
                add(Event::Halt);
            }
            if constants.stop.is_finite() {
                add(Event::Stop(Positive));
                add(Event::Stop(Negative));
            }
        }
    }
    if mode.clamped.is_some() {
        add(Event::ClampOff);
    } else {
        add(Event::ClampOn(Positive));
        add(Event::ClampOn(Negative));
    }
    if mode.limited.is_some() {
        add(Event::VolumeRelease);
    } else if constants.volume_limit.is_finite() {
        add(Event::VolumeLimit(Positive));
        add(Event::VolumeLimit(Negative));
    }
    events
}

/// Where a margin falls below zero between `low`, where it has not, and `high`, where it has:
/// Newton's method, kept within the bracket by halving.
fn first_below_zero(mut low: f64, mut high: f64, margin: impl Fn(f64) -> Margin) -> f64 {
    let mut t = 0.5 * (low + high);
    for _ in 0..120 {
        let here = margin(t);
        if here.value < 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - here.value / here.rate;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - t).abs() <= 1e-18 + 2.0 * f64::EPSILON * t || high - low <= 1e-18 {
            return next;
        }
        t = next;
    }
    t
}
