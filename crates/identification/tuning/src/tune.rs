//! Gains for an uncertain model: a method, its speed, and the margins over random plants within the uncertainty.

use planesman_model_file::ModelFile;
use planesman_text::{option, setting};

use crate::causes::{Cause, causes};
use crate::closed_loop::{Limits, PlantResponse};
use crate::controller::Controller;
use crate::dynamics::Dynamics;
use crate::error::{Result, TuneError};
use crate::model::{Sampling, UncertainModel};
use crate::options::{Kind, Method, TuneOptions};
use crate::plant::Plant;
use crate::reduction::{Reduced, half_rule};
use crate::robustness::{MISSED, Robustness, Steps};
use crate::rules::{crossover, lambda, placement, simc};
use crate::search::{Objective, best};

/// The factor between two closed-loop times that are tried, and their number.
const SLOWER: f64 = 1.15;
const PACES: i32 = 45;
/// Number of steps by which a search's limits are tightened, and of bisections between the last two.
const TIGHTER: u32 = 12;
const HALVINGS: u32 = 6;
/// The share by which the gain of a reduced model may differ from the model's.
const SAME_GAIN: f64 = 0.01;

/// The result: gains and their performance.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// The model.
    pub model: UncertainModel,
    /// The sampling of the controller.
    pub sampling: Sampling,
    /// The method used.
    pub method: Method,
    /// The reason for the choice, if it was not requested.
    pub why: Option<String>,
    /// The model to which the rule was applied.
    pub reduced: Option<Reduced>,
    /// `tau_c`, `lambda` or `1/wn`: its name and value, s.
    pub pace: Option<(&'static str, f64)>,
    /// The gains.
    pub controller: Controller,
    /// The required margins.
    pub limits: Limits,
    /// Margins.
    pub robustness: Robustness,
    /// Responses.
    pub steps: Steps,
    /// The properties of the model that make the phase margin uncertain, most important first.
    pub causes: Vec<Cause>,
    /// Further notes.
    pub notes: Vec<String>,
    /// The model's own plant.
    pub seen: PlantResponse,
    /// The random plants.
    pub draws: Vec<PlantResponse>,
}

impl Tuning {
    /// Whether all limits are kept.
    #[must_use]
    pub fn keeps_limits(&self) -> bool {
        self.robustness.keeps(&self.limits)
    }
}

/// The factors by which limits are loosened, to find limits that some gains keep.
const LOOSER: [f64; 3] = [1.25, 1.6, 2.0];

/// The inputs of the methods.
struct Task<'a> {
    options: &'a TuneOptions,
    /// The model including the computing delay; zeros shorter than a sample are converted to dead time.
    dynamics: Result<Dynamics>,
    sampling: Sampling,
    limits: Limits,
    seen: &'a PlantResponse,
    draws: &'a [PlantResponse],
}

/// The result of a method.
struct ControllerDesign {
    controller: Controller,
    reduced: Option<Reduced>,
    pace: Option<(&'static str, f64)>,
}

/// Gains for a model.
///
/// # Errors
/// If the model is not reliable, or gains are not found; see [`TuneError`].
pub fn tune(file: &ModelFile, options: &TuneOptions) -> Result<Tuning> {
    let model = UncertainModel::new(file, options.anyway)?;
    let sampling = Sampling {
        tick: options.period.unwrap_or(model.sample_time),
        computing_delay: options.computing_delay,
    };
    let seen = PlantResponse::new(model.plant(model.centre(), &sampling)?);
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
            "{} of {} random models have no equivalent in continuous time and are left out",
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
                "{} of {all} random models are unstable although the model is stable, and are left out: the data hardly determines some of the model's modes; fit a model with a lower {}, or {}",
                all - plants.len(),
                option("order"),
                setting("method", "process")
            ));
        }
    }
    let plants: Vec<PlantResponse> = plants.into_iter().map(PlantResponse::new).collect();
    let mut task = Task {
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
            method: name,
            limits,
            best,
            ..
        }) => {
            let advice = task.advice(&model, method, kind);
            return Err(TuneError::OutOfReach {
                method: name,
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
    /// Reduces the model by the half rule, with the integrators and the gain of the sampled plant.
    fn reduced(&self, kind: Kind) -> std::result::Result<Reduced, String> {
        let dynamics = self.dynamics.as_ref().map_err(ToString::to_string)?;
        let reduced = half_rule(dynamics, kind.order(), self.sampling.tick)?;
        let (gain, integrators) = (self.seen.plant.gain(), self.seen.plant.integrators());
        let is_same = (reduced.gain / gain - 1.0).abs() < SAME_GAIN;
        match is_same && reduced.integrators() == integrators {
            true => Ok(reduced),
            false => Err(format!(
                "a steady-state gain of {gain:.4}, while its reduction has {:.4}",
                reduced.gain
            )),
        }
    }

    /// The method and the kind of controller, and the reason.
    fn choice(&self) -> (Method, Kind, Option<String>) {
        let second = self.reduced(Kind::Pid);
        let lead = second.as_ref().is_ok_and(|it| it.second() > it.delay);
        let by_model = match (&second, lead) {
            (Ok(it), true) if it.integrators() < 2 => (
                Kind::Pid,
                format!(
                    "the second time constant, {:.4} s, is longer than the dead time of {:.4} s: a derivative term helps",
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
                        "the second time constant, {:.4} s, is shorter than the dead time of {:.4} s: a derivative term improves little",
                        it.second(),
                        it.delay
                    ),
                    false => {
                        "the model is of first order with dead time: a derivative term improves little"
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
                Some("a crossover is given".to_owned()),
            );
        }
        match self.reduced(kind) {
            Ok(_) => (Method::Simc, kind, Some(by_model.1)),
            Err(unfit) => (
                Method::Optimise,
                kind,
                Some(format!(
                    "the model has {unfit}, which the rules do not cover"
                )),
            ),
        }
    }

    /// An unstable pole p with a dead time keeps the sensitivity above `e^(p theta)` for any controller (Astrom and Murray, *Feedback
    /// Systems*, 2nd ed., sec. 14.4).
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

    fn found(&self, method: Method, kind: Kind) -> Result<ControllerDesign> {
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
                        needs: "at most one integrator",
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

    /// Gain and denominator of first or second order, its dead time, and the reduction if one was made.
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
        let reduced = self.fit_for(Method::Placement, kind, "a model of first order (pi) or second order (pid), or a model that the half rule reduces to such a model")?;
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

    /// The fastest closed-loop time, from `begin` on, that keeps the limits; or the requested one.
    fn paced(
        &self,
        method: Method,
        name: &'static str,
        begin: f64,
        at: impl Fn(f64) -> Option<Controller>,
        reduced: Option<Reduced>,
    ) -> Result<ControllerDesign> {
        let found = |controller, pace| ControllerDesign {
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

    fn at_crossover(&self, kind: Kind, frequency: f64) -> Result<ControllerDesign> {
        let nyquist = self.seen.plant.nyquist();
        let refused = |reason: String, direction| TuneError::Crossover {
            crossover: frequency,
            reason,
            direction,
        };
        if frequency >= nyquist {
            return Err(refused(
                format!("the crossover is not below the Nyquist frequency, {nyquist:.4} rad/s"),
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
                    "the controller would need {missing:.1} degrees more phase lead than it can give"
                ),
                "lower",
            ),
            false => refused(
                format!(
                    "the controller would need {:.1} degrees more phase lag than it can give",
                    -missing
                ),
                "higher",
            ),
        })?;
        Ok(ControllerDesign {
            controller,
            reduced: None,
            pace: None,
        })
    }

    /// The best gains for the model itself, within limits that are tightened until the random plants keep the requested limits.
    fn searched(
        &self,
        method: Method,
        kind: Kind,
        objective: Objective,
    ) -> Result<ControllerDesign> {
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
            return Ok(ControllerDesign {
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
                "the best gains reach {:.1} deg, {:.1} dB and {:.2} in 95 % of the plants",
                best.phase().quantile(MISSED),
                best.gain().quantile(MISSED),
                best.sensitivity().quantile(1.0 - MISSED)
            ),
            Some(best) => format!(
                "even with the best gains {:.0} % of these plants are unstable",
                100.0 * best.unstable()
            ),
            None => "no gains keep these limits even for the model itself".to_owned(),
        };
        TuneError::OutOfReach {
            method: method.name(),
            limits,
            best,
            advice: String::new(),
        }
    }

    /// The next step if no gains keep the limits: it depends on whether the model or its uncertainty is the cause.
    fn advice(&mut self, model: &UncertainModel, method: Method, kind: Kind) -> String {
        let looser = self.looser(method, kind).map_or_else(
            || "looser limits than half of these".to_owned(),
            |it| format!("looser limits, for example {it}, with which there are gains"),
        );
        let alone = best(
            self.seen,
            kind == Kind::Pid,
            &self.limits,
            Objective::IntegralGain,
            self.options.bounds(Objective::IntegralGain),
        );
        let Some(controller) = alone else {
            let derivative = match kind {
                Kind::Pi => format!("{}, or ", setting("controller", "pid")),
                _ => String::new(),
            };
            return format!(
                "No gains of this kind keep them even for the model itself: {derivative}{looser}"
            );
        };
        let own = self.seen.margins(&controller);
        let causes = causes(model, &self.sampling, &controller, &own).unwrap_or_default();
        match causes.first() {
            Some(cause) => format!(
                "The model is too uncertain, most in {}: {}. Or use {looser}",
                cause.name, cause.experiment
            ),
            None => format!("Try {}, or {looser}", setting("method", "optimise")),
        }
    }

    /// Options with looser limits, for which this method finds gains.
    fn looser(&mut self, method: Method, kind: Kind) -> Option<String> {
        let asked = self.limits;
        let options = self.options;
        let found = LOOSER.iter().find_map(|factor| {
            let sensitivity = (10.0 * factor * asked.sensitivity).round() / 10.0;
            let phase = (options.phase_margin / factor).round();
            let gain = (10.0 * options.gain_margin / factor).round() / 10.0;
            self.limits = Limits {
                sensitivity,
                ..asked
            };
            let peak = setting("ms", format!("{sensitivity:.1}")).to_string();
            if self.found(method, kind).is_ok() {
                return Some(peak);
            }
            self.limits = Limits {
                sensitivity,
                phase: phase.to_radians(),
                gain: libm::pow(10_f64, gain / 20.0),
            };
            let phase = setting("phase_margin", phase);
            let gain = setting("gain_margin", format!("{gain:.1}"));
            (self.found(method, kind).is_ok()).then(|| format!("{peak} {phase} {gain}"))
        });
        self.limits = asked;
        found
    }
}
