//! Small bags for the tests.

use std::{path::Path, sync::Arc};

use planesman_bag::{
    BagReader, BagWriter, Compression, Message, OfferedQos, Order, ReadError, Topic, TopicKind,
    WriterOptions,
};

/// A topic of the standard's simplest type.
pub(crate) fn topic(name: &str) -> Topic {
    Topic {
        name: name.to_owned(),
        kind: Arc::new(TopicKind {
            type_name: "std_msgs/msg/Float64".to_owned(),
            definition: "float64 data\n".to_owned(),
            definition_encoding: "ros2msg".to_owned(),
            message_encoding: "cdr".to_owned(),
            type_hash: format!("RIHS01_{}", "0".repeat(64)),
            offered_qos: vec![OfferedQos::reliable(10)],
        }),
    }
}

/// The payload of a `std_msgs/msg/Float64`.
pub(crate) fn payload(value: f64) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend(value.to_le_bytes());
    bytes
}

/// Options under which a few messages make a chunk, and the clock none.
pub(crate) fn small_chunks(compression: Compression) -> WriterOptions {
    WriterOptions {
        compression,
        chunk_size: 10 * (31 + 12),
        flush_interval: None,
        ..WriterOptions::default()
    }
}

/// Writes `count` messages alternately on `/depth` and `/pitch`, 50 ms apart.
pub(crate) fn fill(writer: &mut BagWriter, count: i64) {
    let depth = writer.add_topic(&topic("/depth")).expect("a new topic");
    let pitch = writer.add_topic(&topic("/pitch")).expect("a new topic");
    for k in 0..count {
        let id = if k % 2 == 0 { depth } else { pitch };
        let time = 50_000_000 * k;
        writer
            .write_raw(id, &payload(k as f64), time, time)
            .expect("room on the disk");
    }
}

/// A closed bag of `count` messages in a single file.
pub(crate) fn whole_file(path: &Path, compression: Compression, count: i64) {
    let mut writer = BagWriter::create_file(path, small_chunks(compression)).expect("a new file");
    fill(&mut writer, count);
    writer.close().expect("room on the disk");
}

/// Every message of a bag.
pub(crate) fn all(bag: &BagReader) -> Result<Vec<Message>, ReadError> {
    bag.messages(Order::File).collect()
}

/// Whether [`fill`] writes such a message.
pub(crate) fn was_written(message: &Message) -> bool {
    let k = message.log_time / 50_000_000;
    message.log_time == 50_000_000 * k
        && message.payload == payload(k as f64)
        && message.topic.name == ["/depth", "/pitch"][(k % 2) as usize]
}

/// Whether the messages are the first of those that [`fill`] writes.
pub(crate) fn is_prefix(messages: &[Message]) -> bool {
    messages
        .iter()
        .enumerate()
        .all(|(k, message)| message.log_time == 50_000_000 * k as i64 && was_written(message))
}
