//! ROS 2 parameter files: node name patterns over `ros__parameters`, nested names.

use planesman_text::yaml;
use serde_yaml_ng::Value as Yaml;

use crate::{Refusal, Value};

pub use planesman_text::{LARGEST, read};

/// The parameters that a ROS 2 parameter file sets for the node `full_name` (`/auv/plant_sim`), in order of priority, highest last. Keys may be
/// the full name, the bare name, `/**`, `/*/name`, or namespaces as nested mappings.
///
/// # Errors
/// A [`Refusal`] if the text is not a YAML mapping of that form or a value has no ROS type.
pub fn overrides_for(text: &str, full_name: &str) -> Result<Vec<(String, Value)>, Refusal> {
    let bad = |reason: String| Refusal {
        name: String::new(),
        reason,
    };
    let yaml: Yaml = yaml::from_str(text).map_err(|e| bad(format!("not YAML: {e}")))?;
    let mut found = Vec::new();
    walk(&yaml, "", full_name, &mut found)?;
    Ok(found)
}

/// Parses a value of `-p name:=VALUE`: a YAML scalar or list.
///
/// # Errors
/// A [`Refusal`] if the text is not a YAML value of a ROS type.
pub fn parse_value(name: &str, text: &str) -> Result<Value, Refusal> {
    let yaml: Yaml = yaml::from_str(text).map_err(|e| Refusal {
        name: name.to_owned(),
        reason: format!("'{text}' is not YAML: {e}"),
    })?;
    from_yaml(name, &yaml)
}

/// The parameters in a YAML mapping; names of nested mappings are joined with dots.
///
/// # Errors
/// A [`Refusal`] if a value has no ROS type.
pub fn flatten(yaml: &Yaml) -> Result<Vec<(String, Value)>, Refusal> {
    let mut found = Vec::new();
    flatten_into("", yaml, &mut found)?;
    Ok(found)
}

fn walk(
    yaml: &Yaml,
    path: &str,
    full_name: &str,
    found: &mut Vec<(String, Value)>,
) -> Result<(), Refusal> {
    let refuse = |reason: &str| Refusal {
        name: String::new(),
        reason: reason.to_owned(),
    };
    let Yaml::Mapping(map) = yaml else {
        return Err(refuse("a mapping of node names is expected"));
    };
    for (key, value) in map {
        let Yaml::String(key) = key else {
            return Err(refuse("a node name must be text"));
        };
        if key == "ros__parameters" {
            if matches(path, full_name) {
                flatten_into("", value, found)?;
            }
        } else {
            walk(
                value,
                &format!("{}/{}", path, key.trim_start_matches('/')),
                full_name,
                found,
            )?;
        }
    }
    Ok(())
}

/// Whether the pattern matches the node: `**` matches any number of tokens, `*` one; a bare name matches in any namespace.
fn matches(pattern: &str, full_name: &str) -> bool {
    fn tokens_match(pattern: &[&str], name: &[&str]) -> bool {
        match (pattern.split_first(), name.split_first()) {
            (None, None) => true,
            (Some((&"**", rest)), _) => {
                tokens_match(rest, name)
                    || name
                        .split_first()
                        .is_some_and(|(_, tail)| tokens_match(pattern, tail))
            }
            (Some((p, rest)), Some((n, tail))) => (*p == "*" || p == n) && tokens_match(rest, tail),
            _ => false,
        }
    }
    let pattern: Vec<&str> = pattern.split('/').filter(|t| !t.is_empty()).collect();
    let name: Vec<&str> = full_name.split('/').filter(|t| !t.is_empty()).collect();
    tokens_match(&pattern, &name) || (pattern.len() == 1 && name.last() == pattern.first())
}

fn flatten_into(
    prefix: &str,
    yaml: &Yaml,
    found: &mut Vec<(String, Value)>,
) -> Result<(), Refusal> {
    match yaml {
        Yaml::Null if prefix.is_empty() => Ok(()),
        Yaml::Mapping(map) => {
            for (key, value) in map {
                let Yaml::String(key) = key else {
                    return Err(Refusal {
                        name: prefix.to_owned(),
                        reason: "a parameter name must be text".to_owned(),
                    });
                };
                let name = if prefix.is_empty() {
                    key.clone()
                } else {
                    format!("{prefix}.{key}")
                };
                flatten_into(&name, value, found)?;
            }
            Ok(())
        }
        value => {
            found.push((prefix.to_owned(), from_yaml(prefix, value)?));
            Ok(())
        }
    }
}

fn from_yaml(name: &str, yaml: &Yaml) -> Result<Value, Refusal> {
    let refuse = |reason: &str| Refusal {
        name: name.to_owned(),
        reason: reason.to_owned(),
    };
    match yaml {
        Yaml::Bool(b) => Ok(Value::Bool(*b)),
        Yaml::Number(n) => match n.as_i64() {
            Some(i) => Ok(Value::Integer(i)),
            None if n.is_f64() => Ok(Value::Double(n.as_f64().unwrap_or(f64::NAN))),
            None => Err(refuse("the integer does not fit in 64 bits")),
        },
        Yaml::String(s) => Ok(Value::String(s.clone())),
        Yaml::Sequence(items) => {
            let items: Vec<Value> = items
                .iter()
                .map(|i| from_yaml(name, i))
                .collect::<Result<_, _>>()?;
            list(items).ok_or_else(|| refuse("all values of a list must have the same simple type"))
        }
        _ => Err(refuse(
            "a boolean, number, text or list of one of these is expected",
        )),
    }
}

fn list(items: Vec<Value>) -> Option<Value> {
    let any_double = items.iter().any(|v| matches!(v, Value::Double(_)));
    match items.first() {
        None => Some(Value::StringArray(Vec::new())),
        Some(Value::Bool(_)) => items
            .into_iter()
            .map(|v| {
                if let Value::Bool(b) = v {
                    Some(b)
                } else {
                    None
                }
            })
            .collect::<Option<_>>()
            .map(Value::BoolArray),
        Some(Value::String(_)) => items
            .into_iter()
            .map(|v| {
                if let Value::String(s) = v {
                    Some(s)
                } else {
                    None
                }
            })
            .collect::<Option<_>>()
            .map(Value::StringArray),
        Some(Value::Integer(_) | Value::Double(_)) if any_double => items
            .into_iter()
            .map(|v| match v {
                Value::Double(d) => Some(d),
                Value::Integer(i) => Some(i as f64),
                _ => None,
            })
            .collect::<Option<_>>()
            .map(Value::DoubleArray),
        Some(Value::Integer(_)) => items
            .into_iter()
            .map(|v| {
                if let Value::Integer(i) = v {
                    Some(i)
                } else {
                    None
                }
            })
            .collect::<Option<_>>()
            .map(Value::IntegerArray),
        Some(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "
/**:
  ros__parameters: {use_sim_time: true}
/auv/depth_controller:
  ros__parameters:
    depth: {kp: 0.5, kd: 1}
    peers: [a, b]
plant_sim:
  ros__parameters: {speed: 1.0}
auv:
  sysid:
    ros__parameters: {order: 3}
";

    #[test]
    fn a_node_gets_the_entries_whose_pattern_names_it() {
        let controller = overrides_for(FILE, "/auv/depth_controller").expect("read");
        assert_eq!(
            controller,
            vec![
                ("use_sim_time".to_owned(), Value::Bool(true)),
                ("depth.kp".to_owned(), Value::Double(0.5)),
                ("depth.kd".to_owned(), Value::Integer(1)),
                (
                    "peers".to_owned(),
                    Value::StringArray(vec!["a".into(), "b".into()])
                ),
            ]
        );
        assert_eq!(
            overrides_for(FILE, "/auv/plant_sim").expect("read").len(),
            2
        );
        assert_eq!(overrides_for(FILE, "/auv/sysid").expect("read").len(), 2);
        assert_eq!(overrides_for(FILE, "/other/sysid").expect("read").len(), 1);
    }

    #[test]
    fn what_is_not_a_parameter_file_is_refused() {
        for text in [
            "[1, 2]",
            "a: 3",
            "{a: {ros__parameters: {b: [1, x]}}}",
            ": :",
        ] {
            assert!(overrides_for(text, "/a").is_err(), "{text}");
        }
    }
}
