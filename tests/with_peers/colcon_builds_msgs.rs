//! colcon builds `msgs/` as a ROS package, with the ament and rosidl packages of Debian, and a C++ program uses
//! it (`tests/colcon/build_msgs.sh`).

use crate::foreign;
use std::process::Command;

/// How the script tells that it lacks a tool.
const SKIPPED: i32 = 77;

#[test]
fn colcon_builds_the_messages_and_a_program_uses_them() {
    let output = Command::new("bash")
        .arg(foreign::root().join("tests/colcon/build_msgs.sh"))
        .output()
        .expect("bash starts");
    let printed = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(SKIPPED) {
        foreign::skip(printed.trim().trim_start_matches("skipped: "));
        return;
    }
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}{complaints}");
    assert!(
        printed.contains("ok: colcon built planesman_msgs"),
        "{printed}"
    );
}
