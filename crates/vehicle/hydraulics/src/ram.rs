//! The ram with its load as a hybrid system: closed-form motion between located events.
//!
//! [`crate::modes`] has the equations, [`crate::events`] the changes of mode. A [`Ram`] receives pieces of constant flow, one after the
//! other. The events within a piece depend on the piece only, and a state within it is evaluated from the closed form without side effects.
//! So the motion does not depend on when, or how often, the position is read.

use crate::actuator_set::ActuatorSet;
use crate::closed_form::ClosedForm;
use crate::energy::{Energy, Ledger};
use crate::events::{Event, break_away_force, next_event, outward_flow};
use crate::metering::Flows;
use crate::modes::{Constants, FrictionState, Mode, Pressures, Side, State};

/// Maximum number of events, or of search steps for events, in one piece of flow. Beyond it the rest of the piece stays in its present mode, and the
/// ram is [`Ram::unsolved`].
const MOST_EVENTS_IN_A_PIECE: u32 = 10_000;
const MOST_STEPS_IN_A_PIECE: u32 = 1_000_000;

/// The ram between two flow edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ram {
    constants: Constants,
    pressures: Pressures,
    mode: Mode,
    /// State at `time`, the start of the present segment.
    state: State,
    time: f64,
    flow: f64,
    motion: ClosedForm,
    /// End time of the segment and the event that ends it; `None` at the end of the piece.
    ends: f64,
    event: Option<Event>,
    piece_ends: f64,
    events_left: u32,
    steps_left: u32,
    /// Whether a search for events did not finish.
    unsolved: bool,
    /// Sliding distance in both directions, up to `time`.
    slid: f64,
    /// Whether the constants have changed since the start of the present piece.
    changed: bool,
    /// Energies up to `time`, if they are kept.
    ledger: Option<Ledger>,
}

impl Ram {
    /// Returns a ram at rest at `position`, m, without squeezed oil.
    #[must_use]
    pub(crate) fn resting_at(set: &ActuatorSet, position: f64) -> Self {
        let constants = Constants::new(set);
        let mode = Mode {
            friction: if constants.coulomb == 0.0 {
                FrictionState::Sliding(Side::Positive)
            } else {
                FrictionState::Stuck
            },
            clamped: None,
            limited: None,
        };
        let state = State {
            position,
            volume: constants.area * position,
            ..State::default()
        };
        Self {
            constants,
            pressures: Pressures::new(set),
            mode,
            state,
            time: 0.0,
            flow: 0.0,
            motion: ClosedForm::new(&constants, mode, 0.0, state),
            ends: 0.0,
            event: None,
            piece_ends: 0.0,
            events_left: 0,
            steps_left: 0,
            unsolved: false,
            slid: 0.0,
            changed: false,
            ledger: None,
        }
    }

    /// Mode at the time last advanced to.
    #[must_use]
    pub(crate) fn mode(&self) -> Mode {
        self.mode
    }

    /// Field of the file with the fastest time constant if a search for events did not finish; otherwise `None`.
    #[must_use]
    pub(crate) fn unsolved(&self) -> Option<&'static str> {
        let m = &self.constants;
        let swing = m.area * (m.stiffness / m.mass).sqrt();
        let (damping, leakage) = (m.viscous / m.mass, m.leakage * m.stiffness);
        self.unsolved.then_some(match damping.max(leakage) {
            fastest if fastest <= swing => "oil.stiffness",
            fastest if fastest == damping => "load.viscous",
            _ => "leakage.rate_gain",
        })
    }

    /// P_d, Pa, in a state of this ram.
    #[must_use]
    pub(crate) fn pressure(&self, state: &State) -> f64 {
        self.constants.pressure(state.squeezed)
    }

    /// Total distance that the load has slid against friction up to `time`, m, in both directions.
    #[must_use]
    pub(crate) fn slid(&self, time: f64) -> f64 {
        self.slid + (self.position(time) - self.state.position).abs()
    }

    /// Changes the constants from the next piece on, which must begin next: position, speed and oil stay, the pressure changes.
    pub(crate) fn set_constants(&mut self, constants: Constants, pressures: Pressures) {
        self.changed |= constants != self.constants;
        self.constants = constants;
        self.pressures = pressures;
    }

    /// Keeps the energies from now on; call it before the first piece.
    pub(crate) fn keep_energy(&mut self) {
        self.ledger = Some(Ledger::new(self.constants, self.pressures));
    }

    /// The ledger, if energies are kept.
    pub(crate) fn ledger(&mut self) -> Option<&mut Ledger> {
        self.ledger.as_mut()
    }

    /// Energies up to `time`, which is limited as in [`Ram::at`]; `None` if they are not kept.
    #[must_use]
    pub(crate) fn energy(&self, time: f64) -> Option<Energy> {
        let mut ledger = self.ledger?;
        let (t, end) = (time - self.time, self.at(time));
        ledger.book(self.mode, &self.motion, &self.state, &end, t);
        Some(ledger.energy(end.velocity))
    }

    /// The energies up to the last change of law or flow.
    #[must_use]
    pub(crate) fn booked_energy(&self) -> Option<Energy> {
        let ledger = self.ledger.as_ref()?;
        Some(ledger.energy(self.state.velocity))
    }

    /// Ends the last piece and starts one with the constant flow `flow`, m^3/s. The new piece begins at the time `from`, s, which may
    /// differ from the last piece's end time, and ends at `until`. `flows` is the same flow by its paths, for the energies.
    pub(crate) fn begin(&mut self, flow: f64, from: f64, until: f64, flows: Option<Flows>) {
        self.advance(self.piece_ends);
        self.commit();
        if let (Some(ledger), Some(flows)) = (&mut self.ledger, flows) {
            ledger.begin(self.constants, self.pressures, flows);
        }
        self.time = from;
        self.flow = flow;
        self.piece_ends = until;
        self.events_left = MOST_EVENTS_IN_A_PIECE;
        self.steps_left = MOST_STEPS_IN_A_PIECE;
        if std::mem::take(&mut self.changed) {
            self.reconsider();
        }
        if let Some(side) = self.mode.limited
            && outward_flow(&self.constants, side, flow, &self.state) < 0.0
        {
            self.mode.limited = None;
        }
        self.plan();
    }

    /// Moves the ram by `position`, m, and squeezes in `squeezed`, m^3, at the end of the present piece: a neighbouring state in the same
    /// mode.
    pub(crate) fn displace(&mut self, position: f64, squeezed: f64) {
        self.advance(self.piece_ends);
        self.commit();
        self.state.position += position;
        self.state.squeezed += squeezed;
        self.state.volume += self.constants.area * position + squeezed;
        self.plan();
    }

    /// Processes the events up to `time`, s, which lies within the piece.
    pub(crate) fn advance(&mut self, time: f64) {
        while let Some(event) = self.event
            && self.ends <= time
        {
            self.commit();
            self.change_mode(event);
            self.plan();
        }
    }

    /// State at `time`, s; between the last event and the time advanced to.
    #[must_use]
    pub(crate) fn at(&self, time: f64) -> State {
        self.motion.at(time - self.time)
    }

    /// Position alone, m, at a time as in [`Ram::at`].
    #[must_use]
    pub(crate) fn position(&self, time: f64) -> f64 {
        self.motion.position(time - self.time)
    }

    /// Appends the position at `time`, the same as [`Ram::position`], and at later times `interval` s apart. Sampling stops at the end of the present
    /// segment, and after `count` values.
    pub(crate) fn sample(&self, time: f64, interval: f64, count: usize, positions: &mut Vec<f64>) {
        let within = ((self.ends - time) / interval).ceil() as usize;
        self.motion.sample(
            time - self.time,
            interval,
            within.clamp(1, count),
            positions,
        );
    }

    /// Finds the end of the segment that begins now.
    fn plan(&mut self) {
        self.motion = ClosedForm::new(&self.constants, self.mode, self.flow, self.state);
        let horizon = self.piece_ends - self.time;
        let (constants, motion) = (&self.constants, &self.motion);
        let steps = &mut self.steps_left;
        let next = match self.events_left {
            0 => None,
            _ => next_event(constants, self.mode, self.flow, motion, horizon, steps),
        };
        self.events_left = self.events_left.saturating_sub(1);
        // What is unsolved is not searched any more.
        self.unsolved |= self.steps_left == 0 || self.events_left == 0;
        if self.unsolved {
            self.events_left = 0;
        }
        (self.ends, self.event) = match next {
            Some((t, event)) => (self.time + t, Some(event)),
            None => (self.piece_ends, None),
        };
    }

    /// Moves to the end of the segment. The next segment must be planned afterwards.
    fn commit(&mut self) {
        let state = self.at(self.ends);
        if let Some(ledger) = &mut self.ledger {
            let t = self.ends - self.time;
            ledger.book(self.mode, &self.motion, &self.state, &state, t);
        }
        self.slid += (state.position - self.state.position).abs();
        self.state = state;
        self.time = self.ends;
    }

    /// Applies an event: sets its state exactly and changes the mode.
    fn change_mode(&mut self, event: Event) {
        match event {
            Event::Halt => {
                self.state.velocity = 0.0;
                self.mode.friction = self.at_rest(None);
            }
            Event::BreakAway(side) => self.mode.friction = FrictionState::Sliding(side),
            Event::ClampOn(side) => self.mode.clamped = Some(side),
            Event::ClampOff => self.mode.clamped = None,
            Event::VolumeLimit(side) => {
                self.state.volume = side.sign() * self.constants.volume_limit;
                self.mode.limited = Some(side);
            }
            Event::VolumeRelease => self.mode.limited = None,
            Event::Stop(side) => {
                if let Some(ledger) = &mut self.ledger {
                    ledger.hit_stop(self.state.velocity);
                }
                self.state.position = side.sign() * self.constants.stop;
                self.state.velocity = 0.0;
                self.mode.friction = self.at_rest(Some(side));
            }
        }
    }

    /// Determines the mode of the state after a change of constants.
    fn reconsider(&mut self) {
        let side = Side::from_sign(self.state.squeezed);
        let unclamped = self.constants.stiffness * self.state.squeezed.abs();
        self.mode.clamped = (unclamped > self.constants.clamp(side)).then_some(side);
        self.mode.friction = match self.mode.friction {
            FrictionState::Stuck => self.at_rest(None),
            FrictionState::AtStop(stop) => self.at_rest(Some(stop)),
            sliding @ FrictionState::Sliding(_) => sliding,
        };
    }

    /// Friction state of a load without speed: it slides if the pressure overcomes friction, otherwise it is stuck. A stop removes all of the load's
    /// speed and supports the load.
    fn at_rest(&self, stop: Option<Side>) -> FrictionState {
        let force = self.constants.area * self.pressure(&self.state);
        let side = Side::from_sign(force);
        let breaks_away = force.abs() > break_away_force(&self.constants);
        match stop {
            Some(stop) if !breaks_away || side == stop => FrictionState::AtStop(stop),
            None if !breaks_away => FrictionState::Stuck,
            _ => FrictionState::Sliding(side),
        }
    }
}
