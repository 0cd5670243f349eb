//! Finds inputs that act against the direction that the vehicle file gives them.
//!
//! Each velocity follows the inputs with a first-order lag,
//! ```text
//! T_i nu_i' = k_i sum_j s_j B_ij tau_j + c_i - nu_i,   k_i >= 0
//! ```
//! where B is the acceleration of the initial vehicle by each input, and s_j is -1 for a reversed input. All sets of signs are compared by the
//! errors over windows from measured states; T, k and c are the best ones for each set.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use planesman_linear::digits::significant;
use planesman_parallel::on_all_cores;
use serde::Serialize;

use crate::prediction::{TIME_CONSTANTS, responses, samples};
use crate::problem::{Problem, VELOCITIES, Window};

/// Up to so many inputs every set of signs is compared; of more inputs, only sets with one or all signs reversed.
const FEW: usize = 8;
/// The mean squared errors must be smaller by this factor, geometric mean over the velocities, if the signs are reversed.
const SURE: f64 = 0.7;
/// The same for each input alone.
const SURE_OF_ONE: f64 = 0.85;
/// The step over which accelerations are computed \[s\].
const STEP: f64 = 1e-3;

/// An input with which the motion agrees only if its sign is reversed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReversedInput {
    /// The input.
    pub input: String,
    /// Mean squared errors of velocities with the reversed sign over those without, geometric mean.
    pub ratio: f64,
}

impl fmt::Display for ReversedInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { input, ratio } = self;
        write!(
            f,
            "input {input} acts against its direction in the vehicle file: with the opposite sign, the squared errors of a simple model are {} times \
             as large. Reverse it: --signal '{input}=SIGNAL*-1'",
            significant(*ratio, 2)
        )
    }
}

/// The sums of products of the responses of one velocity to the offset and to each input, and of the velocity without its free motion.
struct Products {
    responses: DMatrix<f64>,
    velocity: DVector<f64>,
    square: f64,
}

impl Products {
    /// The squares that remain with these signs.
    fn left(&self, signs: &[f64]) -> f64 {
        let (offset, inputs) = (self.responses[(0, 0)], signs.len());
        let by_offset = self.velocity[0];
        let without = self.square - by_offset * by_offset / offset;
        let (mut own, mut with_offset, mut with_velocity) = (0.0, 0.0, 0.0);
        for j in 0..inputs {
            with_offset += signs[j] * self.responses[(0, j + 1)];
            with_velocity += signs[j] * self.velocity[j + 1];
            let row = (0..inputs).map(|i| signs[i] * self.responses[(j + 1, i + 1)]);
            own += signs[j] * row.sum::<f64>();
        }
        let own = own - with_offset * with_offset / offset;
        let common = with_velocity - with_offset * by_offset / offset;
        match own > 1e-12 * self.square && common > 0.0 {
            true => without - common * common / own,
            false => without,
        }
    }
}

/// The inputs whose reversed sign explains the recorded velocities far better; the windows begin at measured states.
pub(super) fn reversed_inputs(
    problem: &Problem<'_>,
    windows: &[Window],
    names: &[String],
) -> Vec<ReversedInput> {
    found(problem, windows, names).unwrap_or_default()
}

fn found(
    problem: &Problem<'_>,
    windows: &[Window],
    names: &[String],
) -> Option<Vec<ReversedInput>> {
    let by_input = accelerations(problem, windows, names.len())?;
    let axes: Vec<usize> = (0..6)
        .filter(|axis| {
            let channel = VELOCITIES + axis;
            let is_recorded = windows
                .iter()
                .any(|it| samples(it, channel).next().is_some());
            is_recorded && by_input.iter().any(|it| it[*axis] != 0.0)
        })
        .collect();
    let all: Vec<(usize, f64)> = (axes.iter())
        .flat_map(|axis| TIME_CONSTANTS.iter().step_by(3).map(|t| (*axis, *t)))
        .collect();
    let products = on_all_cores(&all, |(axis, t)| products(windows, *axis, *t, &by_input));
    // The geometric mean of the errors with some signs over those with others.
    let left = |signs: &[f64]| -> Vec<f64> {
        let of_axis = |axis: &usize| {
            let own = all.iter().zip(&products).filter(|it| it.0.0 == *axis);
            own.map(|it| it.1.left(signs)).fold(f64::INFINITY, f64::min)
        };
        axes.iter().map(of_axis).collect()
    };
    let ratio = |one: &[f64], other: &[f64]| {
        let logs = one.iter().zip(other).map(|(a, b)| libm::log(a / b));
        libm::exp(logs.sum::<f64>() / axes.len().max(1) as f64)
    };
    let acts = |j: &usize| by_input[*j].iter().any(|it| *it != 0.0);
    let acting: Vec<usize> = (0..names.len()).filter(acts).collect();
    let signs_of = |reversed: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let sign = |j: usize| {
            let place = acting.iter().position(|it| *it == j);
            if place.is_some_and(reversed) {
                -1.0
            } else {
                1.0
            }
        };
        (0..names.len()).map(sign).collect()
    };
    let count = acting.len();
    let sets: Vec<Vec<f64>> = match count <= FEW {
        true => (1..1_usize << count)
            .map(|set| signs_of(&|place| set >> place & 1 == 1))
            .collect(),
        false => (0..=count)
            .map(|one| signs_of(&|place| one == count || place == one))
            .collect(),
    };
    let as_given = left(&vec![1.0; names.len()]);
    let each = sets
        .into_iter()
        .map(|signs| (ratio(&left(&signs), &as_given), signs));
    let (best, signs) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
    if best > SURE {
        return None;
    }
    let reversed = left(&signs);
    let of_one = |j: usize| {
        let mut back = signs.clone();
        back[j] = 1.0;
        (signs[j] < 0.0).then(|| ratio(&reversed, &left(&back)))
    };
    let each = names.iter().enumerate();
    let each = each.filter_map(|(j, name)| {
        Some(ReversedInput {
            input: name.clone(),
            ratio: of_one(j).filter(|it| *it < SURE_OF_ONE)?,
        })
    });
    Some(each.collect())
}

/// The accelerations of the initial vehicle by each input of its usual size, over that size, at the mean of the measured velocities.
fn accelerations(
    problem: &Problem<'_>,
    windows: &[Window],
    inputs: usize,
) -> Option<Vec<[f64; 6]>> {
    let globals: Vec<f64> = problem.priors().iter().map(|it| it.0).collect();
    let vehicle = problem.vehicle(&globals)?;
    let mut start = [0.0; 12];
    for (axis, value) in start.iter_mut().enumerate().skip(VELOCITIES) {
        *value = windows.iter().map(|it| it.start[axis]).sum::<f64>() / windows.len() as f64;
    }
    let usual = |input: usize| {
        let values = windows
            .iter()
            .flat_map(|it| &it.steps)
            .map(|it| it.1[input]);
        let (sum, count) = values.fold((0.0, 0.0), |it, u| (it.0 + u * u, it.1 + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let after = |input: Option<(usize, f64)>| {
        let mut values = vec![0.0; inputs];
        if let Some((input, value)) = input {
            values[input] = value;
        }
        let way = problem.simulated(&vehicle, &globals, &[(STEP, values)], &start)?;
        way.last().copied()
    };
    let free = after(None)?;
    let each = (0..inputs).map(|input| {
        let size = usual(input);
        if size == 0.0 {
            return Some([0.0; 6]);
        }
        let there = after(Some((input, size)))?;
        let difference = |axis: usize| there[VELOCITIES + axis] - free[VELOCITIES + axis];
        Some(std::array::from_fn(|axis| difference(axis) / (STEP * size)))
    });
    each.collect()
}

/// The products of a velocity's responses, with this time constant.
fn products(
    windows: &[Window],
    axis: usize,
    time_constant: f64,
    by_input: &[[f64; 6]],
) -> Products {
    let channel = VELOCITIES + axis;
    let width = by_input.len() + 1;
    let mut found = Products {
        responses: DMatrix::zeros(width, width),
        velocity: DVector::zeros(width),
        square: 0.0,
    };
    for window in windows {
        let of = responses(&window.steps, time_constant);
        let times = window.times();
        for (k, value) in samples(window, channel) {
            let scaled = of[k].iter().enumerate();
            let scaled = scaled.map(|(j, it)| {
                if j == 0 {
                    *it
                } else {
                    it * by_input[j - 1][axis]
                }
            });
            let row = DVector::from_iterator(width, scaled);
            let left = value - libm::exp(-times[k] / time_constant) * window.start[channel];
            found.responses += &row * row.transpose();
            found.velocity += left * &row;
            found.square += left * left;
        }
    }
    found
}
