//! The vertical plane of a vehicle with six degrees of freedom: derivatives for level flight at a speed.

use super::equations::State;
use super::tick::{Commands, Tick};
use super::water::Water;
use crate::body::Positions;
use crate::vehicle::Derivatives;

/// Half the interval of a central difference, in SI; small, since drag by `w|w|` has a corner at 0.
const HALF: f64 = 1e-6;

impl Tick {
    /// Linear derivatives of heave and pitch at a speed through the water \[m/s\], all else constant: the model for a controller of the
    /// vertical plane.
    ///
    /// Heave is the velocity of the body's origin. Sway, roll and yaw are omitted; they are coupled to heave and pitch only in a vehicle
    /// without symmetry.
    #[must_use]
    pub fn derivatives(&self, speed: f64) -> Derivatives {
        let of = self.vehicle();
        let count = of.parts().inputs.len();
        let force = |w: f64, q: f64, planes: Positions| {
            let state = State {
                position: [0.0; 3],
                attitude: [1.0, 0.0, 0.0, 0.0],
                velocity: [speed, 0.0, w, 0.0, q, 0.0],
            };
            let mut inputs = vec![0.0; count];
            self.put_inputs(&planes, Commands::NONE, 0.0, &mut inputs);
            let total = of.forces(&state, &inputs, &Water::at_rest()).total();
            [total[2], total[4]]
        };
        let slope = |at: &dyn Fn(f64) -> [f64; 2]| {
            let (after, before) = (at(HALF), at(-HALF));
            [0, 1].map(|i| (after[i] - before[i]) / (2.0 * HALF))
        };
        let planes = |dive_planes, bow_stern_differential| Positions {
            dive_planes,
            bow_stern_differential,
            ..Positions::default()
        };
        let [z_w, m_w] = slope(&|w| force(w, 0.0, Positions::default()));
        let [z_q, m_q] = slope(&|q| force(0.0, q, Positions::default()));
        let [z_delta, m_delta] = slope(&|d| force(0.0, 0.0, planes(d, 0.0)));
        let [z_differential, m_differential] = slope(&|d| force(0.0, 0.0, planes(0.0, d)));
        let (inertia, parts) = (of.inertia(), of.parts());
        let (gravity, buoyancy) = (parts.body.centre_of_gravity, parts.centre_of_buoyancy);
        Derivatives {
            speed,
            heave_inertia: inertia[2][2],
            z_w,
            z_q_plus_m_u: z_q,
            z_delta,
            pitch_inertia: inertia[4][4],
            m_w,
            m_q,
            m_delta,
            z_differential,
            m_differential,
            restoring: parts.weight * gravity[2] - parts.buoyancy * buoyancy[2],
            z_q_dot: -inertia[2][4],
            m_w_dot: -inertia[4][2],
            z_ww: 0.0,
            z_qq: 0.0,
            m_ww: 0.0,
            m_qq: 0.0,
            first_moment: parts.body.mass * gravity[2],
            excess_weight: parts.weight - parts.buoyancy,
        }
    }
}
