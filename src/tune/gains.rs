//! The arguments that gains depend on, and the gains computed from them.

use anyhow::Result;
use clap::Args;
use planesman_model_file::ModelFile;
use planesman_show::design::{DiveGains, DiveTask};
use planesman_tuning::{TuneOptions, Tuning, tune};
use planesman_vehicle::identified;

use super::arguments::{ControllerArgs, LimitArgs, TrialArgs};
use super::dive::DiveArgs;

/// The arguments that gains depend on, besides the model.
#[derive(Clone, Debug, Args)]
pub(crate) struct GainArgs {
    #[command(flatten)]
    controller: ControllerArgs,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    trial: TrialArgs,
    #[command(flatten)]
    dive: DiveArgs,
}

/// Gains, by kind of loop.
pub(crate) enum Gains {
    /// Gains of a PI or PID controller.
    Controller(Box<Tuning>),
    /// Gains of the depth and pitch loops.
    Dive(Box<DiveTask>, Box<DiveGains>),
}

impl GainArgs {
    /// The gains for a model: gains of the depth and pitch loops if it is a model of the vehicle's pitch, unless a controller is requested.
    ///
    /// # Errors
    /// Like [`tune`] and [`DiveTask::gains`].
    pub(crate) fn gains(&self, model: ModelFile) -> Result<Gains> {
        let asked = self.controller.method.is_some() || self.controller.controller.is_some();
        if identified::is_of_pitch(&model) && !asked {
            let task = self
                .dive
                .task(model, &self.controller, &self.limits, &self.trial);
            let found = task.gains()?;
            return Ok(Gains::Dive(Box::new(task), Box::new(found)));
        }
        Ok(Gains::Controller(Box::new(tune(&model, &self.into())?)))
    }

    /// The vehicle's speed in the record, m/s.
    pub(crate) fn speed(&self) -> Option<f64> {
        self.dive.speed
    }

    /// Seed of the random draws.
    pub(crate) fn seed(&self) -> u32 {
        self.limits.seed
    }
}

impl From<&GainArgs> for TuneOptions {
    fn from(args: &GainArgs) -> Self {
        let GainArgs {
            controller,
            limits,
            trial,
            ..
        } = args;
        Self {
            method: controller.method,
            controller: controller.controller,
            period: controller.period,
            computing_delay: controller.computing_delay,
            phase_margin: limits.phase_margin,
            gain_margin: limits.gain_margin,
            ms: limits.ms,
            crossover: controller.crossover,
            closed_loop_time: controller.closed_loop_time,
            damping_ratio: controller.damping_ratio,
            td_per_ti: controller.td_per_ti,
            filter_ratio: controller.filter_ratio,
            draws: limits.draws as usize,
            seed: limits.seed,
            step: trial.step,
            input_limit: trial.input_limit,
            anyway: limits.anyway,
        }
    }
}
