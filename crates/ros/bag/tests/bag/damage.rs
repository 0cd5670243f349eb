//! Bags that were cut, never closed, damaged, or never bags.

use std::{collections::BTreeMap, fs, ops::Not, os::unix::fs::FileExt, path::Path};

use crate::common::{all, fill, is_prefix, small_chunks, was_written, whole_file};
use planesman_bag::{
    BagInfo, BagReader, BagWriter, Completeness, Compression, Order, ReadError, WriterOptions,
    reader::Limits,
};
use planesman_testing::hostile;
use planesman_testing::mcap::{MAGIC, beginning, channel, chunk, end, message, record, schema};

fn file_with(folder: &Path, name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("room on the disk");
    path
}

#[test]
fn a_killed_recorder_leaves_what_it_flushed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("killed");
    let mut writer = BagWriter::create(&path, small_chunks(Compression::Zstd)).expect("a new bag");
    fill(&mut writer, 25);
    // Neither the destructor nor the last chunk: what kill -9 leaves.
    std::mem::forget(writer);

    let bag = BagReader::open(&path).expect("a bag");
    let Completeness::Truncated { reason, .. } = bag.completeness() else {
        panic!("a killed bag is not whole");
    };
    assert_eq!(reason, "the file was not closed");
    let messages = all(&bag).expect("whole chunks");
    assert_eq!(messages.len(), 20, "two chunks of ten were flushed");
    assert!(is_prefix(&messages));
    assert_eq!(bag.message_count(), 20);
}

#[test]
fn a_writer_dropped_without_closing_keeps_every_message_and_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("dropped");
    let mut writer = BagWriter::create(&path, small_chunks(Compression::None)).expect("a new bag");
    fill(&mut writer, 25);
    drop(writer);
    let bag = BagReader::open(&path).expect("a bag");
    assert!(!bag.completeness().is_whole());
    assert_eq!(all(&bag).expect("whole chunks").len(), 25);
}

#[test]
fn a_bag_killed_at_once_is_a_bag_without_messages() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("early");
    std::mem::forget(BagWriter::create(&path, WriterOptions::default()).expect("a new bag"));
    let bag = BagReader::open(&path).expect("a bag");
    assert_eq!(bag.message_count(), 0);
    assert!(!bag.completeness().is_whole());
}

#[test]
fn cut_anywhere_a_file_gives_a_prefix_and_says_that_it_is_cut() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for compression in [Compression::None, Compression::Zstd] {
        let path = folder.path().join(format!("{compression:?}.mcap"));
        whole_file(&path, compression, 40);
        let bytes = fs::read(&path).expect("the file");
        let cut = file_with(folder.path(), "cut.mcap", &bytes);
        let file = fs::File::options()
            .write(true)
            .open(&cut)
            .expect("the file");
        let mut expected = 40;
        for length in (0..bytes.len()).rev() {
            file.set_len(length as u64).expect("the file grows shorter");
            match BagReader::open(&cut) {
                Err(ReadError::Empty { .. }) => assert_eq!(length, 0),
                Err(error) => {
                    assert!(matches!(error, ReadError::NoHeader { .. }), "{error}");
                    assert!(length < 80, "the header ends before byte {length}");
                }
                Ok(bag) => {
                    assert!(!bag.completeness().is_whole(), "cut at {length}");
                    let messages = all(&bag).expect("a cut bag is read without error");
                    assert!(is_prefix(&messages), "cut at {length}");
                    assert_eq!(messages.len() as u64, bag.message_count());
                    let cut_from_the_whole = expected - messages.len();
                    assert!(
                        [0, 10].contains(&cut_from_the_whole),
                        "a chunk is there or it is not; at {length}"
                    );
                    expected = messages.len();
                }
            }
        }
        assert_eq!(expected, 0);
    }
}

#[test]
fn a_changed_byte_changes_no_message_and_hides_none_unsaid() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for compression in [Compression::None, Compression::Zstd] {
        let path = folder.path().join(format!("{compression:?}.mcap"));
        whole_file(&path, compression, 30);
        let bytes = fs::read(&path).expect("the file");
        let changed = file_with(folder.path(), "changed.mcap", &bytes);
        let file = fs::File::options()
            .write(true)
            .open(&changed)
            .expect("the file");
        for (at, byte) in bytes.iter().enumerate() {
            file.write_all_at(&[byte ^ 0xA5], at as u64)
                .expect("the file");
            if let Ok(bag) = BagReader::open(&changed) {
                let mut messages = Vec::new();
                let mut damage = bag.completeness().is_whole().not();
                for message in bag.messages(Order::File) {
                    match message {
                        Ok(message) => messages.push(message),
                        Err(_) => damage = true,
                    }
                }
                assert!(messages.iter().all(was_written), "byte {at}");
                assert!(messages.len() == 30 || damage, "byte {at}");
            }
            file.write_all_at(&[*byte], at as u64).expect("the file");
        }
    }
}

#[test]
fn damage_in_a_closed_file_is_an_error_after_what_comes_before() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("hurt.mcap");
    whole_file(&path, Compression::None, 40);
    let mut bytes = fs::read(&path).expect("the file");
    let middle = bytes.len() / 3;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).expect("room on the disk");

    let bag = BagReader::open(&path).expect("its summary is whole");
    let mut messages = bag.messages(Default::default());
    let before: Vec<_> = messages.by_ref().map_while(Result::ok).collect();
    assert!(before.len() < 40 && is_prefix(&before));
    assert!(messages.next().is_none(), "nothing follows the error");
    let error = bag
        .messages(Default::default())
        .find_map(Result::err)
        .expect("damage is reported");
    assert!(matches!(error, ReadError::Damaged { .. }));
    assert!(error.to_string().contains("hurt.mcap is damaged at byte"));
}

#[test]
fn what_is_no_bag_is_refused_in_one_line_that_names_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let empty_folder = folder.path().join("nothing");
    fs::create_dir(&empty_folder).expect("a new folder");
    let not_yaml = file_with(folder.path(), "metadata.yaml", b"half: [written");
    let cases = [
        (folder.path().join("absent"), "no such file"),
        (
            file_with(
                folder.path(),
                "photo.mcap",
                b"\xFF\xD8\xFF\xE0\0\x10JFIF\0 and so on",
            ),
            "a JPEG picture",
        ),
        (file_with(folder.path(), "empty.mcap", b""), "is empty"),
        (
            file_with(folder.path(), "cut.mcap", MAGIC),
            "cut off or damaged in its header",
        ),
        (
            file_with(folder.path(), "old.bag", b"#ROSBAG V2.0\n....."),
            "ROS 1 bag",
        ),
        (
            file_with(folder.path(), "bag.db3", b"SQLite format 3\0..."),
            "cannot be read as a bag of rosbag2's sqlite3 storage",
        ),
        (
            file_with(folder.path(), "letter.txt", b"Dear planesman,"),
            "something else",
        ),
        (empty_folder, "contains no .mcap or .db3 file"),
        (not_yaml, "not the metadata of a rosbag2 bag"),
    ];
    for (path, words) in cases {
        let refusal = BagReader::open(&path).expect_err("no bag").to_string();
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(refusal.contains(&*name), "{refusal}");
        assert!(refusal.contains(words), "{refusal}");
        assert_eq!(refusal.trim().lines().count(), 1, "{refusal}");
    }
}

#[test]
fn other_storages_and_outer_compression_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("other");
    BagWriter::create(&path, WriterOptions::default())
        .expect("a new bag")
        .close()
        .expect("room on the disk");
    let metadata = path.join("metadata.yaml");
    let text = fs::read_to_string(&metadata).expect("the metadata");
    let with = |from: &str, to: &str| {
        fs::write(&metadata, text.replace(from, to)).expect("room on the disk");
        BagReader::open(&path).expect_err("not MCAP").to_string()
    };
    assert!(with("storage_identifier: mcap", "storage_identifier: lmdb").contains("'lmdb'"));
    let packed = |format: &str| {
        let by = format!("compression_format: {format}");
        text.replace("compression_mode: ''", "compression_mode: FILE")
            .replace("compression_format: ''", &by)
            .replace(".mcap", ".mcap.zstd")
    };
    fs::write(&metadata, packed("zstd")).expect("room on the disk");
    let file = path.join("other_0.mcap");
    let plain = fs::read(&file).expect("the file");
    let whole = zstd::encode_all(&plain[..], 3).expect("zstd");
    let packed_file = path.join("other_0.mcap.zstd");
    fs::remove_file(&file).expect("it is there");
    fs::write(&packed_file, &whole).expect("room on the disk");
    let bag = BagReader::open(&path).expect("packed");
    assert!(bag.completeness().is_whole(), "{}", bag.completeness());
    // By another packer it is read only if it lies unpacked beside.
    fs::write(&metadata, packed("lz4")).expect("room on the disk");
    let refusal = BagReader::open(&path).expect_err("packed").to_string();
    assert!(refusal.contains("compression by FILE (lz4)"), "{refusal}");
    fs::write(&file, plain).expect("room on the disk");
    BagReader::open(&path).expect("unpacked");
}

#[test]
fn a_file_that_is_packed_whole_is_read_as_it_is_unpacked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bag");
    let mut writer = BagWriter::create(&path, small_chunks(Compression::None)).expect("a new bag");
    fill(&mut writer, 3000);
    writer.close().expect("room on the disk");
    let plain = path.join("bag_0.mcap");
    let bytes = fs::read(&plain).expect("the file");
    let messages = |path: &Path| -> Vec<_> {
        let bag = BagReader::open(path).expect("a bag");
        bag.messages(Order::File).map_while(Result::ok).collect()
    };
    let expected = messages(&plain);
    let packed = zstd::encode_all(&bytes[..], 3).expect("zstd");
    for name in ["a.mcap.zstd", "a.mcap.zst"] {
        let file = file_with(folder.path(), name, &packed);
        let bag = BagReader::open(&file).expect("a bag");
        assert!(bag.completeness().is_whole(), "{}", bag.completeness());
        assert_eq!(bag.message_count(), expected.len() as u64);
        assert_eq!(messages(&file), expected);
    }
    // A folder without metadata has them too.
    fs::remove_file(path.join("metadata.yaml")).expect("it is there");
    fs::remove_file(&plain).expect("it is there");
    file_with(&path, "bag_0.mcap.zstd", &packed);
    assert_eq!(messages(&path), expected);
    // Cut off, it gives what is before the cut.
    for share in [1, 10, 50, 90, 99] {
        let cut = &packed[..packed.len() * share / 100];
        let file = file_with(folder.path(), "cut.mcap.zstd", cut);
        let Ok(bag) = BagReader::open(&file) else {
            continue;
        };
        assert!(!bag.completeness().is_whole(), "{share}");
        let found = messages(&file);
        assert_eq!(found, expected[..found.len()], "{share}");
        assert_eq!(bag.message_count(), found.len() as u64, "{share}");
    }
    // Zeros without end behind a header are not gone through.
    let mut bomb = bytes[..2000].to_vec();
    bomb.extend(vec![0; 64 << 20]);
    let bomb = zstd::encode_all(&bomb[..], 3).expect("zstd");
    let file = file_with(folder.path(), "bomb.mcap.zstd", &bomb);
    let bag = BagReader::open(&file).expect("a bag");
    assert!(!bag.completeness().is_whole());
}

#[test]
fn a_folder_of_another_kind_of_bag_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refusal = || {
        BagReader::open(folder.path())
            .expect_err("no MCAP")
            .to_string()
    };
    assert!(
        refusal().ends_with("no .mcap or .db3 file"),
        "{}",
        refusal()
    );
    fs::write(folder.path().join("a.bag"), b"#ROSBAG V2.0").expect("room on the disk");
    assert!(refusal().contains("rosbags-convert"), "{}", refusal());
}

#[test]
fn half_written_metadata_hides_no_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("half");
    let mut writer = BagWriter::create(&path, small_chunks(Compression::Zstd)).expect("a new bag");
    fill(&mut writer, 12);
    writer.close().expect("room on the disk");
    let metadata = path.join("metadata.yaml");
    let text = fs::read_to_string(&metadata).expect("the metadata");
    for length in 0..text.len() - 1 {
        fs::write(&metadata, &text[..length]).expect("room on the disk");
        match BagReader::open(&path) {
            Ok(bag) => assert_eq!(all(&bag).expect("an undamaged file").len(), 12),
            // A prefix can be sound YAML that lists no file, or another storage ("mca").
            Err(error) => assert!(
                matches!(
                    error,
                    ReadError::NoMcap { .. }
                        | ReadError::Storage { .. }
                        | ReadError::NotFound { .. }
                ),
                "{error}"
            ),
        }
    }
}

#[test]
fn metadata_of_versions_5_to_8_is_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("older");
    let mut writer = BagWriter::create(&path, small_chunks(Compression::Zstd)).expect("a new bag");
    fill(&mut writer, 2);
    writer.close().expect("room on the disk");
    let version_5 = "rosbag2_bagfile_information:
  version: 5
  storage_identifier: mcap
  duration: {nanoseconds: 50000000}
  starting_time: {nanoseconds_since_epoch: 0}
  message_count: 2
  topics_with_message_count:
    - topic_metadata:
        name: /depth
        type: std_msgs/msg/Float64
        serialization_format: cdr
        offered_qos_profiles: \"- history: 1\\n  depth: 10\\n  reliability: 1\"
      message_count: 1
  compression_format: \"\"
  compression_mode: \"\"
  relative_file_paths: [older_0.mcap]
  files:
    - {path: older_0.mcap, starting_time: {nanoseconds_since_epoch: 0}, duration: {nanoseconds: 50000000}, message_count: 2}
";
    fs::write(path.join("metadata.yaml"), version_5).expect("room on the disk");
    let bag = BagReader::open(&path).expect("a bag");
    assert!(bag.completeness().is_whole());
    assert_eq!(bag.metadata().map(|metadata| metadata.version), Some(5));
}

#[test]
fn lying_lengths_are_refused_and_cost_no_memory() {
    const WORDS: [(&str, &str); 18] = [
        ("record", "the limit is"),
        ("record within the limit", "3 of 104857600 bytes"),
        ("attachment", "cut off"),
        ("unknown record", "cut off"),
        ("schema", "shorter than its fields"),
        ("channel", "shorter than its fields"),
        ("message without a head", "shorter than its fields"),
        ("message of no channel", "unknown channel 9"),
        ("channel of no schema", "unknown schema 9"),
        ("chunk that claims less", "a chunk of 100"),
        ("chunk that claims more", "its header says 33554433"),
        ("chunk that claims far more", "the limit is"),
        ("lz4 chunk that claims less", "its header says 100"),
        ("chunk of zeros", "inside a chunk"),
        ("chunk of something else", "cannot be unpacked"),
        (
            "chunk that claims more than it has",
            "claims 100 bytes, but only 9 are there",
        ),
        (
            "chunk whose packing acts on a terminal",
            "'br\\u{7}'; supported: none, zstd, lz4",
        ),
        ("chunk whose record overruns it", "inside a chunk"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut expected: BTreeMap<_, _> = WORDS.into();
    for (name, bytes) in hostile::records() {
        let path = file_with(folder.path(), "lie.mcap", &[beginning(), bytes].concat());
        let bag = BagReader::open(&path).expect("a header is there");
        let Completeness::Truncated {
            reason, readable, ..
        } = bag.completeness()
        else {
            panic!("{name}: not whole");
        };
        let words = expected.remove(name).unwrap_or_default();
        assert!(reason.contains(words), "{name}: {reason}");
        assert!(readable.is_some());
        let read = all(&bag).expect("what is readable is read").len();
        let many = if name == "chunk of many messages" {
            500_000
        } else {
            0
        };
        assert_eq!(read, many, "{name}");
    }
    assert_eq!(expected, BTreeMap::new(), "no such cases");
}

#[test]
fn an_attachment_longer_than_any_record_is_passed_over() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = [
        beginning(),
        record(9, &[0; 5000]),
        schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
        channel(1, 1, "/depth", "cdr"),
        message(1, 0, &[0; 12]),
        end(),
    ];
    let limits = Limits {
        chunk: 1000,
        ..Limits::default()
    };
    let path = file_with(folder.path(), "attachment.mcap", &bytes.concat());
    let bag = BagReader::open_within(&path, limits).expect("a header is there");
    assert!(bag.completeness().is_whole());
    assert_eq!(all(&bag).expect("a whole file").len(), 1);
}

#[test]
fn a_bag_is_read_up_to_the_unpacked_bytes_that_are_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let one = message(1, 0, &[0; 1000]);
    let packed = zstd::encode_all(&one[..], 1).expect("packed");
    let mut bytes = [
        beginning(),
        schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
        channel(1, 1, "/depth", "cdr"),
    ]
    .concat();
    for _ in 0..5 {
        bytes.extend(chunk(
            "zstd",
            one.len() as u64,
            packed.len() as u64,
            &packed,
        ));
    }
    bytes.extend(end());
    let path = file_with(folder.path(), "small.mcap", &bytes);
    let read = |most| {
        let bag = BagReader::open_within(&path, Limits::unpacked(most)).expect("a header");
        let mut messages = bag.messages(Order::File);
        let count = messages.by_ref().take_while(Result::is_ok).count();
        (count, bag.completeness().to_string())
    };
    assert_eq!(read(None).0, 5);
    assert_eq!(read(Some(5 * one.len() as u64)).0, 5);
    let (count, why) = read(Some(3 * one.len() as u64 + 1));
    assert_eq!(count, 3, "{why}");
    assert!(why.contains("exceeds the limit of"), "{why}");
}

#[test]
fn messages_packed_one_by_one_are_read_up_to_the_unpacked_bytes_that_are_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bag");
    let empty = BagWriter::create(&path, WriterOptions::default()).expect("a new bag");
    empty.close().expect("room on the disk");
    let metadata = path.join("metadata.yaml");
    let text = (fs::read_to_string(&metadata).expect("the metadata"))
        .replace("compression_mode: ''", "compression_mode: MESSAGE")
        .replace("compression_format: ''", "compression_format: zstd");
    fs::write(&metadata, text).expect("room on the disk");
    let packed = zstd::encode_all(&[0; 1000][..], 1).expect("packed");
    let mut bytes = [
        beginning(),
        schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
        channel(1, 1, "/depth", "cdr"),
    ]
    .concat();
    for _ in 0..5 {
        bytes.extend(message(1, 0, &packed));
    }
    bytes.extend(end());
    file_with(&path, "bag_0.mcap", &bytes);
    let read = |most| {
        let bag = BagReader::open_within(&path, Limits::unpacked(most)).expect("a bag");
        let all: Vec<_> = bag.messages(Order::File).collect();
        let whole = all.iter().flatten().filter(|it| it.payload == [0; 1000]);
        let said = all.iter().find_map(|it| it.as_ref().err());
        (whole.count(), said.map(ToString::to_string))
    };
    assert_eq!(read(None), (5, None));
    assert_eq!(read(Some(5000)), (5, None));
    let (count, said) = read(Some(3001));
    assert_eq!(count, 3, "{said:?}");
    let said = said.expect("a limit");
    assert!(said.contains("exceeds the limit of 3001"), "{said}");
}

#[test]
fn an_index_that_lies_is_not_believed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, bytes) in hostile::indexes() {
        let path = file_with(folder.path(), "index.mcap", &bytes);
        let bag = BagReader::open(&path).expect("a header is there");
        assert!(
            bag.completeness().is_whole(),
            "{name}: it is closed, and read through"
        );
        println!(
            "ZZ {name} {} {:?}",
            bag.message_count(),
            all(&bag).map(|m| m.len()).map_err(|e| e.to_string())
        );
    }
}

#[test]
fn topics_beyond_all_measure_are_passed_over_and_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str, first: u16| {
        let mut bytes = beginning();
        for id in 1..100_u16 {
            // A type of a kilobyte for each topic.
            bytes.extend(schema(id, "a/msg/A", "ros2msg", "n".repeat(1000)));
            bytes.extend(channel(id, id, &format!("/topic_{:03}", first + id), "cdr"));
            bytes.extend(message(id, 0, &[]));
        }
        bytes.extend(end());
        file_with(folder.path(), name, &bytes)
    };
    let open = |path: &Path, definitions: u64| {
        let limits = Limits {
            definitions,
            ..Limits::default()
        };
        BagReader::open_within(path, limits).expect("a header is there")
    };
    let bag = open(&file("bag_0.mcap", 0), 50_000);
    let kept = bag.topics().len() as u64;
    assert!((5..50_000 / 1000).contains(&kept), "{kept}");
    assert_eq!(bag.omitted(), 99 - kept);
    assert_eq!(bag.message_count(), 99);
    assert_eq!(all(&bag).expect("a whole file").len() as u64, kept);
    assert!(bag.completeness().is_whole());
    let info = BagInfo::of(&bag).to_string();
    let line = format!(
        "and {} more topics (not counted, because of the memory limit)",
        99 - kept
    );
    assert!(info.contains(&line), "{info}");

    // The measure is the whole bag's, in however many files; a topic that is in several is held once.
    file("bag_1.mcap", 100);
    let split = open(folder.path(), 50_000);
    assert!(split.topics().len() < 50_000 / 1000);
    assert_eq!(
        all(&split).expect("whole files").len(),
        split.topics().len()
    );
    file("bag_1.mcap", 0);
    let again = open(folder.path(), 1_000_000);
    assert_eq!((again.topics().len(), again.omitted()), (99, 0));
    assert_eq!(all(&again).expect("whole files").len(), 198);
}

#[test]
fn lz4_chunks_are_read() {
    use std::io::Write;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("plain.mcap");
    whole_file(&path, Compression::None, 10);
    let plain = BagReader::open(&path).expect("a bag");
    let expected = all(&plain).expect("an undamaged bag");

    // The same records, in one lz4 chunk.
    let records = [
        schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
        channel(1, 1, "/depth", "cdr"),
        message(1, 0, &expected[0].payload),
    ]
    .concat();
    let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
    encoder.write_all(&records).expect("memory");
    let packed = encoder.finish().expect("memory");
    let bytes = [
        beginning(),
        chunk("lz4", records.len() as u64, packed.len() as u64, &packed),
    ]
    .concat();
    let bag = BagReader::open(&file_with(folder.path(), "lz4.mcap", &bytes)).expect("a bag");
    let messages = all(&bag).expect("whole chunks");
    assert_eq!(messages.len(), 1);
    assert_eq!(messages[0].payload, expected[0].payload);
    assert_eq!(messages[0].topic.kind.type_name, "std_msgs/msg/Float64");
}
