//! The committed parameter file is what the program prints, so it cannot drift from the
//! declarations; and what it prints, the nodes read.

use planesman_flight::nodes::NODES;
use planesman_flight::nodes::declarations;
use planesman_flight::parameter_file::parameter_file;
use planesman_flight::scenario::Scenario;
use planesman_parameters::{Values, file};

const COMMITTED: &str = include_str!("../../launch-scripts/params/params.yaml");

#[test]
fn the_committed_file_is_what_the_program_prints() {
    let printed = std::process::Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(["params", "--yaml"])
        .output()
        .expect("run");
    assert!(printed.status.success(), "{printed:?}");
    assert!(
        String::from_utf8_lossy(&printed.stdout) == COMMITTED,
        "write it anew: planesman params --yaml > launch-scripts/params/params.yaml"
    );
}

#[test]
fn every_node_reads_its_defaults_from_it_in_any_namespace() {
    for namespace in ["", "/auv", "/fleet/auv2"] {
        for node in NODES {
            let read = file::overrides_for(COMMITTED, &format!("{namespace}/{node}"))
                .unwrap_or_else(|e| panic!("{node}: {e}"));
            let defaults = Values::defaults(declarations(node).expect(node));
            assert_eq!(
                read.len(),
                defaults.declarations().len(),
                "{namespace}/{node}"
            );
            assert_eq!(defaults.with(read).expect(node), defaults);
        }
    }
}

/// The documents, the scenarios and what is tested, as one text.
fn where_parameters_are_used() -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders: Vec<_> = [
        "docs",
        "launch-scripts/scenarios",
        "tests",
        "crates",
        "nodes",
    ]
    .map(|it| root.join(it))
    .into();
    let mut text = std::fs::read_to_string(root.join("README.md")).expect("README");
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("readable") {
            let path = entry.expect("readable").path();
            let extension = path.extension().and_then(|it| it.to_str());
            if path.is_dir() {
                folders.push(path);
            } else if let Some("md" | "yaml" | "py" | "rs") = extension {
                let file = std::fs::read_to_string(&path).expect("text");
                // Of a source file its own tests; a file of tests whole.
                let source = path.components().any(|it| it.as_os_str() == "src");
                let tests = file
                    .split_once("#[cfg(test)]")
                    .map_or("", |(_, tests)| tests);
                text.push_str(if source { tests } else { &file });
            }
        }
    }
    text
}

#[test]
fn every_parameter_stands_in_a_document_a_scenario_or_a_test() {
    let text = where_parameters_are_used();
    // Names as they are written: `tick` is not found in `ticks`, nor in `core.tick`.
    let words: std::collections::HashSet<&str> = text
        .split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.'))
        .map(|word| word.trim_matches('.'))
        .collect();
    let mut unused = Vec::new();
    for node in NODES {
        for declaration in declarations(node).expect(node) {
            if !words.contains(&*declaration.name) {
                unused.push(format!("{node} {}", declaration.name));
            }
        }
    }
    assert!(unused.is_empty(), "{unused:#?}");
}

#[test]
fn a_scenario_as_a_parameter_file_has_the_scenarios_values() {
    let scenario = Scenario::load("dive").expect("scenario");
    let text = parameter_file(None, Some(&scenario)).expect("written");
    for node in NODES {
        let read = file::overrides_for(&text, &format!("/auv/{node}")).expect("read");
        let defaults = Values::defaults(declarations(node).expect(node));
        assert_eq!(
            defaults.with(read).expect(node),
            scenario.values(node).expect(node)
        );
    }
}

#[test]
fn a_scenario_of_the_installed_package_is_found_by_its_name() {
    let prefix = tempfile::tempdir().expect("a folder");
    let share = prefix.path().join("share/planesman/scenarios");
    std::fs::create_dir_all(&share).expect("room");
    let text = "{description: d, duration: 1, parameters: {plant_sim: {vehicle: ../boat.yaml}}}";
    std::fs::write(share.join("harbour.yaml"), text).expect("room");
    let boat = include_str!("../../launch-scripts/vehicles/table_3_at_3_fps.yaml");
    std::fs::write(share.join("../boat.yaml"), boat).expect("room");
    let run = |name: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_planesman"))
            .args(["params", "--yaml", "--scenario", name])
            .env(
                "AMENT_PREFIX_PATH",
                format!("/nowhere:{}", prefix.path().display()),
            )
            .output()
            .expect("run")
    };
    let printed = run("harbour");
    let text = String::from_utf8_lossy(&printed.stdout);
    assert!(printed.status.success(), "{printed:?}");
    assert!(text.contains("boat.yaml"), "beside the scenario: {text}");
    for name in ["marina", "./harbour", "harbour.yaml"] {
        assert!(!run(name).status.success(), "{name}");
    }
}
