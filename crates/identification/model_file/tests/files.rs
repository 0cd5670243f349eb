//! Model files are read back as they were written, and only such files are.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use planesman_model_file::{Continuous, Heave, ModelFile, Physical, Place};

fn model() -> ModelFile {
    let place = Place {
        re: 0.9,
        im: 0.1 / 3.0,
        re_deviation: 1e-3,
        im_deviation: 2e-17,
    };
    let (num, den) = (vec![0.0, -1.0 / 7.0], vec![1.0, -1.8, 0.81 + 1e-15]);
    ModelFile {
        speed: Some(0.36576),
        covariance: vec![vec![1e-7, 0.0, 0.0, 0.0]; 4],
        continuous: Some(Continuous {
            num: vec![-2.0],
            den: vec![1.0, 3.0, 2.0],
            delay: 0.05,
        }),
        physical: Some(Physical {
            kappa: -0.67,
            beta: 1.4,
            mu: 0.27,
            covariance: [[1e-4, 0.0, 0.0], [0.0, 4e-4, 0.0], [0.0, 0.0, 9e-4]],
            heave: Some(Heave {
                to_pitch: 0.27,
                damping: 0.64,
                from_rate: 0.07,
                from_input: 0.02,
            }),
        }),
        offset: -3.5e-12,
        noise_variance: 2.5e-5,
        poles: vec![place; 2],
        continuous_poles: vec![place; 2],
        fit: Some(97.25),
        verdict: vec!["it \"simulates\": 97 %".to_owned()],
        ..ModelFile::exact(
            "plane_motion:dive_planes",
            "state:pitch_rate",
            0.05,
            num,
            den,
        )
    }
}

#[test]
fn a_model_comes_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["model.yaml", "model.yml", "model.json"] {
        let path = folder.path().join(name);
        model().write(&path).unwrap();
        assert_eq!(ModelFile::read(&path).unwrap(), model(), "{name}");
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(ModelFile::recognises(&path, &text));
    }
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 3, "nothing else stays behind");
}

/// Numbers of 16 and 17 digits, of which a reader that rounds twice misses some by their last bit.
#[test]
fn every_number_comes_back_to_its_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let noise_model: Vec<f64> = (0..1000)
        .map(|k| libm::sin(f64::from(k)) * 10f64.powi(k % 41 - 20))
        .collect();
    let written = ModelFile {
        noise_model,
        ..model()
    };
    for name in ["model.yaml", "model.json"] {
        let path = folder.path().join(name);
        written.write(&path).unwrap();
        let read = ModelFile::read(&path).unwrap();
        assert_eq!(read.noise_model, written.noise_model, "{name}");
    }
}

#[test]
fn the_deviations_are_the_roots_of_the_variances() {
    let found = model().physical.unwrap().deviations();
    for (found, expected) in found.into_iter().zip([1e-2, 2e-2, 3e-2]) {
        assert!((found - expected).abs() < 1e-15);
    }
}

#[test]
fn what_does_not_belong_together_is_neither_written_nor_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.yaml");
    type Change = fn(&mut ModelFile);
    let refused: [(Change, &str); 12] = [
        (|m| m.sample_time = 0.0, "sample_time"),
        (|m| m.sample_time = f64::NAN, "sample_time"),
        (|m| m.speed = Some(-1.0), "speed"),
        (|m| m.den[0] = 2.0, "begin with 1"),
        (|m| m.den.clear(), "begin with 1"),
        (|m| m.num.extend([1.0, 1.0]), "one more"),
        (|m| m.covariance.truncate(3), "4 rows"),
        (|m| m.covariance[2].truncate(1), "4 rows"),
        (
            |m| m.covariance[1][2] = f64::INFINITY,
            "covariance 2 3 is not",
        ),
        (
            |m| m.physical.as_mut().unwrap().mu = f64::NAN,
            "physical mu is not",
        ),
        (|m| m.poles[1].re = f64::NAN, "poles 2 re is not"),
        (
            |m| m.continuous.as_mut().unwrap().den.clear(),
            "continuous.den",
        ),
    ];
    for (change, reason_part) in refused {
        let mut changed = model();
        change(&mut changed);
        let written = changed.write(&path).unwrap_err().to_string();
        assert!(
            written.contains(reason_part) && written.contains("model.yaml"),
            "{written}"
        );
        assert!(!path.exists());
        std::fs::write(&path, serde_yaml_ng::to_string(&changed).unwrap()).unwrap();
        let read = ModelFile::read(&path).unwrap_err().to_string();
        assert_eq!(read, written);
        std::fs::remove_file(&path).unwrap();
    }
    let order = planesman_model_file::LARGEST_ORDER + 1;
    let mut long = model();
    long.num = vec![0.0; order];
    long.den = [vec![1.0], vec![0.0; order]].concat();
    long.covariance = vec![vec![0.0; 2 * order]; 2 * order];
    let refusal = long.check().unwrap_err();
    assert!(refusal.to_string().contains(&format!("at most {order}")));
}

#[test]
fn a_model_behind_a_thousand_samples_of_delay_is_read_as_it_was_written() {
    let order = 1010;
    let mut long = model();
    long.num = vec![0.0; order];
    long.num[order - 1] = 0.5;
    long.den = [vec![1.0, -1.8, 0.81], vec![0.0; order - 2]].concat();
    // Of the delay all is known.
    let mut covariance = vec![vec![0.0; 2 * order]; 2 * order];
    for (i, j) in [
        (0, 0),
        (0, 1),
        (1, 0),
        (1, 1),
        (2 * order - 1, 0),
        (0, 2 * order - 1),
    ] {
        covariance[i][j] = 1e-7;
    }
    long.covariance = covariance;
    let folder = tempfile::tempdir().unwrap();
    for name in ["long.yaml", "long.json"] {
        let path = folder.path().join(name);
        long.write(&path).unwrap();
        assert!(ModelFile::read(&path).unwrap() == long, "{name}");
    }
    // What would not be read again is not written.
    let order = 150;
    long.num = vec![0.0; order];
    long.den = [vec![1.0], vec![0.0; order]].concat();
    long.covariance = vec![vec![1.0 / 3.0; 2 * order]; 2 * order];
    let refusal = long.write(&folder.path().join("full.json")).unwrap_err();
    assert!(refusal.to_string().contains("can be read"), "{refusal}");
}

#[test]
fn what_is_no_model_file_is_refused_with_the_reason() {
    let good = serde_yaml_ng::to_string(&model()).unwrap();
    for (text, reason_part) in [
        (String::new(), "missing field"),
        ("[1, 2".to_owned(), "sequence"),
        (
            good.replace("planesman model 3", "planesman model 9"),
            "planesman model 3",
        ),
        (
            good.replace("planesman model 3", "planesman model 2"),
            "several inputs",
        ),
        (good.replace("offset:", "ofset:"), "ofset"),
        (
            good.replace("sample_time: 0.05", "sample_time: soon"),
            "expected a number",
        ),
        (good.replace("num:", "numerator:"), "numerator"),
    ] {
        let refusal = ModelFile::parse(Path::new("mine.yaml"), &text).unwrap_err();
        assert!(
            refusal.refusal.to_string().contains(reason_part),
            "{refusal}"
        );
        assert!(refusal.to_string().contains("mine.yaml"));
    }
    let elsewhere = ModelFile::parse(Path::new("model.txt"), &good).unwrap_err();
    assert!(
        elsewhere
            .refusal
            .to_string()
            .contains(".json, .yaml or .yml")
    );
    assert!(!ModelFile::recognises(Path::new("v.yaml"), "name: brunner"));
    let later = good.replace("planesman model 3", "planesman model 2");
    assert!(ModelFile::recognises(Path::new("later.yaml"), &later));
}

#[test]
fn a_file_without_end_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let padding = " ".repeat(1 + (1 << 20));
    std::fs::write(&path, padding).unwrap();
    let refusal = ModelFile::read(&path).unwrap_err();
    assert!(
        refusal.refusal.to_string().contains("larger than"),
        "{refusal}"
    );
    let device = ModelFile::read(Path::new("/dev/zero")).unwrap_err();
    assert!(
        device.refusal.to_string().contains("regular file"),
        "{device}"
    );
}
