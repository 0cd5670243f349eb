//! The estimators by their names.

use clap::ValueEnum;

use super::recursive::{Kind, Options, Recursively};
use super::vehicle::Vehicle;
use super::{
    Armax, Estimator, Instruments, LeastSquares, OutputError, VehicleFilter, VehicleSearch,
};

/// The ways there are, by the names they are asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Method {
    /// The least simulated error: noise of any colour leaves no bias
    #[default]
    OutputError,
    /// The same point by rounds of instrumental variables
    Instruments,
    /// The least one-step error, with a model of the noise: for disturbances and feedback
    Armax,
    /// The least equation error, as the thesis: for clean data
    LeastSquares,
    /// Least squares, a sample at a time
    RecursiveLeastSquares,
    /// ARMAX by pseudo-linear regression, a sample at a time
    ExtendedLeastSquares,
    /// ARMAX, a sample at a time
    RecursivePredictionError,
    /// Output error, a sample at a time
    RecursiveOutputError,
    /// The vehicle's own equations: K/J, B/J, M_theta/J
    Vehicle,
    /// State and coefficients of the same, by an extended Kalman filter
    Kalman,
}

/// What some methods are told beforehand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Knowledge {
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The noise on the output as a standard deviation, where it is known.
    pub noise: Option<f64>,
    /// How far the sensor's bias drifts in one second, output unit.
    pub bias_drift: f64,
    /// How far disturbances move the output in one second, output unit.
    pub disturbance: f64,
}

impl Method {
    /// The name it is asked for by.
    #[must_use]
    pub fn name(self) -> String {
        self.to_possible_value()
            .map(|it| it.get_name().to_owned())
            .unwrap_or_default()
    }

    /// Whether it seeks the vehicle's own coefficients, whose number is given.
    #[must_use]
    pub fn is_of_the_vehicle(self) -> bool {
        matches!(self, Self::Vehicle | Self::Kalman)
    }

    /// The estimator, with what it is told.
    #[must_use]
    pub fn estimator(self, knowledge: &Knowledge) -> Box<dyn Estimator> {
        let recursive = |kind| -> Box<dyn Estimator> {
            Box::new(Recursively {
                kind,
                options: Options::default(),
            })
        };
        match self {
            Self::OutputError => Box::new(OutputError),
            Self::Instruments => Box::new(Instruments),
            Self::Armax => Box::new(Armax),
            Self::LeastSquares => Box::new(LeastSquares),
            Self::RecursiveLeastSquares => recursive(Kind::LeastSquares),
            Self::ExtendedLeastSquares => recursive(Kind::ExtendedLeastSquares),
            Self::RecursivePredictionError => recursive(Kind::PredictionError),
            Self::RecursiveOutputError => recursive(Kind::OutputError),
            Self::Vehicle => Box::new(VehicleSearch {
                vehicle: knowledge.vehicle,
            }),
            Self::Kalman => Box::new(VehicleFilter {
                noise: knowledge.noise,
                bias_drift: knowledge.bias_drift,
                disturbance: knowledge.disturbance,
                ..VehicleFilter::of(knowledge.vehicle)
            }),
        }
    }
}
