//! Gains for an uncertain model: a method, its pace, and what the loop keeps over the plants that the model allows.

use planesman_identification::on_all_cores;
use planesman_linear::StepMetrics;
use planesman_model_file::ModelFile;
use planesman_text::{option, setting};

use crate::causes::{Cause, causes};
use crate::closed_loop::{Limits, Margins, Seen};
use crate::controller::Controller;
use crate::dynamics::Dynamics;
use crate::error::{Result, TuneError};
use crate::model::{Sampling, UncertainModel};
use crate::plant::Plant;
use crate::reduction::{Order, Reduced, half_rule};
use crate::response::{Motion, Trial};
use crate::rules::{crossover, lambda, placement, simc};
use crate::search::{Bounds, Objective, best};

/// The share of the plants that may miss a limit.
pub const MISSED: f64 = 0.05;
/// The factor between two paces that are tried, and how many are.
const SLOWER: f64 = 1.15;
const PACES: i32 = 45;
/// Steps by which a search's limits are tightened, and halvings between the last two.
const TIGHTER: u32 = 12;
const HALVINGS: u32 = 6;
/// Ticks of a response at most.
const MOST_TICKS: f64 = 20_000.0;
/// The share by which the gain of a reduced model may differ from the model's.
const SAME_GAIN: f64 = 0.01;
/// Instants of a band at most.
const INSTANTS: usize = 400;

/// How gains are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Skogestad's rule.
    Simc,
    /// Lambda tuning.
    Lambda,
    /// Pole placement.
    Placement,
    /// The largest integral gain within the margins, or a crossover with a phase margin.
    Margins,
    /// The least error after a load within the margins.
    Optimise,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 5] = [
        Self::Simc,
        Self::Lambda,
        Self::Placement,
        Self::Margins,
        Self::Optimise,
    ];

    /// Its name on the command line and its help line.
    #[must_use]
    pub const fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Simc => (
                "simc",
                "Skogestad's rule on the model reduced by the half rule",
            ),
            Self::Lambda => (
                "lambda",
                "A closed loop of one time constant, lambda, on the reduced model",
            ),
            Self::Placement => (
                "placement",
                "Poles of a model of first order (PI) or second order (PID)",
            ),
            Self::Margins => (
                "margins",
                "The largest integral gain within the margins; with a crossover the phase margin there",
            ),
            Self::Optimise => (
                "optimise",
                "The least integrated absolute error after a step of the load, within the margins",
            ),
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.described().0
    }
}

/// The kind of controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Proportional and integral.
    Pi,
    /// With a filtered derivative.
    Pid,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::Pi, Self::Pid];

    /// Its name on the command line and its help line.
    #[must_use]
    pub const fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Pi => ("pi", "Proportional and integral"),
            Self::Pid => ("pid", "With a filtered derivative"),
        }
    }

    const fn order(self) -> Order {
        match self {
            Self::Pi => Order::First,
            Self::Pid => Order::Second,
        }
    }
}

/// The options of [`tune`]; each is the option of that name of `planesman tune`.
#[derive(Clone, Debug)]
pub struct TuneOptions {
    /// `None`: chosen by the model.
    pub method: Option<Method>,
    /// `None`: chosen by the model.
    pub controller: Option<Kind>,
    /// The controller's sample time, s; `None`: the model's.
    pub period: Option<f64>,
    /// From a sample to the command that answers it, s.
    pub computing_delay: f64,
    /// The least phase margin, degrees.
    pub phase_margin: f64,
    /// The least gain margin, dB.
    pub gain_margin: f64,
    /// The largest sensitivity peak.
    pub ms: f64,
    /// The gain crossover of `margins`, rad/s.
    pub crossover: Option<f64>,
    /// `tau_c`, `lambda` or `1/wn`, s; `None`: the least that keeps the limits.
    pub closed_loop_time: Option<f64>,
    /// Of placed poles.
    pub damping_ratio: f64,
    /// `Td / Ti` of a search at most; `None`: as [`Bounds::of`].
    pub td_per_ti: Option<f64>,
    /// `Td` over the filter's time constant of a search at most; `None` likewise.
    pub filter_ratio: Option<f64>,
    /// Plants that are drawn.
    pub draws: usize,
    /// Of the draws.
    pub seed: u32,
    /// The step of the setpoint that is simulated, output unit.
    pub step: f64,
    /// How far the input may go from where it stands, down and up, input unit.
    pub input_limit: Option<(f64, f64)>,
    /// A model whose verdict is against it, or that has no covariance, is taken for all that.
    pub anyway: bool,
}

impl Default for TuneOptions {
    fn default() -> Self {
        Self {
            method: None,
            controller: None,
            period: None,
            computing_delay: 0.0,
            phase_margin: 45.0,
            gain_margin: 6.0,
            ms: 1.6,
            crossover: None,
            closed_loop_time: None,
            damping_ratio: 0.8,
            td_per_ti: None,
            filter_ratio: None,
            draws: 500,
            seed: 1,
            step: 1.0,
            input_limit: None,
            anyway: false,
        }
    }
}

impl TuneOptions {
    /// The limits.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits {
            phase: self.phase_margin.to_radians(),
            gain: libm::pow(10_f64, self.gain_margin / 20.0),
            sensitivity: self.ms,
        }
    }

    fn bounds(&self, objective: Objective) -> Bounds {
        let own = Bounds::of(objective);
        Bounds {
            td_per_ti: self.td_per_ti.unwrap_or(own.td_per_ti),
            filter_ratio: self.filter_ratio.unwrap_or(own.filter_ratio),
        }
    }

    /// Options that do not go with the method.
    fn check(&self, method: Method) -> Result<()> {
        let paced = matches!(method, Method::Simc | Method::Lambda | Method::Placement);
        if self.closed_loop_time.is_some() && !paced {
            return Err(TuneError::Option {
                option: "closed-loop-time",
                methods: "simc, lambda and placement",
            });
        }
        let bound = [
            ("td-per-ti", self.td_per_ti),
            ("filter-ratio", self.filter_ratio),
        ];
        let bound = bound.into_iter().find(|it| it.1.is_some());
        let searches = matches!(method, Method::Margins | Method::Optimise);
        if let (Some((option, _)), false) = (bound, searches && self.crossover.is_none()) {
            return Err(TuneError::Option {
                option,
                methods: "margins (without a crossover) and optimise",
            });
        }
        if self.crossover.is_some() && method != Method::Margins {
            return Err(TuneError::Option {
                option: "crossover",
                methods: "margins",
            });
        }
        Ok(())
    }
}

/// A number over the plants: that of the model itself, and of the drawn ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Of the model itself.
    pub model: f64,
    /// Of the drawn plants, in order of size; infinite ones at the ends.
    pub sorted: Vec<f64>,
}

impl Spread {
    /// Of values.
    #[must_use]
    pub fn new(model: f64, values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Self { model, sorted }
    }

    /// The value below which a share of the plants lies, straight between two of them; the model's own where none were drawn.
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

/// The loop over the plants that the model allows.
#[derive(Clone, Debug)]
pub struct Robustness {
    /// Of the model itself.
    pub model: Margins,
    /// Of the drawn plants.
    pub draws: Vec<Margins>,
}

impl Robustness {
    fn new(controller: &Controller, model: &Seen, draws: &[Seen]) -> Self {
        let on_grid = model.on_grid(controller);
        Self {
            model: model.margins_with(controller, &on_grid),
            draws: on_all_cores(draws, |it| it.margins_with(controller, &on_grid)),
        }
    }

    /// The phase margin, degrees.
    #[must_use]
    pub fn phase(&self) -> Spread {
        self.of(|it| it.phase.to_degrees())
    }

    /// The gain margin, dB.
    #[must_use]
    pub fn gain(&self) -> Spread {
        self.of(|it| 20.0 * libm::log10(it.gain))
    }

    /// The sensitivity peak.
    #[must_use]
    pub fn sensitivity(&self) -> Spread {
        self.of(|it| it.sensitivity)
    }

    /// The gain crossover, rad/s; 0 without one.
    #[must_use]
    pub fn crossover(&self) -> Spread {
        self.of(|it| it.crossover.unwrap_or(0.0))
    }

    fn of(&self, value: impl Fn(&Margins) -> f64) -> Spread {
        Spread::new(value(&self.model), self.draws.iter().map(&value))
    }

    /// The share of the drawn plants that are unstable with these gains; of none drawn that of the model, 0 or 1.
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

    /// Whether the model, and all but [`MISSED`] of the drawn plants in each of the limits, keep them.
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

/// A line of the model and the band that holds 90 % of the drawn plants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    /// s
    pub times: Vec<f64>,
    /// Of the model itself.
    pub model: Vec<f64>,
    /// 5 % and 95 % of the drawn plants; of none the model's own.
    pub range: Vec<(f64, f64)>,
}

/// Steps of setpoint and load.
#[derive(Clone, Debug)]
pub struct Steps {
    /// The step of the setpoint, output unit.
    pub step: f64,
    /// Output after it.
    pub output: Band,
    /// Input after it.
    pub input: Band,
    /// Output after a unit step of the load at the input.
    pub load: Band,
    /// %, of the step of the setpoint.
    pub overshoot: Spread,
    /// To within 2 %, s; infinite where it does not settle in the time shown.
    pub settling: Spread,
    /// The farthest that the input goes from where it stood, input unit.
    pub peak_input: Spread,
    /// How far the input goes altogether, input unit.
    pub travel: Spread,
    /// Share of the time that the input is at a limit, %.
    pub at_limit: Spread,
    /// Integrated absolute error after a unit step of the load, output unit times s.
    pub load_error: Spread,
}

/// The result: gains, and what they do.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// The model.
    pub model: UncertainModel,
    /// When the controller acts.
    pub sampling: Sampling,
    /// How the gains were found.
    pub method: Method,
    /// Why so, where it was not asked for.
    pub why: Option<String>,
    /// The model that the rule was applied to.
    pub reduced: Option<Reduced>,
    /// `tau_c`, `lambda` or `1/wn`: its name and value, s.
    pub pace: Option<(&'static str, f64)>,
    /// The gains.
    pub controller: Controller,
    /// What was to be kept.
    pub limits: Limits,
    /// Margins.
    pub robustness: Robustness,
    /// Responses.
    pub steps: Steps,
    /// Which properties of the model make the phase margin uncertain, the most important first.
    pub causes: Vec<Cause>,
    /// What else is to be said.
    pub notes: Vec<String>,
    /// The plants that were drawn, and the model's own.
    pub seen: Seen,
    /// The same of the drawn ones.
    pub draws: Vec<Seen>,
}

impl Tuning {
    /// Whether all limits are kept.
    #[must_use]
    pub fn keeps_limits(&self) -> bool {
        self.robustness.keeps(&self.limits)
    }
}

/// What the methods work on.
struct Task<'a> {
    options: &'a TuneOptions,
    /// With the computing delay; zeros shorter than a sample are dead time.
    dynamics: Result<Dynamics>,
    sampling: Sampling,
    limits: Limits,
    seen: &'a Seen,
    draws: &'a [Seen],
}

/// What a method has found.
struct Found {
    controller: Controller,
    reduced: Option<Reduced>,
    pace: Option<(&'static str, f64)>,
}

/// Gains for a model.
///
/// # Errors
/// A model that is not to be relied on, gains that are not found; [`TuneError`] has them all.
pub fn tune(file: &ModelFile, options: &TuneOptions) -> Result<Tuning> {
    let model = UncertainModel::new(file, options.anyway)?;
    let sampling = Sampling {
        tick: options.period.unwrap_or(model.sample_time),
        computing_delay: options.computing_delay,
    };
    let seen = Seen::new(model.plant(model.centre(), &sampling)?);
    model.check_sign(&sampling)?;
    let mut notes = model.notes.clone();
    let drawn = if model.is_exact() {
        Vec::new()
    } else {
        model.draws(options.draws, options.seed)
    };
    let seen_at = |it| model.plant(it, &sampling).ok();
    let mut plants: Vec<_> = drawn.iter().filter_map(seen_at).collect();
    if plants.len() < drawn.len() {
        notes.push(format!(
            "{} of {} drawn models have no continuous counterpart and are left out",
            drawn.len() - plants.len(),
            drawn.len()
        ));
    }
    // What decays in the record decays in each plant: a mode that the data hardly shows has draws beyond the unit circle.
    if seen.plant.decays() {
        let all = plants.len();
        plants.retain(Plant::decays);
        if plants.len() < all {
            notes.push(format!(
                "{} of {all} drawn models are unstable, which the model is not, and are left out: the data hardly determines some of its modes; fit it with \
                 a lower {}, or {}",
                all - plants.len(),
                option("order"),
                setting("method", "process")
            ));
        }
    }
    let plants: Vec<Seen> = plants.into_iter().map(Seen::new).collect();
    let task = Task {
        options,
        dynamics: model.dynamics().map(|it| {
            let sample = sampling.tick.max(model.sample_time);
            let short = it.with_short_zeros_as_delay(sample);
            Dynamics {
                delay: short.delay + sampling.computing_delay,
                ..short
            }
        }),
        sampling,
        limits: options.limits(),
        seen: &seen,
        draws: &plants,
    };
    let (method, kind, why) = task.choice();
    options.check(method)?;
    task.check_dead_time()?;
    let found = match task.found(method, kind) {
        Err(TuneError::OutOfReach {
            method,
            limits,
            best,
            ..
        }) => {
            let advice = task.advice(&model, kind);
            return Err(TuneError::OutOfReach {
                method,
                limits,
                best,
                advice,
            });
        }
        found => found?,
    };
    let robustness = Robustness::new(&found.controller, &seen, &plants);
    let steps = Steps::new(
        &found.controller,
        &robustness.model,
        &seen,
        &plants,
        options,
    );
    let causes = causes(&model, &sampling, &found.controller, &robustness.model)?;
    Ok(Tuning {
        limits: task.limits,
        sampling,
        method,
        why,
        reduced: found.reduced,
        pace: found.pace,
        controller: found.controller,
        robustness,
        steps,
        causes,
        notes,
        model,
        seen,
        draws: plants,
    })
}

impl Task<'_> {
    /// The model by the half rule; it has the integrators and the gain of the sampled plant.
    fn reduced(&self, kind: Kind) -> std::result::Result<Reduced, String> {
        let dynamics = self.dynamics.as_ref().map_err(ToString::to_string)?;
        let reduced = half_rule(dynamics, kind.order(), self.sampling.tick)?;
        let (gain, integrators) = (self.seen.plant.gain(), self.seen.plant.integrators());
        let is_same = (reduced.gain / gain - 1.0).abs() < SAME_GAIN;
        match is_same && reduced.integrators() == integrators {
            true => Ok(reduced),
            false => Err(format!(
                "a gain of {gain:.4}, and its reduction one of {:.4}",
                reduced.gain
            )),
        }
    }

    /// The method and the kind of controller, and why.
    fn choice(&self) -> (Method, Kind, Option<String>) {
        let second = self.reduced(Kind::Pid);
        let lead = second.as_ref().is_ok_and(|it| it.second() > it.delay);
        let by_model = match (&second, lead) {
            (Ok(it), true) if it.integrators() < 2 => (
                Kind::Pid,
                format!(
                    "the second time constant, {:.4} s, is longer than the dead time of {:.4} s: a derivative pays",
                    it.second(),
                    it.delay
                ),
            ),
            (Ok(it), true) => (
                Kind::Pid,
                format!("{} integrators need a derivative", it.integrators()),
            ),
            (Ok(it), false) => (
                Kind::Pi,
                match it.second() > 0.0 {
                    true => format!(
                        "the second time constant, {:.4} s, is shorter than the dead time of {:.4} s: a derivative gains little",
                        it.second(),
                        it.delay
                    ),
                    false => {
                        "the model is of first order with dead time: a derivative gains little"
                            .to_owned()
                    }
                },
            ),
            (Err(unfit), _) => (Kind::Pid, format!("the model has {unfit}")),
        };
        // Poles are placed of a model of the controller's own order.
        let order = self.dynamics.as_ref().map_or(0, Dynamics::order);
        let by_model = match (self.options.method, order) {
            (Some(Method::Placement), 1) => (Kind::Pi, String::new()),
            (Some(Method::Placement), 2) => (Kind::Pid, String::new()),
            _ => by_model,
        };
        let kind = self.options.controller.unwrap_or(by_model.0);
        if let Some(method) = self.options.method {
            return (method, kind, None);
        }
        if self.options.crossover.is_some() {
            return (
                Method::Margins,
                kind,
                Some("a crossover is asked for".to_owned()),
            );
        }
        match self.reduced(kind) {
            Ok(_) => (Method::Simc, kind, Some(by_model.1)),
            Err(unfit) => (
                Method::Optimise,
                kind,
                Some(format!(
                    "the model has {unfit}, which the rules do not know"
                )),
            ),
        }
    }

    /// An unstable pole p behind a dead time keeps the sensitivity above `e^(p theta)` with any controller (Astrom and Murray,
    /// *Feedback Systems*, 2nd ed., sec. 14.4).
    fn check_dead_time(&self) -> Result<()> {
        let Ok(dynamics) = &self.dynamics else {
            return Ok(());
        };
        let Some(pole) = dynamics.unstable() else {
            return Ok(());
        };
        let delay = dynamics.delay + 0.5 * self.sampling.tick;
        let least = libm::exp(pole * delay);
        match least < self.limits.sensitivity {
            true => Ok(()),
            false => Err(TuneError::TooLate {
                time_constant: 1.0 / pole,
                delay,
                least,
                limit: self.limits.sensitivity,
                allowed: 1.5 * least,
            }),
        }
    }

    fn found(&self, method: Method, kind: Kind) -> Result<Found> {
        let options = self.options;
        match method {
            Method::Simc => {
                let reduced = self.fit_for(
                    method,
                    kind,
                    "a model that the half rule reduces to lags, integrators and dead time",
                )?;
                let at = |tau_c: f64| Some(simc(&reduced, tau_c));
                self.paced(method, "tau_c", reduced.delay, at, Some(reduced.clone()))
            }
            Method::Lambda => {
                let reduced = self.fit_for(
                    method,
                    kind,
                    "a model that the half rule reduces to lags, one integrator and dead time",
                )?;
                if reduced.integrators() > 1 {
                    return Err(TuneError::NotFor {
                        method: method.name(),
                        needs: "one integrator at most",
                        found: format!("{}", reduced.integrators()),
                    });
                }
                let first = reduced.first();
                let begin = if first.is_finite() {
                    first.max(reduced.delay)
                } else {
                    3.0 * reduced.delay
                };
                self.paced(
                    method,
                    "lambda",
                    begin,
                    |time| lambda(&reduced, time),
                    Some(reduced.clone()),
                )
            }
            Method::Placement => {
                let (gain, den, delay, reduced) = self.low_order(kind)?;
                let at = |time: f64| {
                    let found = placement(gain, &den, 1.0 / time, options.damping_ratio)?;
                    // Poles slower than the plant's own would take a gain of the other sign.
                    (found.kp * found.ki > 0.0 && found.kd * found.ki >= 0.0).then_some(found)
                };
                self.paced(method, "1/wn", delay, at, reduced)
            }
            Method::Margins => match options.crossover {
                Some(frequency) => self.at_crossover(kind, frequency),
                None => self.searched(method, kind, Objective::IntegralGain),
            },
            Method::Optimise => self.searched(method, kind, Objective::AbsoluteError),
        }
    }

    fn fit_for(&self, method: Method, kind: Kind, needs: &'static str) -> Result<Reduced> {
        self.reduced(kind).map_err(|found| TuneError::NotFor {
            method: method.name(),
            needs,
            found,
        })
    }

    /// Gain and denominator of first or second order, its dead time, and the reduction where it is one.
    fn low_order(&self, kind: Kind) -> Result<(f64, Vec<f64>, f64, Option<Reduced>)> {
        let most = match kind {
            Kind::Pi => 1,
            Kind::Pid => 2,
        };
        if let Ok(dynamics) = &self.dynamics
            && dynamics.order() == most
            && dynamics.zeros.is_empty()
        {
            let delay = dynamics.delay + 0.5 * self.sampling.tick;
            return Ok((dynamics.gain, dynamics.denominator()?, delay, None));
        }
        let reduced = self.fit_for(Method::Placement, kind, "a model of first order (pi) or second order (pid), or one that the half rule reduces to such")?;
        let factor = |tau: f64| {
            if tau.is_infinite() {
                vec![1.0, 0.0]
            } else {
                vec![tau, 1.0]
            }
        };
        let constants = reduced.time_constants.iter().map(|tau| factor(*tau));
        let den = constants.fold(vec![1.0], |all, it| {
            planesman_linear::polynomial::product(&all, &it)
        });
        Ok((reduced.gain, den, reduced.delay, Some(reduced)))
    }

    /// The fastest of the paces from `begin` on that keeps the limits; the one asked for, where one is.
    fn paced(
        &self,
        method: Method,
        name: &'static str,
        begin: f64,
        at: impl Fn(f64) -> Option<Controller>,
        reduced: Option<Reduced>,
    ) -> Result<Found> {
        let found = |controller, pace| Found {
            controller,
            reduced: reduced.clone(),
            pace: Some((name, pace)),
        };
        if let Some(asked) = self.options.closed_loop_time {
            let controller = at(asked).ok_or_else(|| self.out_of_reach(method, None))?;
            return Ok(found(controller, asked));
        }
        let mut best: Option<Robustness> = None;
        let mut before = None;
        for step in 0..=PACES {
            let pace = begin * SLOWER.powi(step);
            let Some(controller) = at(pace) else {
                continue;
            };
            let judged = Robustness::new(&controller, self.seen, self.draws);
            if !judged.keeps(&self.limits) {
                let worst = |it: &Robustness| it.sensitivity().quantile(1.0 - MISSED);
                if best
                    .as_ref()
                    .is_none_or(|best| worst(&judged) < worst(best))
                {
                    best = Some(judged);
                }
                before = Some(pace);
                continue;
            }
            let (mut kept, mut missed) = (pace, before);
            for _ in 0..HALVINGS {
                let Some(fast) = missed else { break };
                let middle = (fast * kept).sqrt();
                let keeps = at(middle).is_some_and(|it| {
                    Robustness::new(&it, self.seen, self.draws).keeps(&self.limits)
                });
                if keeps {
                    kept = middle;
                } else {
                    missed = Some(middle);
                }
            }
            let controller = at(kept).unwrap_or(controller);
            return Ok(found(controller, kept));
        }
        Err(self.out_of_reach(method, best.as_ref()))
    }

    fn at_crossover(&self, kind: Kind, frequency: f64) -> Result<Found> {
        let nyquist = self.seen.plant.nyquist();
        let refused = |reason: String, direction| TuneError::Crossover {
            crossover: frequency,
            reason,
            direction,
        };
        if frequency >= nyquist {
            return Err(refused(
                format!("it is not below the Nyquist frequency, {nyquist:.4} rad/s"),
                "lower",
            ));
        }
        let sign = self.seen.plant.sign();
        let found = crossover(
            self.seen,
            kind == Kind::Pid,
            sign,
            frequency,
            self.limits.phase,
        );
        let controller = found.map_err(|missing| match missing > 0.0 {
            true => refused(
                format!(
                    "the controller would have to lead by {missing:.1} degrees more than it can"
                ),
                "lower",
            ),
            false => refused(
                format!(
                    "the controller would have to lag by {:.1} degrees more than it can",
                    -missing
                ),
                "higher",
            ),
        })?;
        Ok(Found {
            controller,
            reduced: None,
            pace: None,
        })
    }

    /// The best on the model itself within limits that are tightened until the drawn plants keep those asked for.
    fn searched(&self, method: Method, kind: Kind, objective: Objective) -> Result<Found> {
        let bounds = self.options.bounds(objective);
        let at = |share: f64| {
            let limits = self.limits.tightened(share);
            let controller = best(self.seen, kind == Kind::Pid, &limits, objective, bounds)?;
            Some((
                Robustness::new(&controller, self.seen, self.draws),
                controller,
            ))
        };
        let mut nearest: Option<Robustness> = None;
        let mut before = None;
        for step in 0..TIGHTER {
            let share = f64::from(step) / f64::from(TIGHTER);
            let Some((judged, controller)) = at(share) else {
                break;
            };
            if !judged.keeps(&self.limits) {
                let worst = |it: &Robustness| it.sensitivity().quantile(1.0 - MISSED);
                if nearest
                    .as_ref()
                    .is_none_or(|nearest| worst(&judged) < worst(nearest))
                {
                    nearest = Some(judged);
                }
                before = Some(share);
                continue;
            }
            let (mut kept, mut missed) = ((share, controller), before);
            for _ in 0..HALVINGS / 2 {
                let Some(loose) = missed else { break };
                let middle = 0.5 * (loose + kept.0);
                match at(middle).filter(|it| it.0.keeps(&self.limits)) {
                    Some((_, controller)) => kept = (middle, controller),
                    None => missed = Some(middle),
                }
            }
            return Ok(Found {
                controller: kept.1,
                reduced: None,
                pace: None,
            });
        }
        Err(self.out_of_reach(method, nearest.as_ref()))
    }

    fn out_of_reach(&self, method: Method, best: Option<&Robustness>) -> TuneError {
        let limits = format!(
            "a phase margin of {:.0} deg, a gain margin of {:.1} dB and a sensitivity peak of {:.2}",
            self.limits.phase.to_degrees(),
            20.0 * libm::log10(self.limits.gain),
            self.limits.sensitivity
        );
        let best = match best {
            Some(best) if best.unstable() < MISSED => format!(
                "the best have {:.1} deg, {:.1} dB and {:.2} there",
                best.phase().quantile(MISSED),
                best.gain().quantile(MISSED),
                best.sensitivity().quantile(1.0 - MISSED)
            ),
            Some(best) => format!(
                "with the best {:.0} % of these are unstable",
                100.0 * best.unstable()
            ),
            None => "the model itself keeps them with none".to_owned(),
        };
        TuneError::OutOfReach {
            method: method.name(),
            limits,
            best,
            advice: String::new(),
        }
    }

    /// What to do where no gains keep the limits: whether the model or its uncertainty is in the way.
    fn advice(&self, model: &UncertainModel, kind: Kind) -> String {
        let limits = self.limits;
        let looser = setting("ms", format!("{:.1}", 1.25 * limits.sensitivity));
        let alone = best(
            self.seen,
            kind == Kind::Pid,
            &limits,
            Objective::IntegralGain,
            self.options.bounds(Objective::IntegralGain),
        );
        let Some(controller) = alone else {
            let derivative = match kind {
                Kind::Pi => format!("{}, or ", setting("controller", "pid")),
                _ => String::new(),
            };
            return format!(
                "The model itself keeps them with no gains of this kind: {derivative}looser limits, as {looser}"
            );
        };
        let own = self.seen.margins(&controller);
        let causes = causes(model, &self.sampling, &controller, &own).unwrap_or_default();
        match causes.first() {
            Some(cause) => format!(
                "The model is too uncertain, most in {}: {}. Or looser limits, as {looser}",
                cause.name, cause.experiment
            ),
            None => format!(
                "Try {}, or looser limits, as {looser}",
                setting("method", "optimise")
            ),
        }
    }
}

impl Steps {
    fn new(
        controller: &Controller,
        margins: &Margins,
        seen: &Seen,
        draws: &[Seen],
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
        let all: Vec<&Seen> = std::iter::once(seen).chain(draws).collect();
        let moved = |trial: &Trial| {
            on_all_cores(&all, |it| Motion::new(&it.plant, controller, trial, ticks))
        };
        let (after_step, after_load) = (moved(&setpoint), moved(&load));
        let spread = |of: &dyn Fn(&Motion) -> f64, motions: &[Motion]| {
            Spread::new(of(&motions[0]), motions[1..].iter().map(of))
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

impl Band {
    /// Of lines over the same times, s, the model's own first; every so many instants where these are many.
    #[must_use]
    pub fn of(times: &[f64], lines: &[&[f64]]) -> Self {
        let every = times.len().div_ceil(INSTANTS).max(1);
        let mut band = Self::default();
        let Some((own, drawn)) = lines.split_first() else {
            return band;
        };
        for (k, time) in times.iter().enumerate().step_by(every) {
            let spread = Spread::new(own[k], drawn.iter().map(|line| line[k]));
            band.times.push(*time);
            band.model.push(spread.model);
            band.range
                .push((spread.quantile(MISSED), spread.quantile(1.0 - MISSED)));
        }
        band
    }
}
