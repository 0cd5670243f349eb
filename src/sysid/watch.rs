//! `planesman sysid watch`: the estimates of a running identifier, live in the terminal.

use anyhow::Result;
use clap::Parser;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_node::{Connections, Direction, Flow, NodeSpec, Qos, Runtime, args};
use sysid::{DRAW, Screen};

/// Watch the estimates of a running identifier.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid watch")]
pub struct WatchArgs {
    /// ROS arguments: --ros-args -r __ns:=/auv -r model:=/other/model
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    ros: Vec<String>,
}

enum Event {
    Model(Box<ModelEstimate>),
    Draw,
    Parameters,
}

/// Runs the command until it is asked to stop.
///
/// # Errors
/// One line for the terminal: an argument that is refused, middleware that does not come up.
pub(super) fn run(watch: &WatchArgs) -> Result<()> {
    let mut screen = Screen::new();
    let mut arguments = args::only(watch.ros.clone())?;
    arguments.console &= !screen.is_drawn();
    let (rt, ()) = Runtime::start(
        NodeSpec {
            name: "sysid_watch",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Event::Parameters,
        },
        arguments,
    )?;
    rt.subscribe("model", Qos::reliable(100), |model| {
        Event::Model(Box::new(model))
    })?;
    let _drawings = rt.every(DRAW, || Event::Draw);
    rt.run(|rt, event| {
        match event {
            Event::Model(model) => screen.take(&model),
            Event::Draw => screen.draw(&heading(&rt.connections())),
            Event::Parameters => {}
        }
        Ok(Flow::Continue)
    })
}

/// The publishers of the models.
fn heading(connections: &Connections) -> String {
    let models = |c: &&planesman_node::Connection| c.direction == Direction::Subscription;
    connections
        .list
        .iter()
        .find(models)
        .map_or_else(String::new, |it| {
            let refused = match it.refused {
                0 => String::new(),
                refused => format!(", {refused} refused"),
            };
            let publishers = match it.peers {
                1 => "1 publisher".to_owned(),
                peers => format!("{peers} publishers"),
            };
            format!(
                "{}: {publishers}, {} estimates{refused}",
                it.topic, it.messages
            )
        })
}
