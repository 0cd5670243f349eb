//! The stamp in a message's header, where it has one.

use planesman_msgs::builtin_interfaces::msg::Time;
use serde_json::Value;

/// `header.stamp` of a message as JSON, `None` when it has none.
#[must_use]
pub fn of(message: &Value) -> Option<Time> {
    let stamp = message.get("header")?.get("stamp")?;
    Some(Time {
        sec: i32::try_from(stamp.get("sec")?.as_i64()?).ok()?,
        nanosec: u32::try_from(stamp.get("nanosec")?.as_u64()?).ok()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::planesman_msgs::msg::VehicleState;

    #[test]
    fn a_headers_stamp_is_found_and_its_absence_too() {
        let mut state = VehicleState::default();
        state.header.stamp = Time::from_nanos(1_250_000_001);
        let message = serde_json::to_value(&state).expect("plain");
        assert_eq!(of(&message), Some(state.header.stamp));
        assert_eq!(of(&serde_json::json!({"data": 1.0})), None);
    }
}
