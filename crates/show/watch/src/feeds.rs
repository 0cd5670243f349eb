//! Subscriptions to topics of any message type; the numbers are decoded by the type's definition.

use std::collections::BTreeMap;

use planesman_decode::{Catalogue, DecodeError, Decoder, FieldPath, Types, Values, schema};
use planesman_node::{Definition, Losses, RawSample};

use crate::{Error, units};

/// Maximum number of listed fields per topic.
const MAX_FIELDS: usize = 500;

/// A subscribed topic.
pub(crate) struct Feed {
    pub(crate) topic: String,
    pub(crate) type_name: String,
    types: Types,
    stamp: Option<FieldPath>,
    /// SI units of the fields, if the definition states them.
    units: BTreeMap<String, &'static str>,
    /// Channels with their fields.
    channels: Vec<(String, FieldPath)>,
    decoder: Decoder,
    values: Values,
    pub(crate) losses: Losses,
    pub(crate) received: u64,
    /// The reason why the last message could not be read.
    pub(crate) trouble: Option<String>,
}

impl Feed {
    /// A feed without channels.
    pub(crate) fn new(
        topic: &str,
        type_name: &str,
        definition: &Definition,
    ) -> Result<Self, Error> {
        let types = schema::read(type_name, "ros2msg", &definition.text)?;
        let mut feed = Self {
            topic: topic.to_owned(),
            type_name: type_name.to_owned(),
            stamp: types.stamp(),
            units: units::of_fields(&definition.text),
            decoder: Decoder::compile(&types, &[])?,
            types,
            channels: Vec::new(),
            values: Values::default(),
            losses: Losses::default(),
            received: 0,
            trouble: None,
        };
        feed.compile(&[])?;
        Ok(feed)
    }

    /// Adds a channel that reads this field.
    pub(crate) fn add(&mut self, channel: &str, field: &str) -> Result<(), Error> {
        if self.channels.iter().any(|(name, _)| name == channel) {
            return Ok(());
        }
        let path: FieldPath = field
            .parse()
            .map_err(|error| Error::Path(field.to_owned(), error))?;
        self.compile(&[(channel.to_owned(), path)])
    }

    fn compile(&mut self, more: &[(String, FieldPath)]) -> Result<(), Error> {
        let channels = [&self.channels, more].concat();
        let stamp = self.stamp.iter();
        let parts = stamp.flat_map(|path| ["sec", "nanosec"].map(|part| path.field(part)));
        let paths: Vec<_> = parts
            .chain(channels.iter().map(|(_, path)| path.clone()))
            .collect();
        self.decoder = Decoder::compile(&self.types, &paths)?;
        self.channels = channels;
        Ok(())
    }

    /// The numeric fields, each with its SI unit, empty if unknown.
    pub(crate) fn fields(&self) -> Vec<(String, &'static str)> {
        let fields = Catalogue::of(&self.types, MAX_FIELDS).fields;
        let with_unit = |path: &FieldPath| {
            let path = path.to_string();
            let own = path.split('[').next().unwrap_or_default();
            let unit = self.units.get(own).copied().unwrap_or_default();
            (path, unit)
        };
        fields.iter().map(with_unit).collect()
    }

    /// Decodes a message and returns its stamp, s, if it has one; [`Feed::numbers`] then returns its numbers.
    pub(crate) fn read(&mut self, sample: &RawSample) -> Result<Option<f64>, DecodeError> {
        self.received += 1;
        self.losses.received(sample.publisher, sample.sequence);
        let outcome = self.decoder.read(&sample.bytes, &mut self.values);
        self.trouble = outcome.as_ref().err().map(ToString::to_string);
        outcome?;
        let part = |index| self.values.number(index);
        Ok(self
            .stamp
            .as_ref()
            .and_then(|_| Some(part(0)? + part(1)? * 1e-9)))
    }

    /// The channels with the numbers of the last message; missing elements of a list are left out.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = (&str, f64)> {
        let first = if self.stamp.is_some() { 2 } else { 0 };
        let numbered = self.channels.iter().enumerate();
        numbered
            .filter_map(move |(k, (name, _))| Some((name.as_str(), self.values.number(first + k)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::builtin_interfaces::msg::Time;
    use planesman_msgs::planesman_msgs::msg::VehicleState;
    use planesman_msgs::{Message, cdr};

    #[test]
    fn numbers_are_read_with_the_stamp_and_a_wrong_field_is_refused_and_forgotten() {
        let definition = Definition {
            text: VehicleState::DEFINITION.to_owned(),
            type_hash: String::new(),
        };
        let mut feed = Feed::new("/auv/state", VehicleState::TYPE_NAME, &definition).expect("ours");
        feed.add("/auv/state:depth", "depth").expect("a field");
        let refusal = feed
            .add("/auv/state:dept", "dept")
            .expect_err("no such field")
            .to_string();
        assert!(refusal.contains("depth"), "{refusal}");
        assert!(feed.fields().contains(&("pitch_rate".to_owned(), "rad/s")));
        let mut state = VehicleState {
            depth: 1.5,
            ..VehicleState::default()
        };
        state.header.stamp = Time::from_nanos(2_500_000_000);
        let mut sample = RawSample {
            topic: "/auv/state".to_owned(),
            bytes: cdr::to_bytes(&state),
            published: None,
            received: Time::default(),
            sequence: 1,
            publisher: [0; 16],
        };
        assert_eq!(feed.read(&sample).expect("whole"), Some(2.5));
        assert_eq!(
            feed.numbers().collect::<Vec<_>>(),
            [("/auv/state:depth", 1.5)]
        );
        sample.bytes.truncate(20);
        assert!(feed.read(&sample).is_err() && feed.trouble.is_some());
    }
}
