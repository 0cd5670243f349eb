//! Equations of motion in the vertical plane, dimensionally consistent.
//!
//! ```text
//! (m - Z_wdot) w'   - Z_qdot q' = Z_w w + (Z_q + m U) q + Z_delta delta
//!                                 + Z_ww w|w| + Z_qq q|q| + m z_G q^2 + (W - B) cos(theta) + Z_load
//! (I_y - M_qdot) q' - M_wdot w' = M_w w + M_q q + M_delta delta
//!                                 + M_ww w|w| + M_qq q|q| - m z_G w q - W BG sin(theta) + M_load
//! theta' = q
//! z'     = w cos(theta) - U sin(theta)
//! x'     = U cos(theta) + w sin(theta)
//! ```
//!
//! The linear terms, and `M_qq` of one variant (`variant`), are taken from Brunner 1988, p. 34 and programs T2 to T5 (App. A), in SI units and real
//! seconds. Cross-flow drag (`|w|`, `|q|`), the inertias that couple heave with pitch, and an origin at a height `z_G` above the centre of gravity
//! are from Prestero 2001 (the REMUS vehicle, ch. 4); other vehicles have zeros there. Of Prestero's six equations only the vertical plane is used.
//! The surge due to pitch about a point other than the centre of gravity (`m z_G u'`) is omitted.
//!
//! The programs use `theta` for `sin(theta)` (p. 46); [`Restoring`] selects the form. The programs also include the offsets of the centre of gravity
//! in the track; here the track is that of the body's origin. The forward speed `U` through the water is given, not computed (`propulsion` can
//! compute it).

use crate::{attitude::Angle, vehicle::Derivatives};

/// State of the vehicle in the vertical plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// `x` \[m\], distance along the track.
    pub distance: f64,
    /// `z` \[m\], positive down, 0 at the surface.
    pub depth: f64,
    /// `theta` \[rad\], positive bow up, not wrapped: a loop adds 2 pi.
    pub pitch: f64,
    /// `w` \[m/s\], body z velocity, positive towards the keel.
    pub heave: f64,
    /// `q` \[rad/s\], positive bow up.
    pub pitch_rate: f64,
}

/// Dependence of the restoring moment on pitch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restoring {
    /// `W BG sin(theta)`: exact hydrostatics.
    #[default]
    Sine,
    /// `W BG theta`: the report's approximation, valid below about 15 degrees.
    SmallAngle,
}

impl Restoring {
    /// Moment divided by `W BG`.
    fn lever(self, pitch: Angle) -> f64 {
        match self {
            Self::Sine => pitch.sin,
            Self::SmallAngle => pitch.radians,
        }
    }
}

/// Generalized force of the vertical plane: heave force and pitch moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeneralisedForce {
    /// \[N\], body z, positive towards the keel.
    pub heave: f64,
    /// \[N m\], positive bow up.
    pub pitch: f64,
}

impl GeneralisedForce {
    /// Zero force and moment.
    pub const NONE: Self = Self {
        heave: 0.0,
        pitch: 0.0,
    };
}

impl std::ops::Add for GeneralisedForce {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            heave: self.heave + other.heave,
            pitch: self.pitch + other.pitch,
        }
    }
}

/// The inverse of the inertia matrix of heave and pitch, which `Z_qdot` and `M_wdot` couple:
///
/// ```text
/// ( w' )   ( m - Z_wdot    -Z_qdot       )^-1 ( Z )
/// ( q' ) = ( -M_wdot       I_y - M_qdot  )    ( M )
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseInertia {
    /// `w'` \[m/s^2\] per N and per N m.
    heave: [f64; 2],
    /// `q'` \[rad/s^2\] per N and per N m.
    pitch: [f64; 2],
}

impl InverseInertia {
    /// `w'` \[m/s^2\] and `q'` \[rad/s^2\] for a load.
    #[must_use]
    pub fn accelerations(&self, load: GeneralisedForce) -> (f64, f64) {
        let under = |[force, moment]: [f64; 2]| force * load.heave + moment * load.pitch;
        (under(self.heave), under(self.pitch))
    }
}

/// Slopes of heave force and pitch moment at a state with zero pitch rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// Slopes of the heave force \[N\].
    pub heave: Slope,
    /// Slopes of the pitch moment \[N m\].
    pub pitch: Slope,
}

/// Derivatives of one force or moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Slope with respect to heave velocity, per m/s.
    pub w: f64,
    /// Slope with respect to pitch rate, per rad/s.
    pub q: f64,
    /// Slope with respect to pitch, per rad.
    pub theta: f64,
    /// Slope with respect to plane angle, per rad.
    pub delta: f64,
}

impl Derivatives {
    /// Inverse of the inertia matrix.
    #[must_use]
    pub fn inverse_inertia(&self) -> InverseInertia {
        let (i_w, i_q) = (self.heave_inertia, self.pitch_inertia);
        let (z_q_dot, m_w_dot) = (self.z_q_dot, self.m_w_dot);
        let determinant = i_w * i_q - z_q_dot * m_w_dot;
        InverseInertia {
            heave: [i_q / determinant, z_q_dot / determinant],
            pitch: [m_w_dot / determinant, i_w / determinant],
        }
    }

    /// Force and moment of water and weight on the moving body with neutral planes, without added inertia, at `w` \[m/s\], `q` \[rad/s\]
    /// and a pitch.
    #[must_use]
    pub fn hull_force(
        &self,
        w: f64,
        q: f64,
        pitch: Angle,
        restoring: Restoring,
    ) -> GeneralisedForce {
        GeneralisedForce {
            heave: self.z_w * w
                + self.z_q_plus_m_u * q
                + (self.z_ww * w * w.abs() + self.z_qq * q * q.abs())
                + (self.first_moment * q * q + self.excess_weight * pitch.cos),
            pitch: self.m_w * w
                + self.m_q * q
                + (self.m_ww * w * w.abs() + self.m_qq * q * q.abs())
                - self.first_moment * w * q
                - self.restoring * restoring.lever(pitch),
        }
    }

    /// Force and moment of the planes: bow and stern planes together at `delta` \[rad\], plus `differential` \[rad\] on the bow planes and
    /// minus it on the stern planes.
    #[must_use]
    pub fn plane_force(&self, delta: f64, differential: f64) -> GeneralisedForce {
        GeneralisedForce {
            heave: self.z_delta * delta + self.z_differential * differential,
            pitch: self.m_delta * delta + self.m_differential * differential,
        }
    }

    /// Slopes of [`hull_force`](Self::hull_force) and [`plane_force`](Self::plane_force) at the heave velocity and pitch of `state` with
    /// zero pitch rate and the hydrostatic restoring moment.
    #[must_use]
    pub fn slopes(&self, state: &State) -> Slopes {
        let (w, theta) = (state.heave, state.pitch);
        Slopes {
            heave: Slope {
                w: self.z_w + 2.0 * self.z_ww * w.abs(),
                q: self.z_q_plus_m_u,
                theta: -self.excess_weight * libm::sin(theta),
                delta: self.z_delta,
            },
            pitch: Slope {
                w: self.m_w + 2.0 * self.m_ww * w.abs(),
                q: self.m_q - self.first_moment * w,
                theta: -self.restoring * libm::cos(theta),
                delta: self.m_delta,
            },
        }
    }

    /// `w'` \[m/s^2\] and `q'` \[rad/s^2\] with both pairs of planes at `delta` \[rad\].
    #[must_use]
    pub fn accelerations(
        &self,
        state: &State,
        delta: f64,
        restoring: Restoring,
        load: GeneralisedForce,
    ) -> (f64, f64) {
        let pitch = Angle::new(state.pitch);
        let hull = self.hull_force(state.heave, state.pitch_rate, pitch, restoring);
        self.inverse_inertia()
            .accelerations(hull + self.plane_force(delta, 0.0) + load)
    }

    /// `w'` \[m/s^2\] with the planes at `delta` \[rad\], without external load, with the hydrostatic restoring moment (which matters only
    /// if heave and pitch are coupled).
    #[must_use]
    pub fn heave_acceleration(&self, state: &State, delta: f64) -> f64 {
        self.accelerations(state, delta, Restoring::Sine, GeneralisedForce::NONE)
            .0
    }

    /// `q'` \[rad/s^2\] with the planes at `delta` \[rad\], without external load.
    #[must_use]
    pub fn pitch_acceleration(&self, state: &State, delta: f64, restoring: Restoring) -> f64 {
        self.accelerations(state, delta, restoring, GeneralisedForce::NONE)
            .1
    }

    /// `z'` \[m/s\], positive down.
    #[must_use]
    pub fn depth_rate(&self, state: &State) -> f64 {
        state.heave * libm::cos(state.pitch) - self.speed * libm::sin(state.pitch)
    }

    /// `x'` \[m/s\], speed along the track.
    #[must_use]
    pub fn track_speed(&self, state: &State) -> f64 {
        self.speed * libm::cos(state.pitch) + state.heave * libm::sin(state.pitch)
    }

    /// Derivative of every component of the state, with the planes at `delta` \[rad\].
    #[must_use]
    pub fn rates(&self, state: &State, delta: f64, restoring: Restoring) -> State {
        let (heave, pitch_rate) =
            self.accelerations(state, delta, restoring, GeneralisedForce::NONE);
        State {
            distance: self.track_speed(state),
            depth: self.depth_rate(state),
            pitch: state.pitch_rate,
            heave,
            pitch_rate,
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
    use crate::vehicle_file::{brunner, remus_100};
    use planesman_units::FOOT;

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
    fn the_slopes_are_those_of_the_loads() {
        let d = remus_100().derivatives(1.54);
        let (w, theta) = (0.12, -0.08);
        let load = |w, q, theta, delta| {
            d.hull_force(w, q, Angle::new(theta), Restoring::Sine) + d.plane_force(delta, 0.0)
        };
        let h = 1e-6;
        let state = State {
            heave: w,
            pitch: theta,
            ..State::default()
        };
        let Slopes { heave, pitch } = d.slopes(&state);
        for (above, below, force, moment) in [
            (
                load(w + h, 0.0, theta, 0.0),
                load(w - h, 0.0, theta, 0.0),
                heave.w,
                pitch.w,
            ),
            (
                load(w, h, theta, 0.0),
                load(w, -h, theta, 0.0),
                heave.q,
                pitch.q,
            ),
            (
                load(w, 0.0, theta + h, 0.0),
                load(w, 0.0, theta - h, 0.0),
                heave.theta,
                pitch.theta,
            ),
            (
                load(w, 0.0, theta, h),
                load(w, 0.0, theta, -h),
                heave.delta,
                pitch.delta,
            ),
        ] {
            let slope = |above: f64, below: f64| (above - below) / (2.0 * h);
            assert!((slope(above.heave, below.heave) - force).abs() < 1e-3);
            assert!((slope(above.pitch, below.pitch) - moment).abs() < 1e-3);
        }
    }

    #[test]
    fn the_path_speed_is_that_of_the_body_whatever_the_pitch() {
        let d = brunner().derivatives(0.4);
        let state = State {
            pitch: 2.0,
            heave: 0.3,
            ..State::default()
        };
        let path = libm::hypot(d.depth_rate(&state), d.track_speed(&state));
        assert!((path - 0.5).abs() < 1e-15);
    }
}
