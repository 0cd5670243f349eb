//! A manoeuvre requested by an action client: its checks and its progress.

use planesman_msgs::planesman_msgs::action::ManoeuvreGoal;
use planesman_parameters::Choice as _;

use crate::error::ManoeuvreError;
use crate::limits::Limit;
use crate::manoeuvre::{Manoeuvre, Signal, TestSignal, nanoseconds};
use crate::runs::{RUNS, Run};

/// The plane command over time.
#[derive(Clone, Debug, PartialEq)]
enum Waveform {
    Signal(TestSignal),
    /// A test run of the report, multiplied by a factor.
    Run(Run, f64),
}

/// A running manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Underway {
    waveform: Waveform,
    /// ns
    duration: i64,
    /// The time of the manoeuvre's first tick, ns of the run; `None` before that tick.
    began: Option<i64>,
    /// Its progress.
    pub progress: Progress,
}

/// The progress of a manoeuvre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Time since the manoeuvre began, s.
    pub elapsed: f64,
    /// The present offset on the planes, rad, positive dive.
    pub dive_planes: f64,
}

impl Underway {
    /// The manoeuvre of a goal, within the planes' limit.
    ///
    /// # Errors
    /// [`ManoeuvreError`].
    pub(crate) fn new(goal: &ManoeuvreGoal, planes_limit: Limit) -> Result<Self, ManoeuvreError> {
        let waveform = match Run::named(&goal.name) {
            Some(run) if goal.amplitude == 0.0 => Waveform::Run(run, 1.0),
            Some(run) => Waveform::Run(run, goal.amplitude / run.amplitude()),
            None => Waveform::Signal(signal(goal)?),
        };
        let (largest, whole) = match &waveform {
            Waveform::Run(run, factor) => (factor * run.amplitude(), run.duration),
            Waveform::Signal(_) => (goal.amplitude, goal.period),
        };
        // No range holds NaN.
        if !(0.0..=planes_limit.bound()).contains(&largest.abs()) {
            return Err(ManoeuvreError::Clipped(largest, planes_limit.bound()));
        }
        let duration = match goal.duration {
            0.0 => whole,
            duration if duration > 0.0 && duration <= 1e6 => duration,
            duration => return Err(ManoeuvreError::Duration(duration)),
        };
        Ok(Self {
            waveform,
            duration: nanoseconds(duration),
            began: None,
            progress: Progress::default(),
        })
    }

    /// The offset on the planes `elapsed` nanoseconds after the vehicle's run began, rad; `None` when the manoeuvre is over.
    pub(crate) fn at(&mut self, elapsed: i64) -> Option<f64> {
        let time = elapsed - *self.began.get_or_insert(elapsed);
        if time >= self.duration {
            return None;
        }
        let dive_planes = match &self.waveform {
            Waveform::Signal(signal) => signal.value(time),
            Waveform::Run(run, factor) => factor * run.value(time),
        };
        self.progress = Progress {
            elapsed: time as f64 * 1e-9,
            dive_planes,
        };
        Some(dive_planes)
    }
}

fn signal(goal: &ManoeuvreGoal) -> Result<TestSignal, ManoeuvreError> {
    let signal = match Signal::named(&goal.name) {
        Some(signal) if signal != Signal::None => signal,
        _ => {
            let names = Signal::NAMES[1..].iter().copied();
            let names: Vec<&str> = names.chain(RUNS.map(|run| run.name)).collect();
            return Err(ManoeuvreError::Unknown {
                name: goal.name.clone(),
                known: names.join(", "),
            });
        }
    };
    let ends_itself = matches!(signal, Signal::Pulse | Signal::Doublet);
    if goal.duration == 0.0 && !ends_itself {
        return Err(ManoeuvreError::Endless(goal.name.clone()));
    }
    Manoeuvre {
        signal,
        amplitude: goal.amplitude,
        period: goal.period,
        period_end: goal.period_end,
        start: 0.0,
        duration: goal.duration,
        seed: goal.seed,
    }
    .build()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: i64 = 50_000_000;

    fn goal(name: &str) -> ManoeuvreGoal {
        ManoeuvreGoal {
            name: name.to_owned(),
            amplitude: 0.1,
            period: 0.2,
            period_end: 0.1,
            duration: 1.0,
            seed: 1,
        }
    }

    fn underway(goal: &ManoeuvreGoal) -> Result<Underway, ManoeuvreError> {
        Underway::new(goal, Limit::new(0.5).unwrap())
    }

    #[test]
    fn every_named_manoeuvre_begins_with_its_first_tick_and_ends_after_its_duration() {
        let names = Signal::NAMES[1..].iter().copied();
        for name in names.chain(RUNS.map(|run| run.name)) {
            let mut underway = underway(&goal(name)).unwrap();
            for tick in 0..20 {
                let offset = underway.at(7 * TICK + tick * TICK).unwrap();
                assert!(offset.abs() <= 0.1, "{name}");
            }
            assert!((underway.progress.elapsed - 0.95).abs() < 1e-9, "{name}");
            assert_eq!(underway.at(27 * TICK), None, "{name}");
        }
    }

    #[test]
    fn a_run_is_the_reports_unless_it_is_scaled() {
        let mut whole = goal("run_8_1");
        (whole.amplitude, whole.duration) = (0.0, 0.0);
        let mut whole = underway(&whole).unwrap();
        assert_eq!(whole.at(0), Some(0.0));
        assert_eq!(whole.at(20 * TICK), Some(20_f64.to_radians()));
        assert!(whole.at(199 * TICK).is_some());
        assert_eq!(whole.at(200 * TICK), None);
        let mut scaled = goal("run_8_1");
        (scaled.amplitude, scaled.duration) = (-0.1, 10.0);
        let mut scaled = underway(&scaled).unwrap();
        scaled.at(0);
        assert!((scaled.at(20 * TICK).unwrap() + 0.1).abs() < 1e-15);
        assert!((scaled.at(100 * TICK).unwrap() + 0.05).abs() < 1e-15);
    }

    #[test]
    fn a_pulse_ends_with_itself() {
        let mut pulse = goal("pulse");
        pulse.duration = 0.0;
        let mut pulse = underway(&pulse).unwrap();
        let lasted = (0..).take_while(|tick| pulse.at(tick * TICK).is_some());
        assert_eq!(lasted.count(), 4);
    }

    #[test]
    fn what_cannot_be_flown_is_refused_with_the_reason() {
        let changed = |change: fn(&mut ManoeuvreGoal), name: &str| {
            let mut goal = goal(name);
            change(&mut goal);
            underway(&goal).unwrap_err().to_string()
        };
        for (refusal, reason) in [
            (changed(|_| (), "loop"), "run_7_3"),
            (changed(|_| (), "none"), "doublet"),
            (changed(|g| g.amplitude = 0.6, "step"), "planes.limit"),
            (changed(|g| g.amplitude = 0.6, "run_9_2"), "planes.limit"),
            (
                changed(|g| g.amplitude = f64::NAN, "run_9_2"),
                "planes.limit",
            ),
            (changed(|g| g.duration = 0.0, "sinusoid"), "duration"),
            (changed(|g| g.duration = -1.0, "pulse"), "duration"),
            (
                changed(|g| g.duration = f64::INFINITY, "run_7_5"),
                "duration",
            ),
            (changed(|g| g.period = 0.0, "square"), "period"),
            (changed(|g| g.period_end = 0.0, "chirp"), "period_end"),
        ] {
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
