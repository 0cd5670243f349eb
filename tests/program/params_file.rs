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
