//! The options of a tuning.

use crate::closed_loop::Limits;
use crate::error::{Result, TuneError};
use crate::reduction::Order;
use crate::search::{Bounds, Objective};

planesman_text::choices! {
    /// The method for the gains.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Method {
        Simc = "simc": "Skogestad's rule for a model reduced by the half rule",
        Lambda = "lambda": "A closed loop with one time constant, lambda, for the reduced model",
        Placement = "placement": "Poles of the closed loop, for a model of first order (PI) or second order (PID)",
        Margins = "margins": "The largest integral gain that keeps the margins; with a crossover the phase margin at that frequency",
        Optimise = "optimise": "The smallest integrated absolute error after a step of the load, while the margins are kept",
    }
}

planesman_text::choices! {
    /// The kind of controller.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Kind {
        Pi = "pi": "Proportional and integral",
        Pid = "pid": "With a filtered derivative",
    }
}

impl Kind {
    pub(crate) const fn order(self) -> Order {
        match self {
            Self::Pi => Order::First,
            Self::Pid => Order::Second,
        }
    }
}

/// The options of [`tune`](crate::tune); each is the option of the same name of `planesman tune`.
#[derive(Clone, Debug)]
pub struct TuneOptions {
    /// The method; with `None` the model determines it.
    pub method: Option<Method>,
    /// The method; with `None` the model determines it.
    pub controller: Option<Kind>,
    /// The controller's sample time, s; with `None` the model's sample time.
    pub period: Option<f64>,
    /// The time from a sample to the resulting command, s.
    pub computing_delay: f64,
    /// The smallest phase margin, degrees.
    pub phase_margin: f64,
    /// The smallest gain margin, dB.
    pub gain_margin: f64,
    /// The largest sensitivity peak.
    pub ms: f64,
    /// The gain crossover for `margins`, rad/s.
    pub crossover: Option<f64>,
    /// `tau_c`, `lambda` or `1/wn`, s; with `None` the shortest time within the limits.
    pub closed_loop_time: Option<f64>,
    /// The damping ratio of placed poles.
    pub damping_ratio: f64,
    /// The maximum of `Td / Ti` in a search; `None`: as in [`Bounds::of`].
    pub td_per_ti: Option<f64>,
    /// The maximum of `Td` over the filter's time constant in a search; `None`: as in [`Bounds::of`].
    pub filter_ratio: Option<f64>,
    /// The number of random plants.
    pub draws: usize,
    /// The seed of the random plants.
    pub seed: u32,
    /// The simulated step of the setpoint, output unit.
    pub step: f64,
    /// The allowed change of the input from its initial value, down and up, input unit.
    pub input_limit: Option<(f64, f64)>,
    /// Whether to use a model despite its verdict or a missing covariance.
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

    pub(crate) fn bounds(&self, objective: Objective) -> Bounds {
        let own = Bounds::of(objective);
        Bounds {
            td_per_ti: self.td_per_ti.unwrap_or(own.td_per_ti),
            filter_ratio: self.filter_ratio.unwrap_or(own.filter_ratio),
        }
    }

    /// Refuses options that do not apply to the method.
    pub(crate) fn check(&self, method: Method) -> Result<()> {
        let paced = matches!(method, Method::Simc | Method::Lambda | Method::Placement);
        if self.closed_loop_time.is_some() && !paced {
            return Err(TuneError::Option {
                option: "closed-loop-time",
                methods: "simc, lambda or placement",
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
                methods: "margins (without a crossover) or optimise",
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
