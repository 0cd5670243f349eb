//! The estimators by name.

use super::armax::Armax;
use super::estimator::Estimator;
use super::fir::Fir;
use super::frequency_domain::FrequencyDomain;
use super::least_squares::LeastSquares;
use super::n4sid::N4sid;
use super::output_error::OutputError;
use super::process::Process;
use super::process_model::Form;
use super::recursive::{Kind, Options};
use super::recursively::Recursively;
use super::refined::WarmStarted;
use super::vehicle::Vehicle;
use super::vehicle_fit::{VehicleFilter, VehicleSearch};

planesman_wording::choices! {
    /// The estimators available to users.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Method {
        #[default]
        Automatic = "automatic": "Output error, Box-Jenkins or ARX, with order and delay, by cross-validation",
        OutputError = "output_error": "Minimises the simulation error; no bias from noise of any colour",
        BoxJenkins = "box_jenkins": "Output error with an autoregressive noise model; suitable for disturbances",
        Armax = "armax": "Minimises the one-step prediction error, with a noise model; suitable for disturbances and feedback",
        LeastSquares = "least_squares": "Minimises the equation error, as in the thesis; suitable for clean data",
        N4sid = "n4sid": "Subspace method without an iterative search: poles from states by canonical variates (Jansson 2003)",
        Fir = "fir": "Finite impulse response by least squares; the Bayesian criterion chooses its length",
        Process = "process": "Gain, one or two time constants and dead time, in continuous time; suitable for step tests",
        Frf = "frf": "Frequency response with coherence, and a transfer function with dead time fitted to it; suitable for chirps",
        RecursiveLeastSquares = "recursive_least_squares": "Least squares, recursively",
        ExtendedLeastSquares = "extended_least_squares": "ARMAX by pseudo-linear regression, recursively",
        RecursivePredictionError = "recursive_prediction_error": "ARMAX, recursively",
        RecursiveOutputError = "recursive_output_error": "Output error, recursively",
        Vehicle = "vehicle": "Output error on the vehicle's equations: K/J, B/J, M_theta/J",
        Kalman = "kalman": "Extended Kalman filter for state and coefficients of the vehicle's equations",
    }
}

/// Properties of methods; the rest of the suite queries these instead of listing methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// The method can fit a static curve before or after the dynamics.
    TakesCurve,
    /// The method can fit a static gain, a model of order 0.
    FitsGain,
    /// The method's models have no poles: an order is their number of coefficients, which the method can choose itself.
    HasNoPoles,
    /// Open orders and delays are chosen by information criteria.
    SearchedByCriteria,
    /// The method recognises a step test: if the output is constant until the step, the record begins at rest.
    KnowsStepTests,
    /// In the method's model without a noise model, the noise enters the equation, not the output.
    HasNoiseInEquation,
    /// The method's standard deviations are valid for noise of any colour, even in the equation.
    AllowsForColour,
    /// In a bootstrap, simulated records are fitted from the poles of the estimate.
    StartsFromPoles,
    /// The method learns sample by sample, with forgetting factor and covariance.
    IsRecursive,
    /// The method estimates the coefficients of the vehicle's equations, which define the order.
    IsOfTheVehicle,
}

/// Prior knowledge that some methods use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Knowledge {
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The standard deviation of the output noise, if known.
    pub noise: Option<f64>,
    /// Standard deviation of the sensor's bias drift in one second, output unit.
    pub bias_drift: f64,
    /// Standard deviation of the output's change by disturbances in one second, output unit.
    pub disturbance: f64,
    /// Number of coefficients of a finite impulse response; with `None` a criterion chooses it.
    pub length: Option<usize>,
    /// The form of a process model; with `None` a criterion chooses it.
    pub process: Option<Form>,
    /// The lowest coherence used to fit a transfer function; `None` for 0.6.
    pub coherence: Option<f64>,
    /// Options of the recursive methods.
    pub recursion: Options,
}

impl Method {
    /// The properties of each method, one row per method.
    fn properties(self) -> &'static [Property] {
        use Property::{
            AllowsForColour, FitsGain, HasNoPoles, HasNoiseInEquation, IsOfTheVehicle, IsRecursive,
            KnowsStepTests, SearchedByCriteria, StartsFromPoles, TakesCurve,
        };
        match self {
            Self::Automatic => &[TakesCurve, FitsGain, KnowsStepTests],
            Self::OutputError | Self::BoxJenkins => {
                &[TakesCurve, FitsGain, SearchedByCriteria, StartsFromPoles]
            }
            Self::Armax => &[TakesCurve, FitsGain, SearchedByCriteria],
            Self::LeastSquares => &[TakesCurve, FitsGain, SearchedByCriteria, HasNoiseInEquation],
            Self::N4sid => &[TakesCurve, SearchedByCriteria],
            Self::Fir => &[
                HasNoPoles,
                SearchedByCriteria,
                HasNoiseInEquation,
                AllowsForColour,
            ],
            Self::Process => &[KnowsStepTests],
            Self::Frf => &[],
            Self::RecursiveLeastSquares => &[
                FitsGain,
                SearchedByCriteria,
                HasNoiseInEquation,
                IsRecursive,
            ],
            Self::ExtendedLeastSquares
            | Self::RecursivePredictionError
            | Self::RecursiveOutputError => &[FitsGain, SearchedByCriteria, IsRecursive],
            Self::Vehicle | Self::Kalman => &[IsOfTheVehicle],
        }
    }

    /// Whether the method has a property.
    #[must_use]
    pub fn has(self, property: Property) -> bool {
        self.properties().contains(&property)
    }

    /// All methods with a property.
    pub fn all_with(property: Property) -> impl Iterator<Item = Self> {
        let all = Self::ALL.into_iter();
        all.filter(move |it| it.has(property))
    }

    /// Whether the method estimates the coefficients of the vehicle's equations, which define the order.
    #[must_use]
    pub fn is_of_the_vehicle(self) -> bool {
        self.has(Property::IsOfTheVehicle)
    }

    /// The estimator, with its prior knowledge.
    #[must_use]
    pub fn estimator(self, knowledge: &Knowledge) -> Box<dyn Estimator> {
        let recursive = |kind| -> Box<dyn Estimator> {
            Box::new(Recursively {
                kind,
                options: knowledge.recursion,
            })
        };
        match self {
            Self::OutputError => Box::new(OutputError),
            Self::Automatic | Self::BoxJenkins => Box::new(WarmStarted {
                poles: Vec::new(),
                noise: true,
            }),
            Self::Armax => Box::new(Armax),
            Self::LeastSquares => Box::new(LeastSquares),
            Self::N4sid => Box::new(N4sid),
            Self::Fir => Box::new(Fir {
                length: knowledge.length,
            }),
            Self::Process => Box::new(Process::of(knowledge.process.unwrap_or(Form::First))),
            Self::Frf => Box::new(FrequencyDomain {
                coherence: knowledge.coherence,
                ..FrequencyDomain::default()
            }),
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
                ..VehicleFilter::new(knowledge.vehicle)
            }),
        }
    }
}
