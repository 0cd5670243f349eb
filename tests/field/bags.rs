//! Bags: which frame, joint or publisher a number is of, whose clock stamped it, and types whose definition is not there.

use std::path::{Path, PathBuf};

use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use planesman_msgs::geometry_msgs::msg::TransformStamped;
use planesman_msgs::nav_msgs::msg::Odometry;
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Message, cdr};
use planesman_testing::{mcap, near};

use crate::answer::{Answer, fit, fit_with};
use crate::plant::{SAMPLES, STEP, log};
use crate::raw_bags::{FLOAT, IMU, Kind, Maker, float, imu};

const STEP_NS: i64 = (STEP * 1e9) as i64;
/// An epoch of today.
const EPOCH: i64 = 1_700_000_000_000_000_000;

/// A bag of some topics, each with its type, and messages: topic, payload, time of reception.
fn bag(folder: &Path, topics: &[(&str, Kind<'_>)], messages: &[(usize, Vec<u8>, i64)]) -> PathBuf {
    let path = folder.join("log.mcap");
    let mut maker = Maker::new(&path);
    let ids: Vec<_> = topics.iter().map(|it| maker.topic(it.0, it.1)).collect();
    for (topic, payload, time) in messages {
        maker.write(ids[*topic], payload, *time);
    }
    maker.close();
    path
}

fn kind<M: Message>() -> Kind<'static> {
    (M::TYPE_NAME, "ros2msg", M::DEFINITION)
}

/// The command of the plant on `/cmd`, and for each of its samples what `messages` makes of number, time and output: some payloads on `/out`.
fn driven<M: Message>(
    messages: impl Fn(usize, i64, f64) -> Vec<(Vec<u8>, i64)>,
) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let mut all = Vec::new();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        all.push((0, float(u[k]), time));
        all.extend(
            messages(k, time, y[k])
                .into_iter()
                .map(|it| (1, it.0, it.1)),
        );
    }
    bag(
        folder.path(),
        &[("/cmd", FLOAT), ("/out", kind::<M>())],
        &all,
    );
    folder
}

fn fitted(folder: &tempfile::TempDir, output: &str, more: &[&str]) -> Answer {
    let signals = ["log.mcap", "-i", "cmd:data", "-o", output];
    fit(folder.path(), &[&signals, more].concat())
}

fn transform(frame: &str, child: &str, x: f64) -> TransformStamped {
    let mut transform = TransformStamped::default();
    transform.header.frame_id = frame.to_owned();
    transform.child_frame_id = child.to_owned();
    transform.transform.translation.x = x;
    transform
}

fn frames(transforms: Vec<TransformStamped>) -> Vec<u8> {
    cdr::to_bytes(&TFMessage { transforms })
}

#[test]
fn a_transform_is_chosen_by_its_frame_and_an_index_that_is_now_one_now_another_is_refused() {
    let moving = |y| transform("odom", "base_link", y);
    let still = || transform("odom", "camera", 5.0);
    // Each in a message of its own, in one message in turns, and a frame that is only now and then there.
    let alone = driven::<TFMessage>(|_, time, y| {
        let later = time + STEP_NS / 5;
        vec![
            (frames(vec![moving(y)]), time),
            (frames(vec![still()]), later),
        ]
    });
    let in_turn = driven::<TFMessage>(|k, time, y| {
        let mut both = vec![moving(y), still()];
        both.rotate_left(k % 2);
        vec![(frames(both), time)]
    });
    let seldom = driven::<TFMessage>(|k, time, y| {
        let mut both = vec![moving(y)];
        if k % 50 == 7 {
            both.insert(0, still());
        }
        vec![(frames(both), time)]
    });
    for folder in [&alone, &in_turn, &seldom] {
        fitted(folder, "out:transforms[0].transform.translation.x", &[]).refused(&[
            "transforms[0] is now of odom->base_link, now of odom->camera",
            "'out:transforms[base_link].transform.translation.x' or 'out:transforms[camera].",
        ]);
        let chosen = "out:transforms[base_link].transform.translation.x";
        fitted(folder, chosen, &[]).is_the_plant(SAMPLES as u64);
    }
    fitted(
        &alone,
        "out:transforms[base_lnk].transform.translation.x",
        &[],
    )
    .refused(&["there is no 'base_lnk'; there are odom->base_link, odom->camera"]);
    // One frame throughout is what its index says.
    let one = driven::<TFMessage>(|_, time, y| vec![(frames(vec![moving(y), still()]), time)]);
    fitted(&one, "out:transforms[0].transform.translation.x", &[]).is_the_plant(SAMPLES as u64);
}

#[test]
fn one_child_in_two_parents_is_two_things() {
    let folder = driven::<TFMessage>(|_, time, y| {
        let pose = |frame, x, later| (frames(vec![transform(frame, "base_link", x)]), time + later);
        vec![pose("odom", y, 0), pose("map", 3.0 - y, STEP_NS / 3)]
    });
    fitted(&folder, "out:transforms[base_link].transform.translation.x", &[]).refused(&[
        "'out:transforms[map->base_link].transform.translation.x' or 'out:transforms[odom->base_link].",
    ]);
    let chosen = "out:transforms[odom->base_link].transform.translation.x";
    fitted(&folder, chosen, &[]).is_the_plant(SAMPLES as u64);
}

/// A joint state of these joints and positions.
fn joints(frame: &str, names: &[&str], position: Vec<f64>) -> Vec<u8> {
    let mut joints = JointState {
        name: names.iter().map(|it| (*it).to_owned()).collect(),
        position,
        ..JointState::default()
    };
    joints.header.frame_id = frame.to_owned();
    cdr::to_bytes(&joints)
}

#[test]
fn two_drivers_on_one_topic_are_told_apart_by_joints_by_frames_or_by_their_lists() {
    let two = |first: fn(f64) -> Vec<u8>, second: fn(f64) -> Vec<u8>| {
        driven::<JointState>(move |_, time, y| {
            vec![(first(y), time), (second(y), time + STEP_NS / 4)]
        })
    };
    let log = ["--stamp", "log"];
    let named = two(
        |y| joints("", &["elbow", "wrist"], vec![y, 1.0]),
        |y| joints("", &["pan", "tilt"], vec![2.0, -y]),
    );
    fitted(&named, "out:position[0]", &log).refused(&[
        "position[0] is now of elbow, now of pan",
        "'out:position[elbow]' or",
    ]);
    fitted(&named, "out:position[elbow]", &log).is_the_plant(SAMPLES as u64);
    // Names with a blank or a sign of equality are names as well.
    let framed = two(
        |y| joints("left arm", &[], vec![y, 1.0]),
        |y| joints("right arm", &[], vec![2.0, -y]),
    );
    fitted(&framed, "out:position[0]", &log).refused(&[
        "the messages are now of left arm, now of right arm",
        "'out:[left arm].position[0]' or",
    ]);
    fitted(&framed, "out:[left arm].position[0]", &log).is_the_plant(SAMPLES as u64);
    // Of numbers a change so rare would be a count that goes on.
    let seldom = driven::<JointState>(|k, time, y| match k % 20 {
        7 => vec![(joints("arm=b", &[], vec![2.0]), time)],
        _ => vec![(joints("arm=a", &[], vec![y]), time)],
    });
    fitted(&seldom, "out:position[0]", &log)
        .refused(&["the messages are now of arm=a, now of arm=b"]);
    let bare = two(
        |y| joints("", &[], vec![y, 1.0]),
        |y| joints("", &[], vec![2.0, -y, 0.0]),
    );
    fitted(&bare, "out:position[0]", &log).refused(&[
        "the list now has 2 numbers, now 3 numbers",
        "a separate topic",
    ]);
}

#[test]
fn two_publishers_of_an_odometry_are_told_apart_by_the_frames_of_their_messages() {
    let folder = driven::<Odometry>(|_, time, y| {
        let odometry = |frame: &str, x, later| {
            let mut odometry = Odometry::default();
            let time = time + later;
            odometry.header.stamp.sec = (time / 1_000_000_000) as i32;
            odometry.header.stamp.nanosec = (time % 1_000_000_000) as u32;
            odometry.header.frame_id = frame.to_owned();
            odometry.child_frame_id = "base_link".to_owned();
            odometry.pose.pose.position.x = x;
            (cdr::to_bytes(&odometry), time)
        };
        vec![odometry("odom", y, 0), odometry("map", 7.0, STEP_NS / 2)]
    });
    fitted(&folder, "out:pose.pose.position.x", &[])
        .refused(&["'out:[map->base_link].pose.pose.position.x'"]);
    fitted(&folder, "out:[odom->base_link].pose.pose.position.x", &[]).is_the_plant(SAMPLES as u64);
}

/// A bag of two topics of the type of `IMU`, whose stamps are what `stamps` makes of the time of reception.
fn stamped(stamps: [&dyn Fn(i64) -> i64; 2]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let mut all = Vec::new();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        for (topic, value) in [(0, u[k]), (1, y[k])] {
            all.push((topic, imu(stamps[topic](time), value), time));
        }
    }
    bag(folder.path(), &[("/cmd", IMU), ("/imu", IMU)], &all);
    folder
}

fn fitted_imu(folder: &tempfile::TempDir, more: &[&str]) -> Answer {
    let signals = [
        "log.mcap",
        "-i",
        "cmd:angular_velocity.y",
        "-o",
        "imu:angular_velocity.y",
    ];
    fit(folder.path(), &[&signals, more].concat())
}

#[test]
fn where_headers_tell_no_common_time_the_recorders_is_taken_and_that_is_said() {
    let own = |time: i64| time - 2_000_000;
    for (stamps, said) in [
        // Never filled, filled once and for all, in whole seconds.
        (
            [&|_| 0, &own] as [&dyn Fn(i64) -> i64; 2],
            "the headers of /cmd contain no stamp",
        ),
        ([&own, &|_| EPOCH], "the stamps of /imu do not advance"),
        (
            [&own, &|time| time / 1_000_000_000 * 1_000_000_000],
            "the stamps of /imu do not advance",
        ),
        // Since the start of the computer, and two seconds ahead.
        (
            [&own, &|time| time - EPOCH + 321_500_000_000],
            "from several clocks",
        ),
        ([&own, &|time| time + 2_000_000_000], "from several clocks"),
    ] {
        let folder = stamped(stamps);
        let by_itself = fitted_imu(&folder, &[]);
        by_itself.is_the_plant(SAMPLES as u64);
        by_itself
            .says(said)
            .says("the recorder's time is used for all");
        let asked = fitted_imu(&folder, &["--stamp", "log"]);
        asked.is_the_plant(SAMPLES as u64);
        let seconds = asked
            .said()
            .contains("of this count as a delay of the system");
        assert!(
            !seconds || asked.said().contains("2.0 ms of this count"),
            "{}",
            asked.said()
        );
        if said.contains("/cmd") {
            fitted_imu(&folder, &["--stamp", "header"]).refused(&[said, "--stamp log"]);
        }
    }
    // One clock, a year before the recorder's, as in a bag of a bag that was played: the headers count.
    let year = 365 * 86_400 * 1_000_000_000;
    let folder = stamped([&|time| time - year, &|time| time - year]);
    let answer = fitted_imu(&folder, &[]);
    answer.is_the_plant(SAMPLES as u64);
    assert_eq!(answer.json["reading"]["stamps"], "of the messages' headers");
    assert!(
        !answer.said().contains("delay of the system"),
        "{}",
        answer.said()
    );
}

#[test]
fn messages_that_are_there_twice_are_named_and_count_once() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let mut all = Vec::new();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        for again in [0, 700_000] {
            all.push((0, imu(time, u[k]), time + again));
            all.push((1, imu(time, y[k]), time + again));
        }
    }
    bag(folder.path(), &[("/cmd", IMU), ("/imu", IMU)], &all);
    let answer = fitted_imu(&folder, &[]);
    answer.is_the_plant(SAMPLES as u64);
    answer.says("/imu: 2000 of 4000 messages have the same stamp as the previous message");
}

/// A payload, written by hand: plain CDR, little endian.
#[derive(Default)]
struct Cdr(Vec<u8>);

impl Cdr {
    fn numbers<const N: usize>(mut self, numbers: impl IntoIterator<Item = [u8; N]>) -> Self {
        for number in numbers {
            self.0.resize(self.0.len().next_multiple_of(N), 0);
            self.0.extend(number);
        }
        self
    }

    fn floats(self, numbers: &[f64]) -> Self {
        self.numbers(numbers.iter().map(|it| it.to_le_bytes()))
    }

    fn singles(self, numbers: &[f64]) -> Self {
        self.numbers(numbers.iter().map(|it| (*it as f32).to_le_bytes()))
    }

    fn text(self, text: &str) -> Self {
        let mut cdr = self.numbers([(text.len() as u32 + 1).to_le_bytes()]);
        cdr.0.extend(text.as_bytes());
        cdr.0.push(0);
        cdr
    }

    fn header(time: i64) -> Self {
        let stamp = [time / 1_000_000_000, time % 1_000_000_000];
        let cdr = Self::default().numbers(stamp.map(|it| (it as u32).to_le_bytes()));
        cdr.text("base")
    }

    fn payload(self) -> Vec<u8> {
        [vec![0, 1, 0, 0], self.0].concat()
    }
}

/// A bag of Humble's sqlite3 storage, or of an older one without QoS: `/cmd`, a `TwistStamped`, and `/out` of a type, its payloads by time and output.
fn humble(folder: &Path, has_qos: bool, type_name: &str, payload: impl Fn(i64, f64) -> Vec<u8>) {
    let base = rusqlite::Connection::open(folder.join("log.db3")).unwrap();
    let qos = if has_qos {
        ", offered_qos_profiles TEXT NOT NULL DEFAULT ''"
    } else {
        ""
    };
    base.execute_batch(&format!(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL{qos});
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
         INSERT INTO topics(id, name, type, serialization_format) VALUES
             (1, '/cmd', 'geometry_msgs/msg/TwistStamped', 'cdr'), (2, '/out', '{type_name}', 'cdr');
         BEGIN;"
    ))
    .unwrap();
    let (u, y) = log(1, SAMPLES);
    let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
    let mut insert = base.prepare(insert).unwrap();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        let command = Cdr::header(time)
            .floats(&[u[k], 0.0, 0.0, 0.0, 0.0, 0.0])
            .payload();
        insert.execute((1, time, command)).unwrap();
        insert.execute((2, time, payload(time, y[k]))).unwrap();
    }
    drop(insert);
    base.execute_batch("COMMIT").unwrap();
}

#[test]
fn bags_without_definitions_are_read_where_ros_defines_the_types_itself() {
    type Written = fn(i64, f64) -> Vec<u8>;
    let kinds: [(&str, &str, Written); 8] = [
        (
            "geometry_msgs/msg/PoseStamped",
            "pose.position.x",
            |time, y| {
                Cdr::header(time)
                    .floats(&[y, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
                    .payload()
            },
        ),
        (
            "geometry_msgs/msg/WrenchStamped",
            "wrench.force.x",
            |time, y| {
                Cdr::header(time)
                    .floats(&[y, 0.0, 0.0, 0.0, 0.0, 0.0])
                    .payload()
            },
        ),
        ("std_msgs/msg/Float32", "data", |_, y| {
            Cdr::default().singles(&[y]).payload()
        }),
        ("std_msgs/msg/Float64MultiArray", "data[1]", |_, y| {
            let layout = Cdr::default().numbers([0_u32, 0, 2].map(u32::to_le_bytes));
            layout.floats(&[7.0, y]).payload()
        }),
        (
            "control_msgs/msg/JointControllerState",
            "process_value",
            |time, y| {
                let cdr =
                    Cdr::header(time).floats(&[0.0, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                cdr.numbers([[0_u8]]).payload()
            },
        ),
        ("sensor_msgs/msg/BatteryState", "voltage", |time, y| {
            let cdr = Cdr::header(time).singles(&[y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let cdr = cdr.numbers([[0_u8]; 4]).numbers([[0_u8; 4]; 2]);
            cdr.text("").text("").payload()
        }),
        // As Humble has it, and with Jazzy's variance.
        ("sensor_msgs/msg/Range", "range", |time, y| {
            Cdr::header(time)
                .numbers([[1_u8]])
                .singles(&[0.1, 0.0, 9.0, y])
                .payload()
        }),
        ("sensor_msgs/msg/Range", "range", |time, y| {
            Cdr::header(time)
                .numbers([[1_u8]])
                .singles(&[0.1, 0.0, 9.0, y, 0.2])
                .payload()
        }),
    ];
    for (at, (type_name, field, payload)) in kinds.into_iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        humble(folder.path(), at % 2 == 0, type_name, payload);
        let output = format!("out:{field}");
        let signals = ["log.db3", "-i", "cmd:twist.linear.x", "-o", &output];
        fit(folder.path(), &signals).is_the_plant(SAMPLES as u64);
    }
    // A version that nobody knows here, and a type of one's own, until its workspace is sourced.
    let folder = tempfile::tempdir().unwrap();
    let signals = ["log.db3", "-i", "cmd:twist.linear.x", "-o", "out:range"];
    humble(folder.path(), true, "sensor_msgs/msg/Range", |time, y| {
        Cdr::header(time)
            .numbers([[1_u8]])
            .singles(&[0.1, 0.0, 9.0, y, 0.2, 0.3])
            .payload()
    });
    fit(folder.path(), &signals).refused(&[
        "/out",
        "they have another version",
        "AMENT_PREFIX_PATH",
    ]);
    let folder = tempfile::tempdir().unwrap();
    humble(folder.path(), true, "my_msgs/msg/Distance", |_, y| {
        Cdr::default().floats(&[1.0, y]).payload()
    });
    fit(folder.path(), &signals).refused(&[
        "my_msgs/msg/Distance",
        "not a standard type",
        "AMENT_PREFIX_PATH",
    ]);
    let share = folder.path().join("ws/share/my_msgs/msg");
    std::fs::create_dir_all(&share).unwrap();
    std::fs::write(share.join("Distance.msg"), "float64 least\nfloat64 range\n").unwrap();
    let prefix = folder.path().join("ws");
    fit_with(folder.path(), &signals, ("AMENT_PREFIX_PATH", &prefix)).is_the_plant(SAMPLES as u64);
}

#[test]
fn mcap_files_whose_schemas_are_empty_are_read_by_the_names_of_their_types() {
    for (type_name, encoding, definition) in [
        ("std_msgs/msg/Float64", "ros2msg", ""),
        ("std_msgs/msg/Float64", "", ""),
        ("std_msgs/msg/Float64", "unknown", "?"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (u, y) = log(1, SAMPLES);
        let kind = (type_name, encoding, definition);
        let samples = (0..SAMPLES).flat_map(|k| [(0, u[k], k), (1, y[k], k)]);
        let all = samples.map(|(topic, it, k)| (topic, float(it), EPOCH + k as i64 * STEP_NS));
        let all: Vec<_> = all.collect();
        bag(folder.path(), &[("/u", kind), ("/y", kind)], &all);
        let signals = ["log.mcap", "-i", "u:data", "-o", "y:data"];
        fit(folder.path(), &signals).is_the_plant(SAMPLES as u64);
        for (type_name, said) in [
            (
                "",
                "the file has neither type nor definition for this topic",
            ),
            ("vendor_msgs/msg/Thing", "vendor_msgs/msg/Thing"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let kind = (type_name, encoding, definition);
            bag(folder.path(), &[("/u", kind), ("/y", kind)], &all);
            let answer = fit(folder.path(), &signals);
            answer.refused(&["/u: ", said]);
            assert!(!answer.text.contains("sqlite3"), "{}", answer.text);
            assert!(!answer.text.contains("of ,"), "{}", answer.text);
        }
    }
}

fn topics(folder: &Path, of: &str) -> Answer {
    crate::answer::planesman(folder, &["sysid", "topics", of])
}

#[test]
fn a_survey_says_of_each_topic_what_is_amiss_below_its_name_and_what_may_be_identified() {
    const EVENT: &str = "example_interfaces/srv/AddTwoInts_Event";
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let kinds = [
        ("/cmd_vel", FLOAT),
        ("/imu", IMU),
        ("/a/odd", ("odd_msgs/msg/Odd", "", "")),
        ("/b/odd", ("odd_msgs/msg/Odd", "", "")),
        (
            "/parameter_events",
            kind::<planesman_msgs::rcl_interfaces::msg::ParameterEvent>(),
        ),
        ("/x/_service_event", (EVENT, "ros2msg", "float64 sum\n")),
        ("/y/_service_event", (EVENT, "ros2msg", "float64 sum\n")),
        ("/tf", kind::<TFMessage>()),
    ];
    let mut all = Vec::new();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        all.push((0, float(u[k]), time));
        all.push((1, imu(0, y[k]), time));
        all.push((7, frames(vec![transform("odom", "base_link", y[k])]), time));
        // Nine of ten come at once.
        all.push((
            2,
            float(0.0),
            EPOCH + (k / 10) as i64 * 10 * STEP_NS + k as i64 % 10,
        ));
        all.extend((3..7).map(|topic| (topic, float(0.0), time)));
    }
    bag(folder.path(), &kinds, &all);
    let answer = topics(folder.path(), "log.mcap");
    assert_eq!(answer.status, Some(0), "{}", answer.text);
    let lines: Vec<&str> = answer.text.lines().collect();
    let below = |topic: &str| {
        let at = lines
            .iter()
            .position(|line| line.starts_with(&format!("{topic}  ")));
        at.map(|at| (lines[at], lines[at + 1]))
            .unwrap_or_else(|| panic!("{topic}"))
    };
    for topic in ["/a/odd", "/b/odd"] {
        let (_, note) = below(topic);
        assert!(
            note.starts_with("  note: the bag does not contain the definition of odd_msgs/msg/Odd"),
            "{note}"
        );
    }
    assert!(below("/a/odd").0.contains("at 20.0") && below("/a/odd").0.contains("in bursts (90 %"));
    assert!(below("/imu").0.contains("(stamps: log)"));
    assert!(
        below("/imu")
            .1
            .contains("the headers of /imu contain no stamp")
    );
    assert!(
        below("/parameter_events")
            .1
            .contains("the fields of this topic are not listed")
    );
    assert!(
        answer
            .text
            .contains("  transforms[base_link].transform.translation.x ")
    );
    assert!(
        answer
            .text
            .contains("note: 2 topics of service events not listed\n")
    );
    assert!(lines.len() < 60, "{}", answer.text);
    // The command that is proposed identifies the plant.
    let proposed = lines
        .iter()
        .find_map(|line| line.strip_prefix("try: planesman sysid fit "));
    let proposed = proposed.unwrap_or_else(|| panic!("{}", answer.text));
    let words: Vec<&str> = proposed.split(' ').collect();
    assert_eq!(
        words,
        [
            "log.mcap",
            "-i",
            "/cmd_vel:data",
            "-o",
            "/imu:angular_velocity.y"
        ]
    );
    fit(folder.path(), &words).is_the_plant(SAMPLES as u64);
}

#[test]
fn a_file_that_was_renamed_beside_its_metadata_is_found() {
    let folder = tempfile::tempdir().unwrap();
    humble(folder.path(), true, "std_msgs/msg/Float32", |_, y| {
        Cdr::default().singles(&[y]).payload()
    });
    let account = |files: &str, messages: usize| {
        format!(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths: [{files}]\n  duration: \
             {{nanoseconds: 1}}\n  starting_time: {{nanoseconds_since_epoch: 1}}\n  message_count: {messages}\n  topics_with_message_count: []\n  \
             compression_format: \"\"\n  compression_mode: \"\"\n"
        )
    };
    let signals = [".", "-i", "cmd:twist.linear.x", "-o", "out:data"];
    for (files, said) in [
        (
            "run_0.db3",
            "the bag's metadata.yaml lists run_0.db3, which does not exist; reading log.db3 instead",
        ),
        (
            "log.db3, log_1.db3",
            "the bag's metadata.yaml lists log_1.db3, which does not exist",
        ),
    ] {
        std::fs::write(
            folder.path().join("metadata.yaml"),
            account(files, 2 * SAMPLES),
        )
        .unwrap();
        let answer = fit(folder.path(), &signals);
        answer.is_the_plant(SAMPLES as u64).says(said);
        assert!(topics(folder.path(), ".").text.contains(said));
    }
    std::fs::remove_file(folder.path().join("log.db3")).unwrap();
    fit(folder.path(), &signals).refused(&["log.db3: no such file"]);
}

#[test]
fn json_is_read_by_the_same_paths_and_other_encodings_are_refused_with_what_converts_them() {
    let (u, y) = log(1, SAMPLES);
    for encoding in ["json", "protobuf", "flatbuffer", "ros1"] {
        let folder = tempfile::tempdir().unwrap();
        let mut maker = Maker::new(&folder.path().join("log.mcap"));
        let kind = ("foxglove.Thing", "jsonschema", "{}");
        let [cmd, out] = ["/cmd", "/out"].map(|name| maker.topic_of(name, kind, encoding));
        for k in 0..SAMPLES {
            let time = EPOCH + k as i64 * STEP_NS;
            let header = format!(
                r#""header": {{"stamp": {{"sec": {}, "nanosec": {}}}, "frame_id": "a"}}"#,
                time / 1_000_000_000,
                time % 1_000_000_000
            );
            let command = format!(r#"{{{header}, "force": {{"x": {}}}}}"#, u[k]);
            maker.write(cmd, command.as_bytes(), time + 3_000_000);
            let both = [
                format!(r#"{{"name": "pan", "at": {}}}"#, y[k]),
                r#"{"name": "tilt", "at": 2}"#.to_owned(),
            ];
            let both = if k % 2 == 0 {
                both.join(",")
            } else {
                both[1].clone() + "," + &both[0]
            };
            let answer = format!(r#"{{{header}, "joints": [{both}]}}"#);
            maker.write(out, answer.as_bytes(), time + 7_000_000);
        }
        maker.close();
        let signals = ["log.mcap", "-i", "cmd:force.x", "-o", "out:joints[pan].at"];
        let answer = fit(folder.path(), &signals);
        if encoding == "json" {
            answer.is_the_plant(SAMPLES as u64);
            let by_index = ["log.mcap", "-i", "cmd:force.x", "-o", "out:joints[0].at"];
            fit(folder.path(), &by_index).refused(&[
                "joints[0] is now of pan, now of tilt",
                "'out:joints[pan].at'",
            ]);
            let listed = topics(folder.path(), "log.mcap").text;
            assert!(
                listed.contains("joints[pan].at") && listed.contains("(stamps: header)"),
                "{listed}"
            );
        } else {
            let command = match encoding {
                "ros1" => "rosbags-convert --src log.mcap",
                "protobuf" => "iter_decoded_messages(['/cmd'])",
                _ => "CSV file from PlotJuggler",
            };
            answer.refused(&["/cmd", encoding, "only cdr and json can be read", command]);
        }
    }
}

#[test]
fn a_topic_of_two_types_is_read_by_the_type_that_has_the_signal() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let base = rusqlite::Connection::open(folder.path().join("log.db3")).unwrap();
    base.execute_batch(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL);
         CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
         INSERT INTO topics VALUES (1, '/cmd', 'std_msgs/msg/String', 'cdr'), (2, '/cmd', 'std_msgs/msg/Float64', 'cdr'),
             (3, '/y', 'std_msgs/msg/Float64', 'cdr');
         BEGIN;",
    )
    .unwrap();
    let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
    let mut insert = base.prepare(insert).unwrap();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        let hello = Cdr::default().text("hello").payload();
        for (topic, payload) in [(1, hello), (2, float(u[k])), (3, float(y[k]))] {
            insert.execute((topic, time, payload)).unwrap();
        }
    }
    drop(insert);
    base.execute_batch("COMMIT").unwrap();
    let signals = ["log.db3", "-i", "cmd:data", "-o", "y:data"];
    fit(folder.path(), &signals).is_the_plant(SAMPLES as u64);
}

#[test]
fn a_status_is_chosen_by_its_name_whatever_its_signs_and_a_value_is_the_number_in_its_text() {
    let folder = driven::<DiagnosticArray>(|k, time, y| {
        let value = |key: &str, value: String| KeyValue {
            key: key.to_owned(),
            value,
        };
        let status = |name: &str, values| DiagnosticStatus {
            name: name.to_owned(),
            values,
            ..DiagnosticStatus::default()
        };
        let mut list = vec![
            status(
                "motor driver: left",
                vec![
                    value("speed (V)", format!("{y:.6} V")),
                    value("state", "OK".to_owned()),
                ],
            ),
            status(
                "motor driver: right",
                vec![value("speed (V)", "7".to_owned())],
            ),
            status("7", vec![value("a[0]", format!("{y:.6}"))]),
        ];
        list.rotate_left(k % 3);
        let array = DiagnosticArray {
            status: list,
            ..DiagnosticArray::default()
        };
        vec![(cdr::to_bytes(&array), time)]
    });
    for output in [
        "out:status[motor driver: left].values[speed (V)].value",
        "out:status[\"motor driver: left\"].values[0].value",
        "out:status[\"7\"].values[\"a[0]\"].value",
    ] {
        fitted(&folder, output, &["--stamp", "log"]).is_the_plant(SAMPLES as u64);
    }
    let log = |output| fitted(&folder, output, &["--stamp", "log"]);
    log("out:status[motor driver: lef].values[0].value")
        .refused(&["there is no 'motor driver: lef'; there are 7, motor driver: left"]);
    log("out:status[7].values[a[0]].value").refused(&["double quotes", "[\"7\"]"]);
    log("out:status[motor driver: left].message").refused(&["a string, not a number"]);
}

const TWIST: &str = "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n================================================================================\n\
    MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";

/// The payload of a `geometry_msgs/msg/Twist`.
fn twist(x: f64) -> Vec<u8> {
    Cdr::default()
        .floats(&[x, 0.0, 0.0, 0.0, 0.0, 0.0])
        .payload()
}

/// A bag in which two publishers command on `/cmd`, the second every so many ns; messages as topic or channel, payload, time of
/// reception, and number.
fn two_commanders(second: i64, value: fn(usize) -> f64) -> Vec<(usize, Vec<u8>, i64)> {
    let (u, y) = log(1, SAMPLES);
    let mut all = Vec::new();
    for k in 0..SAMPLES {
        let time = EPOCH + k as i64 * STEP_NS;
        all.push((0, twist(u[k]), time));
        all.push((1, float(y[k]), time));
    }
    let last = SAMPLES as i64 * STEP_NS;
    let times = (0..)
        .map(|k| k * second + 17_000_000)
        .take_while(|it| *it < last);
    all.extend(
        times
            .enumerate()
            .map(|(k, time)| (2, twist(value(k)), EPOCH + time)),
    );
    all.sort_by_key(|it| it.2);
    all
}

#[test]
fn two_publishers_of_messages_that_say_nothing_of_whose_they_are_are_noticed() {
    for (second, value) in [
        (STEP_NS, (|_| 0.3) as fn(usize) -> f64),
        (STEP_NS, |k| 4.0 + libm::sin(k as f64 * 0.05)),
        (2 * STEP_NS, |_| 0.0),
        (7 * STEP_NS, |_| 0.0),
        (66_000_000, |_| 0.3),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let messages = two_commanders(second, value);
        // One channel without numbers: sqlite3 keeps none.
        let base = rusqlite::Connection::open(folder.path().join("log.db3")).unwrap();
        base.execute_batch(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
             INSERT INTO topics VALUES (0, '/cmd', 'geometry_msgs/msg/Twist', 'cdr'), (1, '/out', 'std_msgs/msg/Float64', 'cdr');
             BEGIN;",
        )
        .unwrap();
        let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        let mut insert = base.prepare(insert).unwrap();
        for (topic, payload, time) in &messages {
            insert.execute((*topic as i64 % 2, time, payload)).unwrap();
        }
        drop(insert);
        base.execute_batch("COMMIT").unwrap();
        let signals = ["log.db3", "-i", "cmd:linear.x", "-o", "out:data"];
        let signals = [&signals[..], &["--method", "output_error", "--order", "2"]].concat();
        let answer = fit(folder.path(), &signals);
        answer
            .says("cmd:linear.x: ")
            .says("two sources seem to share this signal")
            .says("under a separate name");
        assert!(
            !answer.said().contains("verdict: good"),
            "{}",
            answer.said()
        );
        let told = topics(folder.path(), "log.db3").text;
        assert!(
            told.contains("note: linear.x") && told.contains("two sources seem"),
            "{told}"
        );
    }
}

#[test]
fn two_publishers_are_told_apart_by_their_channels_or_by_the_numbers_that_each_counts() {
    let messages = two_commanders(STEP_NS, |_| 0.3);
    for of_channels in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let mut file = mcap::beginning();
        file.extend(mcap::schema(1, "geometry_msgs/msg/Twist", "ros2msg", TWIST));
        file.extend(mcap::schema(2, FLOAT.0, FLOAT.1, FLOAT.2));
        for (id, schema, topic) in [(0, 1, "/cmd"), (1, 2, "/out"), (2, 1, "/cmd")] {
            file.extend(mcap::channel(id, schema, topic, "cdr"));
        }
        // Each counts for itself, and begins when it is started; one in a hundred is lost.
        let mut numbers = [500, 0, 7];
        for (k, (topic, payload, time)) in messages.iter().enumerate() {
            let number = &mut numbers[*topic];
            *number += 1;
            let (channel, number) = match of_channels {
                true => (*topic as u16, 0),
                false => (*topic as u16 % 2, *number),
            };
            if of_channels || k % 100 != 99 {
                let time = *time as u64;
                file.extend(mcap::numbered_message(channel, number, time, payload));
            }
        }
        file.extend(mcap::end());
        std::fs::write(folder.path().join("log.mcap"), file).unwrap();
        let run = |input| fit(folder.path(), &["log.mcap", "-i", input, "-o", "out:data"]);
        run("cmd:linear.x").refused(&[
            "from different publishers in turn",
            "'cmd:[publisher=1].linear.x' (",
            " messages) or 'cmd:[publisher=2].linear.x' (",
        ]);
        let one = run("cmd:[publisher=1].linear.x");
        let (samples, gain) = ("record/samples", "model/steady_state_gain/0");
        near(one.number(samples), SAMPLES as f64, 20.0);
        near(one.number(gain), 0.75, 0.01);
        run("cmd:[publisher=2].linear.x").refused(&["is constant (0.3 in all"]);
        run("cmd:[publisher=3].linear.x").refused(&["publisher 3", "'cmd:[publisher=1].linear.x'"]);
        let told = topics(folder.path(), "log.mcap").text;
        assert!(
            told.contains("the topic has messages of 2 publishers, by their channels or numbers"),
            "{told}"
        );
    }
}
