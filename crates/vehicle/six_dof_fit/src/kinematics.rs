//! Checks the consistency of a recording: each pose against the velocities that move it (Fossen 2021, eq. 2.40).
//!
//! ```text
//! (north, east, depth)' = R(roll, pitch, yaw) (u, v, w)
//! roll' = p + (q sin roll + r cos roll) tan pitch,  pitch' = q cos roll - r sin roll,  yaw' = (q sin roll + r cos roll) / cos pitch
//! ```

use std::fmt;

use planesman_equations::{Run, Track};
use planesman_linear::digits::significant;
use planesman_vehicle::six_dof::rotation;
use serde::Serialize;

use crate::signals::{SIGNALS, apart};

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
    /// The velocities with which the signal agrees if their signs are reversed.
    pub reversed: Vec<&'static str>,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            signal,
            ratio,
            reversed,
        } = self;
        if !reversed.is_empty() {
            let names = reversed.join(" and ");
            return write!(
                f,
                "{signal} follows from the velocities and the attitude only if the sign of {names} is reversed (an axis that points up or to the left?)"
            );
        }
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
            f.write_str(". Check units, clock and frame")
        }
    }
}

/// The agreement of a pose with the velocities that change it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// The pose, one of [`SIGNALS`].
    pub signal: &'static str,
    /// Its increments over those computed from the velocities, after the lag.
    pub ratio: f64,
    /// Time by which the pose is later than the velocities \[s\].
    pub lag: f64,
    /// The correlation of the increments, after the lag.
    pub correlation: f64,
}

impl Agreement {
    /// Whether ratio and lag are as they should be, as far as noise lets that be seen.
    #[must_use]
    pub fn is_close(&self) -> bool {
        let differs = !CLOSE.contains(&self.ratio) || self.lag.abs() >= LATE;
        !differs || self.correlation < CLEAR
    }
}

impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            signal, ratio, lag, ..
        } = self;
        write!(
            f,
            "{signal} moves {ratio:.3} times as far as velocities and attitude imply"
        )?;
        match lag {
            lag if lag.abs() < LATE => f.write_str(". Check scale and clock"),
            lag if *lag > 0.0 => write!(f, ", {lag:.2} s later"),
            lag => write!(f, ", {:.2} s earlier", -lag),
        }
    }
}

/// A jump of a recorded pose that the velocities do not contain, as of an estimator that is reset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reset {
    /// The number of the run.
    pub run: usize,
    /// Its time in the run \[s\].
    pub time: f64,
    /// The signal that jumps furthest, and how far.
    pub signal: &'static str,
    /// The jump, the signal's unit.
    pub jump: f64,
}

/// An input that stays at its smallest or largest value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Saturated {
    /// The input.
    pub input: String,
    /// The value.
    pub value: f64,
    /// The share of its samples there.
    pub share: f64,
}

impl fmt::Display for Saturated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "input {} stays at {} for {:.0} % of the time, so the recording hardly determines its effect",
            self.input,
            significant(self.value, 3),
            100.0 * self.share
        )
    }
}

/// Ratios in this range, and lags below this time \[s\], need no note.
const CLOSE: std::ops::Range<f64> = 0.96..1.04;
const LATE: f64 = 0.12;
/// The share of a pose's increments that velocities with reversed signs must explain.
const SURE: f64 = 0.8;
/// The correlation from which a difference is said.
const CLEAR: f64 = 0.97;
/// Lags up to this time are tried \[s\].
const LATEST: f64 = 1.0;
/// A jump is so many times the usual difference, and at least this far \[m\], \[rad\].
const JUMP: f64 = 15.0;
const LEAST_JUMP: [f64; 2] = [0.05, 0.1];
/// A pose is rounded where, within this many steps, it stays the same although the velocities imply a motion of more than this many times the
/// usual difference.
const AROUND: usize = 2;
const USUAL: f64 = 3.0;
/// The pitch from which jumps of angles do not count \[rad\].
const STEEP: f64 = 1.0;
/// Jumps of several poses within this time are one \[s\].
const ONE_RESET: f64 = 1.0;
/// An input with more values than this that spends more than this share of its samples at a limit is saturated.
const VALUES: usize = 20;
const AT_LIMIT: f64 = 0.2;
/// A pose that moves this many times as far as the velocities say contradicts them, whatever its course.
const APART: f64 = 100.0;

/// The poses of runs that contradict their velocities; `channels` are the signals of their outputs.
pub(super) fn contradictions(runs: &[Run], channels: &[usize]) -> Vec<Contradiction> {
    let of_pose = |pose: usize| {
        let states = states_of(runs, channels, pose, &[]);
        let pairs: Vec<(f64, f64)> = (states.iter())
            .flat_map(|it| it.increments(pose, 0))
            .collect();
        let ratio = ratio(&pairs)?;
        let is_far = ratio.explained <= EXPLAINED && ratio.sizes > APART;
        let of = if is_far { ratio.sizes } else { ratio.slope };
        let counts = is_far || ratio.explained > EXPLAINED;
        let signal = SIGNALS[pose].0;
        if counts {
            let reversed = Vec::new();
            return (!AGREES.contains(&of)).then_some(Contradiction {
                signal,
                ratio: of,
                reversed,
            });
        }
        reversed(runs, channels, pose).map(|reversed| Contradiction {
            signal,
            ratio: of,
            reversed,
        })
    };
    (0..NEEDED.len()).filter_map(of_pose).collect()
}

/// The velocities whose reversed signs make a pose agree; `None` if none do.
fn reversed(runs: &[Run], channels: &[usize], pose: usize) -> Option<Vec<&'static str>> {
    let of = if pose < 3 { 6..9 } else { 9..12 };
    let has = |signal: &usize| channels.contains(signal);
    let signals: Vec<usize> = of.filter(has).collect();
    // Each set of one or two of them.
    let pairs = signals.iter().enumerate();
    let pairs = pairs.flat_map(|(k, a)| signals[k + 1..].iter().map(|b| vec![*a, *b]));
    let sets = signals.iter().map(|it| vec![*it]).chain(pairs);
    let found = sets.filter_map(|set| {
        let states = states_of(runs, channels, pose, &set);
        let pairs = states.iter().flat_map(|it| it.increments(pose, 0));
        let ratio = ratio(&pairs.collect::<Vec<_>>())?;
        let agrees = ratio.explained > SURE && AGREES.contains(&ratio.slope);
        agrees.then_some((ratio.explained, set))
    });
    let (_, best) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(best.into_iter().map(|it| SIGNALS[it].0).collect())
}

/// The agreement of each pose with the velocities, at the lag where it is best.
pub(super) fn agreements(runs: &[Run], channels: &[usize]) -> Vec<Agreement> {
    let of_pose = |pose: usize| {
        let states = states_of(runs, channels, pose, &[]);
        let step = states.first()?.step;
        let most = (LATEST / step) as i64;
        let at = |lag: i64| {
            let pairs = states.iter().flat_map(|it| it.increments(pose, lag));
            let found = ratio(&pairs.collect::<Vec<_>>())?;
            Some((lag, found))
        };
        let (lag, best) = (-most..=most)
            .filter_map(at)
            .max_by(|a, b| a.1.explained.total_cmp(&b.1.explained))?;
        (best.explained > EXPLAINED).then(|| Agreement {
            signal: SIGNALS[pose].0,
            ratio: best.slope,
            lag: lag as f64 * step,
            correlation: best.explained.sqrt(),
        })
    };
    (0..NEEDED.len()).filter_map(of_pose).collect()
}

/// The jumps of poses that the velocities do not contain, in the order of time.
pub(super) fn resets(runs: &[Run], channels: &[usize]) -> Vec<Reset> {
    let mut all: Vec<Reset> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let mut found: Vec<Reset> = Vec::new();
        for pose in 0..NEEDED.len() {
            let Some(states) = States::new(run, channels, pose, &[]) else {
                continue;
            };
            let pairs = states.states.windows(2).map(|it| {
                let said = 0.5 * states.step * (it[0].0 + it[1].0);
                (apart(pose, it[1].1, it[0].1), said)
            });
            let pairs: Vec<(f64, f64)> = pairs.collect();
            let jumps: Vec<f64> = pairs.iter().map(|it| it.0 - it.1).collect();
            let mut sizes: Vec<f64> = jumps.iter().map(|it| it.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let usual = sizes.get(sizes.len() / 2).copied().unwrap_or_default();
            let least = (JUMP * usual).max(LEAST_JUMP[pose / 3]);
            // A rounded pose stays the same where the velocities move it, and then makes up for it.
            let stays = |it: &(f64, f64)| it.1.abs() > USUAL * usual && it.0 == 0.0;
            let is_rounded = |k: usize| {
                let near = k.saturating_sub(AROUND)..(k + AROUND + 1).min(pairs.len());
                pairs[near].iter().any(stays)
            };
            let far = jumps.iter().enumerate();
            let is_defined = |k: usize| {
                let is_angle = (3..6).contains(&pose);
                !(is_angle && (states.steep[k] || states.steep[k + 1]))
            };
            let far = far.filter(|it| it.1.abs() > least && !is_rounded(it.0) && is_defined(it.0));
            found.extend(far.map(|(k, jump)| Reset {
                run: number,
                time: states.from + states.step * (k as f64 + 0.5),
                signal: SIGNALS[pose].0,
                jump: *jump,
            }));
        }
        found.sort_by(|a, b| a.time.total_cmp(&b.time));
        for reset in found {
            match all.last_mut() {
                Some(last) if last.run == number && reset.time - last.time < ONE_RESET => {
                    if reset.jump.abs() > last.jump.abs() {
                        (last.signal, last.jump) = (reset.signal, reset.jump);
                    }
                }
                _ => all.push(reset),
            }
        }
    }
    all
}

/// The inputs that stay at a limit of their range.
pub(super) fn saturated(runs: &[Run], names: &[String]) -> Vec<Saturated> {
    let of_input = |(place, name): (usize, &String)| {
        let tracks = runs.iter().filter_map(|it| it.inputs.get(place));
        let mut values: Vec<f64> = tracks.flat_map(|it| it.values.iter().copied()).collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let mut distinct = values.clone();
        distinct.dedup();
        if distinct.len() <= VALUES {
            return None;
        }
        let ends = [values[0], values[count - 1]];
        let share = |end: f64| values.iter().filter(|it| **it == end).count() as f64 / count as f64;
        let (share, value) = ends
            .map(|end| (share(end), end))
            .into_iter()
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        (share > AT_LIMIT).then(|| Saturated {
            input: name.clone(),
            value,
            share,
        })
    };
    names.iter().enumerate().filter_map(of_input).collect()
}

/// The regression of the second number of each pair on the first, about their means.
struct Ratio {
    slope: f64,
    /// The share of the second that the first explains.
    explained: f64,
    /// The second's size over the first's.
    sizes: f64,
}

fn ratio(pairs: &[(f64, f64)]) -> Option<Ratio> {
    let count = pairs.len() as f64;
    let mean = pairs.iter().fold((0.0, 0.0), |(x, y), it| {
        (x + it.0 / count, y + it.1 / count)
    });
    let sums = pairs.iter().fold([0.0; 3], |[xx, xy, yy], it| {
        let (x, y) = (it.0 - mean.0, it.1 - mean.1);
        [xx + x * x, xy + x * y, yy + y * y]
    });
    let [xx, xy, yy] = sums;
    (xx > 0.0 && yy > 0.0).then(|| Ratio {
        slope: xy / xx,
        explained: xy * xy / (xx * yy),
        sizes: (yy / xx).sqrt(),
    })
}

/// The states of a pose on a grid.
struct States {
    from: f64,
    step: f64,
    /// The rate that the velocities imply, and the pose.
    states: Vec<(f64, f64)>,
    /// Whether the pitch is so steep that roll and yaw are hardly defined.
    steep: Vec<bool>,
}

/// The states of a pose in each run that has it, with the signs of some velocities reversed.
fn states_of(runs: &[Run], channels: &[usize], pose: usize, reversed: &[usize]) -> Vec<States> {
    let each = runs.iter();
    let each = each.filter_map(|run| States::new(run, channels, pose, reversed));
    each.collect()
}

impl States {
    fn new(run: &Run, channels: &[usize], pose: usize, reversed: &[usize]) -> Option<Self> {
        let track = |signal: usize| {
            let place = channels.iter().position(|it| *it == signal)?;
            Some(&run.outputs[place])
        };
        let own = track(pose)?;
        if NEEDED[pose].iter().any(|it| track(*it).is_none()) {
            return None;
        }
        let steps = own.times.len().saturating_sub(1).clamp(1, SAMPLES);
        let (from, to) = (*own.times.first()?, *own.times.last()?);
        let step = (to - from) / steps as f64;
        if step <= 0.0 {
            return None;
        }
        let tracks: Vec<Option<&Track>> = (0..SIGNALS.len()).map(track).collect();
        let mut steep = Vec::new();
        let states = (0..=steps).map(|k| {
            let time = from + k as f64 * step;
            let at = |signal: usize| {
                let value = tracks[signal].map_or(0.0, |it| between(it, time, signal));
                if reversed.contains(&signal) {
                    -value
                } else {
                    value
                }
            };
            steep.push(at(4).abs() > STEEP);
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
        let states = states.collect();
        Some(Self {
            from,
            step,
            states,
            steep,
        })
    }

    /// Increments over a time: first computed from the velocities, then recorded, by so many steps later.
    fn increments(&self, pose: usize, lag: i64) -> Vec<(f64, f64)> {
        let span = ((SPAN / self.step).ceil() as usize).max(STEPS);
        let begins = (0..self.states.len().saturating_sub(span)).step_by(span);
        let moved = begins.filter_map(|begin| {
            let of = &self.states[begin..=begin + span];
            let later = usize::try_from(begin as i64 + lag).ok()?;
            let recorded = self.states.get(later..=later + span)?;
            let inner: f64 = of[1..span].iter().map(|it| it.0).sum();
            let said = self.step * (inner + 0.5 * (of[0].0 + of[span].0));
            Some((said, apart(pose, recorded[span].1, recorded[0].1)))
        });
        moved.collect()
    }
}

/// The value at a time by linear interpolation; angles the shorter way.
fn between(track: &Track, time: f64, signal: usize) -> f64 {
    let (times, values) = (&track.times, &track.values);
    match times.partition_point(|it| *it <= time) {
        0 => values.first().copied().unwrap_or_default(),
        at if at == times.len() => values[at - 1],
        at => {
            let share = (time - times[at - 1]) / (times[at] - times[at - 1]);
            values[at - 1] + share * apart(signal, values[at], values[at - 1])
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
    fn a_pose_that_comes_late_and_one_that_jumps_are_found() {
        let (mut run, channels) = weaving();
        // Depth that is 0.3 s late, since its samples are those of the end of their step, and 10 % too long.
        let depths = run.outputs[0].values.clone();
        run.outputs[0].values = (0..600_usize)
            .map(|k| 1.1 * depths[k.saturating_sub(4)])
            .collect();
        let found = agreements(&[run.clone()], &channels);
        let depth = found.iter().find(|it| it.signal == "depth").unwrap();
        assert!(
            (depth.lag - 0.3).abs() < 0.05 && (depth.ratio - 1.1).abs() < 0.02,
            "{depth:?}"
        );
        assert!(!depth.is_close());
        assert_eq!(resets(&[run.clone()], &channels), []);
        run.outputs[0].values[300..]
            .iter_mut()
            .for_each(|it| *it += 0.5);
        let found = resets(&[run], &channels);
        let [reset] = &found[..] else {
            panic!("{found:?}");
        };
        assert!(
            (reset.time - 29.95).abs() < 1e-6 && (reset.jump - 0.5).abs() < 0.05,
            "{reset:?}"
        );
    }

    #[test]
    fn a_reversed_velocity_that_moves_a_pose_together_with_another_is_named() {
        let (mut run, channels) = weaving();
        // Depth by sway in roll: w of its own size, and reversed.
        let times = run.outputs[0].times.clone();
        let heave = |t: f64| 0.6 * libm::cos(0.7 * t);
        let more = times.iter().map(|t| 0.6 / 0.7 * libm::sin(0.7 * (t + 0.1)));
        for (value, more) in run.outputs[0].values.iter_mut().zip(more) {
            *value += more * 0.95;
        }
        run.outputs[3].values = times.iter().map(|t| heave(*t)).collect();
        assert_eq!(contradictions(&[run.clone()], &channels), []);
        run.outputs[3].values.iter_mut().for_each(|it| *it = -*it);
        let found = contradictions(&[run], &channels);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(
            (found[0].signal, &found[0].reversed[..]),
            ("depth", &["w"][..])
        );
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
