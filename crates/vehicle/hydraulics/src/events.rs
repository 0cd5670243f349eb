//! Events at which the ram's equations change; each is located as the zero of a margin.
//!
//! Every event has a margin that is positive until the event occurs: speed before a halt, oil before a break-away, travel before a stop. A
//! margin's first zero is searched between two turning points where the closed form decreases. Most events are excluded beforehand by
//! bounds of their quantity.
//!
//! Two margins have a small tolerance, so that an event does not trigger itself again: a break-away needs 1e-10 more than Delta F (or the
//! report's "stepping"), and a clamp acts 1e-12 beyond its pressure.

use planesman_linear::{first_below_zero, lowest_point};

use crate::closed_form::{ClosedForm, Quantity, Turns};
use crate::modes::{Constants, FrictionState, Mode, Side, State};

/// A change of the ram's equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// The sliding load stops.
    Halt,
    /// The pressure overcomes friction on this side.
    BreakAway(Side),
    /// The auxiliary piston of this side begins to hold the pressure.
    ClampOn(Side),
    /// The auxiliary piston has returned its oil.
    ClampOff,
    /// V_T reaches its limit on this side.
    VolumeLimit(Side),
    /// The net flow at the volume limit turns inwards.
    VolumeRelease,
    /// The ram reaches a stop.
    Stop(Side),
}

/// Largest number of possible next events in any mode.
const MOST_EVENTS: usize = 7;

/// Excess of the break-away force over Delta F, relative.
const BREAK_AWAY_EXCESS: f64 = 1e-10;

/// Tolerance of the pressure at which a clamp acts, relative.
const CLAMP_EXCESS: f64 = 1e-12;

/// Break-away force of the load, N.
#[must_use]
pub fn break_away_force(constants: &Constants) -> f64 {
    constants.coulomb * (1.0 + constants.stepping.max(BREAK_AWAY_EXCESS))
}

/// Returns the first event on `motion` within `horizon` seconds and its time; the motion is in `mode` at the net metered flow `flow`,
/// m^3/s. `steps` is the remaining number of search steps; 0 means the search did not finish.
#[must_use]
pub(crate) fn next_event(
    constants: &Constants,
    mode: Mode,
    flow: f64,
    motion: &ClosedForm,
    horizon: f64,
    steps: &mut u32,
) -> Option<(f64, Event)> {
    let mut first = None;
    let mut until = horizon;
    for event in possible(constants, mode)
        .into_iter()
        .map_while(|event| event)
    {
        let margin = Margin::new(constants, mode, flow, event);
        let zero = margin.first_zero(motion, until, steps);
        if let Some(t) = zero
            && (first.is_none() || t < until)
        {
            first = Some((t, event));
            until = t;
        }
    }
    first
}

/// `level + sign * quantity`: positive until the event occurs.
#[derive(Clone, Copy)]
struct Margin {
    level: f64,
    sign: f64,
    quantity: Quantity,
}

impl Margin {
    fn new(m: &Constants, mode: Mode, flow: f64, event: Event) -> Self {
        let below = |limit: f64, side: Side, quantity| Self {
            level: limit,
            sign: -side.sign(),
            quantity,
        };
        match event {
            Event::Halt => {
                let sign = match mode.friction {
                    FrictionState::Sliding(side) => side.sign(),
                    FrictionState::Stuck | FrictionState::AtStop(_) => 0.0,
                };
                Self {
                    level: 0.0,
                    sign,
                    quantity: Quantity::Speed,
                }
            }
            Event::BreakAway(side) => {
                let held = break_away_force(m) / (m.area * m.stiffness);
                below(held, side, Quantity::Oil)
            }
            Event::ClampOn(side) => {
                let held = m.clamp(side) / m.stiffness * (1.0 + CLAMP_EXCESS);
                below(held, side, Quantity::Oil)
            }
            Event::ClampOff => {
                let side = mode.clamped.unwrap_or(Side::Positive);
                Self {
                    level: -m.clamp(side) / m.stiffness,
                    sign: side.sign(),
                    quantity: Quantity::Oil,
                }
            }
            Event::VolumeLimit(side) => below(m.volume_limit, side, Quantity::Volume),
            Event::VolumeRelease => {
                // The net flow outwards, less what leaks with the pressure: in terms of oil.
                let side = mode.limited.unwrap_or(Side::Positive);
                let per_oil = m.leakage * m.stiffness;
                below(side.sign() * flow / per_oil, side, Quantity::Oil)
            }
            Event::Stop(side) => below(m.stop, side, Quantity::Position),
        }
    }

    /// The margin and its rate `t` seconds after the start of the motion.
    fn at(&self, motion: &ClosedForm, t: f64) -> (f64, f64) {
        let (value, rate) = motion.value_and_rate(self.quantity, t);
        (self.level + self.sign * value, self.sign * rate)
    }

    /// Time at which the margin first becomes negative within `horizon` seconds.
    fn first_zero(&self, motion: &ClosedForm, horizon: f64, steps: &mut u32) -> Option<f64> {
        let (one, other) = motion.range(self.quantity, horizon);
        if self.level + (self.sign * one).min(self.sign * other) > 0.0 {
            return None;
        }
        match motion.turns(self.quantity) {
            Some(turns) => self.first_zero_between(motion, turns, horizon),
            None => self.first_zero_in_steps(motion, horizon, steps),
        }
    }

    /// Since the deviations decay, a margin that decreases at the start is lowest at its first turning point, and one that increases at its
    /// second.
    fn first_zero_between(&self, motion: &ClosedForm, turns: Turns, horizon: f64) -> Option<f64> {
        let rises = self.sign * motion.value_and_rate_at_start(self.quantity).1 > 0.0;
        let second = turns.first + turns.interval;
        let (from, to) = if rises {
            (turns.first, second)
        } else {
            (0.0, turns.first)
        };
        let to = to.min(horizon);
        (from < to && self.at(motion, to).0 < 0.0)
            .then(|| first_below_zero(from, to, |t| self.at(motion, t)))
    }

    /// Searches in steps so short that the margin has at most one turning point in each.
    fn first_zero_in_steps(
        &self,
        motion: &ClosedForm,
        horizon: f64,
        steps: &mut u32,
    ) -> Option<f64> {
        let step = motion.short_time();
        let value = |t| self.at(motion, t);
        let (mut from, mut before) = (0.0, value(0.0));
        while from < horizon && *steps > 0 {
            *steps -= 1;
            let to = if from + 1.001 * step >= horizon {
                horizon
            } else {
                from + step
            };
            let after = value(to);
            if after.0 < 0.0 {
                return Some(first_below_zero(from, to, value));
            }
            if before.1 < 0.0 && after.1 > 0.0 {
                let lowest = lowest_point(from, to, value);
                if value(lowest).0 < 0.0 {
                    return Some(first_below_zero(from, lowest, value));
                }
            }
            (from, before) = (to, after);
        }
        None
    }
}

/// Net outward flow at the volume limit, m^3/s: while it is positive, V_T stays at the limit.
#[must_use]
pub(crate) fn outward_flow(constants: &Constants, side: Side, flow: f64, state: &State) -> f64 {
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
    // Where the supply is weak, no clamped pressure overcomes friction.
    let can_break_away =
        |side: Side| constants.clamp(side) * constants.area > break_away_force(constants);
    match mode.friction {
        FrictionState::Stuck => {
            for side in [Positive, Negative]
                .into_iter()
                .filter(|s| can_break_away(*s))
            {
                add(Event::BreakAway(side));
            }
        }
        FrictionState::AtStop(side) if can_break_away(side.opposite()) => {
            add(Event::BreakAway(side.opposite()));
        }
        FrictionState::AtStop(_) => {}
        FrictionState::Sliding(_) => {
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
        // Under the clamp nothing changes what leaks.
        if mode.clamped.is_none() && constants.leakage > 0.0 {
            add(Event::VolumeRelease);
        }
    } else if constants.volume_limit.is_finite() {
        add(Event::VolumeLimit(Positive));
        add(Event::VolumeLimit(Negative));
    }
    events
}
