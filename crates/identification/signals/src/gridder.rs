//! Resamples one signal to a uniform grid, sample by sample. All numbers are resampled here, offline ([`crate::resample`]) and live
//! ([`crate::live_grid`]).
//!
//! ```text
//! linear   y(t_k)                                     on the straight line between the samples before and after t_k
//! hold     u(t_k)                                     of the latest sample at or before t_k
//! mean     u_k = (1/T) integral of u(t) dt            over [t_k, t_(k+1)), each sample held until the next,
//!          m_k = (1/T^2) integral of (t - t_k - T/2) u(t) dt      and its first moment, both exactly
//! foh      the same                                   on the straight lines between the samples
//! centred  the mean of the samples nearer to t_k than to any other instant
//! ```

use std::ops::RangeInclusive;

use planesman_record::Input;

use crate::channel::Method;

/// The requested instants among `anchor + k step`.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    anchor: i64,
    /// ns.
    pub(crate) step: f64,
    /// The step, if it is a whole number: instants are then exact at any distance.
    whole: Option<i64>,
    pub(crate) first: i64,
    pub(crate) last: i64,
}

impl Grid {
    /// The grid through `anchor`, ns, with a step of at least 1 ns.
    pub(crate) fn new(anchor: i64, step: f64) -> Self {
        const EXACT: f64 = (1_i64 << 53) as f64;
        Self {
            anchor,
            step,
            whole: (step.fract() == 0.0 && step < EXACT).then_some(step as i64),
            first: i64::MIN,
            last: i64::MAX,
        }
    }

    /// Limits the instants to a window of seconds from the anchor.
    pub(crate) fn within(self, window: &RangeInclusive<f64>) -> Self {
        // A rounding's worth beside the edges still counts as within.
        let index = |seconds: f64| seconds * 1e9 / self.step;
        Self {
            first: (index(*window.start()) - 1e-6).ceil() as i64,
            last: (index(*window.end()) + 1e-6).floor() as i64,
            ..self
        }
    }

    /// Extends the grid by this many earlier instants.
    pub(crate) fn reaching_back(self, instants: i64) -> Self {
        Self {
            first: self.first.saturating_sub(instants),
            ..self
        }
    }

    pub(crate) fn time(&self, k: i64) -> i64 {
        let since = match self.whole {
            Some(step) => k.saturating_mul(step),
            None => (k as f64 * self.step).round() as i64,
        };
        self.anchor.saturating_add(since)
    }

    /// The last instant at or before `stamp`.
    pub(crate) fn at_or_before(&self, stamp: i64) -> i64 {
        let since = stamp.saturating_sub(self.anchor);
        if let Some(step) = self.whole {
            return since.div_euclid(step);
        }
        // By a rounding's worth at most one too far or too near.
        let k = (since as f64 / self.step).floor() as i64;
        if self.time(k) > stamp {
            k - 1
        } else {
            k + i64::from(self.time(k + 1) <= stamp)
        }
    }

    /// The first instant at or after `stamp`.
    fn at_or_after(&self, stamp: i64) -> i64 {
        let before = self.at_or_before(stamp);
        before + i64::from(self.time(before) < stamp)
    }
}

/// The destination of numbers: a grid, and the callback that receives them.
pub(crate) struct Onto<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) put: &'a mut dyn FnMut(Put),
}

/// Numbers on the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Put {
    /// A value at one instant; for the method mean, the mean over the interval that begins there, with its first moment.
    One(i64, Input),
    /// One value at the instants from the first up to the second.
    Held(i64, i64, f64),
}

/// The state of resampling one signal.
#[derive(Clone, Debug)]
pub(crate) struct Gridder {
    method: Method,
    bin: Option<Bin>,
}

/// The partial mean of one interval.
#[derive(Clone, Debug)]
struct Bin {
    k: i64,
    /// The first value; means are computed relative to it, so that the mean of equal values is exact.
    base: f64,
    /// The sum of `(value - base) weight`.
    sum: f64,
    weight: f64,
    /// The partial first moment. The base does not contribute to the moment.
    moment: f64,
}

impl Bin {
    fn of(k: i64, base: f64) -> Self {
        Self {
            k,
            base,
            sum: 0.0,
            weight: 0.0,
            moment: 0.0,
        }
    }

    fn put(&self) -> Put {
        let input = Input {
            mean: self.base + self.sum / self.weight,
            moment: self.moment,
        };
        Put::One(self.k, input)
    }
}

impl Gridder {
    /// A signal before its first sample.
    pub(crate) fn new(method: Method) -> Self {
        Self { method, bin: None }
    }

    /// Discards the partial interval.
    pub(crate) fn forget(&mut self) {
        self.bin = None;
    }

    /// Takes the first sample, or the first after a gap.
    pub(crate) fn begin(&mut self, sample: (i64, f64), onto: &mut Onto<'_>) {
        match self.method {
            Method::Linear => at_instant(sample, onto),
            Method::Centred => self.centred(sample, onto),
            Method::Mean | Method::Foh | Method::Hold => {}
        }
    }

    /// Takes two samples with no gap between them. The methods linear and foh fill at most `most` instants between them.
    pub(crate) fn pair(
        &mut self,
        (t0, v0): (i64, f64),
        (t1, v1): (i64, f64),
        most: usize,
        onto: &mut Onto<'_>,
    ) {
        let grid = onto.grid;
        match self.method {
            Method::Linear => {
                let instants = (grid.at_or_before(t0) + 1).max(grid.first)
                    ..=grid.at_or_before(t1).min(grid.last);
                let slope = (v1 - v0) / (t1 - t0) as f64;
                for k in instants.take(most) {
                    let from_end = (grid.time(k) - t1) as f64;
                    (onto.put)(Put::One(k, Input::held(v1 + slope * from_end)));
                }
            }
            Method::Hold => (onto.put)(Put::Held(grid.at_or_after(t0), grid.at_or_after(t1), v0)),
            Method::Mean => self.hold_over(v0, t0, t1, onto),
            Method::Foh => {
                let slope = (v1 - v0) / (t1 - t0) as f64;
                let intervals = grid.at_or_before(t0).max(grid.first.saturating_sub(1))
                    ..=grid.at_or_before(t1).min(grid.last);
                for k in intervals.take(most.saturating_add(2)) {
                    let (from, to) = (t0.max(grid.time(k)), t1.min(grid.time(k + 1)));
                    let middle = 0.5 * ((from - t1) as f64 + (to - t1) as f64);
                    self.add(k, (v1 + slope * middle, slope), from, to, onto);
                }
            }
            Method::Centred => self.centred((t1, v1), onto),
        }
    }

    /// Takes the last sample, or the last before a gap.
    pub(crate) fn end(&mut self, sample: (i64, f64), onto: &mut Onto<'_>) {
        let (stamp, value) = sample;
        match self.method {
            Method::Linear | Method::Foh => self.bin = None,
            Method::Hold => at_instant(sample, onto),
            Method::Mean => {
                let until = onto.grid.time(onto.grid.at_or_before(stamp) + 1);
                self.hold_over(value, stamp, until, onto);
                self.bin = None;
            }
            Method::Centred => {
                if let Some(bin) = self.bin.take() {
                    (onto.put)(bin.put());
                }
            }
        }
    }

    /// `value` acts from `from` to `until`: it adds to the mean of each interval in this time, and completes intervals that it covers to
    /// the end.
    fn hold_over(&mut self, value: f64, from: i64, until: i64, onto: &mut Onto<'_>) {
        let grid = onto.grid;
        let (first, last) = (grid.at_or_before(from), grid.at_or_before(until));
        self.add(first, (value, 0.0), from, until, onto);
        if last > first {
            (onto.put)(Put::Held(first + 1, last, value));
            self.add(last, (value, 0.0), from, until, onto);
        }
    }

    /// Adds the part of `from` to `until` in interval k to its mean: the value at its middle, and a slope per ns.
    fn add(
        &mut self,
        k: i64,
        (value, slope): (f64, f64),
        from: i64,
        until: i64,
        onto: &mut Onto<'_>,
    ) {
        let grid = onto.grid;
        let (begins, ends) = (grid.time(k), grid.time(k + 1));
        let (from, to) = (from.max(begins), until.min(ends));
        if to <= from {
            return;
        }
        if from == begins {
            self.bin = Some(Bin::of(k, value));
        }
        // An interval whose beginning was not seen has no mean.
        let Some(bin) = self.bin.as_mut().filter(|bin| bin.k == k) else {
            return;
        };
        bin.sum += (value - bin.base) * (to - from) as f64;
        bin.weight += (to - from) as f64;
        // From the interval's middle, in intervals.
        let place = |stamp: i64| (stamp - begins) as f64 / (ends - begins) as f64 - 0.5;
        bin.moment += (value - bin.base) * (place(to).powi(2) - place(from).powi(2)) / 2.0;
        if slope != 0.0 {
            let rise = slope * (ends - begins) as f64;
            bin.moment += rise * (place(to) - place(from)).powi(3) / 12.0;
        }
        if to == ends {
            (onto.put)(bin.put());
        }
    }

    /// Adds a sample to the mean about the nearest instant.
    fn centred(&mut self, (stamp, value): (i64, f64), onto: &mut Onto<'_>) {
        let grid = onto.grid;
        let k = grid.at_or_before(stamp.saturating_add((0.5 * grid.step) as i64));
        if let Some(done) = self.bin.take_if(|bin| bin.k != k) {
            (onto.put)(done.put());
        }
        let bin = self.bin.get_or_insert_with(|| Bin::of(k, value));
        bin.sum += value - bin.base;
        bin.weight += 1.0;
    }
}

fn at_instant((stamp, value): (i64, f64), onto: &mut Onto<'_>) {
    let grid = onto.grid;
    let k = grid.at_or_before(stamp);
    if grid.time(k) == stamp {
        (onto.put)(Put::One(k, Input::held(value)));
    }
}
