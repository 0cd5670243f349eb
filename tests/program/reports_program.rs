//! Commands that the reports' program has: they become it, where it is beside this program or on `PATH`, and otherwise say how it is built.

use std::path::Path;
use std::process::{Command, Output};

/// Says how it was called, and ends with a status of its own.
const SCRIPT: &str = "#!/bin/sh\necho \"called: $*\"\nexit 7\n";

/// `planesman`, copied into an empty folder, with these arguments and folders to search.
fn planesman(folder: &Path, path: &str, arguments: &[&str]) -> Output {
    let program = folder.join("planesman");
    if !program.exists() {
        install(Path::new(env!("CARGO_BIN_EXE_planesman")), &program);
    }
    let mut command = Command::new(program);
    command.args(arguments).env("PATH", path).output().unwrap()
}

/// Copies a program by another process: a file that this process has open for writing is also open in children that other tests fork
/// meanwhile, and cannot be run until they have closed it ("text file busy").
fn install(from: &Path, to: &Path) {
    let mut command = Command::new("install");
    let status = command.args(["-m", "755"]).args([from, to]).status();
    assert!(status.unwrap().success());
}

fn script(folder: &Path) {
    let text = folder.join("script");
    std::fs::write(&text, SCRIPT).unwrap();
    install(&text, &folder.join("planesman-reports"));
}

/// Commands, and what the reports' program gets of each.
const COMMANDS: [(&[&str], &str); 6] = [
    (
        &["reproduce", "--all", "--html", "a b.html"],
        "reproduce --all --html a b.html",
    ),
    (&["dha", "bench", "--table", "4-2"], "bench --table 4-2"),
    (
        &["dha", "limit-cycles", "open loop", "--help"],
        "limit-cycles open loop --help",
    ),
    (&["dha", "limit-cycles", "--", "-x"], "limit-cycles -- -x"),
    (&["dha", "frequency", "auv"], "frequency auv"),
    (
        &["tf", "brunner", "--as-printed", "--speed", "1ft/s"],
        "tf brunner --as-printed --speed 1ft/s",
    ),
];

#[test]
fn arguments_and_status_are_the_reports_programs_beside_this_one_or_on_the_path() {
    let [beside, alone, elsewhere] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    script(beside.path());
    script(elsewhere.path());
    let path = elsewhere.path().to_str().unwrap();
    for (folder, path) in [(&beside, ""), (&alone, path)] {
        for (arguments, called) in COMMANDS {
            let run = planesman(folder.path(), path, arguments);
            let printed = String::from_utf8(run.stdout).unwrap();
            assert_eq!(printed, format!("called: {called}\n"), "{arguments:?}");
            assert_eq!(run.status.code(), Some(7));
        }
    }
}

#[test]
fn without_the_reports_program_the_command_that_builds_it_is_said_and_help_is_there() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, _) in COMMANDS {
        let run = planesman(folder.path(), "", arguments);
        let [printed, said] = [run.stdout, run.stderr].map(|it| String::from_utf8(it).unwrap());
        let build = "cargo build --release --package planesman-reports";
        if arguments.contains(&"--help") {
            assert!(run.status.success() && said.is_empty(), "{said}");
            assert!(
                printed.contains("Usage: planesman dha limit-cycles"),
                "{printed}"
            );
            let words: Vec<&str> = printed.split_whitespace().collect();
            assert!(words.join(" ").contains(build), "{printed}");
            continue;
        }
        assert_eq!(run.status.code(), Some(1), "{said}");
        assert!(printed.is_empty(), "{printed}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(
            said.starts_with("planesman: ") && said.contains(build),
            "{said}"
        );
    }
    // What needs no report runs without their program.
    for arguments in [
        "dha frequency auv --alone",
        "dha size auv",
        "tf brunner",
        "design analyse table_3",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let run = planesman(folder.path(), "", &arguments);
        assert!(run.status.success(), "{arguments:?}: {run:?}");
    }
}
