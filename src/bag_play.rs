//! `planesman bag play --lockstep --through NODE`: plays a bag's inputs through one node, tick by tick, and compares its outputs with the recorded
//! outputs.
//!
//! The inputs with one stamp are published in the recorded order; inputs with the next stamp only after the node has answered. So the result does not
//! depend on the speed of the machine. `/clock` gives the time.

mod plan;
mod player;

use anyhow::{Context, Result, anyhow, bail};
use planesman_bag::{BagReader, BagWriter, Topic, WriterOptions};
use planesman_node::{NodeSpec, Runtime, args};
use planesman_show::diff::{Options, diff};

use crate::arguments::{default_file, make_way};
use crate::bag_command::print;
use plan::{Event, Plan, PlannedOutput, Role, Started};
use player::Player;

pub use plan::PlayArgs;

/// Plays the bag and prints the comparison. Returns whether the outputs equal the recorded outputs.
///
/// # Errors
/// A bag that lacks the inputs or outputs, a node that does not start or answer, a file that cannot be written.
pub fn run(args: &PlayArgs) -> Result<bool> {
    let bag = BagReader::open(&args.bag)?;
    let role = args.through.role();
    let plan = Plan::of(args, role.as_ref(), &bag)?;
    let out = match &args.out {
        Some(path) => path.clone(),
        None => {
            let name = format!("{}.mcap", args.through.name());
            default_file(&name).map_err(|reason| anyhow!("{name}: {reason} with --out"))?
        }
    };
    let options = WriterOptions {
        flush_interval: None,
        ..WriterOptions::default()
    };
    if out.is_file() && out.extension().is_none_or(|it| it != "mcap") {
        bail!(
            "'{}' exists already and is not an *.mcap bag. Name another file",
            out.display()
        );
    }
    make_way(&out)?;
    let writer = BagWriter::create_file(&out, options)?;
    let ticks = record(&plan, role.as_ref(), &bag, args, writer).inspect_err(|_| {
        // Half a recording is of no use, and would be in the way of the next one.
        let _ = std::fs::remove_file(&out);
    })?;
    planesman_console::out!(
        "{ticks} ticks played.\n{}",
        planesman_console::file_line("Bag", &out)
    )?;
    let (recorded, new): (Vec<_>, Vec<_>) =
        plan.outputs.iter().partition(|it| it.recorded().is_some());
    let names = |of: &[&PlannedOutput]| -> Vec<String> {
        of.iter().map(|it| it.name().to_owned()).collect()
    };
    if !new.is_empty() {
        planesman_console::out!(
            "{}: not in {}, so no comparison is possible. Play again with another --out, then: planesman bag diff {} OTHER.mcap",
            names(&new).join(", "),
            args.bag.display(),
            out.display()
        )?;
    }
    if recorded.is_empty() {
        return Ok(true);
    }
    let options = Options {
        only: names(&recorded),
        ..args.rules.options(&[])
    };
    let found = diff(&args.bag, &out, &options)?;
    print(&found, None)?;
    Ok(found.is_equal())
}

/// Records the node's answers. Returns the number of ticks.
fn record(
    plan: &Plan,
    role: Option<&Role>,
    bag: &BagReader,
    args: &PlayArgs,
    writer: BagWriter,
) -> Result<u64> {
    let (rt, ()) = Runtime::start(
        NodeSpec {
            name: "player",
            namespace: "/",
            validate: |(): &()| Ok(()),
            on_parameters: |()| Event::Parameters,
        },
        args::only(["--ros-args", "--log-level", "warn"].map(str::to_owned))?,
    )?;
    let mut child = match plan.command(args, role)? {
        Some(mut command) => Some(Started(command.spawn().context("cannot start the node")?)),
        None => None,
    };
    let topic = |it: &PlannedOutput| it.topic(&rt, child.as_mut());
    let outputs: Vec<Topic> = plan.outputs.iter().map(topic).collect::<Result<_>>()?;
    let mut player = Player::new(rt, plan, outputs, bag, args, writer)?;
    player.wait_for_node(child.as_mut())?;
    let ticks = player.play(bag, child.as_mut())?;
    drop(child);
    player.finish()?;
    Ok(ticks)
}
