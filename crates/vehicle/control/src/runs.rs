//! The report's test runs: their plane commands (Brunner, NPS thesis, 1988, pp. 99-101).
//!
//! | run | shape | ft/s |
//! |---|---|---|
//! | 7/3 | short pulses of 20° on both sides | 1.2 |
//! | 7/5 | a square wave of 20° | 1.2 |
//! | 8/1 | pulses of 20°, -20° and 10° | 2.1 |
//! | 9/1 | two short pulses of 20° | 1.8 |
//! | 9/2 | a rapid sinusoid of 25° | 1.8 |
//!
//! The shapes are the report's. The thesis' records are lost, so the times are assumptions, in whole samples of 0.05 s. A pulse includes its first
//! time and excludes its second.

use std::f64::consts::TAU;

/// The motion of the planes in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// (from ms, to ms, degrees)
    Pulses(&'static [(i64, i64, f64)]),
    /// From `from` ms on, with `amplitude` degrees and a period in ms.
    Sinusoid {
        from: i64,
        amplitude: f64,
        period: i64,
    },
}

/// A run of the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Run {
    /// Name of the run as a manoeuvre: `run_7_3`.
    pub name: &'static str,
    /// The duration, s.
    pub duration: f64,
    shape: Shape,
}

/// All of them.
pub(crate) const RUNS: [Run; 5] = [
    Run {
        name: "run_7_3",
        duration: 15.0,
        shape: Shape::Pulses(&[
            (1_000, 1_600, 20.0),
            (4_000, 4_600, -20.0),
            (7_000, 7_600, 20.0),
            (10_000, 10_600, -20.0),
        ]),
    },
    Run {
        name: "run_7_5",
        duration: 15.0,
        shape: Shape::Pulses(&[
            (1_000, 3_500, 20.0),
            (3_500, 6_000, -20.0),
            (6_000, 8_500, 20.0),
            (8_500, 11_000, -20.0),
        ]),
    },
    Run {
        name: "run_8_1",
        duration: 10.0,
        shape: Shape::Pulses(&[
            (1_000, 2_000, 20.0),
            (3_000, 4_000, -20.0),
            (5_000, 6_000, 10.0),
        ]),
    },
    Run {
        name: "run_9_1",
        duration: 12.0,
        shape: Shape::Pulses(&[(1_000, 1_800, 20.0), (5_000, 5_800, -20.0)]),
    },
    Run {
        name: "run_9_2",
        duration: 12.0,
        shape: Shape::Sinusoid {
            from: 1_000,
            amplitude: 25.0,
            period: 800,
        },
    },
];

impl Run {
    /// The run with that name.
    #[must_use]
    pub(crate) fn named(name: &str) -> Option<Self> {
        RUNS.into_iter().find(|run| run.name == name)
    }

    /// The run's largest plane angle, rad.
    #[must_use]
    pub(crate) fn amplitude(&self) -> f64 {
        let degrees = match self.shape {
            Shape::Pulses(pulses) => pulses.iter().fold(0.0, |most: f64, p| most.max(p.2.abs())),
            Shape::Sinusoid { amplitude, .. } => amplitude,
        };
        degrees.to_radians()
    }

    /// The plane angle `nanos` nanoseconds after the run began, rad, positive dive.
    #[must_use]
    pub(crate) fn value(&self, nanos: i64) -> f64 {
        let millis = nanos / 1_000_000;
        let degrees = match self.shape {
            Shape::Pulses(pulses) => pulses
                .iter()
                .find(|(from, to, _)| (*from..*to).contains(&millis))
                .map_or(0.0, |pulse| pulse.2),
            Shape::Sinusoid {
                from,
                amplitude,
                period,
            } if millis >= from => {
                let within = (nanos - from * 1_000_000) % (period * 1_000_000);
                amplitude * libm::sin(TAU * within as f64 / (period * 1_000_000) as f64)
            }
            Shape::Sinusoid { .. } => 0.0,
        };
        degrees.to_radians()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The run at the report's samples, in degrees.
    fn samples(name: &str) -> Vec<f64> {
        let run = Run::named(name).unwrap();
        let count = (run.duration / 0.05).round() as i64;
        let sample = |k| run.value(k * 50_000_000).to_degrees();
        (0..count).map(sample).collect()
    }

    #[test]
    fn every_pulse_lasts_whole_samples() {
        for (name, length, deflected) in [
            ("run_7_3", 300, 4 * 12),
            ("run_7_5", 300, 4 * 50),
            ("run_8_1", 200, 3 * 20),
            ("run_9_1", 240, 2 * 16),
        ] {
            let samples = samples(name);
            assert_eq!(samples.len(), length, "{name}");
            let moved = samples.iter().filter(|angle| **angle != 0.0).count();
            assert_eq!(moved, deflected, "{name}");
        }
        assert_eq!(
            samples("run_8_1")[19..21],
            [0.0, 20_f64.to_radians().to_degrees()]
        );
    }

    #[test]
    fn the_rapid_sinusoid_repeats_every_sixteen_samples() {
        let samples = samples("run_9_2");
        assert!(samples[..21].iter().all(|angle| *angle == 0.0));
        assert!((samples[24] - 25.0).abs() < 1e-9);
        for k in 20..224 {
            assert!((samples[k] - samples[k + 16]).abs() < 1e-9);
        }
    }

    #[test]
    fn no_run_asks_for_more_than_the_planes_can() {
        for run in RUNS {
            assert!(run.amplitude() <= 30_f64.to_radians(), "{}", run.name);
        }
        assert_eq!(Run::named("run_9_3"), None);
    }
}
