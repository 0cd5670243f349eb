//! The AUV's depth loop through the digital hydraulic actuator, against an independent simulation
//! of the same loop (`reports/studies/data/limit_cycles.json`): the limit cycles of the quantum.
use planesman_studies::depth_loop::{Case, Leakage, Logic, cases};
use planesman_units::INCH;

/// The row of the comparison with these options and M_theta = 0.
fn case(logic: Logic, position_loop: bool, leakage: Leakage) -> Case {
    cases()
        .unwrap()
        .into_iter()
        .find(|case| {
            case.logic == logic
                && case.position_loop == position_loop
                && case.leakage == leakage
                && case.friction
                && case.restoring == 0.0
        })
        .unwrap()
}

#[test]
fn the_cycles_are_those_of_the_independent_simulation() {
    let mut deviating = Vec::new();
    for case in cases().unwrap() {
        let found = case.run().unwrap();
        for figure in found.figures(&case.expected.unwrap_or_default()) {
            if !figure.agrees() {
                deviating.push(format!(
                    "{}, M_theta {}: {}",
                    case.name, case.restoring, figure.name
                ));
            }
        }
    }
    // The first drifts away, wherever its integral lets it; the valves of the other two run through
    // the phases of the control computer, and their cycles hang on the start.
    let lost = "open loop, single speed, leakage, K_i = 0.02, M_theta 0.163";
    assert_eq!(
        deviating,
        [
            format!("{lost}: depth, in"),
            format!("{lost}: error, in"),
            format!("{lost}: t95, s"),
            "Polaris set, open loop, single speed, no leakage, M_theta 0: error, in".to_owned(),
            "Polaris set, position loop, single speed, leakage, M_theta 0: depth, in".to_owned(),
        ]
    );
}

#[test]
fn precision_mode_steers_by_the_drift_alone() {
    let cycle = case(Logic::Precision, true, Leakage::Scaled).run().unwrap();
    assert_eq!(cycle.pulses, 0.0, "no volume moves in the limit cycle");
    assert!(cycle.depth < 0.002 * INCH, "{cycle:?}");
}

#[test]
fn the_open_loop_fails_with_leakage_that_the_position_loop_holds() {
    let open = case(Logic::SingleSpeed, false, Leakage::Scaled);
    let drifting = open.run().unwrap();
    assert!(drifting.error.abs() > INCH, "{drifting:?}");
    let held = case(Logic::SingleSpeed, true, Leakage::Scaled)
        .run()
        .unwrap();
    assert!(held.error.abs() < 0.01 * INCH, "{held:?}");
}

#[test]
fn harmonic_balance_predicts_the_tight_open_loops_cycle_within_half() {
    let case = case(Logic::SingleSpeed, false, Leakage::None);
    let (cycle, predicted) = (case.run().unwrap(), case.predict().unwrap());
    assert!(predicted.residual < 0.1, "{predicted:?}");
    assert!((predicted.frequency / cycle.frequency - 1.0).abs() < 0.2);
    assert!((predicted.depth / cycle.depth - 1.0).abs() < 0.5);
}
