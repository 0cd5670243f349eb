//! A transfer function in s, fitted to data at its original stamps.

use planesman_equations::{Run, TransferFit, TransferOptions, fit_transfer};
use planesman_linear::rows;
use planesman_parallel::Progress;
use serde_json::{Value, json};

use crate::error::FitError;
use crate::options::FitOptions;
use crate::stamped::StampedRuns;

/// A transfer function in s, and the data.
#[derive(Debug)]
pub struct ContinuousResult {
    /// The data.
    pub data: StampedRuns,
    /// The transfer function.
    pub fit: TransferFit,
    /// The findings, in sentences; the last is the verdict.
    pub sentences: Vec<String>,
}

/// Reads the data and fits a transfer function in s. Only these options of the structure have an effect: order, numerator, a delay of 0,
/// offset and rest.
///
/// # Errors
/// If options do not apply to a transfer function in s, the data cannot be read, or there is too little data.
pub fn fit_continuous(
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<ContinuousResult, FitError> {
    options.check_stamped()?;
    if options.signals.are_several() {
        return Err(FitError::OfOne("continuous"));
    }
    let structure = &options.structure;
    if structure.delay.is_some_and(|it| it > 0) {
        return Err(FitError::DelayInSamples);
    }
    if structure.order == Some(0) {
        return Err(FitError::NotOf(
            "order 0",
            "a transfer function in s, which has poles",
        ));
    }
    let data = options.stamped(
        &options.signals.inputs(),
        &options.signals.outputs(),
        progress,
    )?;
    let of = TransferOptions {
        order: structure.order,
        numerator: structure.numerator,
        no_delay: structure.delay == Some(0),
        no_offset: structure.no_offset,
        at_rest: structure.at_rest,
    };
    progress.begin("models", 0, 0);
    let found = fit_transfer(&data.runs, &data.validation, of);
    progress.end();
    let mut fit = found?;
    let (verdict, reasons) = data.doubts(fit.verdict);
    fit.verdict = verdict;
    let mut sentences: Vec<String> = reasons.iter().map(ToString::to_string).collect();
    if !fit.tried.is_empty() {
        let tried = fit.tried.iter().map(|(order, numerator, held)| match held {
            Some(held) => format!("{order}, {numerator} ({held:.1} %)"),
            None => format!("{order}, {numerator} (none)"),
        });
        sentences.push(format!(
            "the model has {} poles and {} numerator coefficients: the fewest with a held-out fit within 0.5 % of the best fit, of {}",
            fit.order,
            fit.numerator,
            tried.collect::<Vec<_>>().join("; ")
        ));
    }
    let held = fit
        .held_out_fit
        .map_or("none".to_owned(), |it| format!("{it:.1} %"));
    let on = match fit.is_validated {
        true => "on the validation data, with only offset and initial state fitted to them",
        false => "on the last 30 % of the data, by a model of the first 70 %",
    };
    sentences.push(format!("simulated fit {held} {on}"));
    if fit.longest_delay.is_some_and(|most| fit.delay().0 >= most) {
        sentences.push(
            "the dead time is at the upper limit of the search (50 intervals or a \
            quarter of the record)"
                .to_owned(),
        );
    }
    sentences.push(fit.verdict_text());
    Ok(ContinuousResult {
        data,
        fit,
        sentences,
    })
}

impl ContinuousResult {
    /// The output of `--json`, without the information on the data.
    ///
    /// # Errors
    /// If the poles cannot be computed.
    pub fn as_json(&self) -> Result<Value, FitError> {
        let fit = &self.fit;
        let (delay, of_delay) = fit.delay();
        let (gain, of_gain) = fit.gain();
        let poles = fit.poles()?;
        let poles = poles.iter().map(|it| {
            json!({
                "re": it.value.re,
                "im": it.value.im,
                "deviation": [it.real_deviation(), it.imaginary_deviation()],
                "mode": it.mode_text(),
            })
        });
        let names = (0..fit.order).map(|k| format!("a{k}"));
        let names = names.chain((0..fit.numerator).map(|k| format!("b{k}")));
        let names: Vec<String> = names.chain(["dead_time".to_owned()]).collect();
        let parameters = names.iter().zip(&fit.parameters).enumerate();
        let parameters = parameters.map(|(at, (name, value))| {
            json!({"name": name, "value": value, "deviation": fit.covariance[(at, at)].max(0.0).sqrt()})
        });
        Ok(json!({
            "continuous": {"num": fit.numerator(), "den": fit.denominator(), "delay": delay},
            "delay_deviation": of_delay,
            "parameters": parameters.collect::<Vec<_>>(),
            "covariance": rows(&fit.covariance),
            "poles": poles.collect::<Vec<_>>(),
            "steady_state_gain": [gain, of_gain],
            "offsets": fit.offsets,
            "fit": fit.fit,
            "held_out_fit": fit.held_out_fit,
            "left": fit.left,
            "samples": fit.samples,
            "segments": self.data.runs.iter().map(Run::end).collect::<Vec<_>>(),
            "signals": self.data.signals,
            "data": self.data.description,
            "verdict": self.sentences,
        }))
    }
}
