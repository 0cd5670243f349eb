//! Proposes the next run: manoeuvres are simulated with the fitted vehicle, and the information that each would add is computed.
//!
//! A separate run has its own current and initial state; numbers and biases are the same. With the information H of the data and H_m of a manoeuvre,
//! both after elimination of the unknowns that are not common, the resulting covariance is `(H + H_m + 1/prior^2)^-1`: Goodwin and Payne, *Dynamic
//! System Identification: Experiment Design and Data Analysis* (1977), ch. 6.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use planesman_equations::{Run, Track};
use planesman_identification::SIGMAS_95;
use planesman_vehicle::six_dof::propulsion::Propulsor;
use planesman_vehicle::six_dof::{Vehicle, coefficients::Factor};
use serde::Serialize;

use super::problem::{Problem, Window};

/// Duration of a manoeuvre, and its beginning \[s\].
const LENGTH: f64 = 60.0;
const BEGIN: f64 = 5.0;
/// Step of a simulation \[s\].
const STEP: f64 = 0.05;
/// Manoeuvres with more pitch are not proposed \[rad\].
const STEEPEST: f64 = 1.0;
/// Up to this number of inputs, two are also moved together.
const PAIRS: usize = 4;
/// An interval counts as reduced if it becomes this much shorter.
const SHORTER: f64 = 0.8;
/// Angle of fins \[rad\], and command of a thruster.
const ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;
const COMMAND: f64 = 0.4;

/// The expected effect of a manoeuvre on a number: half the 95 % interval, relative to the number.
#[derive(Clone, Debug, Serialize)]
pub struct Expected {
    /// The number.
    pub name: String,
    /// The interval from the present data.
    pub before: f64,
    /// The interval expected with the manoeuvre.
    pub after: f64,
    /// The manoeuvre as text; `None` if no manoeuvre of the library shortens the interval by 20 % or more.
    pub manoeuvre: Option<String>,
}

/// The manoeuvre that minimises the largest interval.
#[derive(Clone, Debug, Serialize)]
pub struct NextRun {
    /// In words.
    pub manoeuvre: String,
    /// The largest intervals before and after the manoeuvre, each with the name of its number, among the intervals that some manoeuvre shortens.
    pub largest: [(String, f64); 2],
    /// Change of depth, upwards and downwards \[m\], positive down.
    pub depths: [f64; 2],
    /// Number of manoeuvres compared.
    pub compared: usize,
}

/// A manoeuvre of the library: its text, and its steps with constant inputs.
type Manoeuvre = (String, Vec<(f64, Vec<f64>)>);

/// A shape of the input: its name, and its value, -1 to 1, as a function of the seconds since its beginning.
type Shape = (&'static str, fn(f64) -> f64);

const SHAPES: [Shape; 5] = [
    ("step for 20 s", |t| if t < 20.0 { 1.0 } else { 0.0 }),
    ("doublet, 5 s each way", |t| match t {
        t if t < 5.0 => 1.0,
        t if t < 10.0 => -1.0,
        _ => 0.0,
    }),
    ("zig-zag, 5 s to each side", |t| square(t, 5.0)),
    ("zig-zag, 2 s to each side", |t| square(t, 2.0)),
    (
        "spiral in steps of a third of the deflection, 9 s each",
        |t| [1.0, 2.0, 3.0, -1.0, -2.0, -3.0][((t / 9.0) as usize).min(5)] / 3.0,
    ),
];

fn square(t: f64, half: f64) -> f64 {
    match (t / half) as usize % 2 {
        0 => 1.0,
        _ => -1.0,
    }
}

/// The amplitude of an input, with its text; limited to the input's range.
fn amplitude(vehicle: &Vehicle, input: usize, base: f64) -> Option<(f64, String)> {
    let parts = vehicle.parts();
    let is_angle = parts.fins.iter().any(|it| it.input == input)
        || parts.terms.iter().any(|it| it.of == Factor::Input(input));
    if is_angle {
        return Some((ANGLE, "10 deg".to_owned()));
    }
    parts.propulsors.iter().find_map(|it| match it {
        Propulsor::Force {
            input: of, limits, ..
        } if *of == input => {
            let force = 0.3 * (limits[1] - limits[0]);
            Some((force, format!("{force:.3} N")))
        }
        Propulsor::Propeller { input: of, .. } if *of == input => {
            let rate = 0.3 * base.abs().max(10.0);
            Some((rate, format!("{rate:.4} rad/s")))
        }
        Propulsor::Thruster { input: of, .. } if *of == input => {
            Some((COMMAND, format!("{COMMAND}")))
        }
        _ => None,
    })
}

/// Each shape of each input about `base`; with few inputs also two together.
fn library(vehicle: &Vehicle, base: &[f64]) -> Vec<Manoeuvre> {
    let names = &vehicle.parts().inputs;
    let movable = (0..names.len()).filter_map(|k| Some((k, amplitude(vehicle, k, base[k])?)));
    let movable: Vec<(usize, (f64, String))> = movable.collect();
    let made = |moved: &[(usize, f64, Shape)], words: String| {
        let count = (LENGTH / STEP).round() as usize;
        let steps = (0..count).map(|k| {
            let mut inputs = base.to_vec();
            let time = k as f64 * STEP - BEGIN + 1e-9;
            for (input, by, (_, shape)) in moved.iter().filter(|_| time >= 0.0) {
                inputs[*input] += by * shape(time);
            }
            (STEP, inputs)
        });
        (words, steps.collect())
    };
    let words = |(input, (_, by)): &(usize, (f64, String)), shape: &Shape| {
        format!("{} +-{by}: {}", names[*input], shape.0)
    };
    let mut all = Vec::new();
    for (at, one) in movable.iter().enumerate() {
        for shape in SHAPES {
            all.push(made(&[(one.0, one.1.0, shape)], words(one, &shape)));
        }
        for other in movable.iter().skip(at + 1).filter(|_| names.len() <= PAIRS) {
            for (first, second) in [(SHAPES[2], SHAPES[3]), (SHAPES[3], SHAPES[2])] {
                let both = format!("{}; {}", words(one, &first), words(other, &second));
                let moved = [(one.0, one.1.0, first), (other.0, other.1.0, second)];
                all.push(made(&moved, both));
            }
        }
    }
    all
}

/// The means of the inputs, an initial state of straight motion at the mean speed, and the shortest interval between samples \[s\].
fn usual(runs: &[Run], channels: &[usize]) -> (Vec<f64>, [f64; 12], f64) {
    let mean = |of: &dyn Fn(&Run) -> Option<&Track>| {
        let values = runs.iter().filter_map(of).flat_map(|it| &it.values);
        values.clone().sum::<f64>() / values.count().max(1) as f64
    };
    let inputs = runs.first().map_or(0, |it| it.inputs.len());
    let base = (0..inputs).map(|k| mean(&|run| run.inputs.get(k)));
    let mut start = [0.0; 12];
    // Depth, pitch and surge.
    for channel in [2, 4, 6] {
        let place = channels.iter().position(|it| *it == channel);
        start[channel] = place.map_or(0.0, |it| mean(&|run| run.outputs.get(it)));
    }
    let tracks = runs.iter().flat_map(|it| &it.outputs);
    let intervals = tracks.filter_map(|it| {
        let (first, last) = (it.times.first()?, it.times.last()?);
        Some((last - first) / (it.times.len() - 1) as f64)
    });
    (
        base.collect(),
        start,
        intervals.fold(f64::INFINITY, f64::min),
    )
}

/// An information matrix after elimination of a part that is not common, with its prior.
fn without(
    information: &DMatrix<f64>,
    part: std::ops::Range<usize>,
    priors: &[(f64, f64)],
) -> Option<DMatrix<f64>> {
    let mut rest = information.clone();
    for k in part.clone() {
        rest[(k, k)] += 1.0 / (priors[k].1 * priors[k].1);
    }
    for k in part.clone() {
        let column = rest.column(k).into_owned();
        let pivot = column[k];
        rest -= &column * column.transpose() / pivot;
    }
    let rest = rest.remove_columns(part.start, part.len());
    Some(rest.remove_rows(part.start, part.len())).filter(|it| it.iter().all(|it| it.is_finite()))
}

/// The numbers that the data does not determine within `bound`, from the relative intervals `before`, each with its best manoeuvre; and the
/// next run.
pub(super) fn experiments(
    problem: &Problem<'_>,
    globals: &[f64],
    information: &DMatrix<f64>,
    (runs, channels): (&[Run], &[usize]),
    (before, bound): (&[f64], f64),
) -> Option<(Vec<Expected>, Option<NextRun>)> {
    let (base, start, interval) = usual(runs, channels);
    let vehicle = problem.vehicle(globals)?;
    let priors = problem.priors();
    let part = problem.of_current();
    let of_data = without(information, part.clone(), &priors)?;
    let common = priors[..part.start].iter().chain(&priors[part.end..]);
    let common = common.map(|it| 1.0 / (it.1 * it.1)).collect();
    let of_data = of_data + DMatrix::from_diagonal(&DVector::from_vec(common));
    let numbers = problem.sought.len();
    let intervals = |information: DMatrix<f64>| -> Option<Vec<f64>> {
        let covariance = information.cholesky()?.inverse();
        let size = |k: usize| problem.value(k, globals).abs().max(problem.least_size(k));
        let share = |k: usize| size(k) / problem.unit(k).abs();
        let of = |k: usize| SIGMAS_95 * covariance[(k, k)].sqrt() / share(k);
        Some((0..numbers).map(of).collect())
    };
    // Residuals that are not white make intervals longer; a run's would be likewise.
    let white = intervals(of_data.clone())?;
    let every = ((interval / STEP).round() as usize).max(1);
    let mut tried: Vec<(String, [f64; 2], Vec<f64>)> = Vec::new();
    for (words, steps) in library(&vehicle, &base) {
        let stamps = (0..=steps.len()).step_by(every);
        let samples = stamps.flat_map(|it| channels.iter().map(move |of| (it, *of, 0.0)));
        let window = Window {
            samples: samples.collect(),
            steps,
            from: 0.0,
            held: Arc::default(),
            start,
        };
        let way = problem.simulated(&vehicle, globals, &window.steps, &start);
        let is_level = |way: &Vec<[f64; 12]>| way.iter().all(|it| it[4].abs() <= STEEPEST);
        let Some(way) = way.filter(is_level) else {
            continue;
        };
        let depths = way.iter().map(|it| it[2] - way[0][2]);
        let depths = depths.fold([0.0_f64; 2], |[low, high], it| [low.min(it), high.max(it)]);
        let theta = globals.iter().chain(&start).copied();
        let theta = DVector::from_iterator(globals.len() + start.len(), theta);
        let added = problem.eliminated(&[window], &theta);
        let added = added.and_then(|it| without(&it.0, part.clone(), &priors));
        if let Some(mut after) = added.and_then(|it| intervals(&of_data + it)) {
            for (after, (before, white)) in after.iter_mut().zip(before.iter().zip(&white)) {
                *after *= before / white;
            }
            tried.push((words, depths, after));
        }
    }
    let name = |k: usize| problem.file.numbers()[problem.sought[k]].name.clone();
    let best = |k: usize| tried.iter().min_by(|a, b| a.2[k].total_cmp(&b.2[k]));
    let shorter = |k: &usize| best(*k).is_some_and(|it| it.2[*k] < SHORTER * before[*k]);
    let undetermined = (0..numbers).filter(|k| before[*k] > bound).map(|k| {
        let best = best(k).filter(|_| shorter(&k));
        Expected {
            name: name(k),
            before: before[k],
            after: best.map_or(before[k], |it| it.2[k]),
            manoeuvre: best.map(|it| it.0.clone()),
        }
    });
    let undetermined = undetermined.collect();
    let within_reach: Vec<usize> = (0..numbers).filter(shorter).collect();
    let largest = |of: &[f64]| {
        let each = within_reach.iter().map(|k| (*k, of[*k]));
        each.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let next = tried.iter().min_by(|a, b| {
        let size = |of: &[f64]| largest(of).map_or(0.0, |it| it.1);
        size(&a.2).total_cmp(&size(&b.2))
    });
    let next = next.and_then(|(words, depths, after)| {
        let (first, second) = (largest(before)?, largest(after)?);
        Some(NextRun {
            manoeuvre: words.clone(),
            largest: [(name(first.0), first.1), (name(second.0), second.1)],
            depths: *depths,
            compared: tried.len(),
        })
    });
    Some((undetermined, next))
}
