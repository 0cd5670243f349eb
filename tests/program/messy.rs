//! `planesman sysid fit` as it is called without options, on data as it comes: every case has a known truth.
//!
//! ```text
//! cargo test --test program messy:: -- --nocapture      # prints a table; docs/sysid.md has what is not good in it
//! ```
use std::fs;

use clap::Parser as _;
use planesman::sysid::fit::FitArgs;
use planesman_fit::FitResult;
use planesman_identification::{SIGMAS_95, Uncertain, filter};
use planesman_linear::TransferFunction;
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_text::in_one_line;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

const STEP: f64 = 0.05;
const SAMPLES: usize = 1000;
/// The plant: `2/(s^2 + 1.5 s + 2)`.
const NUM: [f64; 1] = [2.0];
const DEN: [f64; 3] = [1.0, 1.5, 2.0];
/// An interval of 95 % that is this many times as wide holds the truth in all but one of ten thousand cases.
const AS_WIDE: f64 = 2.0;

/// What a case must come to.
enum Outcome {
    /// The intervals hold the plant's poles and gain, and the verdict begins so.
    Holds(&'static str),
    /// The gain's interval holds the truth; the poles are not all there to be found.
    Gain(&'static str),
    /// Somewhere in what is printed stands this, and the verdict does not begin with "good".
    Says(&'static str),
    /// The record is refused with this.
    Refused(&'static str),
}
use Outcome::{Gain, Holds, Refused, Says};

struct Case {
    name: &'static str,
    rows: Vec<Vec<f64>>,
    plant: (Vec<f64>, Vec<f64>),
    options: &'static str,
    outcome: Outcome,
}

/// Numbers of a normal distribution, nearly: mean 0, variance 1.
fn noise(seed: u64, count: usize) -> Vec<f64> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut one = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    (0..count).map(|_| one()).collect()
}

fn prbs(seed: u64, samples: usize, held: usize) -> Vec<f64> {
    let levels = noise(seed, samples / held + 1);
    (0..samples).map(|k| levels[k / held].signum()).collect()
}

/// The response of a plant in s to an input held between samples.
fn response(num: &[f64], den: &[f64], step: f64, input: &[f64]) -> Vec<f64> {
    let plant = TransferFunction::new(num.to_vec(), den.to_vec()).unwrap();
    plant
        .zero_order_hold(step)
        .unwrap()
        .simulate(input)
        .unwrap()
}

fn with(values: &[f64], seed: u64, deviation: f64) -> Vec<f64> {
    let pairs = values.iter().zip(noise(seed, values.len()));
    pairs.map(|(value, e)| value + deviation * e).collect()
}

fn rows(step: f64, u: &[f64], y: &[f64]) -> Vec<Vec<f64>> {
    let pairs = u.iter().zip(y).enumerate();
    pairs
        .map(|(k, (u, y))| vec![k as f64 * step, *u, *y])
        .collect()
}

/// Input, output without and with white noise of 0.05: the record most cases begin with.
fn clean(seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let u = prbs(seed, SAMPLES, 10);
    let x = response(&NUM, &DEN, STEP, &u);
    let y = with(&x, seed + 100, 0.05);
    (u, x, y)
}

/// Reference, input and output of a loop with a proportional controller about a plant in z and a disturbance.
fn closed_loop(b: &[f64], a: &[f64], gain: f64, disturbance: &[f64]) -> Vec<Vec<f64>> {
    let reference = prbs(31, disturbance.len(), 20);
    let (mut x, mut u, mut rows): (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) = Default::default();
    for (k, (r, v)) in reference.iter().zip(disturbance).enumerate() {
        let past = |of: &[f64], by: &[f64]| -> f64 {
            let pairs = by.iter().zip(of.iter().rev());
            pairs.map(|(c, value)| c * value).sum()
        };
        let now = past(&u, &b[1..]) - past(&x, &a[1..]);
        x.push(now);
        u.push(gain * (r - now - v));
        rows.push(vec![k as f64 * STEP, u[k], now + v, *r]);
    }
    rows
}

/// A number of `0..count` for each of a list of places, as if drawn.
fn places(seed: u64, count: usize, samples: usize) -> Vec<usize> {
    let drawn = noise(seed, count).into_iter();
    let mut places: Vec<usize> = drawn.map(|e| (e.abs() * 1e6) as usize % samples).collect();
    places.sort_unstable();
    places.dedup();
    places
}

fn coloured(seed: u64, samples: usize, rho: f64, deviation: f64) -> Vec<f64> {
    let gain = deviation * (1.0 - rho * rho).sqrt();
    filter(&[gain], &[1.0, -rho], &noise(seed, samples))
}

fn plus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// Cases in which the stamps or rows are at fault.
fn of_stamps() -> Vec<(&'static str, Vec<Vec<f64>>, Outcome)> {
    let (u, _, y) = clean(1);
    let all = rows(STEP, &u, &y);
    let kept = |from: &[usize]| -> Vec<Vec<f64>> {
        let kept = all.iter().enumerate().filter(|(k, _)| !from.contains(k));
        kept.map(|(_, row)| row.clone()).collect()
    };
    // Sampled off the grid: a simulation fifty times finer gives the values there.
    let fine = 50;
    let finely: Vec<f64> = (u.iter())
        .flat_map(|u| std::iter::repeat_n(*u, fine))
        .collect();
    let x = response(&NUM, &DEN, STEP / fine as f64, &finely);
    let jittered = (0..SAMPLES).zip(noise(5, SAMPLES)).zip(noise(6, SAMPLES));
    let jittered = jittered.map(|((k, jitter), e)| {
        let off = (10.0 * jitter).clamp(-22.0, 22.0).round() as i64;
        let at = ((k * fine) as i64 + off).max(0) as usize;
        vec![at as f64 * STEP / fine as f64, finely[at], x[at] + 0.05 * e]
    });
    let gaps: Vec<usize> = [(150, 30), (400, 55), (700, 20)]
        .into_iter()
        .flat_map(|(first, count)| first..first + count)
        .collect();
    let mut doubled = all.clone();
    doubled.extend(places(8, 50, SAMPLES).into_iter().map(|k| all[k].clone()));
    doubled.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut late: Vec<(f64, Vec<f64>)> = (all.iter().enumerate())
        .map(|(k, row)| (k as f64, row.clone()))
        .collect();
    for k in places(9, 50, SAMPLES) {
        late[k].0 += 3.5;
    }
    late.sort_by(|p, q| p.0.total_cmp(&q.0));
    let later = |by: usize| [vec![y[0]; by], y[..SAMPLES - by].to_vec()].concat();
    vec![
        ("as it should be", all.clone(), Holds("good")),
        (
            "stamps jitter by a fifth of the interval",
            jittered.collect(),
            Gain("good"),
        ),
        (
            "a tenth of the rows dropped",
            kept(&places(7, 105, SAMPLES)),
            Gain("good"),
        ),
        ("gaps of 1 to 3 s", kept(&gaps), Holds("good")),
        ("50 stamps twice", doubled, Holds("good")),
        (
            "50 rows three rows late",
            late.into_iter().map(|(_, row)| row).collect(),
            Holds("good"),
        ),
        (
            "output 0.15 s late",
            rows(STEP, &u, &later(3)),
            Holds("good"),
        ),
        (
            "output 0.5 s early",
            rows(STEP, &u[..SAMPLES - 10], &y[10..]),
            Says("too early"),
        ),
    ]
}

/// Cases in which sensors or noise are at fault.
fn of_sensors() -> Vec<(&'static str, Vec<Vec<f64>>, Outcome)> {
    let (u, x, y) = clean(11);
    let each = |change: &dyn Fn(f64) -> f64| -> Vec<f64> { y.iter().map(|y| change(*y)).collect() };
    let spread = (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let outliers = |at: &[usize], by: f64| {
        let mut spoilt = y.clone();
        at.iter().for_each(|k| spoilt[*k] += by);
        spoilt
    };
    let walk = filter(&[0.02], &[1.0, -1.0], &noise(12, SAMPLES));
    let ramp: Vec<f64> = (0..SAMPLES).map(|k| 0.004 * k as f64).collect();
    let short = |count: usize| {
        rows(STEP, &prbs(13, count, 3), &{
            let u = prbs(13, count, 3);
            with(&response(&NUM, &DEN, STEP, &u), 14, 0.005)
        })
    };
    vec![
        (
            "output in steps of 0.2",
            rows(STEP, &u, &each(&|y| (y / 0.2).round() * 0.2)),
            Holds("good"),
        ),
        (
            "output saturated at 0.6",
            rows(STEP, &u, &each(&|y| y.clamp(-0.6, 0.6))),
            Holds("good"),
        ),
        (
            "input constant",
            rows(STEP, &vec![1.0; SAMPLES], &y),
            Refused("u is constant (1 in all"),
        ),
        (
            "output constant",
            rows(STEP, &u, &vec![1.0; SAMPLES]),
            Refused("y is constant (1 in all"),
        ),
        (
            "output is the input",
            rows(STEP, &u, &u),
            Refused("y is u times 1.000000"),
        ),
        (
            "1 % outliers of 5",
            rows(STEP, &u, &outliers(&places(15, 10, SAMPLES), 5.0)),
            Holds("good"),
        ),
        (
            "one spike of 1e6",
            rows(STEP, &u, &outliers(&[500], 1e6)),
            Holds("good"),
        ),
        (
            "noise 20 dB below the output",
            rows(STEP, &u, &with(&x, 16, spread / 10.0)),
            Holds("good"),
        ),
        (
            "noise 5 dB below the output",
            rows(STEP, &u, &with(&x, 16, spread * libm::pow(10_f64, -0.25))),
            Holds("good: the noise limits"),
        ),
        (
            "AR(0.9) noise",
            rows(STEP, &u, &plus(&x, &coloured(17, SAMPLES, 0.9, 0.1))),
            Gain("good"),
        ),
        (
            "output drifts: a random walk",
            rows(STEP, &u, &plus(&y, &walk)),
            Gain("not usable"),
        ),
        (
            "output drifts: a ramp",
            rows(STEP, &u, &plus(&y, &ramp)),
            Says("--detrend line"),
        ),
        ("30 samples", short(30), Says("record for longer")),
        ("12 samples", short(12), Says("record")),
        (
            "a sine that no input causes",
            rows(
                STEP,
                &u,
                &with(
                    &(0..SAMPLES)
                        .map(|k| libm::sin(0.7 * STEP * k as f64))
                        .collect::<Vec<_>>(),
                    18,
                    0.05,
                ),
            ),
            Says("no model: the input has no effect on the output"),
        ),
        (
            "a second input, not recorded",
            rows(
                STEP,
                &u,
                &plus(&y, &response(&[1.4], &DEN, STEP, &prbs(19, SAMPLES, 30))),
            ),
            // It leaves half of the output to simulate, at best.
            Gain("not usable"),
        ),
    ]
}

fn cases() -> Vec<Case> {
    let plain = |(name, rows, outcome)| Case {
        name,
        rows,
        plant: (NUM.to_vec(), DEN.to_vec()),
        options: "",
        outcome,
    };
    let mut all: Vec<Case> = of_stamps()
        .into_iter()
        .chain(of_sensors())
        .map(plain)
        .collect();
    let plant = TransferFunction::new(NUM.to_vec(), DEN.to_vec()).unwrap();
    let z = plant.zero_order_hold(STEP).unwrap();
    let (b, a): (Vec<f64>, Vec<f64>) = (z.num.to_vec(), z.den.to_vec());
    let b = [vec![0.0; a.len() - b.len()], b].concat();
    let mut of_loop = |name, disturbance: &[f64], options, outcome| {
        let rows = closed_loop(&b, &a, 1.5, disturbance);
        let case = plain((name, rows, outcome));
        all.push(Case { options, ..case });
    };
    let quiet: Vec<f64> = noise(21, 2000).into_iter().map(|e| 0.05 * e).collect();
    let rough = coloured(22, 2000, 0.9, 0.3);
    of_loop("a loop, white noise", &quiet, "", Gain(""));
    of_loop("a loop, slow disturbance", &rough, "", Says("closed-loop"));
    of_loop("the same, reference given", &rough, "-r r", Gain(""));
    let held = prbs(41, SAMPLES, 10);
    let twice: Vec<f64> = held.iter().flat_map(|u| [*u; 2]).collect();
    let late = response(&NUM, &DEN, STEP / 2.0, &[&[0.0][..], &twice].concat());
    let late: Vec<f64> = late.into_iter().step_by(2).take(SAMPLES).collect();
    let mut of_plant = |name, (num, den): (&[f64], &[f64]), rows, outcome| {
        let plant = (num.to_vec(), den.to_vec());
        all.push(Case {
            name,
            rows,
            plant,
            options: "",
            outcome,
        });
    };
    of_plant(
        "half a sample of delay",
        (&NUM, &DEN),
        rows(STEP, &held, &with(&late, 42, 0.05)),
        Gain("good"),
    );
    let simulated = |num: &[f64], den: &[f64], step: f64, u: Vec<f64>, deviation: f64| {
        let y = with(&response(num, den, step, &u), 43, deviation);
        rows(step, &u, &y)
    };
    for (name, num, den, deviation) in [
        ("integrator", &[1.0][..], &[1.0, 0.0][..], 0.02),
        ("non-minimum phase", &[-1.0, 2.0], &DEN, 0.05),
        ("damping 0.01", &[1.0], &[1.0, 0.02, 1.0], 0.05),
    ] {
        let rows = simulated(num, den, STEP, held.clone(), deviation);
        of_plant(name, (num, den), rows, Holds("good"));
    }
    let fast = simulated(&NUM, &DEN, 0.001, prbs(44, 20_000, 500), 0.05);
    of_plant(
        "1 kHz for dynamics of 1 s",
        (&NUM, &DEN),
        fast,
        Holds("good"),
    );
    let (num, den) = ([1.0], [1.0, 10.1, 1.0]);
    let stiff = simulated(&num, &den, STEP, prbs(45, 4000, 20), 0.02);
    of_plant("poles 100 : 1", (&num, &den), stiff, Gain("good"));
    let unstable = closed_loop(
        &[0.0, 0.05],
        &[1.0, -1.02],
        2.0,
        &noise(46, SAMPLES)
            .into_iter()
            .map(|e| 0.01 * e)
            .collect::<Vec<_>>(),
    );
    // z = 1.02 held: s - ln(1.02)/T.
    let pole = libm::log(1.02_f64) / STEP;
    of_plant(
        "unstable, in a loop",
        (&[2.5 * pole], &[1.0, -pole]),
        unstable,
        Gain("good"),
    );
    let levels: Vec<f64> = noise(47, 100)
        .into_iter()
        .flat_map(|e| std::iter::repeat_n(e.clamp(-1.0, 1.0), 10))
        .collect();
    let dead: Vec<f64> = levels
        .iter()
        .map(|u| u.signum() * (u.abs() - 0.3).max(0.0))
        .collect();
    let mut play = 0.0_f64;
    let played: Vec<f64> = levels
        .iter()
        .map(|u| {
            play = play.clamp(u - 0.15, u + 0.15);
            play
        })
        .collect();
    for (name, moved, said) in [
        ("dead zone of 0.3", dead, Holds("good: the noise limits")),
        ("backlash of 0.3", played, Holds("good")),
    ] {
        let output = with(&response(&NUM, &DEN, STEP, &moved), 48, 0.05);
        let rows = rows(STEP, &levels, &output);
        of_plant(name, (&NUM, &DEN), rows, said);
    }
    all
}

/// Standard deviations, as 95 % intervals, between an estimate and the truth.
fn apart(found: &Uncertain, truth: Complex<f64>) -> f64 {
    let off = found.value - truth;
    let share = |off: f64, deviation: f64| {
        if off.abs() < 1e-9 {
            0.0
        } else {
            off.abs() / (SIGMAS_95 * deviation)
        }
    };
    share(off.re, found.real_deviation()).max(share(off.im, found.imaginary_deviation()))
}

fn told(found: &Uncertain) -> String {
    match found.value.im {
        0.0 => format!(
            "{:.3} ± {:.3}",
            found.value.re,
            SIGMAS_95 * found.real_deviation()
        ),
        im => format!(
            "{:.3} ± {:.3} ± {im:.3}i",
            found.value.re,
            SIGMAS_95 * found.real_deviation()
        ),
    }
}

/// One row of the table, and what is wrong with the case.
fn judged(case: &Case, found: Result<FitResult, String>) -> (String, Option<String>) {
    let (num, den) = &case.plant;
    let plant = TransferFunction::new(num.clone(), den.clone()).unwrap();
    let truth = num.last().unwrap() / den.last().unwrap();
    let mut poles = plant.poles().unwrap();
    poles.retain(|pole| pole.im >= 0.0);
    let found = match (found, &case.outcome) {
        (Ok(found), _) => found,
        (Err(reason), Refused(with)) if reason.contains(with) => {
            return (format!("| {} | | | | refused: {reason} |", case.name), None);
        }
        (Err(reason), _) => return (format!("| {} | | | | {reason} |", case.name), Some(reason)),
    };
    let analysis = &found.analysis;
    let reading = analysis.reading();
    let gain = reading.steady_state_gain().filter(|_| truth.is_finite());
    let at = reading.continuous_poles().unwrap();
    let near: Vec<&Uncertain> = poles
        .iter()
        .filter_map(|pole| {
            at.iter().min_by(|p, q| {
                (p.value - pole)
                    .modulus()
                    .total_cmp(&(q.value - pole).modulus())
            })
        })
        .collect();
    let verdict = analysis.verdict.to_string();
    let verdict = verdict.strip_prefix("verdict: ").unwrap();
    let structure = &analysis.estimate.layout.structure;
    let row = format!(
        "| {} | {}, {} | {} | {} | {} |",
        case.name,
        structure.poles + structure.known_denominator.len() - 1,
        structure.delay,
        gain.map_or("none".to_owned(), |it| format!(
            "{:.3} ± {:.3} ({truth:.3})",
            it.value.re,
            SIGMAS_95 * it.real_deviation()
        )),
        near.iter()
            .map(|it| told(it))
            .collect::<Vec<_>>()
            .join("; "),
        verdict.split(". Next").next().unwrap()
    );
    let of_gain = gain.map_or(0.0, |it| apart(&it, Complex::new(truth, 0.0)));
    let of_poles = poles
        .iter()
        .zip(&near)
        .map(|(truth, found)| apart(found, *truth))
        .fold(0.0, f64::max);
    let text = analysis.text();
    let begins = |with: &str| (!verdict.starts_with(with)).then(|| format!("verdict: {verdict}"));
    let wide = |apart: f64, of: &str| {
        (apart > AS_WIDE).then(|| format!("{of}: {apart:.1} intervals away"))
    };
    let wrong = match case.outcome {
        Holds(with) => begins(with)
            .or(wide(of_gain, "gain"))
            .or(wide(of_poles, "poles")),
        Gain(with) => begins(with).or(wide(of_gain, "gain")),
        Says(what) => (!text.contains(what) || verdict.starts_with("good"))
            .then(|| format!("not said: {what}; {verdict}")),
        Refused(with) => Some(format!("not refused: {with}")),
    };
    (row, wrong)
}

#[test]
fn messy_data_gives_the_truth_or_a_warning() {
    crate::by_command_line();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.csv");
    println!(
        "| data | order, delay | steady-state gain (truth) | poles, 1/s | verdict |\n|---|---|---|---|---|"
    );
    let mut wrong = Vec::new();
    for case in cases() {
        let header = if case.rows[0].len() > 3 {
            "time,u,y,r\n"
        } else {
            "time,u,y\n"
        };
        let line = |row: &Vec<f64>| {
            row.iter()
                .map(|v| format!("{v:.9}"))
                .collect::<Vec<_>>()
                .join(",")
                + "\n"
        };
        fs::write(
            &path,
            header.to_owned() + &case.rows.iter().map(line).collect::<String>(),
        )
        .unwrap();
        let args = format!("fit {} -i u -o y {}", path.display(), case.options);
        let args = FitArgs::try_parse_from(args.split_whitespace()).unwrap();
        let found = planesman_fit::fit(&(&args).try_into().unwrap(), &())
            .map_err(|error| in_one_line(&error));
        let text = found.as_ref().map_or(String::new(), |it| {
            it.prepared.description() + &it.analysis.text()
        });
        let (row, reason) = judged(&case, found);
        println!("{row}");
        wrong.extend(reason.map(|reason| format!("{}: {reason}\n{text}", case.name)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
