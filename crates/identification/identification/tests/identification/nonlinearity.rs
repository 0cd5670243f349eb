//! Plants that are not linear, or change, are told from linear ones whatever their noise; each is integrated here by Runge and
//! Kutta's method.

use planesman_identification::analysis::{Analysis, Options, Verdict, analyse};
use planesman_identification::estimators::Method;
use planesman_identification::static_curve::StaticCurve;
use planesman_identification::validation::nonlinearity::Cause;
use planesman_identification::{Record, filter, noise};

/// s
const STEP: f64 = 0.05;
const SAMPLES: usize = 1500;

/// Levels between -1 and 1, each held for 10 to 40 samples.
fn levels(seed: u32) -> Vec<f64> {
    let random = noise(seed, SAMPLES);
    let share = |it: f64| it.rem_euclid(1.0);
    let mut levels = Vec::new();
    for pair in random.chunks(2) {
        let long = 10 + (30.0 * share(7.0 * pair[0])) as usize;
        levels.extend(vec![2.0 * share(5.0 * pair[1]) - 1.0; long]);
    }
    levels.truncate(SAMPLES);
    levels
}

/// The response from rest of `y'' = 3 u - 1.2 y' - 4 y - more(y')` to an input that is held between samples.
fn response(input: &[f64], more: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let h = STEP / 20.0;
    let (mut y, mut v) = (0.0, 0.0);
    let mut outputs = Vec::with_capacity(input.len());
    for u in input {
        outputs.push(y);
        let f = |y: f64, v: f64| (v, 3.0 * u - 1.2 * v - 4.0 * y - more(v));
        for _ in 0..20 {
            let k1 = f(y, v);
            let k2 = f(y + h / 2.0 * k1.0, v + h / 2.0 * k1.1);
            let k3 = f(y + h / 2.0 * k2.0, v + h / 2.0 * k2.1);
            let k4 = f(y + h * k3.0, v + h * k3.1);
            y += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            v += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
        }
    }
    outputs
}

fn linear(input: &[f64]) -> Vec<f64> {
    response(input, &|_| 0.0)
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn plus(signal: &[f64], other: &[f64], size: f64) -> Vec<f64> {
    let pairs = signal.iter().zip(other);
    pairs.map(|(it, other)| it + size * other).collect()
}

/// Second order by output error: the true structure, where the plant is linear.
fn fitted(input: &[f64], output: Vec<f64>) -> Analysis {
    let options = Options {
        method: Method::OutputError,
        order: Some(2),
        delay: Some(1),
        ..Options::default()
    };
    let signals = (vec![("u", input.to_vec())], vec![("y", output)]);
    let record = Record::of_run(STEP, signals.0, signals.1).unwrap();
    analyse(&record, &options).unwrap()
}

/// The same of an output with white noise of a hundredth of its deviation.
fn measured(input: &[f64], output: &[f64], seed: u32) -> Analysis {
    let white = noise(seed + 500, SAMPLES);
    fitted(input, plus(output, &white, 0.01 * deviation(output)))
}

#[track_caller]
fn cause(analysis: &Analysis) -> Cause {
    let cause = analysis.finding.clone().unwrap().cause;
    let is_told = match cause.is_disturbance() {
        true => matches!(analysis.verdict, Verdict::Disturbed { .. }),
        false => matches!(analysis.verdict, Verdict::NotLinear { .. }),
    };
    assert!(is_told, "{}", analysis.text());
    cause
}

fn near(found: f64, truth: f64, by: f64) -> bool {
    (found - truth).abs() < by
}

#[test]
fn a_static_curve_is_named_with_the_levels_at_which_it_bends() {
    let seed = 1;
    let u = levels(seed);
    let through = |curve: fn(f64) -> f64| {
        let v: Vec<f64> = u.iter().map(|u| curve(*u)).collect();
        cause(&measured(&u, &linear(&v), seed))
    };
    let found = through(|u| u.signum() * (u.abs() - 0.3).max(0.0));
    assert!(
        matches!(found, Cause::Input(StaticCurve::DeadZone { lower: low, upper: high }) if near(low, -0.3, 0.15) && near(high, 0.3, 0.15)),
        "{found:?}"
    );
    let found = through(|u| u.clamp(-0.4, 0.4));
    assert!(
        matches!(found, Cause::Input(StaticCurve::Saturation { lower: Some(low), upper: Some(high) }) if near(low, -0.4, 0.15) && near(high, 0.4, 0.15)),
        "{found:?}"
    );
    let found = through(|u| u.min(0.2));
    assert!(
        matches!(found, Cause::Input(StaticCurve::Saturation { lower: None, upper: Some(high) }) if near(high, 0.2, 0.15)),
        "{found:?}"
    );
    let found = through(|u| u * u.abs());
    assert_eq!(found, Cause::Input(StaticCurve::Square { linear: None }));
    let found = through(|u| if u > 0.0 { u } else { 0.5 * u });
    assert!(
        matches!(&found, Cause::Input(StaticCurve::Piecewise { levels: at, slopes }) if near(at[0], 0.0, 0.1) && near(slopes[0] / slopes[1], 0.5, 0.1)),
        "{found:?}"
    );
    let y = linear(&u);
    let limit = 1.2 * deviation(&y);
    let y: Vec<f64> = y.iter().map(|y| y.clamp(-limit, limit)).collect();
    let found = cause(&measured(&u, &y, seed));
    assert!(
        matches!(found, Cause::Output(StaticCurve::Saturation { lower: Some(low), upper: Some(high) })
            if near(low / limit, -1.0, 0.3) && near(high / limit, 1.0, 0.3)),
        "{found:?}"
    );
}

#[test]
fn backlash_and_friction_are_named() {
    let u = levels(4);
    let mut at = 0.0_f64;
    let play = |u: &f64| {
        at = at.clamp(u - 0.3, u + 0.3);
        at
    };
    let y = linear(&u.iter().map(play).collect::<Vec<_>>());
    let found = cause(&measured(&u, &y, 4));
    assert!(
        matches!(found, Cause::Input(StaticCurve::Backlash { width }) if near(width, 0.6, 0.15)),
        "{found:?}"
    );
    let y = response(&u, &|v| 0.6 * libm::tanh(v / 0.02));
    assert_eq!(cause(&measured(&u, &y, 4)), Cause::Friction);
}

#[test]
fn what_changes_in_time_is_named_with_its_time() {
    let u = levels(5);
    let halved = u.iter().enumerate();
    let halved = halved.map(|(k, u)| if (600..900).contains(&k) { 0.5 * u } else { *u });
    let found = cause(&measured(&u, &linear(&halved.collect::<Vec<_>>()), 5));
    let Cause::Gain(times) = &found else {
        panic!("{found:?}");
    };
    for ((time, gain), (at, truth)) in times.iter().zip([(600, 0.5), (900, 1.0)]) {
        assert!(
            time.abs_diff(at) <= 60 && near(*gain, truth, 0.1),
            "{found:?}"
        );
    }
    // An input that is not recorded: 0.6 from 25 s to 40 s.
    let also: Vec<f64> = (0..SAMPLES)
        .map(|k| f64::from(u8::from((500..800).contains(&k))))
        .collect();
    let y = plus(&linear(&u), &linear(&also), 0.6);
    let found = cause(&measured(&u, &y, 5));
    assert!(
        matches!(&found, Cause::Steps(times) if times.len() == 2 && times[0].abs_diff(500) < 30 && times[1].abs_diff(800) < 30),
        "{found:?}"
    );
    // Noise that is eight times as large for a while.
    let mut burst = noise(77, SAMPLES);
    burst[900..1100].iter_mut().for_each(|e| *e *= 8.0);
    let y = linear(&u);
    let coloured = filter(&[1.0], &[1.0, -0.9], &burst);
    let found = cause(&fitted(&u, plus(&y, &coloured, 0.04 * deviation(&y))));
    assert!(
        matches!(found, Cause::While(from, to, _) if from.abs_diff(900) < 80 && to.abs_diff(1100) < 80),
        "{found:?}"
    );
}

#[test]
fn of_a_long_record_the_end_is_judged_at_its_own_times() {
    let u: Vec<f64> = (0..6).flat_map(levels).collect();
    let changed = 5 * u.len() / 6 + SAMPLES / 2;
    let mut y = linear(&u);
    y[changed..].iter_mut().for_each(|y| *y *= 0.4);
    let white = noise(77, u.len());
    let found = cause(&fitted(&u, plus(&y, &white, 0.01 * deviation(&y))));
    assert!(
        matches!(&found, Cause::Gain(times) if times.len() == 1 && times[0].0.abs_diff(changed) < SAMPLES / 10),
        "{found:?} for {changed}"
    );
}

#[test]
fn a_linear_plant_stays_good_whatever_its_noise_and_loop() {
    for seed in 11..13 {
        let u = levels(seed);
        let y = linear(&u);
        let size = deviation(&y);
        let white = noise(seed + 500, SAMPLES);
        let slow = |pole: f64| {
            let of = filter(&[(1.0 - pole * pole).sqrt()], &[1.0, -pole], &white);
            plus(&y, &of, 0.15 * size)
        };
        let step = 0.15 * size;
        let quantised = y.iter().map(|y| (y / step).round() * step).collect();
        // A force that pushes at random, beside the input.
        let pushed: Vec<f64> = plus(&u, &white, 0.5);
        let mut found = vec![
            fitted(&u, plus(&y, &white, 0.05 * size)),
            fitted(&u, slow(0.9)),
            fitted(&u, slow(0.98)),
            fitted(&u, quantised),
            fitted(&u, plus(&linear(&pushed), &white, 0.01 * size)),
        ];
        // u = 2 (ref - y) in a loop, the plant from sample to sample.
        let (a, b) = difference_equation();
        let (mut inputs, mut outputs) = (vec![0.0; 2], vec![0.0; 2]);
        let mut clean = vec![0.0; 2];
        for k in 2..SAMPLES {
            let next = b[0] * inputs[k - 1] + b[1] * inputs[k - 2]
                - a[0] * clean[k - 1]
                - a[1] * clean[k - 2];
            clean.push(next);
            outputs.push(next + 0.02 * size * white[k]);
            inputs.push(2.0 * (u[k] - outputs[k]));
        }
        found.push(fitted(&inputs, outputs));
        for (number, analysis) in found.iter().enumerate() {
            assert_eq!(
                analysis.finding,
                None,
                "seed {seed}, {number}: {}",
                analysis.text()
            );
        }
        assert!(found[1].held_out.attainable.unwrap() - found[1].held_out.fit.unwrap() > 5.0);
    }
}

/// `a1, a2` and `b1, b2` of `3/(s^2 + 1.2 s + 4)` behind a hold.
fn difference_equation() -> ([f64; 2], [f64; 2]) {
    let (decay, omega) = (libm::exp(-0.6 * STEP), 3.64_f64.sqrt());
    let (cos, sin) = (libm::cos(omega * STEP), libm::sin(omega * STEP));
    let b1 = 1.0 - decay * (cos + 0.6 / omega * sin);
    let b2 = decay * decay + decay * (0.6 / omega * sin - cos);
    ([-2.0 * decay * cos, decay * decay], [0.75 * b1, 0.75 * b2])
}
