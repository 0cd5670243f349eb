//! An actuator of one's own: a servo with a rate limit in place of `dha_actuator`.
//!
//! cargo run -p planesman_flight --example own_actuator

use std::sync::Arc;

use anyhow::{Context as _, Result};
use planesman_flight::parts::{Actuator, Motion, PartError, Parts};
use planesman_flight::{Loop, Scenario};
use planesman_msgs::builtin_interfaces::msg::Duration;
use planesman_msgs::planesman_msgs::msg::{PlaneCommand, PlaneMotion};

/// Moves towards the commanded angle at no more than so many rad/s.
struct Servo {
    angle: f64,
    most_per_tick: f64,
    tick: f64,
}

impl Actuator for Servo {
    fn on_command(&mut self, command: &PlaneCommand) -> Result<Arc<dyn Motion>, PartError> {
        let from = self.angle;
        let step = command.dive_planes - from;
        self.angle += step.clamp(-self.most_per_tick, self.most_per_tick);
        Ok(Arc::new(PlaneMotion {
            header: command.header.clone(),
            duration: Duration {
                sec: 0,
                nanosec: (self.tick * 1e9).round() as u32,
            },
            dive_planes: vec![from, self.angle],
            ..PlaneMotion::default()
        }))
    }
}

fn main() -> Result<()> {
    let scenario = Scenario::load("dive")?;
    for rate in [0.05, 0.2, 1.0] {
        let parts = Parts::default().with_actuator(move |scenario| {
            anyhow::Ok(Servo {
                angle: 0.0,
                most_per_tick: rate * scenario.tick,
                tick: scenario.tick,
            })
        });
        let deepest = Loop::of_parts(&parts, &scenario)?
            .map(|tick| tick.map(|it| it.observation.state.depth))
            .collect::<Result<Vec<f64>, _>>()?
            .into_iter()
            .reduce(f64::max)
            .context("no tick")?;
        println!("{rate} rad/s: deepest {deepest:.3} m");
    }
    Ok(())
}
