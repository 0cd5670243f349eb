//! `planesman coefficients`: a vehicle's coefficients from its geometry, beside those of its file.

use std::process::{Command, Output};

fn planesman(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(args)
        .output()
        .expect("run")
}

#[test]
fn coefficients_are_shown_beside_the_file_s_in_both_systems() {
    let run = planesman(&["coefficients", "brunner"]);
    let text = String::from_utf8(run.stdout).expect("UTF-8");
    assert!(run.status.success());
    let line = text
        .lines()
        .find(|l| l.starts_with("M'delta"))
        .expect("there");
    for part in [
        "-0.1848",
        " -0.184 ",
        "-0.2844",
        " ft lbf/rad",
        "-0.3856",
        " N m/rad",
    ] {
        assert!(line.contains(part), "{part} in {line}");
    }
}

#[test]
fn a_vehicle_without_geometry_and_one_that_is_none_are_refused_in_one_line() {
    let whole = include_str!("../../crates/vehicle/vehicle/vehicles/brunner.yaml");
    let at = whole.find("\ngeometry:").expect("there");
    let folder = tempfile::tempdir().expect("a folder");
    let refusal = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        let run = planesman(&["coefficients", path.to_str().expect("UTF-8")]);
        assert!(!run.status.success());
        let error = String::from_utf8(run.stderr).expect("UTF-8");
        assert_eq!(error.lines().count(), 1, "{error}");
        error
    };
    assert!(refusal("bare.yaml", &whole[..at]).contains("no section 'geometry'"));
    let wrong_unit = whole.replace("span: 2.5 in", "span: 2.5 kg");
    assert!(refusal("unit.yaml", &wrong_unit).contains("one of the units m, cm, mm, in, ft"));
    let no_chord = whole.replace("chord: 1.9 in, ", "");
    assert!(refusal("chord.yaml", &no_chord).contains("missing field `chord`"));
    let flat = whole.replace("depth: 3.5 in", "depth: 0 in");
    assert!(refusal("flat.yaml", &flat).contains("0 in refused: it must be above zero"));
    assert!(
        !planesman(&["coefficients", "no/such.yaml"])
            .status
            .success()
    );
    assert!(
        !planesman(&["coefficients", "brunner", "--speed", "-1"])
            .status
            .success()
    );
}
