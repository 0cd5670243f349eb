//! Bags of messages that are not ours, written by `rosbags`: the model is numpy's least squares on the same samples.
//!
//! Where `.venv` is absent these tests pass, saying what they skipped (tests/README.md).
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Parser;
use serde_json::Value;
use sysid::fit_command::{self, FitArgs, Found};
use sysid::topics_command::{self, TopicsArgs};

/// Writes a bag and returns what numpy found in it; `None` where there is no Python with `rosbags`.
fn make_bag(bag: &Path, compression: &str) -> Option<Value> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let python = root.join(".venv/bin/python");
    if !python.exists() {
        let required = std::env::var("PLANESMAN_PEERS").is_ok_and(|value| value == "required");
        assert!(!required, "{} is required", python.display());
        println!("skipped: there is no {}", python.display());
        return None;
    }
    let output = Command::new(python)
        .arg(root.join("tests/peers/make_imu_bag.py"))
        .arg(bag)
        .arg(compression)
        .output()
        .unwrap();
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaints}");
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

fn fit(data: &[PathBuf], output: &str) -> Found {
    let data = data.iter().map(|path| path.to_str().unwrap());
    let args = ["sysid fit"].into_iter().chain(data);
    let args = args.chain(["--input", "cmd:data", "--output", output, "--rate", "20"]);
    let args = args.chain(["--method", "least_squares", "--order", "2", "--no-offset"]);
    fit_command::fit(&FitArgs::try_parse_from(args).unwrap(), None).unwrap()
}

#[test]
fn the_model_of_any_split_bag_is_numpys() {
    let folder = tempfile::tempdir().unwrap();
    for compression in ["none", "lz4", "zstd"] {
        let bag = folder.path().join(compression);
        let Some(expected) = make_bag(&bag, compression) else {
            return;
        };
        let parts: Vec<PathBuf> = (0..3)
            .map(|part| bag.join(format!("{compression}_{part}.mcap")))
            .collect();
        for data in [std::slice::from_ref(&bag), &parts] {
            for field in ["angular_velocity.y", "orientation.pitch"] {
                let Found {
                    record, analysis, ..
                } = fit(data, &format!("/imu:{field}"));
                let model = analysis.model();
                let ours = model.a.iter().chain(&model.b);
                let theirs = expected[field].as_array().unwrap();
                assert_eq!(theirs.len(), 4);
                for (ours, theirs) in ours.zip(theirs) {
                    let theirs = theirs.as_f64().unwrap();
                    assert!(
                        (ours - theirs).abs() <= 1e-9 * theirs.abs(),
                        "{compression} {field}: {ours} {theirs}"
                    );
                }
                assert_eq!(record.stretches.len(), 2);
                assert_eq!(record.outputs[0].timing.gaps, 1);
                assert_eq!(
                    record.outputs[0].timing.samples,
                    expected["messages"]["/imu"]
                );
                assert_eq!(
                    record.inputs[0].timing.samples,
                    expected["messages"]["/cmd"]
                );
            }
        }
    }
}

#[test]
fn every_field_is_listed_with_its_range() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    let Some(expected) = make_bag(&bag, "zstd") else {
        return;
    };
    let args = ["sysid topics", bag.to_str().unwrap()];
    let survey = topics_command::survey(&TopicsArgs::try_parse_from(args).unwrap()).unwrap();
    assert!(survey.notes.is_empty(), "{:?}", survey.notes);
    let names: Vec<&str> = survey.topics.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["/cmd", "/imu"]);
    let imu = &survey.topics[1];
    assert_eq!(imu.timing.samples, expected["messages"]["/imu"]);
    assert!((imu.timing.rate() - 100.0).abs() < 1.0, "{:?}", imu.timing);
    let field = |name: &str| imu.fields.iter().find(|it| it.path == name).unwrap();
    let gravity = field("linear_acceleration.z");
    assert_eq!((gravity.min, gravity.max), (9.81, 9.81));
    let (pitch, rate) = (field("orientation.pitch"), field("angular_velocity.y"));
    assert!((2.0 * pitch.max - rate.max).abs() < 1e-12);
    assert!(!field("angular_velocity.y").course.is_empty());
    let text = topics_command::table(&survey);
    assert!(text.contains("orientation_covariance[0..8]"), "{text}");
}
