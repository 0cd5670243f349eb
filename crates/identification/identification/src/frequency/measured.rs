//! The response that a record has by itself: the band in which its coherence holds, and its rows beside those of a model.

use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_wording::setting;

use super::response::{Columns, DECIBEL, Point, Settings, Spectra};
use crate::error::{IdentificationError, Result};
use planesman_record::Record;

/// The least coherence used, unless another is given.
pub const COHERENCE: f64 = 0.6;
/// Frequencies in a row that the coherence may leave within a band.
const GAP: usize = 2;
/// The narrowest band, and the fewest frequencies in it.
const OCTAVE: f64 = 2.0;
const FEWEST: usize = 8;

/// The response at one frequency, as a table has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The frequency, rad/s.
    pub omega: f64,
    /// The magnitude, dB.
    pub decibels: f64,
    /// Its standard deviation, dB.
    pub decibel_deviation: f64,
    /// The phase, deg, within half a turn of the model's.
    pub phase: f64,
    /// Its standard deviation, deg.
    pub phase_deviation: f64,
    /// Standard deviations of the 95 % intervals of both.
    pub sigmas_95: f64,
    /// The coherence.
    pub coherence: f64,
    /// Independent averages.
    pub averages: f64,
    /// Whether the transfer function was fitted to it.
    pub is_used: bool,
    /// The model's magnitude, dB, and phase, deg; none at a pole.
    pub model: Option<(f64, f64)>,
}

/// The response of the first input and output of a record, without a model.
#[derive(Clone, Debug)]
pub struct MeasuredResponse {
    /// The response, at rising frequencies.
    pub points: Vec<Point>,
    /// Lengths of the windows, samples.
    pub windows: Vec<usize>,
    /// Whether each point is in the widest band in which the coherence is at least [`COHERENCE`].
    pub used: Vec<bool>,
    /// Whether the response is `S_ry / S_ru`.
    pub by_reference: bool,
}

impl MeasuredResponse {
    /// Of the segments that are used; a second input is the reference of the loop.
    ///
    /// # Errors
    /// As [`Spectra::new`]; a record without input or output.
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

    /// The lowest and the highest frequency of the band, rad/s; `None` where the coherence holds over no octave.
    #[must_use]
    pub fn band(&self) -> Option<(f64, f64)> {
        let mut used = self.points.iter().zip(&self.used).filter(|it| *it.1);
        let first = used.next()?.0.omega;
        Some((first, used.next_back()?.0.omega))
    }

    /// The response and that of a model at each frequency.
    #[must_use]
    pub fn rows(&self, model: impl Fn(f64) -> Option<Complex<f64>>) -> Vec<Row> {
        rows(&self.points, &self.used, model)
    }
}

/// The points as rows beside a model's response.
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

/// The band that the coherence holds in, and the points of it.
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
            "the coherence holds in no band: {least} or more, and more than chance, is needed over an octave; the most is {most:.2}, at \
             {at:.3} rad/s. Next: excite a band of frequencies (a chirp or a PRBS) beyond the noise, record for longer, or ask for \
             less: {}",
            setting("coherence", 0.4)
        )));
    }
    Ok((0..points.len()).map(|at| best.contains(&at)).collect())
}
