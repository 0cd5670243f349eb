//! The plan of a playback: the command's arguments, the node's role, and the bag's topics by role.

use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use planesman_bag::{BagReader, Topic};
use planesman_decode::StampDecoder;
use planesman_node::{Definitions, Next, RawSample, Runtime, STRICT_PARAMETERS};
use planesman_show::diff::stamp_decoder;
use planesman_signals::types;
use rustix::process::{Pid, Signal, kill_process};

use crate::arguments::{choice, output_file};
use crate::bag_command::RuleArgs;
use crate::nodes::LAUNCHED;
use crate::run_folder::RunFolder;

planesman_text::choices! {
    /// The node that the inputs go through.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(super) enum Through {
        Controller = "controller": "depth_controller, started by this command",
        Actuator = "actuator": "dha_actuator, started by this command",
        Sysid = "sysid": "sysid, started by this command",
        Own = "own": "Any node: a running one, or the command after --",
    }
}

/// The topics of one of this program's nodes in the loop: its inputs, its outputs, and the topic that ends a tick.
pub(super) struct Role {
    pub(super) node: &'static str,
    /// Input topics; the first one begins a tick.
    pub(super) inputs: &'static [&'static str],
    /// Whether all other topics, except its answers, are inputs too.
    pub(super) plays_all: bool,
    /// The topic whose message ends the tick.
    pub(super) answer: &'static str,
    /// Output topics to compare.
    pub(super) outputs: &'static [&'static str],
    pub(super) parameter: &'static str,
}

impl Through {
    pub(super) fn role(self) -> Option<Role> {
        Some(match self {
            Self::Controller => Role {
                node: "depth_controller",
                inputs: &[
                    "state",
                    "imu",
                    "depth_pressure",
                    "speed_pressure",
                    "model",
                    "depth_setpoint",
                    "pitch_setpoint",
                    "heading_setpoint",
                    "speed_setpoint",
                ],
                plays_all: false,
                answer: "plane_command",
                outputs: &[
                    "plane_command",
                    "thruster_command",
                    "control_state",
                    "estimate",
                ],
                parameter: "lockstep:=true",
            },
            Self::Actuator => Role {
                node: "dha_actuator",
                inputs: &["plane_command"],
                plays_all: false,
                answer: "plane_motion",
                outputs: &[
                    "plane_motion",
                    "planes",
                    "dha_state",
                    "dha_state_stern",
                    "dha_state_roll",
                    "dha_state_rudder",
                ],
                parameter: "lockstep:=true",
            },
            // Its signals are on any topics.
            Self::Sysid => Role {
                node: "sysid",
                inputs: &["state"],
                plays_all: true,
                answer: "tick_answer",
                outputs: &["model"],
                parameter: "answer:=true",
            },
            Self::Own => return None,
        })
    }
}

/// Arguments of `bag play`.
#[derive(Args)]
pub struct PlayArgs {
    /// A bag folder, a metadata.yaml, an .mcap or .db3 file
    pub(super) bag: PathBuf,
    /// Publish the inputs of a tick only after the node has answered the previous tick
    #[arg(long, required = true)]
    pub(super) lockstep: bool,
    /// The node to play through
    #[arg(long, value_name = "NODE", value_parser = choice(&Through::ALL, Through::described))]
    pub(super) through: Through,
    /// With own: a topic that the node publishes; the first one ends a tick, and those that are in the bag are compared
    #[arg(long, value_name = "TOPIC")]
    pub(super) output: Vec<String>,
    /// With own: a topic to play [default: all except the outputs]
    #[arg(long, value_name = "TOPIC")]
    pub(super) input: Vec<String>,
    /// With own: the input of which the node answers every message [default: stamps of the recorded answers, else the first --input]
    #[arg(long, value_name = "TOPIC")]
    pub(super) tick: Option<String>,
    /// A ROS 2 parameter file for the node [default: parameters.yaml in the folder of the flight that recorded the bag]
    #[arg(long, value_name = "FILE")]
    pub(super) params_file: Option<PathBuf>,
    /// A parameter, NAME:=VALUE; overrides the parameter file
    #[arg(short = 'p', long = "param", value_name = "NAME:=VALUE")]
    pub(super) parameters: Vec<String>,
    /// Bag of the node's outputs, *.mcap [default: NODE.mcap]
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    pub(super) out: Option<PathBuf>,
    /// Longest time to wait for an answer, s
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = crate::arguments::within(0.01, 3600.0))]
    pub(super) timeout: f64,
    #[command(flatten)]
    pub(super) rules: RuleArgs,
    /// With own: the command that starts the node
    #[arg(last = true, value_name = "CMD")]
    pub(super) command: Vec<String>,
}

/// An output topic of the node, before the node runs.
#[derive(Clone)]
pub(super) enum PlannedOutput {
    /// The bag contains this topic, so the node's messages are compared.
    Recorded(Topic),
    /// The bag does not contain this topic; its type comes from the node.
    Unrecorded(String),
}

impl PlannedOutput {
    pub(super) fn recorded(&self) -> Option<Topic> {
        match self {
            Self::Recorded(topic) => Some(topic.clone()),
            Self::Unrecorded(_) => None,
        }
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Recorded(topic) => &topic.name,
            Self::Unrecorded(name) => name,
        }
    }

    /// The topic; for one that is not in the bag, waits until the node publishes it.
    pub(super) fn topic(
        &self,
        rt: &Runtime<Event>,
        mut node: Option<&mut Started>,
    ) -> Result<Topic> {
        let name = match self {
            Self::Recorded(topic) => return Ok(topic.clone()),
            Self::Unrecorded(name) => name,
        };
        let (deadline, end) = (Instant::now() + START, format!("/{name}"));
        loop {
            if let Some(node) = node.as_mut() {
                node.check()?;
            }
            let mut published = rt.published_topics().into_iter();
            if let Some(found) = published.find(|it| it.name == *name || it.name.ends_with(&end)) {
                let definition = rt.block_on(Definitions::from_environment().find(rt, &found));
                let definition = definition
                    .with_context(|| format!("'{}' of type {}", found.name, found.type_name))?;
                return Ok(recorder::node::published_topic(&found, definition));
            }
            if Instant::now() > deadline {
                bail!(
                    "topic '{name}' is neither in the bag nor published by a node. Is the node in this domain and namespace? (planesman doctor)"
                );
            }
            match rt.next(Duration::from_millis(20)) {
                Next::Stop => bail!("stopped before the first tick"),
                Next::Event(_) | Next::Timeout => {}
            }
        }
    }
}

pub(super) enum Event {
    Sample(usize, RawSample),
    Parameters,
}

/// Timeout for the node's topics to appear.
pub(super) const START: Duration = Duration::from_secs(30);

/// The topics by role.
pub(super) struct Plan {
    pub(super) namespace: String,
    pub(super) inputs: Vec<Topic>,
    pub(super) outputs: Vec<PlannedOutput>,
    /// The topic that ends a tick, if it is not the first output.
    pub(super) answer: Option<Topic>,
    /// Index of the input of which every message begins a tick; with `None` the stamps of the recorded answers begin ticks.
    pub(super) tick: Option<usize>,
}

/// A bag's topics except those in `but` and topics with wall-clock time.
fn others(bag: &BagReader, but: &[Topic]) -> Vec<Topic> {
    let of_wall_time = |it: &Topic| {
        planesman_show::diff::WALL_TIME
            .iter()
            .any(|wall| it.name.ends_with(wall))
    };
    let is_other =
        |it: &&Topic| !but.iter().any(|known| known.name == it.name) && !of_wall_time(it);
    let all = bag.topics().iter().map(|it| &*it.topic);
    all.filter(is_other).cloned().collect()
}

/// The bag's topic with this name, or the first topic whose name ends with it.
fn topic_named<'b>(bag: &'b BagReader, name: &str) -> Option<&'b Topic> {
    let all = || bag.topics().iter().map(|it| &*it.topic);
    let end = format!("/{name}");
    let full = all().find(|it| it.name == name);
    full.or_else(|| all().find(|it| it.name.ends_with(&end)))
}

impl Plan {
    pub(super) fn of(args: &PlayArgs, role: Option<&Role>, bag: &BagReader) -> Result<Self> {
        match role {
            None => Self::of_own_node(args, bag),
            Some(role) => Self::of_role(args, role, bag),
        }
    }

    /// The plan for any node, from the topics of the command line.
    fn of_own_node(args: &PlayArgs, bag: &BagReader) -> Result<Self> {
        if args.output.is_empty() {
            bail!(
                "--output is missing: name the topic that the node publishes at the end of a tick"
            );
        }
        let named = |name: &String| {
            topic_named(bag, name).cloned().ok_or_else(|| {
                anyhow!(
                    "{}: the bag has no topic '{name}' (planesman bag info lists the topics)",
                    args.bag.display()
                )
            })
        };
        let outputs: Vec<PlannedOutput> = args
            .output
            .iter()
            .map(|name| match topic_named(bag, name) {
                Some(topic) => PlannedOutput::Recorded(topic.clone()),
                None => PlannedOutput::Unrecorded(name.clone()),
            })
            .collect();
        let recorded: Vec<Topic> = outputs.iter().filter_map(PlannedOutput::recorded).collect();
        let inputs: Vec<Topic> = match &args.input[..] {
            [] => others(bag, &recorded),
            names => names.iter().map(named).collect::<Result<_>>()?,
        };
        let tick = match &args.tick {
            Some(name) => {
                let topic = named(name)?;
                let place = inputs.iter().position(|it| it.name == topic.name);
                Some(place.ok_or_else(|| anyhow!("--tick: '{}' is not an --input", topic.name))?)
            }
            None if outputs[0]
                .recorded()
                .is_some_and(|it| stamps_of(bag, &it).is_some()) =>
            {
                None
            }
            None if args.input.is_empty() => bail!(
                "--tick is missing: the bag has no stamped messages of '{}'; name the input whose every message the node answers",
                outputs[0].name()
            ),
            None => Some(0),
        };
        Ok(Self {
            namespace: String::new(),
            inputs,
            outputs,
            answer: None,
            tick,
        })
    }

    /// The plan for one of this program's nodes, whose topics are known.
    fn of_role(args: &PlayArgs, role: &Role, bag: &BagReader) -> Result<Self> {
        if !(args.output.is_empty() && args.input.is_empty() && args.command.is_empty())
            || args.tick.is_some()
        {
            bail!(
                "--output, --input, --tick and a command are only for --through own: the topics of {} are known",
                role.node
            );
        }
        let present = |names: &[&str]| -> Vec<Topic> {
            names
                .iter()
                .filter_map(|name| topic_named(bag, name).cloned())
                .collect()
        };
        let (first, outputs) = (role.inputs[0], present(role.outputs));
        let Some(trigger) = topic_named(bag, first) else {
            bail!(
                "{}: the bag has no topic '{first}', the input of {}",
                args.bag.display(),
                role.node
            );
        };
        if outputs.is_empty() {
            bail!(
                "{}: the bag has no messages of {} ({})",
                args.bag.display(),
                role.node,
                role.outputs.join(", ")
            );
        }
        let namespace = trigger
            .name
            .strip_suffix(&format!("/{first}"))
            .unwrap_or_default();
        let answer = topic_named(bag, role.answer).cloned().or_else(|| {
            let known = planesman_msgs::loop_topics::named(role.answer)?;
            let name = format!("{namespace}/{}", role.answer);
            Some(planesman_recording::in_bag(known, &name))
        });
        let mut all = bag.topics().iter().map(|it| &*it.topic);
        let clock = all.find(|it| it.kind.type_name == "rosgraph_msgs/msg/Clock");
        let mut inputs = present(role.inputs);
        match role.plays_all {
            true => inputs.extend(others(
                bag,
                &[&inputs[..], &outputs, answer.as_slice()].concat(),
            )),
            false => inputs.extend(clock.cloned()),
        }
        Ok(Self {
            namespace: namespace.to_owned(),
            inputs,
            outputs: outputs.into_iter().map(PlannedOutput::Recorded).collect(),
            answer: Some(answer.context("the topic of the answer is not known")?),
            tick: Some(0),
        })
    }

    /// The command that starts the node; `None` if the node runs already.
    pub(super) fn command(&self, args: &PlayArgs, role: Option<&Role>) -> Result<Option<Command>> {
        let mut command = match (role, &args.command[..]) {
            (None, []) => return Ok(None),
            (None, [program, rest @ ..]) => {
                let mut command = Command::new(program);
                command.args(rest);
                command
            }
            (Some(role), _) => {
                let mut command = Command::new(std::env::current_exe()?);
                // A parameter that the node has not would change nothing, and the outputs would be equal.
                command.env(STRICT_PARAMETERS, "1");
                command.args(["node", role.node, "--ros-args", "--log-level", "warn", "-r"]);
                command.arg(format!("__ns:={}", self.namespace));
                let of_flight = || {
                    let folder = args.bag.canonicalize().ok()?;
                    let run = RunFolder::open(folder.parent()?).ok()?;
                    Some(run.parameter_file())
                };
                if let Some(file) = args.params_file.clone().or_else(of_flight) {
                    command.arg("--params-file").arg(file);
                }
                for parameter in args
                    .parameters
                    .iter()
                    .map(String::as_str)
                    .chain([role.parameter])
                {
                    command.args(["-p", parameter]);
                }
                command
            }
        };
        command
            .env(LAUNCHED, "1")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .process_group(0);
        Ok(Some(command))
    }
}

/// A child process that is ended with the run.
pub(super) struct Started(pub(super) Child);

impl Started {
    pub(super) fn check(&mut self) -> Result<()> {
        match self.0.try_wait()? {
            Some(status) => bail!("the node stopped by itself ({status})"),
            None => Ok(()),
        }
    }
}

impl Drop for Started {
    fn drop(&mut self) {
        let pid = i32::try_from(self.0.id()).ok().and_then(Pid::from_raw);
        if let Some(pid) = pid {
            // It may have ended already.
            let _ = kill_process(pid, Signal::TERM);
        }
        let deadline = Instant::now() + Duration::from_secs(10);
        while Instant::now() < deadline {
            if !matches!(self.0.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A decoder of the stamps of a topic's messages.
pub(super) fn stamps_of(bag: &BagReader, topic: &Topic) -> Option<StampDecoder> {
    stamp_decoder(&types(bag, topic).ok()?)
}
