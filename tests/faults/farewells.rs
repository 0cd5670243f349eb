//! A stranger says in the name of participants that they have left. They have not, so they are found and matched again.

use std::collections::BTreeSet;
use std::fs;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use planesman_node::Connections;
use rustix::process::Pid;

use super::evidence::{self, stamp};
use super::garbage::{Announcements, HEADER, PARTICIPANTS, port};
use super::stage::{Received, Signal, Stage, scenario};
use super::trial;

/// How often the controller is told that the recorder has left, and the time between two.
const TIMES: u32 = 100;
const PERIOD: Duration = Duration::from_millis(20);

pub(crate) fn trials() -> Vec<Trial> {
    vec![
        trial("farewells/of_all_to_all".to_owned(), true, of_all_to_all),
        trial(
            "farewells/of_the_recorder_to_the_controller".to_owned(),
            true,
            of_the_recorder_to_the_controller,
        ),
    ]
}

/// All are matched again, and the loop resumes.
fn of_all_to_all() {
    let stage = Stage::new();
    let announced = Announcements::listen(stage.domain());
    let file = stage.file("long.yaml", scenario(86_400.0, "  sysid: {start: 2.0}\n"));
    let out = stage.path("out");
    let launcher = stage.start(&["dive", &file, "--lockstep", "--keep-running", "--out", &out]);
    let nodes = launcher.nodes();
    let operator = stage.operator();
    operator.state("a flight", |_| true);
    let announced = announced.take();

    let began = Instant::now();
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    for packet in announced.iter().map(|real| farewell(real, 0)) {
        for participant in 0..PARTICIPANTS - 1 {
            let port = port(stage.domain(), participant);
            // Where nobody listens it is refused; that is none of ours.
            let _ = socket.send_to(&packet, (Ipv4Addr::LOCALHOST, port));
        }
    }
    // What was on its way has come by then.
    thread::sleep(Duration::from_millis(100));
    let stopped = stamp(&operator.state("the loop", |_| true));
    operator.state("the loop to resume", |state| {
        stamp(state) > stopped + 200 * evidence::TICK
    });
    let resumed = began.elapsed().as_secs_f64();
    println!("farewells/of_all_to_all: 200 ticks after {resumed:.1} s");

    launcher.signal(Signal::TERM);
    let outcome = launcher.finish();
    // What was published while nobody was matched is lost.
    evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
    evidence::nobody_is_left(&nodes);
    let flight = evidence::whole_flight(&Path::new(&out).join("bag"));
    evidence::each_tick_is_there(&flight);
}

/// What the controller publishes meanwhile reaches the recorder, for which no tick waits, once it is matched again; what does not is told.
fn of_the_recorder_to_the_controller() {
    let stage = Stage::new();
    let announced = Announcements::listen(stage.domain());
    let file = stage.file("long.yaml", scenario(86_400.0, "  sysid: {start: 2.0}\n"));
    let out = stage.path("out");
    let launcher = stage.start(&["dive", &file, "--lockstep", "--keep-running", "--out", &out]);
    let operator = stage.operator();
    operator.state("a flight", |_| true);
    let nodes = launcher.nodes();
    let announced = announced.take();

    let discovery = |node: &str| discovery_port(nodes[node], stage.domain());
    let recorder = announced.iter().find(|packet| {
        let port = u32::from(discovery("recorder")).to_le_bytes();
        // A locator is a kind, UDP over IPv4, and a port in front of an address.
        let locator = [1_u32.to_le_bytes(), port].concat();
        packet.windows(locator.len()).any(|part| part == locator)
    });
    let controller = (Ipv4Addr::LOCALHOST, discovery("depth_controller"));
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let readers = |what: &str, wanted: fn(usize) -> bool| {
        operator.until(what, |received| {
            let Received::Diagnostics(array) = received else {
                return None;
            };
            let of = Connections::from_diagnostics(&array)?;
            let mut all = (of.node == "/auv/depth_controller").then_some(of.list)?;
            all.retain(|it| it.topic == "/auv/control_state");
            wanted(all.first()?.peers).then_some(())
        });
    };
    // The operator is the other one.
    readers("the recorder as a reader", |count| count == 2);
    thread::scope(|scope| {
        scope.spawn(|| {
            for time in 0..TIMES {
                let packet = farewell(recorder.unwrap(), time);
                socket.send_to(&packet, controller).unwrap();
                thread::sleep(PERIOD);
            }
        });
        readers("the recorder to be missed", |count| count == 1);
    });
    readers("the recorder's return", |count| count == 2);
    let told = stamp(&operator.state("the loop", |_| true));
    operator.state("the loop to go on", |state| {
        stamp(state) > told + 20 * evidence::TICK
    });

    launcher.signal(Signal::TERM);
    let outcome = launcher.finish();
    evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
    evidence::nobody_is_left(&nodes);
    let flight = evidence::whole_flight(&Path::new(&out).join("bag"));
    evidence::each_tick_is_there(&flight);
}

/// The port on which a process's participant discovers others.
fn discovery_port(process: Pid, domain: u16) -> u16 {
    let process = format!("/proc/{}", process.as_raw_nonzero());
    let sockets: BTreeSet<String> = fs::read_dir(format!("{process}/fd"))
        .unwrap()
        .filter_map(|entry| fs::read_link(entry.ok()?.path()).ok())
        .filter_map(|target| {
            let name = target.to_str()?.strip_prefix("socket:[")?;
            Some(name.strip_suffix(']')?.to_owned())
        })
        .collect();
    let table = fs::read_to_string(format!("{process}/net/udp")).unwrap();
    let own_ports = table.lines().skip(1).filter_map(|line| {
        let columns: Vec<&str> = line.split_whitespace().collect();
        let port = columns.get(1)?.rsplit_once(':')?.1;
        sockets
            .contains(*columns.get(9)?)
            .then(|| u16::from_str_radix(port, 16).unwrap())
    });
    let own_ports: BTreeSet<u16> = own_ports.collect();
    let mut known = (0..PARTICIPANTS).map(|participant| port(domain, participant));
    known.find(|port| own_ports.contains(port)).unwrap()
}

/// That the participant of this announcement has left (RTPS 2.3, 8.5.3 and 9.6.3.9), said for the nth time.
fn farewell(real: &[u8], time: u32) -> Vec<u8> {
    let mut body = vec![0, 0, 16, 0];
    // To anybody, from the endpoint of participants' announcements, with a number that it comes to after days.
    body.extend([0_u32, 0x0001_00c2].map(u32::to_be_bytes).concat());
    body.extend([0_u32, 1_000_000 + time].map(u32::to_le_bytes).concat());
    // Disposed and unregistered.
    body.extend([0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0]);
    // Its GUID is the key, in a list of parameters.
    body.extend([0, 3, 0, 0, 0x50, 0, 16, 0]);
    body.extend(&real[8..HEADER]);
    body.extend([0, 0, 1, 0xc1, 1, 0, 0, 0]);
    let mut packet = real[..HEADER].to_vec();
    packet.extend([0x15, 0x0b]);
    packet.extend(u16::try_from(body.len()).unwrap().to_le_bytes());
    packet.extend(body);
    packet
}
