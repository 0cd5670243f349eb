//! A recorded manoeuvre, and its metrics: pitch, depth, times.
//!
//! The units are those of the run: body lengths and `L / U` for the printed programs of Brunner 1988, metres and seconds for the dimensional vehicle.
//! Angles are in radians, pitch positive bow up.

use planesman_vehicle::{Diverged, Motion, PlanePath, State};

/// State at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Depth `z` \[length\], positive down.
    pub depth: f64,
    /// Pitch `theta` \[rad\], positive bow up.
    pub pitch: f64,
    /// Pitch rate `q` \[rad/time\], positive bow up.
    pub pitch_rate: f64,
}

/// Evenly spaced samples; the first is at time 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    step: f64,
    samples: Vec<Sample>,
}

impl Track {
    /// A track of `samples` spaced by `step`; an empty list becomes a vehicle at rest at the surface.
    #[must_use]
    pub fn new(step: f64, mut samples: Vec<Sample>) -> Self {
        if samples.is_empty() {
            samples.push(Sample::default());
        }
        Self { step, samples }
    }

    /// Simulates the dimensional vehicle from rest at the surface until `duration` \[s\]: planes at `angle` \[rad\] for `held_for` \[s\], then neutral. The
    /// step is reduced slightly if necessary to make the release coincide with a step.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn of_dive(
        motion: &Motion,
        angle: f64,
        held_for: f64,
        duration: f64,
    ) -> Result<Self, Diverged> {
        let held_steps = (held_for / motion.step).ceil().max(1.0);
        let motion = Motion {
            step: held_for / held_steps,
            ..*motion
        };
        let steps = (duration / motion.step).round() as usize;
        let mut state = State::default();
        let mut samples = vec![Sample::from(state)];
        for k in 0..steps {
            let planes = if (k as f64) < held_steps { angle } else { 0.0 };
            state = motion.advance(&state, &PlanePath::held(&planes), 1)?;
            samples.push(state.into());
        }
        Ok(Self::new(motion.step, samples))
    }

    /// The sample nearest to a time, limited to the first and the last one.
    #[must_use]
    pub fn at(&self, time: f64) -> Sample {
        let index = (time / self.step).round().max(0.0) as usize;
        self.samples[index.min(self.samples.len() - 1)]
    }

    /// The last sample.
    #[must_use]
    pub fn end(&self) -> Sample {
        self.samples[self.samples.len() - 1]
    }

    /// Lowest pitch \[rad\], with the bow furthest down.
    #[must_use]
    pub fn steepest_pitch(&self) -> f64 {
        self.samples
            .iter()
            .map(|s| s.pitch)
            .fold(f64::INFINITY, f64::min)
    }

    /// Largest `|q|` \[rad/time\].
    #[must_use]
    pub fn fastest_pitch_rate(&self) -> f64 {
        self.samples
            .iter()
            .map(|s| s.pitch_rate.abs())
            .fold(0.0, f64::max)
    }

    /// Time at which a depth is first reached, linear between two samples.
    #[must_use]
    pub fn time_to_depth(&self, depth: f64) -> Option<f64> {
        let reached = self.samples.iter().position(|s| s.depth >= depth)?;
        if reached == 0 {
            return Some(0.0);
        }
        let (above, below) = (self.samples[reached - 1], self.samples[reached]);
        let part = (depth - above.depth) / (below.depth - above.depth);
        Some((reached as f64 - 1.0 + part) * self.step)
    }

    /// Last time before `until` at which the pitch differs from its value at `until` by more than `band` times that value; 0 if it never does.
    #[must_use]
    pub fn pitch_settles_at(&self, band: f64, until: f64) -> f64 {
        let settled = self.at(until).pitch;
        self.samples
            .iter()
            .enumerate()
            .map(|(k, s)| (k as f64 * self.step, s.pitch))
            .rfind(|(t, pitch)| *t <= until && (pitch - settled).abs() > band * settled.abs())
            .map_or(0.0, |(t, _)| t)
    }

    /// Range of the pitch, highest minus lowest \[rad\], between two times.
    #[must_use]
    pub fn pitch_swing(&self, from: f64, to: f64) -> f64 {
        let within = self
            .samples
            .iter()
            .enumerate()
            .filter(|(k, _)| {
                let t = *k as f64 * self.step;
                t > from - self.step / 2.0 && t < to + self.step / 2.0
            })
            .map(|(_, s)| s.pitch);
        let (low, high) = within.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), pitch| {
            (l.min(pitch), h.max(pitch))
        });
        (high - low).max(0.0)
    }
}

impl From<State> for Sample {
    fn from(state: State) -> Self {
        Self {
            depth: state.depth,
            pitch: state.pitch,
            pitch_rate: state.pitch_rate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depth and pitch grow together, a unit a second.
    fn ramp() -> Track {
        let samples = (0..=10)
            .map(|k| Sample {
                depth: f64::from(k) * 0.5,
                pitch: f64::from(k) * 0.5,
                pitch_rate: 1.0,
            })
            .collect();
        Track::new(0.5, samples)
    }

    #[test]
    fn a_depth_between_two_samples_is_reached_between_their_times() {
        assert_eq!(ramp().time_to_depth(1.2), Some(1.2));
        assert_eq!(ramp().time_to_depth(0.0), Some(0.0));
        assert_eq!(ramp().time_to_depth(6.0), None);
    }

    #[test]
    fn the_swing_is_that_of_the_window_alone() {
        assert_eq!(ramp().pitch_swing(1.0, 3.0), 2.0);
        assert_eq!(ramp().pitch_swing(7.0, 8.0), 0.0);
    }

    #[test]
    fn a_ramp_settles_only_at_its_end() {
        assert_eq!(ramp().pitch_settles_at(0.05, 5.0), 4.5);
    }

    #[test]
    fn outside_the_record_its_ends_hold() {
        assert_eq!(ramp().at(-1.0), ramp().at(0.0));
        assert_eq!(ramp().at(99.0), ramp().end());
        assert_eq!(Track::new(0.1, Vec::new()).end(), Sample::default());
    }
}
