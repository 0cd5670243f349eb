//! The program itself on data made to hurt it: every run ends by itself, in little memory, with a clear error or an answer
//! that says what it is of.
//!
//! Each case is a process of its own under a limit of address space and of processor time. More random cases than the
//! usual run with `PLANESMAN_HOSTILE=COUNT` in the environment.

use crate::bags;
use std::fs;
use std::io::Read as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use bags::{FLOAT, IMU, Maker, float, imu};
use planesman_decode::schema as schemas;
use planesman_identifier::{Identifier, IdentifierParameters};
use planesman_msgs::Message as _;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_testing::hostile::{self, mutated};
use planesman_testing::mcap::{self, beginning, channel, end, lying_record, message, schema};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// Address space for one run, KiB: less than the 300 MB that a bag of a gigabyte may take, and what the program's own
/// file takes.
const MEMORY: u64 = 400_000;

/// Processor time, s.
const SECONDS: u64 = 60;

/// Two signals of two topics, as [`lawful`] has.
const SIGNALS: &str =
    "--input /cmd:data --output /imu:angular_velocity.y --order 1 --method least_squares";

/// How a run ended.
#[derive(Debug)]
struct Ended {
    succeeded: bool,
    printed: String,
    complaint: String,
}

/// Runs a command of `planesman sysid` and judges how it ends; `case` names what it was given.
fn sysid(case: &str, arguments: &str, data: &[&Path]) -> Ended {
    let limited = format!("ulimit -v {MEMORY}; ulimit -t {SECONDS}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_planesman"), "sysid"])
        .args(arguments.split_whitespace().take(1))
        .args(data)
        .args(arguments.split_whitespace().skip(1))
        .env_remove("RUST_BACKTRACE")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = child.stdout.take().unwrap();
    let out = std::thread::spawn(move || {
        let mut printed = Vec::new();
        out.read_to_end(&mut printed).unwrap();
        printed
    });
    let mut complaint = Vec::new();
    let begin = Instant::now();
    // The pipe is closed when the program ends; one that waits is ended from here.
    let watch = child.id();
    let (ended, waiting) = std::sync::mpsc::channel::<()>();
    let guard = std::thread::spawn(move || {
        let patience = Duration::from_secs(10 * SECONDS);
        if waiting.recv_timeout(patience) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
            let _ = Command::new("kill").arg(watch.to_string()).status();
        }
    });
    child
        .stderr
        .take()
        .unwrap()
        .read_to_end(&mut complaint)
        .unwrap();
    let status = child.wait().unwrap();
    drop(ended);
    guard.join().unwrap();
    let printed = String::from_utf8_lossy(&out.join().unwrap()).into_owned();
    let complaint = String::from_utf8_lossy(&complaint).into_owned();
    let case = format!(
        "{case}: planesman sysid {arguments}: {:?}: {complaint}",
        begin.elapsed()
    );
    assert_eq!(status.signal(), None, "{case}");
    assert!(!complaint.contains("panicked"), "{case}");
    // Nothing that a terminal would obey is passed on.
    let acts = |text: &str| text.contains(|c: char| c.is_control() && !"\n\t".contains(c));
    assert!(!acts(&printed) && !acts(&complaint), "{case}");
    if status.success() {
        assert!(!printed.is_empty(), "{case}");
        // On a busy machine it says how long it has worked.
        let is_progress = |line: &str| line.starts_with("models, ");
        assert!(complaint.lines().all(is_progress), "{case}");
    } else {
        assert!(complaint.starts_with("planesman: "), "{case}");
        assert!(complaint.len() < 3000, "{case}");
    }
    Ended {
        succeeded: status.success(),
        printed,
        complaint,
    }
}

/// Every command that reads data.
fn looks_through(case: &str, data: &[&Path]) -> [Ended; 2] {
    [
        sysid(case, "topics", data),
        sysid(case, &format!("fit {SIGNALS}"), data),
    ]
}

/// A bag as it should be: floats on /cmd, Imu on /imu.
fn lawful(path: &Path) {
    let mut maker = Maker::new(path);
    let (cmd, imus) = (maker.topic("/cmd", FLOAT), maker.topic("/imu", IMU));
    let mut y = 0.0;
    for k in 0..200_i64 {
        let u = f64::from(u8::from((k / 15) % 2 == 0));
        maker.write(cmd, &float(u), k * 50_000_000);
        maker.write(imus, &imu(k * 50_000_000, y), k * 50_000_000);
        y = 0.9 * y + 0.2 * u;
    }
    maker.close();
}

/// One topic of one type with some payloads.
fn one_topic(encoding: (&str, &str), text: impl AsRef<[u8]>, payloads: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = beginning();
    bytes.extend(schema(1, "a/msg/A", encoding.0, text));
    bytes.extend(channel(1, 1, "/a", encoding.1));
    for (k, payload) in payloads.iter().enumerate() {
        bytes.extend(message(1, k as u64 * 50_000_000, payload));
    }
    bytes.extend(end());
    bytes
}

fn payload(numbers: &[u32]) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    numbers.iter().for_each(|it| bytes.extend(it.to_le_bytes()));
    bytes
}

/// How many random cases of a kind are tried, for so many in the usual run.
fn count(usual: usize) -> usize {
    match std::env::var("PLANESMAN_HOSTILE") {
        Ok(count) => count.parse().unwrap(),
        Err(_) => usual,
    }
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

#[test]
fn a_lawful_bag_is_read_under_the_limits() {
    let folder = Folder::new();
    let path = folder.0.path().join("a.mcap");
    lawful(&path);
    for ended in looks_through("lawful", &[&path]) {
        assert!(ended.succeeded, "{ended:?}");
    }
}

#[test]
fn a_million_topics_are_listed_in_part_under_300_megabytes() {
    let folder = Folder::new();
    // 16 bits number a file's channels: a million take sixteen files.
    for number in 0..16_u32 {
        let mut bytes = beginning();
        bytes.extend(schema(1, FLOAT.0, FLOAT.1, FLOAT.2));
        for id in 1..=62_500_u16 {
            let name = format!("/fleet/vehicle_{number:02}_{id:05}/depth");
            bytes.extend(channel(id, 1, &name, "cdr"));
            if id % 20 == 0 {
                bytes.extend(message(id, 1, &float(1.0)));
            }
        }
        bytes.extend(end());
        folder.file(&format!("a_{number}.mcap"), bytes);
    }
    let folder = folder.0.path();
    let listed = sysid("a million topics", "topics", &[folder]);
    assert!(listed.printed.contains("999000 more topics are not listed"));
    assert!(!listed.printed.contains("skipped"), "{}", listed.printed);
    let signals =
        "--input /fleet/vehicle_00_00020/depth:data --output /fleet/vehicle_15_62500/depth:data";
    let fit = sysid("a million topics", &format!("fit {signals}"), &[folder]);
    assert!(
        fit.complaint
            .contains("0 rows of the regression cannot determine"),
        "{fit:?}"
    );
}

#[test]
fn a_cut_bag_gives_what_is_before_the_cut_or_an_error() {
    let folder = Folder::new();
    let path = folder.0.path().join("a.mcap");
    lawful(&path);
    let bytes = fs::read(&path).unwrap();
    // Every place in the first record and about the last, and many between.
    let last = bytes.len() - 40;
    let step = bytes.len() / count(100) + 1;
    let places = (0..30)
        .chain((30..last).step_by(step))
        .chain(last..bytes.len());
    for place in places {
        let cut = folder.file("cut.mcap", &bytes[..place]);
        let [topics, _] = looks_through(&format!("cut at {place}"), &[&cut]);
        assert!(
            !topics.succeeded || topics.printed.contains("incomplete"),
            "{place}: {topics:?}"
        );
    }
}

#[test]
fn changed_bytes_give_an_answer_or_an_error() {
    let folder = Folder::new();
    let path = folder.0.path().join("a.mcap");
    lawful(&path);
    let bytes = fs::read(&path).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(1988);
    for number in 0..count(250) {
        let changed = folder.file("changed.mcap", mutated(&bytes, &mut random));
        looks_through(&format!("change {number}"), &[&changed]);
    }
}

#[test]
fn lengths_that_lie_take_no_memory() {
    let folder = Folder::new();
    for (case, bytes) in hostile::records() {
        for tail in [&[][..], &end()] {
            let path = folder.file("lie.mcap", [&beginning(), &bytes[..], tail].concat());
            looks_through(case, &[&path]);
        }
    }
    for (case, bytes) in hostile::indexes() {
        let path = folder.file("index.mcap", bytes);
        looks_through(case, &[&path]);
    }
}

#[test]
fn schemas_made_to_hurt_are_refused_or_listed_in_part() {
    let folder = Folder::new();
    let payloads = [
        payload(&[u32::MAX; 8]),
        payload(&[0; 64]),
        payload(&[1; 64]),
        vec![],
        vec![0, 1],
    ];
    let msg = hostile::schemas().into_iter();
    let idl = hostile::idl().into_iter();
    let all = msg
        .map(|(case, text)| (case, "ros2msg", text))
        .chain(idl.map(|(case, text)| (case, "ros2idl", text)));
    for (case, encoding, text) in all {
        let path = folder.file("schema.mcap", one_topic((encoding, "cdr"), text, &payloads));
        let topics = sysid(case, "topics", &[&path]);
        assert!(topics.succeeded, "{case}: {topics:?}");
        sysid(
            case,
            "fit --input a:x --output a:x --method least_squares",
            &[&path],
        );
    }
    let random_bytes: Vec<u8> = (0..=255).cycle().take(5000).collect();
    for (case, encoding, text) in [
        ("a text that is no UTF-8", ("ros2msg", "cdr"), random_bytes),
        ("json", ("jsonschema", "json"), b"{}".to_vec()),
        ("protobuf", ("protobuf", "protobuf"), vec![10, 3, 1, 2, 3]),
        (
            "cdr of another schema",
            ("omgidl", "cdr"),
            b"struct A { double x; };".to_vec(),
        ),
        ("no encoding", ("", ""), Vec::new()),
        (
            "json in cdr's clothes",
            ("ros2msg", "json"),
            b"float64 x\n".to_vec(),
        ),
    ] {
        let path = folder.file("schema.mcap", one_topic(encoding, text, &payloads));
        let topics = sysid(case, "topics", &[&path]);
        assert!(
            topics.succeeded && topics.printed.contains("note: "),
            "{case}: {topics:?}"
        );
        let fit = sysid(
            case,
            "fit --input a:x --output a:x --method least_squares",
            &[&path],
        );
        assert!(!fit.succeeded, "{case}: {fit:?}");
    }
}

#[test]
fn payloads_whose_lengths_lie_are_reported_and_passed_over() {
    let folder = Folder::new();
    let payloads = hostile::payloads();
    for (text, types) in hostile::lists() {
        let path = folder.file(
            "payload.mcap",
            one_topic(("ros2msg", "cdr"), types, &payloads),
        );
        let topics = sysid(text, "topics", &[&path]);
        assert!(topics.succeeded, "{text}: {topics:?}");
        for path_in in [
            "v[99999999]",
            "v[18446744073709551615]",
            "b[4000000000].c[4000000000].y[4000000000]",
            "x",
        ] {
            let arguments = format!("fit --input a:{path_in} --output a:x --method least_squares");
            sysid(text, &arguments, &[&path]);
        }
    }
    let path = folder.file(
        "path.mcap",
        one_topic(("ros2msg", "cdr"), "float64 x\n", &[float(1.0)]),
    );
    for signal in [
        "a:x".to_owned() + &".x".repeat(30_000),
        "a:x".to_owned() + &"[0]".repeat(30_000),
        "a:".to_owned() + &"x".repeat(100_000),
    ] {
        let arguments = [
            "fit",
            path.to_str().unwrap(),
            "--input",
            &signal,
            "--output",
            "a:x",
        ];
        let output = Command::new(env!("CARGO_BIN_EXE_planesman"))
            .arg("sysid")
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code().map(|it| it != 0), Some(true));
    }
}

#[test]
fn tables_made_to_hurt_are_refused_or_read_in_part() {
    let folder = Folder::new();
    for (case, bytes) in hostile::tables() {
        let path = folder.file("a.csv", bytes);
        for arguments in [
            "topics",
            "fit --input u --output y",
            "fit --input u --output y --time-unit ns --rate 1000000 --method least_squares",
        ] {
            sysid(case, arguments, &[&path]);
        }
    }
    let table = ["t,u,y\n", &hostile::rows(200)].concat();
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for number in 0..count(60) {
        let path = folder.file("changed.csv", mutated(table.as_bytes(), &mut random));
        sysid(&format!("table {number}"), "topics", &[&path]);
        sysid(
            &format!("table {number}"),
            "fit --input u --output y --method least_squares",
            &[&path],
        );
    }
}

/// The tables of rosbag2's sqlite3 storage.
const TABLES: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,
     offered_qos_profiles TEXT);
     CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);";

#[test]
fn databases_made_to_hurt_are_refused_or_read_in_part() {
    let folder = Folder::new();
    let forever = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n";
    for (case, sql) in [
        ("no tables", "CREATE TABLE cats(name TEXT)".to_owned()),
        ("empty tables", TABLES.to_owned()),
        (
            "a view that never ends",
            format!(
                "CREATE VIEW topics(id, name, type, serialization_format, offered_qos_profiles) AS {forever}) SELECT i, i, i, 'cdr', '' FROM n"
            ),
        ),
        (
            "300 000 topics",
            format!(
                "{TABLES} {forever} LIMIT 300000) INSERT INTO topics SELECT i, '/t' || i, 'std_msgs/msg/Float64', 'cdr', '' FROM n"
            ),
        ),
        (
            "a million messages of topics that are not there",
            format!(
                "{TABLES} {forever} LIMIT 1000000) INSERT INTO messages SELECT i, i, i, x'00' FROM n"
            ),
        ),
        (
            "a payload of 200 MB",
            format!(
                "{TABLES} INSERT INTO topics VALUES (1, '/cmd', 'std_msgs/msg/Float64', 'cdr', ''); INSERT INTO messages VALUES (1, 1, 1, zeroblob(200000000))"
            ),
        ),
        (
            "a name of 200 MB",
            format!("{TABLES} INSERT INTO topics VALUES (1, zeroblob(200000000), 'a', 'cdr', '')"),
        ),
        (
            "numbers that are texts",
            format!(
                "{TABLES} INSERT INTO topics VALUES (1, '/cmd', 'std_msgs/msg/Float64', 'cdr', ''); INSERT INTO messages VALUES (1, 1, 'noon', 'text')"
            ),
        ),
        (
            "names that act on a terminal",
            format!(
                "{TABLES} INSERT INTO topics VALUES (1, char(27) || '[2J', char(27) || ']0;x', char(27), char(27))"
            ),
        ),
    ] {
        let path = folder.0.path().join("a.db3");
        let _ = fs::remove_file(&path);
        rusqlite::Connection::open(&path)
            .unwrap()
            .execute_batch(&sql)
            .unwrap();
        looks_through(case, &[&path]);
    }
}

#[test]
fn files_packed_whole_that_hurt_unpacked_are_read_in_part() {
    let folder = Folder::new();
    let packed = |bytes: &[u8]| zstd::encode_all(bytes, 1).unwrap();
    let mut zeros = beginning();
    zeros.resize(400 << 20, 0);
    let mut long = beginning();
    long.extend(lying_record(5, u64::MAX, &vec![0; 1 << 20]));
    for (case, bytes) in [
        ("zeros behind a header", packed(&zeros)),
        ("zeros", packed(&vec![0; 200 << 20])),
        ("a record that claims all", packed(&long)),
        ("packed twice", packed(&packed(&beginning()))),
        ("no frame", b"\x28\xb5\x2f\xfd no frame".to_vec()),
    ] {
        let path = folder.file("a.mcap.zstd", bytes);
        looks_through(case, &[&path]);
    }
}

#[test]
fn what_is_no_data_is_refused() {
    let folder = Folder::new();
    let at = |name: &str| folder.0.path().join(name);
    fs::create_dir(at("empty")).unwrap();
    fs::create_dir(at("folder.csv")).unwrap();
    fs::create_dir(at("folder.mcap")).unwrap();
    fs::create_dir(at("nested")).unwrap();
    fs::create_dir(at("nested/a.mcap")).unwrap();
    fs::create_dir(at("nested/metadata.yaml")).unwrap();
    for name in ["pipe.mcap", "pipe.csv"] {
        assert!(
            Command::new("mkfifo")
                .arg(at(name))
                .status()
                .unwrap()
                .success()
        );
    }
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let noise: Vec<u8> = (0..100_000).map(|_| random.random()).collect();
    folder.file("noise.mcap", &noise);
    folder.file("magic.mcap", [mcap::MAGIC, &noise].concat());
    folder.file("header.mcap", [&beginning(), &noise[..]].concat());
    folder.file("only_magic.mcap", mcap::MAGIC);
    folder.file("nothing.mcap", "");
    folder.file("noise.bag", &noise);
    for name in [
        "absent",
        "absent.csv",
        "empty",
        "folder.csv",
        "folder.mcap",
        "nested",
        "pipe.mcap",
        "pipe.csv",
        "noise.mcap",
        "magic.mcap",
        "only_magic.mcap",
        "nothing.mcap",
        "noise.bag",
    ] {
        for ended in looks_through(name, &[&at(name)]) {
            assert!(!ended.succeeded, "{name}: {ended:?}");
        }
    }
    looks_through("noise behind a header", &[&at("header.mcap")]);
    for device in ["/dev/null", "/dev/zero", "/dev/stdin", "/proc/self/mem"] {
        for ended in looks_through(device, &[Path::new(device)]) {
            assert!(!ended.succeeded, "{device}: {ended:?}");
        }
    }
}

#[test]
fn metadata_that_lies_hides_no_message_and_takes_no_memory() {
    let folder = Folder::new();
    let bag = folder.0.path().join("bag");
    fs::create_dir(&bag).unwrap();
    lawful(&bag.join("bag_0.mcap"));
    let account = |about: &str| {
        format!(
            "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  duration: {{nanoseconds: 0}}\n  \
             starting_time: {{nanoseconds_since_epoch: 0}}\n  topics_with_message_count: []\n  {about}\n"
        )
    };
    let listed = |files: &str| {
        account(&format!(
            "message_count: 400\n  relative_file_paths: [{files}]"
        ))
    };
    for (case, text, is_read) in [
        ("lawful", listed("bag_0.mcap"), true),
        (
            "a count that lies",
            listed("bag_0.mcap").replace("400", "18446744073709551615"),
            true,
        ),
        (
            "a count below zero",
            listed("bag_0.mcap").replace("400", "-1"),
            true,
        ),
        (
            "a file that is not there",
            listed("bag_0.mcap, bag_1.mcap"),
            true,
        ),
        // What is there is read in its place.
        ("a file elsewhere", listed("../../../../etc/passwd"), true),
        ("a file of another kind", listed("metadata.yaml"), false),
        ("no file", listed(""), true),
        (
            "one file many times",
            listed(&"bag_0.mcap, ".repeat(500)),
            true,
        ),
        (
            "another storage",
            listed("bag_0.mcap").replace("mcap\n", "lmdb\n"),
            false,
        ),
        ("not this", "a: b\n".to_owned(), true),
        ("nothing", String::new(), true),
        ("long", "x".repeat(100 << 20), true),
        (
            "many small things",
            account(&format!("custom_data: [{}]", "a,".repeat(2_000_000))),
            true,
        ),
    ]
    .into_iter()
    .chain(
        hostile::yaml()
            .into_iter()
            .map(|(case, text)| (case, text, true)),
    ) {
        fs::write(bag.join("metadata.yaml"), text).unwrap();
        for ended in looks_through(case, &[&bag]) {
            assert_eq!(ended.succeeded, is_read, "{case}: {ended:?}");
        }
    }
}

#[test]
fn garbage_on_the_nodes_topics_is_refused_and_makes_no_estimate_that_is_not_finite() {
    let parameters = IdentifierParameters {
        input: "cmd:angular_velocity.z".to_owned(),
        output: "imu:angular_velocity.y".to_owned(),
        break_on: String::new(),
        ..IdentifierParameters::default()
    };
    let mut identifier = Identifier::new(&parameters).unwrap();
    let types = schemas::read(IMU.0, IMU.1, IMU.2).unwrap();
    let mut readers =
        ["/auv/cmd", "/auv/imu"].map(|topic| identifier.reader(topic, &types).unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let (mut accepted, mut refused) = (0, 0);
    for k in 0..20_000_i64 {
        let lawful = imu(k * 50_000_000, random.random_range(-1.0..1.0));
        let payload = match random.random_range(0..4) {
            0 => (0..random.random_range(0..400))
                .map(|_| random.random())
                .collect(),
            1 => mutated(&lawful, &mut random),
            _ => lawful,
        };
        let reader = &mut readers[(k % 2) as usize];
        let found = identifier.on_payload(reader, &Time::default(), &payload);
        assert_eq!(found.refused.is_empty(), found.stamp.is_some());
        for estimate in &found.estimates {
            assert_eq!(estimate.first_non_finite(), None);
        }
        accepted += usize::from(found.stamp.is_some());
        refused += found.refused.len();
    }
    assert!(accepted > 5000 && refused > 1000, "{accepted} {refused}");
}
