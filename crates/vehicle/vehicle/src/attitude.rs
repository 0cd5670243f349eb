//! Attitude of the body in the fixed frame: yaw, then pitch, then roll.
//!
//! Fixed frame and body are forward, right, down. `yaw` turns about down, `pitch` about the new right axis, `roll` about the new forward
//! axis (SNAME 1950; the usual z-y'-x'' order):
//!
//! ```text
//! v_fixed = Rz(yaw) Ry(pitch) Rx(roll) v_body
//! p = roll' - yaw' sin(pitch)
//! q = pitch' cos(roll) + yaw' sin(roll) cos(pitch)
//! r = yaw' cos(roll) cos(pitch) - pitch' sin(roll)
//! ```
//!
//! The report has one axis for each equation: pitch in the vertical plane through the keel, yaw about the vertical, roll about the keel
//! line. They are used here as the equations of these three angles. The rates of the angles are therefore not computed from the body's
//! rates (which is singular at 90 degrees of pitch), and attitude and position are valid through any number of loops.

/// An angle with its sine and cosine, for equations that use them more than once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// \[rad\]
    pub radians: f64,
    /// Its sine.
    pub sin: f64,
    /// Its cosine.
    pub cos: f64,
}

impl Angle {
    /// Creates an angle, rad.
    #[must_use]
    pub fn new(radians: f64) -> Self {
        let (sin, cos) = libm::sincos(radians);
        Self { radians, sin, cos }
    }

    /// The angle changed to `radians`; unchanged if it is the same. For a small change the addition theorems are used, with sine and cosine
    /// of the change by their series. This is much faster than computing new sines and cosines, and has the same rounding.
    #[inline]
    #[must_use]
    pub fn turned_to(self, radians: f64) -> Self {
        let turn = radians - self.radians;
        if turn == 0.0 {
            return self;
        }
        if turn.abs() > SMALL_TURN {
            return Self::new(radians);
        }
        let square = turn * turn;
        let sin = turn * (1.0 - square * (SIN_3 - square * (SIN_5 - square * SIN_7)));
        let cos = 1.0 - square * (COS_2 - square * (COS_4 - square * COS_6));
        Self {
            radians,
            sin: self.sin * cos + self.cos * sin,
            cos: self.cos * cos - self.sin * sin,
        }
    }
}

/// Largest change \[rad\] for which the first omitted term of the series, `turn^8 / 8!`, is less than half a unit in the last place.
const SMALL_TURN: f64 = 1.0 / 32.0;

// The series' coefficients, by their powers of the turn.
const COS_2: f64 = 1.0 / 2.0;
const SIN_3: f64 = 1.0 / 6.0;
const COS_4: f64 = 1.0 / 24.0;
const SIN_5: f64 = 1.0 / 120.0;
const COS_6: f64 = 1.0 / 720.0;
const SIN_7: f64 = 1.0 / 5040.0;

/// The rotation between body and fixed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Roll, as in [`Attitude`].
    pub roll: Angle,
    /// Pitch, as in [`Attitude`].
    pub pitch: Angle,
    /// Yaw, as in [`Attitude`].
    pub yaw: Angle,
}

impl Rotation {
    /// Converts a body vector (forward, right, down) to the fixed frame.
    #[must_use]
    pub fn to_fixed(&self, [u, v, w]: [f64; 3]) -> [f64; 3] {
        let Self { roll, pitch, yaw } = self;
        let below = v * roll.sin + w * roll.cos;
        let ahead = u * pitch.cos + below * pitch.sin;
        let aside = v * roll.cos - w * roll.sin;
        [
            ahead * yaw.cos - aside * yaw.sin,
            ahead * yaw.sin + aside * yaw.cos,
            below * pitch.cos - u * pitch.sin,
        ]
    }

    /// Converts a vector of the fixed frame to body axes (forward, right, down).
    #[must_use]
    pub fn to_body(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let Self { roll, pitch, yaw } = self;
        let ahead = x * yaw.cos + y * yaw.sin;
        let aside = y * yaw.cos - x * yaw.sin;
        let below = ahead * pitch.sin + z * pitch.cos;
        [
            ahead * pitch.cos - z * pitch.sin,
            aside * roll.cos + below * roll.sin,
            below * roll.cos - aside * roll.sin,
        ]
    }
}

/// The three angles \[rad\], or their rates \[rad/s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Roll, positive starboard side down.
    pub roll: f64,
    /// Pitch, positive bow up.
    pub pitch: f64,
    /// Yaw, positive bow to starboard.
    pub yaw: f64,
}

impl Attitude {
    /// The rotation between body and fixed frame.
    #[must_use]
    pub fn rotation(&self) -> Rotation {
        Rotation {
            roll: Angle::new(self.roll),
            pitch: Angle::new(self.pitch),
            yaw: Angle::new(self.yaw),
        }
    }

    /// Converts a body vector (forward, right, down) to the fixed frame.
    #[must_use]
    pub fn to_fixed(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation().to_fixed(v)
    }

    /// Converts a vector of the fixed frame to body axes (forward, right, down).
    #[must_use]
    pub fn to_body(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation().to_body(v)
    }

    /// Body rates `p`, `q`, `r` \[rad/s\] for the rates of the angles.
    #[must_use]
    pub fn body_rates(&self, rates: &Self) -> [f64; 3] {
        let (sin_roll, cos_roll) = libm::sincos(self.roll);
        let (sin_pitch, cos_pitch) = libm::sincos(self.pitch);
        [
            rates.roll - rates.yaw * sin_pitch,
            rates.pitch * cos_roll + rates.yaw * sin_roll * cos_pitch,
            rates.yaw * cos_roll * cos_pitch - rates.pitch * sin_roll,
        ]
    }

    /// The quaternion (x, y, z, w) from body vectors to the fixed frame; both forward, right, down.
    #[must_use]
    pub fn quaternion(&self) -> [f64; 4] {
        let (sr, cr) = libm::sincos(0.5 * self.roll);
        let (sp, cp) = libm::sincos(0.5 * self.pitch);
        let (sy, cy) = libm::sincos(0.5 * self.yaw);
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Attitude = Attitude {
        roll: 0.4,
        pitch: -1.9,
        yaw: 2.5,
    };

    #[test]
    fn an_angle_turned_on_has_the_sine_and_the_cosine_of_the_new_one() {
        for from in [0.0, 0.7, -1.9, 3.1, 100.0] {
            for turn in [0.0, 1e-9, -1e-3, 0.031, -0.031, 0.04, -3.0] {
                let turned = Angle::new(from).turned_to(from + turn);
                let afresh = Angle::new(from + turn);
                assert_eq!(turned.radians, afresh.radians);
                assert!((turned.sin - afresh.sin).abs() < 3e-16, "{from} by {turn}");
                assert!((turned.cos - afresh.cos).abs() < 3e-16, "{from} by {turn}");
            }
        }
        assert!(Angle::new(0.0).turned_to(f64::NAN).sin.is_nan());
    }

    #[test]
    fn there_and_back_is_where_it_was() {
        let v = [0.3, -0.2, 0.7];
        for (found, expected) in ANY.to_body(ANY.to_fixed(v)).into_iter().zip(v) {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn bow_to_starboard_and_up_the_way_is_to_starboard_and_up() {
        let attitude = Attitude {
            yaw: 0.3,
            pitch: 0.2,
            roll: 0.0,
        };
        let [x, y, z] = attitude.to_fixed([1.0, 0.0, 0.0]);
        assert!(x > 0.0 && y > 0.0 && z < 0.0);
        // Heeled to starboard, right is down.
        let heeled = Attitude {
            roll: 0.1,
            ..Attitude::default()
        };
        assert!(heeled.to_fixed([0.0, 1.0, 0.0])[2] > 0.0);
    }

    #[test]
    fn the_body_s_rates_are_those_at_which_its_axes_turn() {
        let rates = Attitude {
            roll: 0.2,
            pitch: -0.3,
            yaw: 0.5,
        };
        let omega = ANY.to_fixed(ANY.body_rates(&rates));
        let at = |t: f64| Attitude {
            roll: ANY.roll + t * rates.roll,
            pitch: ANY.pitch + t * rates.pitch,
            yaw: ANY.yaw + t * rates.yaw,
        };
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let h = 1e-5;
            let (after, before) = (at(h).to_fixed(axis), at(-h).to_fixed(axis));
            let a = ANY.to_fixed(axis);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let turned = omega[j] * a[k] - omega[k] * a[j];
                assert!(((after[i] - before[i]) / (2.0 * h) - turned).abs() < 1e-9);
            }
        }
    }
}
