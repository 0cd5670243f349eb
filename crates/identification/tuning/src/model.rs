//! A model with its uncertainty, and random plants within it.

use nalgebra::{Complex, DMatrix, DVector};
use planesman_identification::analysis::{Standing, Verdict};
use planesman_identification::estimators::{Form, ProcessModel};
use planesman_identification::{Model, SIGMAS_95, continuous, noise};
use planesman_linear::digits::with_interval;
use planesman_linear::{
    ComplexFunctions as _, TransferFunction, discrete_to_continuous, is_sampling_artefact, polar,
    polynomial,
};
use planesman_model_file::{ModelFile, Side};

use crate::dynamics::Dynamics;
use crate::error::{Result, TuneError};
use crate::plant::Plant;

/// Ticks within this share of each other count as equal.
const SAME: f64 = 1e-6;
/// Directions of the covariance below this share of the largest are rounding error.
const ROUNDING: f64 = 1e-15;
/// The step of difference quotients, in standard deviations.
pub(crate) const NUDGE: f64 = 0.01;
/// A pole this near to z = 1 counts as an integrator.
const AT_ONE: f64 = 1e-6;

/// The sampling of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// The controller's sample time, s.
    pub tick: f64,
    /// The time from a sample of the output to the resulting command, s.
    pub computing_delay: f64,
}

/// A model with normally distributed parameters. For a process model they are gain, logarithms of time constants (so that these stay above
/// 0) and dead time; for others the coefficients of the difference equation.
#[derive(Clone, Debug)]
pub struct UncertainModel {
    /// The input's name.
    pub input: String,
    /// The output's name.
    pub output: String,
    /// Description of the kind of model.
    pub description: String,
    /// The sampling interval of the identification, s.
    pub sample_time: f64,
    /// Notes about the model.
    pub notes: Vec<String>,
    kind: Kind,
    centre: DVector<f64>,
    /// `F` of the covariance `F F'`.
    factor: DMatrix<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The parameters are gain, logarithms of time constants, dead time.
    Process(Form),
    /// The first coefficients, this many, are `a`; the rest is the numerator.
    Equation { poles: usize },
}

/// A property in which the model's uncertainty is expressed.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// Unit of the property; empty for the signals' own unit.
    pub unit: &'static str,
    /// What it is.
    pub kind: PropertyKind,
    /// Its value.
    pub value: f64,
}

/// What a property says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyKind {
    /// How much.
    Gain,
    /// How fast.
    Pole,
    /// How damped.
    Damping,
    /// How late.
    Delay,
}

impl UncertainModel {
    /// From a model file.
    ///
    /// # Errors
    /// Unless `anyway`: if the verdict says that the model is not reliable, or the file has no covariance.
    pub fn new(file: &ModelFile, anyway: bool) -> Result<Self> {
        let mut notes = Vec::new();
        if let Some(judgement) = file.judgement() {
            let (standing, code) = (judgement.standing, judgement.code);
            let verdict = Standing::of_name(&standing).and_then(|it| Verdict::of(&code, it));
            match verdict.ok_or(TuneError::Judgement { standing, code })? {
                it if it.standing() == Standing::NotUsable && !anyway => {
                    return Err(TuneError::Verdict(it));
                }
                it => notes.push(format!("the model's verdict: {}", it.words())),
            }
        }
        let (kind, centre, covariance) = match process(file) {
            Some((form, values)) => {
                let (centre, covariance, alone) = process_coordinates(file, &values);
                if alone {
                    notes.push(
                        "the file has no covariance of the process parameters: they are \
                        assumed to be independent"
                            .to_owned(),
                    );
                }
                (Kind::Process(form), centre, covariance)
            }
            None => {
                let values: Vec<f64> = file.den[1..].iter().chain(&file.num).copied().collect();
                let count = values.len();
                let covariance = DMatrix::from_fn(count, count, |i, j| file.covariance[i][j]);
                let (values, covariance) = (DVector::from_vec(values), covariance);
                let (values, covariance) = match is_of_lines(file) {
                    true => {
                        let held = of_held_input(file.order(), count);
                        (&held * values, &held * covariance * held.transpose())
                    }
                    false => (values, covariance),
                };
                let poles = file.order();
                (Kind::Equation { poles }, values, covariance)
            }
        };
        if let Some(curve) = &file.static_curve {
            let (side, undone) = match curve.side {
                Side::Input => ("input", "the controller's output"),
                Side::Output => ("output", "the measured value"),
            };
            notes.push(format!(
                "gains and margins are those of the linear dynamics, without the static curve ({}) of the {side}; apply the inverse of the curve to {undone}",
                curve.kind
            ));
        }
        let factor = factor(&covariance);
        let is_exact =
            file.method == ModelFile::exact("", "", 1.0, vec![1.0], vec![1.0, 0.0]).method;
        if factor.ncols() == 0 && !is_exact {
            if !anyway {
                return Err(TuneError::NoCovariance);
            }
            notes.push("no covariance: the model is assumed to be exact".to_owned());
        }
        let description = match &file.process {
            Some(process) => format!("process {}, {}", process.form, process.equation),
            None => format!("{}, order {}", file.method, file.order()),
        };
        Ok(Self {
            input: file.input.clone(),
            output: file.output.clone(),
            description,
            sample_time: file.sample_time,
            notes,
            kind,
            centre,
            factor,
        })
    }

    /// Whether the model is known without uncertainty.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.factor.ncols() == 0
    }

    /// The mean of the parameters.
    #[must_use]
    pub fn centre(&self) -> &DVector<f64> {
        &self.centre
    }

    /// The parameters, moved from the mean by this many standard deviations along a direction of the covariance.
    #[must_use]
    pub fn along(&self, direction: usize, deviations: f64) -> DVector<f64> {
        &self.centre + self.factor.column(direction) * deviations
    }

    /// The number of directions of the covariance.
    #[must_use]
    pub fn directions(&self) -> usize {
        self.factor.ncols()
    }

    /// Random parameters from their distribution; they depend only on the seed.
    #[must_use]
    pub fn draws(&self, count: usize, seed: u32) -> Vec<DVector<f64>> {
        let directions = self.directions();
        let numbers = noise(seed, count * directions);
        let each = numbers.chunks(directions.max(1));
        each.map(|it| &self.centre + &self.factor * DVector::from_row_slice(it))
            .collect()
    }

    /// The plant with these parameters, sampled as the controller sees it.
    ///
    /// # Errors
    /// If the model has direct feedthrough, or the tick differs from the model's and there is no continuous counterpart.
    pub fn plant(&self, parameters: &DVector<f64>, sampling: &Sampling) -> Result<Plant> {
        let Sampling {
            tick,
            computing_delay,
        } = *sampling;
        let plant = match self.kind {
            Kind::Process(form) => {
                let (transfer, delay) = process_transfer(form, parameters)?;
                Plant::held(&transfer, delay + computing_delay, tick)?
            }
            Kind::Equation { poles } => {
                let own = (tick / self.sample_time - 1.0).abs() < SAME;
                let late = computing_delay / tick;
                let whole = (late - late.round()).abs() < SAME;
                if own && whole {
                    let (den, num) = equation(parameters, poles);
                    Plant::of_z(num, &den, tick, late.round() as usize)
                } else {
                    let (transfer, delay) = self.continuous(parameters)?;
                    if transfer.num.len() == transfer.den.len() {
                        return Err(TuneError::Feedthrough(tick));
                    }
                    Plant::held(&transfer, delay + computing_delay, tick)?
                }
            }
        };
        match plant.delay {
            0 => Err(TuneError::Feedthrough(tick)),
            _ => Ok(plant),
        }
    }

    /// The model with these parameters in continuous time, and its dead time, s.
    ///
    /// # Errors
    /// If poles belong to no continuous system.
    pub fn continuous(&self, parameters: &DVector<f64>) -> Result<(TransferFunction, f64)> {
        match self.kind {
            Kind::Process(form) => process_transfer(form, parameters),
            Kind::Equation { poles } => {
                let (den, num) = equation(parameters, poles);
                let direct = num.len() > poles;
                let model = Model {
                    sample_time: self.sample_time,
                    a: den[1..].to_vec(),
                    feedthrough: if direct { num[0] } else { 0.0 },
                    b: num[usize::from(direct)..].to_vec(),
                    c: Vec::new(),
                    bias: 0.0,
                };
                let found = continuous(&model).map_err(|source| TuneError::NoContinuous {
                    sample_time: self.sample_time,
                    source,
                })?;
                Ok((found.transfer, found.delay))
            }
        }
    }

    /// The model itself in gain, time constants and dead time.
    ///
    /// # Errors
    /// Like [`UncertainModel::continuous`].
    pub fn dynamics(&self) -> Result<Dynamics> {
        let (transfer, delay) = self.continuous(&self.centre)?;
        Dynamics::new(&transfer, delay)
    }

    /// Gain, poles and dead time with these parameters; the poles are in the order of the model's own. The dead time of a difference
    /// equation is its numerator's delay at a frequency, rad/s: `-arg(z^-d B / B(1)) / w`.
    ///
    /// # Errors
    /// If roots cannot be found.
    pub fn properties(
        &self,
        parameters: &DVector<f64>,
        plant: &Plant,
        frequency: f64,
    ) -> Result<Vec<Property>> {
        let of = |name: &str, unit, kind, value| Property {
            name: name.to_owned(),
            unit,
            kind,
            value,
        };
        match self.kind {
            Kind::Process(form) => {
                let values = natural(parameters);
                let named = form.parameters().iter().zip(values);
                let kind = |name: &str| match name {
                    "K" => PropertyKind::Gain,
                    "theta" => PropertyKind::Delay,
                    "zeta" => PropertyKind::Damping,
                    _ => PropertyKind::Pole,
                };
                Ok(named
                    .map(|((name, unit), value)| of(name, unit, kind(name), value))
                    .collect())
            }
            Kind::Equation { poles } => {
                let integrates = plant.integrators() > 0;
                let gain = if integrates {
                    "integrator gain"
                } else {
                    "steady-state gain"
                };
                let mut found = vec![of(
                    gain,
                    if integrates { "per s" } else { "" },
                    PropertyKind::Gain,
                    plant.gain(),
                )];
                let own = self.modes(&self.centre, poles)?;
                let here = self.modes(parameters, poles)?;
                for (number, mode) in (1..).zip(&own) {
                    let nearest = here
                        .iter()
                        .min_by(|a, b| (*a - mode).modulus().total_cmp(&(*b - mode).modulus()));
                    let s = nearest.copied().unwrap_or(*mode);
                    match mode.im {
                        0.0 => found.push(of(
                            &format!("time constant {number}"),
                            "s",
                            PropertyKind::Pole,
                            -1.0 / s.re,
                        )),
                        _ => {
                            found.push(of(
                                &format!("natural frequency {number}"),
                                "rad/s",
                                PropertyKind::Pole,
                                s.modulus(),
                            ));
                            found.push(of(
                                &format!("damping ratio {number}"),
                                "",
                                PropertyKind::Damping,
                                -s.re / s.modulus(),
                            ));
                        }
                    }
                }
                let q = polar(1.0, -frequency * plant.tick);
                let size: f64 = plant.b.iter().sum();
                let lag = -(crate::plant::backward(&plant.b, q) / size).argument() / frequency;
                let delay = plant.delay as f64 * plant.tick + lag;
                found.push(of(
                    "delay minus the lead of the zeros",
                    "s",
                    PropertyKind::Delay,
                    delay,
                ));
                Ok(found)
            }
        }
    }

    /// The poles in s, 1/s, slowest first, of a pair the upper one, without integrators and artefacts of sampling.
    fn modes(&self, parameters: &DVector<f64>, poles: usize) -> Result<Vec<Complex<f64>>> {
        let (den, _) = equation(parameters, poles);
        let roots = polynomial::roots(&den)?.into_iter();
        let kept = roots
            .filter(|z| !is_sampling_artefact(*z) && (z - 1.0).modulus() > AT_ONE && z.im >= 0.0);
        let mut modes: Vec<_> = kept
            .filter_map(|z| discrete_to_continuous(z, self.sample_time))
            .collect();
        modes.sort_by(|a, b| a.modulus().total_cmp(&b.modulus()));
        Ok(modes)
    }

    /// Checks that the sign of the gain is determined: the 95 % interval of the gain, or of `B(1)`, does not contain 0. `B(1)` is not affected by a
    /// slow pole that passes z = 1.
    ///
    /// # Errors
    /// [`TuneError::Sign`].
    pub fn check_sign(&self, sampling: &Sampling) -> Result<()> {
        let nominal = self.plant(&self.centre, sampling)?;
        let half_width = |of: &dyn Fn(&Plant) -> f64| {
            let slope = |direction: usize| {
                let moved = |by: f64| {
                    let plant = self.plant(&self.along(direction, by), sampling)?;
                    Ok::<_, TuneError>(of(&plant))
                };
                Ok::<_, TuneError>((moved(NUDGE)? - moved(-NUDGE)?) / (2.0 * NUDGE))
            };
            let slopes = (0..self.directions()).map(slope);
            let slopes = slopes.collect::<Result<Vec<f64>>>()?;
            let variance: f64 = slopes.iter().map(|it| it * it).sum();
            Ok::<_, TuneError>(SIGMAS_95 * variance.sqrt())
        };
        let size = |plant: &Plant| plant.b.iter().sum::<f64>();
        let (value, gain) = (size(&nominal), nominal.gain());
        let half = half_width(&Plant::gain)?;
        if half < gain.abs() || half_width(&size)? < value.abs() {
            return Ok(());
        }
        let interval = with_interval(gain, half);
        let what = match nominal.integrators() {
            0 => "steady-state gain",
            _ => "integrator gain",
        };
        Err(TuneError::Sign { what, interval })
    }
}

/// Whether a model was identified for an input that is linear between its samples: its numerator then has the exact factor `(1 + 1/z)/2`.
fn is_of_lines(file: &ModelFile) -> bool {
    let alternating = file.num.iter().rev().enumerate();
    let at_minus_one: f64 = alternating
        .map(|(i, b)| if i % 2 == 0 { *b } else { -b })
        .sum();
    let size: f64 = file.num.iter().map(|b| b.abs()).sum();
    file.method != "exact" && file.num.len() > 1 && at_minus_one.abs() < 1e-9 * size
}

/// The coefficients of a model of linear input, converted for the held input of a controller: the numerator without the factor `(1 + 1/z)/2`.
fn of_held_input(poles: usize, count: usize) -> DMatrix<f64> {
    let mut held = DMatrix::identity(count, count);
    for row in poles..count {
        // b'_j = 2 b_j - b'_(j-1), and none at the end.
        let before = match row > poles {
            true => held.row(row - 1).into_owned(),
            false => held.row(row) * 0.0,
        };
        let mut own = -before;
        own[row] += 2.0;
        match row + 1 == count {
            true => held.row_mut(row).fill(0.0),
            false => held.set_row(row, &own),
        }
    }
    held
}

/// The form of a file's process model, and its parameters.
fn process(file: &ModelFile) -> Option<(Form, Vec<f64>)> {
    let process = file.process.as_ref()?;
    let form = Form::ALL.into_iter().find(|it| it.name() == process.form)?;
    let values: Vec<f64> = process.parameters.iter().map(|it| it.value).collect();
    let last = values.len().checked_sub(1)?;
    let positive = values[1..last].iter().all(|it| *it > 0.0);
    (positive && values.len() == form.parameters().len()).then_some((form, values))
}

/// Gain, logarithms and dead time, their covariance, and whether correlations of the parameters are unknown.
fn process_coordinates(file: &ModelFile, values: &[f64]) -> (DVector<f64>, DMatrix<f64>, bool) {
    let last = values.len() - 1;
    let is_logarithm = |i: usize| (1..last).contains(&i);
    let coordinate = |i: usize| {
        if is_logarithm(i) {
            libm::log(values[i])
        } else {
            values[i]
        }
    };
    let slope = |i: usize| {
        if is_logarithm(i) {
            1.0 / values[i]
        } else {
            1.0
        }
    };
    let process = file.process.as_ref();
    let known = process.map(|it| &it.covariance).filter(|it| !it.is_empty());
    let deviation = |i: usize| {
        process
            .and_then(|it| it.parameters.get(i))
            .map_or(0.0, |it| it.deviation)
    };
    let covariance = DMatrix::from_fn(values.len(), values.len(), |i, j| {
        let natural = match known {
            Some(rows) => rows[i][j],
            None if i == j => deviation(i).powi(2),
            None => 0.0,
        };
        slope(i) * natural * slope(j)
    });
    let centre = DVector::from_fn(values.len(), |i, _| coordinate(i));
    let is_uncertain = covariance.iter().any(|it| *it != 0.0);
    (centre, covariance, known.is_none() && is_uncertain)
}

/// Gain, time constants and dead time; the dead time is at least 0.
fn natural(coordinates: &DVector<f64>) -> Vec<f64> {
    let last = coordinates.len() - 1;
    let each = coordinates.iter().enumerate();
    each.map(|(i, value)| match i {
        0 => *value,
        i if i == last => value.max(0.0),
        _ => libm::exp(*value),
    })
    .collect()
}

fn process_transfer(form: Form, coordinates: &DVector<f64>) -> Result<(TransferFunction, f64)> {
    let values = DVector::from_vec(natural(coordinates));
    let count = values.len();
    let model = ProcessModel {
        form,
        values,
        covariance: DMatrix::zeros(count, count),
        sought: count,
    };
    let (num, den, delay) = model.transfer();
    Ok((TransferFunction::new(num, den)?, delay))
}

/// Denominator and numerator in z.
fn equation(parameters: &DVector<f64>, poles: usize) -> (Vec<f64>, &[f64]) {
    let all = parameters.as_slice();
    (
        std::iter::once(1.0)
            .chain(all[..poles].iter().copied())
            .collect(),
        &all[poles..],
    )
}

/// `F` with `F F'` the covariance; a column for each direction that is not rounding error.
pub(crate) fn factor(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let used: Vec<usize> = (0..covariance.nrows())
        .filter(|i| covariance[(*i, *i)] > 0.0)
        .collect();
    let among = |i: usize, j: usize| covariance[(used[i], used[j])];
    if used.is_empty() {
        return DMatrix::zeros(covariance.nrows(), 0);
    }
    // Scaled, so that a small coefficient is no rounding beside a large one.
    let scale: Vec<f64> = used.iter().map(|i| covariance[(*i, *i)].sqrt()).collect();
    let correlation = DMatrix::from_fn(used.len(), used.len(), |i, j| {
        among(i, j) / scale[i] / scale[j]
    });
    let eigen = correlation.symmetric_eigen();
    let largest = eigen
        .eigenvalues
        .iter()
        .fold(0.0_f64, |most, it| most.max(*it));
    let kept: Vec<usize> = (0..used.len())
        .filter(|k| eigen.eigenvalues[*k] > ROUNDING * largest)
        .collect();
    let mut factor = DMatrix::zeros(covariance.nrows(), kept.len());
    for (column, k) in kept.iter().enumerate() {
        let size = eigen.eigenvalues[*k].sqrt();
        for (i, row) in used.iter().enumerate() {
            factor[(*row, column)] = scale[i] * eigen.eigenvectors[(i, *k)] * size;
        }
    }
    factor
}
