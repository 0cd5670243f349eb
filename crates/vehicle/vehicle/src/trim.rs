//! Trim: pitch and plane angle of level flight, at which the vehicle keeps its depth.
//!
//! With `w = U tan(theta)` the path is level, and `q = 0`. Two equations remain, zero heave force and zero pitch moment, for pitch and
//! plane angle. Both are linear in the plane angle, which follows from the moment; Newton's method finds the pitch.
//!
//! A neutrally buoyant vehicle flies level on an even keel with neutral planes. A lighter vehicle, such as the REMUS in Prestero 2001, is
//! pressed down by its hull flying bow down, and by its planes, which balance the Munk moment.

use crate::{
    Restoring, State,
    attitude::Angle,
    dynamics::{GeneralisedForce, Slopes},
    vehicle::Derivatives,
};

/// Steady flight at constant depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelFlight {
    /// `theta` \[rad\], positive bow up.
    pub pitch: f64,
    /// `w` \[m/s\], positive towards the keel.
    pub heave: f64,
    /// `delta` \[rad\], positive dive.
    pub planes: f64,
}

/// Largest number of Newton steps; the REMUS at its working speed needs five.
const STEPS: usize = 50;

/// Steps below this size \[rad\] are ignored: rounding moves the pitch by an even smaller angle.
const CLOSE: f64 = 1e-13;

/// Largest pitch of the search \[rad\]; hulls stall at much smaller angles.
const STEEPEST: f64 = std::f64::consts::FRAC_PI_4;

impl LevelFlight {
    /// State of this flight at the origin.
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
    /// Level flight of this vehicle; `None` if it does not exist within 45 degrees of pitch. At zero speed or without planes nothing holds
    /// a buoyant vehicle down.
    #[must_use]
    pub fn level_flight(&self) -> Option<LevelFlight> {
        let mut flight = LevelFlight::default();
        for _ in 0..STEPS {
            let state = flight.state();
            let GeneralisedForce {
                heave: force,
                pitch: moment,
            } = self.hull_force(
                state.heave,
                state.pitch_rate,
                Angle::new(state.pitch),
                Restoring::Sine,
            );
            if force == 0.0 && moment == 0.0 {
                return Some(flight);
            }
            // The planes take up the moment; what they then leave of the force must vanish.
            let ratio = self.z_delta / self.m_delta;
            flight.planes = -moment / self.m_delta;
            let Slopes { heave, pitch } = self.slopes(&state);
            let heaving = self.speed / libm::cos(state.pitch).powi(2);
            let slope = (heave.w - ratio * pitch.w) * heaving + heave.theta - ratio * pitch.theta;
            let change = -(force - ratio * moment) / slope;
            if change.abs() < CLOSE {
                return Some(flight);
            }
            let pitch = (flight.pitch + change).clamp(-STEEPEST, STEEPEST);
            if pitch == flight.pitch || pitch.is_nan() {
                return None;
            }
            flight.pitch = pitch;
            flight.heave = self.speed * libm::tan(pitch);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::GeneralisedForce;
    use crate::vehicle_file::{brunner, remus_100};
    use planesman_units::FOOT;

    #[test]
    fn a_neutral_vehicle_flies_level_on_an_even_keel() {
        let flight = brunner().derivatives(FOOT).level_flight();
        assert_eq!(flight, Some(LevelFlight::default()));
    }

    #[test]
    fn in_level_flight_nothing_accelerates_and_the_depth_stays() {
        for speed in [0.3, 1.0, 1.54, 2.5] {
            let d = remus_100().derivatives(speed);
            let flight = d.level_flight().expect("it flies level");
            let state = flight.state();
            let (heaving, pitching) = d.accelerations(
                &state,
                flight.planes,
                Restoring::Sine,
                GeneralisedForce::NONE,
            );
            assert!(heaving.abs() < 1e-12, "{speed}: {heaving}");
            assert!(pitching.abs() < 1e-12, "{speed}: {pitching}");
            assert!(d.depth_rate(&state).abs() < 1e-15);
        }
    }

    #[test]
    fn the_slower_a_buoyant_vehicle_the_steeper_it_flies_until_it_cannot() {
        let pitch = |speed| {
            let flight = remus_100().derivatives(speed).level_flight();
            flight.map(|flight| flight.pitch.to_degrees())
        };
        for (speed, degrees) in [(2.5, -1.22), (1.0, -6.92), (0.5, -21.43), (0.3, -38.89)] {
            let found = pitch(speed).expect("it flies level");
            assert!((found - degrees).abs() < 0.01, "{speed}: {found}");
        }
        assert_eq!(pitch(0.2), None);
        assert_eq!(pitch(0.0), None);
    }
}
