//! Every message type of this crate, found by name where types are known only at run time.

use crate::{Message, cdr};

/// A message type at run time.
#[derive(Debug, Clone, Copy)]
pub struct TypeInfo {
    /// [`Message::TYPE_NAME`].
    pub type_name: &'static str,
    /// [`Message::DDS_TYPE_NAME`].
    pub dds_type_name: &'static str,
    /// [`Message::DEFINITION`].
    pub definition: &'static str,
    /// [`Message::TYPE_HASH`].
    pub type_hash: &'static str,
    /// Converts a payload ([`cdr`]) to JSON with the ROS field names; NaN becomes `null`.
    pub to_json: fn(&[u8]) -> Result<serde_json::Value, JsonError>,
}

impl TypeInfo {
    /// The entry of a message type.
    #[must_use]
    pub const fn of<M: Message>() -> Self {
        Self {
            type_name: M::TYPE_NAME,
            dds_type_name: M::DDS_TYPE_NAME,
            definition: M::DEFINITION,
            type_hash: M::TYPE_HASH,
            to_json: to_json::<M>,
        }
    }
}

/// The reason why a payload cannot be shown as JSON.
#[derive(Debug, thiserror::Error)]
pub enum JsonError {
    /// The payload is not a message of the type.
    #[error(transparent)]
    Payload(#[from] cdr::Error),
    /// JSON cannot represent the message.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

fn to_json<M: Message>(payload: &[u8]) -> Result<serde_json::Value, JsonError> {
    let message: M = cdr::from_bytes(payload)?;
    Ok(serde_json::to_value(message)?)
}

/// Every message of this crate in order of name, without the messages of services and actions.
#[must_use]
pub fn registry() -> &'static [TypeInfo] {
    crate::REGISTRY
}

/// The message type with this ROS name (`std_msgs/msg/Float64`).
#[must_use]
pub fn type_info(type_name: &str) -> Option<&'static TypeInfo> {
    let registry = registry();
    let index = registry
        .binary_search_by(|info| info.type_name.cmp(type_name))
        .ok()?;
    registry.get(index)
}
