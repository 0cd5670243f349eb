//! A program that joins two network namespaces by a link in user space, and changes its frames as configured.
//!
//! It is this test program once more, started with [`FLAG`] in a network namespace of its own. It makes two more,
//! the near and the far end, each with a TAP device, whose other sides it holds. Kernels without `netem` do as well.
//!
//! It prints one line with both ends' process ids, by which others enter them. Then each line it reads is the
//! link's new state ([`Link`], JSON) or `null`, answered by what has become of the frames so far ([`Counts`]). It ends with its
//! input, and the namespaces with it, once those within have ended.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::{BufReader, Read as _, Write as _};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use serde::{Deserialize, Serialize};
use tappers::{Interface, Tap};

use super::link::{Counts, Link, To, Wire};

/// The first argument of the program; the second and third are the link's MTU and seed.
pub(crate) const FLAG: &str = "--forward-frames";

/// The addresses of the ends.
pub(crate) const NEAR: &str = "10.77.0.1";
pub(crate) const FAR: &str = "10.77.0.2";
/// An Ethernet frame's header, B.
const HEADER: usize = 14;
/// Longest wait for the next frame that is due.
const IDLE: Duration = Duration::from_secs(3600);

/// The processes whose namespaces are the link's ends.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct Ends {
    pub(crate) near: u32,
    pub(crate) far: u32,
}

pub(crate) fn main(mtu: &str, seed: &str) -> ExitCode {
    match run(mtu, seed) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(mtu: &str, seed: &str) -> Result<()> {
    let (length, seed): (usize, u64) = (mtu.parse()?, seed.parse()?);
    let link = Arc::new(Mutex::new(Link::GOOD));
    let near = End::make("near", NEAR, mtu)?;
    let far = End::make("far", FAR, mtu)?;
    let wires = [(To::Far, &near, &far), (To::Near, &far, &near)].map(|(to, from, other)| {
        let wire = Arc::new(Mutex::new(Wire::new(to, seed)));
        let (sender, receiver) = channel();
        let (from, other) = (Arc::clone(&from.tap), Arc::clone(&other.tap));
        let (ours, link) = (Arc::clone(&wire), Arc::clone(&link));
        thread::spawn(move || take(&from, length + HEADER, &ours, &link, &sender));
        thread::spawn(move || deliver(&other, &receiver));
        wire
    });
    let ends = Ends {
        near: near.holder.id(),
        far: far.holder.id(),
    };
    println!("{}", serde_json::to_string(&ends)?);
    for line in std::io::stdin().lines() {
        if let Some(new) = serde_json::from_str(&line?)? {
            *lock(&link) = new;
        }
        let counts = [&wires[0], &wires[1]].map(|wire| lock(wire).counts);
        println!("{}", serde_json::to_string::<[Counts; 2]>(&counts)?);
        std::io::stdout().flush()?;
    }
    Ok(())
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// One end of the link.
struct End {
    tap: Arc<Tap>,
    /// Keeps the namespace, until its input ends.
    holder: Child,
}

impl End {
    fn make(name: &str, address: &str, mtu: &str) -> Result<Self> {
        let mut holder = Command::new("unshare")
            .args(["--net", "bash", "-c", "echo && exec cat"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("unshare")?;
        // Its line says that it has a namespace of its own.
        let mut line = [0; 1];
        let mut said = BufReader::new(holder.stdout.take().context("no output")?);
        said.read_exact(&mut line).context("no network namespace")?;
        // A device that is moved keeps its other side.
        let tap = Tap::new_named(Interface::new(name)?).context("no TAP device")?;
        let pid = holder.id().to_string();
        ip(&["link", "set", name, "netns", &pid], None)?;
        let there = Some(pid.as_str());
        ip(&["link", "set", "lo", "up"], there)?;
        ip(&["link", "set", name, "mtu", mtu, "up"], there)?;
        let address = format!("{address}/24");
        ip(&["address", "add", &address, "dev", name], there)?;
        ip(&["route", "add", "224.0.0.0/4", "dev", name], there)?;
        Ok(Self {
            tap: Arc::new(tap),
            holder,
        })
    }
}

/// Runs `ip`, in the namespace of the process `there` if one is named.
fn ip(arguments: &[&str], there: Option<&str>) -> Result<()> {
    let mut command = match there {
        None => Command::new("ip"),
        Some(pid) => {
            let mut command = Command::new("nsenter");
            command.args(["--net", "--target", pid, "ip"]);
            command
        }
    };
    let status = command.args(arguments).status().context("ip")?;
    ensure!(status.success(), "ip {}: {status}", arguments.join(" "));
    Ok(())
}

/// A frame and when it is due; of several, the first that came goes first.
type Due = Reverse<(Instant, u64, Vec<u8>)>;

/// Takes the frames of one end onto their way.
fn take(from: &Tap, longest: usize, wire: &Mutex<Wire>, link: &Mutex<Link>, way: &Sender<Due>) {
    let mut buffer = vec![0; longest];
    for number in 0.. {
        let Ok(length) = from.recv(&mut buffer) else {
            return;
        };
        let link = *lock(link);
        let delays = lock(wire).pass(&link);
        let now = Instant::now();
        for delay in delays {
            let due = Reverse((now + delay, number, buffer[..length].to_vec()));
            if way.send(due).is_err() {
                return;
            }
        }
    }
}

/// Delivers frames to one end when they are due.
fn deliver(to: &Tap, way: &Receiver<Due>) {
    let mut waiting: BinaryHeap<Due> = BinaryHeap::new();
    loop {
        let now = Instant::now();
        while let Some(Reverse((due, _, frame))) = waiting.peek()
            && *due <= now
        {
            // As on any link: a frame that the other end does not take is lost.
            let _ = to.send(frame);
            waiting.pop();
        }
        let until = waiting.peek().map_or(IDLE, |Reverse((due, _, _))| {
            due.saturating_duration_since(now)
        });
        match way.recv_timeout(until) {
            Ok(due) => waiting.push(due),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}
