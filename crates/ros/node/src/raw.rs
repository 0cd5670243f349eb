//! Raw subscriptions: undecoded payloads, for recording.
//!
//! The middleware's subscriptions return decoded values only. Here the "decoded value" is the payload itself, so a raw reader is an ordinary ROS
//! subscription that `ros2 node info` lists.

use std::fmt;

use planesman_msgs::builtin_interfaces::msg::Time;
use ros2_client::MessageInfo;
use rustdds::{GUID, RepresentationIdentifier, serialization::payload_at_hand};
use serde::de::{DeserializeSeed, Deserializer, SeqAccess, Visitor};

/// An undecoded sample.
#[derive(Clone, Debug, PartialEq)]
pub struct RawSample {
    /// Absolute name of the topic.
    pub topic: String,
    /// Payload with its 4-byte encapsulation header (whose padding count is 0).
    pub bytes: Vec<u8>,
    /// Time of publication, if known.
    pub published: Option<Time>,
    /// Time of reception.
    pub received: Time,
    /// Sequence number of the publisher, from 1.
    pub sequence: i64,
    /// Identity of the publisher (GID).
    pub publisher: [u8; 16],
}

impl RawSample {
    pub(crate) fn new(topic: &str, bytes: Vec<u8>, info: &MessageInfo) -> Self {
        let time = |stamp: ros2_client::ROSTime| Time::from_nanos(stamp.to_nanos());
        Self {
            topic: topic.to_owned(),
            bytes,
            published: info.source_timestamp().map(time),
            received: info
                .received_timestamp()
                .map_or_else(crate::clock::wall, time),
            sequence: info.sequence_number(),
            publisher: GUID::from(info.publisher_gid()).to_bytes(),
        }
    }
}

/// "Decodes" a CDR payload as its own bytes, all at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WholePayload;

impl<'de> DeserializeSeed<'de> for WholePayload {
    type Value = Vec<u8>;

    fn deserialize<D: Deserializer<'de>>(self, payload: D) -> Result<Vec<u8>, D::Error> {
        let Some((encoding, body)) = payload_at_hand() else {
            return Payload.deserialize(payload);
        };
        let little_endian = matches!(
            encoding,
            RepresentationIdentifier::CDR_LE | RepresentationIdentifier::PL_CDR_LE
        );
        Ok([&[0, u8::from(little_endian), 0, 0], &*body].concat())
    }
}

/// "Decodes" the rest of a CDR payload as its own bytes, one by one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Payload;

impl<'de> DeserializeSeed<'de> for Payload {
    type Value = Vec<u8>;

    fn deserialize<D: Deserializer<'de>>(self, payload: D) -> Result<Vec<u8>, D::Error> {
        // The byte order is a type parameter of the CDR deserializer and shows nowhere else.
        let little_endian = !std::any::type_name::<D>().contains("BigEndian");
        let header = vec![0, u8::from(little_endian), 0, 0];
        payload.deserialize_tuple(usize::MAX, Bytes(header))
    }
}

/// Collects the bytes after a header until the payload ends.
struct Bytes(Vec<u8>);

impl<'de> Visitor<'de> for Bytes {
    type Value = Vec<u8>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the bytes of a payload")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut bytes: A) -> Result<Vec<u8>, A::Error> {
        // The end of the payload is an error to a decoder, and all we wait for.
        while let Ok(Some(byte)) = bytes.next_element() {
            self.0.push(byte);
        }
        Ok(self.0)
    }
}

#[cfg(test)]
mod tests {
    use rustdds::serialization::deserialize_from_cdr_with_decoder_and_rep_id;

    use super::*;

    #[test]
    fn a_payload_comes_back_byte_for_byte_in_either_order() {
        let body: Vec<u8> = (0..=255).collect();
        for (encoding, header) in [
            (RepresentationIdentifier::CDR_LE, [0, 1, 0, 0]),
            (RepresentationIdentifier::CDR_BE, [0, 0, 0, 0]),
        ] {
            let (bytes, _) = deserialize_from_cdr_with_decoder_and_rep_id(&body, encoding, Payload)
                .expect("every payload is bytes");
            assert_eq!(bytes, [&header[..], &body].concat());
        }
    }
}
