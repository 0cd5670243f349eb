//! Round trip: written messages are read back, from the folder that rosbag2 expects.

use std::{fs, time::Duration};

use crate::common::{all, fill, is_prefix, payload, small_chunks, topic, whole_file};
use planesman_bag::{
    BagInfo, BagMetadata, BagReader, BagWriter, Completeness, Compression, Order, WriteError,
    WriterOptions, sorted_into_bags,
};

#[test]
fn a_closed_bag_holds_every_message_in_order() {
    for compression in [Compression::None, Compression::Zstd] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deep/dive");
        let mut writer = BagWriter::create(&path, small_chunks(compression)).expect("a new bag");
        fill(&mut writer, 101);
        let metadata = writer.close().expect("room on the disk");
        assert_eq!(metadata.message_count, 101);
        assert_eq!(metadata.duration.nanoseconds, 5_000_000_000);

        for door in [
            path.clone(),
            path.join("metadata.yaml"),
            path.join("dive_0.mcap"),
        ] {
            let bag = BagReader::open(&door).expect("a bag");
            assert_eq!(*bag.completeness(), Completeness::Whole, "{door:?}");
            assert_eq!(bag.message_count(), 101);
            assert_eq!(bag.span(), Some((0, 5_000_000_000)));
            let messages = all(&bag).expect("an undamaged bag");
            assert_eq!(messages.len(), 101);
            assert!(is_prefix(&messages));
            assert_eq!(*messages[0].topic, topic("/depth"));
            assert_eq!(*messages[1].topic, topic("/pitch"));
        }
    }
}

#[test]
fn only_the_named_topics_are_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("dive.mcap");
    whole_file(&path, Compression::Zstd, 10);
    let bag = BagReader::open(&path).expect("a bag");
    let names: Vec<_> = bag
        .messages_of(|topic| topic.name == "/pitch", Order::File)
        .map(|message| message.expect("an undamaged bag").topic.name.clone())
        .collect();
    assert_eq!(names, ["/pitch"; 5]);
}

#[test]
fn the_metadata_is_what_rosbag2_writes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("dive");
    let mut writer = BagWriter::create(&path, WriterOptions::default()).expect("a new bag");
    fill(&mut writer, 3);
    assert!(
        !path.join("metadata.yaml").exists(),
        "written at close only"
    );
    writer.close().expect("room on the disk");

    let text = fs::read_to_string(path.join("metadata.yaml")).expect("the metadata");
    for line in [
        "rosbag2_bagfile_information:",
        "  version: 9",
        "  storage_identifier: mcap",
        "    nanoseconds: 100000000",
        "    nanoseconds_since_epoch: 0",
        "  message_count: 3",
        "      name: /depth",
        "      type: std_msgs/msg/Float64",
        "      serialization_format: cdr",
        "      - history: keep_last",
        "        reliability: reliable",
        "    message_count: 2",
        "  compression_format: ''",
        "  - dive_0.mcap",
        "  - path: dive_0.mcap",
        "  ros_distro: jazzy",
    ] {
        assert!(
            text.lines().any(|l| l == line),
            "{line:?} is not in\n{text}"
        );
    }
    let read = BagMetadata::read(&path.join("metadata.yaml")).expect("the metadata");
    assert_eq!(read.topics_with_message_count.len(), 2);
    let left = fs::read_dir(&path).expect("the folder").count();
    assert_eq!(
        left, 2,
        "the bag's folder holds the file and its metadata only"
    );
}

#[test]
fn a_bag_without_messages_is_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("still");
    let mut writer = BagWriter::create(&path, WriterOptions::default()).expect("a new bag");
    writer.add_topic(&topic("/depth")).expect("a new topic");
    writer.close().expect("room on the disk");
    let bag = BagReader::open(&path).expect("a bag");
    assert!(bag.completeness().is_whole());
    assert_eq!(bag.topics().len(), 1);
    assert_eq!(bag.span(), None);
    assert_eq!(all(&bag).expect("an undamaged bag"), []);
}

#[test]
fn an_existing_path_is_refused_and_left_as_it_is() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let taken = folder.path().join("taken");
    fs::write(&taken, "a letter").expect("room on the disk");
    for error in [
        BagWriter::create(&taken, WriterOptions::default()),
        BagWriter::create_file(&taken, WriterOptions::default()),
        BagWriter::create(folder.path(), WriterOptions::default()),
    ]
    .map(|created| created.expect_err("the path is taken"))
    {
        assert!(matches!(error, WriteError::Exists { .. }), "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    assert_eq!(fs::read(&taken).expect("the letter"), b"a letter");
    assert!(BagWriter::create(&taken.join("below"), WriterOptions::default()).is_err());
}

#[test]
fn messages_out_of_order_are_put_in_order() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("late.mcap");
    let mut writer = BagWriter::create_file(&path, WriterOptions::default()).expect("a new file");
    let depth = writer.add_topic(&topic("/depth")).expect("a new topic");
    for time in [30, 10, 20, 10] {
        writer
            .write_raw(depth, &payload(time as f64), time, 0)
            .expect("room on the disk");
    }
    writer.close().expect("room on the disk");
    let bag = BagReader::open(&path).expect("a bag");
    let times = |order| -> Vec<_> {
        bag.messages(order)
            .map(|message| message.map(|m| (m.log_time, m.sequence)).expect("whole"))
            .collect()
    };
    assert_eq!(times(Order::File), [(30, 0), (10, 1), (20, 2), (10, 3)]);
    assert_eq!(times(Order::LogTime), [(10, 0), (10, 0), (20, 0), (30, 0)]);
    assert_eq!(bag.span(), Some((10, 30)));
}

#[test]
fn a_draft_names_the_file_that_it_becomes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("dive.mcap");
    let written = ["1.part", "another.part"].map(|draft| {
        let draft = folder.path().join(draft);
        let mut writer = BagWriter::create_in(
            fs::File::create_new(&draft).expect("a new file"),
            &file,
            WriterOptions::default(),
        )
        .expect("room on the disk");
        let depth = writer.add_topic(&topic("/depth")).expect("a new topic");
        writer
            .write_raw(depth, &payload(1.0), 1, 0)
            .expect("room on the disk");
        let account = writer.close().expect("room on the disk");
        assert_eq!(account.relative_file_paths, ["dive.mcap"]);
        fs::read(&draft).expect("written")
    });
    assert_eq!(written[0], written[1]);
}

#[test]
fn a_split_bag_is_read_in_the_order_of_its_metadata() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let parts: Vec<_> = (0..11)
        .map(|part| {
            let bag = folder.path().join(format!("part{part}"));
            let mut writer = BagWriter::create(&bag, WriterOptions::default()).expect("a new bag");
            let depth = writer.add_topic(&topic("/depth")).expect("a new topic");
            writer
                .write_raw(depth, &payload(0.0), part, part)
                .expect("room on the disk");
            let metadata = writer.close().expect("room on the disk");
            (bag.join(format!("part{part}_0.mcap")), metadata)
        })
        .collect();
    let split = folder.path().join("split");
    fs::create_dir(&split).expect("a new folder");
    let mut metadata = parts[0].1.clone();
    metadata.message_count = 11;
    metadata.relative_file_paths = Vec::new();
    for (number, (file, _)) in parts.iter().enumerate() {
        let name = format!("split_{number}.mcap");
        fs::copy(file, split.join(&name)).expect("room on the disk");
        metadata
            .relative_file_paths
            .push(format!("elsewhere/{name}"));
    }
    let order = |bag: &BagReader| -> Vec<_> {
        all(bag)
            .expect("an undamaged bag")
            .iter()
            .map(|message| message.log_time)
            .collect()
    };

    let unlisted = BagReader::open(&split).expect("a bag");
    assert!(!unlisted.completeness().is_whole());
    assert_eq!(order(&unlisted), (0..11).collect::<Vec<_>>());

    metadata.write(&split).expect("room on the disk");
    let listed = BagReader::open(&split).expect("a bag");
    assert!(listed.completeness().is_whole());
    assert_eq!(order(&listed), (0..11).collect::<Vec<_>>());
    assert_eq!(listed.topics().len(), 1);
    assert_eq!(listed.topics()[0].messages, 11);

    metadata.relative_file_paths.reverse();
    metadata.write(&split).expect("room on the disk");
    let reversed = BagReader::open(&split).expect("a bag");
    assert_eq!(order(&reversed), (0..11).rev().collect::<Vec<_>>());
}

#[test]
fn losses_are_reported_in_the_bag() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("lossy");
    let mut writer = BagWriter::create(&path, WriterOptions::default()).expect("a new bag");
    let depth = writer.add_topic(&topic("/depth")).expect("a new topic");
    writer.note_dropped(depth, 3);
    writer
        .write_raw(depth, &payload(1.0), 5, 5)
        .expect("room on the disk");
    assert_eq!(writer.health().dropped(), 3);
    assert_eq!(writer.health().waiting, 1);
    writer.close().expect("room on the disk");

    let bag = BagReader::open(&path).expect("a bag");
    let info = BagInfo::of(&bag);
    assert_eq!(info.dropped, 3);
    let text = info.to_string();
    assert!(text.contains("messages  1, and 3 lost"), "{text}");
    assert!(text.contains("status    complete"), "{text}");
    assert!(text.contains("/depth  std_msgs/msg/Float64"), "{text}");
}

#[test]
fn a_silence_does_not_keep_messages_in_memory() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("quiet.mcap");
    let options = WriterOptions {
        flush_interval: Some(Duration::ZERO),
        ..WriterOptions::default()
    };
    let mut writer = BagWriter::create_file(&path, options).expect("a new file");
    fill(&mut writer, 3);
    writer.flush_if_due().expect("room on the disk");
    assert_eq!(writer.health().waiting, 0);
    assert_eq!(
        writer.health().bytes,
        fs::metadata(&path).expect("the file").len()
    );
    let bag = BagReader::open(&path).expect("a bag being written");
    assert_eq!(bag.message_count(), 3);
    assert!(!bag.completeness().is_whole());
}

#[test]
fn a_split_bag_is_one_bag_and_each_of_its_files_is_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("split");
    let options = WriterOptions {
        max_file_duration: Some(Duration::from_millis(500)),
        ..small_chunks(Compression::Zstd)
    };
    let mut writer = BagWriter::create(&path, options).expect("a new folder");
    assert!(!writer.split().expect("nothing to do"), "no file is empty");
    fill(&mut writer, 25);
    assert!(writer.split().expect("room on the disk"));
    let depth = writer.add_topic(&topic("/depth")).expect("it is known");
    writer.note_dropped(depth, 2);
    let metadata = writer.close().expect("room on the disk");

    // 0 to 0.5 s, 0.55 to 1.05 s, 1.1 to 1.2 s, and the one that was asked for.
    let counts: Vec<u64> = metadata.files.iter().map(|it| it.message_count).collect();
    assert_eq!(counts, [11, 11, 3, 0]);
    assert_eq!(metadata.duration.nanoseconds, 24 * 50_000_000);
    assert_eq!(metadata.starting_time.nanoseconds_since_epoch, 0);
    assert_eq!(metadata.message_count, 25);
    assert_eq!(metadata.dropped(), 2);
    let bag = BagReader::open(&path).expect("a bag");
    assert!(bag.completeness().is_whole(), "{}", bag.completeness());
    let messages = all(&bag).expect("undamaged");
    assert_eq!(messages.len(), 25);
    assert!(is_prefix(&messages));
    for (k, count) in counts.iter().enumerate() {
        let file = BagReader::open(&path.join(format!("split_{k}.mcap"))).expect("a file");
        assert!(file.completeness().is_whole());
        assert_eq!(file.message_count(), *count);
    }
}

#[test]
fn a_folder_of_several_bags_is_refused_and_files_are_sorted_into_bags() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a new folder");
        whole_file(&path, Compression::Zstd, 101);
        path
    };
    let refusal = |path: &str| {
        let refusal = BagReader::open(&folder.path().join(path)).expect_err("several");
        refusal.to_string()
    };
    // Of one time, whatever they are called.
    let runs = [file("runs/run_1.mcap"), file("runs/run_2.mcap")];
    let text = refusal("runs");
    assert!(
        text.contains("several bags (times overlap): run_1.mcap, run_2.mcap"),
        "{text}"
    );
    assert_eq!(sorted_into_bags(&runs), [&runs[..1], &runs[1..]]);
    // Each in a folder of its own.
    for name in ["day/one", "day/two"] {
        let mut writer =
            BagWriter::create(&folder.path().join(name), WriterOptions::default()).expect("a bag");
        fill(&mut writer, 3);
        writer.close().expect("room on the disk");
    }
    let text = refusal("day");
    assert!(text.contains("folders with bags (one, two)"), "{text}");
    // One after the other, but of different names.
    let mut later = BagWriter::create(&folder.path().join("later"), WriterOptions::default())
        .expect("a new bag");
    let depth = later.add_topic(&topic("/depth")).expect("a new topic");
    let hour = 3_600_000_000_000;
    later
        .write_raw(depth, &payload(0.0), hour, hour)
        .expect("room on the disk");
    later.close().expect("room on the disk");
    let evening = folder.path().join("runs/evening.mcap");
    fs::rename(folder.path().join("later/later_0.mcap"), &evening).expect("moved");
    fs::remove_file(&runs[1]).expect("removed");
    assert!(refusal("runs").contains("(names differ)"));
    // One after the other, and numbered: one bag.
    let second = folder.path().join("runs/run_2.mcap");
    fs::rename(&evening, &second).expect("moved");
    let bag = BagReader::open(&folder.path().join("runs")).expect("one bag");
    assert_eq!(bag.message_count(), 102);
    let both = [runs[0].clone(), second];
    assert_eq!(sorted_into_bags(&both), [&both[..]]);
}
