//! ROS names: expands `~`, `{node}` and relative names, checks and remaps them.
//!
//! The rules are those of "Topic and Service name mapping to DDS" and "Static Remapping" on design.ros2.org, as implemented by `rcl`: a name is
//! expanded, then replaced by the first rule whose expanded left side equals the name.

use crate::{
    args::{Remap, RemapKind},
    bad_argument::BadArgument,
    name_rules::{check, check_namespace, is_token},
};

/// A node's name and namespace after remapping.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeNames {
    /// Name without namespace, such as `plant_sim`.
    pub name: String,
    /// Namespace, such as `/auv`; begins with `/` and ends without it, except `/` itself.
    pub namespace: String,
}

impl NodeNames {
    /// Applies the `__node` and `__ns` rules to the names given in the program.
    ///
    /// # Errors
    /// A name or namespace that violates the ROS rules.
    pub fn remapped(name: &str, namespace: &str, rules: &[Remap]) -> Result<Self, BadArgument> {
        let rule = |kind| {
            rules
                .iter()
                .find(|r| r.kind == kind && r.node.as_deref().is_none_or(|n| n == name))
                .map(|r| r.to.as_str())
        };
        let namespace = rule(RemapKind::Namespace).unwrap_or(namespace);
        let name = rule(RemapKind::Node).unwrap_or(name);
        if !is_token(name) {
            return Err(BadArgument::new(name, "not a valid node name"));
        }
        let namespace = format!("/{}", namespace.trim_matches('/'));
        check_namespace(&namespace)?;
        Ok(Self {
            name: name.to_owned(),
            namespace,
        })
    }

    /// The fully qualified name: `/auv/plant_sim`.
    #[must_use]
    pub fn full(&self) -> String {
        join(&self.namespace, &self.name)
    }

    /// Name of the logger: the full name with dots, such as `auv.plant_sim`.
    #[must_use]
    pub fn logger(&self) -> String {
        self.full().trim_start_matches('/').replace('/', ".")
    }

    /// Absolute name of `name` in this node, before remapping.
    ///
    /// # Errors
    /// The result violates the ROS rules for names.
    pub fn expand(&self, name: &str) -> Result<String, BadArgument> {
        let namespace = self.namespace.trim_start_matches('/');
        let filled = name
            .replace("{node}", &self.name)
            .replace("{namespace}", namespace)
            .replace("{ns}", namespace);
        let absolute = if filled.starts_with('/') {
            filled
        } else if filled == "~" {
            self.full()
        } else if let Some(rest) = filled.strip_prefix("~/") {
            join(&self.full(), rest)
        } else {
            join(&self.namespace, &filled)
        };
        check(&absolute).map_err(|e| BadArgument::new(name, &e.reason))?;
        Ok(absolute)
    }

    /// Absolute name of a topic or service, after remapping.
    ///
    /// # Errors
    /// The name, or the applied rule, violates the ROS rules for names.
    pub fn resolve(
        &self,
        name: &str,
        kind: RemapKind,
        rules: &[Remap],
    ) -> Result<String, BadArgument> {
        let expanded = self.expand(name)?;
        for rule in rules {
            let applies = rule.kind == kind || rule.kind == RemapKind::TopicOrService;
            let ours = rule.node.as_deref().is_none_or(|node| node == self.name);
            if applies && ours && self.expand(&rule.from)? == expanded {
                return self.expand(&rule.to);
            }
        }
        Ok(expanded)
    }
}

/// Joins `parent` and `child` with one slash.
fn join(parent: &str, child: &str) -> String {
    format!("{}/{child}", parent.trim_end_matches('/'))
}

/// DDS topic of a service's requests.
pub(crate) fn requests_topic(service: &str) -> String {
    format!("rq{service}Request")
}

/// DDS topic of a service's answers.
pub(crate) fn replies_topic(service: &str) -> String {
    format!("rr{service}Reply")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant() -> NodeNames {
        NodeNames::remapped("plant_sim", "/auv", &[]).expect("good names")
    }

    fn rule(text: &str) -> Remap {
        text.parse().expect("good rule")
    }

    #[test]
    fn names_expand_as_rcl_expands_them() {
        for (name, expanded) in [
            ("state", "/auv/state"),
            ("/tf", "/tf"),
            ("~/pause", "/auv/plant_sim/pause"),
            ("~", "/auv/plant_sim"),
            ("{node}/x", "/auv/plant_sim/x"),
            ("/{ns}/x", "/auv/x"),
        ] {
            assert_eq!(plant().expand(name).expect(name), expanded);
        }
        for name in ["", "a//b", "2x", "a__b", "~x", "{who}/a", "a/", "å"] {
            assert!(plant().expand(name).is_err(), "{name}");
        }
    }

    #[test]
    fn a_remap_replaces_the_whole_name_it_names_and_the_first_rule_wins() {
        let rules = [
            rule("state:=truth/state"),
            rule("/auv/state:=/never"),
            rule("other_node:imu:=/never"),
            rule("plant_sim:imu:=/sensors/imu"),
            rule("rosservice://odom:=/never"),
        ];
        let topic = |name| plant().resolve(name, RemapKind::Topic, &rules);
        assert_eq!(topic("state"), Ok("/auv/truth/state".to_owned()));
        assert_eq!(topic("imu"), Ok("/sensors/imu".to_owned()));
        assert_eq!(topic("odom"), Ok("/auv/odom".to_owned()));
    }

    #[test]
    fn node_and_namespace_are_remapped_too() {
        let names = NodeNames::remapped(
            "plant_sim",
            "/auv",
            &[rule("__ns:=/twin/"), rule("__node:=plant_2")],
        )
        .expect("good names");
        assert_eq!(names.full(), "/twin/plant_2");
        assert_eq!(names.logger(), "twin.plant_2");
        let root = NodeNames::remapped("plant_sim", "/", &[]).expect("good names");
        assert_eq!(root.full(), "/plant_sim");
        assert_eq!(root.expand("state").expect("good name"), "/state");
        assert!(NodeNames::remapped("plant sim", "/", &[]).is_err());
    }
}
