//! `planesman sysid compare`, and `sysid fit` with validation data and with all methods.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME};
use clap::Parser;
use planesman::sysid::compare::{self, CompareArgs};
use planesman::sysid::fit::FitArgs;
use planesman_console::Format;
use planesman_fit::{CompareOptions, Compared, Comparison, FitResult};
use planesman_identification::{filter, noise};
use planesman_model_file::ModelFile;
use planesman_show::pages::tables::{numbers, tables};
use planesman_testing::{content, hostile::mutated};
use planesman_text::in_one_line;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

const A: [f64; 3] = [1.0, -1.5, 0.7];
const B: [f64; 3] = [0.0, 1.0, 0.5];

/// Columns `t`, `u` and `y` at 10 Hz; y is the response to noise, with slow noise of a size and an offset of 2.
fn table(folder: &Path, name: &str, seed: u32, b: &[f64], size: f64) -> PathBuf {
    let u = noise(seed, 600);
    let v = filter(&[1.0], &[1.0, -0.8], &noise(seed + 5, 600));
    let mut text = String::from("t,u,y");
    for (k, y) in filter(b, &A, &u).iter().enumerate() {
        let y = y + size * v[k] + 2.0;
        let _ = write!(text, "\n{:.3},{},{y}", 0.1 * k as f64, u[k]);
    }
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

fn try_fit(data: &Path, more: &str) -> Result<FitResult, String> {
    crate::by_command_line();
    let args = ["fit", "-i", "u", "-o", "y", data.to_str().unwrap()];
    let args = FitArgs::try_parse_from(args.into_iter().chain(more.split_whitespace()));
    let args = args.map_err(|error| error.to_string())?;
    planesman_fit::fit(
        &(&args).try_into().map_err(|error| in_one_line(&error))?,
        &(),
    )
    .map_err(|error| in_one_line(&error))
}

fn fit(data: &Path, more: &str) -> FitResult {
    try_fit(data, more).unwrap()
}

/// The model of a fit as a file of that name beside the data.
fn written(data: &Path, name: &str, more: &str) -> PathBuf {
    let path = data.with_file_name(name);
    fit(data, more).model_file().unwrap().write(&path).unwrap();
    path
}

fn try_compare(files: &[&Path], more: &str) -> Result<Comparison, String> {
    crate::by_command_line();
    let files = files.iter().map(|path| path.to_str().unwrap());
    let args = ["compare"].into_iter().chain(files);
    let args = CompareArgs::try_parse_from(args.chain(more.split_whitespace()));
    let args = args.map_err(|error| error.to_string())?;
    let options = CompareOptions::try_from(&args).map_err(|error| format!("{error:#}"))?;
    planesman_fit::compare(&options, &()).map_err(|error| in_one_line(&error))
}

/// The page of a comparison, by the command as it is run.
fn page_of(page: &Path, files: &[&Path]) -> Result<String, String> {
    let files = files.iter().map(|path| path.to_str().unwrap());
    let args = [
        "compare",
        "--format",
        "csv",
        "--html",
        page.to_str().unwrap(),
    ];
    let args = CompareArgs::try_parse_from(args.into_iter().chain(files)).unwrap();
    compare::run(&args).map_err(|error| format!("{error:#}"))?;
    Ok(fs::read_to_string(page).unwrap())
}

fn ahead(model: &Compared, samples: usize) -> f64 {
    let mut predicted = model.judgement.predicted.iter();
    let found = predicted.find(|(ahead, _)| *ahead == samples).unwrap();
    found.1.unwrap()
}

#[test]
fn a_model_file_simulates_its_own_data_as_well_as_the_fit_said() {
    let folder = tempfile::tempdir().unwrap();
    for (b, delay) in [(&B[..], 1), (&[0.3, 1.0, 0.5][..], 0)] {
        let data = table(folder.path(), "a.csv", 4, b, 0.3);
        for method in ["oe", "bj", "armax", "arx", "n4sid", "fir", "rls"] {
            // A recursion has no direct feedthrough.
            if method == "rls" && delay == 0 {
                continue;
            }
            let options = match method {
                "fir" => format!("--method fir --delay {delay}"),
                method => format!("--method {method} --order 2 --delay {delay}"),
            };
            let found = fit(&data, &options);
            let model = data.with_file_name(format!("{method}.yaml"));
            found.model_file().unwrap().write(&model).unwrap();
            let judged = try_compare(&[&model, &data], "").unwrap();
            let judgement = &judged.models[0].judgement;
            let (ours, said) = (judgement.fit.unwrap(), found.analysis.fit.unwrap());
            assert!(
                (ours - said).abs() < 0.02,
                "{method} {delay}: {ours} {said}"
            );
            let predicted = ahead(&judged.models[0], 10);
            let said = found.analysis.predicted_fit.unwrap();
            assert!(
                (predicted - said).abs() < 0.1,
                "{method} {delay}: {predicted} {said}"
            );
            let structure = &judgement.estimate.layout.structure;
            assert_eq!(structure.delay, delay, "{method}");
        }
    }
}

#[test]
fn a_noise_model_predicts_better_than_it_simulates_and_leaves_white_residuals() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let with = written(&data, "with.json", "--method bj --order 2");
    let without = written(&data, "without.yaml", "--method oe --order 2");
    let other = table(folder.path(), "b.csv", 77, &B, 0.3);
    let found = try_compare(&[&with, &without, &other], "--ahead 1,3").unwrap();
    let [with, without] = &found.models[..] else {
        panic!("two models");
    };
    assert!(ahead(with, 1) > with.judgement.fit.unwrap() + 2.0);
    assert!(ahead(with, 1) > ahead(with, 3));
    assert!((ahead(without, 1) - without.judgement.fit.unwrap()).abs() < 0.1);
    let white = |of: &Compared| of.judgement.residuals.as_ref().unwrap().whiteness.passes();
    assert!(white(with) && !white(without));
}

#[test]
fn a_model_from_elsewhere_needs_no_more_than_its_transfer_function() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.0);
    let exact = |name: &str, num: Vec<f64>, offset: f64| {
        let path = folder.path().join(name);
        let file = ModelFile {
            offset,
            ..ModelFile::exact("u", "y", 0.1, num, A.to_vec())
        };
        file.write(&path).unwrap();
        path
    };
    let truth = exact("truth.json", B[1..].to_vec(), 2.0);
    // The same with direct feedthrough that is none, and one of half the gain.
    let padded = exact("padded.json", B.to_vec(), 2.0);
    let half = exact("half.json", vec![0.5, 0.25], 2.0);
    let found = try_compare(&[&truth, &padded, &half, &data], "").unwrap();
    let fits: Vec<f64> = (found.models.iter())
        .map(|it| it.judgement.fit.unwrap())
        .collect();
    assert!(
        fits[0] > 99.99 && (fits[1] - fits[0]).abs() < 1e-9,
        "{fits:?}"
    );
    assert!((40.0..60.0).contains(&fits[2]), "{fits:?}");
}

#[test]
fn an_unstable_model_is_judged_by_its_predictions() {
    let folder = tempfile::tempdir().unwrap();
    // A pole at 1.05, held by u = r - y.
    let (r, e) = (noise(3, 600), noise(9, 600));
    let mut text = String::from("t,u,y");
    let (mut u, mut y) = (0.0, 0.0);
    for k in 0..600 {
        y = 1.05 * y + 0.5 * u + 0.1 * e[k];
        u = r[k] - y;
        let _ = write!(text, "\n{:.3},{u},{y}", 0.1 * k as f64);
    }
    let data = folder.path().join("loop.csv");
    fs::write(&data, text).unwrap();
    let model = written(&data, "unstable.yaml", "--method arx --order 1");
    let found = try_compare(&[&model, &data], "").unwrap();
    assert_eq!(found.models[0].judgement.fit, None);
    assert!(ahead(&found.models[0], 1) > 80.0);
    let tables = tables(&found.models);
    assert!(tables[0].text(Format::Csv).contains(",-,"));
    let page = page_of(&folder.path().join("page.html"), &[&model, &data]);
    assert!(!content(&page.unwrap()).contains("NaN"));
}

#[test]
fn a_vehicles_own_equations_are_judged_like_any_model() {
    let folder = tempfile::tempdir().unwrap();
    let run = Run::SevenFive;
    let heave = run.vehicle().0.heave.unwrap();
    let (u, y) = (run.planes(), run.measured(3, NOISE, BIAS));
    let mut text = String::from("t,u,y");
    for (k, (u, y)) in u.iter().zip(&y).enumerate() {
        let _ = write!(text, "\n{:.3},{u},{y}", SAMPLE_TIME * k as f64);
    }
    let data = folder.path().join("run.csv");
    fs::write(&data, text).unwrap();
    let options = format!(
        "--method vehicle --heave {},{},{},{}",
        heave.to_pitch, heave.damping, heave.from_rate, heave.from_input
    );
    let model = written(&data, "vehicle.yaml", &options);
    let said = ModelFile::read(&model).unwrap();
    let found = try_compare(&[&model, &data], "").unwrap();
    let ours = found.models[0].judgement.fit.unwrap();
    assert!(
        (ours - said.fit.unwrap()).abs() < 1.0,
        "{ours} {:?}",
        said.fit
    );
    let table = tables(&found.models)[2].text(Format::Csv);
    for pole in said.continuous_poles.iter().filter(|it| it.im >= 0.0) {
        let mut cells = table
            .split([',', '\n'])
            .filter_map(|it| it.parse::<f64>().ok());
        let is_told = cells.any(|it| (it / pole.re - 1.0).abs() < 0.01);
        assert!(is_told, "{}: {table}", pole.re);
    }
}

#[test]
fn tables_say_everything_within_eighty_columns_and_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let first = written(&data, "first.yaml", "--method oe --order 2");
    let second = written(&data, "second.yaml", "--method fir");
    let found = try_compare(&[&first, &second, &data], "").unwrap();
    let tables = tables(&found.models);
    let texts: Vec<String> = tables.iter().map(|it| it.text(Format::Table)).collect();
    let text = texts.join("\n");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    for phrase in [
        "10 ahead",
        "uncorrelated with earlier inputs",
        "99 % bound",
        "steady-state gain",
        "phase, deg",
        "(fir)",
    ] {
        assert!(text.contains(phrase), "{phrase}: {text}");
    }
    // The plant's pole is (0.75 +- 0.37i) in z: ln / T = -1.78 +- 4.59i.
    let row = texts[2].lines().find(|it| it.contains("first"));
    let cells: Vec<&str> = row.unwrap().split_whitespace().collect();
    assert!(cells[2].starts_with("-1."), "{text}");
    let json = numbers(&found.models).text(Format::Json);
    let rows: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
    let of = |name: &str| rows.iter().find(|it| it["quantity"] == name).unwrap();
    assert!((of("pole 1 imaginary, 1/s")["value"].as_f64().unwrap() - 4.59).abs() < 0.2);
    assert!(of("pole 1 imaginary, 1/s")["deviation"].as_f64().unwrap() > 0.0);
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let model = written(&data, "model.yaml", "--method oe --order 2");
    let file = ModelFile::read(&model).unwrap();
    let with = |name: &str, file: ModelFile| {
        let path = folder.path().join(name);
        file.write(&path).unwrap();
        path
    };
    let slow = with(
        "slow.yaml",
        ModelFile {
            sample_time: 0.2,
            ..file.clone()
        },
    );
    let fast = with(
        "fast.yaml",
        ModelFile {
            sample_time: 0.01,
            ..file.clone()
        },
    );
    let other = with(
        "other.yaml",
        ModelFile {
            output: "depth".to_owned(),
            ..file
        },
    );
    for (files, more, reasons) in [
        (
            vec![&model, &slow, &data],
            "",
            ["slow.yaml", "0.2 s", "--rate 5"],
        ),
        (
            vec![&fast, &data],
            "",
            ["fast.yaml", "0.01 s", "at most 10"],
        ),
        (vec![&other, &data], "", ["depth", "column", "y"]),
        (
            vec![&model, &other, &data],
            "",
            ["other.yaml", "'depth'", "--output"],
        ),
        (vec![&data], "", ["model file", "json", "yaml"]),
        (vec![&model], "", ["data", "bag", ".csv"]),
        (vec![&model, &data], "--ahead 0", ["--ahead", "0", "1000"]),
    ] {
        let files: Vec<&Path> = files.into_iter().map(PathBuf::as_path).collect();
        let refusal = try_compare(&files, more).unwrap_err();
        for reason in reasons {
            assert!(refusal.contains(reason), "{reason}: {refusal}");
        }
    }
    // A grid for the slow one; the data's own names for the other.
    assert!(try_compare(&[&slow, &data], "").is_ok());
    assert!(try_compare(&[&model, &other, &data], "-o y").is_ok());
}

#[test]
fn validation_data_of_its_own_gives_the_held_out_figures() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let other = table(folder.path(), "b.csv", 77, &B, 0.3);
    let options = "--method oe --order 2";
    let judged = |validation: &str| fit(&data, &format!("{options} --validation {validation}"));
    let found = judged(other.to_str().unwrap());
    // All of the first file is fitted, and the second judges as a comparison does.
    let plain = fit(&data, options);
    assert_eq!(found.analysis.model(), plain.analysis.model());
    let model = written(&data, "model.yaml", options);
    let compared = try_compare(&[&model, &other], "").unwrap();
    let fit = compared.models[0].judgement.fit.unwrap();
    assert!((found.analysis.held_out.fit.unwrap() - fit).abs() < 1e-6);
    assert_eq!(
        found.model_file().unwrap().held_out_fit,
        found.analysis.held_out.fit
    );
    let verdict = found.analysis.sentences().join("\n");
    assert!(
        verdict.contains("validation data, 600 samples"),
        "{verdict}"
    );

    // A window of the same data is left out of the fit, wherever it lies.
    for (window, fitted, held) in [
        ("40..", vec![400], 200),
        ("..20", vec![399], 201),
        ("20..40", vec![200, 199], 201),
    ] {
        let found = judged(window);
        let lengths: Vec<usize> = (found.prepared.resampled.record.segments.iter())
            .map(|it| it.len())
            .collect();
        assert_eq!(lengths, fitted, "{window}");
        let validation = &found.validation.as_ref().unwrap().resampled.record;
        assert_eq!(validation.samples(), held, "{window}");
    }
    for (more, reason) in [
        ("--window 0..30 --validation 20..40", "overlaps"),
        (
            "--validation nothing.csv",
            "'nothing.csv' is neither an existing file or folder",
        ),
        ("--validation 40..20", "reversed"),
        ("--validation 100..200", "validation data"),
    ] {
        let refusal = try_fit(&data, &format!("{options} {more}")).unwrap_err();
        assert!(refusal.contains(reason), "{more}: {refusal}");
    }
}

#[test]
fn in_a_loop_validation_data_is_judged_by_what_its_reference_causes() {
    let folder = tempfile::tempdir().unwrap();
    // y = 0.2 q^-1 / (1 - 0.9 q^-1) u + v, u = r - 2 y, v strong and slow.
    let (r, e) = (noise(5, 3000), noise(82, 3000));
    let mut text = String::from("t,r,u,y");
    let (mut u, mut x, mut v) = (0.0, 0.0, 0.0);
    for k in 0..3000 {
        x = 0.9 * x + 0.2 * u;
        v = 0.8 * v + 0.3 * e[k];
        u = r[k] - 2.0 * (x + v);
        let _ = write!(text, "\n{:.3},{},{u},{}", 0.1 * k as f64, r[k], x + v);
    }
    let data = folder.path().join("loop.csv");
    fs::write(&data, text).unwrap();
    let found = fit(
        &data,
        "--method oe --order 1 --reference r --validation 200..",
    );
    let (held, fitted) = (found.analysis.held_out.fit, found.analysis.fit);
    assert!(
        (held.unwrap() - fitted.unwrap()).abs() < 5.0,
        "{held:?} {fitted:?}"
    );
}

#[test]
fn of_all_methods_the_one_that_simulates_held_out_data_best_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let found = fit(&data, "--method all --order 2 --delay 1");
    let fits: Vec<f64> = (found.tried.iter())
        .filter_map(|it| it.outcome.as_ref().ok()?.held_out.fit)
        .collect();
    assert!(fits.len() >= 10, "{fits:?}");
    let best = fits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(found.analysis.held_out.fit, Some(best));
    assert_eq!(found.model_file().unwrap().held_out_fit, Some(best));
    // Least squares takes the slow noise for dynamics.
    assert_ne!(found.model_file().unwrap().method, "least_squares");
    let refusal = try_fit(&data, "--method fir --order 3 --numerator 2").unwrap_err();
    assert!(refusal.contains("Use --order for the number"), "{refusal}");
}

#[test]
fn the_page_of_a_comparison_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let first = written(&data, "first.yaml", "--method oe --order 2");
    let second = written(&data, "second.yaml", "--method fir");
    let page = page_of(&folder.path().join("page.html"), &[&first, &second, &data]).unwrap();
    for heading in [
        "Measured and simulated output",
        "Magnitude",
        "Phase",
        "Poles",
        "Step responses",
        "Residual autocorrelation",
        "Cross-correlation of residual and input",
    ] {
        assert!(page.contains(heading), "{heading}");
    }
    let page = content(&page);
    assert_eq!(page.matches("<figure class=\"plot").count(), 8);
    assert!(!page.contains(" src=") && !page.contains("NaN"));
}

#[test]
fn a_model_file_with_any_numbers_gives_an_answer_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let data = table(folder.path(), "a.csv", 4, &B, 0.3);
    let good = written(&data, "good.json", "--method bj --order 2");
    let text = fs::read(&good).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let bad = folder.path().join("bad.json");
    let (mut judged, mut refused) = (0, 0);
    for number in 0..300 {
        let mut changed = text.clone();
        if number % 3 == 0 {
            changed = mutated(&changed, &mut random);
        } else {
            // Numbers that stay numbers, of any size.
            let digits: Vec<usize> = (0..changed.len())
                .filter(|at| changed[*at].is_ascii_digit())
                .collect();
            for _ in 0..random.random_range(1..20) {
                let at = digits[random.random_range(0..digits.len())];
                changed[at] = b"0123456789e-."[random.random_range(0..13)];
            }
        }
        fs::write(&bad, changed).unwrap();
        // A page that exists is refused.
        let page = folder.path().join(format!("{number}.html"));
        match page_of(&page, &[&bad, &good, &data]) {
            Ok(page) => {
                judged += 1;
                assert!(!content(&page).contains("NaN"), "{number}");
            }
            Err(reason) => {
                refused += 1;
                assert!(!reason.is_empty());
            }
        }
    }
    assert!(judged > 20 && refused > 20, "{judged} {refused}");
}
