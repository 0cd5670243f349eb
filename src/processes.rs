//! The nodes as child processes: starts, monitors, and stops them in order.

use std::fs::File;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use planesman_node::STRICT_PARAMETERS;
use rustix::process::{Pid, Signal, kill_process};

use crate::nodes::LAUNCHED;
use crate::run_folder::RunFolder;
use planesman_flight::nodes::NAMESPACE;

/// Timeout for a node to stop cleanly.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// The process of one node.
struct Member {
    name: &'static str,
    child: Child,
    exit: Option<ExitStatus>,
}

/// The running nodes of one flight.
pub struct Processes {
    run: RunFolder,
    members: Vec<Member>,
    /// The process of the web page, which is not part of the flight.
    page: Option<Child>,
}

impl Processes {
    /// Starts each of `nodes` as a process of this program, with the flight's parameter file.
    ///
    /// # Errors
    /// A process cannot be started; those already running are stopped.
    pub fn start(run: &RunFolder, namespace: &str, nodes: &[&'static str]) -> Result<Self> {
        let program = std::env::current_exe().context("cannot find this program's own path")?;
        let mut processes = Self {
            run: run.clone(),
            members: Vec::new(),
            page: None,
        };
        for name in nodes {
            let log = File::create(run.log(name))
                .with_context(|| format!("cannot write '{}'", run.log(name).display()))?;
            let child = Command::new(&program)
                .args(["node", name, "--ros-args", "-r"])
                .arg(format!("__ns:={namespace}"))
                .args(own_clock(namespace))
                .arg("--params-file")
                .arg(run.parameter_file())
                .env(LAUNCHED, "1")
                .env(STRICT_PARAMETERS, "1")
                .env("PLANESMAN_EXIT_REPORT", run.exit_report(name))
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(log)
                // Ctrl-C is the launcher's: it stops the nodes in order.
                .process_group(0)
                .spawn()
                .with_context(|| format!("cannot start the node {name}"))?;
            processes.members.push(Member {
                name,
                child,
                exit: None,
            });
        }
        Ok(processes)
    }

    /// Starts the process that shows the flight on a page in the browser. The process of the page reports its own errors; the flight continues
    /// without the page.
    ///
    /// # Errors
    /// The process cannot be started.
    pub fn show(&mut self) -> Result<()> {
        let program = std::env::current_exe().context("cannot find this program's own path")?;
        let child = Command::new(program)
            .args(["watch", "--", "--ros-args", "--log-level", "warn"])
            .env(LAUNCHED, "1")
            .stdin(Stdio::null())
            .process_group(0)
            .spawn()
            .context("cannot start the page")?;
        self.page = Some(child);
        Ok(())
    }

    /// Checks that every node still runs.
    ///
    /// # Errors
    /// A node has stopped by itself; the error contains the end of its log.
    pub fn check(&mut self) -> Result<()> {
        for member in &mut self.members {
            if member.exit.is_none()
                && let Some(status) = member.child.try_wait()?
            {
                member.exit = Some(status);
                bail!(
                    "the node {} stopped by itself ({status}):\n{}",
                    member.name,
                    tail(&self.run, member.name)
                );
            }
        }
        Ok(())
    }

    /// Asks all nodes to stop and waits until they have stopped. The recorder, started first, stops last, so that it receives the last messages of
    /// the other nodes even if one of them does not stop.
    ///
    /// # Errors
    /// A node does not stop in time (it is then killed), or ends with an error.
    pub fn stop(&mut self) -> Result<()> {
        let Some((recorder, publishers)) = self.members.split_first_mut() else {
            return Ok(());
        };
        for member in &*publishers {
            member.ask_to_stop();
        }
        let stopped: Vec<Result<()>> = publishers
            .iter_mut()
            .map(|member| member.wait(&self.run))
            .collect();
        recorder.ask_to_stop();
        recorder.wait(&self.run)?;
        stopped.into_iter().collect()
    }
}

impl Member {
    fn ask_to_stop(&self) {
        if self.exit.is_none() {
            signal(&self.child, Signal::TERM);
        }
    }

    fn wait(&mut self, run: &RunFolder) -> Result<()> {
        if self.exit.is_some() {
            return Ok(());
        }
        let deadline = Instant::now() + STOP_TIMEOUT;
        let status = loop {
            if let Some(status) = self.child.try_wait()? {
                break status;
            }
            if Instant::now() > deadline {
                self.child.kill()?;
                self.exit = Some(self.child.wait()?);
                bail!(
                    "the node {} did not stop within {} s and was killed; its log is {}",
                    self.name,
                    STOP_TIMEOUT.as_secs(),
                    run.log(self.name).display()
                );
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        self.exit = Some(status);
        if !status.success() {
            bail!(
                "the node {} ended with {status}:\n{}",
                self.name,
                tail(run, self.name)
            );
        }
        Ok(())
    }
}

impl Drop for Processes {
    fn drop(&mut self) {
        let deadline = Instant::now() + Duration::from_secs(3);
        if let Some(page) = &mut self.page {
            signal(page, Signal::TERM);
            let _ = ended(page, deadline);
        }
        for member in &mut self.members {
            // Best effort on the way out of an error: it cannot be reported.
            member.ask_to_stop();
        }
        let deadline = Instant::now() + Duration::from_secs(3);
        for member in &mut self.members {
            if member.exit.is_none() {
                member.exit = ended(&mut member.child, deadline);
            }
        }
    }
}

/// Waits until the process has ended, or kills it at the deadline.
fn ended(child: &mut Child, deadline: Instant) -> Option<ExitStatus> {
    loop {
        match child.try_wait() {
            Ok(None) if Instant::now() < deadline => {
                std::thread::sleep(Duration::from_millis(10));
            }
            Ok(Some(status)) => return Some(status),
            _ => {
                let _ = child.kill();
                return child.wait().ok();
            }
        }
    }
}

/// The remapping of `/clock` for a vehicle in a separate namespace.
fn own_clock(namespace: &str) -> Vec<String> {
    match namespace.trim_end_matches('/') {
        NAMESPACE => Vec::new(),
        other => vec!["-r".to_owned(), format!("/clock:={other}/clock")],
    }
}

fn signal(child: &Child, signal: Signal) {
    if let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        // It may have ended in between; then there is nobody to signal.
        let _ = kill_process(pid, signal);
    }
}

/// The last lines of a node's log, or a sentence with the reason why they cannot be read.
fn tail(run: &RunFolder, node: &str) -> String {
    let log = run.log(node);
    let text = match std::fs::read(&log) {
        Ok(text) => String::from_utf8_lossy(&text).into_owned(),
        Err(_) if !run.path().exists() => {
            let folder = run.path().display();
            return format!("the folder '{folder}' was moved or removed during the flight");
        }
        Err(error) => return format!("cannot read its log '{}': {error}", log.display()),
    };
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(8)..].join("\n")
}
