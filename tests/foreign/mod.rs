//! What the suite's tests over real DDS share: processes of the `planesman` program that end with their test,
//! in a DDS domain of their own on the loopback interface, and the foreign peers of `tests/peers`.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test uses its part of this module"
)]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so by panicking"
)]

pub mod peers;

use std::{
    fs::File,
    io::Read as _,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    time::{Duration, Instant},
};

use planesman_node::{ExitReport, testing::OwnDomain};

/// Longest that anything may take; reached only when something is broken.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Whether `condition` came true within [`PATIENCE`].
pub fn comes_true(mut condition: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    loop {
        if condition() {
            return true;
        }
        if start.elapsed() > PATIENCE {
            return false;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A domain and a folder for one test's processes and their files. Both go with the value.
pub struct Sea {
    domain: OwnDomain,
    folder: tempfile::TempDir,
}

impl Sea {
    /// A domain that nobody else is in, and an empty folder.
    pub fn new() -> Self {
        Self {
            domain: OwnDomain::claim().unwrap(),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// The domain's number.
    pub fn domain(&self) -> u16 {
        self.domain.id()
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A file in the folder with this text.
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The `planesman` program, not yet started. Its services speak as Cyclone DDS does.
    pub fn planesman(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_planesman"));
        command
            .current_dir(self.folder.path())
            .envs(self.domain.variables())
            .env("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        command
    }

    /// Starts `planesman` with these arguments.
    pub fn start(&self, arguments: &[&str]) -> Process {
        let name = arguments.join(" ");
        let log = self.path(&format!("{}.log", name.replace(['/', ' '], "_")));
        let child = self
            .planesman()
            .args(arguments)
            .env("PLANESMAN_EXIT_REPORT", log.with_extension("json"))
            .stderr(File::create(&log).unwrap())
            .spawn()
            .unwrap();
        Process { name, child, log }
    }

    /// Starts one node with these parameters (`NAME:=VALUE`).
    pub fn start_node(&self, node: &str, parameters: &[&str]) -> Process {
        let mut arguments = vec!["node", node, "--ros-args"];
        for parameter in parameters {
            arguments.extend(["-p", parameter]);
        }
        self.start(&arguments)
    }

    /// Starts `planesman dive` on a scenario's text, to fly until it is stopped, `factor` times faster than the
    /// wall clock. The flight's files are in `self.path("flight")`.
    pub fn keep_flying(&self, scenario: &str, factor: &str) -> Process {
        self.file("scenario.yaml", scenario);
        let arguments = [
            "dive",
            "scenario.yaml",
            "--keep-running",
            "--factor",
            factor,
            "--out",
            "flight",
        ];
        self.start(&arguments)
    }
}

/// A running process of ours; killed if a test forgets it.
pub struct Process {
    name: String,
    child: Child,
    log: PathBuf,
}

impl Process {
    /// Its process number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// What it has written to its standard error.
    pub fn log(&self) -> String {
        let mut bytes = Vec::new();
        File::open(&self.log)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Whether it has not ended by itself.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Ends it as `kill -9` does.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ends it as `Ctrl-C` does, and returns how it ended.
    pub fn stop(&mut self) -> ExitStatus {
        self.signal("-INT");
        let mut status = None;
        let ended = comes_true(|| {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        assert!(ended, "{} does not stop:\n{}", self.name, self.log());
        status.unwrap()
    }

    /// What a node told when it stopped.
    pub fn exit_report(&self) -> ExitReport {
        exit_report(&self.log.with_extension("json"))
    }

    fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status().unwrap();
        assert!(status.success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            if std::thread::panicking() {
                eprintln!("log of {}:\n{}", self.name, self.log());
            }
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// The exit report in a file.
pub fn exit_report(path: &Path) -> ExitReport {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}
