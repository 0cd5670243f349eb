//! A plant of one's own: pitch, pitch rate and depth by three equations in place of `plant_sim`.
//!
//! cargo run -p planesman_flight --example own_plant

use anyhow::{Context as _, Result};
use planesman_flight::parts::{PartError, Parts, Plant};
use planesman_flight::{Loop, Scenario};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, VehicleState};

/// `q' = -1.2 q - 0.3 theta - 0.5 delta`, `theta' = q`, `z' = -U sin theta`: Euler steps over the samples of the planes.
struct Glider {
    speed: f64,
    tick: f64,
    pitch_rate: f64,
    pitch: f64,
    depth: f64,
    distance: f64,
}

impl Plant for Glider {
    fn state(&self, stamp: Time) -> VehicleState {
        let mut state = VehicleState {
            distance: self.distance,
            depth: self.depth,
            depth_rate: -self.speed * libm::sin(self.pitch),
            pitch: self.pitch,
            pitch_rate: self.pitch_rate,
            surge: self.speed,
            ..VehicleState::default()
        };
        state.header.stamp = stamp;
        state.header.frame_id = "map_ned".to_owned();
        state
    }

    fn advance(&mut self, motion: &PlaneMotion) -> Result<(), PartError> {
        let dt = self.tick / motion.dive_planes.len() as f64;
        for delta in &motion.dive_planes {
            self.pitch_rate += dt * (-1.2 * self.pitch_rate - 0.3 * self.pitch - 0.5 * delta);
            self.pitch += dt * self.pitch_rate;
            self.depth -= dt * self.speed * libm::sin(self.pitch);
            self.distance += dt * self.speed * libm::cos(self.pitch);
        }
        Ok(())
    }
}

fn main() -> Result<()> {
    let scenario = Scenario::load("dive")?;
    let parts = Parts::default().with_plant(|scenario| {
        anyhow::Ok(Glider {
            speed: 0.3048,
            tick: scenario.tick,
            pitch_rate: 0.0,
            pitch: 0.0,
            depth: 0.0,
            distance: 0.0,
        })
    });
    let last = Loop::of_parts(&parts, &scenario)?
        .last()
        .context("no tick")??;
    println!("depth after 90 s: {:.3} m", last.observation.state.depth);
    Ok(())
}
