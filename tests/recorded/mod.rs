//! The messages in a bag, decoded.

use std::path::Path;

use planesman_bag::{BagReader, Order};
use planesman_msgs::Message;

/// Every message on `topic`, as recorded; `None` while the bag cannot be read.
pub(crate) fn messages<M: Message>(bag: &Path, topic: &str) -> Option<Vec<M>> {
    let bag = BagReader::open(bag).ok()?;
    bag.messages_of(|it| it.name == topic, Order::File)
        .map(|message| message.ok()?.decode().ok())
        .collect()
}
