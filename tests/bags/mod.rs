//! Bags of foreign messages for the tests, written raw.

// Each test program uses its own part.
#![allow(dead_code)]

use std::path::Path;
use std::sync::Arc;

use planesman_bag::{BagWriter, Compression, OfferedQos, Topic, TopicId, TopicKind, WriterOptions};
use planesman_msgs::sensor_msgs::msg::Imu;
use planesman_msgs::{Message, cdr};

/// Type, schema encoding and schema of a topic.
pub(crate) type Kind<'a> = (&'a str, &'a str, &'a str);

pub(crate) const FLOAT: Kind<'static> = ("std_msgs/msg/Float64", "ros2msg", "float64 data\n");
pub(crate) const IMU: Kind<'static> = (Imu::TYPE_NAME, "ros2msg", Imu::DEFINITION);

/// Writes a bag in one file.
pub(crate) struct Maker(BagWriter);

impl Maker {
    pub(crate) fn new(path: &Path) -> Self {
        let options = WriterOptions {
            compression: Compression::None,
            chunk_size: 4000,
            flush_interval: None,
            ..WriterOptions::default()
        };
        Self(BagWriter::create_file(path, options).unwrap())
    }

    pub(crate) fn topic(&mut self, name: &str, kind: Kind<'_>) -> TopicId {
        self.topic_of(name, kind, "cdr")
    }

    /// A topic whose messages are encoded so.
    pub(crate) fn topic_of(
        &mut self,
        name: &str,
        (kind, encoding, definition): Kind<'_>,
        messages: &str,
    ) -> TopicId {
        self.0
            .add_topic(&Topic {
                name: name.to_owned(),
                kind: Arc::new(TopicKind {
                    type_name: kind.to_owned(),
                    definition: definition.to_owned(),
                    definition_encoding: encoding.to_owned(),
                    message_encoding: messages.to_owned(),
                    type_hash: String::new(),
                    offered_qos: vec![OfferedQos::reliable(1)],
                }),
            })
            .unwrap()
    }

    pub(crate) fn write(&mut self, topic: TopicId, payload: &[u8], time: i64) {
        self.0.write_raw(topic, payload, time, time).unwrap();
    }

    pub(crate) fn close(self) {
        self.0.close().unwrap();
    }
}

/// The payload of a `std_msgs/msg/Float64`.
pub(crate) fn float(value: f64) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat()
}

/// The payload of a `sensor_msgs/msg/Imu` whose pitch rate is `value`.
pub(crate) fn imu(stamp: i64, value: f64) -> Vec<u8> {
    let mut imu = Imu::default();
    imu.header.stamp.sec = stamp.div_euclid(1_000_000_000) as i32;
    imu.header.stamp.nanosec = stamp.rem_euclid(1_000_000_000) as u32;
    imu.header.frame_id = "imu".to_owned();
    imu.angular_velocity.y = value;
    imu.orientation.y = value;
    cdr::to_bytes(&imu)
}
