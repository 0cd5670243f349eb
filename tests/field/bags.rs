//! Bags: which frame, joint or publisher a number is of, whose clock stamped it, and types whose definition is not there.

use std::path::{Path, PathBuf};

use planesman_msgs::geometry_msgs::msg::TransformStamped;
use planesman_msgs::nav_msgs::msg::Odometry;
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Message, cdr};

use crate::answer::{Answer, fit};
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
    let framed = two(
        |y| joints("arm", &[], vec![y, 1.0]),
        |y| joints("head", &[], vec![2.0, -y]),
    );
    fitted(&framed, "out:position[0]", &log).refused(&[
        "the messages are now of arm, now of head",
        "'out:[arm].position[0]' or",
    ]);
    fitted(&framed, "out:[arm].position[0]", &log).is_the_plant(SAMPLES as u64);
    let bare = two(
        |y| joints("", &[], vec![y, 1.0]),
        |y| joints("", &[], vec![2.0, -y, 0.0]),
    );
    fitted(&bare, "out:position[0]", &log).refused(&[
        "the list has now 2 numbers, now 3 numbers",
        "a topic of its own",
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
            "the headers of /cmd are not filled",
        ),
        ([&own, &|_| EPOCH], "the stamps of /imu stand still"),
        (
            [&own, &|time| time / 1_000_000_000 * 1_000_000_000],
            "the stamps of /imu stand still",
        ),
        // Since the start of the computer, and two seconds ahead.
        (
            [&own, &|time| time - EPOCH + 321_500_000_000],
            "of several clocks",
        ),
        ([&own, &|time| time + 2_000_000_000], "of several clocks"),
    ] {
        let folder = stamped(stamps);
        let by_itself = fitted_imu(&folder, &[]);
        by_itself.is_the_plant(SAMPLES as u64);
        by_itself
            .says(said)
            .says("the recorder's time is taken for all");
        let asked = fitted_imu(&folder, &["--stamp", "log"]);
        asked.is_the_plant(SAMPLES as u64);
        let seconds = asked.said().contains("count as delay of the system");
        assert!(
            !seconds || asked.said().contains("2.0 ms count"),
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
    answer.says("/imu: 2000 of 4000 messages bear the stamp of the one before");
}
