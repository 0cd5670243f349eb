//! Plans the next stretch of motion: a step as long as its error allows, up to the first event.

use planesman_linear::{first_below_zero, lowest_point};

use super::{Event, MOST_FORCED, Mode, SHORTEST, STATES, Simulation, Stretch};

/// The largest allowed size of a line's last wave coefficients over a step, as a multiple of a step's largest error.
const TAIL: f64 = 1.0;

impl Simulation {
    /// The largest error over its scale; NaN if one is NaN.
    fn largest_error(&self, errors: &[f64; STATES]) -> f64 {
        let scaled = errors.iter().zip(&self.scales);
        let scaled = scaled.map(|(error, scale)| (error / scale).abs());
        scaled.fold(0.0, |one: f64, other| match other > one || other.is_nan() {
            true => other,
            false => one,
        })
    }

    /// The next stretch, at most up to `limit`.
    pub(super) fn plan(&mut self, limit: f64) -> Stretch {
        let mut limit = limit;
        self.line_steps.clear();
        for line in self.lines.iter_mut().filter(|line| line.is_open()) {
            line.stay_closed(self.time);
            limit = limit.min(line.look_back(self.time));
        }
        let horizon = limit - self.time;
        let sliding = matches!(self.mode, Mode::Sliding(_));
        let longest = if sliding { self.longest } else { f64::INFINITY };
        let mut h = self.step.min(longest).min(horizon);
        let mut most = 4.0;
        // What is left of the horizon is not worth a step of its own.
        if horizon - h < 1e-3 * h {
            h = horizon;
        }
        let after = loop {
            let dense = self.dense(h);
            let (after, errors) = match &dense {
                Some(dense) => (dense.after, dense.error),
                None => self.stepped(h),
            };
            let mut error = self.largest_error(&errors) / self.accuracy;
            if let Some(dense) = &dense
                && (error <= 1.0 || h <= SHORTEST)
            {
                self.line_steps = self.line_steps_along(h, dense);
                let tails = self.line_steps.iter().map(|(_, step)| step.tail());
                let most = TAIL * self.accuracy * self.scales[2];
                error = tails.fold(error, |error, tail| error.max(tail / most));
            }
            let factor = (0.9 / error.max(1e-12).sqrt().sqrt().sqrt()).clamp(0.2, most);
            if error <= 1.0 || h <= SHORTEST {
                self.forced += u32::from(error > 1.0);
                self.unsolved |= error.is_nan() || self.forced > MOST_FORCED;
                // A step cut short by the horizon says nothing against longer ones.
                self.step = if h < self.step {
                    self.step.max(h * factor)
                } else {
                    h * factor
                };
                break after;
            }
            // What has just been too long is not tried again at once.
            most = 1.0;
            let factor = if error.is_finite() {
                factor.min(0.8)
            } else {
                0.2
            };
            h = (h * factor).max(SHORTEST.min(horizon));
            self.step = h;
        };
        let end = if h == horizon { limit } else { self.time + h };
        let begin_rates = self.rates(self.time, &self.row);
        let end_rates = self.rates(self.time + h, &after);
        let slopes = |end: &[f64; STATES]| [[begin_rates[2], begin_rates[3]], [end[2], end[3]]];
        let mut stretch = Stretch {
            end,
            after,
            slopes: slopes(&end_rates),
            event: None,
        };
        for event in self.possible() {
            let begin = self.margin(event, self.time, &self.row, &begin_rates);
            let end = self.margin(event, self.time + h, &after, &end_rates);
            let until = if end.0 < 0.0 {
                h
            } else if may_touch(begin, end, h) {
                let lowest = lowest_point(0.0, h, |h| self.margin_after(event, h));
                if self.margin_after(event, lowest).0 >= 0.0 {
                    continue;
                }
                lowest
            } else {
                continue;
            };
            let at = self.zero(event, until, begin);
            if self.time + at < stretch.end
                || (stretch.event.is_none() && self.time + at <= stretch.end)
            {
                let (end, after) = (self.time + at, self.stepped(at).0);
                stretch = Stretch {
                    end,
                    after,
                    slopes: slopes(&self.rates(end, &after)),
                    event: Some(event),
                };
            }
        }
        if stretch.event.is_some() && !self.lines.is_empty() {
            self.line_steps = self.line_steps(stretch.end - self.time);
        }
        stretch
    }

    /// The events that can end this mode.
    fn possible(&self) -> impl Iterator<Item = Event> + use<> {
        let load = &self.circuit.load;
        let mut events = [None; 5];
        match self.mode {
            Mode::Stuck => {
                events[0] = Some(Event::BreakAway(1.0));
                events[1] = Some(Event::BreakAway(-1.0));
            }
            Mode::AtStop(side) => events[0] = Some(Event::Release(side)),
            Mode::Sliding(sign) => {
                if load.coulomb > 0.0 {
                    events[0] = Some(Event::Halt(sign));
                }
                match (load.elastic_stop, self.contact) {
                    (None, _) => {
                        events[1] = Some(Event::Stop(1.0));
                        events[2] = Some(Event::Stop(-1.0));
                    }
                    (Some(_), None) => {
                        events[1] = Some(Event::ContactOn(1.0));
                        events[2] = Some(Event::ContactOn(-1.0));
                    }
                    (Some(_), Some(side)) => events[1] = Some(Event::ContactOff(side)),
                }
            }
        }
        events.into_iter().flatten()
    }

    /// An event's margin, positive before the event, and the margin's rate.
    fn margin(
        &self,
        event: Event,
        time: f64,
        row: &[f64; STATES],
        rates: &[f64; STATES],
    ) -> (f64, f64) {
        let travel = self.circuit.load.travel;
        let [a, b] = self.circuit.areas();
        let net = || self.net(time, row);
        let net_rate =
            || rates[2] * a + rates[3] * b - self.circuit.load.spring * row[1] - self.force.rate;
        let held = self.circuit.break_away();
        match event {
            Event::Halt(sign) => (sign * row[1], sign * rates[1]),
            Event::BreakAway(sign) => (held - sign * net(), -sign * net_rate()),
            // On a stop without friction a hair of force lifts the ram.
            Event::Release(side) => (
                held.max(1e-9 * a * self.scales[2]) + side * net(),
                side * net_rate(),
            ),
            Event::Stop(side) | Event::ContactOn(side) => (travel - side * row[0], -side * row[1]),
            Event::ContactOff(side) => (side * row[0] - travel, side * row[1]),
        }
    }

    fn margin_after(&self, event: Event, h: f64) -> (f64, f64) {
        let row = self.stepped(h).0;
        let rates = self.rates(self.time + h, &row);
        self.margin(event, self.time + h, &row, &rates)
    }

    /// The time at which a margin is zero: it is `begin` with its rate here, and below zero at `until`.
    fn zero(&self, event: Event, until: f64, begin: (f64, f64)) -> f64 {
        let margin = |h| self.margin_after(event, h);
        let (mut low, mut high) = (0.0, until);
        if begin.0 <= 0.0 {
            if begin.1 <= 0.0 {
                return 0.0;
            }
            // It starts at zero and rises: the zero is a later one.
            for _ in 0..60 {
                low = 0.5 * high;
                if margin(low).0 > 0.0 {
                    break;
                }
                high = low;
            }
        }
        first_below_zero(low, high, margin)
    }
}

/// Whether a margin that falls from `begin` and rises to `end` (values with their rates) may be below zero in between: the intersection of
/// the two tangents is below any convex curve.
fn may_touch(begin: (f64, f64), end: (f64, f64), h: f64) -> bool {
    if begin.1 >= 0.0 || end.1 <= 0.0 {
        return false;
    }
    let meet = (begin.0 - end.0 + end.1 * h) / (end.1 - begin.1);
    begin.0 + begin.1 * meet.clamp(0.0, h) < 0.0
}
