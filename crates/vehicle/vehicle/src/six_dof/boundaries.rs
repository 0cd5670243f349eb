//! Loss of buoyancy at the surface, and contact with the bottom.
//!
//! ```text
//! surface:  strips along the hull; B/n s_i of buoyancy is lost where a share s_i is out of the water, s_i = 1/2 - z_i/H in [0, 1]
//! bottom:   at the four ends of its base, N = k d (1 + c d') where it is d deep in the ground, and friction -mu N against the way
//! ```
//!
//! Every strip has the height `H` in any attitude, so the force depends only on depths and has a potential. The contact force follows Hunt
//! and Crossley ("Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42, 1975), with a spring that the
//! weight compresses by 1 cm. Damping, added mass, fins and thrusters stay those of the submerged hull: slamming and ventilation are not modelled.

use super::equations::State;
use super::hull::STRIPS;
use super::lanes::{Real, Six, Three, cross, of, scaled, six, sum};
use super::rotation;
use super::vehicle::Vehicle;
use super::water::Water;

/// Depth to which the weight alone presses the hull into the ground \[m\].
const SINKAGE: f64 = 0.01;

/// Damping of the contact, per velocity into the ground \[s/m\].
const CONTACT_DAMPING: f64 = 1.0;

/// Coefficient of friction with the ground.
const FRICTION: f64 = 0.3;

/// Speed \[m/s\] at which friction reaches its full value.
const CREEP: f64 = 0.05;

impl Vehicle {
    /// Depths of the lowest and the highest point of the hull \[m\], for the rotation matrix of an attitude.
    #[must_use]
    pub fn extent(&self, depth: f64, r: &[Three<f64>; 3]) -> [f64; 2] {
        let (hull, b) = (&self.parts.hull, self.parts.centre_of_buoyancy);
        let down = r[2];
        let centre = depth + down[0] * b[0] + down[1] * b[1] + down[2] * b[2];
        let ends = hull.ends().map(|[x, y]| centre + down[0] * x + down[1] * y);
        let lowest = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let highest = hull
            .strips()
            .iter()
            .map(|x| centre + down[0] * x)
            .fold(f64::INFINITY, f64::min);
        [lowest + 0.5 * hull.height, highest - 0.5 * hull.height]
    }

    /// Largest vertical distance of any part of the hull from the origin \[m\].
    #[inline(always)]
    pub(super) fn reach(&self) -> f64 {
        let (hull, b) = (&self.parts.hull, self.parts.centre_of_buoyancy);
        hull.reach() + b[0].abs() + b[1].abs() + b[2].abs()
    }

    /// Forces of surface and bottom on the hull.
    #[inline(always)]
    pub(super) fn boundaries<T: Real>(
        &self,
        r: &[Three<T>; 3],
        state: &State<T>,
        water: &Water<T>,
    ) -> Six<T> {
        let none = [T::of(0.0); 6];
        if !water.has_surface && water.bottom.is_none() {
            return none;
        }
        let reach = self.reach();
        let depth = state.position[2];
        let mut force = none;
        if water.has_surface && depth.least() < reach {
            force = sum(force, self.emerged(r, depth));
        }
        if let Some(bottom) = water.bottom.filter(|it| (-depth).least() < reach - it) {
            force = sum(force, self.aground(r, state, bottom));
        }
        force
    }

    /// Buoyancy lost above the surface.
    #[inline(always)]
    fn emerged<T: Real>(&self, r: &[Three<T>; 3], depth: T) -> Six<T> {
        let (hull, b) = (&self.parts.hull, self.parts.centre_of_buoyancy);
        let down = r[2];
        let share = T::of(self.parts.buoyancy / STRIPS as f64);
        let mut force = [T::of(0.0); 6];
        for x in hull.strips() {
            let place = of(&[b[0] + x, b[1], b[2]]);
            let deep = depth + super::lanes::dot(down, place);
            let out = (deep * (-1.0 / hull.height) + T::of(0.5)).map(|s| s.clamp(0.0, 1.0));
            let lost = scaled(share * out, down);
            force = sum(force, six(lost, cross(place, lost)));
        }
        force
    }

    /// Contact force of the bottom.
    #[inline(always)]
    fn aground<T: Real>(&self, r: &[Three<T>; 3], state: &State<T>, bottom: f64) -> Six<T> {
        let (hull, b) = (&self.parts.hull, self.parts.centre_of_buoyancy);
        let [u, v, w, p, q, turn] = state.velocity;
        let stiffness = T::of(self.parts.weight / (4.0 * SINKAGE));
        let mut force = [T::of(0.0); 6];
        for [x, y] in hull.ends() {
            let place = of(&[b[0] + x, b[1] + y, b[2]]);
            let deep = state.position[2] + super::lanes::dot(r[2], place);
            let sunk = (deep + T::of(0.5 * hull.height - bottom)).map(|d| d.max(0.0));
            let moving = sum([u, v, w], cross([p, q, turn], place));
            let [north, east, down] = rotation::to_fixed(r, moving);
            let damped = (T::of(1.0) + down * CONTACT_DAMPING).map(|x| x.max(0.0));
            let normal = stiffness * sunk * damped;
            let way = (north * north + east * east + T::of(CREEP * CREEP)).sqrt();
            let friction = -(normal * FRICTION) / way;
            let pushed = rotation::to_body(r, [friction * north, friction * east, -normal]);
            force = sum(force, six(pushed, cross(place, pushed)));
        }
        force
    }
}
