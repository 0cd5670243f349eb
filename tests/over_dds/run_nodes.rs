//! `launch-scripts/run_nodes.sh` starts the loop without ROS and without the launcher, and stops
//! all of it.
use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use planesman_bag::BagReader;
use planesman_flight::parameter_file::parameter_file;
use planesman_flight::scenario::Scenario;
use planesman_node::testing::OwnDomain;
use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use tempfile::TempDir;

/// Longest that anything may take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(90);

struct Script {
    domain: OwnDomain,
    folder: TempDir,
}

impl Script {
    fn new() -> Self {
        Self {
            domain: OwnDomain::claim().unwrap(),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, options: &[&str]) -> Command {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/launch-scripts/run_nodes.sh");
        let mut command = Command::new("env");
        command
            // Who runs the tests in the background ignores Ctrl-C, and a shell cannot undo that.
            .args(["--default-signal=INT", script])
            .args(["--bin", env!("CARGO_BIN_EXE_planesman")])
            .args(options)
            .current_dir(self.folder.path())
            .envs(self.domain.variables());
        command
    }

    /// In a process group of its own, as a shell starts it.
    fn start(&self, options: &[&str]) -> Running<'_> {
        let child = self
            .command(options)
            .stdin(Stdio::null())
            .stderr(File::create(self.path("stderr")).unwrap())
            .process_group(0)
            .spawn()
            .unwrap();
        Running {
            script: self,
            child,
        }
    }

    fn run(&self, options: &[&str]) -> Output {
        self.command(options).output().unwrap()
    }
}

struct Running<'a> {
    script: &'a Script,
    child: Child,
}

impl Running<'_> {
    fn log(&self) -> String {
        std::fs::read_to_string(self.script.path("stderr")).unwrap()
    }

    fn until<T>(&mut self, what: &str, mut look: impl FnMut(&mut Self) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(seen) = look(self) {
                return seen;
            }
            assert!(Instant::now() < deadline, "{what}:\n{}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn until_log_says(&mut self, text: &str) {
        self.until(text, |running| running.log().contains(text).then_some(()));
    }

    /// The exit status.
    fn end(&mut self) -> Option<i32> {
        let status = self.until("the end", |running| running.child.try_wait().unwrap());
        status.code()
    }

    fn press_ctrl_c(&self) {
        kill_process_group(Pid::from_child(&self.child), Signal::INT).unwrap();
    }

    /// The script's processes with `part` in their command lines.
    fn children(&self, part: &str) -> Vec<Pid> {
        let parent = format!("PPid:\t{}\n", self.child.id());
        let mut found = Vec::new();
        for entry in std::fs::read_dir("/proc").unwrap().flatten() {
            let read = |name| std::fs::read_to_string(entry.path().join(name)).unwrap_or_default();
            let pid = entry.file_name().to_str().and_then(|n| n.parse().ok());
            if let Some(pid) = pid.and_then(Pid::from_raw)
                && read("status").contains(&parent)
                && read("cmdline").replace('\0', " ").contains(part)
            {
                found.push(pid);
            }
        }
        found
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        // The nodes end with the script.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn ctrl_c_stops_all_nodes_and_the_recorder_last() {
    let script = Script::new();
    let scenario = Scenario::parse("{description: short, duration: 2}").unwrap();
    let parameters = parameter_file(None, Some(&scenario)).unwrap();
    std::fs::write(script.path("params.yaml"), parameters).unwrap();
    let options = ["--lockstep", "--params", "params.yaml", "--bag", "the bag"];
    let mut running = script.start(&options);
    running.until_log_says("done: 40 ticks");
    running.press_ctrl_c();
    assert_eq!(running.end(), Some(0), "{}", running.log());

    let log = running.log();
    let closed = log.find("bag closed").unwrap();
    assert!(log.rfind("shutting down").unwrap() < closed, "{log}");
    let bag = BagReader::open(&script.path("the bag")).unwrap();
    let states = bag
        .topics()
        .iter()
        .find(|t| t.topic.name == "/auv/state")
        .map(|t| t.messages);
    // A state is said again when somebody was late to join.
    assert!(states.is_some_and(|n| n >= 40), "{states:?}");
}

#[test]
fn when_a_node_dies_the_others_are_stopped() {
    let script = Script::new();
    let mut running = script.start(&["--no-record", "--namespace", "auv2"]);
    running.until_log_says("[auv2.plant_sim]: up in domain");
    let victim = running.until("sysid", |r| r.children("node sysid").first().copied());
    kill_process(victim, Signal::KILL).unwrap();
    assert_eq!(running.end(), Some(1), "{}", running.log());
    let log = running.log();
    assert!(log.contains("the node sysid ended by itself"), "{log}");
    assert!(running.children("node").is_empty());
}

#[test]
fn one_node_alone_is_started_by_its_name() {
    let script = Script::new();
    let mut running = script.start(&["depth_controller"]);
    running.until_log_says("[auv.depth_controller]: up in domain");
    assert_eq!(running.children(" node ").len(), 1);
    running.press_ctrl_c();
    assert_eq!(running.end(), Some(0), "{}", running.log());
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let script = Script::new();
    for (options, part) in [
        (vec!["--speed"], "--speed"),
        (vec!["rudder"], "rudder"),
        (vec!["--bag"], "--bag"),
        (vec!["--factor", "fast"], "fast"),
        (vec!["--lockstep", "--factor", "2"], "lockstep"),
        (vec!["--params", "nowhere.yaml"], "nowhere.yaml"),
    ] {
        let output = script.run(&options);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(part) && said.lines().count() == 1, "{said}");
    }
}
