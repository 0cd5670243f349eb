//! An estimator of one's own in place of `sysid`, compared with the vehicle's own model: least squares of one equation,
//! `q(k+1) = a q(k) + b delta(k) + c`, by its normal equations.
//!
//! cargo run -p planesman_flight --example own_estimator

use anyhow::{Context as _, Result};
use nalgebra::{Matrix3, Vector3};
use planesman_flight::parts::{Estimator, Model, PartError, Parts};
use planesman_flight::{Loop, Scenario, summary};
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, PlaneMotion, VehicleState};

/// The sums of the normal equations, and the row whose outcome the next state is.
#[derive(Default)]
struct LeastSquares {
    tick: f64,
    information: Matrix3<f64>,
    product: Vector3<f64>,
    samples: u64,
    row: Option<Vector3<f64>>,
}

impl Estimator for LeastSquares {
    fn learn(
        &mut self,
        state: &VehicleState,
        motion: &PlaneMotion,
    ) -> Result<Vec<Model>, PartError> {
        if let Some(row) = self.row {
            self.information += row * row.transpose();
            self.product += row * state.pitch_rate;
            self.samples += 1;
        }
        let planes = &motion.dive_planes;
        let mean = planes.iter().sum::<f64>() / planes.len() as f64;
        self.row = Some(Vector3::new(state.pitch_rate, mean, 1.0));
        let Some(inverse) = self.information.try_inverse() else {
            return Ok(Vec::new());
        };
        let theta = inverse * self.product;
        let mut model = ModelEstimate {
            name: "model".to_owned(),
            estimator: "own least squares".to_owned(),
            order: 1,
            valid: self.samples > 100,
            samples: self.samples,
            sample_time: self.tick,
            a: vec![-theta[0]],
            b: vec![theta[1]],
            ..ModelEstimate::default()
        };
        model.header.stamp = state.header.stamp.clone();
        Ok(vec![Model::Made(Box::new(model))])
    }
}

fn main() -> Result<()> {
    let scenario = Scenario::load("dive")?;
    let parts = Parts::default().with_estimator(|scenario| {
        anyhow::Ok(LeastSquares {
            tick: scenario.tick,
            ..LeastSquares::default()
        })
    });
    let ticks = Loop::of_parts(&parts, &scenario)?.collect::<Result<Vec<_>, _>>()?;
    let model = ticks.iter().rev().find_map(|it| it.models.last());
    let model = model.context("no model")?;
    let pole = libm::log(-model.a[0]) / model.sample_time;
    let truth = summary::truth_of(&scenario.parameters_of("plant_sim")?, scenario.tick)?;
    println!(
        "identified pole {pole:.3} 1/s from {} samples",
        model.samples
    );
    println!("the vehicle's own poles {:.3?} 1/s", truth.poles);
    Ok(())
}
