//! Closed-form motion of the ram within one mode, exact for any length of time ([`crate::modes`] has the equations).

use crate::modes::{Constants, FrictionState, Mode, Side, State};

/// A quantity of the ram that a limit or an event monitors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// X_1, m.
    Position,
    /// X_1', m/s.
    Speed,
    /// V_e, m^3.
    Oil,
    /// V_T, m^3.
    Volume,
}

/// Times of a quantity's turning points: `first` (s from the start), then every `interval`; infinite if there are no turning points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turns {
    /// Time of the first turning point.
    pub first: f64,
    /// Time between two turning points.
    pub interval: f64,
}

impl Turns {
    const NONE: Self = Self {
        first: f64::INFINITY,
        interval: f64::INFINITY,
    };

    /// A single turning point, if `time` is in the future.
    fn once(time: f64) -> Self {
        Self {
            first: if time > 0.0 { time } else { f64::INFINITY },
            ..Self::NONE
        }
    }
}

/// Time integrals of a motion, for its energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Integrals {
    /// Of V_e, m^3 s.
    pub squeezed: f64,
    /// Of V_e^2, m^6 s.
    pub squeezed_squared: f64,
    /// Of v^2, m^2/s.
    pub velocity_squared: f64,
}

/// Motion within one mode at constant flow, from its initial state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClosedForm {
    start: State,
    area: f64,
    limited: bool,
    law: Law,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// v = 0, V_e' = q - a V_e, with net flow q and leakage rate a.
    Stuck { flow: f64, leakage_rate: f64 },
    /// v' = g - c v, V_e' = q - A_L v at clamped pressure: g is the driving acceleration minus friction, c the viscous rate.
    Clamped {
        flow: f64,
        drive: f64,
        viscous_rate: f64,
    },
    /// V_e' = q - a V_e - A_L v, v' = b V_e - c v - f: the load slides on compressible oil.
    CompressibleSliding(CompressibleSliding),
}

/// Second-order equations about the equilibrium. The characteristic roots are mu +- sqrt(spread).
///
/// The energy dv^2 + (b/A_L) dV_e^2 of the deviation from equilibrium never grows, since its rate is -2 c dv^2 - 2 a (b/A_L) dV_e^2. So
/// |dv| + sqrt(b/A_L) |dV_e| at the start is an upper bound for each deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CompressibleSliding {
    /// q, m^3/s: net metered flow.
    flow: f64,
    /// a = k beta/V, 1/s: decay rate of the squeezed oil due to leakage.
    leakage_rate: f64,
    /// b = A_L beta/(V M), 1/(m^2 s^2): acceleration per squeezed volume.
    acceleration_per_oil: f64,
    /// c = C/M, 1/s.
    viscous_rate: f64,
    /// f = s Delta F/M, m/s^2: deceleration by friction, against the direction s.
    friction: f64,
    /// -(a + c)/2, 1/s.
    mu: f64,
    /// ((a - c)/2)^2 - A_L b, 1/s^2.
    spread: f64,
    /// Square root of its magnitude, 1/s.
    root: f64,
    /// 1/root.
    time: f64,
    /// For real roots: the root nearer to 0, computed from the product of both roots, because `mu + root` would lose digits at strong damping.
    slow: f64,
    /// a/b, m^2 s.
    leakage_over_acceleration: f64,
    /// 1/(A_L + a c/b).
    per_area: f64,
    steady_squeezed: f64,
    steady_velocity: f64,
    squeezed_reach: f64,
    velocity_reach: f64,
}

impl ClosedForm {
    /// Returns the motion from `start` in `mode` at the net metered flow `flow`, m^3/s.
    #[must_use]
    pub(crate) fn new(constants: &Constants, mode: Mode, flow: f64, start: State) -> Self {
        let limited = mode.limited.is_some();
        let (flow, leakage) = if limited {
            (0.0, 0.0)
        } else {
            (flow, constants.leakage)
        };
        let held_pressure = mode.clamped.map(|side| side.sign() * constants.clamp(side));
        let law = match (mode.friction, held_pressure) {
            (FrictionState::Stuck | FrictionState::AtStop(_), None) => Law::Stuck {
                flow,
                leakage_rate: leakage * constants.stiffness,
            },
            (FrictionState::Stuck | FrictionState::AtStop(_), Some(pressure)) => Law::Stuck {
                flow: flow - leakage * pressure,
                leakage_rate: 0.0,
            },
            (FrictionState::Sliding(side), Some(pressure)) => Law::Clamped {
                flow: flow - leakage * pressure,
                drive: (constants.area * pressure - side.sign() * constants.coulomb)
                    / constants.mass,
                viscous_rate: constants.viscous / constants.mass,
            },
            (FrictionState::Sliding(side), None) => Law::CompressibleSliding(
                CompressibleSliding::new(constants, flow, leakage, side, &start),
            ),
        };
        Self {
            start,
            area: constants.area,
            limited,
            law,
        }
    }

    /// The state `t` seconds after the start.
    #[must_use]
    pub(crate) fn at(&self, t: f64) -> State {
        let start = &self.start;
        let (moved, velocity, squeezed_by) = match &self.law {
            Law::Stuck { flow, leakage_rate } => (
                0.0,
                0.0,
                (flow - leakage_rate * start.squeezed) * decayed(*leakage_rate, t),
            ),
            Law::Clamped {
                flow,
                drive,
                viscous_rate,
            } => {
                let final_velocity = drive / viscous_rate;
                let velocity_change =
                    (drive - viscous_rate * start.velocity) * decayed(*viscous_rate, t);
                // x' = v and v' = g - c v give x = v_final t - (v - v_0)/c.
                let moved = final_velocity * t - velocity_change / viscous_rate;
                (
                    moved,
                    start.velocity + velocity_change,
                    flow * t - self.area * moved,
                )
            }
            Law::CompressibleSliding(law) => law.after(t, start, self.area),
        };
        State {
            position: start.position + moved,
            velocity,
            squeezed: start.squeezed + squeezed_by,
            volume: if self.limited {
                start.volume
            } else {
                start.volume + (squeezed_by + self.area * moved)
            },
        }
    }

    /// Position, m, the same as in [`ClosedForm::at`]; needs no computation while the load is stuck.
    #[must_use]
    pub(crate) fn position(&self, t: f64) -> f64 {
        match &self.law {
            // Nothing is moved; the sum is that of `at`, also in the sign of 0.
            Law::Stuck { .. } => self.start.position + 0.0,
            Law::Clamped { .. } | Law::CompressibleSliding(_) => self.at(t).position,
        }
    }

    /// Appends `count` positions, m, at `from` and then every `interval` s. The samples equal [`ClosedForm::position`] except for rounding; each
    /// follows from the previous one by a transition.
    pub(crate) fn sample(&self, from: f64, interval: f64, count: usize, positions: &mut Vec<f64>) {
        let time = |i: usize| from + i as f64 * interval;
        match &self.law {
            Law::CompressibleSliding(law) => {
                let begin = law.deviations(&self.start);
                let transition = law.transition(interval, self.area);
                let mut now = times(&law.transition(from, self.area), begin);
                positions.extend((0..count).map(|i| {
                    let moved = law.moved(time(i), begin, now);
                    now = times(&transition, now);
                    self.start.position + moved
                }));
            }
            Law::Stuck { .. } | Law::Clamped { .. } => {
                positions.extend((0..count).map(|i| self.position(time(i))));
            }
        }
    }

    /// Derivatives `(v', V_e')` in a state of this motion, m/s^2 and m^3/s.
    #[must_use]
    pub(crate) fn rates(&self, state: &State) -> (f64, f64) {
        let (v, w) = (state.velocity, state.squeezed);
        match &self.law {
            Law::Stuck { flow, leakage_rate } => (0.0, flow - leakage_rate * w),
            Law::Clamped {
                flow,
                drive,
                viscous_rate,
            } => (drive - viscous_rate * v, flow - self.area * v),
            Law::CompressibleSliding(law) => (
                law.acceleration_per_oil * w - law.viscous_rate * v - law.friction,
                law.flow - law.leakage_rate * w - self.area * v,
            ),
        }
    }

    /// Value and rate of change of a quantity `t` seconds after the start, SI.
    #[must_use]
    pub(crate) fn value_and_rate(&self, quantity: Quantity, t: f64) -> (f64, f64) {
        self.value_and_rate_in(quantity, &self.at(t))
    }

    /// [`ClosedForm::value_and_rate`] at the start of the motion.
    #[must_use]
    pub(crate) fn value_and_rate_at_start(&self, quantity: Quantity) -> (f64, f64) {
        self.value_and_rate_in(quantity, &self.start)
    }

    fn value_and_rate_in(&self, quantity: Quantity, state: &State) -> (f64, f64) {
        let (v_dot, w_dot) = self.rates(state);
        match quantity {
            Quantity::Position => (state.position, state.velocity),
            Quantity::Speed => (state.velocity, v_dot),
            Quantity::Oil => (state.squeezed, w_dot),
            Quantity::Volume if self.limited => (state.volume, 0.0),
            Quantity::Volume => (state.volume, w_dot + self.area * state.velocity),
        }
    }

    /// Lower and upper bound of a quantity for `horizon` seconds: fast, but not tight.
    #[must_use]
    pub(crate) fn range(&self, quantity: Quantity, horizon: f64) -> (f64, f64) {
        let start = &self.start;
        // The highest speed and the most that V_T changes in a second, then V_e's range.
        let (speeds, volume_rate, oil) = match &self.law {
            Law::Stuck { flow, leakage_rate } => {
                let rate = flow - leakage_rate * start.squeezed;
                let furthest = start.squeezed + rate * horizon;
                ((0.0, 0.0), rate.abs(), (start.squeezed, furthest))
            }
            Law::Clamped {
                flow,
                drive,
                viscous_rate,
            } => {
                let speeds = (start.velocity, drive / viscous_rate);
                let fastest = start.velocity.abs().max(speeds.1.abs());
                let oil = (flow.abs() + self.area * fastest) * horizon;
                let oil = (start.squeezed - oil, start.squeezed + oil);
                (speeds, flow.abs(), oil)
            }
            Law::CompressibleSliding(law) => {
                let (v, v_reach) = (law.steady_velocity, law.velocity_reach);
                let (w, w_reach) = (law.steady_squeezed, law.squeezed_reach);
                let volume_rate = law.flow.abs() + law.leakage_rate * (w.abs() + w_reach);
                let oil = (w - w_reach, w + w_reach);
                ((v - v_reach, v + v_reach), volume_rate, oil)
            }
        };
        let about = |value: f64, rate: f64| (value - rate * horizon, value + rate * horizon);
        match quantity {
            Quantity::Speed => speeds,
            Quantity::Oil => oil,
            Quantity::Position => about(start.position, speeds.0.abs().max(speeds.1.abs())),
            Quantity::Volume => about(start.volume, volume_rate),
        }
    }

    /// Turning points of a quantity in closed form; `None` for position and volume of a load in compressible sliding.
    #[must_use]
    pub(crate) fn turns(&self, quantity: Quantity) -> Option<Turns> {
        let start = &self.start;
        match (&self.law, quantity) {
            (Law::Stuck { .. }, _) | (Law::Clamped { .. }, Quantity::Speed | Quantity::Volume) => {
                Some(Turns::NONE)
            }
            // Where the speed, on its way from v_0 to g/c, passes 0 or q/A_L.
            (
                Law::Clamped {
                    flow,
                    drive,
                    viscous_rate,
                },
                Quantity::Position | Quantity::Oil,
            ) => {
                let passes = match quantity {
                    Quantity::Oil => flow / self.area,
                    _ => 0.0,
                };
                let left =
                    (drive / viscous_rate - passes) / (drive / viscous_rate - start.velocity);
                Some(Turns::once(-libm::log(left) / viscous_rate))
            }
            (Law::CompressibleSliding(law), Quantity::Speed | Quantity::Oil) => {
                let (v_dot, w_dot) = self.rates(start);
                let (v_dot_dot, w_dot_dot) = (
                    law.acceleration_per_oil * w_dot - law.viscous_rate * v_dot,
                    -law.leakage_rate * w_dot - self.area * v_dot,
                );
                Some(match quantity {
                    Quantity::Oil => law.turns(w_dot, w_dot_dot),
                    _ => law.turns(v_dot, v_dot_dot),
                })
            }
            (Law::CompressibleSliding(_), Quantity::Position | Quantity::Volume) => None,
        }
    }

    /// Times between 0 and `t` at which a quantity turns; `end` is the state at `t`.
    pub(crate) fn turns_within(
        &self,
        quantity: Quantity,
        t: f64,
        end: &State,
    ) -> impl Iterator<Item = f64> + use<> {
        let (before, after) = (
            self.value_and_rate_at_start(quantity).1,
            self.value_and_rate_in(quantity, end).1,
        );
        let swings = match &self.law {
            Law::CompressibleSliding(law) => law.spread < 0.0 && t * law.root > 3.0,
            Law::Stuck { .. } | Law::Clamped { .. } => false,
        };
        // Rates of one sign: it has not turned, or twice.
        let turns = if before * after < 0.0 || swings {
            self.turns(quantity)
        } else {
            None
        };
        let turns = turns.unwrap_or(Turns::NONE);
        std::iter::successors(Some(turns.first), move |last| Some(last + turns.interval))
            .take_while(move |time| *time < t)
            .take(MOST_TURNS)
    }

    /// Integrals over the first `t` seconds; `end` is the state at `t`.
    #[must_use]
    pub(crate) fn integrals(&self, t: f64, end: &State) -> Integrals {
        let start = &self.start;
        // Of x' = rate - decay x, by x - x_0 = (rate - decay x_0) d(t): the integrals of x and of x^2.
        let of_decay = |x: f64, rate: f64, decay: f64| {
            let slope = rate - decay * x;
            let [first, second] = decay_integrals(decay, t);
            (
                x * t + slope * first,
                x * x * t + slope * (2.0 * x * first + slope * second),
            )
        };
        match &self.law {
            Law::Stuck { flow, leakage_rate } => {
                let (squeezed, squeezed_squared) = of_decay(start.squeezed, *flow, *leakage_rate);
                Integrals {
                    squeezed,
                    squeezed_squared,
                    velocity_squared: 0.0,
                }
            }
            // The pressure is the clamp's, whatever V_e is.
            Law::Clamped {
                drive,
                viscous_rate,
                ..
            } => Integrals {
                squeezed: 0.0,
                squeezed_squared: 0.0,
                velocity_squared: of_decay(start.velocity, *drive, *viscous_rate).1,
            },
            Law::CompressibleSliding(law) => law.integrals(t, start, end, self.area),
        }
    }

    /// A time, s, much shorter than all time constants of this motion.
    #[must_use]
    pub(crate) fn short_time(&self) -> f64 {
        match &self.law {
            Law::CompressibleSliding(law) => {
                0.5 / (law.leakage_rate * law.viscous_rate + self.area * law.acceleration_per_oil)
                    .sqrt()
            }
            Law::Stuck { .. } | Law::Clamped { .. } => f64::INFINITY,
        }
    }
}

impl CompressibleSliding {
    /// Equations of a load that slides to `side` at the net flow `q`, with leakage `k`.
    fn new(constants: &Constants, flow: f64, leakage: f64, side: Side, start: &State) -> Self {
        let leakage_rate = leakage * constants.stiffness;
        let acceleration_per_oil = constants.area * constants.stiffness / constants.mass;
        let viscous_rate = constants.viscous / constants.mass;
        let friction = side.sign() * constants.coulomb / constants.mass;
        let half = 0.5 * (leakage_rate - viscous_rate);
        let spread = half * half - constants.area * acceleration_per_oil;
        let leakage_over_acceleration = leakage_rate / acceleration_per_oil;
        let per_area = 1.0 / (constants.area + leakage_over_acceleration * viscous_rate);
        let steady_velocity = (flow - leakage_over_acceleration * friction) * per_area;
        let steady_squeezed = (friction + viscous_rate * steady_velocity) / acceleration_per_oil;
        let (dv, dw) = (
            start.velocity - steady_velocity,
            start.squeezed - steady_squeezed,
        );
        let root = spread.abs().sqrt();
        let mu = -0.5 * (leakage_rate + viscous_rate);
        let product = leakage_rate * viscous_rate + constants.area * acceleration_per_oil;
        let velocity_per_oil = (constants.stiffness / constants.mass).sqrt();
        let velocity_reach = dv.abs() + velocity_per_oil * dw.abs();
        Self {
            flow,
            leakage_rate,
            acceleration_per_oil,
            viscous_rate,
            friction,
            mu,
            spread,
            root,
            time: 1.0 / root,
            slow: product / (mu - root),
            leakage_over_acceleration,
            per_area,
            steady_squeezed,
            steady_velocity,
            squeezed_reach: velocity_reach / velocity_per_oil,
            velocity_reach,
        }
    }

    /// `(x - x_0, v, V_e - V_e0)` after `t`.
    fn after(&self, t: f64, start: &State, area: f64) -> (f64, f64, f64) {
        let before = self.deviations(start);
        let after = times(&self.transition(t, area), before);
        let moved = self.moved(t, before, after);
        (moved, self.steady_velocity + after[1], after[0] - before[0])
    }

    /// Computes the integrals of [`ClosedForm::integrals`]. The deviation after t is even d + odd n, where d is the deviation at the start and n = (A -
    /// mu I) d. Its square needs the integrals of even^2, even odd and odd^2.
    fn integrals(&self, t: f64, start: &State, end: &State, area: f64) -> Integrals {
        let [dw, dv] = self.deviations(start);
        let half = 0.5 * (self.viscous_rate - self.leakage_rate);
        let (nw, nv) = (
            half * dw - area * dv,
            self.acceleration_per_oil * dw - half * dv,
        );
        let settled = dw.abs() < SETTLED * self.steady_squeezed.abs()
            && dv.abs() < SETTLED * self.steady_velocity.abs();
        let [even, mixed, odd] = if settled {
            [0.0; 3]
        } else {
            self.square_integrals(t, half)
        };
        let square = |d: f64, n: f64| d * d * even + n * (2.0 * d * mixed + n * odd);
        let moved = end.position - start.position;
        // M v' = A_L P_d - C v - s Delta F over t.
        let squeezed =
            (end.velocity - start.velocity + self.viscous_rate * moved + self.friction * t)
                / self.acceleration_per_oil;
        // (x_s + d)^2 = x_s (2 x - x_s) + d^2.
        let of = |steady: f64, integral: f64, squared: f64| {
            steady * (2.0 * integral - steady * t) + squared
        };
        Integrals {
            squeezed,
            squeezed_squared: of(self.steady_squeezed, squeezed, square(dw, nw)),
            velocity_squared: of(self.steady_velocity, moved, square(dv, nv)),
        }
    }

    /// The integrals of even^2, even odd and odd^2 of [`CompressibleSliding::exponentials`] from 0 to t:
    ///
    /// ```text
    /// even^2 = e^(s t) (1 + cosh z t)/2    even odd = e^(s t) sinh(z t)/z    odd^2 = 2 e^(s t) (cosh(z t) - 1)/z^2
    /// ```
    ///
    /// with s = 2 mu and z = 2 r. Near critical damping, where z is much smaller than s, a power series in z^2 is used.
    fn square_integrals(&self, t: f64, half: f64) -> [f64; 3] {
        let (s, z) = (2.0 * self.mu, 2.0 * self.root);
        let whole = decayed(-s, t);
        let decay = 1.0 + s * whole;
        let z_squared = 4.0 * self.spread;
        if self.spread.abs() > NEAR_CRITICAL * half * half {
            let (cosh, sinh) = if self.spread < 0.0 {
                let (sine, cosine) = libm::sincos(z * t);
                let over = 1.0 / (s * s + z * z);
                (
                    over * (decay * (s * cosine + z * sine) - s),
                    over * (decay * (s * sine - z * cosine) + z),
                )
            } else {
                let (slow, fast) = (decayed(-2.0 * self.slow, t), decayed(z - s, t));
                (0.5 * (slow + fast), 0.5 * (slow - fast))
            };
            let odd = 2.0 * (cosh - whole) / z_squared;
            return [0.5 * (whole + cosh), sinh / z, odd];
        }
        // Of e^(s t) t^k/k!, each by parts from the one before, two at a time.
        let per_s = 1.0 / s;
        let (mut moment, mut power, mut weight) = (whole, decay, 1.0);
        let [mut cosh, mut sinh, mut cosh_less_one] = [whole, 0.0, 0.0];
        for [of_odd, of_even] in RECIPROCALS {
            power *= t * of_odd;
            moment = (power - moment) * per_s;
            sinh += weight * moment;
            power *= t * of_even;
            moment = (power - moment) * per_s;
            cosh_less_one += weight * moment;
            weight *= z_squared;
            cosh += weight * moment;
        }
        [0.5 * (whole + cosh), sinh, 2.0 * cosh_less_one]
    }

    /// Deviations of `V_e` and v from the equilibrium.
    fn deviations(&self, state: &State) -> [f64; 2] {
        [
            state.squeezed - self.steady_squeezed,
            state.velocity - self.steady_velocity,
        ]
    }

    /// Transition matrix of the deviations over a time `t`: exp(A t) = even I + odd (A - mu I), with A = [[-a, -A_L], [b, -c]].
    fn transition(&self, t: f64, area: f64) -> [[f64; 2]; 2] {
        let (even, odd) = self.exponentials(t);
        let half = 0.5 * (self.viscous_rate - self.leakage_rate);
        [
            [even + half * odd, -(area * odd)],
            [self.acceleration_per_oil * odd, even - half * odd],
        ]
    }

    /// x - x_0 after `t` from the deviations before and after: both equations are integrated over t, and the integral of `V_e` is
    /// eliminated.
    fn moved(&self, t: f64, before: [f64; 2], after: [f64; 2]) -> f64 {
        let [squeezed_by, velocity_change] = [after[0] - before[0], after[1] - before[1]];
        (self.flow * t
            - self.leakage_over_acceleration * (velocity_change + self.friction * t)
            - squeezed_by)
            * self.per_area
    }

    /// Turning points of a quantity, from its initial rate and that rate's derivative: e^(mu t) (rate cosh(r t) + (rate' - mu rate) sinh(r
    /// t)/r) = 0 with r^2 = spread.
    fn turns(&self, rate: f64, rate_dot: f64) -> Turns {
        let odd = rate_dot - self.mu * rate;
        if self.root == 0.0 {
            Turns::once(-rate / odd)
        } else if self.spread > 0.0 {
            Turns::once(libm::atanh(-rate * self.root / odd) / self.root)
        } else {
            // The angle of (-odd/r, rate), within (0, pi].
            let (y, x) = (rate, -odd / self.root);
            let angle = if y < 0.0 {
                libm::atan2(-y, -x)
            } else {
                libm::atan2(y, x)
            };
            let half_turn = std::f64::consts::PI;
            Turns {
                first: if angle > 0.0 { angle } else { half_turn } / self.root,
                interval: half_turn / self.root,
            }
        }
    }

    /// e^(mu t) times cosh(r t) and sinh(r t)/r, with r^2 = spread; cos and sin for complex roots, 1 and t for equal roots.
    fn exponentials(&self, t: f64) -> (f64, f64) {
        let angle = self.root * t;
        if angle < 1e-3 {
            let z = self.spread * t * t;
            let decay = libm::exp(self.mu * t);
            let even = 1.0 + z / 2.0 * (1.0 + z / 12.0);
            let odd = t * (1.0 + z / 6.0 * (1.0 + z / 20.0));
            (decay * even, decay * odd)
        } else if self.spread < 0.0 {
            let decay = libm::exp(self.mu * t);
            let (sine, cosine) = libm::sincos(angle);
            (decay * cosine, decay * sine * self.time)
        } else {
            let slow = libm::exp(self.slow * t);
            let fast = libm::exp((self.mu - self.root) * t);
            (0.5 * (slow + fast), 0.5 * (slow - fast) * self.time)
        }
    }
}

fn times(matrix: &[[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    matrix.map(|row| row[0] * x + row[1] * y)
}

/// Largest number of turning points considered within one motion; later turning points are ignored.
const MOST_TURNS: usize = 64;

/// |r^2| relative to ((a - c)/2)^2 below which the integrals use a series; rounding costs 1e-13 there.
const NEAR_CRITICAL: f64 = 1e-3;

/// 1/k for the powers k of t in that series; its truncation error is (r/mu)^10.
const RECIPROCALS: [[f64; 2]; 5] = [
    [1.0, 1.0 / 2.0],
    [1.0 / 3.0, 1.0 / 4.0],
    [1.0 / 5.0, 1.0 / 6.0],
    [1.0 / 7.0, 1.0 / 8.0],
    [1.0 / 9.0, 1.0 / 10.0],
];

/// Relative deviation from a steady motion below which its square is only rounding error.
const SETTLED: f64 = 1e-7;

/// Integrals of d(t) = [`decayed`] and of its square from 0 to t, s^2 and s^3.
fn decay_integrals(rate: f64, t: f64) -> [f64; 2] {
    let z = rate * t;
    if z > 0.03 {
        let (once, twice) = (decayed(rate, t), decayed(2.0 * rate, t));
        return [(t - once) / rate, (t - 2.0 * once + twice) / (rate * rate)];
    }
    // The sums of (-z)^n/(n + 2)! and of (-z)^n (2^(n + 2) - 2)/(n + 3)!.
    let (mut first, mut second) = (0.0, 0.0);
    for [of_first, of_second] in DECAY_SERIES.iter().rev() {
        first = of_first - z * first;
        second = of_second - z * second;
    }
    [t * t * first, t * t * t * second]
}

/// 1/(n + 2)! and (2^(n + 2) - 2)/(n + 3)!.
const DECAY_SERIES: [[f64; 2]; 8] = [
    [1.0 / 2.0, 2.0 / 6.0],
    [1.0 / 6.0, 6.0 / 24.0],
    [1.0 / 24.0, 14.0 / 120.0],
    [1.0 / 120.0, 30.0 / 720.0],
    [1.0 / 720.0, 62.0 / 5040.0],
    [1.0 / 5040.0, 126.0 / 40_320.0],
    [1.0 / 40_320.0, 254.0 / 362_880.0],
    [1.0 / 362_880.0, 510.0 / 3_628_800.0],
];

/// (1 - e^(-rate t))/rate, s.
fn decayed(rate: f64, t: f64) -> f64 {
    if rate == 0.0 {
        t
    } else {
        -libm::expm1(-rate * t) / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;

    fn constants(name: &str) -> Constants {
        Constants::new(&load(name).expect("built in"))
    }

    fn modes() -> Vec<Mode> {
        let mut modes = Vec::new();
        for friction in [
            FrictionState::Stuck,
            FrictionState::Sliding(Side::Positive),
            FrictionState::Sliding(Side::Negative),
        ] {
            for clamped in [None, Some(Side::Positive), Some(Side::Negative)] {
                for limited in [None, Some(Side::Positive)] {
                    modes.push(Mode {
                        friction,
                        clamped,
                        limited,
                    });
                }
            }
        }
        modes
    }

    fn some_state(c: &Constants) -> State {
        let position = 0.1 * 0.0254;
        let squeezed = 0.4 * c.clamp_positive / c.stiffness;
        State {
            position,
            velocity: 0.02,
            squeezed,
            volume: squeezed + c.area * position,
        }
    }

    #[test]
    fn the_closed_forms_satisfy_their_differential_equations() {
        for name in ["auv", "table_3_1", "table_4_1"] {
            for damping in [0.3, 1.0, 1.000_001, 4.0] {
                let mut c = constants(name);
                c.viscous *= damping;
                for mode in modes() {
                    let mut start = some_state(&c);
                    if mode.friction == FrictionState::Stuck {
                        start.velocity = 0.0;
                    }
                    let motion = ClosedForm::new(&c, mode, 1e-8, start);
                    // Fourth-order central difference of x, v and V_e against their rates.
                    let (t, h) = (1.3e-3, 1e-5);
                    let [s1, s2, s3, s4] = [-2.0, -1.0, 1.0, 2.0].map(|j| motion.at(t + j * h));
                    let rate = |f: fn(&State) -> f64| {
                        (f(&s1) - 8.0 * f(&s2) + 8.0 * f(&s3) - f(&s4)) / (12.0 * h)
                    };
                    let now = motion.at(t);
                    let (v_dot, w_dot) = motion.rates(&now);
                    let close = |x: f64, y: f64, scale: f64| (x - y).abs() < 2e-6 * scale;
                    let w_scale = c.area * now.velocity.abs() + 1e-8;
                    assert!(close(rate(|s| s.position), now.velocity, 0.02), "{mode:?}");
                    assert!(close(rate(|s| s.velocity), v_dot, 10.0), "{mode:?}");
                    assert!(close(rate(|s| s.squeezed), w_dot, w_scale), "{mode:?}");
                    let balance = now.volume - now.squeezed - c.area * now.position;
                    if mode.limited.is_none() {
                        assert!(balance.abs() < 1e-14 * now.volume.abs(), "{mode:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn moving_twice_is_moving_once() {
        for name in ["auv", "table_4_1"] {
            let c = constants(name);
            for mode in modes() {
                let start = State {
                    velocity: if mode.friction == FrictionState::Stuck {
                        0.0
                    } else {
                        0.02
                    },
                    ..some_state(&c)
                };
                let once = ClosedForm::new(&c, mode, 1e-8, start).at(0.011);
                let half = ClosedForm::new(&c, mode, 1e-8, start).at(0.004);
                let twice = ClosedForm::new(&c, mode, 1e-8, half).at(0.007);
                assert!((once.position - twice.position).abs() < 1e-15);
                assert!((once.velocity - twice.velocity).abs() < 1e-13);
                assert!((once.squeezed - twice.squeezed).abs() < 1e-12 * once.squeezed.abs());
            }
        }
    }

    const QUANTITIES: [Quantity; 4] = [
        Quantity::Position,
        Quantity::Speed,
        Quantity::Oil,
        Quantity::Volume,
    ];

    /// Every law, stiffly and weakly damped, from a few starts: with the motion's name.
    fn motions() -> Vec<(String, ClosedForm)> {
        let mut motions = Vec::new();
        for name in ["auv", "table_3_1", "table_4_1"] {
            for damping in [0.3, 1.0, 4.0] {
                let mut c = constants(name);
                c.viscous *= damping;
                for mode in modes() {
                    for (velocity, flow) in [(0.02, 1e-8), (-0.05, 1e-6), (0.3, -3e-5)] {
                        let mut start = some_state(&c);
                        start.velocity = if mode.friction == FrictionState::Stuck {
                            0.0
                        } else {
                            velocity
                        };
                        let motion = ClosedForm::new(&c, mode, flow, start);
                        motions.push((format!("{name} {damping} {mode:?} {flow}"), motion));
                    }
                }
            }
        }
        motions
    }

    #[test]
    fn no_quantity_leaves_its_range() {
        for (name, motion) in motions() {
            for quantity in QUANTITIES {
                let horizon = 0.012;
                let (one, other) = motion.range(quantity, horizon);
                let hair = 1e-12 * one.abs().max(other.abs());
                for i in 0..=200 {
                    let value = motion
                        .value_and_rate(quantity, f64::from(i) / 200.0 * horizon)
                        .0;
                    assert!(value >= one.min(other) - hair, "{name} {quantity:?}");
                    assert!(value <= one.max(other) + hair, "{name} {quantity:?}");
                }
            }
        }
    }

    /// Simpson's rule on the motion itself.
    #[test]
    fn the_integrals_are_those_of_the_motion() {
        for (name, motion) in motions() {
            for t in [1e-5, 0.003] {
                const STEPS: u32 = 400;
                let step = t / f64::from(STEPS);
                let mut sums = [0.0; 3];
                for i in 0..=STEPS {
                    let weight = match i {
                        0 | STEPS => 1.0,
                        i if i % 2 == 1 => 4.0,
                        _ => 2.0,
                    };
                    let State {
                        velocity, squeezed, ..
                    } = motion.at(f64::from(i) * step);
                    let values = [squeezed, squeezed * squeezed, velocity * velocity];
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += weight * value * step / 3.0;
                    }
                }
                let found = motion.integrals(t, &motion.at(t));
                let close = |found: f64, sum: f64, scale: f64| {
                    assert!(
                        (found - sum).abs() <= 2e-7 * scale,
                        "{name} {t}: {found} {sum}"
                    );
                };
                // Each beside the root of its square's.
                let [_, squares, speeds] = sums;
                if !matches!(motion.law, Law::Clamped { .. }) {
                    close(found.squeezed, sums[0], (squares * t).sqrt());
                    close(found.squeezed_squared, squares, squares);
                }
                close(found.velocity_squared, speeds, speeds);
            }
        }
    }

    #[test]
    fn a_quantity_turns_when_it_is_said_to_and_at_no_other_time() {
        for (name, motion) in motions() {
            for quantity in QUANTITIES {
                let Some(turns) = motion.turns(quantity) else {
                    continue;
                };
                let step = 1.7e-5;
                let rates: Vec<f64> = (0..=700)
                    .map(|i| motion.value_and_rate(quantity, f64::from(i) * step).1)
                    .collect();
                // What has settled has only rounding left for a rate.
                let hair = 1e-9 * rates.iter().fold(0.0f64, |most, rate| most.max(rate.abs()));
                for (i, pair) in rates.windows(2).enumerate() {
                    if pair[0].abs().max(pair[1].abs()) < hair {
                        continue;
                    }
                    let (from, to) = (i as f64 * step, (i + 1) as f64 * step);
                    let count = if turns.first > to {
                        0
                    } else if turns.interval.is_infinite() {
                        i32::from(turns.first > from)
                    } else {
                        let turned = |t: f64| ((t - turns.first) / turns.interval).floor();
                        (turned(to) - turned(from)) as i32
                    };
                    let turned = pair[0] * pair[1] < 0.0;
                    assert_eq!(turned, count == 1, "{name} {quantity:?} at {from}");
                }
            }
        }
    }
}
