//! `planesman sysid fit` on CSV files: loops with a reference, several runs, long records, and refusals.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME};
use clap::Parser;
use planesman::sysid::fit::FitArgs;
use planesman_equations::{Equations, EquationsFile};
use planesman_fit::FitResult;
use planesman_identification::{PART, filter, noise, with_noise};
use planesman_text::in_one_line;

/// Columns at 20 Hz, the first of them named so, in a table of that name.
fn table(folder: &Path, name: &str, columns: &[(&str, &[f64])]) -> PathBuf {
    let mut text = String::from("t");
    for (name, _) in columns {
        let _ = write!(text, ",{name}");
    }
    for k in 0..columns[0].1.len() {
        let _ = write!(text, "\n{:.3}", 0.05 * k as f64);
        for (_, values) in columns {
            let _ = write!(text, ",{}", values[k]);
        }
    }
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

fn try_fit(data: &[PathBuf], more: &str) -> Result<FitResult, String> {
    crate::by_command_line();
    let data = data.iter().map(|path| path.to_str().unwrap());
    let args = ["fit", "-i", "u", "-o", "y"].into_iter().chain(data);
    let args = FitArgs::try_parse_from(args.chain(more.split_whitespace()));
    let args = args.map_err(|error| error.to_string())?;
    planesman_fit::fit(
        &(&args).try_into().map_err(|error| in_one_line(&error))?,
        &(),
    )
    .map_err(|error| in_one_line(&error))
}

fn fit(data: &[PathBuf], more: &str) -> FitResult {
    try_fit(data, more).unwrap()
}

fn says(found: &FitResult, phrase: &str) -> bool {
    let sentences = found.analysis.sentences();
    sentences.iter().any(|sentence| sentence.contains(phrase))
}

/// y = 0.2 q^-1 / (1 - 0.9 q^-1) u + v, u = r - 2 y, v strong and slow: r, u and y.
fn closed_loop(count: usize) -> [Vec<f64>; 3] {
    let (r, e) = (noise(5, count), noise(82, count));
    let (mut u, mut y) = (Vec::<f64>::new(), Vec::<f64>::new());
    let (mut x, mut v) = (0.0, 0.0);
    for k in 0..count {
        x = 0.9 * x + u.last().map_or(0.0, |u| 0.2 * u);
        v = 0.8 * v + 0.3 * e[k];
        y.push(x + v);
        u.push(r[k] - 2.0 * y[k]);
    }
    [r, u, y]
}

#[test]
fn a_loop_is_noticed_and_its_reference_sets_the_model_right() {
    let folder = tempfile::tempdir().unwrap();
    let [r, u, y] = closed_loop(4000);
    let data = [table(
        folder.path(),
        "a.csv",
        &[("r", &r), ("u", &u), ("y", &y)],
    )];
    let direct = fit(&data, "--order 1");
    let text = direct.analysis.text();
    assert!(says(&direct, "closed-loop"), "{text}");
    assert!(says(&direct, "--reference"), "{text}");

    // Output error has no noise model to keep the noise that went round apart.
    let direct = fit(&data, "--order 1 --method output_error");
    let staged = fit(&data, "--order 1 --method output_error --reference r");
    let text = staged.analysis.text();
    assert!(
        says(
            &staged,
            "noise that returns through the feedback biases the direct fit"
        ),
        "{text}"
    );
    assert!(!says(&staged, "closed-loop"), "{text}");
    let off = |found: &FitResult| {
        let gain = found.analysis.reading().steady_state_gain().unwrap();
        (gain.value.re - 2.0).abs() / gain.real_deviation()
    };
    assert!(off(&staged) < 4.0, "{text}");
    assert!(off(&direct) > 10.0, "{}", direct.analysis.text());
}

#[test]
fn windows_and_files_are_runs_of_one_model_and_may_keep_their_numerators() {
    let folder = tempfile::tempdir().unwrap();
    let run = Run::NineOne;
    let (u, y) = (run.planes(), run.measured(3, 0.0, BIAS));
    let doubled: Vec<f64> = run.clean().iter().map(|y| 2.0 * y).collect();
    let a = table(folder.path(), "a.csv", &[("u", &u), ("y", &y)]);
    let b = table(folder.path(), "b.csv", &[("u", &u), ("y", &doubled)]);

    let found = fit(&[a.clone(), b], "--order 3 --own-numerators");
    let analysis = &found.analysis;
    assert_eq!(found.prepared.resampled.record.segments.len(), 2);
    assert_eq!(found.prepared.resampled.outputs[0].timing.samples, 480);
    let gains = [0, 1].map(|run| analysis.estimate.model(run).b[0]);
    assert!((gains[1] / gains[0] - 2.0).abs() < 1e-4, "{gains:?}");
    assert!((analysis.model().a[0] - run.plant().a[0]).abs() < 1e-4);
    assert_eq!(analysis.text().matches("numerator  ").count(), 2);

    let found = fit(&[a], "--order 3 --window 0.5..5 --window 5..11.5");
    assert_eq!(found.prepared.resampled.record.segments.len(), 2);
    assert_eq!(
        found.prepared.resampled.record.segments[1].start,
        5_000_000_000
    );
    assert!((found.analysis.model().a[0] - run.plant().a[0]).abs() < 1e-3);
}

#[test]
fn a_long_records_order_is_sought_where_the_input_moves_and_all_of_it_is_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let count = 3 * PART;
    let mut u = noise(7, count);
    u[..PART].fill(0.0);
    let y = with_noise(&filter(&[0.0, 0.2], &[1.0, -0.9], &u), 8, 0.1);
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let found = fit(&data, "--method least_squares --delay 1");
    assert!(
        says(&found, "of 30000 samples"),
        "{}",
        found.analysis.text()
    );
    assert_eq!(found.analysis.search.samples, PART);

    let found = fit(&data, "--order 1");
    let pole = found.analysis.reading().poles().unwrap()[0];
    let rows = found.analysis.estimate.residuals[0].len();
    assert_eq!(rows, count);
    assert!((pole.value.re - 0.9).abs() < 4.0 * pole.real_deviation());
}

#[test]
fn the_vehicles_coefficients_come_out_and_with_its_inertia_the_moments() {
    let folder = tempfile::tempdir().unwrap();
    let run = Run::SevenFive;
    let (known, [kappa, beta, _]) = run.vehicle();
    let heave = known.heave.unwrap();
    let (u, y) = (run.planes(), run.measured(3, NOISE, BIAS));
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let heave = format!(
        "--heave {},{},{},{}",
        heave.to_pitch, heave.damping, heave.from_rate, heave.from_input
    );
    for method in ["vehicle", "kalman"] {
        let found = fit(&data, &format!("--method {method} --inertia 2 {heave}"));
        let named = found.analysis.physical().unwrap().named();
        for ((name, value, deviation), truth) in named.iter().zip([kappa, beta]) {
            assert!(
                (value - truth).abs() < 4.0 * deviation,
                "{name}: {value} {truth}"
            );
        }
        let text = found.analysis.text();
        assert!(
            text.contains("K/J  ") && text.contains("M_theta  "),
            "{text}"
        );
        let file = found.model_file().unwrap();
        let physical = file.physical.unwrap();
        assert_eq!((physical.kappa, physical.beta), (named[0].1, named[1].1));
        assert_eq!(
            physical.heave.unwrap().damping,
            known.heave.unwrap().damping
        );
        assert_eq!(file.method, method);
        assert_eq!(file.sample_time, SAMPLE_TIME);
        let doubtful = fit(
            &data,
            &format!("--method {method} {heave} --heave-doubt 20"),
        );
        assert_eq!(doubtful.analysis.physical().unwrap().named().len(), 7);
    }
    // Second order with a zero at 1 is the pitch equation.
    let found = fit(&data, "--order 2 --zeros-at-one 1");
    assert_eq!(found.analysis.physical().unwrap().named().len(), 3);
    assert!(fit(&data, "--order 2").analysis.physical().is_none());
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let run = Run::SevenFive;
    let (u, y) = (run.planes(), run.clean());
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    for (more, reason) in [
        (
            "--method vehicle --order 3",
            "takes order, delay and zeros from the vehicle's equations",
        ),
        (
            "--order 2 --heave 1,2,3,4",
            "need --method vehicle or kalman",
        ),
        ("--method vehicle --heave 1,2,3", "expected four numbers"),
        ("--method vehicle --heave 1,2,3,nan", "'nan' is not finite"),
        ("--method guesswork", "output_error"),
        ("--inertia 0", "above 0"),
        ("--reference z", "no column 'z'"),
        ("--window 3..2", "'3..2' is reversed; write 2..3"),
        ("--window 3", "not a window"),
        ("--prefilter ..", "not a band"),
    ] {
        let refusal = try_fit(&data, more).unwrap_err();
        assert!(refusal.contains(reason), "{more}: {refusal}");
    }
}

#[test]
fn methods_are_known_by_the_names_of_other_tools() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = (Run::NineOne.planes(), Run::NineOne.measured(3, NOISE, 0.0));
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    for (name, method) in [
        ("arx", "least_squares"),
        ("oe", "output_error"),
        ("rls", "recursive_least_squares"),
    ] {
        let found = fit(&data, &format!("--order 2 --method {name}"));
        assert_eq!(found.model_file().unwrap().method, method);
    }
    let refusal = try_fit(&data, "--method arxx").unwrap_err();
    assert!(refusal.contains("arx"), "{refusal}");
}

#[test]
fn the_numerator_may_have_an_order_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let u = noise(4, 500);
    let y = filter(&[0.0, 0.0, 0.3], &[1.0, -1.6, 0.8, -0.1], &u);
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let found = fit(
        &data,
        "--method arx --order 3 --numerator 1 --delay 2 --no-offset",
    );
    let model = found.analysis.model();
    assert_eq!((model.a.len(), model.b.len()), (3, 3));
    for (found, expected) in model.b.iter().zip([0.0, 0.3, 0.0]) {
        assert!((found - expected).abs() < 1e-9, "{model:?}");
    }
}

#[test]
fn a_recursion_forgets_as_it_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let u = noise(4, 1000);
    // The gain doubles halfway.
    let y = filter(&[0.0, 0.2], &[1.0, -0.5], &u);
    let y: Vec<f64> = (0..1000)
        .map(|k| if k < 500 { y[k] } else { 2.0 * y[k] })
        .collect();
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let gain = |more: &str| {
        let found = fit(&data, &format!("--method rls --order 1 --no-offset {more}"));
        found.analysis.model().b[0]
    };
    assert!((gain("--forgetting 0.95") - 0.4).abs() < 1e-6);
    assert!((gain("") - 0.4).abs() > 0.05);
    // A strong prior keeps the parameters small.
    assert!(gain("--initial-covariance 1e-6").abs() < 0.01);
    let refusal = try_fit(&data, "--method arx --order 1 --forgetting 0.9").unwrap_err();
    assert!(refusal.contains("only to recursive methods"), "{refusal}");
}

#[test]
fn zeros_in_front_are_the_start_of_the_thesis() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = (Run::EightOne.planes(), Run::EightOne.clean());
    // In motion: the first thirty samples are gone.
    let (u, y) = (&u[30..], &y[30..]);
    let data = [table(folder.path(), "a.csv", &[("u", u), ("y", y)])];
    for method in ["arx", "rls --initial-covariance 1e14"] {
        let found = fit(
            &data,
            &format!("--method {method} --order 3 --no-offset --prewindow"),
        );
        // `.8753, .0533, -.0491` for rows that begin with the first sample, reckoned apart from this program.
        let mut poles = found.analysis.model().poles().unwrap();
        poles.sort_by(|a, b| b.re.total_cmp(&a.re));
        for (pole, expected) in poles.iter().zip([0.8753, 0.0533, -0.0491]) {
            assert!((pole.re - expected).abs() < 6e-5, "{method}: {poles:?}");
        }
        let file = found.model_file().unwrap();
        assert!(file.preparation[0].contains("3 zeros"), "{file:?}");
    }
    let refusal = try_fit(&data, "--prewindow").unwrap_err();
    assert!(refusal.contains("--order"), "{refusal}");
}

#[test]
fn preparation_is_named_and_kept_in_the_model_file() {
    let folder = tempfile::tempdir().unwrap();
    let (u, mut y) = (Run::NineOne.planes(), Run::NineOne.clean());
    let mut u = u;
    // Twenty seconds in which nothing happens.
    u.extend([0.0; 400]);
    y.extend([0.0; 400]);
    y[100] = 1e6;
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let found = fit(&data, "--order 3 --outliers drop --segment auto");
    let file = found.model_file().unwrap();
    assert!(
        file.preparation[0].contains("y: 1 sample far from the neighbours, the first at 5.000 s"),
        "{file:?}"
    );
    assert!(
        file.preparation[1].contains("the longest part in which u moves"),
        "{file:?}"
    );
    assert!(found.prepared.description().contains("1.0000e6"));
    assert!(found.prepared.resampled.record.samples() < 400);
    let coarse = fit(
        &data,
        "--order 3 --method arx --rate 5 --detrend line --outliers keep",
    );
    let steps: Vec<&str> = coarse
        .prepared
        .steps
        .iter()
        .map(|it| it.name.name())
        .collect();
    assert_eq!(steps, ["decimation", "detrend", "detrend"]);
    assert!(
        coarse
            .prepared
            .description()
            .contains("--output-method centred")
    );
    for (more, done) in [
        ("", "replaced by the straight line"),
        ("--outliers report", "--outliers drop"),
    ] {
        let fitted = fit(&data, &format!("--order 3 --method arx {more}"));
        let file = fitted.model_file().unwrap();
        assert!(file.preparation[0].contains(done), "{file:?}");
    }
}

#[test]
fn a_prefilter_keeps_the_model_and_leaves_a_slow_disturbance_out() {
    let folder = tempfile::tempdir().unwrap();
    let u: Vec<f64> = noise(3, 200)
        .iter()
        .flat_map(|level| [level.signum(); 5])
        .collect();
    let y: Vec<f64> = filter(&[0.0, 0.2, 0.1], &[1.0, -1.6, 0.63], &u)
        .iter()
        .zip(noise(4, u.len()))
        .enumerate()
        .map(|(k, (y, e))| y + 0.05 * e + 20.0 * libm::sin(0.01 * k as f64))
        .collect();
    let data = [table(folder.path(), "a.csv", &[("u", &u), ("y", &y)])];
    let found = fit(
        &data,
        "--method bj --order 2 --prefilter 0.2.. --bootstrap 100",
    );
    let steps: Vec<&str> = found
        .prepared
        .steps
        .iter()
        .map(|it| it.name.name())
        .collect();
    assert_eq!(steps, ["prefilter"]);
    let poles = found.analysis.model().poles().unwrap();
    assert!(
        (poles[0].re - 0.9).abs() < 0.02 && (poles[1].re - 0.7).abs() < 0.05,
        "{poles:?}"
    );
    let bootstrap = found.analysis.bootstrap.as_ref().unwrap();
    assert_eq!((bootstrap.refits, bootstrap.poles.len()), (100, 2));
    let ((least, most), _) = bootstrap.poles[0];
    assert!(least < 20.0 * libm::log(0.9_f64) && 20.0 * libm::log(0.9_f64) < most);
    let text = found.analysis.text();
    assert_eq!(text.matches("\n  bootstrap").count(), 3, "{text}");
}

/// The equations of x' = -a x + b u.
const EQUATIONS: &str = "inputs: [u]
outputs: {y: {equation: x, unit: m}}
states: {x: {derivative: -a*x + b*u, initial: unknown}}
parameters: {a: {start: 0.5, min: 0.01, unit: 1/s}, b: {start: 1}}
";

#[test]
fn equations_of_ones_own_need_no_signals_by_name_and_are_written_back() {
    let folder = tempfile::tempdir().unwrap();
    let count = 600;
    let u: Vec<f64> = noise(3, count / 10)
        .iter()
        .flat_map(|it| [*it; 10])
        .collect();
    // x' = -2 x + 3 u, exact behind a hold.
    let share = libm::exp(-0.1_f64);
    let mut x = vec![0.2];
    for k in 1..count {
        x.push(share * x[k - 1] + 1.5 * (1.0 - share) * u[k - 1]);
    }
    let y: Vec<f64> = x
        .iter()
        .zip(noise(4, count))
        .map(|(x, e)| x + 0.02 * e)
        .collect();
    let data = table(folder.path(), "run.csv", &[("u", &u), ("y", &y)]);
    let file = folder.path().join("first.yaml");
    fs::write(&file, EQUATIONS).unwrap();
    let fitted = folder.path().join("fitted.yaml");
    let page = folder.path().join("fit.html");
    let args = |more: &[&str]| {
        let begin = ["fit", data.to_str().unwrap(), "--quiet"];
        FitArgs::try_parse_from(begin.iter().chain(more))
    };
    assert!(args(&[]).is_err(), "signals are needed without equations");
    let [file, fitted, page] = [&file, &fitted, &page].map(|it| it.to_str().unwrap());
    let of = args(&["--equations", file, "--model", fitted, "--html", page]).unwrap();
    planesman::sysid::fit::run(&of).unwrap();
    let written = EquationsFile::read(Path::new(fitted)).unwrap();
    for ((_, of), truth) in written.parameters.0.iter().zip([2.0, 3.0]) {
        let (value, deviation) = (of.start.unwrap(), of.deviation.unwrap());
        assert!(
            (value - truth).abs() < 4.0 * deviation && deviation < 0.1,
            "{value} {truth}"
        );
    }
    assert!(
        fs::read_to_string(page)
            .unwrap()
            .contains("y, measured and simulated")
    );
    fs::remove_file(page).unwrap();
    assert!(args(&["--equations", file, "--continuous", "-i", "u", "-o", "y"]).is_err());
    let of = args(&[
        "--continuous",
        "--order",
        "1",
        "-i",
        "u",
        "-o",
        "y",
        "--html",
        page,
    ])
    .unwrap();
    planesman::sysid::fit::run(&of).unwrap();
    assert!(
        fs::read_to_string(page)
            .unwrap()
            .contains("e^(-tau s) / (s + a0)")
    );
    fs::write(file, EQUATIONS.replace("b*u", "b*v")).unwrap();
    let of = args(&["--equations", file]).unwrap();
    let refusal = planesman::sysid::fit::run(&of).unwrap_err();
    let refusal = format!("{refusal:#}");
    let said = "first.yaml: states: x: derivative: character 10: 'v' is not an input, state, parameter or definition";
    assert!(refusal.contains(said), "{refusal}");
}

#[test]
fn the_equations_that_are_shipped_are_equations() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch-scripts/equations");
    let files = fs::read_dir(folder).unwrap().map(|it| it.unwrap().path());
    let names = files.map(|path| {
        let file = EquationsFile::read(&path).unwrap();
        Equations::new(file).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    });
    assert_eq!(names.count(), 7);
}
