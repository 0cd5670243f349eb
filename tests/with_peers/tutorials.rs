//! The tutorials and the gallery of docs, followed: their commands run as they stand, and print what is written below them.
//!
//! A fenced block `sh` is run in a scratch folder, in a network namespace of its own. A block `text` behind it has lines that it prints, in their order; others may stand between. A block `sh WORD`
//! needs more than this repository: `rclpy` is run where tests/ros is installed, `rosbags` where tests/peers is; `ros2` (the command line) and `build` are not run, and named.

use crate::foreign;
use std::path::Path;
use std::process::Command;

use foreign::{CYCLONE, RCLPY, root, skip};

/// A fenced block of commands.
struct Block {
    /// Its line in the page.
    line: usize,
    /// What it needs besides this repository; empty for nothing.
    needs: String,
    script: String,
    /// Lines of its output.
    expected: Vec<String>,
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(kind) = line.strip_prefix("```") else {
            continue;
        };
        let within = lines.by_ref().map(|(_, line)| line.to_owned());
        let within: Vec<_> = within.take_while(|line| line != "```").collect();
        match kind.split_once(' ').unwrap_or((kind, "")) {
            ("sh", needs) => blocks.push(Block {
                line: number + 1,
                needs: needs.to_owned(),
                script: within.join("\n"),
                expected: Vec::new(),
            }),
            ("text", "") => blocks.last_mut().unwrap().expected = within,
            _ => panic!("line {}: neither sh nor text: {kind}", number + 1),
        }
    }
    blocks
}

/// A line with one space for each run of spaces.
fn words(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first of these lines that the output does not have behind those before it.
fn missing<'a>(expected: &'a [String], output: &str) -> Option<&'a String> {
    let mut output = output.lines().map(words);
    let mut expected = expected.iter().filter(|line| !line.is_empty());
    expected.find(|line| !output.any(|it| it == words(line)))
}

/// Runs the page's commands.
fn follow(page: &str) {
    let text = std::fs::read_to_string(root().join("docs").join(page)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for shared in ["launch-scripts", "crates"] {
        std::os::unix::fs::symlink(root().join(shared), folder.path().join(shared)).unwrap();
    }
    let program = Path::new(env!("CARGO_BIN_EXE_planesman")).parent().unwrap();
    let mut path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());

    let blocks = blocks(&text);
    assert!(!blocks.is_empty(), "{page} has no commands");
    let mut installed = Vec::new();
    for (word, python) in [("rclpy", RCLPY), ("rosbags", CYCLONE)] {
        if blocks.iter().any(|it| it.needs == word) && python.found().is_some() {
            let programs = root().join(python.environment).join("bin");
            path = format!("{}:{path}", programs.display());
            installed.push(word);
        }
    }
    let (run, left): (Vec<_>, Vec<_>) = blocks.iter().partition(|it| match it.needs.as_str() {
        "" => true,
        word @ ("rclpy" | "rosbags") => installed.contains(&word),
        "ros2" | "build" => false,
        needs => panic!("{page}:{}: nobody has {needs}", it.line),
    });
    for block in &left {
        println!("{page}:{}: not run: needs {}", block.line, block.needs);
    }
    println!("{page}: {} of {} blocks are run", run.len(), blocks.len());

    for block in run {
        let place = format!("{page}:{}", block.line);
        println!("{place}\n{}", block.script);
        let run = Command::new(root().join("tests/netns.sh"))
            .args(["timeout", "600", "bash", "-ec", &block.script])
            .current_dir(folder.path())
            .env("PATH", &path)
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("ROS_DOMAIN_ID")
            .env_remove("RMW_IMPLEMENTATION")
            .output()
            .unwrap();
        if run.status.code() == Some(125) {
            skip("network namespaces cannot be made here");
            return;
        }
        let output = String::from_utf8_lossy(&run.stdout);
        let complaints = String::from_utf8_lossy(&run.stderr);
        assert!(
            run.status.success(),
            "{place}: {}\n{output}\n{complaints}",
            run.status
        );
        if let Some(line) = missing(&block.expected, &output) {
            panic!("{place}: it does not print '{line}' there, but\n{output}");
        }
    }
}

const TUTORIALS: [&str; 7] = [
    "tutorial_design.md",
    "tutorial_frequency.md",
    "tutorial_identify.md",
    "tutorial_log.md",
    "tutorial_replay.md",
    "tutorial_reproduce.md",
    "tutorial_ros2.md",
];

#[test]
fn each_tutorial_is_followed_here() {
    let pages = std::fs::read_dir(root().join("docs")).unwrap();
    let names = pages.map(|it| it.unwrap().file_name().into_string().unwrap());
    let mut tutorials: Vec<_> = names.filter(|it| it.starts_with("tutorial_")).collect();
    tutorials.sort();
    assert_eq!(tutorials, TUTORIALS);
}

#[test]
fn what_the_readme_the_tutorials_and_the_gallery_link_is_there() {
    let docs = TUTORIALS.map(|it| format!("docs/{it}"));
    let others = ["README.md", "docs/README.md", "docs/gallery.md"];
    for page in docs.iter().map(String::as_str).chain(others) {
        let page = root().join(page);
        let text = std::fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap();
            let file = page.parent().unwrap().join(target);
            assert!(file.exists(), "{}: {target}", page.display());
        }
    }
}

#[test]
fn a_line_that_is_not_printed_or_not_in_its_place_is_missed() {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let output = "one\n  two   2.0\nthree\n";
    assert_eq!(missing(&lines("one\n\nthree"), output), None);
    assert_eq!(missing(&lines("two 2.0"), output), None);
    assert_eq!(missing(&lines("two 2.1"), output).unwrap(), "two 2.1");
    assert_eq!(missing(&lines("three\none"), output).unwrap(), "one");
}

#[test]
fn a_controller_is_designed_and_flown() {
    follow("tutorial_design.md");
}

#[test]
fn a_frequency_response_is_taken_from_a_chirp() {
    follow("tutorial_frequency.md");
}

#[test]
fn a_model_is_identified_and_judged() {
    follow("tutorial_identify.md");
}

#[test]
fn a_vehicle_is_fitted_to_its_log() {
    follow("tutorial_log.md");
}

#[test]
fn a_replay_through_an_estimator_gives_the_same_answers() {
    follow("tutorial_replay.md");
}

#[test]
fn the_reports_are_reproduced() {
    follow("tutorial_reproduce.md");
}

#[test]
fn a_controller_in_rclpy_flies_and_its_bag_is_read() {
    follow("tutorial_ros2.md");
}

#[test]
fn the_flights_of_the_gallery_are_flown() {
    follow("gallery.md");
}
