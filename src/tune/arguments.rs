//! Arguments of the controller, its limits and the simulated steps.

use clap::Args;
use planesman_tuning::{Kind, Method, TuneOptions};
use planesman_units::Dimension;

use crate::arguments::{choice, quantity, within};

/// The kind of controller, and the tuning method.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Controller")]
pub(super) struct ControllerArgs {
    /// Tuning method [default: simc for a model that reduces to lags, integrators and dead time, else optimise]
    #[arg(long, value_parser = choice(&Method::ALL, Method::described))]
    pub(super) method: Option<Method>,
    /// Kind of controller [default: pid if a second time constant is longer than the dead time, else pi]
    #[arg(long, value_parser = choice(&Kind::ALL, Kind::described))]
    pub(super) controller: Option<Kind>,
    /// Sample time of the controller (s, or with its unit: 50ms) [default: the sample time of the model]
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-6, 1e6))]
    pub(super) period: Option<f64>,
    /// Delay from a sample of the output to the command computed from that sample (s, or with its unit)
    #[arg(long, value_name = "TIME", default_value = "0", value_parser = quantity(Dimension::Time, 0.0, 1e6))]
    pub(super) computing_delay: f64,
    /// tau_c for simc, lambda for lambda, 1/wn for placement (s) [default: the smallest that keeps the limits]
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-6, 1e9))]
    pub(super) closed_loop_time: Option<f64>,
    /// For placement: damping ratio of the pair of poles
    #[arg(long, value_name = "ZETA", default_value_t = TuneOptions::default().damping_ratio, value_parser = within(0.1, 2.0))]
    pub(super) damping_ratio: f64,
    /// For margins and optimise: largest Td/Ti; up to 0.25 the controller's zeros are real [default: 0.25 for margins, none for optimise]
    #[arg(long, value_name = "RATIO", value_parser = within(1e-3, 1e3))]
    pub(super) td_per_ti: Option<f64>,
    /// For margins and optimise: largest ratio of Td to its filter's time constant, which limits the amplification of noise
    /// [default: 10 for margins, none for optimise]
    #[arg(long, value_name = "N", value_parser = within(1.0, 1e6))]
    pub(super) filter_ratio: Option<f64>,
    /// For margins: gain crossover frequency (rad/s); the phase margin there is --phase-margin
    #[arg(long, value_name = "RAD/S", value_parser = within(1e-9, 1e9))]
    pub(super) crossover: Option<f64>,
}

/// Limits that 95 % of the plants must keep.
#[derive(Clone, Debug, Args)]
#[command(
    next_help_heading = "Limits that 95 % of the plants drawn from the model's covariance must keep"
)]
pub(super) struct LimitArgs {
    /// Minimum phase margin (deg)
    #[arg(long, value_name = "DEG", default_value_t = TuneOptions::default().phase_margin, value_parser = within(1.0, 89.0))]
    pub(super) phase_margin: f64,
    /// Minimum gain margin, upward and downward (dB)
    #[arg(long, value_name = "DB", default_value_t = TuneOptions::default().gain_margin, value_parser = within(0.1, 60.0))]
    pub(super) gain_margin: f64,
    /// Maximum sensitivity peak Ms: 1.4 for a calm loop, 2 for a fast one
    #[arg(long, value_name = "PEAK", default_value_t = TuneOptions::default().ms, value_parser = within(1.05, 100.0))]
    pub(super) ms: f64,
    /// Number of plants drawn from the model's covariance
    #[arg(long, value_name = "COUNT", default_value_t = 500, value_parser = clap::value_parser!(u32).range(50..=100_000))]
    pub(super) draws: u32,
    /// Seed of the draws
    #[arg(long, default_value_t = TuneOptions::default().seed)]
    pub(super) seed: u32,
    /// Use the model even if its verdict is unfavourable or it has no covariance
    #[arg(long)]
    pub(super) anyway: bool,
}

/// Steps to simulate.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Simulated steps")]
pub(super) struct TrialArgs {
    /// Step of the setpoint, in the output's unit
    #[arg(long, value_name = "SIZE", default_value_t = TuneOptions::default().step, value_parser = step, allow_hyphen_values = true)]
    pub(super) step: f64,
    /// Range of the input about its operating point, down and up, in its unit
    #[arg(long, value_name = "FROM..TO", value_parser = limit, allow_hyphen_values = true)]
    pub(super) input_limit: Option<(f64, f64)>,
}

fn step(text: &str) -> Result<f64, String> {
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|it| it.is_finite() && *it != 0.0);
    value.ok_or_else(|| "a number other than 0 is expected".to_owned())
}

fn limit(text: &str) -> Result<(f64, f64), String> {
    let ends = text
        .split_once("..")
        .and_then(|(low, high)| Some((low.parse().ok()?, high.parse().ok()?)));
    let within = |(low, high): &(f64, f64)| {
        *low <= 0.0 && *high >= 0.0 && low < high && low.is_finite() && high.is_finite()
    };
    ends.filter(within).ok_or_else(|| {
        "FROM..TO is expected, FROM at most 0 and TO at least 0, such as -5..10".to_owned()
    })
}
