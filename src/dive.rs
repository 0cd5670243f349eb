//! `planesman dive`: a scenario flown by separate processes over DDS.
//!
//! The launcher is itself a node. The launcher reads all diagnostics until every node has discovered the others, releases the vehicle, shows the
//! progress, and stops the nodes in an order that loses no message: publishers first, the recorder last.

mod launcher;
mod options;

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use planesman_console::print_wrapped;
use planesman_flight::nodes::NODES;
use planesman_flight::scenario::Scenario;
use planesman_flight::sink::full_name;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticArray;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_msgs::std_srvs::srv::SetBool;
use planesman_node::claim::{Claim, Stage};
use planesman_node::{Client, Direction, Domain, Next, NodeSpec, Qos, Runtime, args, shutdown};
use planesman_parameters::Value;

use crate::processes::Processes;
use crate::run_folder::{Loss, RunFolder};
use launcher::{Event, LaunchedNode, Launcher};
use options::yield_to_other_dive;

pub use options::{Options, Pace};

/// Time to detect another loop. A peer is found within 0.2 s, even one that starts at the same moment.
const LISTEN_TIME: Duration = Duration::from_millis(500);
/// Time until killed nodes are forgotten: their DDS lease of 5 s, with a margin.
const LEASE_TIME: Duration = Duration::from_secs(7);

/// Flies `scenario` into the folder `run` and prints the summary. Returns the published messages that are missing in the bag.
///
/// # Errors
/// A node cannot start, does not discover the others, or fails in flight.
pub fn run(scenario: &Scenario, run: &RunFolder, options: &Options) -> Result<Option<Loss>> {
    let extra = extra(run, options);
    launcher_decides(scenario, &extra)?;
    let parameters =
        scenario.parameter_file(&options.namespace, &extra, options.pace.owns_time())?;
    let namespace = format!("__ns:={}", options.namespace);
    let (rt, ()) = Runtime::start(
        NodeSpec {
            name: "planesman",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Event::Poll,
        },
        args::only(["--ros-args", "-r", &namespace, "--log-level", "warn"].map(str::to_owned))?,
    )?;
    // Nobody else ends the dive by telling of its nodes.
    let own = NODES.map(|node| full_name(&options.namespace, node));
    let vehicle = vec![full_name(&options.namespace, "plant_sim")];
    rt.subscribe_to_speakers(
        "/diagnostics",
        Qos::reliable(1000),
        move |array: &DiagnosticArray| {
            let is_told = |node: &&String| {
                let mut told = array.status.iter().map(|it| it.name.split_once(": "));
                told.any(|it| it.is_some_and(|(name, _)| name == node.as_str()))
            };
            own.iter().filter(is_told).cloned().collect()
        },
        Event::Diagnostics,
    )?;
    rt.subscribe_to_speakers(
        "state",
        Qos::reliable(1000),
        move |_: &VehicleState| vehicle.clone(),
        Event::State,
    )?;
    rt.subscribe("model", Qos::reliable(1000).of_one_publisher(), |model| {
        Event::Model(Box::new(model))
    })?;
    let go = rt.client::<SetBool>("plant_sim/pause")?;
    let parameters_of = |node: &'static str| {
        Ok(LaunchedNode {
            node,
            parameters: scenario.launched_values(node, &extra)?,
            get: rt.client(&format!("{node}/get_parameters"))?,
        })
    };
    let launched = NODES.into_iter().map(parameters_of);
    let launched = launched.collect::<Result<Vec<_>>>()?;
    if options.verbose {
        print_wrapped(format_args!("{}\n", scenario.description()))?;
    }
    let claim = claim_namespace(&rt, options)?;
    // All that can be refused has been: now there is something to keep.
    run.create(scenario, &parameters)?;
    if options.keep_running {
        planesman_console::out!(
            "{}",
            other_terminal(Domain::from_environment()?, &options.namespace)
        )?;
    }
    fly(rt, go, launched, claim, scenario, run, options)
        .inspect_err(|error| run.note_failure(error))
}

/// Starts the nodes and flies them to the end.
fn fly(
    rt: Runtime<Event>,
    go: Client<SetBool>,
    launched: Vec<LaunchedNode>,
    claim: Claim,
    scenario: &Scenario,
    run: &RunFolder,
    options: &Options,
) -> Result<Option<Loss>> {
    let mut processes = Processes::start(run, &options.namespace, &NODES)?;
    if options.watch {
        processes.show()?;
    }
    drop(rt.every(Duration::from_millis(20), || Event::Poll));
    let mut launcher = Launcher::new(scenario, options, processes, go, (launched, claim));
    let flown = launcher.command(&rt);
    launcher.bar.finish_and_clear();
    let flown = flown.and(rt.shutdown().map_err(Into::into));
    let stopped = launcher.processes.stop();
    // The bag is closed. A report can be made again, with `planesman report`.
    shutdown::at_once();
    if let Err(error) = flown.and(stopped).and_then(|()| launcher.check_flown()) {
        // What was flown is worth a report; that it cannot be made must not hide the error.
        if launcher.ticks > 0
            && let Ok(report) = run.report(scenario.clone(), &options.scenario, options.verbose)
        {
            report.print()?;
        }
        return Err(error);
    }
    if launcher.interrupted {
        planesman_console::out!(
            "Interrupted after {} ticks; the bag is closed.",
            launcher.ticks
        )?;
    } else if options.verbose {
        planesman_console::out!(
            "Flew {:.1} s of vehicle time in {:.1} s of wall-clock time, with {} processes over DDS.\n",
            launcher.ticks as f64 * scenario.tick,
            launcher.flown.as_secs_f64(),
            NODES.len() + 1,
        )?;
    }
    let report = run.report(scenario.clone(), &options.scenario, options.verbose)?;
    report.print()?;
    run.loss(scenario)
}

/// Commands for a second terminal to look into the running loop.
fn other_terminal(domain: Domain, namespace: &str) -> String {
    let range = if domain.local { "LOCALHOST" } else { "SUBNET" };
    let namespace = namespace.trim_end_matches('/');
    format!(
        "In another terminal (Ctrl-C here ends the loop):\n\
         \x20 export ROS_DOMAIN_ID={} ROS_AUTOMATIC_DISCOVERY_RANGE={range}\n\
         \x20 ros2 topic list\n\
         \x20 ros2 topic echo {namespace}/state\n\
         \x20 planesman watch\n",
        domain.id
    )
}

/// Waits until no other loop runs in the namespace: its vehicle would also get the nodes' answers. Returns the claim to the namespace.
fn claim_namespace(rt: &Runtime<Event>, options: &Options) -> Result<Claim> {
    // Who launches calls the vehicle's service.
    let evidence = format!("rq{}/plant_sim/pauseRequest", options.namespace);
    let claim = rt.claim(&format!("launch {}", options.namespace), &evidence)?;
    find_no_other_loop(rt, || yield_to_other_dive(&claim, options))?;
    claim.advance_to(Stage::Held);
    Ok(claim)
}

/// Listens for publishers of the topics that the node reads and for all diagnostics; runs `check` meanwhile.
///
/// # Errors
/// Another loop runs, `check` fails, or the process is asked to stop.
pub(crate) fn find_no_other_loop<E: 'static>(
    rt: &Runtime<E>,
    check: impl Fn() -> Result<()>,
) -> Result<()> {
    let began = Instant::now();
    loop {
        if matches!(rt.next(Duration::from_millis(50)), Next::Stop) {
            bail!("interrupted");
        }
        check()?;
        let connections = rt.connections();
        let taken = connections.list.iter().find(|end| {
            end.direction == Direction::Subscription && end.topic != "/diagnostics" && end.peers > 0
        });
        match taken {
            None if began.elapsed() > LISTEN_TIME => return Ok(()),
            Some(end) if began.elapsed() > LEASE_TIME => bail!(
                "{} has a publisher already: is another loop running? Stop that loop, or choose \
                 another ROS_DOMAIN_ID or --namespace",
                end.topic
            ),
            _ => {}
        }
    }
}

/// Parameters that the launcher sets: node, name, value.
fn extra(run: &RunFolder, options: &Options) -> Vec<(&'static str, &'static str, Value)> {
    let lockstep = options.pace == Pace::Lockstep;
    let mut extra: Vec<(&str, &str, Value)> = vec![
        (
            "recorder",
            "output",
            run.bag().to_string_lossy().as_ref().into(),
        ),
        ("recorder", "answer", lockstep.into()),
        ("sysid", "answer", lockstep.into()),
        ("dha_actuator", "lockstep", lockstep.into()),
        ("depth_controller", "lockstep", lockstep.into()),
        ("recorder", "reliable_sensors", true.into()),
        ("plant_sim", "reliable_sensors", true.into()),
        ("plant_sim", "start_paused", true.into()),
    ];
    match options.pace {
        Pace::Lockstep => {
            extra.push(("plant_sim", "time", "lockstep".into()));
            let members: &[&str] = &["sysid", "recorder"];
            extra.push(("plant_sim", "lockstep.members", members.into()));
        }
        Pace::Real { factor, sim_time } => {
            extra.push(("plant_sim", "time", "real".into()));
            extra.push(("plant_sim", "factor", factor.into()));
            extra.push(("plant_sim", "sim_time", sim_time.into()));
        }
    }
    if options.keep_running {
        extra.push(("plant_sim", "duration", 0.0.into()));
    }
    extra
}

/// Refuses a scenario that sets one of the launcher's parameters to another value; the launcher would override it.
fn launcher_decides(scenario: &Scenario, extra: &[(&str, &str, Value)]) -> Result<()> {
    let of_pace = ["time", "factor", "sim_time"].map(|name| ("plant_sim", name));
    for (node, name) in extra.iter().map(|it| (it.0, it.1)).chain(of_pace) {
        let decided = extra.iter().find(|it| (it.0, it.1) == (node, name));
        let given = scenario.given(node, name);
        if given.is_some_and(|given| decided.is_none_or(|it| it.2 != *given)) {
            bail!(
                "{node}.{name} is set by the options of `planesman dive` (--sim-time, --factor, --lockstep, --out). Remove it from the scenario"
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_for_another_terminal_name_domain_range_and_topic() {
        let domain = Domain { id: 7, local: true };
        let lines = other_terminal(domain, "/second");
        for part in [
            "export ROS_DOMAIN_ID=7 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST",
            "ros2 topic echo /second/state",
            "planesman watch",
        ] {
            assert!(lines.contains(part), "{lines}");
        }
    }
}
