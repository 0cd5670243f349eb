//! Writes the seeds that are bytes and not text, a folder for each target, into the folder that `SEEDS` names. Built as a
//! target is, since the same instrumented crates are in it.
#![no_main]
#![allow(unreachable_code)] // It exits before there is anything to fuzz.

use std::fs;
use std::path::{Path, PathBuf};

use planesman_bag::{BagWriter, Compression, OfferedQos, Topic, WriterOptions};
use planesman_model_file::ModelFile;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, DhaState, ModelEstimate, PlaneCommand, PlaneMotion, VehicleState,
};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::{Float64, Header};
use planesman_msgs::{Message, cdr};
use planesman_testing::telemetry::{self, Version};
use planesman_testing::{dataflash, hostile, mcap, ulog};

libfuzzer_sys::fuzz_target!(
    init: {
        write();
        std::process::exit(0)
    },
    |_data: &[u8]| {}
);

fn write() {
    let folder = std::env::var_os("SEEDS").map(PathBuf::from);
    let folder = folder.expect("SEEDS=FOLDER");
    for target in [
        "bag", "cdr", "csv", "flight", "log", "rtps", "schema", "ulog", "yaml",
    ] {
        fs::create_dir_all(folder.join(target)).expect("a folder");
    }
    for (name, compression) in [
        ("plain.mcap", Compression::None),
        ("zstd.mcap", Compression::Zstd),
    ] {
        floats(&folder.join("bag").join(name), compression);
    }
    let (num, den) = (vec![0.1, 0.2], vec![1.0, -0.9, 0.1]);
    let model = ModelFile::exact("planes:x", "state:y", 0.05, num, den);
    for name in ["model.yaml", "model.json"] {
        model
            .write(&folder.join("yaml").join(name))
            .expect("a model file");
    }
    flight(&folder.join("flight/three_ticks.mcap"));
    fs::write(folder.join("ulog/log"), ulog::log(&[(1.0, 0.0); 25])).expect("a seed");
    for (name, kind, bytes) in [
        ("dataflash", 0, dataflash::log(&[(1.0, 0.0); 25])),
        (
            "mavlink_1",
            1,
            telemetry::log(&[(1.0, 0.0); 25], Version::One, 1),
        ),
        (
            "mavlink_2",
            1,
            telemetry::log(&[(1.0, 0.0); 25], Version::Two, 2),
        ),
        (
            "moos",
            2,
            b"0.0 A p 1.5\n0.1 B p X=1,Y=2\n0.2 A p 2\n".to_vec(),
        ),
    ] {
        let bytes = [&[kind], &bytes[..]].concat();
        fs::write(folder.join("log").join(name), bytes).expect("a seed");
    }
    hurtful(&folder);
    datagrams(&folder.join("rtps"));
    payload(&folder, 0, &state(0));
    payload(&folder, 1, &motion(0));
    payload(&folder, 2, &self::model(0));
    payload(&folder, 4, &JointState::default());
    for (name, language, text) in [
        ("model", 0_u8, ModelEstimate::DEFINITION),
        ("motion", 0, PlaneMotion::DEFINITION),
        ("idl", 1, IDL),
    ] {
        let bytes = [&[language], text.as_bytes()].concat();
        fs::write(folder.join("schema").join(name), bytes).expect("a seed");
    }
}

/// The cases of the tests that are short enough for a target, behind the byte that chooses where it takes one.
fn hurtful(folder: &Path) {
    let behind = |choice: u8, text: &[u8]| [&[choice], text].concat();
    let texts = |cases: Vec<hostile::Case<String>>, choice: u8| -> Vec<Vec<u8>> {
        let cases = cases.iter();
        cases
            .map(|(_, text)| behind(choice, text.as_bytes()))
            .collect()
    };
    let bags = hostile::records()
        .into_iter()
        .map(|(_, bytes)| [mcap::beginning(), bytes, mcap::end()].concat());
    let tables = hostile::tables().into_iter();
    let yaml = hostile::yaml().into_iter();
    let all: [(&str, Vec<Vec<u8>>); 5] = [
        ("bag", bags.collect()),
        ("csv", tables.map(|(_, bytes)| behind(0, &bytes)).collect()),
        ("schema", texts(hostile::schemas(), 0)),
        ("schema", texts(hostile::idl(), 1)),
        ("yaml", yaml.map(|(_, text)| text.into_bytes()).collect()),
    ];
    for (target, cases) in all {
        let short = cases.iter().filter(|case| case.len() <= LONGEST);
        for (number, case) in short.enumerate() {
            let name = format!("hurtful_{}_{number}", case.first().unwrap_or(&0));
            fs::write(folder.join(target).join(name), case).expect("a seed");
        }
    }
}

/// The longest input that `fuzz/run` lets libFuzzer make.
const LONGEST: usize = 16_384;

/// One datagram for each kind of submessage (RTPS 2.3, 9.4.5), of the writer and to the reader that are matched, and all
/// in one; the target gives them a header.
fn datagrams(folder: &Path) {
    let ends = [[0, 0, 1, 4], [0, 0, 1, 3]].concat();
    let number = |n: u32| [0_u32, n].map(u32::to_le_bytes).concat();
    let set = |n: u32| {
        [
            number(n),
            [4_u32, 0xa000_0000, 1].map(u32::to_le_bytes).concat(),
        ]
        .concat()
    };
    let data = |after: u16| [[0, 0, after as u8, 0].to_vec(), ends.clone(), number(1)].concat();
    let fragment = [1_u32.to_le_bytes().to_vec(), vec![1, 0, 4, 0, 8, 0, 0, 0]].concat();
    let bodies: [(u8, Vec<u8>); 8] = [
        (0x06, [ends.clone(), set(1)].concat()),
        (
            0x07,
            [ends.clone(), number(1), number(9), vec![1, 0, 0, 0]].concat(),
        ),
        (0x08, [ends.clone(), number(2), set(3)].concat()),
        (0x09, vec![0; 8]),
        (0x0e, vec![9; 12]),
        (
            0x12,
            [
                ends.clone(),
                number(1),
                [1_u32, 4, 0xf000_0000, 1].map(u32::to_le_bytes).concat(),
            ]
            .concat(),
        ),
        (0x15, [data(16), vec![0, 1, 0, 0, 1, 2, 3, 4]].concat()),
        (0x16, [data(28), fragment, vec![0, 1, 0, 0]].concat()),
    ];
    let mut all = Vec::new();
    for (kind, body) in bodies {
        let flags = if kind == 0x15 { 5 } else { 1 };
        let length = u16::try_from(body.len()).expect("short");
        let submessage = [&[kind, flags], &length.to_le_bytes()[..], &body[..]].concat();
        let datagram = |bytes: &[u8]| {
            let length = u16::try_from(bytes.len()).expect("short");
            [&length.to_le_bytes()[..], bytes].concat()
        };
        fs::write(folder.join(format!("{kind:02x}")), datagram(&submessage)).expect("a seed");
        all.extend(datagram(&submessage));
    }
    fs::write(folder.join("all"), all).expect("a seed");
}

const IDL: &str = "module a { module msg {
  typedef double double__3[3];
  module A_Constants { const long SIZE = 3; };
  @verbatim (language=\"comment\", text=\"a message\")
  struct A { double__3 x; @unit(value=\"m\") sequence<float, 4> y; string<8> z; boolean w; };
}; };
";

fn writer(path: &Path, compression: Compression) -> BagWriter {
    let _ = fs::remove_file(path);
    let options = WriterOptions {
        compression,
        chunk_size: 256,
        flush_interval: None,
        ..WriterOptions::default()
    };
    BagWriter::create_file(path, options).expect("a bag")
}

fn floats(path: &Path, compression: Compression) {
    let mut bag = writer(path, compression);
    let topic = Topic::of::<Float64>("/a", OfferedQos::reliable(1));
    let topic = bag.add_topic(&topic).expect("a topic");
    for k in 0..8 {
        let message = Float64 { data: k as f64 };
        bag.write(topic, &message, k * 100).expect("written");
    }
    bag.close().expect("closed");
}

fn flight(path: &Path) {
    let mut bag = writer(path, Compression::None);
    let mut put = |name: &str, messages: Vec<(i64, Vec<u8>)>, topic: Topic| {
        let topic = bag.add_topic(&topic).expect(name);
        for (time, payload) in messages {
            bag.write_raw(topic, &payload, time, time).expect(name);
        }
    };
    fn three<M: Message>(of: fn(i64) -> M) -> Vec<(i64, Vec<u8>)> {
        let times = (0..3).map(|k| k * 50_000_000);
        times.map(|at| (at, cdr::to_bytes(&of(at)))).collect()
    }
    let qos = || OfferedQos::reliable(1);
    put(
        "state",
        three(state),
        Topic::of::<VehicleState>("/auv/state", qos()),
    );
    let control = |at| ControlState {
        header: header(at),
        mode: ControlState::MODE_DEPTH,
        depth_target: 1.0,
        ..ControlState::default()
    };
    put(
        "control",
        three(control),
        Topic::of::<ControlState>("/auv/control_state", qos()),
    );
    let command = |at| PlaneCommand {
        header: header(at),
        ..PlaneCommand::default()
    };
    put(
        "command",
        three(command),
        Topic::of::<PlaneCommand>("/auv/plane_command", qos()),
    );
    put(
        "motion",
        three(motion),
        Topic::of::<PlaneMotion>("/auv/plane_motion", qos()),
    );
    let ram = |at| DhaState {
        header: header(at),
        group: "planes".to_owned(),
        ..DhaState::default()
    };
    put(
        "ram",
        three(ram),
        Topic::of::<DhaState>("/auv/dha_state", qos()),
    );
    put(
        "model",
        three(model),
        Topic::of::<ModelEstimate>("/auv/model", qos()),
    );
    bag.close().expect("closed");
}

fn header(at: i64) -> Header {
    Header {
        stamp: Time::from_nanos(at),
        ..Header::default()
    }
}

fn state(at: i64) -> VehicleState {
    VehicleState {
        header: header(at),
        depth: at as f64 * 1e-9,
        ..VehicleState::default()
    }
}

fn motion(at: i64) -> PlaneMotion {
    PlaneMotion {
        header: header(at),
        dive_planes: vec![0.0, 0.1],
        ..PlaneMotion::default()
    }
}

fn model(at: i64) -> ModelEstimate {
    ModelEstimate {
        header: header(at),
        name: "model".to_owned(),
        input: "plane_motion:dive_planes".to_owned(),
        output: "state:pitch_rate".to_owned(),
        valid: true,
        a: vec![-0.9],
        b: vec![0.1],
        s_poles_re: vec![-0.5],
        s_poles_im: vec![0.0],
        ..ModelEstimate::default()
    }
}

fn payload(folder: &Path, kind: u8, message: &impl Message) {
    let bytes = [&[kind], &cdr::to_bytes(message)[..]].concat();
    fs::write(folder.join("cdr").join(kind.to_string()), bytes).expect("a seed");
}
