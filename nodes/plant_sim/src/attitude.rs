//! How the body lies in the fixed frame: turned by the course, then by pitch, then by roll.
//!
//! Fixed frame and body are forward, right, down; `yaw` turns about down, `pitch` about the turned
//! right, `roll` about the turned forward (SNAME 1950; the usual z-y'-x'' order):
//!
//! ```text
//! v_fixed = Rz(yaw) Ry(pitch) Rx(roll) v_body
//! p = roll' - yaw' sin(pitch)
//! q = pitch' cos(roll) + yaw' sin(roll) cos(pitch)
//! r = yaw' cos(roll) cos(pitch) - pitch' sin(roll)
//! ```
//!
//! The report's plants have one axis each: pitch in the vertical plane through the keel, course
//! about the vertical, roll about the keel line. They are taken as the equations of these three
//! angles themselves. So the angles' rates are never solved for from the body's (which is
//! singular at 90 degrees of pitch): attitude and position hold through any number of loops.

/// The three angles \[rad\], or their rates \[rad/s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Positive starboard side down.
    pub roll: f64,
    /// Positive bow up.
    pub pitch: f64,
    /// Positive bow to starboard.
    pub yaw: f64,
}

impl Attitude {
    /// A body vector (forward, right, down) in the fixed frame.
    #[must_use]
    pub fn to_fixed(&self, [u, v, w]: [f64; 3]) -> [f64; 3] {
        let (sin_roll, cos_roll) = self.roll.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let below = v * sin_roll + w * cos_roll;
        let ahead = u * cos_pitch + below * sin_pitch;
        let aside = v * cos_roll - w * sin_roll;
        [
            ahead * cos_yaw - aside * sin_yaw,
            ahead * sin_yaw + aside * cos_yaw,
            below * cos_pitch - u * sin_pitch,
        ]
    }

    /// A vector of the fixed frame in the body (forward, right, down).
    #[must_use]
    pub fn to_body(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin_roll, cos_roll) = self.roll.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let ahead = x * cos_yaw + y * sin_yaw;
        let aside = y * cos_yaw - x * sin_yaw;
        let below = ahead * sin_pitch + z * cos_pitch;
        [
            ahead * cos_pitch - z * sin_pitch,
            aside * cos_roll + below * sin_roll,
            below * cos_roll - aside * sin_roll,
        ]
    }

    /// The body's rates `p`, `q`, `r` \[rad/s\] under the rates of the angles.
    #[must_use]
    pub fn body_rates(&self, rates: &Self) -> [f64; 3] {
        let (sin_roll, cos_roll) = self.roll.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        [
            rates.roll - rates.yaw * sin_pitch,
            rates.pitch * cos_roll + rates.yaw * sin_roll * cos_pitch,
            rates.yaw * cos_roll * cos_pitch - rates.pitch * sin_roll,
        ]
    }

    /// The quaternion (x, y, z, w) that turns body vectors into the fixed frame; both forward,
    /// right, down.
    #[must_use]
    pub fn quaternion(&self) -> [f64; 4] {
        let (sr, cr) = (0.5 * self.roll).sin_cos();
        let (sp, cp) = (0.5 * self.pitch).sin_cos();
        let (sy, cy) = (0.5 * self.yaw).sin_cos();
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
