//! Bags of messages that are not ours, written by `rosbags`: the model is numpy's least squares on the same samples.
//!
//! Where `.venv` is absent these tests pass, saying what they skipped (tests/README.md).

use crate::foreign::peers;
use std::path::{Path, PathBuf};

use clap::Parser;
use planesman::sysid::fit::FitArgs;
use planesman::sysid::topics;
use planesman_bag::{BagReader, Message, Order};
use planesman_decode::{Catalogue, Decoder, FieldPath, Values};
use planesman_fit::{DataOptions, FitResult};
use planesman_show::diff::{Options, diff};
use serde_json::Value;

/// The output of a peer; `None` where there is no Python with `rosbags`.
fn printed(program: &str, arguments: &[&str]) -> Option<String> {
    let output = peers::program(program)?.args(arguments).output().unwrap();
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaints}");
    Some(String::from_utf8(output.stdout).unwrap())
}

/// Writes a bag and returns what numpy found in it.
fn make_bag(bag: &Path, compression: &str) -> Option<Value> {
    let printed = printed("make_imu_bag.py", &[bag.to_str().unwrap(), compression])?;
    Some(serde_json::from_str(&printed).unwrap())
}

fn fit(data: &[PathBuf], output: &str) -> FitResult {
    let data = data.iter().map(|path| path.to_str().unwrap());
    let args = ["sysid fit"].into_iter().chain(data);
    let args = args.chain(["--input", "cmd:data", "--output", output, "--rate", "20"]);
    let args = args.chain(["--method", "least_squares", "--order", "2", "--no-offset"]);
    planesman_fit::fit(
        &(&FitArgs::try_parse_from(args).unwrap())
            .try_into()
            .unwrap(),
        &(),
    )
    .unwrap()
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
                let FitResult {
                    prepared, analysis, ..
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
                assert_eq!(prepared.resampled.record.segments.len(), 2);
                assert_eq!(prepared.resampled.outputs[0].timing.gaps, 1);
                assert_eq!(
                    prepared.resampled.outputs[0].timing.samples,
                    expected["messages"]["/imu"]
                );
                assert_eq!(
                    prepared.resampled.inputs[0].timing.samples,
                    expected["messages"]["/cmd"]
                );
            }
        }
    }
}

#[test]
fn bags_of_any_compression_are_equal_and_a_part_lacks_messages() {
    let folder = tempfile::tempdir().unwrap();
    let bags = ["none", "lz4", "zstd"].map(|it| folder.path().join(it));
    for bag in &bags {
        let name = bag.file_name().unwrap().to_str().unwrap();
        if make_bag(bag, name).is_none() {
            return;
        }
        let found = diff(&bags[0], bag, &Options::default()).unwrap();
        assert!(found.is_equal(), "{}", found.headline());
    }
    let part = bags[1].join("lz4_0.mcap");
    let found = diff(&bags[0], &part, &Options::default()).unwrap();
    assert!(found.headline().contains("only A has it"));
    for topic in &found.topics {
        let [in_a, in_b] = topic.messages;
        assert_eq!([topic.equal, topic.different], [in_b, 0], "{}", topic.name);
        assert_eq!(topic.alone, [in_a - in_b, 0], "{}", topic.name);
    }
}

#[test]
fn every_field_is_listed_with_its_range() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    let Some(expected) = make_bag(&bag, "zstd") else {
        return;
    };
    let survey = planesman_fit::survey(&DataOptions::files([&bag]), None, &()).unwrap();
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
    assert!(!field("angular_velocity.y").means.is_empty());
    let text = topics::table(&survey, true, None);
    assert!(text.contains("orientation_covariance[0..8]"), "{text}");
}

/// The number at a path of a message as the foreign readers printed it; `None` for an element that is not there.
fn told_number(message: &Value, path: &FieldPath) -> Option<f64> {
    let pointer = format!("/{path}").replace(['.', '['], "/").replace(']', "");
    let value = message.pointer(&pointer)?;
    value.as_f64().or_else(|| value.as_bool().map(f64::from))
}

#[test]
fn every_number_of_every_kind_is_what_foreign_readers_read_in_bags_of_every_form() {
    let folder = tempfile::tempdir().unwrap();
    if printed("make_kinds_bag.py", &[folder.path().to_str().unwrap()]).is_none() {
        return;
    }
    let at = |name: &str| folder.path().join(name);
    // rosbags and mcap-ros2-support agree, in either byte order.
    let read = ["little", "big"].map(|name| {
        let all = ["--decode", "100", at(name).to_str().unwrap()].map(str::to_owned);
        let printed = printed("read_bag.py", &all.each_ref().map(String::as_str)).unwrap();
        serde_json::from_str::<Value>(&printed).unwrap()["topics"]["/kinds"]["values"].clone()
    });
    assert_eq!(read[0], read[1]);
    let expected = read[0].as_array().unwrap();
    assert_eq!(expected.len(), 40);

    for name in [
        "little",
        "big",
        "packed",
        "file",
        "sqlite",
        "sqlite_packed",
        "sqlite/sqlite.db3",
        "bare.mcap",
        "idl.mcap",
    ] {
        let bag = BagReader::open(&at(name)).unwrap();
        assert!(bag.completeness().is_whole(), "{name}");
        let types = planesman_signals::types(&bag, &bag.topics()[0].topic).unwrap();
        let mut fields = Catalogue::of(&types, usize::MAX).fields;
        // These are ours: rosbags knows none.
        fields.retain(|path| {
            !["roll", "pitch", "yaw"].contains(&path.to_string().trim_start_matches("turn."))
        });
        let decoder = Decoder::compile(&types, &fields).unwrap();
        let mut values = Values::default();
        let messages: Vec<Message> = bag.messages(Order::File).map(Result::unwrap).collect();
        assert_eq!(messages.len(), expected.len(), "{name}");
        for (message, expected) in messages.iter().zip(expected) {
            decoder.read(&message.payload, &mut values).unwrap();
            for (index, field) in fields.iter().enumerate() {
                let (ours, theirs) = (values.number(index), told_number(expected, field));
                // JSON's numbers are read to the last bit but one.
                let off = ours.unwrap_or(0.0) - theirs.unwrap_or(0.0);
                assert!(
                    ours.is_some() == theirs.is_some()
                        && off.abs() <= 4e-16 * theirs.unwrap_or(0.0).abs(),
                    "{name}: {field}: {ours:?} {theirs:?}"
                );
            }
        }
        let fields: Vec<String> = fields.iter().map(ToString::to_string).collect();
        for field in [
            "a_uint64",
            "octets[3]",
            "few[2].three[2]",
            "truths[0]",
            "last",
        ] {
            assert!(fields.iter().any(|it| it == field), "{field}");
        }
    }
}
