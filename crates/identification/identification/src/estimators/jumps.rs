//! Detects jumps in the parameters of a recursion.
//!
//! Three further recursions that started later run in parallel with the main one, which remembers all rows. Each recursion is compared with the main
//! one by the test for a change of regression (Chow, *Econometrica* 28, 1960):
//! ```text
//! S = (V_all - V_before - V_since) / s2
//! ```
//! `V` are sums of squared residuals: of all rows, of the rows before the later start, and of the rows after it. `s2` is the noise's variance.
//! Without a jump S follows the chi-square distribution with as many degrees of freedom as parameters, p; it stays below `p + 2 sqrt(p x) + 2 x` with
//! a probability of at least `1 - exp(-x)` (Laurent and Massart, *Annals of Statistics* 28, 2000). If S exceeds this bound, the recursion with the
//! later start takes over: everything before its start is forgotten, and no row after it is lost.
//!
//! - **Starts.** One recursion starts when the prediction errors begin to grow: when the cumulative sum of the log-likelihood ratio of a
//!   larger variance leaves zero (Page, *Biometrika* 41, 1954). This recursion finds large jumps at once. Two others start every 64 and every 256
//!   rows. These recursions find small jumps and drift.
//! - **Noise.** `s2` is the larger of two variances: of the rows before and after, and of the rows after alone. So an increase of the noise does not
//!   count as a jump. `s2` is at least 0.5 % of the output's changes from sample to sample: so a nonlinearity of that size does not count as a jump.
//! - **Coloured residuals** make S larger than this distribution. So S is divided by its usual mean at the end of a window, over p, if that
//!   is above 1.
//! - **Outliers.** A single error counts as at most three standard deviations in the cumulative sum.

use nalgebra::DVector;

use crate::rls::RecursiveLeastSquares;

/// `x`: the negative logarithm of the false-alarm probability in one test of Gaussian residuals.
const RARITY: f64 = 16.0;
/// Windows, rows.
const PERIODS: [u64; 2] = [64, 256];
/// Minimum number of rows per parameter before a model is compared.
const ROWS_PER_PARAMETER: f64 = 2.0;
/// Ratio of the larger variance in the cumulative sum's test to the noise's variance.
const RATIO: f64 = 4.0;
/// The cumulative sum above which errors count as grown.
const GROWN: f64 = 5.0;
/// Errors are limited to this size, in standard deviations.
const LARGEST: f64 = 3.0;
/// The smallest noise, over the root mean square of the output's changes.
const LEAST_NOISE: f64 = 0.005;
/// The initial number of windows in the usual statistic, at 1 per parameter, and the weight of a window after each later one.
const FIRST_WINDOWS: f64 = 3.0;
const FADING: f64 = 0.95;

/// A recursion with a later start.
#[derive(Clone, Debug)]
struct Challenger {
    rls: RecursiveLeastSquares,
    /// `V_before`, output unit squared.
    cost_before: f64,
    /// S at the last row; `None` with too few rows before or after.
    statistic: Option<f64>,
    /// Sum of S / p over past windows, and their number, both with forgetting.
    usual: f64,
    windows: f64,
}

impl Challenger {
    fn new(rls: &RecursiveLeastSquares) -> Self {
        Self {
            rls: rls.clone(),
            cost_before: 0.0,
            statistic: None,
            usual: FIRST_WINDOWS,
            windows: FIRST_WINDOWS,
        }
    }

    /// Ends a window without a jump. Values above `limit` do not count as usual.
    fn end_window(&mut self, limit: f64) {
        if let Some(statistic) = self.statistic {
            self.usual = FADING * self.usual + statistic.min(limit) / self.rls.size() as f64;
            self.windows = FADING * self.windows + 1.0;
        }
    }

    /// Starts at `theta`, after the rows of `all`.
    fn start(&mut self, all: &RecursiveLeastSquares, theta: &DVector<f64>) {
        self.rls.restart_about(theta);
        self.cost_before = all.cost();
        self.statistic = None;
    }

    /// Takes a row that `all` has processed.
    fn update(
        &mut self,
        all: &RecursiveLeastSquares,
        row: &[f64],
        output: f64,
        forgetting: f64,
        least: f64,
    ) {
        // Every lambda here lies in (0, 1].
        let _ = self.rls.set_forgetting(forgetting);
        self.rls.update(row, output);
        self.cost_before *= forgetting;
        let p = self.rls.size() as f64;
        let enough = ROWS_PER_PARAMETER * p;
        let is_enough =
            self.rls.rows() as f64 >= enough && all.weight() - self.rls.weight() > enough;
        let since = self.rls.cost();
        let variance = (since / (self.rls.weight() - p))
            .max((self.cost_before + since) / (all.weight() - 2.0 * p))
            .max(least);
        self.statistic = (is_enough && variance > 0.0)
            .then(|| (all.cost() - self.cost_before - since) / variance);
    }

    /// S relative to its usual value.
    fn surprise(&self) -> f64 {
        let usual = (self.usual / self.windows).max(1.0);
        self.statistic.map_or(0.0, |it| it / usual)
    }
}

/// Watches a recursion for jumps.
#[derive(Clone, Debug)]
pub(super) struct JumpDetector {
    /// The recursion of the cumulative sum, followed by the recursions of [`PERIODS`].
    challengers: [Challenger; 3],
    /// The cumulative sum.
    sum: f64,
    /// Rows taken.
    rows: u64,
    /// The last output, and the mean square of its changes.
    last: f64,
    change: f64,
    /// The limit of S.
    limit: f64,
}

impl JumpDetector {
    /// A detector for a recursion before its first row.
    pub(super) fn new(rls: &RecursiveLeastSquares) -> Self {
        let p = rls.size() as f64;
        let mut challenger = Challenger::new(rls);
        challenger.rls.reset();
        Self {
            challengers: [challenger.clone(), challenger.clone(), challenger],
            sum: 0.0,
            rows: 0,
            last: 0.0,
            change: 0.0,
            limit: p + 2.0 * (p * RARITY).sqrt() + 2.0 * RARITY,
        }
    }

    /// Adds a row to `rls`, whose parameters are `theta` and whose prediction error is `error`. After a jump, returns the number of rows on
    /// which the estimate is now based.
    pub(super) fn update(
        &mut self,
        rls: &mut RecursiveLeastSquares,
        theta: &DVector<f64>,
        row: &[f64],
        output: f64,
        error: f64,
        forgetting: f64,
    ) -> Option<u64> {
        if self.rows > 0 {
            let squared = (output - self.last).powi(2);
            self.change += (squared - self.change) / self.rows as f64;
        }
        self.last = output;
        let least = LEAST_NOISE.powi(2) * self.change;
        if self.sum == 0.0 {
            self.challengers[0].end_window(self.limit);
            self.challengers[0].start(rls, theta);
        }
        for (challenger, period) in self.challengers[1..].iter_mut().zip(PERIODS) {
            if self.rows.is_multiple_of(period) {
                challenger.end_window(self.limit);
                challenger.start(rls, theta);
            }
        }
        self.rows += 1;
        self.sum = (self.sum + growth(rls, row, error, least)).max(0.0);
        let _ = rls.set_forgetting(forgetting);
        rls.update(row, output);
        for challenger in &mut self.challengers {
            challenger.update(rls, row, output, forgetting, least);
        }
        let candidates = &self.challengers[usize::from(self.sum <= GROWN)..];
        let surprising = candidates
            .iter()
            .max_by(|one, other| one.surprise().total_cmp(&other.surprise()))
            .filter(|it| it.surprise() > self.limit)?;
        let since = surprising.rls.rows();
        rls.take_over(&surprising.rls);
        self.sum = 0.0;
        let theta = rls.parameters();
        for challenger in &mut self.challengers {
            challenger.start(rls, &theta);
        }
        Some(since)
    }
}

/// The log-likelihood ratio of a larger variance, for one error.
fn growth(rls: &RecursiveLeastSquares, row: &[f64], error: f64, least: f64) -> f64 {
    let is_learnt = rls.weight() > ROWS_PER_PARAMETER * rls.size() as f64;
    let variance = rls.noise_variance().filter(|_| is_learnt).unwrap_or(0.0);
    let variance = variance.max(least) * (1.0 + rls.leverage(row));
    let normalised = match is_learnt && variance > 0.0 {
        true => (error * error / variance).min(LARGEST * LARGEST),
        false => 0.0,
    };
    0.5 * ((1.0 - 1.0 / RATIO) * normalised - libm::log(RATIO))
}
