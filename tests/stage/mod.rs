//! The stage of the tests that need no foreign program: a DDS domain and a folder of one's own,
//! programs that end with it, and an operator who hears the loop and speaks to it.
//!
//! Nothing here waits for a fixed time: one waits for what is to happen, and gives up only
//! after [`PATIENCE`], which is reached when something is broken.

// Each test program uses its own part.
#![allow(dead_code, clippy::unwrap_used)]

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use planesman_msgs::Service;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_msgs::planesman_msgs::action::ManoeuvreFeedback;
use planesman_msgs::planesman_msgs::msg::{ControlState, DhaState, ModelEstimate, VehicleState};
use planesman_msgs::rcl_interfaces::msg::{
    Parameter, ParameterType, ParameterValue, SetParametersResult,
};
use planesman_msgs::rcl_interfaces::srv::{
    SetParametersAtomically, SetParametersAtomicallyRequest,
};
use planesman_node::testing::OwnDomain;
use planesman_node::{Client, GoalId, Next, NodeSpec, Qos, RosArguments, Runtime};
pub(crate) use rustix::process::Signal;
use rustix::process::{Pid, kill_process, kill_process_group};
use tempfile::TempDir;

/// Longest that anything may take; reached only when something is broken.
pub(crate) const PATIENCE: Duration = Duration::from_secs(90);

/// The same of long work, as many dives at once or a long one: how long that takes on a busy machine is the machine's.
pub(crate) const LONG_WORK: Duration = Duration::from_secs(900);

/// Time between two looks at what is waited for.
pub(crate) const LOOK: Duration = Duration::from_millis(10);

/// Looks until there is something to see.
pub(crate) fn eventually<T>(what: &str, look: impl FnMut() -> Option<T>) -> T {
    within(PATIENCE, what, look)
}

/// Like [`eventually`], for what is long work: how long it takes is the machine's.
fn within<T>(patience: Duration, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + patience;
    loop {
        if let Some(seen) = look() {
            return seen;
        }
        assert!(Instant::now() < deadline, "waited in vain: {what}");
        std::thread::sleep(LOOK);
    }
}

/// A DDS domain and a folder that nobody else has.
pub(crate) struct Stage {
    domain: OwnDomain,
    folder: TempDir,
    programs: Cell<u32>,
    /// The middleware whose form of services the programs speak, Jazzy's default if empty.
    middleware: &'static str,
}

impl Stage {
    pub(crate) fn new() -> Self {
        Self {
            domain: OwnDomain::claim().unwrap(),
            folder: tempfile::tempdir().unwrap(),
            programs: Cell::new(0),
            middleware: "",
        }
    }

    /// A stage whose programs speak with that middleware.
    pub(crate) fn with(middleware: &'static str) -> Self {
        Self {
            middleware,
            ..Self::new()
        }
    }

    /// The domain's number.
    pub(crate) fn domain(&self) -> u16 {
        self.domain.id()
    }

    /// What a program in the domain has in its environment.
    pub(crate) fn variables(&self) -> impl Iterator<Item = (&'static str, String)> + use<> {
        self.domain.variables().into_iter()
    }

    /// A path in the folder, as an argument.
    pub(crate) fn path(&self, name: &str) -> String {
        let path = self.folder.path().join(name);
        path.to_str().unwrap().to_owned()
    }

    /// A file in the folder, and its path.
    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }

    /// The contents of the folder, without the programs' outputs.
    pub(crate) fn content(&self) -> Vec<String> {
        let names = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = names
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| !name.starts_with("program-"))
            .collect();
        names.sort();
        names
    }

    /// `planesman` with these arguments, in the stage's domain and folder.
    pub(crate) fn start(&self, arguments: &[&str]) -> Process {
        self.start_as(arguments, &[])
    }

    /// Like [`start`](Self::start), with more in the environment.
    pub(crate) fn start_as(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Process {
        self.start_at(&[], arguments, variables)
    }

    /// Like [`start_as`](Self::start_as), behind the arguments of a command that becomes the program somewhere else.
    pub(crate) fn start_at(
        &self,
        place: &[String],
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Process {
        let number = self.programs.replace(self.programs.get() + 1);
        let out = |stream: &str| PathBuf::from(self.path(&format!("program-{number}.{stream}")));
        let (stdout, stderr) = (out("stdout"), out("stderr"));
        let program = env!("CARGO_BIN_EXE_planesman").to_owned();
        let parts: Vec<String> = place.iter().cloned().chain([program]).collect();
        let child = Command::new(&parts[0])
            .args(&parts[1..])
            .args(arguments)
            .current_dir(self.folder.path())
            .envs(self.domain.variables())
            .env("RMW_IMPLEMENTATION", self.middleware)
            .envs(variables.iter().copied())
            .stdin(Stdio::null())
            .stdout(File::create(&stdout).unwrap())
            .stderr(File::create(&stderr).unwrap())
            // As a shell does, so that a test can press Ctrl-C.
            .process_group(0)
            .spawn()
            .unwrap();
        Process {
            child,
            arguments: arguments.join(" "),
            stdout,
            stderr,
        }
    }

    /// Runs `planesman` with these arguments to its end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Outcome {
        self.start(arguments).finish()
    }

    /// One node with parameters `name:=value`, in a process of its own, which ends with
    /// the test if nothing else ends it.
    pub(crate) fn node(&self, name: &str, parameters: &[&str]) -> Process {
        let mut arguments = vec!["node", name, "--ros-args"];
        for parameter in parameters {
            arguments.extend(["-p", parameter]);
        }
        self.start_as(&arguments, &[(planesman::nodes::LAUNCHED, "1")])
    }

    /// An operator, subscribed to the topics of the loop and able to command it.
    pub(crate) fn operator(&self) -> Operator {
        Operator::join(&self.domain)
    }
}

/// A program that was started; stopped when dropped.
pub(crate) struct Process {
    child: Child,
    arguments: String,
    stdout: PathBuf,
    stderr: PathBuf,
}

/// How a program ended.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) status: ExitStatus,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Outcome {
    /// Itself, if the program ended well.
    pub(crate) fn success(self) -> Self {
        assert!(self.status.success(), "{self:#?}");
        self
    }

    /// Its standard error, without log lines of level INFO.
    pub(crate) fn complaints(&self) -> Vec<&str> {
        let lines = self.stderr.lines();
        lines.filter(|line| !line.starts_with("[INFO]")).collect()
    }
}

impl Process {
    pub(crate) fn pid(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(self.pid(), signal).unwrap();
    }

    /// Ctrl-C reaches every process of the terminal's foreground group.
    pub(crate) fn press_ctrl_c(&self) {
        kill_process_group(self.pid(), Signal::INT).unwrap();
    }

    /// Ends it as `kill -9` does.
    pub(crate) fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    pub(crate) fn stdout(&self) -> String {
        fs::read_to_string(&self.stdout).unwrap()
    }

    pub(crate) fn stderr(&self) -> String {
        fs::read_to_string(&self.stderr).unwrap()
    }

    /// Waits for its end.
    pub(crate) fn finish(self) -> Outcome {
        self.finish_within(PATIENCE)
    }

    /// Waits for its end, of a program whose work takes longer than [`PATIENCE`] on a busy machine.
    pub(crate) fn finish_within(mut self, patience: Duration) -> Outcome {
        let what = format!("the end of planesman {}", self.arguments);
        let status = within(patience, &what, || self.child.try_wait().unwrap());
        Outcome {
            status,
            stdout: self.stdout(),
            stderr: self.stderr(),
        }
    }

    /// The nodes that a launcher has started, by name.
    pub(crate) fn nodes(&self) -> BTreeMap<String, Pid> {
        let parent = format!("PPid:\t{}", self.child.id());
        let node_of = |entry: &Path| {
            let status = fs::read_to_string(entry.join("status")).ok()?;
            let command = fs::read_to_string(entry.join("cmdline")).ok()?;
            let mut parts = command.split('\0').skip(1);
            let is_node = status.lines().any(|line| line == parent) && parts.next()? == "node";
            let pid = entry.file_name()?.to_str()?.parse().ok()?;
            is_node.then_some((parts.next()?.to_owned(), Pid::from_raw(pid)?))
        };
        fs::read_dir("/proc")
            .unwrap()
            .filter_map(|entry| node_of(&entry.ok()?.path()))
            .collect()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if !self.is_running() {
            return;
        }
        if std::thread::panicking() {
            eprintln!("planesman {}:\n{}", self.arguments, self.stderr());
        }
        // A launcher then stops its nodes; nobody is left in the folder when that goes.
        let _ = kill_process(self.pid(), Signal::TERM);
        let deadline = Instant::now() + Duration::from_secs(20);
        while self.is_running() && Instant::now() < deadline {
            std::thread::sleep(LOOK);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Keeps a process from doing anything, deaf to all but SIGKILL.
pub(crate) fn freeze(pid: Pid) {
    kill_process(pid, Signal::STOP).unwrap();
}

/// Ends a process as `kill -9` does.
pub(crate) fn kill(pid: Pid) {
    kill_process(pid, Signal::KILL).unwrap();
}

/// Whether a process still runs; one that waits for its parent to take note does not.
pub(crate) fn runs(pid: Pid) -> bool {
    let stat = fs::read_to_string(format!("/proc/{}/stat", pid.as_raw_nonzero()));
    // The state follows the command's name, which is in brackets.
    stat.is_ok_and(|stat| {
        !stat
            .rsplit_once(") ")
            .is_some_and(|(_, rest)| rest.starts_with(['Z', 'X']))
    })
}

/// A message to the operator.
#[derive(Clone, Debug)]
pub(crate) enum Received {
    State(VehicleState),
    Control(ControlState),
    Actuator(DhaState),
    Model(Box<ModelEstimate>),
    Diagnostics(DiagnosticArray),
    Progress(GoalId, ManoeuvreFeedback),
    Parameters,
}

impl Received {
    /// The node's own status `name`, such as `/auv/plant_sim: vehicle`.
    pub(crate) fn status(&self, name: &str) -> Option<&DiagnosticStatus> {
        let Self::Diagnostics(array) = self else {
            return None;
        };
        array.status.iter().find(|status| status.name == name)
    }
}

/// A node of the test's own, in the loop's domain.
pub(crate) struct Operator {
    pub(crate) rt: Runtime<Received>,
}

impl Operator {
    fn join(domain: &OwnDomain) -> Self {
        let spec = NodeSpec {
            name: "operator",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Received::Parameters,
        };
        let (rt, ()) = Runtime::start_in(domain.domain(), spec, RosArguments::default()).unwrap();
        let qos = Qos::reliable(1000);
        rt.subscribe("state", qos, Received::State).unwrap();
        rt.subscribe("control_state", qos, Received::Control)
            .unwrap();
        rt.subscribe("dha_state", qos, Received::Actuator).unwrap();
        rt.subscribe("model", qos, |model| Received::Model(Box::new(model)))
            .unwrap();
        rt.subscribe("/diagnostics", qos, Received::Diagnostics)
            .unwrap();
        Self { rt }
    }

    /// Listens until `pick` has what it wants.
    pub(crate) fn until<T>(&self, what: &str, mut pick: impl FnMut(Received) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Next::Event(received) = self.rt.next(LOOK)
                && let Some(picked) = pick(received)
            {
                return picked;
            }
            assert!(Instant::now() < deadline, "waited in vain: {what}");
        }
    }

    /// The next vehicle state that `wanted` likes.
    pub(crate) fn state(
        &self,
        what: &str,
        mut wanted: impl FnMut(&VehicleState) -> bool,
    ) -> VehicleState {
        self.until(what, |received| match received {
            Received::State(state) if wanted(&state) => Some(state),
            _ => None,
        })
    }

    /// Waits until the node's status `name` has this message, and returns its level.
    pub(crate) fn status(&self, name: &str, message: &str) -> u8 {
        self.until(&format!("{name}: {message}"), |received| {
            let status = received.status(name)?;
            status.message.contains(message).then_some(status.level)
        })
    }

    /// Changes a node's parameters, all or none.
    pub(crate) fn set(&self, node: &str, parameters: &[Parameter]) -> SetParametersResult {
        let name = format!("{node}/set_parameters_atomically");
        let set: Client<SetParametersAtomically> = self.rt.client(&name).unwrap();
        let parameters = parameters.to_vec();
        self.call(&set, SetParametersAtomicallyRequest { parameters })
            .result
    }

    /// Calls a service and waits for its answer.
    pub(crate) fn call<S: Service>(&self, client: &Client<S>, request: S::Request) -> S::Response {
        self.rt.block_on(client.call(request, PATIENCE)).unwrap()
    }
}

/// A parameter that is a number.
pub(crate) fn double(name: &str, value: f64) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value: ParameterValue {
            r#type: ParameterType::PARAMETER_DOUBLE,
            double_value: value,
            ..ParameterValue::default()
        },
    }
}

/// A parameter that is a text.
pub(crate) fn text(name: &str, value: &str) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value: ParameterValue {
            r#type: ParameterType::PARAMETER_STRING,
            string_value: value.to_owned(),
            ..ParameterValue::default()
        },
    }
}

/// The text of a scenario that flies for `seconds`, with these lines below `parameters:`.
pub(crate) fn scenario(seconds: f64, parameters: &str) -> String {
    format!("description: A test's dive\nduration: {seconds}\nparameters:\n{parameters}")
}
