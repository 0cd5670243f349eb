//! Reads the record that the options describe.

use planesman_parallel::Progress;
use planesman_signals::{
    Method, Options, Preparation, PreparedRecord, Source, StepName, read_record, unreachable,
    without_dynamics,
};

use crate::data::{DataOptions, reading};
use crate::error::FitError;
use crate::options::{GridOptions, SignalOptions, Validation};
use crate::steps_in_words::StepsInWords;

/// Half the shortest sampling interval, s.
const EDGE: f64 = 0.5e-6;

/// Expected properties of a record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// Number of zeros inserted before each segment.
    pub(crate) prewindow: usize,
    /// Whether the output is at rest before the record, so that a constant input is a step.
    pub(crate) at_rest: bool,
    /// Whether the output may be the input times a number.
    pub(crate) is_static: bool,
    /// Whether a given model is simulated, which does not need a moving input.
    pub(crate) is_simulated: bool,
}

impl Expected {
    /// No expectations, for validation data.
    pub(crate) const ANY: Self = Self {
        prewindow: 0,
        at_rest: false,
        is_static: true,
        is_simulated: true,
    };
}

/// Two times, s.
type Window = (f64, f64);

impl GridOptions {
    /// The options of each window, with the grid's rate `rate` unless the options give a rate.
    fn of_windows(&self, rate: Option<f64>) -> Vec<Options> {
        let all = [(f64::NEG_INFINITY, f64::INFINITY)];
        let windows = match &self.window[..] {
            [] => &all[..],
            windows => windows,
        };
        let of = |(from, to): &Window| Options {
            rate: self.rate.or(rate),
            window: *from..=*to,
            input_method: self.input_method,
            output_method: self.output_method,
            max_gap: self.max_gap,
            unwrap: self.unwrap,
        };
        windows.iter().map(of).collect()
    }

    /// Replaces the windows; the other options are kept.
    pub(crate) fn within(&self, window: Vec<Window>) -> Self {
        Self {
            window,
            ..self.clone()
        }
    }

    /// Sets the grid's rate, Hz, unless a rate is given.
    pub(crate) fn at_rate(mut self, rate: f64) -> Self {
        self.rate.get_or_insert(rate);
        self
    }

    /// Averages the outputs about each instant if a record was decimated without a given rate.
    pub(crate) fn averaged_where_decimated(&self, record: &PreparedRecord) -> Option<Self> {
        let decimated = record
            .steps
            .iter()
            .any(|it| it.name == StepName::Decimation);
        let linear = self.rate.is_none() && self.output_method == Method::Linear;
        (decimated && linear).then(|| Self {
            output_method: Method::Centred,
            ..self.clone()
        })
    }

    /// Grids without the validation window, in order of preference: the first grid that finds samples is used. It covers the data before and after
    /// the window, or one of the two.
    pub(crate) fn outside(&self, (from, to): Window) -> Result<Vec<Self>, FitError> {
        let windows = &self.window;
        if let Some(window) = windows.iter().find(|(a, b)| *a < to && from < *b) {
            return Err(FitError::Overlap {
                window: *window,
                validation: (from, to),
            });
        }
        // Samples on the window's edges are in it.
        let (before, behind) = ((f64::NEG_INFINITY, from - EDGE), (to + EDGE, f64::INFINITY));
        let ways = match (windows.is_empty(), from > 0.0) {
            (false, _) => vec![windows.clone()],
            (true, true) => vec![vec![before, behind], vec![before], vec![behind]],
            (true, false) => vec![vec![behind]],
        };
        Ok(ways.into_iter().map(|it| self.within(it)).collect())
    }
}

/// The message type for the motion of planes between samples, and its field for the mean.
const MOTION: (&str, &str) = ("planesman_msgs/msg/PlaneMotion", "dive_planes");

impl SignalOptions {
    /// The signal of interval means that a bag has in addition to samples of the planes' positions.
    pub(crate) fn means_of_motion(&self) -> Result<Option<String>, FitError> {
        if !self.input.contains("planes:") {
            return Ok(None);
        }
        let signals = [self.input.clone(), self.output.clone()];
        let sources = self.data.each(&signals)?;
        Ok(sources.iter().find_map(|source| {
            let mut topics = source.bag()?.topics().iter().map(|it| &it.topic);
            let found = topics.find(|topic| topic.kind.type_name == MOTION.0)?;
            Some(format!("{}:{}", found.name.rsplit('/').next()?, MOTION.1))
        }))
    }

    /// The validation data on the grid of the fitted data, with the same decimation.
    pub(crate) fn validation(
        &self,
        given: &Validation,
        fitted: &PreparedRecord,
        progress: &dyn Progress,
    ) -> Result<PreparedRecord, FitError> {
        let own = match given {
            Validation::Window(..) => None,
            Validation::Data(path) => Some(self.data.for_files(vec![path.clone()])),
        };
        let grid = self.grid.within(match given {
            Validation::Window(from, to) => vec![(*from, *to)],
            Validation::Data(_) => Vec::new(),
        });
        let averaged = grid.averaged_where_decimated(fitted);
        let rate = 1.0 / fitted.resampled.record.sample_time;
        let grid = averaged.unwrap_or(grid).at_rate(rate);
        let data = own.as_ref().unwrap_or(&self.data);
        let record = self.record(data, &grid, Expected::ANY, false, progress);
        record.map_err(|error| FitError::Validation(Box::new(error)))
    }

    /// Reads the signals as a record for uses other than a fit.
    ///
    /// # Errors
    /// If options conflict, the data cannot be read or lacks a signal, or the signals have no common time or do not move.
    pub fn read(&self, progress: &dyn Progress) -> Result<PreparedRecord, FitError> {
        self.check()?;
        self.record(&self.data, &self.grid, Expected::ANY, false, progress)
    }

    /// Reads the signals of `data` as a record on `grid`: the input, and the reference if there is one. Each window of each source gives one or more
    /// segments. If allowed and no rate is given, the record is decimated when it is sampled much faster than it moves.
    ///
    /// # Errors
    /// If the data cannot be read or lacks a signal, the signals have no common time, the grid is finer than the data, or the signals have
    /// no dynamics.
    pub(crate) fn record(
        &self,
        data: &DataOptions,
        grid: &GridOptions,
        expected: Expected,
        decimate: bool,
        progress: &dyn Progress,
    ) -> Result<PreparedRecord, FitError> {
        let in_words = StepsInWords::read(&self.input).is_some();
        let mut signals = self.inputs();
        signals.extend(self.reference.clone());
        signals.drain(..usize::from(in_words));
        signals.extend(self.outputs());
        let sources = data.each(&signals)?;
        self.record_of(&sources, grid, expected, decimate, progress)
    }

    /// Like [`SignalOptions::record`], for open sources.
    pub(crate) fn record_of(
        &self,
        sources: &[Box<dyn Source>],
        grid: &GridOptions,
        expected: Expected,
        decimate: bool,
        progress: &dyn Progress,
    ) -> Result<PreparedRecord, FitError> {
        let mut inputs = self.inputs();
        inputs.extend(self.reference.clone());
        let outputs = self.outputs();
        let mut prepared: Option<PreparedRecord> = None;
        let in_words = StepsInWords::read(&self.input);
        let recorded = &inputs[usize::from(in_words.is_some())..];
        for source in sources {
            let rate = prepared
                .as_ref()
                .map(|prepared| 1.0 / prepared.resampled.record.sample_time);
            let windows = grid.of_windows(rate.or(source.sample_time().map(f64::recip)));
            let read = |inputs: &[String]| {
                reading(source.bytes(), progress, |told| {
                    read_record(&**source, inputs, &outputs, &windows, told)
                })
            };
            let next = match (&in_words, read(&inputs)) {
                (_, Ok(of_its_name)) => of_its_name,
                (None, Err(refusal)) => return Err(FitError::data(refusal)),
                (Some(Err(rule)), Err(_)) => {
                    return Err(FitError::value("input", &self.input, rule.clone()));
                }
                (Some(Ok(steps)), Err(_)) => {
                    let mut next = read(recorded).map_err(FitError::data)?;
                    steps.put_into(&mut next);
                    next
                }
            };
            prepared = Some(match prepared {
                None => next,
                Some(before) => before.followed_by(next),
            });
        }
        let prepared = prepared.ok_or(FitError::NoData)?;
        let record = &prepared.resampled.record;
        let preparation = &self.preparation;
        let begins = matches!(&in_words, Some(Ok(steps)) if steps.is_from_rest());
        let at_rest = expected.at_rest || begins;
        let unfit = (preparation.prefilter).and_then(|band| unreachable(record, band));
        let still = || without_dynamics(record, at_rest, expected.is_static);
        let still = (!expected.is_simulated).then(still).flatten();
        if let Some(reason) = still.or(unfit) {
            return Err(FitError::Record(reason));
        }
        Ok(prepared.prepared(&Preparation {
            decimate: decimate && grid.rate.is_none(),
            outliers: preparation.outliers,
            band: preparation.prefilter,
            segment: preparation.segment,
            trend: preparation.detrend,
            prewindow: expected.prewindow,
        }))
    }
}
