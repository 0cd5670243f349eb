//! Parameters such as `qos_overrides.TOPIC.publisher.reliability`, set at the start: with these a user chooses the quality of service of a topic, the
//! same as in rclcpp and rclpy.
//!
//! | policy | values |
//! |---|---|
//! | `reliability` | `reliable`, `best_effort` |
//! | `durability` | `volatile`, `transient_local` |
//! | `history` | `keep_last` |
//! | `depth` | 1 to 10000 |

use std::{collections::BTreeSet, rc::Rc};

use planesman_parameters::{Declaration, Value, Values};

use planesman_text::did_you_mean;

use crate::{
    endpoint::{Direction, Endpoint},
    qos::Qos,
};

const PREFIX: &str = "qos_overrides.";

const POLICIES: [(&str, &[&str]); 4] = [
    ("reliability", &["reliable", "best_effort"]),
    ("durability", &["volatile", "transient_local"]),
    ("history", &["keep_last"]),
    ("depth", &[]),
];

/// Declaration of the parameter `name`; `None` if it is not such a parameter.
pub(crate) fn declaration(name: &str) -> Option<Declaration> {
    let (topic, end) = name.strip_prefix(PREFIX)?.split_once('.')?;
    let (end, policy) = end.split_once('.')?;
    let (_, choices) = POLICIES.iter().find(|(known, _)| *known == policy)?;
    let is_one = topic.starts_with('/') && ["publisher", "subscription"].contains(&end);
    is_one.then(|| Declaration {
        name: name.to_owned(),
        default: match choices.first() {
            Some(first) => Value::String((*first).to_owned()),
            None => Value::Integer(10),
        },
        description: "Quality of service of a topic",
        unit: "",
        positive: "",
        range: choices.is_empty().then_some((1.0, 10_000.0)),
        choices,
        read_only: true,
    })
}

/// An endpoint in these parameters' names: `/auv/imu.publisher`.
pub(crate) fn end(direction: Direction, topic: &str) -> String {
    let end = match direction {
        Direction::Publisher => "publisher",
        Direction::Subscription => "subscription",
    };
    format!("{topic}.{end}")
}

/// Topics opened by the runtime itself.
const OF_EVERY_NODE: [&str; 4] = ["/clock", "/diagnostics", "/parameter_events", "/rosout"];

/// Warns about each such parameter whose topic or direction the node does not use.
pub(crate) fn warn_of_unused(values: &Values, endpoints: &[Rc<Endpoint>]) {
    let ends = endpoints.iter().map(|it| end(it.direction, &it.topic));
    for warning in unused(values, &ends.collect()) {
        log::warn!("{warning}");
    }
}

fn unused(values: &Values, ends: &BTreeSet<String>) -> Vec<String> {
    let names = values.declarations().iter().map(|it| &it.name);
    let warning = |name: &String| {
        let (end, _) = name.strip_prefix(PREFIX)?.rsplit_once('.')?;
        let (topic, direction) = end.rsplit_once('.')?;
        let is_used = ends.contains(end) || OF_EVERY_NODE.contains(&topic);
        let meant = did_you_mean(end, ends.iter().map(String::as_str));
        (!is_used).then(|| {
            format!(
                "parameter '{name}' has no effect: the node has no {direction} on '{topic}'{meant}"
            )
        })
    };
    names.filter_map(warning).collect()
}

/// The QoS of the topic (absolute name), with the overrides among the values.
pub(crate) fn applied(values: &Values, direction: Direction, topic: &str, qos: Qos) -> Qos {
    let end = end(direction, topic);
    let given = |policy| values.get(&format!("{PREFIX}{end}.{policy}"));
    let is = |policy, word: &str, own| match given(policy) {
        Some(Value::String(given)) => given == word,
        _ => own,
    };
    let depth = match given("depth") {
        Some(Value::Integer(depth)) => usize::try_from(*depth).unwrap_or(qos.depth()),
        _ => qos.depth(),
    };
    qos.with(
        is("reliability", "reliable", qos.is_reliable()),
        is("durability", "transient_local", qos.is_latched()),
        depth,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topics_quality_of_service_is_what_the_parameters_say() {
        let declared = |name: &str| declaration(name).is_some();
        assert!(declared("qos_overrides./auv/imu.publisher.depth"));
        for name in [
            "qos_overrides./auv/imu.publisher.lifespan",
            "qos_overrides./auv/imu.reader.depth",
            "qos_overrides.imu.publisher.depth",
            "qos_overrides./auv/imu",
            "depth.p",
        ] {
            assert!(!declared(name), "{name}");
        }
        let given = [
            (
                "qos_overrides./auv/imu.publisher.reliability",
                Value::from("reliable"),
            ),
            ("qos_overrides./auv/imu.publisher.depth", Value::Integer(50)),
            (
                "qos_overrides./auv/state.publisher.reliability",
                Value::from("best_effort"),
            ),
        ];
        let declarations = given.iter().filter_map(|(name, _)| declaration(name));
        let defaults = Values::defaults(declarations.collect());
        let changes = given.map(|(name, value)| (name.to_owned(), value));
        let values = defaults.with(changes).expect("as declared");
        let of = |direction, topic| applied(&values, direction, topic, Qos::sensor());
        assert_eq!(of(Direction::Publisher, "/auv/imu"), Qos::reliable(50));
        assert_eq!(of(Direction::Subscription, "/auv/imu"), Qos::sensor());
        assert_eq!(of(Direction::Publisher, "/auv/state"), Qos::sensor());
        let opened = ["/auv/imu.publisher", "/auv/state.subscription"].map(str::to_owned);
        assert_eq!(
            unused(&values, &opened.into()),
            [
                "parameter 'qos_overrides./auv/state.publisher.reliability' has no effect: the node has no publisher on '/auv/state'; did you mean '/auv/state.subscription'?"
            ]
        );
        let bad = [(
            "qos_overrides./auv/imu.publisher.depth".to_owned(),
            Value::Integer(0),
        )];
        assert!(defaults.with(bad).is_err());
    }
}
