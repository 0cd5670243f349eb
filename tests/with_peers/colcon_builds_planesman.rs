//! colcon builds the ROS package planesman with the ament packages of Jazzy: from the repository's root, where `colcon build`
//! finds it beside planesman_msgs, and in a workspace's `src`. What `ros2 run` and `ros2 launch` would start is there, and starts.
//!
//! Cargo builds into the folder of this test, with its profile, where nearly all is built already.

use crate::foreign;
use std::{
    io::{BufRead as _, BufReader},
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use foreign::root;
use planesman_flight::nodes::NODES;
use planesman_node::testing::OwnDomain;
use rustix::process::{Pid, Signal, kill_process};

/// Where the test's own `planesman` stands.
const BUILT: &str = env!("CARGO_BIN_EXE_planesman");

/// A workspace with the repository in its `src`, and ROS 2 Jazzy of wheels below it.
struct Workspace {
    folder: tempfile::TempDir,
    colcon: PathBuf,
}

impl Workspace {
    /// `None`, having said so, where the tool or ROS is missing.
    fn with(colcon: PathBuf) -> Option<Self> {
        for needed in [&colcon, &ros().join("bin/python")] {
            if !needed.exists() {
                foreign::skip(&format!("there is no {}", needed.display()));
                return None;
            }
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("src")).unwrap();
        symlink(root(), folder.path().join("src/planesman")).unwrap();
        Some(Self { folder, colcon })
    }

    /// A program in the environment of `/opt/ros/jazzy/setup.sh`.
    fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        let path = std::env::var("PATH").unwrap();
        command
            .current_dir(self.folder.path())
            .env("PATH", format!("{}/bin:{path}", ros().display()))
            .env("LD_LIBRARY_PATH", ros().join("lib"))
            .env("AMENT_PREFIX_PATH", ros())
            .env("CMAKE_PREFIX_PATH", ros());
        command
    }

    /// The standard output of `colcon`.
    fn colcon(&self, arguments: &[&str]) -> String {
        let profile = Path::new(BUILT).parent().unwrap();
        let output = self
            .command(&self.colcon)
            .args(arguments)
            .env("CARGO_TARGET_DIR", profile.parent().unwrap())
            .output()
            .unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        let complaints = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{printed}{complaints}");
        printed.into_owned()
    }

    fn build(&self, where_from: &[&str]) {
        let python = format!("-DPython3_EXECUTABLE={}/bin/python", ros().display());
        let release = if BUILT.contains("/release/") {
            "Release"
        } else {
            "Debug"
        };
        let profile = format!("-DCMAKE_BUILD_TYPE={release}");
        let options = ["--cmake-args", "-DBUILD_TESTING=OFF", &python, &profile];
        self.colcon(&[&["build"], where_from, &options].concat());
    }

    /// What a shell prints, or starts, that has sourced the workspace.
    fn sourced(&self, script: &str, arguments: &[&str]) -> Command {
        let prefix = "import ament_index_python as a; print(a.get_package_prefix('planesman'))";
        let mut command = self.command(Path::new("sh"));
        command
            .arg("-c")
            .arg(format!(
                ". install/setup.sh && prefix=$(python -c \"{prefix}\") && {script}"
            ))
            .arg("sh")
            .args(arguments)
            .stdin(Stdio::null());
        command
    }

    fn printed(&self, script: &str) -> Vec<String> {
        let output = self.sourced(script, &[]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(str::to_owned).collect()
    }

    /// What the package must hold, once built.
    fn holds_what_ros2_looks_for(&self) {
        // As `ros2 pkg executables` finds them.
        let mut programs =
            self.printed("find \"$prefix/lib/planesman\" -type f -perm -u+x -printf '%f\\n'");
        programs.sort();
        let examples = [
            "chirp_logs.py",
            "own_actuator.py",
            "own_controller.py",
            "own_estimator.py",
            "own_plant.py",
            "policy_controller.py",
        ];
        let mut expected = [&NODES[..], &["planesman", "planesman-reports"], &examples].concat();
        expected.sort_unstable();
        assert_eq!(programs, expected);

        let share =
            self.printed("cd \"$prefix/share/planesman\" && find . -type f -printf '%P\\n'");
        for file in [
            "launch/dive.launch.py",
            "launch/replay.launch.py",
            "layouts/plotjuggler.xml",
            "meshes/hull.obj",
            "package.xml",
            "params/params.yaml",
            "scenarios/dive.yaml",
            "urdf/brunner.urdf",
            "vehicles/table_3_at_3_fps.yaml",
        ] {
            assert!(
                share.iter().any(|f| f == file),
                "{file} is not in {share:?}"
            );
        }
        let scenario = self.printed(
            "\"$prefix/lib/planesman/planesman\" params plant_sim --yaml \
             --scenario too_fast",
        );
        assert!(
            scenario
                .iter()
                .any(|line| line.contains("table_3_at_3_fps.yaml"))
        );

        // The library of FMUs is beside the program.
        let program = "\"$prefix/lib/planesman/planesman\"";
        let made = self.printed(&format!("{program} export --fmi auv --out /dev/null"));
        assert!(made[0].contains("FMI 3.0"), "{made:?}");

        for node in NODES {
            self.starts_and_ends(node);
        }
    }

    /// `ros2 run planesman NODE`, until Ctrl-C.
    fn starts_and_ends(&self, node: &str) {
        let domain = OwnDomain::claim().unwrap();
        let mut child = self
            .sourced("exec \"$prefix/lib/planesman/$1\"", &[node])
            .envs(domain.variables())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = String::new();
        let mut lines = BufReader::new(child.stderr.take().unwrap());
        while !said.contains("up in domain") {
            assert!(lines.read_line(&mut said).unwrap() > 0, "{node}: {said}");
        }
        kill_process(Pid::from_child(&child), Signal::INT).unwrap();
        std::io::copy(&mut lines, &mut std::io::sink()).unwrap();
        assert!(child.wait().unwrap().success(), "{node}: {said}");
    }
}

fn ros() -> PathBuf {
    root().join(".ros")
}

#[test]
fn in_a_workspace_both_packages_are_built_and_every_node_runs() {
    let Some(workspace) = Workspace::with(ros().join("bin/colcon")) else {
        return;
    };
    workspace.build(&[]);
    workspace.holds_what_ros2_looks_for();
    let messages = workspace.printed("python -c 'import planesman_msgs as m; print(m.__file__)'");
    let own = workspace.folder.path().canonicalize().unwrap();
    assert!(Path::new(&messages[0]).starts_with(own), "{messages:?}");
}

#[test]
fn debians_colcon_builds_it_too() {
    let Some(workspace) = Workspace::with(PathBuf::from("/usr/bin/colcon")) else {
        return;
    };
    // The messages are in `.ros` already.
    let package = root().join("launch-scripts");
    workspace.build(&["--base-paths", package.to_str().unwrap()]);
    workspace.holds_what_ros2_looks_for();
}

#[test]
fn colcon_finds_both_packages_in_the_repositorys_root() {
    for colcon in [ros().join("bin/colcon"), PathBuf::from("/usr/bin/colcon")] {
        let Some(workspace) = Workspace::with(colcon) else {
            continue;
        };
        let repository = root().to_str().unwrap();
        let found = workspace.colcon(&["list", "--names-only", "--base-paths", repository]);
        let mut found: Vec<_> = found.lines().collect();
        found.sort_unstable();
        assert_eq!(found, ["planesman", "planesman_msgs"]);
    }
}
