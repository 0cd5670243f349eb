//! The foreign programs that the suite's tests use, where they are installed: the Python programs of
//! `tests/peers`, which are Cyclone DDS participants, rclpy nodes on Fast DDS or readers of bags, by the interpreter that runs
//! them, and those of `tests/ros`, for which rclpy has a client of its own.

// Each test program uses its own part.
#![allow(dead_code, clippy::unwrap_used)]

pub(crate) mod peers;

use std::{
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Child, ChildStdout, Command, Stdio},
};

#[allow(unused_imports)] // Each test program uses its own part.
pub(crate) use peers::{are_required, root, skip};
use serde_json::Value;

/// The full name of a topic that `planesman_msgs::loop_topics` names within the vehicle's namespace.
pub(crate) fn full_name(topic: &str) -> String {
    if topic.starts_with('/') {
        topic.to_owned()
    } else {
        format!("/auv/{topic}")
    }
}

/// A Python with the peers' programs for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Python {
    /// The folder with its `bin/python`, from the root.
    pub(crate) environment: &'static str,
    /// The folder with the programs that only it has, from the root; the others are in `tests/peers`.
    programs: &'static str,
    /// The nodes' environment to match it.
    pub(crate) middleware: &'static str,
}

/// Cyclone DDS, and the bag readers.
pub(crate) const CYCLONE: Python = Python {
    environment: ".venv",
    programs: "tests/peers",
    middleware: "rmw_cyclonedds_cpp",
};

/// ROS 2 Jazzy's rclpy on Fast DDS.
pub(crate) const RCLPY: Python = Python {
    environment: ".ros",
    programs: "tests/ros",
    middleware: "rmw_fastrtps_cpp",
};

/// The output of a peer, one JSON object per line, and its exit status.
#[derive(Debug)]
pub(crate) struct Printed {
    pub(crate) lines: Vec<Value>,
    pub(crate) status: i32,
    pub(crate) complaints: String,
}

impl Printed {
    /// The lines of a peer that succeeded.
    pub(crate) fn well(self) -> Vec<Value> {
        assert_eq!(self.status, 0, "{}", self.complaints);
        self.lines
    }

    /// The only line of a peer that succeeded.
    pub(crate) fn answer(self) -> Value {
        let mut lines = self.well();
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines.remove(0)
    }

    /// The only line of a peer that was refused what it asked.
    pub(crate) fn refusal(mut self) -> Value {
        assert_eq!((self.status, self.lines.len()), (3, 1), "{self:?}");
        self.lines.remove(0)
    }
}

impl Python {
    /// The Python of the bag readers; `None`, having said so, where there is none.
    pub(crate) fn find() -> Option<Self> {
        CYCLONE.found()
    }

    /// Itself; `None`, having said so, where it is not installed.
    pub(crate) fn found(self) -> Option<Self> {
        if !self.interpreter().exists() {
            skip(&format!("there is no {}", self.interpreter().display()));
            return None;
        }
        Some(self)
    }

    fn interpreter(&self) -> PathBuf {
        root().join(self.environment).join("bin/python")
    }

    /// A peer, not yet started.
    pub(crate) fn command(&self, program: &str, domain: u16, arguments: &[&str]) -> Command {
        self.command_at(&[], program, domain, arguments)
    }

    /// A peer behind the arguments of a command that becomes the program somewhere else, not yet started.
    pub(crate) fn command_at(
        &self,
        place: &[String],
        program: &str,
        domain: u16,
        arguments: &[&str],
    ) -> Command {
        let own = root().join(self.programs).join(program);
        let shared = root().join("tests/peers").join(program);
        let program = if own.exists() { own } else { shared };
        let mut command = self.node_at(place, &program, domain);
        command
            .args(["--domain", &domain.to_string()])
            .args(arguments);
        command
    }

    /// Any program that finds its domain in the environment, as ROS nodes do; not yet started.
    pub(crate) fn node(&self, program: &Path, domain: u16) -> Command {
        self.node_at(&[], program, domain)
    }

    fn node_at(&self, place: &[String], program: &Path, domain: u16) -> Command {
        let interpreter = self.interpreter();
        let mut command = match place {
            [] => Command::new(interpreter),
            [first, rest @ ..] => {
                let mut command = Command::new(first);
                command.args(rest).arg(interpreter);
                command
            }
        };
        command
            .arg(program)
            // Nothing leaves the loopback interface.
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env(
                "FASTRTPS_DEFAULT_PROFILES_FILE",
                root().join("tests/ros/loopback.xml"),
            )
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env("RMW_IMPLEMENTATION", self.middleware)
            .stdin(Stdio::null());
        command
    }

    /// Runs a peer to its end.
    pub(crate) fn run(&self, program: &str, domain: u16, arguments: &[&str]) -> Printed {
        self.run_as(program, domain, arguments, &[])
    }

    /// Like [`run`](Self::run), with more in the environment.
    pub(crate) fn run_as(
        &self,
        program: &str,
        domain: u16,
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Printed {
        let mut command = self.command(program, domain, arguments);
        let output = command.envs(variables.iter().copied()).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        Printed {
            lines: text.lines().map(json).collect(),
            status: output.status.code().unwrap_or(-1),
            complaints: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// The next `count` messages on a topic, however long a busy machine takes to send them.
    pub(crate) fn echo(
        &self,
        domain: u16,
        topic: &str,
        type_name: &str,
        count: usize,
    ) -> Vec<Value> {
        let count = count.to_string();
        let arguments = [topic, type_name, "--count", &count, "--timeout", "600"];
        self.run("peer_echo.py", domain, &arguments).well()
    }

    /// Starts a peer that goes on until it is dropped, or its own timeout.
    pub(crate) fn start(&self, program: &str, domain: u16, arguments: &[&str]) -> Running {
        Running::of(self.command(program, domain, arguments))
    }

    /// The result of `read_bag.py`, one JSON value.
    pub(crate) fn read_bag(&self, arguments: &[&Path]) -> Value {
        self.read("read_bag.py", arguments)
    }

    /// The result of `load_model.py`, one JSON value.
    pub(crate) fn load_model(&self, file: &Path) -> Value {
        self.read("load_model.py", &[file])
    }

    /// The result of a reader, one JSON value.
    fn read(&self, program: &str, arguments: &[&Path]) -> Value {
        let output = Command::new(self.interpreter())
            .arg(root().join("tests/peers").join(program))
            .args(arguments)
            .output()
            .unwrap();
        let complaints = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{complaints}");
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

/// A peer that goes on, line by line.
pub(crate) struct Running {
    child: Child,
    lines: BufReader<ChildStdout>,
}

impl Running {
    /// The program, started.
    pub(crate) fn of(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        Self { child, lines }
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }
}

impl Iterator for Running {
    type Item = Value;

    /// The next line, `None` when the peer has ended.
    fn next(&mut self) -> Option<Value> {
        let mut line = String::new();
        (self.lines.read_line(&mut line).unwrap() > 0).then(|| json(&line))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn json(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))
}
