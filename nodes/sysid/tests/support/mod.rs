//! Synthetic runs with exactly reproducible numbers: third-order plants from dive planes to
//! pitch rate at three speeds (Brunner, NPS thesis, 1988, Table 8's structure, consistent units,
//! volts to volts, 20 Hz), driven by inputs shaped like the thesis' runs 7/3 to 9/2 (pp. 99-101).
//!
//! Noise is twelve uniforms minus six from x <- 1664525 x + 1013904223 mod 2^32, scaled.

#![allow(clippy::unwrap_used)]

use serde_json::Value;

/// The runs' sampling interval, s.
pub(crate) const SAMPLE_TIME: f64 = 0.05;
/// The noise on the gyro, V (assumed; the thesis gives none).
pub(crate) const NOISE: f64 = 0.005;
/// The thesis' gyro bias, V.
pub(crate) const BIAS: f64 = 0.025;
/// The noise's seed.
pub(crate) const SEED: u32 = 12345;
/// The depth noise's seed.
pub(crate) const DEPTH_SEED: u32 = 54321;

/// The expected values that lie beside these tests.
pub(crate) fn expected() -> Value {
    serde_json::from_str(include_str!("../data/least_squares_cases.json")).unwrap()
}

/// A list of numbers.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect()
}

/// A plant's difference equation.
#[derive(Clone, Debug)]
pub(crate) struct Plant {
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
}

/// The plant of a run.
pub(crate) fn plant(run: &str) -> Plant {
    let name = match run {
        "7/3" | "7/5" => "P3_1.2",
        "9/1" | "9/2" => "P3_1.8",
        _ => "P3_2.1",
    };
    let plant = &expected()["plants"][name];
    Plant {
        a: numbers(&plant["a"]),
        b: numbers(&plant["b"]),
    }
}

/// The plane command of a run, V.
pub(crate) fn planes(run: &str) -> Vec<f64> {
    let pulses = |count: usize, pulses: &[(usize, usize, f64)]| {
        (0..count)
            .map(|k| {
                pulses
                    .iter()
                    .filter(|(from, to, _)| (*from..*to).contains(&k))
                    .map(|(_, _, volts)| volts)
                    .sum()
            })
            .collect()
    };
    match run {
        "7/3" => pulses(
            300,
            &[
                (20, 32, 0.2),
                (80, 92, -0.2),
                (140, 152, 0.2),
                (200, 212, -0.2),
            ],
        ),
        "7/5" => pulses(
            300,
            &[
                (20, 70, 0.2),
                (70, 120, -0.2),
                (120, 170, 0.2),
                (170, 220, -0.2),
            ],
        ),
        "8/1" => pulses(200, &[(20, 40, 0.2), (60, 80, -0.2), (100, 120, 0.1)]),
        "9/1" => pulses(240, &[(20, 36, 0.2), (100, 116, -0.2)]),
        "9/2" => {
            // sin(j pi/8) to ten decimals: these decimals define the run.
            #[allow(clippy::approx_constant)]
            const EIGHTH: [f64; 5] = [0.0, 0.3826834324, 0.7071067812, 0.9238795325, 1.0];
            let sine = |j: usize| {
                let quarter = j % 8;
                let size = EIGHTH[if quarter <= 4 { quarter } else { 8 - quarter }];
                if j % 16 < 8 { size } else { -size }
            };
            (0..240)
                .map(|k: usize| k.checked_sub(20).map_or(0.0, |j| 0.25 * sine(j)))
                .collect()
        }
        other => panic!("no run {other}"),
    }
}

/// y_k from the outputs and inputs before it.
pub(crate) fn next(plant: &Plant, inputs: &[f64], outputs: &[f64]) -> f64 {
    let k = outputs.len();
    let past = |coefficients: &[f64], values: &[f64]| -> f64 {
        coefficients
            .iter()
            .take(k)
            .enumerate()
            .map(|(i, c)| c * values[k - 1 - i])
            .sum()
    };
    past(&plant.b, inputs) - past(&plant.a, outputs)
}

/// The plant's response from rest.
pub(crate) fn respond(plant: &Plant, inputs: &[f64]) -> Vec<f64> {
    let mut outputs = Vec::new();
    for _ in inputs {
        outputs.push(next(plant, inputs, &outputs));
    }
    outputs
}

/// `count` numbers of variance one.
pub(crate) fn noise(seed: u32, count: usize) -> Vec<f64> {
    let mut x = seed;
    let mut uniform = || {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(x) + 0.5) / 4_294_967_296.0
    };
    (0..count)
        .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
        .collect()
}

/// The clean output of a run, V.
pub(crate) fn clean(run: &str) -> Vec<f64> {
    respond(&plant(run), &planes(run))
}

/// Values with noise of a size added.
pub(crate) fn with_noise(values: &[f64], seed: u32, size: f64) -> Vec<f64> {
    values
        .iter()
        .zip(noise(seed, values.len()))
        .map(|(y, e)| y + size * e)
        .collect()
}
