//! Reports survive what the loop survives: whatever a bag holds beside the flight is left out and named, and the
//! figures are those of the flight.

use crate::recorded;
use std::fs;
use std::path::PathBuf;

use planesman::run_folder::RunFolder;
use planesman_bag::{BagReader, BagWriter, Message, OfferedQos, Order, Topic, WriterOptions};
use planesman_flight::flight::Flight;
use planesman_flight::scenario::Scenario;
use planesman_flight::summary::Summary;
use planesman_flight::{Parts, fly};
use planesman_linear::StepMetrics;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::cdr;
use planesman_msgs::planesman_msgs::msg::{ControlState, VehicleState};
use planesman_msgs::std_msgs::msg::String as Text;

const SCENARIO: &str = "
description: a short dive
duration: 30.0
parameters:
  depth_controller: {depth_setpoint: 0.3}
";

const STATE: &str = "/auv/state";

/// A flight's folder whose bag holds a short dive, written anew.
struct Rewritten {
    folder: tempfile::TempDir,
}

impl Rewritten {
    /// The dive's messages as `tell` writes them, each with how often it has been called before.
    fn by(mut tell: impl FnMut(&mut BagWriter, usize, &Message)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scenario.yaml"), SCENARIO).unwrap();
        let plain = folder.path().join("plain.mcap");
        fly(&scenario(), &Parts::default(), &plain, "/auv", &()).unwrap();
        let rewritten = Self { folder };
        let mut writer = BagWriter::create(&rewritten.bag(), WriterOptions::default()).unwrap();
        let bag = BagReader::open(&plain).unwrap();
        for (k, message) in bag.messages(Order::File).enumerate() {
            tell(&mut writer, k, &message.unwrap());
        }
        writer.close().unwrap();
        rewritten
    }

    fn bag(&self) -> PathBuf {
        self.folder.path().join("bag")
    }

    fn summary(&self) -> Summary {
        Summary::new(&Flight::read(&self.bag()).unwrap(), &scenario()).unwrap()
    }

    /// The output of `planesman report`, and the page.
    fn report(&self) -> (String, String) {
        let run = RunFolder::open(self.folder.path()).unwrap();
        let report = run.report(run.scenario().unwrap(), "dive", false).unwrap();
        (report.to_string(), fs::read_to_string(run.page()).unwrap())
    }
}

fn scenario() -> Scenario {
    Scenario::parse(SCENARIO).unwrap()
}

fn put(writer: &mut BagWriter, topic: &Topic, payload: &[u8], time: i64) {
    let topic = writer.add_topic(topic).unwrap();
    writer.write_raw(topic, payload, time, time).unwrap();
}

fn again(writer: &mut BagWriter, message: &Message) {
    put(writer, &message.topic, &message.payload, message.log_time);
}

/// The flight without a change.
fn plain() -> Rewritten {
    Rewritten::by(|writer, _, message| again(writer, message))
}

/// A message of the state's topic with another stamp and depth.
fn stranger(message: &Message, seconds: i32, depth: f64) -> Vec<u8> {
    let mut state: VehicleState = message.decode().unwrap();
    state.header.stamp = Time {
        sec: seconds,
        nanosec: 1,
    };
    state.depth = depth;
    cdr::to_bytes(&state)
}

/// The reports of both flights are the same, but for the notes.
fn assert_same_flight(rewritten: &Summary, plain: &Summary) {
    assert_eq!(rewritten.depth, plain.depth);
    assert_eq!(rewritten.depth_setpoint, plain.depth_setpoint);
    assert_eq!(rewritten.identified, plain.identified);
    assert_eq!(
        (rewritten.pulses, rewritten.held_ticks),
        (plain.pulses, plain.held_ticks)
    );
}

#[test]
fn the_figures_are_those_of_all_states_since_the_depth_was_asked_for() {
    let rewritten = plain();
    let states: Vec<VehicleState> = recorded::messages(&rewritten.bag(), STATE).unwrap();
    let controls: Vec<ControlState> =
        recorded::messages(&rewritten.bag(), "/auv/control_state").unwrap();
    assert!(controls.iter().all(|c| c.depth_target == 0.3));
    let times: Vec<f64> = states
        .iter()
        .map(|s| s.header.stamp.nanos() as f64 * 1e-9)
        .collect();
    let depths: Vec<f64> = states.iter().map(|s| s.depth).collect();
    let expected = StepMetrics::of(&times, &depths, depths[0], 0.3).unwrap();
    let summary = rewritten.summary();
    assert_eq!(summary.depth, Some(expected));
    assert_eq!(summary.notes, [""; 0]);
}

#[test]
fn ticks_said_again_while_the_loop_waited_count_once() {
    let rewritten = Rewritten::by(|writer, k, message| {
        again(writer, message);
        if k % 97 < 20 {
            again(writer, message);
        }
    });
    let summary = rewritten.summary();
    assert_same_flight(&summary, &plain().summary());
    let note = summary.notes.iter().find(|note| note.starts_with(STATE));
    assert!(
        note.is_some_and(|it| it.contains("counted once")),
        "{summary:?}"
    );
    let (text, page) = rewritten.report();
    assert!(text.contains("counted once") && page.contains("counted once"));
}

#[test]
fn foreign_messages_are_counted_named_and_left_out() {
    let text = Topic::of::<Text>("/auv/plane_command", OfferedQos::reliable(1));
    let rewritten = Rewritten::by(|writer, k, message| {
        if message.topic.name == STATE && k > 1000 && k % 100 < 20 {
            // Cut off, no number, from another time, and from another vehicle.
            let cut = &message.payload[..40];
            put(writer, &message.topic, cut, message.log_time);
            put(writer, &message.topic, &stranger(message, 1, f64::NAN), 0);
            put(writer, &message.topic, &stranger(message, 9_999, 1e300), 0);
            let other = Topic {
                name: "/other/state".to_owned(),
                ..(*message.topic).clone()
            };
            put(writer, &other, &stranger(message, 7, -5.0), 0);
        }
        if message.topic.name == text.name {
            put(writer, &text_of_another(&text), b"\0\x01\0\0", 0);
        }
        again(writer, message);
    });
    let summary = rewritten.summary();
    assert_same_flight(&summary, &plain().summary());
    let notes = summary.notes.join("\n");
    for part in [
        STATE,
        "not a planesman_msgs/msg/VehicleState",
        "out of order",
    ] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    rewritten.report();
}

/// The topic under a name that the flight does not use.
fn text_of_another(topic: &Topic) -> Topic {
    Topic {
        name: "/auv/plane_command_text".to_owned(),
        ..topic.clone()
    }
}

#[test]
fn a_topic_of_another_type_is_named_and_the_rest_is_reported() {
    let rewritten = Rewritten::by(|writer, _, message| {
        if message.topic.name == "/auv/plane_command" {
            let other = Topic::of::<Text>("/auv/plane_command", OfferedQos::reliable(1));
            put(writer, &other, &message.payload, message.log_time);
        } else {
            again(writer, message);
        }
    });
    let summary = rewritten.summary();
    assert_same_flight(&summary, &plain().summary());
    let expected = "/auv/plane_command: 600 messages skipped. The reason for the first is: its type is std_msgs/msg/String";
    assert!(summary.notes[0].starts_with(expected), "{summary:?}");
    rewritten.report();
}

#[test]
fn of_a_vehicle_that_began_again_the_last_flight_is_reported() {
    let mut first = Vec::new();
    let rewritten = Rewritten::by(|writer, k, message| {
        if k < 2000 {
            first.push(message.clone());
        }
        again(writer, message);
    });
    // The same bag with a cut flight before it.
    let twice = Rewritten::by(|writer, k, message| {
        if k == 0 {
            first.iter().for_each(|message| again(writer, message));
        }
        again(writer, message);
    });
    let summary = twice.summary();
    assert_same_flight(&summary, &rewritten.summary());
    assert!(
        summary.notes.join("\n").contains("time went back"),
        "{summary:?}"
    );
}

#[test]
fn depths_beyond_all_numbers_leave_a_page_that_says_so() {
    let rewritten = Rewritten::by(|writer, _, message| {
        if message.topic.name == STATE {
            let mut state: VehicleState = message.decode().unwrap();
            state.depth *= 1e308;
            put(
                writer,
                &message.topic,
                &cdr::to_bytes(&state),
                message.log_time,
            );
        } else {
            again(writer, message);
        }
    });
    let (text, page) = rewritten.report();
    assert!(
        text.contains("finite") || text.contains("no depth response"),
        "{text}"
    );
    assert!(page.contains("</html>"));
}

#[test]
fn names_in_a_bag_do_nothing_to_the_page_or_the_terminal() {
    let rewritten = Rewritten::by(|writer, _, message| {
        again(writer, message);
        if message.topic.name != STATE {
            return;
        }
        let evil = Topic {
            name: "/\u{1b}[31m<b>\u{202e}".to_owned(),
            ..(*message.topic).clone()
        };
        put(writer, &evil, &message.payload, message.log_time);
    });
    let page = rewritten.report().1;
    assert!(!page.contains('\u{1b}') && !page.contains('\u{202e}') && !page.contains("<b>"));
    assert!(page.contains("[31m&lt;b&gt;\\u202e"));
}

#[test]
fn a_bag_that_is_damaged_in_the_middle_is_reported_up_to_there() {
    let rewritten = plain();
    let file: PathBuf = fs::read_dir(rewritten.bag())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path: &PathBuf| path.extension().is_some_and(|it| it == "mcap"))
        .unwrap();
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 64].fill(0xa5);
    fs::write(&file, bytes).unwrap();
    let (text, page) = rewritten.report();
    assert!(text.contains("The bag is incomplete"), "{text}");
    assert!(page.contains("The bag is incomplete"));
}
