//! Five synthetic runs that replace the thesis' lost records: third-order plants from dive planes to pitch rate at the runs' three speeds. The inputs
//! are shaped like those of runs 7/3 to 9/2 (Brunner, NPS thesis, 1988, pp. 99-101), volts to volts, 20 Hz.
//!
//! The plants have the structure of Table 8's third-order model, including a zero at z = 1, in consistent units. The runs are defined by decimal
//! numbers, so that any program can compute identical numbers. The noise is that of [`planesman_identification::noise`], scaled. Durations and noise
//! level are assumed, since the thesis does not state them.

use planesman_identification::estimators::UNKNOWNS;
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::with_noise;

/// Sampling interval of the runs, s.
pub const SAMPLE_TIME: f64 = 0.05;
/// Noise of the gyro, V (assumed; not stated in the thesis).
pub const NOISE: f64 = 0.005;
/// Gyro bias stated in the thesis, V.
pub const BIAS: f64 = 0.025;

/// A plant's difference equation `y_k = -a1 y_(k-1) - ... + b1 u_(k-1) + ...`.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// Coefficients `a1 ... an`.
    pub a: Vec<f64>,
    /// Coefficients `b1 ... bn`, V/V.
    pub b: Vec<f64>,
}

impl Plant {
    /// Next output `y_k` from previous outputs and inputs, V.
    #[must_use]
    pub fn next(&self, inputs: &[f64], outputs: &[f64]) -> f64 {
        let k = outputs.len();
        let past = |coefficients: &[f64], values: &[f64]| -> f64 {
            coefficients
                .iter()
                .take(k)
                .enumerate()
                .map(|(i, c)| c * values[k - 1 - i])
                .sum()
        };
        past(&self.b, inputs) - past(&self.a, outputs)
    }

    /// Response from rest, V.
    #[must_use]
    pub fn respond(&self, inputs: &[f64]) -> Vec<f64> {
        let mut outputs = Vec::with_capacity(inputs.len());
        for _ in inputs {
            outputs.push(self.next(inputs, &outputs));
        }
        outputs
    }
}

planesman_text::choices! {
    /// A run of the thesis, by its number.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Run {
        /// 7/3: four short pulses at 1.2 ft/s.
        SevenThree = "7/3",
        /// 7/5: a square wave at 1.2 ft/s.
        SevenFive = "7/5",
        /// 8/1: three pulses at 2.1 ft/s.
        EightOne = "8/1",
        /// 9/1: two pulses at 1.8 ft/s.
        NineOne = "9/1",
        /// 9/2: a sinusoid of 1.25 Hz at 1.8 ft/s.
        NineTwo = "9/2",
    }
}

impl Run {
    /// The run with this number.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|run| run.name() == name)
    }

    /// Speed, ft/s.
    #[must_use]
    pub fn speed(self) -> f64 {
        match self {
            Self::SevenThree | Self::SevenFive => 1.2,
            Self::EightOne => 2.1,
            Self::NineOne | Self::NineTwo => 1.8,
        }
    }

    /// Plant at the run's speed.
    #[must_use]
    pub fn plant(self) -> Plant {
        let (a, b) = match self {
            Self::SevenThree | Self::SevenFive => (
                [-2.899220036, 2.801129200, -0.9018887212],
                [0.04074507348, -0.08025755659, 0.03951248310],
            ),
            Self::NineOne | Self::NineTwo => (
                [-2.851440556, 2.707974524, -0.8565040752],
                [0.09005535940, -0.1760553911, 0.08600003167],
            ),
            Self::EightOne => (
                [-2.828096481, 2.662806429, -0.8346755128],
                [0.1214921871, -0.2366258725, 0.1151336854],
            ),
        };
        Plant {
            a: a.to_vec(),
            b: b.to_vec(),
        }
    }

    /// The same plant in the form of the vehicle's equations, in volts: the known heave terms, and `kappa`, `beta`, `mu`. Computed from the
    /// nondimensional coefficients of Table 1 (Brunner 1988, p. 41), a length of 28 in, and calibrations of gyro and planes of 1.25 V/V, with the
    /// polarity of the records.
    #[must_use]
    pub fn vehicle(self) -> (Vehicle, [f64; UNKNOWNS]) {
        const GAIN: f64 = 1.25;
        const LENGTH: f64 = 28.0 / 12.0;
        // I'y - M'q_dot, M'w, M'q, M'delta and M'theta U^2; m' - Z'w_dot, Z'w, Z'q + m', Z'delta.
        let (i_y, m_w, m_q, m_delta, m_theta) = (0.072, 0.088, -0.20, -0.184, -0.106);
        let (m_z, z_w, z_q, z_delta) = (1.046, -1.295, 0.196, 0.095);
        let rate = self.speed() / LENGTH;
        let heave = Heave {
            to_pitch: m_w / i_y * rate,
            damping: -z_w / m_z * rate,
            from_rate: z_q / m_z * rate,
            from_input: -z_delta / m_z * rate * rate * GAIN,
            doubt: 0.0,
        };
        let unknowns = [
            -m_delta / i_y * rate * rate * GAIN,
            -m_q / i_y * rate,
            -m_theta / i_y / (LENGTH * LENGTH),
        ];
        (Vehicle { heave: Some(heave) }, unknowns)
    }

    /// Plane command, V; 0.2 V is 20 degrees.
    #[must_use]
    pub fn planes(self) -> Vec<f64> {
        match self {
            Self::SevenThree => pulses(
                300,
                &[
                    (20, 32, 0.2),
                    (80, 92, -0.2),
                    (140, 152, 0.2),
                    (200, 212, -0.2),
                ],
            ),
            Self::SevenFive => pulses(
                300,
                &[
                    (20, 70, 0.2),
                    (70, 120, -0.2),
                    (120, 170, 0.2),
                    (170, 220, -0.2),
                ],
            ),
            Self::EightOne => pulses(200, &[(20, 40, 0.2), (60, 80, -0.2), (100, 120, 0.1)]),
            Self::NineOne => pulses(240, &[(20, 36, 0.2), (100, 116, -0.2)]),
            Self::NineTwo => (0..240)
                .map(|k: usize| k.checked_sub(20).map_or(0.0, |j| 0.25 * sixteenth_sine(j)))
                .collect(),
        }
    }

    /// Output without noise and bias, V.
    #[must_use]
    pub fn clean(self) -> Vec<f64> {
        self.plant().respond(&self.planes())
    }

    /// Output with gyro noise and bias, V.
    #[must_use]
    pub fn measured(self, seed: u32, noise: f64, bias: f64) -> Vec<f64> {
        with_noise(&self.clean(), seed, noise)
            .into_iter()
            .map(|y| y + bias)
            .collect()
    }
}

/// A signal that is zero except for pulses: first sample, sample after the last, V.
fn pulses(count: usize, pulses: &[(usize, usize, f64)]) -> Vec<f64> {
    (0..count)
        .map(|k| {
            pulses
                .iter()
                .filter(|(from, to, _)| (*from..*to).contains(&k))
                .map(|(_, _, volts)| volts)
                .sum()
        })
        .collect()
}

/// sin(j pi / 8) with ten decimals, which define the run.
fn sixteenth_sine(j: usize) -> f64 {
    #[allow(clippy::approx_constant)]
    const EIGHTH: [f64; 5] = [0.0, 0.3826834324, 0.7071067812, 0.9238795325, 1.0];
    let quarter = j % 8;
    let size = EIGHTH[if quarter <= 4 { quarter } else { 8 - quarter }];
    if j % 16 < 8 { size } else { -size }
}
