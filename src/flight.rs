//! A flight as its bag tells it: the series that the summary and the page are made of.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use depth_controller::gains::pitch_model::{FIRST_PAIR, is_of_pitch};
use planesman_bag::reader::{BagReader, Order};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, PlaneCommand, PlaneMotion, VehicleState,
};
use planesman_msgs::{Message, cdr};

/// The messages of one flight, in the order of their stamps.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// The vehicle's true states.
    pub states: Vec<VehicleState>,
    /// The controller's inside.
    pub controls: Vec<ControlState>,
    /// The plane commands.
    pub commands: Vec<PlaneCommand>,
    /// The plane motion within each tick.
    pub motions: Vec<PlaneMotion>,
    /// The actuators' inside, by the planes they move.
    pub actuators: BTreeMap<String, Vec<DhaState>>,
    /// The identified models of pitch rate over plane angle; of several pairs' that of sysid's
    /// first, or that which spoke first.
    pub models: Vec<ModelEstimate>,
    /// Messages per topic.
    pub counts: BTreeMap<String, u64>,
    /// Why the bag is not whole, `None` when it is.
    pub truncated: Option<String>,
}

impl Flight {
    /// The flight in a bag. Topics are recognised by their last name, in any namespace.
    ///
    /// # Errors
    /// When the path is no bag, or a message of ours does not decode.
    pub fn read(path: &Path) -> Result<Self> {
        let mut flight = Self::default();
        let bag = BagReader::open(path)?;
        for message in bag.messages(Order::File) {
            let message = message?;
            let topic = &message.topic.name;
            flight
                .add(topic, &message.payload)
                .with_context(|| format!("bag '{}', topic {topic}", path.display()))?;
        }
        if !bag.completeness().is_whole() {
            flight.truncated = Some(bag.completeness().to_string());
        }
        flight.arrange();
        Ok(flight)
    }

    /// Takes one recorded message.
    fn add(&mut self, topic: &str, payload: &[u8]) -> Result<()> {
        *self.counts.entry(topic.to_owned()).or_default() += 1;
        match topic.rsplit('/').next().unwrap_or(topic) {
            "state" => self.states.push(decode(payload)?),
            "control_state" => self.controls.push(decode(payload)?),
            "plane_command" => self.commands.push(decode(payload)?),
            "plane_motion" => self.motions.push(decode(payload)?),
            "model" => self.models.push(decode(payload)?),
            name if name.starts_with("dha_state") => {
                let state: DhaState = decode(payload)?;
                let group = self.actuators.entry(state.group.clone());
                group.or_default().push(state);
            }
            _ => {}
        }
        Ok(())
    }

    /// Sorts by stamps, and picks the models.
    fn arrange(&mut self) {
        self.states.sort_by_key(|m| m.header.stamp.nanos());
        self.controls.sort_by_key(|m| m.header.stamp.nanos());
        self.commands.sort_by_key(|m| m.header.stamp.nanos());
        self.motions.sort_by_key(|m| m.header.stamp.nanos());
        for states in self.actuators.values_mut() {
            states.sort_by_key(|m| m.header.stamp.nanos());
        }
        self.models.sort_by_key(|m| m.header.stamp.nanos());
        self.models.retain(is_of_pitch);
        let of_first = self.models.iter().find(|m| m.name == FIRST_PAIR);
        if let Some(chosen) = of_first.or(self.models.first()) {
            let name = chosen.name.clone();
            self.models.retain(|m| m.name == name);
        }
    }

    /// Seconds from the first state to a stamp.
    #[must_use]
    pub fn seconds(&self, stamp: &Time) -> f64 {
        let start = self.states.first().map_or(0, |s| s.header.stamp.nanos());
        (stamp.nanos() - start) as f64 * 1e-9
    }

    /// The depth over time: (s, m).
    #[must_use]
    pub fn depth(&self) -> Vec<(f64, f64)> {
        self.states
            .iter()
            .map(|s| (self.seconds(&s.header.stamp), s.depth))
            .collect()
    }

    /// The plane angle as the actuator moved it: (s, rad), several points a tick.
    #[must_use]
    pub fn plane_angle(&self) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for motion in &self.motions {
            let start = self.seconds(&motion.header.stamp);
            let duration = motion.duration.nanos() as f64 * 1e-9;
            let last = motion.dive_planes.len().saturating_sub(1).max(1) as f64;
            for (i, angle) in motion.dive_planes.iter().enumerate().step_by(5) {
                points.push((start + duration * i as f64 / last, *angle));
            }
        }
        points
    }

    /// The last model that calls itself valid.
    #[must_use]
    pub fn final_model(&self) -> Option<&ModelEstimate> {
        self.models.iter().rev().find(|m| m.valid)
    }
}

fn decode<M: Message>(payload: &[u8]) -> Result<M> {
    cdr::from_bytes(payload).map_err(|e| anyhow::anyhow!("{}: {e}", M::TYPE_NAME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_pairs_models_only_those_of_pitch_by_the_first_pair_are_a_flights() {
        let of = |name: &str, output: &str, samples| ModelEstimate {
            name: name.to_owned(),
            input: "plane_motion:dive_planes".to_owned(),
            output: output.to_owned(),
            samples,
            valid: true,
            ..ModelEstimate::default()
        };
        let mut flight = Flight {
            models: vec![
                of("heave", "state:heave", 1),
                of("filtered", "state:pitch_rate", 2),
                of("model", "state:pitch_rate", 3),
                of("filtered", "state:pitch_rate", 4),
                of("heave", "state:heave", 5),
            ],
            ..Flight::default()
        };
        flight.arrange();
        let samples: Vec<u64> = flight.models.iter().map(|m| m.samples).collect();
        assert_eq!(samples, vec![3]);
        assert_eq!(flight.final_model().map(|m| m.samples), Some(3));
    }
}
