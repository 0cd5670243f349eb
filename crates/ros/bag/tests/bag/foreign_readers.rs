//! Foreign readers read the bags: `rosbags` and `mcap` from PyPI, by `tests/peers/read_bag.py`.
//!
//! They are looked for in `.venv` in the repository's root. Without them the tests pass, saying what they
//! skipped; with `PLANESMAN_PEERS=required` in the environment they fail.

#[path = "../../../../../tests/foreign/peers.rs"]
mod peers;

use std::{
    path::{Path, PathBuf},
    process::Output,
};

use planesman_bag::{BagReader, BagWriter, Compression, OfferedQos, Topic, WriterOptions};
use planesman_msgs::{
    Message, builtin_interfaces::msg::Time, planesman_msgs::msg::VehicleState,
    sensor_msgs::msg::JointState, std_msgs::msg::Header, tf2_msgs::msg::TFMessage,
};
use serde_json::Value;

/// Runs `read_bag.py`; `None` where there is no Python with the readers.
fn read_bag(arguments: &[&Path]) -> Option<Output> {
    let mut command = peers::program("read_bag.py")?;
    Some(command.args(arguments).output().expect("Python starts"))
}

/// The readers' common result, if they agree.
fn agreed(output: &Output) -> Value {
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaints}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn header(nanoseconds: i64) -> Header {
    Header {
        stamp: Time::from_nanos(nanoseconds),
        frame_id: "auv/base_link".to_owned(),
    }
}

fn write<M: Message>(writer: &mut BagWriter, name: &str, messages: impl Iterator<Item = (i64, M)>) {
    let topic = Topic::of::<M>(name, OfferedQos::reliable(10));
    let id = writer.add_topic(&topic).expect("a new topic");
    for (time, message) in messages {
        writer.write(id, &message, time).expect("room on the disk");
    }
}

/// Writes a few topics whose fields differ in every message.
fn fill(writer: &mut BagWriter, count: i64) {
    let times = || (0..count).map(|k| 50_000_000 * k);
    write(
        writer,
        "/auv/state",
        times().map(|time| {
            let state = VehicleState {
                header: header(time),
                depth: time as f64 / 1e9,
                ..VehicleState::default()
            };
            (time, state)
        }),
    );
    write(
        writer,
        "/auv/planes",
        times().map(|time| {
            let planes = JointState {
                header: header(time),
                name: vec!["dive_planes".to_owned(), "ram".to_owned()],
                position: vec![0.1, time as f64],
                ..JointState::default()
            };
            (time, planes)
        }),
    );
    write(
        writer,
        "/tf",
        times().map(|time| {
            let mut transforms = TFMessage::default();
            transforms.transforms.resize(2, Default::default());
            transforms.transforms[1].header = header(time);
            transforms.transforms[1].transform.rotation.w = 1.0;
            (time, transforms)
        }),
    );
}

fn options(compression: Compression) -> WriterOptions {
    WriterOptions {
        compression,
        chunk_size: 2000,
        flush_interval: None,
        ..WriterOptions::default()
    }
}

fn new_bag(path: &Path, compression: Compression) -> BagWriter {
    BagWriter::create(path, options(compression)).expect("a new bag")
}

#[test]
fn foreign_readers_find_every_message_with_its_values() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (compression, max_file_size) in [
        (Compression::None, None),
        (Compression::Zstd, None),
        (Compression::Zstd, Some(6000)),
    ] {
        let path = folder
            .path()
            .join(format!("{compression:?}_{max_file_size:?}"));
        let options = WriterOptions {
            max_file_size,
            ..options(compression)
        };
        let mut writer = BagWriter::create(&path, options).expect("a new bag");
        fill(&mut writer, 50);
        let metadata = writer.close().expect("room on the disk");
        assert_eq!(metadata.files.len() > 1, max_file_size.is_some());
        let Some(output) = read_bag(&[&path]) else {
            return;
        };
        let found = agreed(&output);
        assert_eq!(found["closed"], true);
        let state = &found["topics"]["/auv/state"];
        assert_eq!(state["type"], VehicleState::TYPE_NAME);
        assert_eq!(state["type_hash"], VehicleState::TYPE_HASH);
        assert_eq!(state["count"], 50);
        assert_eq!(state["last"], 2_450_000_000_i64);
        assert_eq!(state["values"][3]["depth"], 0.15);
        assert_eq!(state["offered_qos"][0]["reliability"], "reliable");
        assert_eq!(state["offered_qos"][0]["depth"], 10);
        let planes = &found["topics"]["/auv/planes"];
        assert_eq!(planes["values"][1]["name"][1], "ram");
        assert_eq!(planes["values"][2]["position"][1], 1e8);
    }
}

#[test]
fn foreign_readers_compute_the_type_hash_of_every_type() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("types");
    let mut writer = new_bag(&path, Compression::Zstd);
    // rosbags takes `char` for `uint8`; REP-2011 tells them apart.
    let types = || {
        planesman_msgs::registry()
            .iter()
            .filter(|info| !info.definition.contains("char["))
    };
    for info in types() {
        let name = format!("/{}", info.type_name);
        let topic = Topic::of_type(info, name, OfferedQos::best_effort(5));
        writer.add_topic(&topic).expect("a new topic");
    }
    writer.close().expect("room on the disk");
    let Some(output) = read_bag(&[&path]) else {
        return;
    };
    let found = agreed(&output);
    for info in types() {
        let topic = &found["topics"][format!("/{}", info.type_name)];
        assert_eq!(topic["type_hash"], info.type_hash, "{}", info.type_name);
    }
}

#[test]
fn a_killed_bag_gives_foreign_readers_what_it_gives_ours() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("killed");
    let mut writer = new_bag(&path, Compression::Zstd);
    fill(&mut writer, 50);
    let file: PathBuf = writer.file().to_owned();
    std::mem::forget(writer);
    let Some(output) = read_bag(&[Path::new("--mcap-only"), &file]) else {
        return;
    };
    let found = agreed(&output);
    assert_eq!(found["closed"], false);
    let bag = BagReader::open(&path).expect("a bag");
    assert!(bag.message_count() > 0);
    for count in bag.topics() {
        assert_eq!(found["topics"][&count.topic.name]["count"], count.messages);
    }
}

#[test]
fn foreign_readers_refuse_what_ours_refuses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let absent = folder.path().join("absent");
    let Some(output) = read_bag(&[&absent]) else {
        return;
    };
    assert_eq!(output.status.code(), Some(2));
    assert!(BagReader::open(&absent).is_err());
}

/// A message whose every number, flag and text differs from the default.
fn varied<M: Message>() -> M {
    fn vary(value: &mut Value, count: &mut u8) {
        *count = *count % 100 + 1;
        match value {
            Value::Number(number) => {
                *value = if number.is_f64() {
                    (f64::from(*count) + 0.5).into()
                } else {
                    (*count).into()
                }
            }
            Value::Bool(flag) => *flag = !*flag,
            Value::String(text) => *text = format!("text {count}"),
            Value::Array(items) => items.iter_mut().for_each(|item| vary(item, count)),
            Value::Object(fields) => fields.values_mut().for_each(|field| vary(field, count)),
            Value::Null => {}
        }
    }
    let mut value = serde_json::to_value(M::default()).expect("a message is JSON");
    vary(&mut value, &mut 0);
    serde_json::from_value(value).expect("the same fields")
}

#[test]
fn foreign_readers_decode_every_type_of_the_loop_to_the_same_values() {
    use planesman_msgs::{
        diagnostic_msgs::msg::DiagnosticArray,
        nav_msgs::msg::Odometry,
        planesman_msgs::msg::{
            ControlState, DhaState, ModelEstimate, PlaneCommand, PlaneMotion, TickAnswer,
        },
        rcl_interfaces::msg::{Log, ParameterEvent},
        rosgraph_msgs::msg::Clock,
        sensor_msgs::msg::{FluidPressure, Imu},
        std_msgs::msg::Float64,
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("values");
    let mut writer = new_bag(&path, Compression::Zstd);
    let mut expected = Vec::new();
    macro_rules! write_each {
        ($($type:ty),* $(,)?) => {$(
            let message = varied::<$type>();
            let name = format!("/{}", <$type>::TYPE_NAME);
            expected.push((name.clone(), serde_json::to_value(&message).expect("JSON")));
            write(&mut writer, &name, std::iter::once((0, message)));
        )*};
    }
    let mut diagnostics = varied::<DiagnosticArray>();
    diagnostics.status.push(varied());
    diagnostics.status[0].values.push(varied());
    expected.push((
        "/diagnostics".to_owned(),
        serde_json::to_value(&diagnostics).expect("JSON"),
    ));
    write(
        &mut writer,
        "/diagnostics",
        std::iter::once((0, diagnostics)),
    );
    write_each!(
        VehicleState,
        PlaneCommand,
        ControlState,
        PlaneMotion,
        DhaState,
        ModelEstimate,
        TickAnswer,
        Odometry,
        TFMessage,
        Imu,
        FluidPressure,
        JointState,
        Clock,
        Float64,
        Log,
        ParameterEvent,
    );
    writer.close().expect("room on the disk");
    let Some(output) = read_bag(&[&path]) else {
        return;
    };
    let found = agreed(&output);
    for (name, value) in expected {
        assert_eq!(found["topics"][&name]["values"][0], value, "{name}");
    }
}
