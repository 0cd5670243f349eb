//! A transfer function in s, fitted to samples at their original stamps by output error, without resampling.
//!
//! ```text
//! y = B(s)/A(s) e^(-tau s) (u - u0) + M(s)/A(s) impulse + offset,     A = s^n + d_(n-1) s^(n-1) + ... + d_0
//! xi_k = s^k/A e^(-tau s) (u - u0),   psi_k = s^k/A impulse,   eta_k = s^k/A (y - offset)
//! dy/db_k = xi_k,   dy/dm_k = psi_k,   dy/dd_k = -eta_k,   dy/dtau = -dy_u/dt + h(t) (u - u0)(-tau)
//! ```
//! `M` is the initial free motion of a run, `u0` the input's first value, `y_u` the response to the input, `h = sum b_k psi_k` the impulse
//! response. The search begins with least squares on filtered signals (state variable filters; Young 1981; Garnier and Wang,
//! *Identification of Continuous-time Models from Sampled Data*, 2008, ch. 1).

use nalgebra::{DMatrix, DVector};
use planesman_identification::analysis::{GOOD, SAMPLES_PER_PARAMETER, USABLE, Verdict};
use planesman_identification::estimators::{Search, Total, coloured_covariance, least};
use planesman_identification::{IdentificationError, Uncertain, least_squares, stop_point};
use planesman_linear::{ComplexFunctions as _, polynomial};
use planesman_text::{option, setting};

use crate::chains::{Chains, Signal};
use crate::error::EquationsError;
use crate::fit::{FITTED, fit_of, informative, mean_square, verdict_text};
use crate::simulation::{Between, Run};

/// Orders tried if no order is given.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=4;
/// A larger order is chosen if it improves the held-out fit by this much, %.
const WORTH: f64 = 0.5;
/// Number of filters at which searches begin, delays in usual intervals, and number of searches without a delay.
const FILTERS: usize = 7;
const DELAYS: [f64; 8] = [0.0, 0.5, 1.5, 3.0, 6.0, 12.0, 25.0, 50.0];
const STARTS: usize = 3;
const SEARCH: Search = Search {
    steps: 60,
    enough: 1e-11,
    radius: f64::INFINITY,
};

/// Options of the fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct TransferOptions {
    /// Number of poles; with `None` the lowest order that is nearly as good as the best of orders 1 to 4.
    pub order: Option<usize>,
    /// Number of numerator coefficients; `None` to choose between one and the number of poles.
    pub numerator: Option<usize>,
    /// Whether the dead time is 0.
    pub no_delay: bool,
    /// Whether the offset is 0.
    pub no_offset: bool,
    /// Whether the data begins at rest, with the input 0 before the first sample.
    pub at_rest: bool,
}

/// A transfer function in s.
#[derive(Clone, Debug)]
pub struct TransferFit {
    /// `d_0 ... d_(n-1), b_0 ... b_m`, then the dead time, s, if estimated.
    pub parameters: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Poles.
    pub order: usize,
    /// Coefficients of the numerator.
    pub numerator: usize,
    /// The upper limit of the search for the dead time, s; `None` if it was not estimated.
    pub longest_delay: Option<f64>,
    /// Whether the dead time is at 0, or at the upper limit.
    pub is_delay_at_bound: bool,
    /// The offset of each run: the output at an input of 0, for a model that settles.
    pub offsets: Vec<f64>,
    /// Simulated output of each run.
    pub simulated: Vec<Vec<f64>>,
    /// Fit on all data, %.
    pub fit: Option<f64>,
    /// Fit on data not used for fitting, %.
    pub held_out_fit: Option<f64>,
    /// Root mean square of the residual.
    pub left: f64,
    /// Samples.
    pub samples: usize,
    /// Tried orders and numbers of numerator coefficients, with their held-out fit, %.
    pub tried: Vec<(usize, usize, Option<f64>)>,
    /// Whether separate validation data was given.
    pub is_validated: bool,
    /// The verdict.
    pub verdict: Verdict,
}

impl TransferFit {
    /// `1, d_(n-1) ... d_0`.
    #[must_use]
    pub fn denominator(&self) -> Vec<f64> {
        let low_first = self.parameters[..self.order].iter().rev();
        std::iter::once(1.0).chain(low_first.copied()).collect()
    }

    /// The numerator, highest power first.
    #[must_use]
    pub fn numerator(&self) -> Vec<f64> {
        let of = &self.parameters[self.order..self.order + self.numerator];
        of.iter().rev().copied().collect()
    }

    /// The dead time and its standard deviation, s; 0 if it was not estimated.
    #[must_use]
    pub fn delay(&self) -> (f64, f64) {
        let at = self.order + self.numerator;
        match self.parameters.get(at) {
            Some(delay) => (*delay, self.covariance[(at, at)].max(0.0).sqrt()),
            None => (0.0, 0.0),
        }
    }

    /// The verdict, and the next step with a transfer function in s.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        if self.verdict == Verdict::ParametersUndetermined {
            return self.verdict.text(format!(
                "the data cannot separate dead time and zeros. Use fewer coefficients ({}), or no dead time ({})",
                setting("numerator", 1),
                setting("delay", 0)
            ));
        }
        verdict_text(
            self.verdict,
            format!(
                "write plots of the fit with {}. Leave out {} to get a sampled model, which simulator and controller need",
                setting("html", "model.html"),
                option("continuous")
            ),
            format!(
                "look at the plots to see where the fit fails: {}. Then try another {}, or your own equations: {}",
                setting("html", "model.html"),
                option("order"),
                setting("equations", "FILE")
            ),
        )
    }

    /// The poles, 1/s, slowest first; one pole of each complex pair.
    ///
    /// # Errors
    /// If they cannot be computed.
    pub fn poles(&self) -> Result<Vec<Uncertain>, EquationsError> {
        let denominator = self.denominator();
        let derivative = polynomial::derivative(&denominator);
        let roots = polynomial::roots(&denominator).map_err(IdentificationError::from)?;
        let covariance = self.covariance.view((0, 0), (self.order, self.order));
        let mut poles: Vec<Uncertain> = roots
            .into_iter()
            .filter(|it| it.im >= 0.0)
            .map(|value| {
                // dp/dd_k = -p^k / A'(p)
                let slope = -polynomial::evaluate(&derivative, value).inv();
                let slopes = DMatrix::from_fn(2, self.order, |part, k| {
                    let of = slope * value.powi(k as i32);
                    if part == 0 { of.re } else { of.im }
                });
                let of = &slopes * covariance * slopes.transpose();
                Uncertain {
                    value,
                    covariance: of.fixed_view::<2, 2>(0, 0).into_owned(),
                }
            })
            .collect();
        poles.sort_by(|p, q| p.value.modulus().total_cmp(&q.value.modulus()));
        Ok(poles)
    }

    /// The steady-state gain `b_0/d_0` and its standard deviation.
    #[must_use]
    pub fn gain(&self) -> (f64, f64) {
        let (d, b) = (self.parameters[0], self.parameters[self.order]);
        let mut slopes = DVector::zeros(self.parameters.len());
        slopes[0] = -b / (d * d);
        slopes[self.order] = 1.0 / d;
        let variance = (slopes.transpose() * &self.covariance * &slopes)[(0, 0)];
        (b / d, variance.max(0.0).sqrt())
    }
}

/// The runs and their unknowns.
struct Problem<'a> {
    runs: &'a [Run],
    options: TransferOptions,
    n: usize,
    m: usize,
    longest_delay: f64,
}

impl Problem<'_> {
    fn signal<'b>(&self, run: &'b Run, delay: f64) -> Signal<'b> {
        let track = &run.inputs[0];
        let first = track.values.first().copied().unwrap_or(0.0);
        let known = self.options.at_rest || self.options.no_offset;
        Signal {
            track,
            between: run.between,
            reference: if known { 0.0 } else { first },
            before: if self.options.at_rest { 0.0 } else { first },
            delay,
        }
    }

    /// Number of the model's parameters.
    fn common(&self) -> usize {
        self.n + self.m + usize::from(!self.options.no_delay)
    }

    fn own(&self) -> usize {
        usize::from(!self.options.no_offset) + if self.options.at_rest { 0 } else { self.n }
    }

    fn count(&self) -> usize {
        self.common() + self.runs.len() * self.own()
    }

    fn delay(&self, theta: &DVector<f64>) -> f64 {
        match self.options.no_delay {
            true => 0.0,
            false => theta[self.n + self.m],
        }
    }

    fn is_at_bound(&self, theta: &DVector<f64>) -> bool {
        let delay = self.delay(theta);
        !self.options.no_delay && (delay <= 0.0 || delay >= self.longest_delay)
    }

    /// Offset and initial free motion of a run.
    fn of_run(&self, theta: &DVector<f64>, run: usize) -> (f64, Vec<f64>) {
        let first = self.common() + run * self.own();
        let free = first + usize::from(!self.options.no_offset);
        let offset = if self.options.no_offset {
            0.0
        } else {
            theta[first]
        };
        match self.options.at_rest {
            true => (offset, vec![0.0; self.n]),
            false => (offset, theta.as_slice()[free..free + self.n].to_vec()),
        }
    }

    /// Simulated outputs, one run below the other, and their slopes on request.
    fn simulated(
        &self,
        theta: &DVector<f64>,
        with_slopes: bool,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        stop_point();
        let (n, m) = (self.n, self.m);
        let rows: usize = self.runs.iter().map(|it| it.outputs[0].times.len()).sum();
        let mut values = DVector::zeros(rows);
        let mut slopes = DMatrix::zeros(if with_slopes { rows } else { 0 }, self.count());
        let (d, b) = (&theta.as_slice()[..n], &theta.as_slice()[n..n + m]);
        let delay = self.delay(theta);
        let mut first = 0;
        for (number, run) in self.runs.iter().enumerate() {
            let (offset, motion) = self.of_run(theta, number);
            let chains = Chains {
                d,
                b,
                m: &motion,
                with_slopes,
            };
            let signal = self.signal(run, delay);
            // The input that acts at the begin is of the past, and moves with the dead time.
            let (at_begin, _) = signal.at(0.0);
            let own = self.common() + number * self.own();
            let dot = |of: &[f64], z: &[f64]| of.iter().zip(z).map(|(a, b)| a * b).sum::<f64>();
            chains.through(run, &signal, &mut |k, z| {
                let row = first + k;
                values[row] = offset + dot(b, &z[..n]) + dot(&motion, &z[n..2 * n]);
                if !with_slopes {
                    return;
                }
                let mut put = |at: usize, value: f64| slopes[(row, at)] = value;
                for i in 0..n {
                    put(i, -z[2 * n + i]);
                }
                for (i, xi) in z[..m].iter().enumerate() {
                    put(n + i, *xi);
                }
                if !self.options.no_delay {
                    let last = z[3 * n] - dot(d, &z[..n]);
                    let rates = z[1..n].iter().copied().chain([last]).collect::<Vec<f64>>();
                    put(n + m, dot(b, &z[n..2 * n]) * at_begin - dot(b, &rates));
                }
                let mut at = own;
                if !self.options.no_offset {
                    put(at, 1.0);
                    at += 1;
                }
                if !self.options.at_rest {
                    for i in 0..n {
                        put(at + i, z[n + i]);
                    }
                }
            })?;
            first += run.outputs[0].times.len();
        }
        values
            .iter()
            .all(|it| it.is_finite())
            .then_some((values, slopes))
    }

    fn measured(&self) -> DVector<f64> {
        let values = self
            .runs
            .iter()
            .flat_map(|it| it.outputs[0].values.iter().copied());
        DVector::from_vec(values.collect())
    }

    fn total(&self, measured: &DVector<f64>, theta: &DVector<f64>) -> Option<Total> {
        let (values, slopes) = self.simulated(theta, true)?;
        let errors = measured - values;
        let mut total = Total {
            information: slopes.tr_mul(&slopes),
            gradient: slopes.tr_mul(&errors),
            cost: errors.norm_squared(),
        };
        if !self.options.no_delay {
            let at = self.n + self.m;
            let leaves = theta[at] <= 0.0 && total.gradient[at] < 0.0
                || theta[at] >= self.longest_delay && total.gradient[at] > 0.0;
            if leaves {
                total.information.row_mut(at).fill(0.0);
                total.information.column_mut(at).fill(0.0);
                total.gradient[at] = 0.0;
            }
        }
        let is_finite = total.cost.is_finite() && total.information.iter().all(|it| it.is_finite());
        is_finite.then_some(total)
    }

    fn minimised(&self, start: DVector<f64>) -> Option<(DVector<f64>, f64)> {
        let measured = self.measured();
        let within = |mut theta: DVector<f64>| {
            if !self.options.no_delay {
                let at = self.n + self.m;
                theta[at] = theta[at].clamp(0.0, self.longest_delay);
            }
            Some(theta)
        };
        least(
            start,
            SEARCH,
            &|theta| self.total(&measured, theta),
            &within,
        )
    }

    /// The denominator from least squares on signals filtered by `1/(s + omega)^n`.
    fn denominator(&self, omega: f64, delay: f64) -> Option<Vec<f64>> {
        let n = self.n;
        let d = repeated(omega, n);
        let mut rows = Vec::new();
        for (number, run) in self.runs.iter().enumerate() {
            let chains = Chains {
                d: &d,
                b: &[],
                m: &[],
                with_slopes: false,
            };
            let mut columns: Vec<Vec<f64>> = Vec::new();
            chains.through(run, &self.signal(run, delay), &mut |_, z| {
                columns.push(z[..2 * n].to_vec())
            })?;
            let output = Signal {
                track: &run.outputs[0],
                between: Between::Lines,
                reference: 0.0,
                before: 0.0,
                delay: 0.0,
            };
            let mut number_of_row = 0;
            chains.through(run, &output, &mut |_, z| {
                let mut row: Vec<f64> = z[..n].iter().map(|it| -it).collect();
                let of = &columns[number_of_row];
                row.extend(&of[..self.m]);
                for other in 0..self.runs.len() {
                    let own = other == number;
                    row.extend(of[n..2 * n].iter().map(|it| if own { *it } else { 0.0 }));
                    row.push(f64::from(u8::from(own)));
                }
                let highest = z[2 * n] - d.iter().zip(&z[..n]).map(|(a, b)| a * b).sum::<f64>();
                rows.push((row, highest));
                number_of_row += 1;
            })?;
        }
        let found = least_squares(&rows).ok()?;
        Some(found.as_slice()[..n].to_vec())
    }

    /// With a given denominator and dead time, computes the other parameters by least squares.
    fn completed(&self, d: &[f64], delay: f64) -> Option<(DVector<f64>, f64)> {
        let mut theta = DVector::zeros(self.count());
        theta.rows_mut(0, self.n).copy_from_slice(d);
        if !self.options.no_delay {
            theta[self.n + self.m] = delay;
        }
        let (_, slopes) = self.simulated(&theta, true)?;
        let linear: Vec<usize> = (self.n..self.n + self.m)
            .chain(self.common()..self.count())
            .collect();
        let columns = slopes.select_columns(&linear);
        let lengths: Vec<f64> = columns
            .column_iter()
            .map(|it| it.norm().max(1e-300))
            .collect();
        let scaled = DMatrix::from_fn(columns.nrows(), lengths.len(), |i, j| {
            columns[(i, j)] / lengths[j]
        });
        let measured = self.measured();
        let solved = scaled.svd(true, true).solve(&measured, 1e-10).ok()?;
        for (j, at) in linear.iter().enumerate() {
            theta[*at] = solved[j] / lengths[j];
        }
        let (values, _) = self.simulated(&theta, false)?;
        let cost = (measured - values).norm_squared();
        cost.is_finite().then_some((theta, cost))
    }

    fn start(&self, interval: f64) -> Vec<DVector<f64>> {
        let longest = self.runs.iter().map(Run::end).fold(0.0, f64::max);
        let (slow, fast) = (4.0 / longest, 1.0 / interval);
        let mut found: Vec<DVector<f64>> = Vec::new();
        for delay in DELAYS.iter().map(|it| it * interval) {
            if delay > self.longest_delay || self.options.no_delay && delay > 0.0 {
                break;
            }
            let mut of_delay: Vec<(DVector<f64>, f64)> = Vec::new();
            for filter in 0..FILTERS {
                let omega = slow * libm::pow(fast / slow, filter as f64 / (FILTERS - 1) as f64);
                let both = [
                    self.denominator(omega, delay),
                    Some(repeated(omega, self.n)),
                ];
                let both = both.into_iter().flatten();
                of_delay.extend(both.filter_map(|d| self.completed(&d, delay)));
            }
            of_delay.sort_by(|p, q| p.1.total_cmp(&q.1));
            // A dead time that is far off has its own minimum: each is searched from.
            let count = if self.options.no_delay { STARTS } else { 1 };
            found.extend(of_delay.into_iter().take(count).map(|it| it.0));
        }
        found
    }
}

/// `d_0 ... d_(n-1)` of `(s + omega)^n`.
fn repeated(omega: f64, n: usize) -> Vec<f64> {
    let mut d = vec![1.0];
    for _ in 0..n {
        let mut next = vec![0.0; d.len() + 1];
        for (k, value) in d.iter().enumerate() {
            next[k] += omega * value;
            next[k + 1] += value;
        }
        d = next;
    }
    d.truncate(n);
    d
}

/// The transfer function from one input to one output. The result is validated on `validation`, with an offset and a free motion estimated
/// for each run; without separate data, a model of the first 70 % of each run is validated on the rest.
///
/// # Errors
/// [`EquationsError`]: too little data, an output that does not move, or no model that is simulated at all.
pub fn fit_transfer(
    runs: &[Run],
    validation: &[Run],
    options: TransferOptions,
) -> Result<TransferFit, EquationsError> {
    let all = runs.iter().flat_map(|it| it.outputs[0].values.iter());
    let (least, most) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| {
        (a.min(*y), b.max(*y))
    });
    if least == most {
        return Err(EquationsError::Constant("the output".to_owned()));
    }
    let orders = options.order.map_or(ORDERS, |it| it..=it);
    // A zero beside a dead time does nearly the same: without one first.
    let numerators = |n: usize| match options.numerator {
        Some(given) => vec![given.min(n)],
        None if n == 1 => vec![1],
        None => vec![1, n],
    };
    let mut found: Vec<TransferFit> = Vec::new();
    let mut refusal = None;
    for order in orders {
        for numerator in numerators(order) {
            let options = TransferOptions {
                numerator: Some(numerator),
                ..options
            };
            match of_order(runs, validation, options, order) {
                Ok(fit) => found.push(fit),
                Err(error) => refusal = Some(error),
            }
        }
    }
    let held = |it: &TransferFit| it.held_out_fit.unwrap_or(f64::NEG_INFINITY);
    let best = found.iter().map(held).fold(f64::NEG_INFINITY, f64::max);
    let tried = found
        .iter()
        .map(|it| (it.order, it.numerator, it.held_out_fit));
    let tried: Vec<(usize, usize, Option<f64>)> = tried.collect();
    let chosen = found.into_iter().find(|it| held(it) >= best - WORTH);
    match (chosen, refusal) {
        (Some(chosen), _) if tried.len() == 1 => Ok(chosen),
        (Some(chosen), _) => Ok(TransferFit { tried, ..chosen }),
        (None, Some(refusal)) => Err(refusal),
        (None, None) => Err(EquationsError::NoEffect),
    }
}

fn of_order(
    runs: &[Run],
    validation: &[Run],
    options: TransferOptions,
    n: usize,
) -> Result<TransferFit, EquationsError> {
    let times = runs.iter().map(|it| &it.outputs[0].times);
    let mut intervals: Vec<f64> = times
        .flat_map(|it| it.windows(2).map(|it| it[1] - it[0]))
        .collect();
    intervals.sort_by(f64::total_cmp);
    let interval = intervals.get(intervals.len() / 2).copied().unwrap_or(1.0);
    let longest = runs.iter().map(Run::end).fold(0.0, f64::max);
    let problem = Problem {
        runs,
        options,
        n,
        m: options.numerator.unwrap_or(n).min(n),
        longest_delay: (DELAYS[DELAYS.len() - 1] * interval).min(0.25 * longest),
    };
    let samples = problem.measured().len();
    if samples <= problem.count() {
        return Err(EquationsError::TooFew {
            samples,
            sought: problem.count(),
        });
    }
    let starts = problem.start(interval).into_iter();
    let ends = starts.filter_map(|start| problem.minimised(start));
    let (theta, _) = ends
        .min_by(|p, q| p.1.total_cmp(&q.1))
        .ok_or(EquationsError::NoEffect)?;
    let (values, mut slopes) = problem
        .simulated(&theta, true)
        .ok_or(EquationsError::NoEffect)?;
    let errors = problem.measured() - &values;
    let of_runs = |all: &DVector<f64>| -> Vec<Vec<f64>> {
        let mut rest = all.as_slice();
        let own = |run: &Run| {
            let (own, others) = rest.split_at(run.outputs[0].times.len());
            rest = others;
            own.to_vec()
        };
        runs.iter().map(own).collect()
    };
    let (residuals, simulated) = (of_runs(&errors), of_runs(&values));
    let is_at_bound = problem.is_at_bound(&theta);
    if is_at_bound {
        slopes.column_mut(n + problem.m).fill(0.0);
    }
    let covariance = covariance(slopes, &residuals)?;
    let common = problem.common();
    let pairs = |x: &[Vec<f64>]| {
        fit_of(
            runs.iter()
                .zip(x)
                .map(|(run, x)| (&run.outputs[0].values[..], &x[..])),
        )
    };
    let left = mean_square(errors.as_slice()).sqrt();
    let held_out_fit = held_out(&problem, validation, &theta, left);
    let offsets = (0..runs.len()).map(|run| {
        let reference = problem.signal(&runs[run], 0.0).reference;
        problem.of_run(&theta, run).0 - theta[n] / theta[0] * reference
    });
    let mut found = TransferFit {
        parameters: theta.as_slice()[..common].to_vec(),
        covariance: covariance.view((0, 0), (common, common)).into_owned(),
        order: n,
        numerator: problem.m,
        longest_delay: (!options.no_delay).then_some(problem.longest_delay),
        is_delay_at_bound: is_at_bound,
        offsets: offsets.collect(),
        fit: pairs(&simulated),
        simulated,
        held_out_fit,
        left,
        samples,
        tried: Vec::new(),
        is_validated: !validation.is_empty(),
        verdict: Verdict::Good,
    };
    // Dead time and numerator may stand in for each other.
    let of_delay = n + problem.m;
    let is_delay_known =
        options.no_delay || found.covariance[(of_delay, of_delay)].sqrt() < problem.longest_delay;
    found.verdict = match found.held_out_fit {
        None => Verdict::NotValidated,
        Some(_) if samples < SAMPLES_PER_PARAMETER * problem.count() => Verdict::FewSamples,
        Some(held) if held < USABLE => Verdict::Unusable,
        Some(_) if !is_delay_known => Verdict::ParametersUndetermined,
        Some(held) if held < GOOD => Verdict::Usable,
        Some(_) => Verdict::Good,
    };
    Ok(found)
}

/// The covariance of all parameters, for residuals of any colour. A parameter without slopes has zero covariance.
fn covariance(
    slopes: DMatrix<f64>,
    residuals: &[Vec<f64>],
) -> Result<DMatrix<f64>, EquationsError> {
    let (rows, count) = slopes.shape();
    let lengths: Vec<f64> = slopes.column_iter().map(|it| it.norm()).collect();
    let active: Vec<usize> = (0..count).filter(|it| lengths[*it] > 0.0).collect();
    let scaled = DMatrix::from_fn(rows, active.len(), |k, j| {
        slopes[(k, active[j])] / lengths[active[j]]
    });
    let inverse = scaled
        .qr()
        .r()
        .try_inverse()
        .ok_or(EquationsError::NoEffect)?;
    let mut unit = DMatrix::zeros(count, active.len());
    for (row, i) in active.iter().enumerate() {
        unit.row_mut(*i)
            .copy_from(&(inverse.row(row) / lengths[*i]));
    }
    let squares: f64 = residuals.iter().flatten().map(|it| it * it).sum();
    let variance = squares / (rows - active.len()).max(1) as f64;
    Ok(coloured_covariance(&unit, slopes, residuals, variance))
}

/// The fit on data not used for fitting, %.
fn held_out(
    problem: &Problem<'_>,
    validation: &[Run],
    theta: &DVector<f64>,
    left: f64,
) -> Option<f64> {
    let of = |runs: &[Run], values: &DVector<f64>, skip: &[usize]| {
        let mut first = 0;
        let each = runs.iter().zip(skip).map(|(run, skip)| {
            let measured = &run.outputs[0].values[..];
            let x = &values.as_slice()[first..first + measured.len()];
            first += measured.len();
            (&measured[*skip..], &x[*skip..])
        });
        informative(left, each.collect::<Vec<_>>().into_iter())
    };
    if validation.is_empty() {
        let parts: Vec<Run> = problem
            .runs
            .iter()
            .map(|it| it.until(FITTED * it.end()))
            .collect();
        let first = Problem {
            runs: &parts,
            ..*problem
        };
        if first.measured().len() <= first.count() {
            return None;
        }
        let (theta, _) = first.minimised(theta.clone())?;
        let (values, _) = problem.simulated(&theta, false)?;
        let skip: Vec<usize> = parts.iter().map(|it| it.outputs[0].times.len()).collect();
        return of(problem.runs, &values, &skip);
    }
    let other = Problem {
        runs: validation,
        ..*problem
    };
    // Offset and free motion enter linearly; the numerator is held by what the model's part leaves.
    let mut moved = DVector::zeros(other.count());
    let common = problem.common();
    moved.rows_mut(0, common).copy_from(&theta.rows(0, common));
    let (values, slopes) = other.simulated(&moved, true)?;
    let own: Vec<usize> = (common..other.count()).collect();
    if !own.is_empty() {
        let left = other.measured() - values;
        let solved = slopes
            .select_columns(&own)
            .svd(true, true)
            .solve(&left, 1e-12)
            .ok()?;
        moved.rows_mut(common, own.len()).copy_from(&solved);
    }
    let (values, _) = other.simulated(&moved, false)?;
    of(validation, &values, &vec![0; validation.len()])
}
