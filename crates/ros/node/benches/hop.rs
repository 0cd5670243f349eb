//! A message of 100 bytes from node to node: its latency, and what it costs.
//!
//! ```text
//! hop pong &  hop ping SECONDS      half of each round trip; prints a line of JSON
//! hop sub &   hop pub RATE          so many messages a second until stopped; sub prints each second how many it has
//! ```
//!
//! `benches/peers/run --only hop` builds it and runs it beside Cyclone DDS and rclpy. The nodes are those of the suite: the same runtime,
//! the same QoS, with parameters, log and diagnostics.

use std::{
    process::ExitCode,
    time::{Duration, Instant},
};

use anyhow::{Context as _, bail};
use planesman_msgs::std_msgs::msg::String as Text;
use planesman_node::{Flow, NodeSpec, Publisher, Qos, RosArguments, Runtime};

/// Characters of a message: 100 bytes with the encapsulation, the length and the final zero.
const CHARACTERS: usize = 91;
/// Round trips before the first that counts.
const WARM_UP: u64 = 500;
/// A ping that has had no answer for so long is sent again.
const LOST: Duration = Duration::from_millis(500);

enum Event {
    Message(Text),
    Poll,
    Parameters,
}

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    arguments.retain(|argument| argument != "--bench");
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    planesman_node::exit_code("hop", || match arguments[..] {
        ["ping", seconds] => ping(Duration::from_secs_f64(seconds.parse()?)),
        ["pong"] => pong(),
        ["pub", rate] => publish(rate.parse()?),
        ["sub"] => subscribe(),
        // What `cargo bench` runs.
        [] => planesman_console::out!("benches/peers/run --only hop").context("stdout"),
        _ => bail!("expected: ping SECONDS, pong, pub RATE or sub"),
    })
}

fn node(name: &'static str) -> anyhow::Result<Runtime<Event>> {
    let spec = NodeSpec {
        name,
        namespace: "/hop",
        validate: |(): &()| Ok(()),
        on_parameters: |()| Event::Parameters,
    };
    Ok(Runtime::start(spec, RosArguments::default())?.0)
}

fn message() -> Text {
    Text {
        data: "x".repeat(CHARACTERS),
    }
}

fn ping(duration: Duration) -> anyhow::Result<()> {
    let rt = node("ping")?;
    let pings: Publisher<Text> = rt.publisher("ping", Qos::reliable(100))?;
    rt.subscribe("pong", Qos::reliable(100), Event::Message)?;
    drop(rt.every(LOST, || Event::Poll));
    let (mut answers, mut hops) = (0_u64, Vec::<Duration>::new());
    let (mut sent, mut began) = (Instant::now(), None);
    rt.run(|_, event| {
        let now = Instant::now();
        match event {
            Event::Message(_) => {
                answers += 1;
                if answers > WARM_UP {
                    hops.push((now - sent) / 2);
                }
            }
            Event::Poll if now - sent >= LOST => {}
            Event::Poll | Event::Parameters => return Ok(Flow::Continue),
        }
        if answers == WARM_UP {
            began = Some(now);
        }
        if began.is_some_and(|began| now - began >= duration) {
            hops.sort_unstable();
            let at = |share: f64| {
                let hop = hops[(share * (hops.len() - 1) as f64) as usize];
                hop.as_secs_f64() * 1e6
            };
            planesman_console::out!(
                "{{\"count\": {}, \"median\": {:.2}, \"p99\": {:.2}}}",
                hops.len(),
                at(0.5),
                at(0.99)
            )?;
            return Ok(Flow::Stop);
        }
        sent = Instant::now();
        pings.publish(&message());
        Ok(Flow::Continue)
    })
}

fn pong() -> anyhow::Result<()> {
    let rt = node("pong")?;
    let pongs = rt.publisher("pong", Qos::reliable(100))?;
    rt.subscribe("ping", Qos::reliable(100), Event::Message)?;
    rt.run(|_, event| {
        if let Event::Message(message) = event {
            pongs.publish(&message);
        }
        Ok(Flow::Continue)
    })
}

fn publish(rate: f64) -> anyhow::Result<()> {
    let rt = node("publisher")?;
    let output = rt.publisher("data", Qos::reliable(100))?;
    drop(rt.every(Duration::from_secs_f64(1.0 / rate), || Event::Poll));
    rt.run(|_, event| {
        if let Event::Poll = event {
            output.publish(&message());
        }
        Ok(Flow::Continue)
    })
}

fn subscribe() -> anyhow::Result<()> {
    let rt = node("subscriber")?;
    rt.subscribe("data", Qos::reliable(100), Event::Message)?;
    drop(rt.every(Duration::from_secs(1), || Event::Poll));
    let mut total = 0_u64;
    rt.run(|_, event| {
        match event {
            Event::Message(_) => total += 1,
            Event::Poll => planesman_console::out!("total {total}")?,
            Event::Parameters => {}
        }
        Ok(Flow::Continue)
    })
}
