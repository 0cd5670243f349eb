//! The ram's modes, and its motion within one mode in closed form.
//!
//! ```text
//! V_e' = Q - k P_d - A_L v       P_d = beta/V V_e, held between -|P_m-| and P_m+
//! M v' = A_L P_d - C v - s Delta F       while the load slides in direction s
//! v = 0                                  while it sticks
//! V_T = V_e + A_L x                      held at +-V_lim: then Q and k count as 0
//! ```
//!
//! (IBM 66-L03-005, Section II.B.2-3, Figures 2-9 to 2-13.) V_e is the oil squeezed into the
//! column. Beyond what the clamp holds it sits in the auxiliary pistons and is delivered
//! later: the clamp saturates the pressure and loses nothing. With a = k beta/V,
//! b = A_L (beta/V)/M, c = C/M and f = s Delta F/M each mode is linear with constant forcing, so
//! its motion is exact for any length of time.

use crate::actuator_set::ActuatorSet;

/// One of two directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To the right: dive.
    Positive,
    /// To the left: rise.
    Negative,
}

impl Side {
    /// The side that `value` points to; 0 counts as positive.
    #[must_use]
    pub fn of(value: f64) -> Self {
        if value < 0.0 {
            Self::Negative
        } else {
            Self::Positive
        }
    }

    /// +1 or -1.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }

    /// The other side.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::Positive => Self::Negative,
            Self::Negative => Self::Positive,
        }
    }
}

/// Where the ram is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// X_1, m.
    pub position: f64,
    /// X_1', m/s.
    pub velocity: f64,
    /// V_e = V_T - A_L X_1, m^3: oil squeezed in, carried for its own sake so that rest is exact.
    pub squeezed: f64,
    /// V_T, m^3: net oil metered in.
    pub volume: f64,
}

/// Whether the load moves: the friction latch of Figure 2-13.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// The latch is open, held by friction.
    Stuck,
    /// Held against a stop: only the pressure's pull inwards can free it.
    AtStop(Side),
    /// The latch is closed; friction acts against this side.
    Sliding(Side),
}

/// Which of the ram's laws are in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Friction and stops.
    pub load: Load,
    /// The auxiliary piston that clamps the pressure, if one does.
    pub clamped: Option<Side>,
    /// The volume limit at which V_T is held, if it is.
    pub limited: Option<Side>,
}

/// The constants of the ram's equations, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// A_L.
    pub area: f64,
    /// M.
    pub mass: f64,
    /// C.
    pub viscous: f64,
    /// Delta F.
    pub coulomb: f64,
    /// beta/V.
    pub stiffness: f64,
    /// k = 2 q_L/P_h.
    pub leakage: f64,
    /// P_m+.
    pub clamp_positive: f64,
    /// |P_m-|.
    pub clamp_negative: f64,
    /// V_lim.
    pub volume_limit: f64,
    /// x_stop.
    pub stop: f64,
}

impl Constants {
    /// Those of an actuator.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self {
            area: set.area,
            mass: set.mass,
            viscous: set.viscous,
            coulomb: set.coulomb,
            stiffness: set.stiffness,
            leakage: set.pressure_leakage(),
            clamp_positive: set.clamp_positive,
            clamp_negative: set.clamp_negative,
            volume_limit: set.volume_limit,
            stop: set.stop,
        }
    }

    /// |P_m| on one side, Pa.
    #[must_use]
    pub fn clamp(&self, side: Side) -> f64 {
        match side {
            Side::Positive => self.clamp_positive,
            Side::Negative => self.clamp_negative,
        }
    }

    /// P_d, Pa, for the oil squeezed in.
    #[must_use]
    pub fn pressure(&self, squeezed: f64) -> f64 {
        (self.stiffness * squeezed).clamp(-self.clamp_negative, self.clamp_positive)
    }
}

/// The motion within one mode and one constant flow, from the state it began in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    start: State,
    area: f64,
    limited: bool,
    law: Law,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// v = 0, V_e' = q - a V_e.
    Stuck { q: f64, a: f64 },
    /// v' = g - c v, V_e' = q - A_L v: the pressure is clamped.
    Clamped { q: f64, g: f64, c: f64 },
    /// V_e' = q - a V_e - A_L v, v' = b V_e - c v - f: the load rides on the oil.
    Riding(Riding),
}

/// The second-order law about its equilibrium. The characteristic roots are mu +- sqrt(spread).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Riding {
    q: f64,
    a: f64,
    b: f64,
    c: f64,
    f: f64,
    mu: f64,
    spread: f64,
    root: f64,
    steady_squeezed: f64,
    steady_velocity: f64,
}

impl ClosedForm {
    /// The motion from `start` in `mode` under the net metered flow `flow`, m^3/s.
    #[must_use]
    pub fn new(constants: &Constants, mode: Mode, flow: f64, start: State) -> Self {
        let m = constants;
        let limited = mode.limited.is_some();
        let (q, k) = if limited {
            (0.0, 0.0)
        } else {
            (flow, m.leakage)
        };
        let held_pressure = mode.clamped.map(|side| side.sign() * m.clamp(side));
        let law = match (mode.load, held_pressure) {
            (Load::Stuck | Load::AtStop(_), None) => Law::Stuck {
                q,
                a: k * m.stiffness,
            },
            (Load::Stuck | Load::AtStop(_), Some(pressure)) => Law::Stuck {
                q: q - k * pressure,
                a: 0.0,
            },
            (Load::Sliding(side), Some(pressure)) => Law::Clamped {
                q: q - k * pressure,
                g: (m.area * pressure - side.sign() * m.coulomb) / m.mass,
                c: m.viscous / m.mass,
            },
            (Load::Sliding(side), None) => {
                let a = k * m.stiffness;
                let b = m.area * m.stiffness / m.mass;
                let c = m.viscous / m.mass;
                let f = side.sign() * m.coulomb / m.mass;
                let half = 0.5 * (a - c);
                let spread = half * half - m.area * b;
                let steady_velocity = (q * b - a * f) / (a * c + m.area * b);
                Law::Riding(Riding {
                    q,
                    a,
                    b,
                    c,
                    f,
                    mu: -0.5 * (a + c),
                    spread,
                    root: spread.abs().sqrt(),
                    steady_squeezed: (f + c * steady_velocity) / b,
                    steady_velocity,
                })
            }
        };
        Self {
            start,
            area: m.area,
            limited,
            law,
        }
    }

    /// The state `t` seconds after the start.
    #[must_use]
    pub fn at(&self, t: f64) -> State {
        let start = &self.start;
        let (moved, velocity, squeezed_by) = match &self.law {
            Law::Stuck { q, a } => (0.0, 0.0, (q - a * start.squeezed) * decayed(*a, t)),
            Law::Clamped { q, g, c } => {
                let final_velocity = g / c;
                let velocity_change = (g - c * start.velocity) * decayed(*c, t);
                // x' = v and v' = g - c v give x = v_final t - (v - v_0)/c.
                let moved = final_velocity * t - velocity_change / c;
                (
                    moved,
                    start.velocity + velocity_change,
                    q * t - self.area * moved,
                )
            }
            Law::Riding(law) => law.after(t, start, self.area),
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

    /// `(v', V_e')` in a state on this motion, m/s^2 and m^3/s.
    #[must_use]
    pub fn rates(&self, state: &State) -> (f64, f64) {
        let (v, w) = (state.velocity, state.squeezed);
        match &self.law {
            Law::Stuck { q, a } => (0.0, q - a * w),
            Law::Clamped { q, g, c } => (g - c * v, q - self.area * v),
            Law::Riding(law) => (
                law.b * w - law.c * v - law.f,
                law.q - law.a * w - self.area * v,
            ),
        }
    }

    /// A time, s, within which each quantity on this motion turns at most once.
    #[must_use]
    pub fn turning_time(&self) -> f64 {
        match &self.law {
            Law::Riding(law) => 0.5 / (law.a * law.c + self.area * law.b).sqrt(),
            Law::Stuck { .. } | Law::Clamped { .. } => f64::INFINITY,
        }
    }

    /// For a load that rides on the oil: its equilibrium `(v, V_e)` and how far, at most, it
    /// will ever be from each.
    ///
    /// The energy dv^2 + (b/A_L) dV_e^2 of the deviation never grows: its rate is
    /// -2 c dv^2 - 2 a (b/A_L) dV_e^2.
    #[must_use]
    pub fn bounds(&self) -> Option<((f64, f64), (f64, f64))> {
        let Law::Riding(law) = &self.law else {
            return None;
        };
        let dv = self.start.velocity - law.steady_velocity;
        let dw = self.start.squeezed - law.steady_squeezed;
        let velocity_per_oil = (law.b / self.area).sqrt();
        let reach = dv.hypot(velocity_per_oil * dw);
        Some((
            (law.steady_velocity, reach),
            (law.steady_squeezed, reach / velocity_per_oil),
        ))
    }
}

impl Riding {
    /// `(x - x_0, v, V_e - V_e0)` after `t`.
    fn after(&self, t: f64, start: &State, area: f64) -> (f64, f64, f64) {
        let dw = start.squeezed - self.steady_squeezed;
        let dv = start.velocity - self.steady_velocity;
        // exp(A t) = even I + odd (A - mu I), of A = [[-a, -A_L], [b, -c]].
        let (even, odd) = self.exponentials(t);
        let half = 0.5 * (self.c - self.a);
        let w_after = (even + half * odd) * dw - area * odd * dv;
        let v_after = self.b * odd * dw + (even - half * odd) * dv;
        let squeezed_by = w_after - dw;
        let velocity_change = v_after - dv;
        // Both equations integrated over t, the integral of V_e eliminated.
        let moved = (self.q * t - (self.a / self.b) * (velocity_change + self.f * t) - squeezed_by)
            / (area + self.a * self.c / self.b);
        (moved, self.steady_velocity + v_after, squeezed_by)
    }

    /// e^(mu t) times cosh(r t) and sinh(r t)/r of r^2 = spread: cos and sin where the roots
    /// are complex, 1 and t where they meet.
    fn exponentials(&self, t: f64) -> (f64, f64) {
        let angle = self.root * t;
        if angle < 1e-3 {
            let z = self.spread * t * t;
            let decay = (self.mu * t).exp();
            let even = 1.0 + z / 2.0 * (1.0 + z / 12.0);
            let odd = t * (1.0 + z / 6.0 * (1.0 + z / 20.0));
            (decay * even, decay * odd)
        } else if self.spread < 0.0 {
            let decay = (self.mu * t).exp();
            let (sine, cosine) = angle.sin_cos();
            (decay * cosine, decay * sine / self.root)
        } else {
            let slow = ((self.mu + self.root) * t).exp();
            let fast = ((self.mu - self.root) * t).exp();
            (0.5 * (slow + fast), 0.5 * (slow - fast) / self.root)
        }
    }
}

/// (1 - e^(-rate t))/rate, s.
fn decayed(rate: f64, t: f64) -> f64 {
    if rate == 0.0 {
        t
    } else {
        -(-rate * t).exp_m1() / rate
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
        for load in [
            Load::Stuck,
            Load::Sliding(Side::Positive),
            Load::Sliding(Side::Negative),
        ] {
            for clamped in [None, Some(Side::Positive), Some(Side::Negative)] {
                for limited in [None, Some(Side::Positive)] {
                    modes.push(Mode {
                        load,
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
                    if mode.load == Load::Stuck {
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
                    velocity: if mode.load == Load::Stuck { 0.0 } else { 0.02 },
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

    #[test]
    fn a_deviation_from_the_steady_ride_never_outgrows_its_energy() {
        let c = constants("table_4_1");
        let mode = Mode {
            load: Load::Sliding(Side::Positive),
            clamped: None,
            limited: None,
        };
        let motion = ClosedForm::new(&c, mode, 1e-6, some_state(&c));
        let ((v, v_reach), (w, w_reach)) = motion.bounds().expect("it rides");
        for i in 0..1000 {
            let state = motion.at(f64::from(i) * 1e-4);
            assert!((state.velocity - v).abs() <= v_reach * (1.0 + 1e-12));
            assert!((state.squeezed - w).abs() <= w_reach * (1.0 + 1e-12));
        }
    }
}
