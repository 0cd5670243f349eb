//! The frequency response of a record: the band of sufficient coherence, and table rows that compare it with a model's response.

use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_wording::setting;

use super::response::{Columns, DECIBEL, Point, Settings, Spectra};
use crate::error::{IdentificationError, Result};
use planesman_record::Record;

/// The lowest coherence used by default.
pub const COHERENCE: f64 = 0.6;
/// Number of consecutive frequencies within a band at which the coherence may be too low.
const GAP: usize = 2;
/// Width of the narrowest band, and the minimum number of frequencies in a band.
const OCTAVE: f64 = 2.0;
const FEWEST: usize = 8;

/// The response at one frequency, as a row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The frequency, rad/s.
    pub omega: f64,
    /// The magnitude, dB.
    pub decibels: f64,
    /// Standard deviation of the magnitude, dB.
    pub decibel_deviation: f64,
    /// The phase, deg, within half a turn of the model's.
    pub phase: f64,
    /// Standard deviation of the phase, deg.
    pub phase_deviation: f64,
    /// Standard deviations of the 95 % intervals of both.
    pub sigmas_95: f64,
    /// The coherence.
    pub coherence: f64,
    /// Independent averages.
    pub averages: f64,
    /// Whether the transfer function was fitted to this point.
    pub is_used: bool,
    /// The model's magnitude, dB, and phase, deg; `None` at a pole.
    pub model: Option<(f64, f64)>,
}

/// The response of the first input and output of a record, without a model.
#[derive(Clone, Debug)]
pub struct MeasuredResponse {
    /// The response, at increasing frequencies.
    pub points: Vec<Point>,
    /// Lengths of the windows, samples.
    pub windows: Vec<usize>,
    /// Whether each point is in the widest band with a coherence of at least [`COHERENCE`].
    pub used: Vec<bool>,
    /// Whether the response is `S_ry / S_ru`.
    pub by_reference: bool,
}

impl MeasuredResponse {
    /// Uses the selected segments; a second input is the reference of the loop.
    ///
    /// # Errors
    /// Like [`Spectra::new`]; also if the record lacks an input or output.
    pub fn new(record: &Record) -> Result<Self> {
        let columns = record.used().into_iter().filter_map(|number| {
            let segment = &record.segments[number];
            let (input, references) = segment.inputs.split_first()?;
            Some(Columns {
                inputs: vec![input],
                output: segment.outputs.first()?,
                references: references.iter().take(1).map(Vec::as_slice).collect(),
            })
        });
        let spectra = Spectra::new(columns.collect(), record.sample_time, &Settings::default())?;
        let used = band(&spectra.points, COHERENCE);
        Ok(Self {
            used: used.unwrap_or_else(|_| vec![false; spectra.points.len()]),
            points: spectra.points,
            windows: spectra.windows.0,
            by_reference: record.inputs.len() > 1,
        })
    }

    /// The lowest and the highest frequency of the band, rad/s; `None` if the coherence is sufficient over less than an octave.
    #[must_use]
    pub fn band(&self) -> Option<(f64, f64)> {
        let mut used = self.points.iter().zip(&self.used).filter(|it| *it.1);
        let first = used.next()?.0.omega;
        Some((first, used.next_back()?.0.omega))
    }

    /// The measured response and the model's response at each frequency.
    #[must_use]
    pub fn rows(&self, model: impl Fn(f64) -> Option<Complex<f64>>) -> Vec<Row> {
        rows(&self.points, &self.used, model)
    }
}

/// The points as rows with a model's response.
pub(crate) fn rows(
    points: &[Point],
    used: &[bool],
    model: impl Fn(f64) -> Option<Complex<f64>>,
) -> Vec<Row> {
    let mut phase_before = None;
    let each = points.iter().zip(used);
    each.map(|(point, is_used)| {
        let near = |phase: f64, other: f64| phase + 360.0 * ((other - phase) / 360.0).round();
        let model = model(point.omega).map(|it| {
            let phase = it.argument().to_degrees();
            let phase = phase_before.map_or(phase, |before| near(phase, before));
            phase_before = Some(phase);
            (DECIBEL * libm::log(it.modulus()), phase)
        });
        let phase = point.values[0].argument().to_degrees();
        let (decibels, decibel_deviation) = point.decibels(0);
        Row {
            omega: point.omega,
            decibels,
            decibel_deviation,
            phase: model.map_or(phase, |model| near(phase, model.1)),
            phase_deviation: point.phase_deviation(0).to_degrees(),
            sigmas_95: point.sigmas_95(),
            coherence: point.coherence,
            averages: point.averages,
            is_used: *is_used,
            model,
        }
    })
    .collect()
}

/// The band of sufficient coherence, and its points.
pub(crate) fn band(points: &[Point], least: f64) -> Result<Vec<bool>> {
    let holds = |it: &Point| it.coherence >= least.max(it.coherence_by_chance());
    let (mut best, mut run): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    let width = |run: &[usize]| match (run.first(), run.last()) {
        (Some(first), Some(last)) => points[*last].omega / points[*first].omega,
        _ => 0.0,
    };
    for (at, point) in points.iter().enumerate() {
        if run.last().is_some_and(|last| at - last > GAP + 1) {
            run.clear();
        }
        if holds(point) {
            run.push(at);
            if width(&run) > width(&best) {
                best.clone_from(&run);
            }
        }
    }
    if width(&best) < OCTAVE || best.len() < FEWEST {
        let most = points
            .iter()
            .max_by(|p, q| p.coherence.total_cmp(&q.coherence));
        let (most, at) = most.map_or((0.0, 0.0), |it| (it.coherence, it.omega));
        return Err(IdentificationError::NoBand(format!(
            "the coherence is too low in every band. It must be significant and at least {least} over an octave, but the highest is {most:.2}, at {at:.3} rad/s. Next: excite a band of frequencies (a chirp or a PRBS) well above the noise, record for longer, or lower the required coherence: {}",
            setting("coherence", 0.4)
        )));
    }
    Ok((0..points.len()).map(|at| best.contains(&at)).collect())
}
