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
    /// The namespace of the identifier's topics [default: /auv]
    #[arg(long)]
    namespace: Option<String>,
    /// ROS arguments: --ros-args -r __ns:=/auv -r model:=/other/model
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    ros: Vec<String>,
}

impl WatchArgs {
    /// ROS's arguments, the namespace among them if one is given.
    fn ros_arguments(&self) -> Vec<String> {
        let namespace = self.namespace.iter().flat_map(|namespace| {
            let remap = format!("__ns:={namespace}");
            [
                "--ros-args".to_owned(),
                "-r".to_owned(),
                remap,
                "--".to_owned(),
            ]
        });
        namespace.chain(self.ros.iter().cloned()).collect()
    }
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
    let mut arguments = args::only(watch.ros_arguments())?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_node::RosArguments;

    #[test]
    fn a_namespace_is_that_of_the_ros_argument() {
        let read = |arguments: &[&str]| -> RosArguments {
            let watch = WatchArgs::try_parse_from(arguments).expect("a command line");
            args::only(watch.ros_arguments()).expect("ROS's arguments")
        };
        let remaps = read(&["watch", "--namespace", "/second"]).remaps;
        let ros = read(&["watch", "--", "--ros-args", "-r", "__ns:=/second"]).remaps;
        assert_eq!(remaps, ros);
        assert_eq!(remaps.len(), 1);
        assert!(read(&["watch"]).remaps.is_empty());
    }
}
