//! Checks the consistency of a recording: each pose against the velocities that move it (Fossen 2021, eq. 2.40).
//!
//! ```text
//! (north, east, depth)' = R(roll, pitch, yaw) (u, v, w)
//! roll' = p + (q sin roll + r cos roll) tan pitch,  pitch' = q cos roll - r sin roll,  yaw' = (q sin roll + r cos roll) / cos pitch
//! ```

use std::fmt;

use planesman_equations::{Run, Track};
use planesman_vehicle::six_dof::rotation;
use serde::Serialize;

use crate::problem::{SIGNALS, apart};

/// The signals that each pose needs in addition to the velocity; others count as 0 if not recorded.
const NEEDED: [&[usize]; 6] = [&[6, 5], &[6, 5], &[6, 8, 4], &[9], &[10], &[11]];
/// Increments are computed over this time \[s\], and at least this number of samples.
const SPAN: f64 = 0.5;
const STEPS: usize = 5;
/// Maximum number of samples of the grid.
const SAMPLES: usize = 5000;
/// The share of the pose's increments that the velocities must explain for their ratio to count.
const EXPLAINED: f64 = 0.5;
/// Ratios in this range agree.
const AGREES: std::ops::Range<f64> = 0.7..1.4;
/// A ratio this close, relatively, to the ratio of degrees and radians counts as equal to that ratio.
const NEAR: f64 = 0.2;

/// A pose that does not agree with its velocities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contradiction {
    /// The name of the pose signal, one of [`SIGNALS`].
    pub signal: &'static str,
    /// The signal's increments divided by the increments computed from the velocities.
    pub ratio: f64,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { signal, ratio } = self;
        let is = |of: f64| (ratio.abs() / of - 1.0).abs() < NEAR;
        write!(
            f,
            "{signal} moves {ratio:.3} times as far as velocities and attitude imply"
        )?;
        if *ratio < 0.0 && is(1.0) {
            f.write_str(": the sign seems reversed (an axis that points up or to the left?)")
        } else if is(1f64.to_degrees()) || is(1f64.to_radians()) {
            f.write_str(": one of them is in degrees, the other in radians")
        } else {
            f.write_str(": check units, clock and frame")
        }
    }
}

/// The poses of runs that contradict their velocities; `channels` are the signals of their outputs.
pub(super) fn contradictions(runs: &[Run], channels: &[usize]) -> Vec<Contradiction> {
    let of_pose = |pose: usize| {
        let pairs: Vec<(f64, f64)> = runs
            .iter()
            .filter_map(|run| increments(run, channels, pose))
            .flatten()
            .collect();
        let ratio = ratio(&pairs).filter(|it| !AGREES.contains(it))?;
        let signal = SIGNALS[pose].0;
        Some(Contradiction { signal, ratio })
    };
    (0..NEEDED.len()).filter_map(of_pose).collect()
}

/// The slope of the second over the first, about their means; `None` if one does not explain the other.
fn ratio(pairs: &[(f64, f64)]) -> Option<f64> {
    let count = pairs.len() as f64;
    let mean = pairs.iter().fold((0.0, 0.0), |(x, y), it| {
        (x + it.0 / count, y + it.1 / count)
    });
    let sums = pairs.iter().fold([0.0; 3], |[xx, xy, yy], it| {
        let (x, y) = (it.0 - mean.0, it.1 - mean.1);
        [xx + x * x, xy + x * y, yy + y * y]
    });
    let [xx, xy, yy] = sums;
    let explained = xy * xy / (xx * yy);
    (explained > EXPLAINED).then(|| xy / xx)
}

/// Increments of a pose over a time: first computed from the velocities, then recorded.
fn increments(run: &Run, channels: &[usize], pose: usize) -> Option<Vec<(f64, f64)>> {
    let track = |signal: usize| {
        let place = channels.iter().position(|it| *it == signal)?;
        Some(&run.outputs[place])
    };
    let own = track(pose)?;
    if NEEDED[pose].iter().any(|it| track(*it).is_none()) {
        return None;
    }
    let steps = own.times.len().clamp(1, SAMPLES);
    let (from, to) = (*own.times.first()?, *own.times.last()?);
    let step = (to - from) / steps as f64;
    if step <= 0.0 {
        return None;
    }
    let grid = (0..=steps).map(|k| from + k as f64 * step);
    let tracks: Vec<Option<&Track>> = (0..SIGNALS.len()).map(track).collect();
    let states = grid.map(|time| {
        let at = |signal: usize| tracks[signal].map_or(0.0, |it| between(it, time));
        let [roll, pitch, yaw] = [3, 4, 5].map(at);
        let ([sin, cos], [p, q, r]) = ([libm::sin(roll), libm::cos(roll)], [9, 10, 11].map(at));
        let turning = q * sin + r * cos;
        let rate = match pose {
            0..3 => {
                let turned = rotation::matrix(rotation::from_euler([roll, pitch, yaw]));
                rotation::to_fixed(&turned, [6, 7, 8].map(at))[pose]
            }
            3 => p + turning * libm::tan(pitch),
            4 => q * cos - r * sin,
            _ => turning / libm::cos(pitch),
        };
        (rate, at(pose))
    });
    let states: Vec<(f64, f64)> = states.collect();
    let span = ((SPAN / step).ceil() as usize).max(STEPS);
    let windows = states.windows(span + 1).step_by(span);
    let moved = windows.map(|it| {
        let inner: f64 = it[1..span].iter().map(|it| it.0).sum();
        let said = step * (inner + 0.5 * (it[0].0 + it[span].0));
        (said, apart(pose, it[span].1, it[0].1))
    });
    Some(moved.collect())
}

/// The value at a time by linear interpolation.
fn between(track: &Track, time: f64) -> f64 {
    let (times, values) = (&track.times, &track.values);
    match times.partition_point(|it| *it <= time) {
        0 => values.first().copied().unwrap_or_default(),
        at if at == times.len() => values[at - 1],
        at => {
            let share = (time - times[at - 1]) / (times[at] - times[at - 1]);
            values[at - 1] + share * (values[at] - values[at - 1])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_equations::Between;

    /// Pitch, depth, u, w, q at 10 Hz of a weaving vehicle.
    fn weaving() -> (Run, Vec<usize>) {
        let times: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        let pitch = |t: f64| 0.3 * libm::sin(0.4 * t);
        let mut depth = 0.0;
        let depths = times.iter().map(|t| {
            // A hundredth of the step at a time.
            for k in 0..100 {
                let at = t + 0.001 * (f64::from(k) + 0.5);
                depth += 0.001 * (-libm::sin(pitch(at)) * 1.5);
            }
            depth
        });
        let depths: Vec<f64> = depths.collect();
        let track = |values: Vec<f64>| Track {
            times: times.clone(),
            values,
        };
        let of = |f: &dyn Fn(f64) -> f64| track(times.iter().map(|t| f(*t)).collect());
        let outputs = vec![
            track(depths),
            of(&pitch),
            of(&|_| 1.5),
            of(&|_| 0.0),
            of(&|t| 0.12 * libm::cos(0.4 * t)),
        ];
        let run = Run {
            inputs: Vec::new(),
            outputs,
            between: Between::default(),
        };
        (run, vec![2, 4, 6, 8, 10])
    }

    #[test]
    fn a_recording_that_agrees_with_itself_has_no_contradiction() {
        let (run, channels) = weaving();
        assert_eq!(contradictions(&[run], &channels), []);
    }

    #[test]
    fn an_axis_that_points_up_and_rates_in_degrees_are_named() {
        let (mut run, channels) = weaving();
        run.outputs[0].values.iter_mut().for_each(|it| *it = -*it);
        let rates = &mut run.outputs[4].values;
        rates.iter_mut().for_each(|it| *it = it.to_degrees());
        let found = contradictions(&[run], &channels);
        let said: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert!(
            said[0].contains("depth") && said[0].contains("reversed"),
            "{said:?}"
        );
        assert!(
            said[1].contains("pitch") && said[1].contains("degrees"),
            "{said:?}"
        );
    }
}
