//! The log file: `ROS_LOG_DIR`, `ROS_HOME`, `--log-file-name`.

use crate::error::{Error, Result};
use std::{
    fs::{File, create_dir_all},
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};

use crate::args::RosArguments;

/// Folder for log files, in rcl's order of priority; `None` unless files are requested. (Nodes of rcl write to `~/.ros/log` by default.)
pub(crate) fn folder(
    arguments: &RosArguments,
    variable: impl Fn(&str) -> Option<String>,
) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|value| !value.is_empty());
    let home = || PathBuf::from(set("HOME").unwrap_or_else(|| ".".to_owned()));
    let expanded = |path: String| match path.strip_prefix('~') {
        Some(rest) => home().join(rest.trim_start_matches('/')),
        None => PathBuf::from(path),
    };
    match (arguments.log_files, set("ROS_LOG_DIR"), set("ROS_HOME")) {
        (Some(false), ..) => None,
        (_, Some(folder), _) => Some(expanded(folder)),
        (_, None, Some(folder)) => Some(expanded(folder).join("log")),
        (Some(true), None, None) => Some(home().join(".ros/log")),
        (None, None, None) => None,
    }
}

/// Opens `PREFIX_PID_MILLISECONDS.log` in `folder`, named as in rcl.
///
/// # Errors
/// The folder cannot be created, or the file cannot be written.
pub(crate) fn open(folder: &PathBuf, prefix: &str) -> Result<File> {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let name = format!(
        "{prefix}_{}_{}.log",
        std::process::id(),
        since_1970.unwrap_or_default().as_millis()
    );
    let path = folder.join(name);
    create_dir_all(folder)
        .and_then(|()| File::create_new(&path))
        .map_err(Error::system(format!(
            "cannot write the log file '{}'",
            path.display()
        )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(line: &str, variables: &[(&str, &str)]) -> Option<PathBuf> {
        let line = format!("x --ros-args {line}");
        let (_, arguments) =
            crate::args::split(line.split_whitespace().map(str::to_owned)).expect("good");
        folder(&arguments, |name| {
            let found = variables.iter().find(|(known, _)| *known == name)?;
            Some(found.1.to_owned())
        })
    }

    #[test]
    fn files_are_written_where_ros_variables_say_or_when_asked_for() {
        let home = ("HOME", "/home/a");
        let log = "--log-file-name x";
        for (line, variables, expected) in [
            ("", vec![home], None),
            (log, vec![home], Some("/home/a/.ros/log")),
            (
                "--enable-external-lib-logs",
                vec![home],
                Some("/home/a/.ros/log"),
            ),
            ("", vec![home, ("ROS_HOME", "/ros")], Some("/ros/log")),
            (
                "",
                vec![home, ("ROS_HOME", "/ros"), ("ROS_LOG_DIR", "~/l")],
                Some("/home/a/l"),
            ),
            ("", vec![home, ("ROS_LOG_DIR", "")], None),
            (
                "--disable-external-lib-logs",
                vec![("ROS_LOG_DIR", "/l")],
                None,
            ),
        ] {
            assert_eq!(
                folder_with(line, &variables),
                expected.map(PathBuf::from),
                "{line}"
            );
        }
    }
}
