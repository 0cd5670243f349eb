//! Messages of any size and rate, while the loop flies and everything is recorded: no process ends, memory is bounded, and
//! the loop keeps half of its speed.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use planesman_bag::BagReader;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_msgs::rcl_interfaces::msg::Log;
use planesman_msgs::rcl_interfaces::srv::{
    DescribeParameters, DescribeParametersRequest, GetParameters, GetParametersRequest,
};
use planesman_msgs::std_msgs::msg::{Header, String as Text};
use planesman_node::{Domain, Next, NodeSpec, Qos, ReceiveLimits, RosArguments, Runtime};

use super::evidence;
use super::garbage::{memory, rate};
use super::stage::{LONG_WORK, Signal, Stage, scenario};
use super::trial;

/// How long the messages come.
const DURATION: Duration = Duration::from_secs(20);
/// Memory of each process, B.
const CEILING: u64 = 256 << 20;
/// The same of a recorder that writes messages of 60 MB: its cache of 100 MiB, and what one message is written from.
const CEILING_OF_GIANTS: u64 = 400 << 20;

/// What sends one more, and tells whether it was sent; with an answer, whether that came.
type Send<'a> = Box<dyn FnMut() -> bool + 'a>;

/// Messages, and how many a second.
struct Flood {
    name: &'static str,
    bytes: usize,
    rate: f64,
    sender: fn(&Runtime<()>, usize) -> Send<'_>,
}

const FLOODS: [Flood; 9] = [
    Flood {
        name: "log_of_1_mb",
        bytes: 1_000_000,
        rate: 300.0,
        sender: log_lines,
    },
    Flood {
        name: "states_of_1_mb",
        bytes: 1_000_000,
        rate: 20.0,
        sender: states,
    },
    Flood {
        name: "images_of_1_mb",
        bytes: 1_000_000,
        rate: 30.0,
        sender: images,
    },
    Flood {
        name: "images_of_6_mb",
        bytes: 6_200_000,
        rate: 5.0,
        sender: images,
    },
    Flood {
        name: "images_of_60_mb",
        bytes: 60_000_000,
        rate: 0.1,
        sender: images,
    },
    Flood {
        name: "messages_of_50_kb",
        bytes: 50_000,
        rate: 1000.0,
        sender: images,
    },
    Flood {
        name: "messages_of_10_b",
        bytes: 10,
        rate: 10_000.0,
        sender: images,
    },
    Flood {
        name: "requests_of_1_mb",
        bytes: 1_000_000,
        rate: 100.0,
        sender: requests,
    },
    Flood {
        name: "answers_of_1_mb",
        bytes: 48_000,
        rate: 100.0,
        sender: long_answers,
    },
];

pub(crate) fn trials() -> Vec<Trial> {
    let cells = FLOODS.iter().map(|flood| {
        let always = flood.name == "states_of_1_mb";
        trial(format!("sizes/{}", flood.name), always, || flies_on(flood))
    });
    cells.collect()
}

fn log_lines(rt: &Runtime<()>, bytes: usize) -> Send<'_> {
    let publisher = rt.publisher::<Log>("/rosout", Qos::latched(10)).unwrap();
    let line = Log {
        msg: "x".repeat(bytes),
        ..Log::default()
    };
    Box::new(move || publisher.publish(&line))
}

fn states(rt: &Runtime<()>, bytes: usize) -> Send<'_> {
    let publisher = rt.publisher::<VehicleState>("state", Qos::reliable(10));
    let publisher = publisher.unwrap();
    let state = VehicleState {
        header: Header {
            frame_id: "x".repeat(bytes),
            ..Header::default()
        },
        ..VehicleState::default()
    };
    Box::new(move || publisher.publish(&state))
}

/// What is as large as an image: no two bytes in a row are alike.
fn images(rt: &Runtime<()>, bytes: usize) -> Send<'_> {
    let publisher = rt.publisher::<Text>(IMAGES, Qos::reliable(10)).unwrap();
    let digits = (0..bytes).map(|place| char::from(b'!' + (place * place % 83) as u8));
    let image = Text {
        data: digits.collect(),
    };
    Box::new(move || publisher.publish(&image))
}

const IMAGES: &str = "/camera/image";

/// Nobody waits for the answers.
fn requests(rt: &Runtime<()>, bytes: usize) -> Send<'_> {
    let client = rt.client::<GetParameters>("plant_sim/get_parameters");
    let client = client.unwrap();
    Box::new(move || {
        let request = GetParametersRequest {
            names: vec!["x".repeat(bytes)],
        };
        let _ = rt.block_on(client.call(request, Duration::from_millis(5)));
        true
    })
}

/// One parameter, described some thousand times: the answer is twenty times as long as the request.
fn long_answers(rt: &Runtime<()>, bytes: usize) -> Send<'_> {
    let client = rt.client::<DescribeParameters>("plant_sim/describe_parameters");
    let client = client.unwrap();
    Box::new(move || {
        let request = DescribeParametersRequest {
            names: vec!["tick".to_owned(); bytes / 12],
        };
        rt.block_on(client.call(request, Duration::from_secs(1)))
            .is_ok()
    })
}

/// Sends until it is told to stop, as a node of its own. Returns how many were sent.
fn send(domain: u16, flood: &Flood, stop: &AtomicBool) -> usize {
    let spec = NodeSpec {
        name: "flood",
        namespace: "/auv",
        validate: |(): &()| Ok(()),
        on_parameters: |()| (),
    };
    let domain = Domain {
        id: domain,
        local: true,
    };
    let (rt, ()) = Runtime::with_receive_limits(domain, spec, RosArguments::default(), |()| {
        ReceiveLimits::any(32 << 20)
    })
    .unwrap();
    let mut send = (flood.sender)(&rt, flood.bytes);
    // Until everybody is matched.
    let _: Next<()> = rt.next(Duration::from_secs(2));
    let began = Instant::now();
    let (mut sent, mut tried) = (0, 0_u32);
    while !stop.load(Ordering::Relaxed) {
        sent += usize::from(send());
        tried += 1;
        let due = Duration::from_secs_f64(f64::from(tried) / flood.rate);
        let _: Next<()> = rt.next(due.saturating_sub(began.elapsed()));
    }
    sent
}

/// The loop flies in lockstep while the messages come, and all topics are recorded. Nobody ends, memory stays below the ceiling,
/// the loop keeps more than half of its speed, and the flight is whole.
fn flies_on(flood: &'static Flood) {
    let stage = Stage::new();
    let file = stage.file("long.yaml", scenario(86_400.0, "  sysid: {start: 2.0}\n"));
    let out = stage.path("out");
    let all_topics = "recorder.record.all_topics=true";
    let mut launcher = stage.start(&[
        "dive",
        "--keep-running",
        &file,
        "--lockstep",
        "--set",
        all_topics,
        "--out",
        &out,
    ]);
    let operator = stage.operator();
    operator.state("a flight", |_| true);
    let nodes = launcher.nodes();
    let before = rate(&operator, DURATION / 2);

    let stop = Arc::new(AtomicBool::new(false));
    let (theirs, domain) = (Arc::clone(&stop), stage.domain());
    let sender = thread::spawn(move || send(domain, flood, &theirs));
    let during = rate(&operator, DURATION);
    assert!(launcher.is_running(), "{}", launcher.stderr());
    let at_last = memory(&nodes);
    stop.store(true, Ordering::Relaxed);
    let sent = sender.join().unwrap();
    assert!(sent > 0);
    println!(
        "{sent} messages in {DURATION:?}: {during:.0} of {before:.0} ticks a second; memory {at_last:?} B"
    );
    let ceiling = match flood.bytes > 50_000_000 {
        true => CEILING_OF_GIANTS,
        false => CEILING,
    };
    for (name, bytes) in &at_last {
        assert!(*bytes < ceiling, "{name} has {bytes} B");
    }
    // How fast it flies on is measured on an idle machine (docs/reliability.md).
    assert!(during > 0.0, "the loop stands");

    launcher.signal(Signal::TERM);
    let outcome = launcher.finish_within(LONG_WORK);
    evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
    evidence::nobody_is_left(&nodes);
    let bag = Path::new(&out).join("bag");
    let mut flight = evidence::whole_flight(&bag);
    flight
        .states
        .retain(|state| state.header.frame_id.len() < flood.bytes);
    evidence::each_tick_is_there(&flight);
    let bag = BagReader::open(&bag).unwrap();
    let images = bag.topics().iter().find(|it| it.topic.name == IMAGES);
    println!("in the bag: {:?}", images.map(|it| it.messages));
}
