//! The equations of motion in the vertical plane, dimensionally consistent.
//!
//! ```text
//! (m - Z_wdot) w'   = Z_w w + (Z_q + m U) q + Z_delta delta
//! (I_y - M_qdot) q' = M_w w + (M_q + M_q|q| |q|) q + M_delta delta - W BG sin(theta)
//! theta' = q
//! z'     = w cos(theta) - U sin(theta)
//! x'     = U cos(theta) + w sin(theta)
//! ```
//!
//! Brunner 1988, p. 34 and programs T2 to T5 (App. A), in SI units and real seconds. The
//! programs take `theta` for `sin(theta)` (p. 46); [`Restoring`] chooses. They also carry the
//! offsets of the centre of gravity into the track; here the track is that of the centre of
//! gravity. The forward speed `U` through the water is given, not solved for.

use crate::vehicle::Derivatives;

/// Where the vehicle is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// `x` \[m\], along the track.
    pub distance: f64,
    /// `z` \[m\], positive down, 0 at the surface.
    pub depth: f64,
    /// `theta` \[rad\], positive bow up, not wrapped: a loop adds a turn.
    pub pitch: f64,
    /// `w` \[m/s\], body z velocity, positive towards the keel.
    pub heave: f64,
    /// `q` \[rad/s\], positive bow up.
    pub pitch_rate: f64,
}

/// How the restoring moment depends on pitch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restoring {
    /// `W BG sin(theta)`: what hydrostatics gives.
    #[default]
    Sine,
    /// `W BG theta`: the report's approximation, good below some 15 degrees.
    SmallAngle,
}

impl Restoring {
    /// The moment per `W BG`.
    fn lever(self, pitch: f64) -> f64 {
        match self {
            Self::Sine => pitch.sin(),
            Self::SmallAngle => pitch,
        }
    }
}

impl Derivatives {
    /// `w'` \[m/s^2\] with the planes at `delta` \[rad\].
    #[must_use]
    pub fn heave_acceleration(&self, state: &State, delta: f64) -> f64 {
        let State {
            heave: w,
            pitch_rate: q,
            ..
        } = *state;
        (self.z_w * w + self.z_q_plus_m_u * q + self.z_delta * delta) / self.heave_inertia
    }

    /// `q'` \[rad/s^2\] with the planes at `delta` \[rad\].
    #[must_use]
    pub fn pitch_acceleration(&self, state: &State, delta: f64, restoring: Restoring) -> f64 {
        let State {
            heave: w,
            pitch_rate: q,
            pitch: theta,
            ..
        } = *state;
        (self.m_w * w + (self.m_q + self.m_q_q * q.abs()) * q + self.m_delta * delta
            - self.restoring * restoring.lever(theta))
            / self.pitch_inertia
    }

    /// `z'` \[m/s\], positive down.
    #[must_use]
    pub fn depth_rate(&self, state: &State) -> f64 {
        state.heave * state.pitch.cos() - self.speed * state.pitch.sin()
    }

    /// `x'` \[m/s\], along the track.
    #[must_use]
    pub fn track_speed(&self, state: &State) -> f64 {
        self.speed * state.pitch.cos() + state.heave * state.pitch.sin()
    }

    /// The rate of change of every part of the state, with the planes at `delta` \[rad\].
    #[must_use]
    pub fn rates(&self, state: &State, delta: f64, restoring: Restoring) -> State {
        State {
            distance: self.track_speed(state),
            depth: self.depth_rate(state),
            pitch: state.pitch_rate,
            heave: self.heave_acceleration(state, delta),
            pitch_rate: self.pitch_acceleration(state, delta, restoring),
        }
    }
}

impl From<State> for [f64; 5] {
    fn from(s: State) -> Self {
        [s.distance, s.depth, s.pitch, s.heave, s.pitch_rate]
    }
}

impl From<[f64; 5]> for State {
    fn from([distance, depth, pitch, heave, pitch_rate]: [f64; 5]) -> Self {
        Self {
            distance,
            depth,
            pitch,
            heave,
            pitch_rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::FOOT;
    use crate::vehicle_file::brunner;

    #[test]
    fn bow_up_with_way_on_the_vehicle_climbs() {
        let state = State {
            pitch: 0.1,
            ..State::default()
        };
        assert!(brunner().derivatives(FOOT).depth_rate(&state) < 0.0);
    }

    #[test]
    fn diving_planes_press_the_vehicle_down_and_its_bow_too() {
        let rates = brunner()
            .derivatives(FOOT)
            .rates(&State::default(), 0.1, Restoring::Sine);
        assert!(rates.heave > 0.0 && rates.pitch_rate < 0.0);
    }

    #[test]
    fn bow_up_the_restoring_moment_turns_the_bow_down() {
        let state = State {
            pitch: 1.0,
            ..State::default()
        };
        let d = brunner().derivatives(0.0);
        assert!(d.pitch_acceleration(&state, 0.0, Restoring::Sine) < 0.0);
    }

    #[test]
    fn the_path_speed_is_that_of_the_body_whatever_the_pitch() {
        let d = brunner().derivatives(0.4);
        let state = State {
            pitch: 2.0,
            heave: 0.3,
            ..State::default()
        };
        let path = d.depth_rate(&state).hypot(d.track_speed(&state));
        assert!((path - 0.5).abs() < 1e-15);
    }
}
