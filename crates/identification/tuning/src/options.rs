//! What a tuning is asked for.

use crate::closed_loop::Limits;
use crate::error::{Result, TuneError};
use crate::reduction::Order;
use crate::search::{Bounds, Objective};

planesman_text::choices! {
    /// How gains are found.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Method {
        Simc = "simc": "Skogestad's rule on the model reduced by the half rule",
        Lambda = "lambda": "A closed loop of one time constant, lambda, on the reduced model",
        Placement = "placement": "Poles of a model of first order (PI) or second order (PID)",
        Margins = "margins": "The largest integral gain within the margins; with a crossover the phase margin there",
        Optimise = "optimise": "The least integrated absolute error after a step of the load, within the margins",
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

/// The options of [`tune`](crate::tune); each is the option of that name of `planesman tune`.
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

    pub(crate) fn bounds(&self, objective: Objective) -> Bounds {
        let own = Bounds::of(objective);
        Bounds {
            td_per_ti: self.td_per_ti.unwrap_or(own.td_per_ti),
            filter_ratio: self.filter_ratio.unwrap_or(own.filter_ratio),
        }
    }

    /// Options that do not go with the method.
    pub(crate) fn check(&self, method: Method) -> Result<()> {
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
