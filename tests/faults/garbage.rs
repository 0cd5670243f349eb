//! Packets that nobody should send, while the loop flies: it keeps flying, in the memory it has.
//!
//! All of them go to the ports that the nodes' middleware has on the loopback interface (RTPS 2.3, 9.6.1.1).

use std::collections::{BTreeMap, VecDeque};
use std::net::{Ipv4Addr, UdpSocket};
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use rustix::io::read;
use rustix::net::{AddressFamily, Protocol, RawProtocol, SocketFlags, SocketType, socket_with};
use rustix::process::Pid;

use super::evidence::{self, stamp};
use super::stage::{LONG_WORK, Operator, Signal, Stage, eventually, scenario};
use super::{trial, trial_where};

/// Packets a second.
const RATE: u32 = 1000;
/// How long they come.
const DURATION: Duration = Duration::from_secs(60);
/// Address space of each process, KiB: a claim of gigabytes is not to be had.
const CEILING: u32 = 1_500_000;
/// By how much a process may grow, B: what all readers have acknowledged stays for up to six seconds, 35 MB at 2,400 ticks a second.
const GROWTH: u64 = 64 << 20;
/// Ticks after which no queue grows any more.
const QUEUES_FULL: i64 = 11_000;
/// Participants whose ports are tried; without multicast there are no more.
pub(crate) const PARTICIPANTS: u16 = 12;
/// A port where nobody listens.
const NOBODY: u32 = 9;
/// The participants that a flood invents.
const INVENTED: u16 = 1000;

pub(crate) fn trials() -> Vec<Trial> {
    vec![
        trial("garbage/a_claim_takes_no_memory".to_owned(), true, || {
            lives_through(made_by(claiming), Duration::from_secs(5));
        }),
        trial_where(
            || Tap::open(0).map(drop),
            "garbage/damaged_copies_of_its_own".to_owned(),
            true,
            || {
                let [before, during, after] = lives_through(damaged, Duration::from_secs(5));
                let ticks = format!("{before}, {during}, {after} ticks a second");
                // A pair of endpoints that stands still leaves a tick a second, a thousandth; one that goes on by the
                // middleware's timers alone, of 20 to 100 ms, at most a fortieth. Without packets nothing holds the loop up.
                assert!(during > before / 20.0, "{ticks}");
                assert!(after > before / 4.0, "{ticks}");
            },
        ),
        trial("garbage/each_kind_of_submessage".to_owned(), false, || {
            flies_on(forged)
        }),
        trial("garbage/flood_of_participants".to_owned(), false, || {
            flies_on(invented)
        }),
        trial("garbage/flood_at_ones_expense".to_owned(), false, || {
            flies_on(invented_elsewhere)
        }),
    ]
}

/// The garbage: random, or made of the participants' own announcements.
type Maker = fn(&mut Pcg64, &[Vec<u8>]) -> Vec<u8>;

/// Makes packets, each with the port that it goes to; from the domain and the participants' announcements.
type Source = Box<dyn FnMut(&mut Pcg64) -> Option<(u16, Vec<u8>)> + Send>;

/// Packets of a maker for any port of the participants.
fn made_by(maker: Maker) -> impl FnOnce(u16, Vec<Vec<u8>>) -> Source {
    move |domain, announced| {
        Box::new(move |chance| {
            let packet = maker(chance, &announced);
            let participant = chance.random_range(0..PARTICIPANTS - 1);
            let port = port(domain, participant) + chance.random_range(0..2);
            Some((port, packet))
        })
    }
}

/// Like [`lives_through`], for [`DURATION`]; and the loop keeps more than half of its speed.
fn flies_on(maker: Maker) {
    let [before, during, _] = lives_through(made_by(maker), DURATION);
    assert!(during > before / 2.0, "{during} of {before} ticks a second");
}

/// The loop flies while packets come for so long. Everybody lives, has as much memory as before, shows that it
/// refuses something, and ends when it is asked to. Returns the ticks a second before, meanwhile and after.
fn lives_through(source: impl FnOnce(u16, Vec<Vec<u8>>) -> Source, time: Duration) -> [f64; 3] {
    let stage = Stage::new();
    let announced = Announcements::listen(stage.domain());
    let file = stage.file("long.yaml", scenario(86_400.0, "  sysid: {start: 2.0}\n"));
    let out = stage.path("out");
    let limited = [
        "bash",
        "-c",
        "ulimit -v \"$0\" && exec \"$@\"",
        &CEILING.to_string(),
    ]
    .map(str::to_owned);
    let launcher = stage.start_at(
        &limited,
        &["dive", &file, "--lockstep", "--keep-running", "--out", &out],
        &[],
    );
    let operator = stage.operator();
    let first = stamp(&operator.state("a flight", |_| true));
    // The recorder keeps the last 10,000 messages of each topic: what it holds is not to grow any more.
    while stamp(&operator.state("a flight", |_| true)) < first + QUEUES_FULL * evidence::TICK {}
    let nodes = launcher.nodes();
    let before = rate(&operator, time / 6);
    let memory_before = memory(&nodes);

    let sender = Sender::start(source(stage.domain(), announced.take()));
    let during = rate(&operator, time);
    let memory_during = memory(&nodes);
    for name in nodes.keys() {
        let status = format!("/auv/{name}: middleware");
        let counts = operator.until("refusals that are counted", |received| {
            let status = received.status(&status)?;
            let counts = status
                .values
                .iter()
                .map(|pair| format!("{} {}", pair.key, pair.value));
            status
                .message
                .contains("was refused")
                .then(|| counts.collect::<Vec<_>>().join(", "))
        });
        println!("{name} has refused: {counts}");
    }
    let sent = sender.stop();
    let after = rate(&operator, time / 2);
    println!(
        "{sent} packets: {during:.0} of {before:.0} ticks a second, {after:.0} after them; memory {memory_before:?}, then {memory_during:?} B"
    );

    for (name, before) in &memory_before {
        let grown = memory_during[name].saturating_sub(*before);
        assert!(grown < GROWTH, "{name} has grown by {grown} B");
    }
    launcher.signal(Signal::TERM);
    let asked = Instant::now();
    // It reads a bag of some 100,000 ticks for its report.
    let outcome = launcher.finish_within(LONG_WORK);
    evidence::ends_and_says_what_it_lost(&outcome, std::path::Path::new(&out));
    println!(
        "it ended {:.1} s after SIGTERM",
        asked.elapsed().as_secs_f64()
    );
    assert!(outcome.stdout.contains("Interrupted after"), "{outcome:#?}");
    evidence::nobody_is_left(&nodes);
    let flight = evidence::whole_flight(&std::path::Path::new(&out).join("bag"));
    evidence::each_tick_is_there(&flight);
    [before, during, after]
}

/// Ticks of the vehicle a second, over so long.
pub(crate) fn rate(operator: &Operator, time: Duration) -> f64 {
    let first = stamp(&operator.state("the loop", |_| true));
    let began = Instant::now();
    let mut last = first;
    while began.elapsed() < time {
        if let planesman_node::Next::Event(super::stage::Received::State(state)) =
            operator.rt.next(Duration::from_millis(100))
        {
            last = stamp(&state);
        }
    }
    (last - first) as f64 / evidence::TICK as f64 / began.elapsed().as_secs_f64()
}

/// The memory in use by each process, B.
pub(crate) fn memory(nodes: &BTreeMap<String, Pid>) -> BTreeMap<String, u64> {
    let of = |pid: &Pid| {
        let status =
            std::fs::read_to_string(format!("/proc/{}/status", pid.as_raw_nonzero())).ok()?;
        let line = status
            .lines()
            .find_map(|line| line.strip_prefix("VmRSS:"))?;
        line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()
    };
    nodes
        .iter()
        .map(|(name, pid)| {
            (
                name.clone(),
                of(pid).unwrap_or_else(|| panic!("{name} has ended")) << 10,
            )
        })
        .collect()
}

/// The port of a domain's participant for discovery; that for its data is the next.
pub(crate) fn port(domain: u16, participant: u16) -> u16 {
    7410 + 250 * domain + 2 * participant
}

/// The participants' announcements, received as a twelfth one would.
pub(crate) struct Announcements {
    socket: UdpSocket,
}

impl Announcements {
    pub(crate) fn listen(domain: u16) -> Self {
        let address = (Ipv4Addr::LOCALHOST, port(domain, PARTICIPANTS - 1));
        let socket = UdpSocket::bind(address).unwrap();
        socket.set_nonblocking(true).unwrap();
        Self { socket }
    }

    /// Those of six participants at least.
    pub(crate) fn take(self) -> Vec<Vec<u8>> {
        let mut received = BTreeMap::new();
        let mut buffer = [0; 65_536];
        eventually("announcements of all", || {
            while let Ok(length) = self.socket.recv(&mut buffer) {
                if length >= HEADER && buffer[..4] == *b"RTPS" {
                    received.insert(buffer[8..HEADER].to_vec(), buffer[..length].to_vec());
                }
            }
            (received.len() >= 6).then_some(())
        });
        received.into_values().collect()
    }
}

/// Sends at [`RATE`] until it is stopped.
struct Sender {
    stop: Arc<AtomicBool>,
    sent: Arc<AtomicU64>,
    thread: thread::JoinHandle<()>,
}

impl Sender {
    fn start(mut source: Source) -> Self {
        let (stop, sent) = (
            Arc::new(AtomicBool::new(false)),
            Arc::new(AtomicU64::new(0)),
        );
        let (ours, count) = (Arc::clone(&stop), Arc::clone(&sent));
        let thread = thread::spawn(move || {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            let mut chance = Pcg64::seed_from_u64(1);
            let began = Instant::now();
            for number in 0.. {
                let due = began + Duration::from_secs(1) * number / RATE;
                thread::sleep(due.saturating_duration_since(Instant::now()));
                if ours.load(Ordering::Relaxed) {
                    return;
                }
                let Some((port, packet)) = source(&mut chance) else {
                    continue;
                };
                // Where nobody listens it is refused; that is none of ours.
                let _ = socket.send_to(&packet, (Ipv4Addr::LOCALHOST, port));
                count.fetch_add(1, Ordering::Relaxed);
            }
        });
        Self { stop, sent, thread }
    }

    fn stop(self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
        self.sent.load(Ordering::Relaxed)
    }
}

/// A packet's header (RTPS 2.3, 8.3.3.1), B.
pub(crate) const HEADER: usize = 20;

/// The kinds of submessages (RTPS 2.3, 9.4.5.1), one that does not exist among them.
const KINDS: [u8; 14] = [
    0x01, 0x06, 0x07, 0x08, 0x09, 0x0c, 0x0d, 0x0e, 0x0f, 0x12, 0x13, 0x15, 0x16, 0x7f,
];

/// Readers and writers: none, those of discovery, and the first of a node's own.
const ENTITIES: [u32; 12] = [
    0x0000_0000,
    0x0001_00c2,
    0x0001_00c7,
    0x0000_03c2,
    0x0000_03c7,
    0x0000_04c2,
    0x0000_04c7,
    0x0002_00c2,
    0x0002_00c7,
    0x0000_0103,
    0x0000_0104,
    0x0000_0004,
];

/// Numbers on which lengths, counts and sequence numbers break.
const NUMBERS: [u32; 10] = [
    0,
    1,
    2,
    7,
    0xffff,
    0x0001_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

/// One packet in three is noise behind a header, one a real announcement spoilt, one a submessage made up in
/// the name of a participant that there is.
fn forged(chance: &mut Pcg64, announced: &[Vec<u8>]) -> Vec<u8> {
    let real = &announced[chance.random_range(0..announced.len())];
    let mut packet = match chance.random_range(0..3) {
        0 => {
            let mut packet = real[..HEADER].to_vec();
            let length = chance.random_range(0..1400);
            packet.extend((0..length).map(|_| chance.random::<u8>()));
            return packet;
        }
        1 => {
            let mut packet = real.clone();
            for _ in 0..chance.random_range(1..8) {
                let place = chance.random_range(HEADER..packet.len());
                packet[place] = chance.random();
            }
            packet.truncate(chance.random_range(HEADER..=packet.len()));
            return packet;
        }
        _ => real[..HEADER].to_vec(),
    };
    let mut body = Vec::new();
    let kind = KINDS[chance.random_range(0..KINDS.len())];
    if matches!(kind, 0x15 | 0x16) {
        // Extra flags, and where the sample begins behind the next words.
        let after = if kind == 0x15 { 16 } else { 28 };
        body.extend([0, 0, after, 0]);
    }
    for _ in 0..2 {
        body.extend(ENTITIES[chance.random_range(0..ENTITIES.len())].to_be_bytes());
    }
    for _ in 0..chance.random_range(0..16) {
        body.extend(NUMBERS[chance.random_range(0..NUMBERS.len())].to_le_bytes());
    }
    packet.extend([kind, chance.random::<u8>() | 1]);
    packet.extend(u16::try_from(body.len()).unwrap().to_le_bytes());
    packet.extend(body);
    packet
}

/// The packets of a domain as they cross the loopback interface, for who may read it.
struct Tap {
    socket: OwnedFd,
    domain: u16,
    /// The latest ones, each with its port.
    recent: VecDeque<(u16, Vec<u8>)>,
}

impl Tap {
    /// Packets that are remembered.
    const REMEMBERED: usize = 200;

    fn open(domain: u16) -> Result<Self, String> {
        let ip = RawProtocol::new(u32::from(0x0800_u16.to_be())).map(Protocol::from_raw);
        let (family, kind) = (AddressFamily::PACKET, SocketType::DGRAM);
        let socket = socket_with(family, kind, SocketFlags::NONBLOCK, ip);
        Ok(Self {
            socket: socket.map_err(|e| format!("no packets of others can be read here: {e}"))?,
            domain,
            recent: VecDeque::new(),
        })
    }

    /// One of the latest packets, each the last one as often as all others together.
    fn packet(&mut self, chance: &mut Pcg64) -> Option<(u16, Vec<u8>)> {
        let mut buffer = [0; 65_536];
        while let Ok(length) = read(&self.socket, &mut buffer) {
            let packet = &buffer[..length];
            let data = usize::from(packet[0] & 0xf) * 4 + 8;
            if length < data + HEADER || packet[9] != 17 || packet[data..data + 4] != *b"RTPS" {
                continue;
            }
            let to = u16::from_be_bytes([packet[data - 6], packet[data - 5]]);
            let ports = port(self.domain, 0)..port(self.domain, PARTICIPANTS);
            if ports.contains(&to) {
                self.recent.push_back((to, packet[data..].to_vec()));
            }
            if self.recent.len() > Self::REMEMBERED {
                self.recent.pop_front();
            }
        }
        match chance.random() {
            true => self.recent.back().cloned(),
            false if self.recent.is_empty() => None,
            false => self
                .recent
                .get(chance.random_range(0..self.recent.len()))
                .cloned(),
        }
    }
}

/// Copies of what the flight's participants send each other, announcements, data and acknowledgements, with one to seven
/// bits flipped or a word replaced.
fn damaged(domain: u16, _: Vec<Vec<u8>>) -> Source {
    let mut tap = Tap::open(domain).unwrap();
    Box::new(move |chance| {
        let (port, mut packet) = tap.packet(chance)?;
        let body = HEADER..packet.len();
        if chance.random_range(0..10) < 7 {
            for _ in 0..chance.random_range(1..8) {
                packet[chance.random_range(body.clone())] ^= 1 << chance.random_range(0..8);
            }
        } else {
            let word = body.start + chance.random_range(0..body.len() / 4) * 4;
            let number = NUMBERS[chance.random_range(0..NUMBERS.len())];
            packet[word..word + 4].copy_from_slice(&number.to_le_bytes());
        }
        Some((port, packet))
    })
}

/// A stranger's first fragment of a sample of 4 GB, 64 bytes in all.
fn claiming(chance: &mut Pcg64, _: &[Vec<u8>]) -> Vec<u8> {
    let mut packet = b"RTPS\x02\x04\x01\x12".to_vec();
    packet.extend((0..12).map(|_| chance.random::<u8>()));
    packet.extend([0x16, 1, 40, 0, 0, 0, 28, 0]);
    // To and from the endpoints of participants' announcements.
    packet.extend(
        [0x0001_00c7_u32, 0x0001_00c2]
            .map(u32::to_be_bytes)
            .concat(),
    );
    // Number 7, its fragment 1, one of 1,024 bytes, of so many in all.
    packet.extend([0_u32, 7, 1].map(u32::to_le_bytes).concat());
    packet.extend([1_u16, 1024].map(u16::to_le_bytes).concat());
    packet.extend(u32::MAX.to_le_bytes());
    packet.extend([b'A'; 8]);
    packet
}

/// The announcement of a participant that there is not, one of [`INVENTED`], where nobody listens.
fn invented(chance: &mut Pcg64, announced: &[Vec<u8>]) -> Vec<u8> {
    let mut packet = invented_elsewhere(chance, announced);
    for place in HEADER..packet.len() - 8 {
        // A locator is a kind, UDP over IPv4, and a port in front of an address.
        let (kind, port) = (&packet[place..place + 4], &packet[place + 4..place + 8]);
        if *kind == 1_u32.to_le_bytes() && port[2..] == [0, 0] && port[1] >= 0x1c {
            packet[place + 4..place + 8].copy_from_slice(&NOBODY.to_le_bytes());
        }
    }
    packet
}

/// Like [`invented`], but all of them where the first real one listens, who gets what they are sent.
fn invented_elsewhere(chance: &mut Pcg64, announced: &[Vec<u8>]) -> Vec<u8> {
    let real = &announced[0];
    let own = real[8..HEADER].to_vec();
    let mut name = own.clone();
    name[8..10].copy_from_slice(&chance.random_range(0..INVENTED).to_le_bytes());
    name[10] = 0xfe;
    let mut packet = real.clone();
    // Its name stands in the header and among its particulars.
    for place in 0..=packet.len() - own.len() {
        if packet[place..].starts_with(&own) {
            packet[place..place + own.len()].copy_from_slice(&name);
        }
    }
    packet
}
