//! A model of several channels fitted to all records, in the signals' own units.

use nalgebra::{DMatrix, DVector};
use planesman_record::{Segment, filter};

use super::equations::Equations;
use super::layout::{Channel, Layout};
use super::scaled::Scaled;
use super::selection::Model;
use crate::error::{IdentificationError, Result};
use crate::estimators::{Error, Estimate, Linearised, Search, coloured, lost, unit_factor};
use crate::structure;
use crate::uncertainty::Reading;

/// Rounds of noise model and model.
const ROUNDS: usize = 5;
const STEPS: usize = 60;
const ENOUGH: f64 = 1e-10;
/// A prior standard deviation, relative to the output's, that keeps initial motions near 0 if nothing else separates those of two channels.
const MOTION: f64 = 1e3;

/// A model of all channels, in the scaled units of its records.
pub(super) struct Fitted {
    pub(super) layout: Layout,
    pub(super) theta: DVector<f64>,
    /// `1, d1, ..., dk` of the noise; `[1]` if it is white, or not modelled.
    pub(super) whitening: Vec<f64>,
}

impl Fitted {
    /// The smallest error near a model's poles; with a noise model on request.
    pub(super) fn near(
        segments: &[Segment],
        (model, offset, noise): (&Model, bool, bool),
        radius: f64,
    ) -> Result<Self> {
        let none = || {
            IdentificationError::Search("the search for the smallest output error found no minimum")
        };
        let layout = Layout {
            channels: model.channels.clone(),
            offset,
            runs: segments.len(),
        };
        let plain = Equations::new(segments, layout.clone(), &[1.0]);
        let whole = plain.whole();
        let search = Search {
            steps: STEPS,
            enough: ENOUGH,
            radius,
        };
        let start = plain.completed(&model.poles, &whole).ok_or_else(none)?;
        let (mut theta, _) = plain.minimised(start, &whole, search).ok_or_else(none)?;
        let mut whitening = vec![1.0];
        for _ in 0..if noise { ROUNDS } else { 0 } {
            whitening = plain.whitening(&theta);
            let equations = Equations::new(segments, layout.clone(), &whitening);
            let Some((found, _)) = equations.minimised(theta.clone(), &whole, search) else {
                break;
            };
            let moved = (&found - &theta).norm() > 1e-6 * theta.norm();
            theta = found;
            if !moved || whitening.len() == 1 {
                break;
            }
        }
        Ok(Self {
            layout,
            theta,
            whitening,
        })
    }

    pub(super) fn equations(&self, segments: &[Segment], whitening: &[f64]) -> Equations {
        Equations::new(segments, self.layout.clone(), whitening)
    }

    /// Applies the channels to other records, each with the offset of record `run` and no initial motion.
    pub(super) fn on(&self, segments: &[Segment], run: usize) -> (Equations, DVector<f64>) {
        let layout = Layout {
            runs: segments.len(),
            ..self.layout.clone()
        };
        let mut theta = DVector::zeros(layout.count());
        for number in 0..layout.channels.len() {
            let places = layout.a(number).chain(layout.b(number));
            places.for_each(|at| theta[at] = self.theta[at]);
        }
        for at in (0..layout.runs).filter_map(|run| layout.offset(run)) {
            theta[at] = self.layout.offset(run).map_or(0.0, |at| self.theta[at]);
        }
        (Equations::new(segments, layout, &[1.0]), theta)
    }
}

/// The model in the signals' units, with its uncertainty.
pub(super) struct InUnits {
    /// The model of each channel, with the covariance of its parameters.
    pub(super) channels: Vec<(Channel, Estimate)>,
    /// The offset of each record, relative to the inputs' levels.
    pub(super) offsets: Vec<f64>,
    pub(super) noise_variance: f64,
    pub(super) residuals: Vec<Vec<f64>>,
}

impl InUnits {
    /// # Errors
    /// [`IdentificationError`], if the records do not determine every parameter.
    pub(super) fn of(fitted: &Fitted, scaled: &Scaled, sample_time: f64) -> Result<Self> {
        let Fitted {
            layout,
            theta,
            whitening,
        } = fitted;
        let equations = fitted.equations(&scaled.segments, whitening);
        let at = equations.linearised(theta);
        let residuals: Vec<Vec<f64>> = (0..layout.runs)
            .map(|run| equations.errors(theta, run))
            .collect();
        let counted: usize = equations.counted_errors(theta).iter().map(Vec::len).sum();
        let freedom = counted.saturating_sub(theta.len());
        if freedom == 0 {
            return Err(IdentificationError::TooFewRows {
                rows: counted,
                parameters: theta.len(),
            });
        }
        let variance = at.errors.norm_squared() / freedom as f64;
        let lists = by_run(&at.errors, &scaled.segments);
        let unit = unit_factor(&with_motions_held(&at, layout, variance))?;
        let mut factor = coloured(unit, &at, &lists, variance);
        if whitening.len() > 1 {
            // The residual is nearly white, the noise on the output is not.
            let on_output = lists.iter().map(|of| filter(&[1.0], whitening, of));
            let on_output: Vec<Vec<f64>> = on_output.collect();
            factor *= lost(whitening, &on_output, theta.len());
        }
        let y = scaled.output;
        let channels = layout.channels.iter().enumerate().map(|(number, channel)| {
            let u = scaled.inputs[channel.input];
            let motions = (0..layout.runs).flat_map(|run| layout.motion(run, number));
            let places: Vec<(usize, f64)> = (layout.a(number).map(|at| (at, 1.0)))
                .chain(layout.b(number).map(|at| (at, y.size / u.size)))
                .chain(motions.map(|at| (at, y.size)))
                .collect();
            let own = DMatrix::from_fn(places.len(), factor.ncols(), |i, j| {
                factor[(places[i].0, j)] * places[i].1
            });
            let estimate = Estimate {
                input_level: u.level,
                error: Error::Output,
                layout: structure::Layout {
                    structure: channel.structure.clone(),
                    runs: layout.runs,
                },
                sample_time,
                theta: DVector::from_fn(places.len(), |i, _| theta[places[i].0] * places[i].1),
                covariance: &own * own.transpose(),
                factor: Some(own),
                noise_variance: variance * y.size * y.size,
                noise_model: Vec::new(),
                noise_denominator: whitening[1..].to_vec(),
                residuals: Vec::new(),
                output_curve: None,
                physical: None,
                process: None,
                frequency: None,
            };
            (channel.clone(), estimate)
        });
        let offset = |run: usize| layout.offset(run).map_or(0.0, |at| theta[at]);
        let in_units = |it: &Vec<f64>| it.iter().map(|e| e * y.size).collect();
        Ok(Self {
            channels: channels.collect(),
            offsets: (0..layout.runs)
                .map(|run| y.level + y.size * offset(run))
                .collect(),
            noise_variance: variance * y.size * y.size,
            residuals: residuals.iter().map(in_units).collect(),
        })
    }
}

impl InUnits {
    /// Whether a zero may cancel a pole in at least one channel.
    pub(super) fn cancels(&self) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|(_, it)| !Reading::new(it, 0).cancelled_poles().is_empty())
    }
}

/// Splits errors into records.
fn by_run(errors: &DVector<f64>, segments: &[Segment]) -> Vec<Vec<f64>> {
    let mut rest = errors.as_slice();
    let of = |segment: &Segment| {
        let (own, others) = rest.split_at(segment.len());
        rest = others;
        own.to_vec()
    };
    segments.iter().map(of).collect()
}

/// Adds a row for each initial motion that keeps it weakly near 0: otherwise the motions of two channels with the same poles could not be
/// separated.
fn with_motions_held(at: &Linearised, layout: &Layout, variance: f64) -> Linearised {
    let channels = 0..layout.channels.len();
    let motions: Vec<usize> = (0..layout.runs)
        .flat_map(|run| channels.clone().flat_map(move |it| layout.motion(run, it)))
        .collect();
    let rows = at.errors.len();
    let mut slopes = at
        .slopes
        .clone()
        .resize_vertically(rows + motions.len(), 0.0);
    for (row, place) in motions.iter().enumerate() {
        slopes[(rows + row, *place)] = variance.sqrt() / MOTION;
    }
    Linearised {
        errors: at
            .errors
            .clone()
            .resize_vertically(rows + motions.len(), 0.0),
        slopes,
    }
}
