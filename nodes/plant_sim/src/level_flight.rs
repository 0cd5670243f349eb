//! Level flight: the pitch and the plane angle at which the vehicle keeps its depth by itself.
//!
//! With `w = U tan(theta)` the path is level, and with `q = 0` nothing turns. What remains are two
//! equations, heave force and pitch moment both 0, in pitch and plane angle. The plane angle is
//! in both to the first power and is taken from the moment; the pitch is found by Newton's method.
//!
//! A vehicle that weighs what it displaces flies level on an even keel with neutral planes. One that
//! is lighter, as Prestero 2001 ballasts the REMUS, is pressed down by its hull flying bow down and
//! by its planes, which hold the bow against the Munk moment.

use crate::{Restoring, State, linearised::Slopes, vehicle::Derivatives};

/// A steady flight at one depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelFlight {
    /// `theta` \[rad\], positive bow up.
    pub pitch: f64,
    /// `w` \[m/s\], positive towards the keel.
    pub heave: f64,
    /// `delta` \[rad\], positive dive.
    pub planes: f64,
}

/// Newton steps; a trim within reach takes five.
const STEPS: usize = 30;

impl LevelFlight {
    /// The state of this flight at the origin.
    #[must_use]
    pub fn state(&self) -> State {
        State {
            pitch: self.pitch,
            heave: self.heave,
            ..State::default()
        }
    }
}

impl Derivatives {
    /// How this vehicle flies level, `None` when it cannot within 45 degrees of pitch: without
    /// way on, or without planes, nothing holds a buoyant vehicle down.
    #[must_use]
    pub fn level_flight(&self) -> Option<LevelFlight> {
        let mut flight = LevelFlight::default();
        for _ in 0..STEPS {
            let state = flight.state();
            let force = self.heave_force(&state, 0.0);
            let moment = self.pitch_moment(&state, 0.0, Restoring::Sine);
            if force == 0.0 && moment == 0.0 {
                return Some(flight);
            }
            // The planes take up the moment; what they then leave of the force must vanish.
            let ratio = self.z_delta / self.m_delta;
            flight.planes = -moment / self.m_delta;
            let Slopes { heave, pitch } = Slopes::about(self, &state);
            let heaving = self.speed / state.pitch.cos().powi(2);
            let slope = (heave.w - ratio * pitch.w) * heaving + heave.theta - ratio * pitch.theta;
            let change = -(force - ratio * moment) / slope;
            if !change.is_finite() || (flight.pitch + change).abs() > std::f64::consts::FRAC_PI_4 {
                return None;
            }
            flight.pitch += change;
            flight.heave = self.speed * flight.pitch.tan();
            if change.abs() < 1e-15 {
                return Some(flight);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Load;
    use crate::quantity::FOOT;
    use crate::vehicle_file::{brunner, remus_100};

    #[test]
    fn a_neutral_vehicle_flies_level_on_an_even_keel() {
        let flight = brunner().derivatives(FOOT).level_flight();
        assert_eq!(flight, Some(LevelFlight::default()));
    }

    #[test]
    fn in_level_flight_nothing_accelerates_and_the_depth_stays() {
        for speed in [1.0, 1.54, 2.5] {
            let d = remus_100().derivatives(speed);
            let flight = d.level_flight().expect("it flies level");
            let state = flight.state();
            let (heaving, pitching) =
                d.accelerations(&state, flight.planes, Restoring::Sine, Load::NONE);
            assert!(heaving.abs() < 1e-14, "{speed}: {heaving}");
            assert!(pitching.abs() < 1e-14, "{speed}: {pitching}");
            assert!(d.depth_rate(&state).abs() < 1e-15);
        }
    }

    #[test]
    fn a_buoyant_vehicle_without_way_on_does_not_fly() {
        assert_eq!(remus_100().derivatives(0.0).level_flight(), None);
    }
}
