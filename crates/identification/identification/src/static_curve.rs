//! Static curves before linear dynamics (Hammerstein models) or after them (Wiener models).
//!
//! ```text
//! Hammerstein   y = G(q) f(u) + offset      Wiener   y = f(G(q) u + offset)
//! ```
//! (Ljung 1999, sec. 5.2; Janczak, *Identification of Nonlinear Systems Using Neural Networks and Polynomial Models*, 2005, ch. 2 and 3.)
//! The curve's largest slope is 1, so that `G` contains the gain.

use nalgebra::{DMatrix, DVector};

use crate::structure::range;
use planesman_record::{Record, Run};

/// A signal with at most this many distinct values counts as having few values.
const FEW_VALUES: usize = 40;
/// The share of the signal's range by which a parameter is moved, and the least singular value of columns of size 1 that are independent.
const SMALL_CHANGE: f64 = 1e-6;
const INDEPENDENT: f64 = 1e-4;

/// The position of a curve relative to the linear dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The curve is before the dynamics, at the input.
    Input,
    /// The curve is after the dynamics, at the output.
    Output,
}

/// A curve. Levels and widths are in the signal's unit.
#[derive(Clone, Debug, PartialEq)]
pub enum StaticCurve {
    /// Zero between two values, slope 1 beyond them: `x - upper`, 0, `x - lower`.
    DeadZone {
        /// The lower level.
        lower: f64,
        /// The upper level.
        upper: f64,
    },
    /// Slope 1 between two values, constant beyond them.
    Saturation {
        /// The lower limit; `None` if the curve has no lower limit.
        lower: Option<f64>,
        /// The upper limit; `None` if the curve has no upper limit.
        upper: Option<f64>,
    },
    /// `x |x| + c x`, for example a thruster's force over its speed.
    Square {
        /// `c`, the signal's unit; `None` for a known 0.
        linear: Option<f64>,
    },
    /// Straight lines that meet at breakpoints.
    Piecewise {
        /// The levels, increasing.
        levels: Vec<f64>,
        /// The slopes below the first breakpoint, between two, and above the last; one of them is fixed at 1.
        slopes: Vec<f64>,
    },
    /// Play (backlash); the width is the total play.
    Backlash {
        /// The width.
        width: f64,
    },
}

impl StaticCurve {
    /// The kind of curve, as written in the file.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::DeadZone { .. } => "dead zone",
            Self::Saturation { .. } => "saturation",
            Self::Square { .. } => "square law",
            Self::Piecewise { .. } => "piecewise linear",
            Self::Backlash { .. } => "backlash",
        }
    }

    /// The estimated parameters, by name.
    #[must_use]
    pub fn parameters(&self) -> Vec<(String, f64)> {
        let named = |name: &str, value: f64| (name.to_owned(), value);
        match self {
            Self::DeadZone { lower, upper } => {
                vec![named("lower", *lower), named("upper", *upper)]
            }
            Self::Saturation { lower, upper } => {
                let each = [("lower", lower), ("upper", upper)];
                let known = each
                    .iter()
                    .filter_map(|(name, it)| Some(named(name, (**it)?)));
                known.collect()
            }
            Self::Square { linear } => linear.iter().map(|c| named("linear", *c)).collect(),
            Self::Piecewise { levels, slopes } => {
                let levels = levels.iter().enumerate();
                let levels = levels.map(|(i, w)| (format!("level {}", i + 1), *w));
                let known = reference(slopes);
                let slopes = slopes.iter().enumerate().filter(|(i, _)| *i != known);
                let slopes = slopes.map(|(i, s)| (format!("slope {}", i + 1), *s));
                levels.chain(slopes).collect()
            }
            Self::Backlash { width } => vec![named("width", *width)],
        }
    }

    /// The curve of a kind with these named parameters; `None` if the parameters do not match the kind.
    #[must_use]
    pub fn named(kind: &str, parameters: &[(&str, f64)]) -> Option<Self> {
        let of = |name: &str| parameters.iter().find(|it| it.0 == name).map(|it| it.1);
        let counted = |name: &str, count: usize| -> Vec<Option<f64>> {
            (1..=count).map(|i| of(&format!("{name} {i}"))).collect()
        };
        let curve = match kind {
            "dead zone" => Self::DeadZone {
                lower: of("lower")?,
                upper: of("upper")?,
            },
            "saturation" => Self::Saturation {
                lower: of("lower"),
                upper: of("upper"),
            },
            "square law" => Self::Square {
                linear: of("linear"),
            },
            "piecewise linear" => {
                let count = parameters.len() / 2;
                let slopes = counted("slope", count + 1);
                Self::Piecewise {
                    levels: counted("level", count).into_iter().collect::<Option<_>>()?,
                    slopes: slopes.into_iter().map(|it| it.unwrap_or(1.0)).collect(),
                }
            }
            "backlash" => Self::Backlash {
                width: of("width")?,
            },
            _ => return None,
        };
        let values: Vec<f64> = curve.parameters().iter().map(|it| it.1).collect();
        (values.len() == parameters.len()).then(|| curve.with(&values))?
    }

    /// The curve with other parameter values, in the order of [`Self::parameters`]; `None` if breakpoints cross or a width is negative.
    pub(crate) fn with(&self, values: &[f64]) -> Option<Self> {
        if values.iter().any(|it| !it.is_finite()) {
            return None;
        }
        let mut values = values.iter().copied();
        let mut next = || values.next();
        match self {
            Self::DeadZone { .. } => {
                let (lower, upper) = (next()?, next()?);
                (lower < upper).then_some(Self::DeadZone { lower, upper })
            }
            Self::Saturation { lower, upper } => {
                let lower = lower.and_then(|_| next());
                let upper = upper.and_then(|_| next());
                let apart = lower.zip(upper).is_none_or(|(lower, upper)| lower < upper);
                apart.then_some(Self::Saturation { lower, upper })
            }
            Self::Square { linear } => Some(Self::Square {
                linear: linear.and_then(|_| next()),
            }),
            Self::Piecewise { levels, slopes } => {
                let levels: Vec<f64> = levels.iter().filter_map(|_| next()).collect();
                let known = reference(slopes);
                let slopes = slopes.iter().enumerate();
                let slopes = slopes.map(|(i, s)| if i == known { Some(*s) } else { next() });
                let slopes: Vec<f64> = slopes.collect::<Option<_>>()?;
                let rising = levels.windows(2).all(|pair| pair[0] < pair[1]);
                rising.then_some(Self::Piecewise { levels, slopes })
            }
            Self::Backlash { .. } => {
                let width = next()?;
                (width >= 0.0).then_some(Self::Backlash { width })
            }
        }
    }

    /// The breakpoints of the curve.
    pub(crate) fn levels(&self) -> Vec<f64> {
        match self {
            Self::DeadZone { lower, upper } => vec![*lower, *upper],
            Self::Saturation { lower, upper } => lower.iter().chain(upper).copied().collect(),
            Self::Piecewise { levels, .. } => levels.clone(),
            Self::Square { .. } | Self::Backlash { .. } => Vec::new(),
        }
    }

    /// Whether the curve bends only between two values of a signal, and a backlash is no wider than their distance.
    pub(crate) fn bends_within(&self, least: f64, most: f64) -> bool {
        match self {
            Self::Backlash { width } => *width <= most - least,
            _ => (self.levels().iter()).all(|level| (least..=most).contains(level)),
        }
    }

    /// Whether the curve's values at these inputs, with a gain and an offset, determine all its parameters and leave one value for a test.
    fn is_told_by(&self, values: &[f64]) -> bool {
        if matches!(self, Self::Backlash { .. }) {
            return true; // What it was before tells too.
        }
        let parameters: Vec<f64> = self.parameters().iter().map(|it| it.1).collect();
        let numbers = parameters.len() + 2;
        let small = SMALL_CHANGE * range(values);
        let own = self.of(values);
        let slopes = parameters.iter().enumerate().map(|(j, value)| {
            let mut moved = parameters.clone();
            moved[j] = value + small;
            let moved = self
                .with(&moved)
                .map_or_else(|| own.clone(), |it| it.of(values));
            moved
                .iter()
                .zip(&own)
                .map(|(p, q)| (p - q) / small)
                .collect::<Vec<f64>>()
        });
        let columns = [vec![1.0; values.len()], own.clone()];
        let columns: Vec<Vec<f64>> = columns.into_iter().chain(slopes).collect();
        let unit = |it: &Vec<f64>| DVector::from_column_slice(it).normalize();
        let columns: Vec<DVector<f64>> = columns.iter().map(unit).collect();
        let is_finite = columns.iter().all(|it| it.iter().all(|v| v.is_finite()));
        values.len() > numbers
            && is_finite
            && DMatrix::from_columns(&columns).rank(INDEPENDENT) == numbers
    }

    /// Scales the curve so that the largest slope of straight lines is 1.
    pub(crate) fn normalised(self) -> Self {
        match self {
            Self::Piecewise { levels, slopes } => {
                let larger = |largest: f64, it: &f64| {
                    if it.abs() > largest.abs() {
                        *it
                    } else {
                        largest
                    }
                };
                let largest = slopes.iter().fold(0.0, larger);
                let slopes = slopes.iter().map(|it| it / largest).collect();
                Self::Piecewise { levels, slopes }
            }
            other => other,
        }
    }

    /// Applies the curve to a signal; only backlash has memory, and starts in the middle of its play.
    #[must_use]
    pub fn of(&self, signal: &[f64]) -> Vec<f64> {
        match self {
            Self::Backlash { width } => {
                let mut at = signal.first().copied().unwrap_or_default();
                let follow = |x: &f64| {
                    at = at.clamp(x - width / 2.0, x + width / 2.0);
                    at
                };
                signal.iter().map(follow).collect()
            }
            _ => signal.iter().map(|x| self.at(*x)).collect(),
        }
    }

    /// The value at `x`.
    fn at(&self, x: f64) -> f64 {
        match self {
            Self::DeadZone { lower, upper } => (x - upper).max(0.0) + (x - lower).min(0.0),
            Self::Saturation { lower, upper } => x
                .max(lower.unwrap_or(x))
                .min(upper.unwrap_or(f64::INFINITY)),
            Self::Square { linear } => x * x.abs() + linear.unwrap_or(0.0) * x,
            Self::Piecewise { levels, slopes } => {
                let changes = slopes.windows(2).map(|pair| pair[1] - pair[0]);
                let bends = levels.iter().zip(changes);
                let bends = bends.map(|(level, change)| change * (x - level).max(0.0));
                slopes.first().map_or(x, |slope| slope * x) + bends.sum::<f64>()
            }
            Self::Backlash { .. } => x,
        }
    }

    /// The slope at `x`.
    pub(crate) fn slope(&self, x: f64) -> f64 {
        match self {
            Self::DeadZone { lower, upper } => f64::from(u8::from(x < *lower || x > *upper)),
            Self::Saturation { lower, upper } => {
                let inside = lower.is_none_or(|it| x > it) && upper.is_none_or(|it| x < it);
                f64::from(u8::from(inside))
            }
            Self::Square { linear } => 2.0 * x.abs() + linear.unwrap_or(0.0),
            Self::Piecewise { levels, slopes } => {
                let below = levels.iter().take_while(|level| x > **level).count();
                slopes.get(below).copied().unwrap_or(1.0)
            }
            Self::Backlash { .. } => 1.0,
        }
    }

    /// A record with the curve applied to its first input.
    #[must_use]
    pub fn of_input(&self, record: &Record) -> Record {
        let mut record = record.clone();
        for segment in &mut record.segments {
            if let Some((past, inputs)) = segment.run().map(|run| self.of_run(&run)) {
                if let Some(first) = segment.past.first_mut() {
                    *first = past;
                }
                if let Some(first) = segment.inputs.first_mut() {
                    *first = inputs;
                }
            }
        }
        record
    }

    /// The earlier and the following inputs of a run after the curve.
    pub(crate) fn of_run(&self, run: &Run<'_>) -> (Vec<f64>, Vec<f64>) {
        let mut past = self.of(&[run.past, run.inputs].concat());
        let inputs = past.split_off(run.past.len());
        (past, inputs)
    }
}

/// A curve with the covariance of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedCurve {
    /// The curve.
    pub curve: StaticCurve,
    /// The covariance of [`StaticCurve::parameters`].
    pub covariance: DMatrix<f64>,
}

impl FittedCurve {
    /// A known curve, with zero covariance.
    pub(crate) fn known(curve: &StaticCurve) -> Self {
        let count = curve.parameters().len();
        Self {
            curve: curve.clone(),
            covariance: DMatrix::zeros(count, count),
        }
    }

    /// Whether every parameter is known better than the signal's range. A signal with few values must have more values than the curve has
    /// parameters including gain and offset, and at these values no parameter may compensate for another.
    #[must_use]
    pub fn is_determined(&self, signal: &[f64]) -> bool {
        let size = range(signal);
        let parameters = self.covariance.diagonal();
        let is_known = parameters.iter().all(|variance| variance.sqrt() < size);
        is_known && few_values(signal).is_none_or(|values| self.curve.is_told_by(&values))
    }

    /// Name, value and standard deviation of the estimated parameters.
    pub fn named(&self) -> impl Iterator<Item = (String, f64, f64)> {
        let deviation = |j: usize| self.covariance[(j, j)].max(0.0).sqrt();
        let named = self.curve.parameters().into_iter().enumerate();
        named.map(move |(j, (name, value))| (name, value, deviation(j)))
    }
}

/// The values, increasing, of a signal with few values.
fn few_values(signal: &[f64]) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = Vec::new();
    for value in signal {
        if let Err(at) = values.binary_search_by(|it| it.total_cmp(value)) {
            values.insert(at, *value);
        }
        if values.len() > FEW_VALUES {
            return None;
        }
    }
    Some(values)
}

/// Which slope is fixed at 1.
fn reference(slopes: &[f64]) -> usize {
    let at_one = slopes.iter().position(|it| *it == 1.0);
    at_one.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<StaticCurve> {
        vec![
            StaticCurve::DeadZone {
                lower: -0.5,
                upper: 1.0,
            },
            StaticCurve::Saturation {
                lower: Some(-1.0),
                upper: Some(2.0),
            },
            StaticCurve::Saturation {
                lower: None,
                upper: Some(2.0),
            },
            StaticCurve::Square { linear: Some(0.5) },
            StaticCurve::Piecewise {
                levels: vec![-1.0, 1.0],
                slopes: vec![0.25, 1.0, 0.5],
            },
            StaticCurve::Backlash { width: 1.0 },
        ]
    }

    #[test]
    fn each_curve_has_the_values_of_its_definition() {
        let x = [-3.0, -0.75, 0.0, 0.5, 3.0];
        let expected = [
            [-2.5, -0.25, 0.0, 0.0, 2.0],
            [-1.0, -0.75, 0.0, 0.5, 2.0],
            [-3.0, -0.75, 0.0, 0.5, 2.0],
            [-10.5, -0.9375, 0.0, 0.5, 10.5],
            [-0.75, 0.0, 0.75, 1.25, 2.75],
            [-3.0, -1.25, -0.5, 0.0, 2.5],
        ];
        for (curve, expected) in all().iter().zip(expected) {
            assert_eq!(curve.of(&x), expected, "{curve:?}");
        }
    }

    #[test]
    fn the_parameters_of_a_curve_make_the_curve_and_slopes_are_its_differences() {
        for curve in all() {
            let values: Vec<f64> = curve.parameters().iter().map(|it| it.1).collect();
            assert_eq!(curve.with(&values).as_ref(), Some(&curve));
            let parameters = curve.parameters();
            let named: Vec<_> = parameters.iter().map(|it| (it.0.as_str(), it.1)).collect();
            assert_eq!(
                StaticCurve::named(curve.name(), &named).as_ref(),
                Some(&curve)
            );
            for x in [-2.9, -0.7, 0.1, 0.6, 1.5, 3.1] {
                let h = 1e-6;
                let by_difference = (curve.at(x + h) - curve.at(x - h)) / (2.0 * h);
                assert!(
                    (curve.slope(x) - by_difference).abs() < 1e-6,
                    "{curve:?} at {x}"
                );
            }
        }
        let crossing = StaticCurve::DeadZone {
            lower: 0.0,
            upper: 1.0,
        };
        assert_eq!(crossing.with(&[1.0, 0.0]), None);
        assert_eq!(crossing.with(&[f64::NAN, 0.0]), None);
    }
}
