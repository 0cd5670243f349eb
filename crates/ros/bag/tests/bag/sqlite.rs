//! Bags of rosbag2's sqlite3 storage, as Humble (without definitions) and Iron (with them) write them, and what is none.

use std::fs;
use std::path::Path;

use planesman_bag::{BagReader, Message, Order};
use planesman_msgs::cdr;
use planesman_msgs::std_msgs::msg::Float64;
use rusqlite::Connection;

/// The tables as rosbag2 creates them, some messages on two topics, and one on a topic that is not there.
fn database(path: &Path, count: i64, has_definitions: bool) {
    let base = Connection::open(path).unwrap();
    base.execute_batch(
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
         CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
             serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
         CREATE INDEX timestamp_idx ON messages (timestamp ASC);
         INSERT INTO topics VALUES (3, '/depth', 'std_msgs/msg/Float64', 'cdr', ''), (7, '/odd', 'odd_msgs/msg/Odd', 'cdr', '');
         BEGIN;",
    )
    .unwrap();
    if has_definitions {
        base.execute_batch(
            "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
                 encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
             INSERT INTO message_definitions VALUES (1, 'odd_msgs/msg/Odd', 'ros2msg', 'float64 odd', 'RIHS01_0');",
        )
        .unwrap();
    }
    let mut insert = base
        .prepare("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)")
        .unwrap();
    for k in 0..count {
        let payload = cdr::to_bytes(&Float64 { data: k as f64 });
        let topic = if k % 10 == 9 { 7 } else { 3 };
        insert.execute((topic, k * 1_000_000, payload)).unwrap();
    }
    drop(insert);
    base.execute_batch("COMMIT").unwrap();
}

fn messages(bag: &BagReader) -> Vec<Message> {
    bag.messages(Order::File).map(Result::unwrap).collect()
}

#[test]
fn a_database_is_read_as_a_bag_in_batches() {
    let folder = tempfile::tempdir().unwrap();
    // A name that means something in a URI.
    let path = folder.path().join("a?b#c%20_0.db3");
    database(&path, 2000, false);
    let before = fs::read(&path).unwrap();
    let bag = BagReader::open(&path).unwrap();
    assert!(bag.completeness().is_whole());
    assert_eq!(bag.message_count(), 2000);
    assert_eq!(bag.span(), Some((0, 1_999_000_000)));
    let all = messages(&bag);
    for (k, message) in all.iter().enumerate() {
        assert_eq!(message.log_time, k as i64 * 1_000_000);
        assert_eq!(message.decode::<Float64>().unwrap().data, k as f64);
    }
    let depth = bag.messages_of(|it| it.name == "/depth", Order::File);
    assert_eq!(depth.count(), 1800);
    // Humble's bags have no definitions: a standard type's is known, another's is not.
    let kinds: Vec<_> = bag.topics().iter().map(|it| &it.topic.kind).collect();
    assert_eq!(kinds[0].definition_encoding, "ros2msg");
    assert!(kinds[0].definition.contains("float64 data"));
    assert_eq!(kinds[1].definition, "");
    // Nothing is written beside it or into it.
    assert_eq!(fs::read(&path).unwrap(), before);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn definitions_are_taken_from_the_bag_and_the_folder_needs_no_metadata() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..11 {
        let path = folder.path().join(format!("bag_{number}.db3"));
        database(&path, 10 + number, true);
    }
    let bag = BagReader::open(folder.path()).unwrap();
    assert!(!bag.completeness().is_whole());
    assert_eq!(bag.topics()[1].topic.kind.definition, "float64 odd");
    let files: Vec<_> = bag.files().map(|(path, _)| path.to_owned()).collect();
    assert!(files[10].ends_with("bag_10.db3"), "{files:?}");
    assert_eq!(messages(&bag).len() as u64, bag.message_count());
}

#[test]
fn a_database_that_is_packed_whole_is_read_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.db3");
    database(&plain, 500, true);
    let packed = folder.path().join("bag_0.db3.zstd");
    let bytes = zstd::encode_all(&*fs::read(&plain).unwrap(), 3).unwrap();
    fs::write(&packed, &bytes).unwrap();
    let bag = BagReader::open(&packed).unwrap();
    assert!(bag.completeness().is_whole());
    assert_eq!(messages(&bag), messages(&BagReader::open(&plain).unwrap()));

    // As rosbag2 lists it, and found without the list.
    let metadata = "rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  duration: {nanoseconds: 499000000}
  starting_time: {nanoseconds_since_epoch: 0}
  message_count: 500
  topics_with_message_count: []
  compression_format: zstd
  compression_mode: FILE
  relative_file_paths: [bag_0.db3.zstd]
";
    fs::remove_file(&plain).unwrap();
    for is_listed in [false, true] {
        if is_listed {
            fs::write(folder.path().join("metadata.yaml"), metadata).unwrap();
        }
        let bag = BagReader::open(folder.path()).unwrap();
        assert_eq!(messages(&bag).len(), 500);
        assert_eq!(bag.completeness().is_whole(), is_listed);
    }
    fs::write(&packed, &bytes[..bytes.len() / 2]).unwrap();
    assert!(BagReader::open(&packed).is_err());
}

#[test]
fn what_is_no_bag_or_is_damaged_is_refused_or_read_in_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db3");
    let refused = |sql: &str| {
        let _ = fs::remove_file(&path);
        let base = Connection::open(&path).unwrap();
        base.execute_batch(sql).unwrap();
        drop(base);
        BagReader::open(&path).unwrap_err().to_string()
    };
    for sql in [
        "CREATE TABLE cats(name TEXT)",
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT)",
        "CREATE TABLE topics(id TEXT, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);
         INSERT INTO topics VALUES ('x', 'a', 'b', 'cdr', '')",
        // A view that would never end.
        "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);
         CREATE VIEW messages(id, topic_id, timestamp, data) AS
             WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i, 1, i, x'00' FROM n",
    ] {
        let refusal = refused(sql);
        assert!(refusal.contains("a.db3 cannot be read as a bag"), "{refusal}");
        assert_eq!(refusal.lines().count(), 1, "{refusal}");
    }
    let _ = fs::remove_file(&path);
    database(&path, 3000, true);
    let whole = fs::read(&path).unwrap();
    for cut in (0..40).map(|k| whole.len() * k / 40) {
        fs::write(&path, &whole[..cut]).unwrap();
        if let Ok(bag) = BagReader::open(&path) {
            bag.messages(Order::File)
                .map_while(Result::ok)
                .for_each(drop);
        }
        let mut garbled = whole.clone();
        garbled[cut..whole.len().min(cut + 50)].fill(0xa5);
        fs::write(&path, garbled).unwrap();
        if let Ok(bag) = BagReader::open(&path) {
            bag.messages(Order::File)
                .map_while(Result::ok)
                .for_each(drop);
        }
    }
}
