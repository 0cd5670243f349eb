//! A depth law of one's own, flown and swept: a linear-quadratic regulator in place of `depth_controller`.
//!
//! cargo run -p planesman_flight --example own_law

use anyhow::{Context as _, Result};
use nalgebra::{DMatrix, RowVector4, Vector4};
use planesman_flight::parts::{Law, PartError, Parts, dive};
use planesman_flight::sweep::{Part, Sweep};
use planesman_flight::{Loop, Scenario};
use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand, VehicleState};
use planesman_plant::PlantParameters;
use planesman_vehicle::{linearised, vehicle_file};

/// `delta = delta_0 - K (x - x_0)`, x = (heave, pitch rate, pitch, depth), within 0.35 rad.
struct Regulator {
    gain: RowVector4<f64>,
    setpoint: f64,
}

impl Regulator {
    /// The regulator that minimises `sum (z/0.05)^2 + (theta/0.3)^2 + (delta/0.2)^2` of the scenario's vehicle about level flight.
    fn new(scenario: &Scenario) -> Result<Self> {
        let plant: PlantParameters = scenario.parameters_of("plant_sim")?;
        let vehicle = vehicle_file::load_on(&plant.vehicle, &plant.vehicle_base)?;
        let system = linearised::state_space(&vehicle, plant.speed)?;
        let system = system.zero_order_hold(scenario.tick)?;
        let weights = [0.0, 0.0, 0.3_f64.powi(-2), 0.05_f64.powi(-2)];
        Ok(Self {
            gain: riccati(
                &system.a,
                &system.b,
                &DMatrix::from_diagonal(&weights.to_vec().into()),
                0.2_f64.powi(-2),
            )?,
            setpoint: 0.9144,
        })
    }
}

/// `K = (R + B' P B)^-1 B' P A` of the P that `P = Q + A' P (A - B K)` comes to.
fn riccati(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: f64,
) -> Result<RowVector4<f64>> {
    let mut p = q.clone();
    for _ in 0..100_000 {
        let k = b.transpose() * &p * a / (r + (b.transpose() * &p * b)[(0, 0)]);
        let next = q + a.transpose() * &p * (a - b * &k);
        if (&next - &p).amax() <= 1e-9 * next.amax() {
            return Ok(RowVector4::from_iterator(k.iter().copied()));
        }
        p = next;
    }
    None.context("the Riccati equation does not converge")
}

impl Law for Regulator {
    fn on_state(
        &mut self,
        state: &VehicleState,
    ) -> Result<(PlaneCommand, ControlState), PartError> {
        let depth = state.depth - self.setpoint;
        // Far from the depth, no steeper than it dives from 0.3 m.
        let x = Vector4::new(
            state.heave,
            state.pitch_rate,
            state.pitch,
            depth.clamp(-0.3, 0.3),
        );
        let planes = -(self.gain * x)[0];
        Ok(dive(state, planes.clamp(-0.35, 0.35), self.setpoint))
    }
}

fn main() -> Result<()> {
    let scenario = Scenario::load("dive")?;
    let parts = Parts::default().with_law(Regulator::new);
    println!("K = {:.3?}", Regulator::new(&scenario)?.gain.as_slice());

    let last = Loop::of_parts(&parts, &scenario)?
        .last()
        .context("no tick")??;
    println!("depth after 90 s: {:.4} m", last.observation.state.depth);

    let vary = ["plant_sim.speed=0.25,0.3048,0.4".to_owned()];
    let sweep = Sweep::new(scenario, &vary, None, 1)?.with_parts(parts);
    for place in 0..sweep.cases(Part::ALL) {
        let case = sweep.case(Part::ALL, place)?;
        println!(
            "{} m/s: settles within 5 % after {:?} s",
            case.values[0], case.numbers[4]
        );
    }
    Ok(())
}
