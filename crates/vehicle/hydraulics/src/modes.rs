//! Modes of the ram: the equations of each, and their constants.
//!
//! ```text
//! V_e' = Q - k P_d - A_L v       P_d = beta/V V_e, held between -|P_m-| and P_m+
//! M v' = A_L P_d - C v - s Delta F       while the load slides in direction s
//! v = 0                                  while it sticks
//! V_T = V_e + A_L x                      held at +-V_lim: then Q and k count as 0
//! ```
//!
//! (IBM 66-L03-005, Section II.B.2-3, Figures 2-9 to 2-13.) V_e is the volume of oil squeezed into the column. The part beyond the clamp is
//! stored in the auxiliary pistons and delivered later: the clamp saturates the pressure without loss. With a = k beta/V, b = A_L
//! (beta/V)/M, c = C/M and f = s Delta F/M each mode is linear with constant forcing, so its motion has a closed form
//! ([`crate::closed_form`]).

use crate::actuator_set::ActuatorSet;

/// The direction of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To the right: dive.
    Positive,
    /// To the left: rise.
    Negative,
}

impl Side {
    /// The side of the sign of `value`; 0 counts as positive.
    #[must_use]
    pub fn from_sign(value: f64) -> Self {
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

/// State of the ram.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// X_1, m.
    pub position: f64,
    /// X_1', m/s.
    pub velocity: f64,
    /// V_e = V_T - A_L X_1, m^3: squeezed oil, a separate state so that rest is exact.
    pub squeezed: f64,
    /// V_T, m^3: net metered oil.
    pub volume: f64,
}

/// Whether the load moves: the friction latch of Figure 2-13.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionState {
    /// The latch is open: friction holds the load.
    Stuck,
    /// The load is at a stop; only an inward pressure can move it.
    AtStop(Side),
    /// The latch is closed; friction opposes motion to this side.
    Sliding(Side),
}

/// Active equations of the ram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Friction and stops.
    pub friction: FrictionState,
    /// Side whose auxiliary piston clamps the pressure; `None` if the pressure is not clamped.
    pub clamped: Option<Side>,
    /// Volume limit that holds V_T; `None` within the limits.
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
    /// Excess of static friction over Delta F, as a share; 0 unless the report's "stepping" is modelled ([`crate::Condition::stepping`]).
    pub stepping: f64,
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
    /// Takes the constants of an actuator.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self {
            area: set.area,
            mass: set.load.mass,
            viscous: set.load.viscous,
            coulomb: set.load.coulomb,
            stepping: 0.0,
            stiffness: set.oil.stiffness,
            leakage: set.pressure_leakage(),
            clamp_positive: set.oil.clamp_positive,
            clamp_negative: set.oil.clamp_negative,
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

    /// P_d, Pa, at a volume of squeezed oil.
    #[must_use]
    pub fn pressure(&self, squeezed: f64) -> f64 {
        (self.stiffness * squeezed).clamp(-self.clamp_negative, self.clamp_positive)
    }
}

/// Pressures at the ram's ports, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pressures {
    /// P_h.
    pub supply: f64,
    /// P_R.
    pub back: f64,
    /// P_L0 = P_h A_R/A_L.
    pub resting: f64,
}

impl Pressures {
    /// Takes the pressures of an actuator.
    #[must_use]
    pub(crate) fn new(set: &ActuatorSet) -> Self {
        Self {
            supply: set.oil.supply,
            back: set.oil.return_pressure,
            resting: set.resting_pressure(),
        }
    }
}
