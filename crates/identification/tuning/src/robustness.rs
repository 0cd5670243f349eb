//! The performance of gains over random plants within a model's uncertainty.

use planesman_identification::on_all_cores;
use planesman_linear::StepMetrics;

use crate::closed_loop::{Limits, Margins, PlantResponse};
use crate::controller::Controller;
use crate::options::TuneOptions;
use crate::response::{Motion, Trial};

/// The share of the plants that may miss a limit.
pub const MISSED: f64 = 0.05;
/// Maximum number of ticks of a response.
const MOST_TICKS: f64 = 20_000.0;
/// Maximum number of instants of a band.
const INSTANTS: usize = 400;

/// A quantity over the plants: its value for the model itself, and for the random plants.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// The value for the model itself.
    pub model: f64,
    /// The values for the random plants, sorted; infinite values are at the ends.
    pub sorted: Vec<f64>,
}

impl Distribution {
    /// Of values.
    #[must_use]
    pub fn new(model: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Self { model, sorted }
    }

    /// The quantile with that share of the plants below it, by linear interpolation; the model's value without random plants.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let Some(last) = self.sorted.len().checked_sub(1) else {
            return self.model;
        };
        let place = share * last as f64;
        let (low, high) = (
            self.sorted[place.floor() as usize],
            self.sorted[place.ceil() as usize],
        );
        match low == high {
            true => low,
            false => low + (high - low) * place.fract(),
        }
    }
}

/// Margins of the loop with the model and with random plants drawn from the model's uncertainty.
#[derive(Clone, Debug)]
pub struct Robustness {
    /// The value for the model itself.
    pub model: Margins,
    /// The margins of the random plants.
    pub draws: Vec<Margins>,
}

impl Robustness {
    pub(crate) fn new(
        controller: &Controller,
        model: &PlantResponse,
        draws: &[PlantResponse],
    ) -> Self {
        let on_grid = model.on_grid(controller);
        Self {
            model: model.margins_with(controller, &on_grid),
            draws: on_all_cores(draws, |it| it.margins_with(controller, &on_grid)),
        }
    }

    /// The phase margin, degrees.
    #[must_use]
    pub fn phase(&self) -> Distribution {
        self.of(|it| it.phase.to_degrees())
    }

    /// The gain margin, dB.
    #[must_use]
    pub fn gain(&self) -> Distribution {
        self.of(|it| 20.0 * libm::log10(it.gain))
    }

    /// The sensitivity peak.
    #[must_use]
    pub fn sensitivity(&self) -> Distribution {
        self.of(|it| it.sensitivity)
    }

    /// The gain crossover, rad/s; 0 if there is none.
    #[must_use]
    pub fn crossover(&self) -> Distribution {
        self.of(|it| it.crossover.unwrap_or(0.0))
    }

    fn of(&self, value: impl Fn(&Margins) -> f64) -> Distribution {
        Distribution::new(value(&self.model), self.draws.iter().map(&value))
    }

    /// The share of the random plants that are unstable with these gains; without random plants, 0 or 1 for the model itself.
    #[must_use]
    pub fn unstable(&self) -> f64 {
        let own = std::slice::from_ref(&self.model);
        let all = if self.draws.is_empty() {
            own
        } else {
            &self.draws[..]
        };
        all.iter().filter(|it| !it.is_stable).count() as f64 / all.len() as f64
    }

    /// Whether the model keeps the limits, and for each limit all but [`MISSED`] of the random plants.
    #[must_use]
    pub fn keeps(&self, limits: &Limits) -> bool {
        let [phase, gain, sensitivity] = [
            self.of(|it| it.phase),
            self.of(|it| it.gain),
            self.sensitivity(),
        ];
        limits.are_kept(&self.model)
            && phase.quantile(MISSED) >= limits.phase
            && gain.quantile(MISSED) >= limits.gain
            && sensitivity.quantile(1.0 - MISSED) <= limits.sensitivity
    }
}

/// A curve of the model and the band that contains 90 % of the random plants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    /// s
    pub times: Vec<f64>,
    /// The value for the model itself.
    pub model: Vec<f64>,
    /// The 5 % and 95 % quantiles of the random plants; without random plants the model's own values.
    pub range: Vec<(f64, f64)>,
}

impl Band {
    /// Computes the band from curves over the same times, s, the model's own curve first; if there are many instants, some are left out.
    #[must_use]
    pub fn of(times: &[f64], lines: &[&[f64]]) -> Self {
        let every = times.len().div_ceil(INSTANTS).max(1);
        let mut band = Self::default();
        let Some((own, drawn)) = lines.split_first() else {
            return band;
        };
        for (k, time) in times.iter().enumerate().step_by(every) {
            let spread = Distribution::new(own[k], drawn.iter().map(|line| line[k]));
            band.times.push(*time);
            band.model.push(spread.model);
            band.range
                .push((spread.quantile(MISSED), spread.quantile(1.0 - MISSED)));
        }
        band
    }
}

/// Steps of setpoint and load.
#[derive(Clone, Debug)]
pub struct Steps {
    /// The step of the setpoint, output unit.
    pub step: f64,
    /// Output after the setpoint step.
    pub output: Band,
    /// Input after the setpoint step.
    pub input: Band,
    /// Output after a unit step of the load at the input.
    pub load: Band,
    /// Overshoot, % of the setpoint step.
    pub overshoot: Distribution,
    /// Settling time to within 2 %, s; infinite if the output does not settle in the time shown.
    pub settling: Distribution,
    /// The largest change of the input from its initial value, input unit.
    pub peak_input: Distribution,
    /// Total travel of the input, input unit.
    pub travel: Distribution,
    /// Share of the time with the input at a limit, %.
    pub at_limit: Distribution,
    /// Integrated absolute error after a unit step of the load, output unit times s.
    pub load_error: Distribution,
}

impl Steps {
    pub(crate) fn new(
        controller: &Controller,
        margins: &Margins,
        seen: &PlantResponse,
        draws: &[PlantResponse],
        options: &TuneOptions,
    ) -> Self {
        let tick = seen.plant.tick;
        let crossover = margins.crossover.unwrap_or(0.1 * seen.plant.nyquist());
        let ti = Some(controller.ti())
            .filter(|ti| ti.is_finite())
            .unwrap_or(0.0);
        let duration = 15.0 / crossover + 4.0 * ti + 3.0 * seen.plant.delay as f64 * tick;
        let ticks = (duration / tick).ceil().clamp(40.0, MOST_TICKS) as usize;
        let step = options.step;
        let setpoint = Trial {
            setpoint: step,
            load: 0.0,
            limit: options.input_limit,
        };
        let load = Trial {
            setpoint: 0.0,
            load: 1.0,
            limit: None,
        };
        let all: Vec<&PlantResponse> = std::iter::once(seen).chain(draws).collect();
        let moved = |trial: &Trial| {
            on_all_cores(&all, |it| Motion::new(&it.plant, controller, trial, ticks))
        };
        let (after_step, after_load) = (moved(&setpoint), moved(&load));
        let spread = |of: &dyn Fn(&Motion) -> f64, motions: &[Motion]| {
            Distribution::new(of(&motions[0]), motions[1..].iter().map(of))
        };
        let times: Vec<f64> = (0..ticks).map(|k| k as f64 * tick).collect();
        let band = |motions: &[Motion], of: fn(&Motion) -> &[f64]| {
            Band::of(&times, &motions.iter().map(of).collect::<Vec<_>>())
        };
        let metrics = |motion: &Motion| StepMetrics::of(&times, &motion.output, 0.0, step).ok();
        Self {
            step,
            output: band(&after_step, |it| &it.output),
            input: band(&after_step, |it| &it.input),
            load: band(&after_load, |it| &it.output),
            overshoot: spread(
                &|it| metrics(it).map_or(f64::INFINITY, |it| it.overshoot),
                &after_step,
            ),
            settling: spread(
                &|it| {
                    metrics(it)
                        .and_then(|it| it.settling_time)
                        .unwrap_or(f64::INFINITY)
                },
                &after_step,
            ),
            peak_input: spread(
                &|it| it.input.iter().fold(0.0, |most, u| most.max(u.abs())),
                &after_step,
            ),
            travel: spread(&Motion::travel, &after_step),
            at_limit: spread(&|it| 100.0 * it.at_limit as f64 / ticks as f64, &after_step),
            load_error: spread(&|it| it.absolute_error(0.0, tick), &after_load),
        }
    }
}
