//! The estimates of an identifier, live in the terminal: the view of `planesman sysid watch` and `sysid --watch`.
//!
//! On a terminal the view is drawn anew a few times a second; elsewhere each estimate is a line.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use console::Term;
use nalgebra::{Complex, DMatrix, DVector};
use planesman_identification::estimators::{Error, Estimate};
use planesman_identification::{IdentificationError, Layout, Reading, Structure, Uncertain};
use planesman_linear::{pair_text, pole_text};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_text::shown;

use crate::sparkline::sparkline;

/// Time between two drawings.
pub const DRAW: Duration = Duration::from_millis(250);

/// Estimates whose fit and pole are shown.
const COURSE: usize = 40;

/// Pairs that are shown; any publisher may name more.
const PAIRS: usize = 64;

/// The terminal, or what stands in its place.
#[derive(Debug)]
pub struct Screen {
    term: Term,
    view: View,
    /// Lines drawn.
    drawn: usize,
}

impl Screen {
    /// An empty screen on stdout.
    #[must_use]
    pub fn new() -> Self {
        let screen = Self {
            term: Term::buffered_stdout(),
            view: View::default(),
            drawn: 0,
        };
        if screen.is_drawn() {
            // A terminal that cannot hide its cursor is still one.
            let _ = screen.term.hide_cursor();
        }
        screen
    }

    /// Whether it is a terminal, on which the log would be in the way.
    #[must_use]
    pub fn is_drawn(&self) -> bool {
        self.term.is_term()
    }

    /// Takes an estimate; without a terminal it is printed at once.
    pub fn take(&mut self, model: &ModelEstimate) {
        if !self.is_drawn() {
            // A closed stdout is no reason to stop.
            let _ = self.term.write_line(&shown(line(model)).to_string());
            let _ = self.term.flush();
        }
        self.view.take(model);
    }

    /// Draws the view below a heading, in place of the last one.
    pub fn draw(&mut self, heading: &str) {
        if !self.is_drawn() {
            return;
        }
        let (height, width) = self.term.size();
        let mut lines = vec![heading.to_owned()];
        lines.extend(self.view.lines());
        lines.truncate(usize::from(height).saturating_sub(1).max(1));
        let _ = self.term.clear_last_lines(self.drawn);
        for line in &lines {
            let line = shown(line).to_string();
            let line = console::truncate_str(&line, usize::from(width), "…");
            let _ = self.term.write_line(&line);
        }
        let _ = self.term.flush();
        self.drawn = lines.len();
    }
}

impl Default for Screen {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        if self.is_drawn() {
            let _ = self.term.show_cursor();
            let _ = self.term.flush();
        }
    }
}

/// Every pair's last estimate, and what led to it.
#[derive(Clone, Debug, Default)]
struct View {
    /// By name, input and output.
    pairs: BTreeMap<[String; 3], Track>,
}

#[derive(Clone, Debug, Default)]
struct Track {
    last: ModelEstimate,
    fits: VecDeque<f64>,
    /// The real part of the slowest pole, 1/s.
    poles: VecDeque<f64>,
}

impl View {
    /// Takes an estimate.
    fn take(&mut self, model: &ModelEstimate) {
        let key = [&model.name, &model.input, &model.output].map(Clone::clone);
        if self.pairs.len() == PAIRS && !self.pairs.contains_key(&key) {
            return;
        }
        let track = self.pairs.entry(key).or_default();
        if track.last.restarts != model.restarts {
            *track = Track::default();
        }
        track.last = model.clone();
        if model.valid {
            let slowest = model
                .s_poles_re
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max);
            for (course, value) in [(&mut track.fits, model.fit), (&mut track.poles, slowest)] {
                course.push_back(value);
                if course.len() > COURSE {
                    course.pop_front();
                }
            }
        }
    }

    /// The view as lines.
    #[must_use]
    fn lines(&self) -> Vec<String> {
        if self.pairs.is_empty() {
            return vec!["no estimate has come yet".to_owned()];
        }
        self.pairs.values().flat_map(Track::lines).collect()
    }
}

impl Track {
    fn lines(&self) -> Vec<String> {
        let model = &self.last;
        let course = |values: &VecDeque<f64>| {
            let values: Vec<f64> = values.iter().copied().collect();
            sparkline(&values)
        };
        let mut lines = vec![
            String::new(),
            format!("{}  {} -> {}", model.name, model.input, model.output),
            format!(
                "  {}, order {}, {} samples of {} s{}: {}",
                model.estimator,
                model.order,
                model.samples,
                (model.sample_time * 1e9).round() / 1e9,
                if model.frozen { ", frozen" } else { "" },
                state(model)
            ),
        ];
        let estimate = estimate_of(model);
        let reading = estimate.as_ref().map(|estimate| Reading::of(estimate, 0));
        let poles = |found: Option<Result<Vec<Uncertain>, IdentificationError>>| {
            let once = found.into_iter().flatten().flatten();
            let once = once.filter(|pole| pole.value.im >= 0.0);
            once.map(text).collect::<Vec<_>>().join("   ")
        };
        lines.push(format!(
            "  poles z   {}",
            poles(reading.map(|it| it.poles()))
        ));
        lines.push(format!(
            "  poles s   {}  1/s",
            poles(reading.map(|it| it.continuous_poles()))
        ));
        if let Some(slowest) = self.poles.back() {
            let course = course(&self.poles);
            lines.push(format!("  slowest   {slowest:.4} 1/s  {course}"));
        }
        let gain = reading.and_then(|it| it.dc_gain());
        lines.push(format!(
            "  gain      {}",
            gain.map_or_else(|| "none, there is a pole at z = 1".to_owned(), text)
        ));
        let physical = model.physical_names.iter().zip(&model.physical_values);
        for ((name, value), deviation) in physical.zip(&model.physical_deviations) {
            lines.push(format!("  {name:<9} {value:.5} ± {deviation:.5}"));
        }
        lines.push(format!(
            "  fit       {:.2} %  {}",
            model.fit,
            course(&self.fits)
        ));
        lines
    }
}

/// An estimate in one line.
fn line(model: &ModelEstimate) -> String {
    let slowest = model
        .s_poles_re
        .iter()
        .zip(&model.s_poles_im)
        .max_by(|p, q| p.0.total_cmp(q.0).then(p.1.total_cmp(q.1)));
    let pole = slowest.map_or_else(String::new, |(re, im)| {
        format!(
            ", slowest pole {} 1/s",
            pole_text(Complex::new(*re, *im), 4)
        )
    });
    format!(
        "{:.2} {} {}: {} samples, fit {:.2} %{pole}{}, {}",
        model.header.stamp.nanos() as f64 * 1e-9,
        model.name,
        model.estimator,
        model.samples,
        model.fit,
        if model.frozen { ", frozen" } else { "" },
        state(model)
    )
}

fn state(model: &ModelEstimate) -> &str {
    if model.valid { "valid" } else { &model.reason }
}

/// A number, or both of a conjugate pair, and the standard deviation of each part.
fn text(uncertain: Uncertain) -> String {
    let value = pair_text(uncertain.value, 4);
    let real = uncertain.real_deviation();
    if uncertain.value.im == 0.0 {
        format!("{value} ± {real:.4}")
    } else {
        let imaginary = uncertain.imaginary_deviation();
        format!("{value} (sd {real:.4}, {imaginary:.4})")
    }
}

/// The estimate in a message; `None` when its covariance is not that of its coefficients.
#[must_use]
pub fn estimate_of(model: &ModelEstimate) -> Option<Estimate> {
    let n = model.a.len();
    let width = model.covariance.len().isqrt();
    let sound = width * width == model.covariance.len() && width >= 2 * n && model.b.len() == n;
    if n == 0 || !sound {
        return None;
    }
    let all = DMatrix::from_row_slice(width, width, &model.covariance);
    Some(Estimate {
        error: Error::Equation,
        layout: Layout {
            structure: Structure::of_order(n).without_offset(),
            runs: 1,
        },
        sample_time: model.sample_time,
        theta: DVector::from_iterator(2 * n, model.a.iter().chain(&model.b).copied()),
        covariance: all.view((0, 0), (2 * n, 2 * n)).into_owned(),
        noise_variance: model.noise_variance,
        noise_model: Vec::new(),
        factor: None,
        noise_denominator: Vec::new(),
        input_level: 0.0,
        residuals: Vec::new(),
        physical: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(samples: u64, pole: f64) -> ModelEstimate {
        ModelEstimate {
            name: "model".to_owned(),
            estimator: "least_squares".to_owned(),
            input: "cmd:data".to_owned(),
            output: "imu:x".to_owned(),
            sample_time: 0.1,
            order: 1,
            samples,
            a: vec![-pole],
            b: vec![0.2],
            covariance: vec![1e-6, 0.0, 0.0, 1e-6],
            poles_re: vec![pole],
            poles_im: vec![0.0],
            s_poles_re: vec![pole.ln() / 0.1],
            s_poles_im: vec![0.0],
            fit: 90.0 + samples as f64,
            valid: true,
            ..ModelEstimate::default()
        }
    }

    #[test]
    fn the_view_tells_each_pairs_poles_gain_and_fit_with_deviations_and_their_course() {
        let mut view = View::default();
        assert_eq!(view.lines(), vec!["no estimate has come yet"]);
        for k in 0..5 {
            view.take(&model(k, 0.8 + 0.02 * k as f64));
        }
        let heave = ModelEstimate {
            name: "heave".to_owned(),
            valid: false,
            reason: "the input has not moved".to_owned(),
            ..model(7, 0.5)
        };
        view.take(&heave);
        let text = view.lines().join("\n");
        for part in [
            "model  cmd:data -> imu:x",
            "least_squares, order 1, 4 samples of 0.1 s: valid",
            "poles z   0.8800 ± 0.0010",
            "poles s   -1.2783 ± 0.0114  1/s",
            "slowest   -1.2783 1/s  ▁▃▅▇█",
            // b / (1 - p), and sqrt((b / (1 - p)^2)^2 + (1 / (1 - p))^2) thousandths
            "gain      1.6667 ± 0.0162",
            "fit       94.00 %  ▁▃▅▇█",
            "heave  cmd:data -> imu:x",
            "the input has not moved",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }

    #[test]
    fn time_that_went_back_begins_the_course_anew_and_a_bad_covariance_tells_no_poles() {
        let mut view = View::default();
        view.take(&model(1, 0.8));
        view.take(&ModelEstimate {
            restarts: 1,
            covariance: vec![1.0; 3],
            ..model(2, 0.9)
        });
        let text = view.lines().join("\n");
        assert!(text.contains("fit       92.00 %  ▁"), "{text}");
        assert!(!text.contains("0.9000"), "{text}");
    }

    #[test]
    fn however_many_pairs_are_named_the_view_stays_small() {
        let mut view = View::default();
        for k in 0..10_000 {
            view.take(&ModelEstimate {
                name: format!("pair {k}"),
                ..model(1, 0.8)
            });
        }
        assert_eq!(view.pairs.len(), PAIRS);
    }

    #[test]
    fn without_a_terminal_an_estimate_is_a_line() {
        assert_eq!(
            line(&model(3, 0.8)),
            "0.00 model least_squares: 3 samples, fit 93.00 %, slowest pole -2.2314 1/s, valid"
        );
    }
}
