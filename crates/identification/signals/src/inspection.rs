//! Properties of the samples of a topic or table before a record is made from them; determined and described the same way as for a record.

use crate::channel::{Change, Timing};
use crate::clock::{ClockFollower, Followed};
use crate::mixture::Mixture;
use crate::repeats::{Repeats, rows_per_sample};
use crate::resample::PRELUDE;
use crate::sieve::{bursts, interval};
use crate::spread::{LostDigits, Spreader};
use crate::timing::Meter;
use crate::unwrap::{Unwrap, Unwrapper};

/// The stamps of a topic or table, in the order of arrival.
#[derive(Clone, Debug)]
pub struct StampInspection {
    clock: ClockFollower,
    meter: Meter,
    /// The first stamps, up to where the clock goes back.
    first: Vec<i64>,
    has_returned: bool,
    digits: DigitWatch,
}

/// Detects stamps that lose digits, if the first come one by one; spreads them from there on.
#[derive(Clone, Debug, Default)]
struct DigitWatch {
    lost: Option<LostDigits>,
    spreader: Option<Spreader>,
}

impl DigitWatch {
    fn of(first: &[i64]) -> Self {
        let mut first = first.to_vec();
        first.sort_unstable();
        let is_even = bursts(&first).is_none();
        Self {
            lost: is_even.then(|| LostDigits::new(interval(&first))),
            spreader: None,
        }
    }

    fn next(&mut self, stamp: i64) -> i64 {
        if let Some((mut spreader, samples)) = self.lost.as_mut().and_then(|it| it.take(stamp, 0.0))
        {
            for (stamp, _) in samples {
                spreader.next(stamp);
            }
            (self.spreader, self.lost) = (Some(spreader), None);
        }
        self.spreader.as_mut().map_or(stamp, |it| it.next(stamp))
    }
}

/// What stamps show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StampFindings {
    /// Timing of the samples on a continuous clock.
    pub timing: Timing,
    /// The share of intervals below a tenth of the mean, 0 to 1.
    pub bursts: f64,
    /// Samples per second; for bursts, averaged over the time between bursts.
    pub rate: f64,
    /// Findings about the clock, for people.
    pub clock: Vec<String>,
    /// The spread that a record applies to the stamps, if it does.
    pub change: Option<Change>,
}

impl Default for StampInspection {
    fn default() -> Self {
        Self {
            clock: ClockFollower::new(1),
            meter: Meter::default(),
            first: Vec::new(),
            has_returned: false,
            digits: DigitWatch::default(),
        }
    }
}

impl StampInspection {
    /// Takes a stamp, ns, and a hash of the message's content.
    pub fn take(&mut self, stamp: i64, content: u64) {
        if !self.has_returned && self.first.len() < PRELUDE {
            self.first.push(stamp);
            if self.first.len() == PRELUDE {
                self.digits = DigitWatch::of(&self.first);
            }
        }
        // Its upper bits are a finite number.
        let content = (content >> 12) as f64;
        let Self { meter, digits, .. } = self;
        let mut give = |followed| {
            if let Followed::Sample(_, stamp, _) = followed {
                meter.take(digits.next(stamp));
            }
        };
        self.clock.take(0, stamp, Some(content), &mut give);
        if !self.has_returned && self.clock.has_returned() {
            self.has_returned = true;
            // Those behind the newest are of the new time.
            let newest = self.first.iter().copied().max();
            let end = self.first.iter().position(|it| Some(*it) == newest);
            self.first.truncate(end.map_or(0, |it| it + 1));
        }
    }

    /// Returns the findings.
    #[must_use]
    pub fn finish(mut self) -> StampFindings {
        let meter = &mut self.meter;
        self.clock.finish(&mut |followed| {
            if let Followed::Sample(_, stamp, _) = followed {
                meter.take(stamp);
            }
        });
        // Of few they are known only now.
        let mut digits = DigitWatch::of(&self.first);
        let spread: Vec<i64> = self.first.iter().map(|it| digits.next(*it)).collect();
        if digits.spreader.is_some() && self.first.len() < PRELUDE && !self.has_returned {
            (self.digits, self.meter) = (digits, Meter::default());
            spread.into_iter().for_each(|it| self.meter.take(it));
        }
        self.first.sort_unstable();
        let bursts = bursts(&self.first);
        let timing = self.meter.timing();
        StampFindings {
            bursts: self.meter.bursts(),
            rate: bursts.map_or(timing.rate(), |it| 1e9 / it.interval),
            clock: self.clock.notes(),
            change: bursts
                .or(self.digits.spreader.map(|it| it.bursts))
                .map(|it| it.change()),
            timing,
        }
    }
}

/// The samples of one field, in the order of arrival.
#[derive(Clone, Debug, Default)]
pub struct ValueInspection {
    first: Vec<(i64, f64)>,
    /// The finding from the first samples, once there are enough.
    known: Option<Known>,
}

#[derive(Clone, Debug, Default)]
struct Known {
    repeats: Option<Repeats>,
    mixture: Option<Mixture>,
    unwrapper: Unwrapper,
}

impl ValueInspection {
    /// Takes a sample, its stamp in ns, its value finite.
    pub fn take(&mut self, stamp: i64, value: f64) {
        match &mut self.known {
            Some(known) => drop(known.unwrapper.next(value)),
            None => {
                self.first.push((stamp, value));
                if self.first.len() == PRELUDE {
                    self.look();
                }
            }
        }
    }

    fn look(&mut self) {
        let first = std::mem::take(&mut self.first);
        let values: Vec<f64> = first.iter().map(|it| it.1).collect();
        let mut unwrapper = Unwrapper::new(Unwrap::Automatic, &values);
        for value in &values {
            unwrapper.next(*value);
        }
        // A clock that goes back puts two times beside each other.
        let mixture = match first.is_sorted_by_key(|it| it.0) {
            true => Mixture::find(&first),
            false => None,
        };
        self.known = Some(Known {
            repeats: rows_per_sample(&values).map(Repeats::new),
            mixture,
            unwrapper,
        });
    }

    /// The changes that a record makes to the samples as an output, and evidence of two alternating sources.
    #[must_use]
    pub fn finish(mut self) -> (Vec<Change>, Option<Mixture>) {
        if self.known.is_none() {
            self.look();
        }
        let known = self.known.unwrap_or_default();
        let repeats = known.repeats.map(|it| it.change());
        let unwrapped = Change::of(&known.unwrapper);
        let changes = repeats.into_iter().chain(unwrapped).collect();
        (changes, known.mixture)
    }
}
