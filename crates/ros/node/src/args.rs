//! ROS arguments: `--ros-args -r from:=to -p name:=value --params-file F --log-level L ... --`.
//!
//! The syntax follows `rcl` ("ROS Command Line Arguments", design.ros2.org). Arguments outside `--ros-args ... --` belong to the program and are
//! returned unchanged.

use std::path::PathBuf;
use std::{ffi::OsString, str::FromStr};

use log::LevelFilter;
use planesman_parameters::{Value, file};

pub use crate::bad_argument::BadArgument;
use crate::name_rules::check_namespace;

/// The target of a remapping rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemapKind {
    /// `__node:=name`
    Node,
    /// `__ns:=/namespace`
    Namespace,
    /// `rostopic://from:=to`
    Topic,
    /// `rosservice://from:=to`
    Service,
    /// `from:=to`
    TopicOrService,
}

/// One remapping rule, `[node:]from:=to`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remap {
    /// Node that the rule applies to; any node if `None`.
    pub node: Option<String>,
    /// Its target.
    pub kind: RemapKind,
    /// Name to replace, as written in the rule.
    pub from: String,
    /// The replacement, as written in the rule.
    pub to: String,
}

impl FromStr for Remap {
    type Err = BadArgument;

    fn from_str(text: &str) -> Result<Self, BadArgument> {
        let refuse = |reason| BadArgument::new(text, reason);
        let (left, to) = text
            .split_once(":=")
            .ok_or_else(|| refuse("from:=to is expected"))?;
        let (kind, left) = if let Some(rest) = left.strip_prefix("rostopic://") {
            (RemapKind::Topic, rest)
        } else if let Some(rest) = left.strip_prefix("rosservice://") {
            (RemapKind::Service, rest)
        } else {
            (RemapKind::TopicOrService, left)
        };
        let (node, from) = match left.split_once(':') {
            Some((node, from)) => (Some(node.to_owned()), from),
            None => (None, left),
        };
        if from.is_empty() || to.is_empty() {
            return Err(refuse("a side of from:=to is empty"));
        }
        let kind = match from {
            "__node" | "__name" => RemapKind::Node,
            "__ns" => RemapKind::Namespace,
            _ => kind,
        };
        Ok(Self {
            node,
            kind,
            from: from.to_owned(),
            to: to.to_owned(),
        })
    }
}

/// A source of parameter values; later sources have priority over earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterSource {
    /// `-p [node:]name:=value`
    Assignment {
        /// Node that the source applies to; any node if `None`.
        node: Option<String>,
        /// The parameter.
        name: String,
        /// Its value.
        value: Value,
    },
    /// `--params-file FILE`
    File(PathBuf),
}

/// The arguments between `--ros-args` and `--`.
#[derive(Clone, Debug, PartialEq)]
pub struct RosArguments {
    /// Remapping rules in the given order; the first that matches applies.
    pub remaps: Vec<Remap>,
    /// Parameter values in the given order; the last one has priority.
    pub parameters: Vec<ParameterSource>,
    /// `--log-level LEVEL`
    pub log_level: LevelFilter,
    /// `--log-level LOGGER:=LEVEL`
    pub logger_levels: Vec<(String, LevelFilter)>,
    /// Whether the log goes to `/rosout` (`--disable-rosout-logs`).
    pub rosout: bool,
    /// Whether the log goes to stderr (`--disable-stdout-logs`; in ROS it means the console).
    pub console: bool,
    /// Enclave with the node's keys and permissions under DDS Security (`--enclave /NAME`).
    pub enclave: String,
    /// Whether the log goes to files (`--enable-external-lib-logs`, `--disable-external-lib-logs`); `None` if not specified.
    pub log_files: Option<bool>,
    /// The beginning of the log file's name (`--log-file-name`).
    pub log_file_prefix: Option<String>,
    /// Warnings about arguments without effect here.
    pub ignored: Vec<String>,
}

impl Default for RosArguments {
    fn default() -> Self {
        Self {
            remaps: Vec::new(),
            parameters: Vec::new(),
            log_level: LevelFilter::Info,
            logger_levels: Vec::new(),
            rosout: true,
            console: true,
            enclave: "/".to_owned(),
            log_files: None,
            log_file_prefix: None,
            ignored: Vec::new(),
        }
    }
}

/// Splits a program's arguments (including its name, as in [`std::env::args_os`]) into its own arguments and the ROS arguments.
///
/// # Errors
/// The first ROS argument that is unknown, lacks its value, or cannot be parsed; an argument, except a path, that is not UTF-8.
pub fn split(
    arguments: impl IntoIterator<Item = impl Into<OsString>>,
) -> Result<(Vec<String>, RosArguments), BadArgument> {
    let mut own = Vec::new();
    let mut ros = RosArguments::default();
    let mut arguments = arguments.into_iter().map(Into::into);
    while let Some(argument) = arguments.next() {
        let argument = text(argument)?;
        if argument == "--ros-args" {
            take_section(&mut arguments, &mut ros)?;
        } else {
            own.push(argument);
        }
    }
    Ok((own, ros))
}

/// The ROS arguments among `arguments` (without the program's name), for a program without its own arguments: other arguments are ignored with a
/// warning, as in rcl.
///
/// # Errors
/// Same as [`split`].
pub fn only(
    arguments: impl IntoIterator<Item = impl Into<OsString>>,
) -> Result<RosArguments, BadArgument> {
    let (own, mut ros) = split(arguments)?;
    let line = |argument: String| format!("{argument}: ROS arguments must follow --ros-args");
    ros.ignored.extend(own.into_iter().map(line));
    Ok(ros)
}

/// The ROS arguments of this process, for a program that has no other arguments.
///
/// # Errors
/// Same as [`split`].
pub fn from_environment() -> Result<RosArguments, BadArgument> {
    only(std::env::args_os().skip(1))
}

/// The argument as text.
fn text(argument: OsString) -> Result<String, BadArgument> {
    argument.into_string().map_err(|argument| {
        BadArgument::new(&argument.to_string_lossy(), "the argument is not UTF-8")
    })
}

/// Parses arguments up to the closing `--`, or to the end.
fn take_section(
    arguments: &mut impl Iterator<Item = OsString>,
    ros: &mut RosArguments,
) -> Result<(), BadArgument> {
    while let Some(argument) = arguments.next() {
        let argument = text(argument)?;
        let mut raw = || {
            arguments
                .next()
                .ok_or_else(|| BadArgument::new(&argument, "the argument's value is missing"))
        };
        if argument == "--params-file" {
            ros.parameters.push(ParameterSource::File(raw()?.into()));
            continue;
        }
        let mut value = || text(raw()?);
        match argument.as_str() {
            "--" => return Ok(()),
            "--ros-args" => {}
            "-r" | "--remap" => ros.remaps.push(value()?.parse()?),
            "-p" | "--param" => ros.parameters.push(assignment(&value()?)?),
            "--log-level" => set_level(&value()?, ros)?,
            "--enable-rosout-logs" => ros.rosout = true,
            "--disable-rosout-logs" => ros.rosout = false,
            "--enable-stdout-logs" => ros.console = true,
            "--disable-stdout-logs" => ros.console = false,
            "--enable-external-lib-logs" => ros.log_files = Some(true),
            "--disable-external-lib-logs" => ros.log_files = Some(false),
            "-e" | "--enclave" => {
                ros.enclave = value()?;
                check_namespace(&ros.enclave)?;
            }
            "--log-file-name" => {
                let prefix = value()?;
                if prefix.contains('/') {
                    let reason = "a log file's name must not contain a slash; set its folder with ROS_LOG_DIR";
                    return Err(BadArgument::new(&prefix, reason));
                }
                ros.log_files = ros.log_files.or(Some(true));
                ros.log_file_prefix = Some(prefix);
            }
            "--log-config-file" => {
                let file = value()?;
                let text = "log files cannot be configured";
                ros.ignored.push(format!("{argument} {file}: {text}"));
            }
            _ => return Err(BadArgument::new(&argument, "not a ROS argument")),
        }
    }
    Ok(())
}

fn assignment(text: &str) -> Result<ParameterSource, BadArgument> {
    let (left, value) = text
        .split_once(":=")
        .ok_or_else(|| BadArgument::new(text, "name:=value is expected"))?;
    let (node, name) = match left.split_once(':') {
        Some((node, name)) => (Some(node.to_owned()), name),
        None => (None, left),
    };
    if name.is_empty() {
        return Err(BadArgument::new(text, "the parameter's name is missing"));
    }
    let value =
        file::parse_value(name, value).map_err(|e| BadArgument::new(text, &e.to_string()))?;
    Ok(ParameterSource::Assignment {
        node,
        name: name.to_owned(),
        value,
    })
}

fn set_level(text: &str, ros: &mut RosArguments) -> Result<(), BadArgument> {
    let (logger, level) = match text.split_once(":=") {
        Some((logger, level)) => (Some(logger), level),
        None => (None, text),
    };
    let level = match level.to_ascii_lowercase().as_str() {
        "debug" => LevelFilter::Debug,
        "info" => LevelFilter::Info,
        "warn" => LevelFilter::Warn,
        "error" | "fatal" => LevelFilter::Error,
        "unset" | "none" => LevelFilter::Off,
        _ => {
            return Err(BadArgument::new(
                text,
                "debug, info, warn, error or fatal is expected",
            ));
        }
    };
    match logger {
        Some(logger) => ros.logger_levels.push((logger.to_owned(), level)),
        None => ros.log_level = level,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStringExt as _;

    fn split_words(line: &str) -> Result<(Vec<String>, RosArguments), BadArgument> {
        split(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn ros_arguments_are_taken_out_and_the_rest_left() {
        let (own, ros) = split_words(
            "sysid replay --ros-args -r state:=truth -r __ns:=/b -p depth.kp:=0.5 \
             --params-file a.yaml -p other:rate:=20 --log-level warn --log-level auv.x:=debug \
             --disable-rosout-logs --enclave /auv --log-file-name b -- bag --ros-args --remap a:=b",
        )
        .expect("good arguments");
        assert_eq!(own, ["sysid", "replay", "bag"]);
        assert_eq!(ros.remaps.len(), 3);
        assert_eq!(ros.remaps[1].kind, RemapKind::Namespace);
        assert_eq!(
            ros.parameters,
            [
                ParameterSource::Assignment {
                    node: None,
                    name: "depth.kp".to_owned(),
                    value: Value::Double(0.5)
                },
                ParameterSource::File("a.yaml".into()),
                ParameterSource::Assignment {
                    node: Some("other".to_owned()),
                    name: "rate".to_owned(),
                    value: Value::Integer(20)
                },
            ]
        );
        assert_eq!(ros.log_level, LevelFilter::Warn);
        assert_eq!(
            ros.logger_levels,
            [("auv.x".to_owned(), LevelFilter::Debug)]
        );
        assert!(!ros.rosout && ros.console);
        assert_eq!(ros.enclave, "/auv");
        assert_eq!(ros.log_file_prefix.as_deref(), Some("b"));
        assert_eq!(ros.ignored, [""; 0]);
        let ros = only(["a.mcap", "--ros-args"]).expect("passed over");
        assert!(ros.ignored[0].starts_with("a.mcap: "), "{:?}", ros.ignored);
    }

    #[test]
    fn an_argument_that_is_not_utf_8_is_refused_unless_it_is_a_path() {
        let bad = || OsString::from_vec(b"caf\xe9".to_vec());
        let refusal = only([bad()]).expect_err("no text");
        assert_eq!(
            refusal.to_string(),
            "'caf\u{fffd}': the argument is not UTF-8"
        );
        only(["--ros-args".into(), "-p".into(), bad()]).expect_err("no assignment");
        let ros = only(["--ros-args".into(), "--params-file".into(), bad()]).expect("a path");
        assert_eq!(ros.parameters, [ParameterSource::File(bad().into())]);
    }

    #[test]
    fn a_bad_argument_is_refused_with_its_reason() {
        for (line, reason) in [
            ("x --ros-args --frobnicate", "not a ROS argument"),
            ("x --ros-args -r state", "from:=to"),
            ("x --ros-args -r :=b", "empty"),
            ("x --ros-args -p", "value is missing"),
            ("x --ros-args -p kp", "name:=value"),
            ("x --ros-args -p kp:=[1,", "not YAML"),
            ("x --ros-args --log-level loud", "debug, info"),
            ("x --ros-args --enclave auv", "slash"),
            ("x --ros-args --log-file-name ../a", "ROS_LOG_DIR"),
            ("x --ros-args --enclave /../auv", "tokens"),
        ] {
            let refusal = split_words(line).expect_err(line).to_string();
            assert!(refusal.contains(reason), "{line}: {refusal}");
        }
    }
}
