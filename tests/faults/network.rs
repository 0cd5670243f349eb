//! Two network namespaces and the link between them, as a test drives it.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use super::forwarder::{Ends, FLAG};
use super::link::{Counts, Link};

/// The usual longest packet of an Ethernet, B.
pub(crate) const ETHERNET: u16 = 1500;

/// Arguments to put before a command so that it runs elsewhere.
pub(crate) type Place = Vec<String>;

/// Two namespaces and their link; gone when dropped.
pub(crate) struct Network {
    forwarder: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    ends: Ends,
}

/// Whether namespaces and TAP devices are to be had here; if not, why.
pub(crate) fn is_possible() -> Result<(), String> {
    Network::join(ETHERNET, 0).map(drop)
}

impl Network {
    /// Joined by a good link of this MTU (B), whose chances follow from `seed`.
    pub(crate) fn new(mtu: u16, seed: u64) -> Self {
        Self::join(mtu, seed).unwrap()
    }

    fn join(mtu: u16, seed: u64) -> Result<Self, String> {
        let this = std::env::current_exe().map_err(|e| e.to_string())?;
        let mut command = Command::new("unshare");
        if !rustix::process::geteuid().is_root() {
            command.arg("--map-root-user");
        }
        let mut forwarder = command
            .arg("--net")
            .arg(this)
            .args([FLAG, &mtu.to_string(), &seed.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| format!("unshare: {e}"))?;
        let orders = forwarder.stdin.take().ok_or("no input")?;
        let mut answers = BufReader::new(forwarder.stdout.take().ok_or("no output")?);
        let mut line = String::new();
        answers.read_line(&mut line).map_err(|e| e.to_string())?;
        let ends = serde_json::from_str(&line)
            .map_err(|_| "no network namespace with a TAP device is to be had here")?;
        Ok(Self {
            forwarder,
            orders,
            answers,
            ends,
        })
    }

    /// Puts the link into this state.
    pub(crate) fn set(&mut self, link: Link) {
        self.order(Some(link));
    }

    /// The fate of the frames so far: those to the far end, then those to the near one.
    pub(crate) fn counts(&mut self) -> [Counts; 2] {
        self.order(None)
    }

    fn order(&mut self, link: Option<Link>) -> [Counts; 2] {
        writeln!(self.orders, "{}", serde_json::to_string(&link).unwrap()).unwrap();
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap()
    }

    /// From now on no packet to several crosses the link.
    pub(crate) fn without_multicast(&self) {
        for (device, place) in [("near", self.near()), ("far", self.far())] {
            let ip = |arguments: &str| {
                let mut command = Command::new(&place[0]);
                command.args(&place[1..]).arg("ip");
                let output = command.args(arguments.split(' ')).output().unwrap();
                assert!(output.status.success(), "ip {arguments}: {output:?}");
                String::from_utf8(output.stdout).unwrap()
            };
            ip(&format!("link set {device} multicast off"));
            ip(&format!("route del 224.0.0.0/4 dev {device}"));
            let flags = ip(&format!("link show dev {device}"));
            assert!(!flags.contains("MULTICAST"), "{flags}");
        }
    }

    /// Where the near end is.
    pub(crate) fn near(&self) -> Place {
        inside(self.ends.near)
    }

    /// Where the far end is.
    pub(crate) fn far(&self) -> Place {
        inside(self.ends.far)
    }
}

/// In the namespaces of the process `pid`.
pub(crate) fn inside(pid: u32) -> Place {
    let mut command = vec!["nsenter".to_owned()];
    if !rustix::process::geteuid().is_root() {
        command.extend(["--user", "--preserve-credentials"].map(str::to_owned));
    }
    command.extend(["--net".to_owned(), format!("--target={pid}")]);
    command
}

impl Drop for Network {
    fn drop(&mut self) {
        // It ends with its input as well, but so it ends now.
        let _ = self.forwarder.kill();
        let _ = self.forwarder.wait();
    }
}
