//! Gains of `planesman tune` and `planesman design optimise` beside the best that scipy has found.
//!
//! `tests/peers/best_gains.json` is the record of `tests/peers/best_gains.py`: of each case the sampled system, the limits and the best gains. Both sides'
//! gains are judged here by the same few lines, on the recorded system.

use std::process::Command;

use planesman_linear::{Complex, ComplexFunctions as _, DMatrix, polar};
use planesman_model_file::ModelFile;
use planesman_tuning::{Kind, Method, TuneOptions, tune};
use serde_json::Value;

/// The share by which the error may lie above that of scipy's gains.
const WITHIN: f64 = 0.01;
/// Frequencies between which margins are interpolated.
const FREQUENCIES: usize = 3000;

fn record() -> Value {
    serde_json::from_str(include_str!("../peers/best_gains.json")).unwrap()
}

fn numbers(of: &Value) -> Vec<f64> {
    let all = of.as_array().unwrap_or_else(|| panic!("{of}"));
    all.iter().map(|it| it.as_f64().unwrap()).collect()
}

fn number(of: &Value, at: &str) -> f64 {
    of.pointer(at)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{at} in {of}"))
}

/// What gains do on a recorded system.
#[derive(Debug)]
struct Outcome {
    cost: f64,
    /// rad
    phase: f64,
    /// The least factor above 1 by which the gain may grow or fall.
    gain: f64,
    sensitivity: f64,
    /// %
    overshoot: f64,
}

/// Frequencies as angles a tick, and the open loop there.
fn open_loop(at: impl Fn(Complex<f64>) -> Complex<f64>) -> Vec<Complex<f64>> {
    let angle =
        |k: usize| std::f64::consts::PI * libm::pow(1e-4, 1.0 - k as f64 / FREQUENCIES as f64);
    (0..=FREQUENCIES)
        .map(|k| at(polar(1.0, angle(k))))
        .collect()
}

/// Phase margin, gain margin and sensitivity peak of an open loop between its points.
fn margins(open: &[Complex<f64>]) -> (f64, f64, f64) {
    let (mut phase, mut gain, mut peak) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
    for pair in open.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let sizes = [a, b].map(|it| libm::log(it.modulus()));
        let between = |share: f64| a + (b - a) * share;
        if sizes[0] * sizes[1] <= 0.0 {
            phase = phase.min(
                (-between(sizes[0] / (sizes[0] - sizes[1])))
                    .argument()
                    .abs(),
            );
        }
        if a.im * b.im < 0.0 && a.re < 0.0 && b.re < 0.0 {
            let size = between(a.im / (a.im - b.im)).modulus();
            gain = gain.min(size.max(1.0 / size));
        }
        peak = peak.max(1.0 / (b + 1.0).modulus());
    }
    if let Some(last) = open.last().filter(|it| it.re < 0.0) {
        gain = gain.min(last.modulus().max(1.0 / last.modulus()));
    }
    (phase, gain, peak)
}

/// Of a PID controller (kp, ki, kd, filter) on a recorded plant: the integrated absolute error after a unit step of the load.
fn pid(case: &Value, gains: &[f64]) -> Outcome {
    let [a, b] = ["a", "b"].map(|name| numbers(&case[name]));
    let (tick, ticks) = (
        number(case, "/tick"),
        case["ticks"].as_u64().unwrap() as usize,
    );
    let [kp, ki, kd, filter] = *gains else {
        panic!("{gains:?}")
    };
    let polynomial = |c: &[f64], q: Complex<f64>| {
        let zero = Complex::from(0.0);
        c.iter().rev().fold(zero, |sum, c| sum * q + *c)
    };
    let open = open_loop(|z| {
        let q = z.inv();
        let control =
            (1.0 - q).inv() * ki * tick + (1.0 - q) * kd / (filter + tick - q * filter) + kp;
        control * polynomial(&b, q) / polynomial(&a, q)
    });
    let (mut y, mut u) = (vec![0.0; ticks], vec![0.0; ticks]);
    let (mut integral, mut derivative, mut before) = (0.0, 0.0, 0.0);
    for k in 0..ticks {
        let past = |c: &[f64], of: &[f64]| {
            (1..c.len().min(k + 1))
                .map(|j| c[j] * of[k - j])
                .sum::<f64>()
        };
        y[k] = past(&b, &u) - past(&a, &y);
        integral -= ki * tick * y[k];
        derivative = (filter * derivative - kd * (y[k] - before)) / (filter + tick);
        before = y[k];
        u[k] = 1.0 - kp * y[k] + integral + derivative;
    }
    let (phase, gain, sensitivity) = margins(&open);
    let cost = y.iter().map(|y| tick * y.abs()).sum();
    Outcome {
        cost,
        phase,
        gain,
        sensitivity,
        overshoot: 0.0,
    }
}

/// Of the dive loop's gains (Kpz, Kdz, Kpy, Kr): the largest over the speeds of ITAE U^2 after a unit step of the depth setpoint.
fn dive(case: &Value, gains: &[f64]) -> Outcome {
    let [kpz, kdz, kpy, kr] = *gains else {
        panic!("{gains:?}")
    };
    let (tick, duration) = (number(case, "/tick"), number(case, "/limits/duration"));
    let mut worst = Outcome {
        cost: 0.0,
        phase: f64::INFINITY,
        gain: f64::INFINITY,
        sensitivity: 0.0,
        overshoot: 0.0,
    };
    for (system, speed) in case["systems"]
        .as_array()
        .unwrap()
        .iter()
        .zip(numbers(&case["speeds"]))
    {
        let matrix = |name: &str| {
            let rows: Vec<_> = system[name]
                .as_array()
                .unwrap()
                .iter()
                .map(numbers)
                .collect();
            DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
        };
        let (a, rows) = (matrix("a"), matrix("rows"));
        let b = DMatrix::from_vec(a.nrows(), 1, numbers(&system["b"]));
        let law = DMatrix::from_row_slice(1, 4, &[kr, kpy, -kpy * kpz, -kpy * kdz]) * &rows;
        let complex = |it: &DMatrix<f64>| it.map(Complex::from);
        let (ac, bc, lawc) = (complex(&a), complex(&b), complex(&law));
        let open = open_loop(|z| {
            let identity = DMatrix::identity(a.nrows(), a.nrows());
            let x = (identity * z - &ac).lu().solve(&bc).unwrap();
            -(&lawc * x)[(0, 0)]
        });
        let (phase, gain, sensitivity) = margins(&open);
        let count = (duration / tick).round() as usize + 1;
        let (mut x, mut itae) = (DMatrix::zeros(a.nrows(), 1), 0.0);
        for k in 0..count {
            let z = (rows.rows(2, 1) * &x)[(0, 0)];
            worst.overshoot = worst.overshoot.max(100.0 * (z - 1.0));
            let share = if k + 1 == count { 0.5 } else { 1.0 };
            itae += share * tick * (k as f64 * tick) * f64::abs(1.0 - z);
            let planes = (&law * &x)[(0, 0)] + kpy * kpz;
            x = &a * x + &b * planes;
        }
        worst.cost = worst.cost.max(itae * speed * speed);
        worst.phase = worst.phase.min(phase);
        worst.gain = worst.gain.min(gain);
        worst.sensitivity = worst.sensitivity.max(sensitivity);
    }
    worst
}

/// Whether the limits are kept to within a share, which stands for rounding and interpolation.
fn keeps(case: &Value, found: &Outcome, gains: &[f64], share: f64) -> bool {
    let limits = &case["limits"];
    let least = |at: &str| number(limits, at) * (1.0 - share);
    let most = |at: &str| {
        limits
            .get(at)
            .and_then(Value::as_f64)
            .map_or(f64::INFINITY, |it| it * (1.0 + share))
    };
    let asked = gains[0] * limits.get("step").and_then(Value::as_f64).unwrap_or(0.0);
    found.phase.to_degrees() >= least("/phase")
        && 20.0 * libm::log10(found.gain) >= least("/gain")
        && found.sensitivity <= most("ms")
        && found.overshoot <= most("overshoot") + share
        && asked.to_degrees() <= most("pitch")
        && (asked * gains[2]).to_degrees() <= most("planes")
}

/// That our gains keep the limits and cost as little as scipy's, both judged by the same lines.
fn compare(case: &Value, own: &[f64], judge: fn(&Value, &[f64]) -> Outcome) {
    let best = numbers(&case["best"]["gains"]);
    let (found, scipy) = (judge(case, own), judge(case, &best));
    println!(
        "{}: {own:?} {:.5}, scipy {best:?} {:.5}, {:+.3} %",
        case["name"],
        found.cost,
        scipy.cost,
        100.0 * (found.cost / scipy.cost - 1.0)
    );
    // What is compared with is what scipy found, by its own account too.
    let told = number(case, "/best/cost");
    assert!((scipy.cost / told - 1.0).abs() < 1e-6, "{case} {scipy:?}");
    assert!(keeps(case, &scipy, &best, 2e-3), "{case} {scipy:?}");
    assert!(keeps(case, &found, own, 2e-3), "{case} {found:?}");
    assert!(
        found.cost <= (1.0 + WITHIN) * scipy.cost,
        "{case} {found:?}"
    );
}

#[test]
fn optimised_gains_have_the_least_error_that_scipy_finds() {
    let record = record();
    let cases = record["pid"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    for case in cases {
        let [mut a, mut b] = ["a", "b"].map(|name| numbers(&case[name]));
        let order = a.len().max(b.len());
        a.resize(order, 0.0);
        b.resize(order, 0.0);
        let limits = &case["limits"];
        let options = TuneOptions {
            method: Some(Method::Optimise),
            controller: Some(Kind::Pid),
            phase_margin: number(limits, "/phase"),
            gain_margin: number(limits, "/gain"),
            ms: number(limits, "/ms"),
            ..TuneOptions::default()
        };
        let found = tune(
            &ModelFile::exact("u", "y", number(case, "/tick"), b, a),
            &options,
        )
        .unwrap();
        let gains = found.controller;
        assert!(found.keeps_limits());
        compare(case, &[gains.kp, gains.ki, gains.kd, gains.filter], pid);
    }
}

/// `planesman design optimise` for a case, from these gains.
fn optimise(case: &Value, start: &[&str]) -> String {
    let limits = &case["limits"];
    let text = |at: &str| number(limits, at).to_string();
    let speeds: Vec<String> = numbers(&case["speeds"])
        .iter()
        .map(f64::to_string)
        .collect();
    let actuator = if case["lag"].is_null() {
        "ideal"
    } else {
        "first_order"
    };
    let printed = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args([
            "design",
            "optimise",
            "brunner",
            "--actuator",
            actuator,
            "--speed",
            &speeds.join(","),
        ])
        .args([
            "--phase-margin",
            &text("/phase"),
            "--gain-margin",
            &text("/gain"),
            "--overshoot",
            &text("/overshoot"),
        ])
        .args([
            "--step",
            &text("/step"),
            "--pitch-limit",
            &text("/pitch"),
            "--planes-limit",
            &text("/planes"),
            "--duration",
            &text("/duration"),
        ])
        .args(start)
        .output()
        .unwrap();
    assert!(
        printed.status.success(),
        "{}",
        String::from_utf8_lossy(&printed.stderr)
    );
    String::from_utf8(printed.stdout).unwrap()
}

fn gains_in(text: &str) -> Vec<f64> {
    let of = |name: &str| {
        let rest = text
            .split_once(name)
            .unwrap_or_else(|| panic!("{name} in {text}"))
            .1;
        let word = rest.split_whitespace().next().unwrap();
        word.trim_end_matches(',').parse().unwrap()
    };
    ["Kpz ", "Kdz ", "Kpy ", "Kr "].map(of).to_vec()
}

#[test]
fn dive_gains_have_the_least_error_that_scipy_finds() {
    let record = record();
    let cases = record["dive"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    std::thread::scope(|scope| {
        for case in cases {
            scope.spawn(|| compare(case, &gains_in(&optimise(case, &[])), dive));
        }
    });
}

#[test]
fn dive_gains_do_not_depend_on_the_start() {
    let record = record();
    let case = &record["dive"][0];
    let other = [
        "--depth-p",
        "2",
        "--depth-d",
        "0.1",
        "--pitch-p",
        "3",
        "--pitch-rate",
        "5",
    ];
    assert_eq!(
        gains_in(&optimise(case, &[])),
        gains_in(&optimise(case, &other))
    );
}
