//! The equations of motion in six degrees of freedom, in Fossen's vector form about the body's origin:
//!
//! ```text
//! M_RB nu' + C_RB(nu) nu + M_A (nu' - nu_c') + C_A(nu_r) nu_r + D(nu_r) nu_r + g = tau
//! nu   = (u, v, w, p, q, r)            over ground, in the body: forward, starboard, keel
//! nu_r = nu - (R^T v_c, 0)             through the water
//! nu_c' = ( -w x (R^T v_c) + R^T v_c' , 0 )
//! (x, y, z)' = R (u, v, w)     Q' = 1/2 Q (0, p, q, r)
//! ```
//!
//! Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), ch. 6 to 8, writes the equation in `nu_r`, which is the same
//! in a steady uniform current. Accelerating water also acts by its pressure gradient, with the same force as on the displaced water.

use super::inertia::{Matrix6, coriolis};
use super::lanes::{Real, Six, Three, cross, difference, halves, of, product, scaled, six, sum};
use super::propulsion::Propulsor;
use super::rotation::{self, Quaternion};
use super::vehicle::Vehicle;
use super::water::{GRAVITY, Water};

/// State of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T = f64> {
    /// Position of the body's origin: north, east, down \[m\].
    pub position: Three<T>,
    /// Attitude, from the body to the fixed frame.
    pub attitude: Quaternion<T>,
    /// `nu`: u, v, w \[m/s\], p, q, r \[rad/s\], over ground.
    pub velocity: Six<T>,
}

impl<T: Real> State<T> {
    /// The state as one row: position, attitude, velocity.
    #[inline(always)]
    #[must_use]
    pub fn row(&self) -> [T; 13] {
        let ([x, y, z], [a, b, c, d], [u, v, w, p, q, r]) =
            (self.position, self.attitude, self.velocity);
        [x, y, z, a, b, c, d, u, v, w, p, q, r]
    }

    /// The state from such a row.
    #[inline(always)]
    #[must_use]
    pub fn of_row([x, y, z, a, b, c, d, u, v, w, p, q, r]: [T; 13]) -> Self {
        Self {
            position: [x, y, z],
            attitude: [a, b, c, d],
            velocity: [u, v, w, p, q, r],
        }
    }
}

/// The terms on the right-hand side of `M nu' = ...`: forces \[N\] and moments \[N m\] about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces<T = f64> {
    /// `-C_RB(nu) nu`
    pub rigid_body_coriolis: Six<T>,
    /// `-C_A(nu_r) nu_r`, including the Munk moment.
    pub added_mass_coriolis: Six<T>,
    /// `M_A nu_c'`, and the pressure gradient of accelerating water.
    pub current_acceleration: Six<T>,
    /// `-g`: weight and buoyancy.
    pub restoring: Six<T>,
    /// `-D(nu_r) nu_r`: damping matrices and cross-flow drag.
    pub damping: Six<T>,
    /// Coefficients beyond added mass: hull lift, drag by products, fins given by `u^2 delta`.
    pub coefficients: Six<T>,
    /// Fins in the flow at their own position.
    pub fins: Six<T>,
    /// Propellers and thrusters.
    pub propulsion: Six<T>,
    /// Surface and bottom.
    pub boundaries: Six<T>,
}

impl<T: Real> Forces<T> {
    /// Sum of all terms.
    #[inline(always)]
    #[must_use]
    pub fn total(&self) -> Six<T> {
        let mut total = sum(self.rigid_body_coriolis, self.added_mass_coriolis);
        for part in [
            self.current_acceleration,
            self.restoring,
            self.damping,
            self.coefficients,
            self.fins,
            self.propulsion,
            self.boundaries,
        ] {
            total = sum(total, part);
        }
        total
    }
}

/// Constant inputs, with the terms that depend only on these inputs.
pub(super) struct FixedTerms<'a, T> {
    inputs: &'a [T],
    /// Thrust of the propulsors that do not depend on the flow.
    thrust: Six<T>,
    /// The others.
    in_flow: &'a [Propulsor],
}

impl Vehicle {
    /// Forces and moments on the vehicle by term; `inputs` are in the vehicle's order.
    #[inline(always)]
    #[must_use]
    pub fn forces<T: Real>(&self, state: &State<T>, inputs: &[T], water: &Water<T>) -> Forces<T> {
        let r = rotation::matrix(state.attitude);
        self.forces_at(&r, state, &self.held(inputs), water)
    }

    /// Prepares constant inputs and the thrust that depends only on them: the thrust of the propulsors before the first one that depends on the flow.
    #[inline(always)]
    pub(super) fn held<'a, T: Real>(&'a self, inputs: &'a [T]) -> FixedTerms<'a, T> {
        let propulsors = &self.parts.propulsors;
        let still = propulsors
            .iter()
            .take_while(|one| !one.feels_flow())
            .count();
        let (still, in_flow) = propulsors.split_at(still);
        let zero = [T::of(0.0); 6];
        let thrust = still.iter().fold(zero, |thrust, propulsor| {
            sum(thrust, propulsor.force(&zero, inputs))
        });
        FixedTerms {
            inputs,
            thrust,
            in_flow,
        }
    }

    /// The forces, given the rotation matrix of the attitude.
    #[inline(always)]
    fn forces_at<T: Real>(
        &self,
        r: &[Three<T>; 3],
        state: &State<T>,
        held: &FixedTerms<'_, T>,
        water: &Water<T>,
    ) -> Forces<T> {
        let (nu, inputs) = (state.velocity, held.inputs);
        let (_, turning) = halves(nu);
        let [c_x, c_y, c_z] = rotation::to_body(r, water.velocity);
        let zero = T::of(0.0);
        let through = difference(nu, [c_x, c_y, c_z, zero, zero, zero]);
        let follows = rotation::to_body(r, water.acceleration);
        let carried = sum(cross([c_x, c_y, c_z], turning), follows);
        let gradient = rotation::to_body(r, water.of_water);
        let mut damping = self.parts.damping.force(&through);
        for hull in &self.parts.cross_flow {
            damping = sum(damping, hull.force(&through));
        }
        let mut coefficients = [zero; 6];
        for term in &self.parts.terms {
            coefficients[term.row] += term.force(&through, inputs);
        }
        let mut fins = [zero; 6];
        for fin in &self.parts.fins {
            fins = sum(fins, fin.force(&through, inputs[fin.input]));
        }
        let mut propulsion = held.thrust;
        for propulsor in held.in_flow {
            propulsion = sum(propulsion, propulsor.force(&through, inputs));
        }
        Forces {
            rigid_body_coriolis: self.parts.body.coriolis(&nu),
            added_mass_coriolis: coriolis(&self.parts.added_mass, &through),
            current_acceleration: sum(
                product(&self.parts.added_mass, &six(carried, [zero; 3])),
                self.at_buoyancy(scaled(T::of(self.parts.buoyancy / GRAVITY), gradient)),
            ),
            restoring: self.restoring(r),
            damping,
            coefficients,
            fins,
            propulsion,
            boundaries: self.boundaries(r, state, water),
        }
    }

    /// A force at the centre of buoyancy, with its moment about the origin.
    #[inline(always)]
    fn at_buoyancy<T: Real>(&self, force: Three<T>) -> Six<T> {
        six(force, cross(of(&self.parts.centre_of_buoyancy), force))
    }

    /// `-g = ( (W-B) k , r_g x W k - r_b x B k )`, with `k` down in body axes.
    #[inline(always)]
    fn restoring<T: Real>(&self, r: &[Three<T>; 3]) -> Six<T> {
        let down = r[2];
        let weight = scaled(T::of(self.parts.weight), down);
        let moment = cross(of(&self.parts.body.centre_of_gravity), weight);
        let buoyancy = self.at_buoyancy(scaled(T::of(-self.parts.buoyancy), down));
        sum(six(weight, moment), buoyancy)
    }

    /// `nu'` \[m/s^2, rad/s^2\].
    #[inline(always)]
    #[must_use]
    pub fn acceleration<T: Real>(
        &self,
        state: &State<T>,
        inputs: &[T],
        water: &Water<T>,
    ) -> Six<T> {
        product(
            &self.inverse_inertia,
            &self.forces(state, inputs, water).total(),
        )
    }

    /// Derivative of the state, as a row.
    #[inline(always)]
    #[must_use]
    pub fn derivative<T: Real>(&self, state: &State<T>, inputs: &[T], water: &Water<T>) -> [T; 13] {
        self.derivative_under(state, &self.held(inputs), water)
    }

    /// The derivative of the state, with prepared inputs.
    #[inline(always)]
    pub(super) fn derivative_under<T: Real>(
        &self,
        state: &State<T>,
        held: &FixedTerms<'_, T>,
        water: &Water<T>,
    ) -> [T; 13] {
        let (linear, turning) = halves(state.velocity);
        let r = rotation::matrix(state.attitude);
        let forces = self.forces_at(&r, state, held, water);
        State {
            position: rotation::to_fixed(&r, linear),
            attitude: rotation::rate(state.attitude, turning),
            velocity: product(&self.inverse_inertia, &forces.total()),
        }
        .row()
    }

    /// `M_RB + M_A`.
    #[must_use]
    pub fn inertia(&self) -> Matrix6 {
        super::inertia::added(&self.parts.body.matrix(), &self.parts.added_mass)
    }
}
