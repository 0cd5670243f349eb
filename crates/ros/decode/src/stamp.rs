//! Stamps of messages.

use crate::{Decoder, FieldPath, Types, Values};

/// Decoder of the stamps of messages of one type.
#[derive(Debug)]
pub struct StampDecoder(Decoder);

impl StampDecoder {
    /// Decoder of the type's stamp ([`Types::stamp`]); `None` for a type without a stamp.
    #[must_use]
    pub fn of(types: &Types) -> Option<Self> {
        Self::at(types, &types.stamp()?)
    }

    /// Decoder of the `builtin_interfaces/Time` at a path; `None` if the type has no such field there.
    #[must_use]
    pub fn at(types: &Types, stamp: &FieldPath) -> Option<Self> {
        let parts = ["sec", "nanosec"].map(|name| stamp.field(name));
        Decoder::compile(types, &parts).ok().map(Self)
    }

    /// Stamp of a message, ns; `None` for a payload of another type.
    #[must_use]
    pub fn read(&self, payload: &[u8], values: &mut Values) -> Option<i64> {
        self.0.read(payload, values).ok()?;
        values.nanoseconds(0)
    }
}

impl Values {
    /// The stamp whose seconds are at `index` and whose nanoseconds follow.
    #[must_use]
    pub fn nanoseconds(&self, index: usize) -> Option<i64> {
        let seconds = self.number(index)? as i64;
        let nanoseconds = self.number(index + 1)? as i64;
        seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
    }
}

#[cfg(test)]
mod tests {
    use planesman_msgs::{
        Message, builtin_interfaces::msg::Time, cdr, geometry_msgs::msg::Vector3,
        nav_msgs::msg::Odometry, rosgraph_msgs::msg::Clock, tf2_msgs::msg::TFMessage,
    };

    use super::*;
    use crate::schema;

    fn types<M: Message>() -> Types {
        schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION).expect("ours")
    }

    #[test]
    fn a_stamp_is_read_where_the_type_has_one() {
        let mut odometry = Odometry::default();
        odometry.header.frame_id = "odom".to_owned();
        odometry.header.stamp = Time::from_nanos(7_050_000_001);
        let decoder = StampDecoder::of(&types::<Odometry>()).expect("a header");
        let mut values = Values::default();
        let mut stamp = |payload: &[u8]| decoder.read(payload, &mut values);
        assert_eq!(stamp(&cdr::to_bytes(&odometry)), Some(7_050_000_001));
        assert_eq!(stamp(&[0, 1, 0, 0, 7]), None);

        let clock = Clock {
            clock: Time::from_nanos(3),
        };
        let decoder = StampDecoder::of(&types::<Clock>()).expect("a time");
        assert_eq!(decoder.read(&cdr::to_bytes(&clock), &mut values), Some(3));
        assert!(StampDecoder::of(&types::<Vector3>()).is_none());
        assert!(
            StampDecoder::of(&types::<TFMessage>()).is_none(),
            "many, not one"
        );
    }
}
