//! State equations of one's own, fitted to data.

use planesman_equations::{Equations, EquationsFile, EquationsFit, Found, Initial, fit};
use planesman_parallel::Progress;
use serde_json::{Value, json};

use crate::error::FitError;
use crate::options::FitOptions;
use crate::stamped::StampedRuns;

/// Equations fitted to data.
#[derive(Debug)]
pub struct EquationsResult {
    /// The data.
    pub data: StampedRuns,
    /// The fit.
    pub fit: EquationsFit,
}

/// Reads the data and fits the equations. Of the options the signals count, each `NAME=SIGNAL` or, of a model with one, `SIGNAL`, and the
/// data with its windows. A signal that is not named is the one of the file, or has the name of the input or output.
///
/// # Errors
/// Equations that are refused, a signal of none of their names, options that say nothing of equations, data that cannot be read.
pub fn fit_equations(
    options: &FitOptions,
    file: EquationsFile,
    progress: &dyn Progress,
) -> Result<EquationsResult, FitError> {
    options.check_stamped()?;
    let structure = &options.structure;
    let given = [
        ("order", structure.order.is_some()),
        ("numerator", structure.numerator.is_some()),
        ("delay", structure.delay.is_some()),
        ("no_offset", structure.no_offset),
        ("at_rest", structure.at_rest),
    ];
    if let Some((option, _)) = given.into_iter().find(|it| it.1) {
        return Err(FitError::NotOf(option, "equations, which stand in their file"));
    }
    let equations = Equations::new(file)?;
    let file = &equations.file;
    let inputs = file.inputs.0.iter();
    let inputs = inputs.map(|(name, signal)| (name.clone(), signal.clone()));
    let inputs = bound("input", inputs.collect(), &options.signals.inputs())?;
    let outputs = file.outputs.0.iter();
    let outputs = outputs.map(|(name, of)| (name.clone(), of.signal.clone()));
    let outputs = bound("output", outputs.collect(), &options.signals.outputs())?;
    let data = options.stamped(&inputs, &outputs, progress)?;
    progress.begin("models", 0, 0);
    let found = fit(&equations, &data.runs, &data.validation);
    progress.end();
    let mut fit = found?;
    let (verdict, reasons) = data.doubts(fit.verdict);
    fit.verdict = verdict;
    fit.reasons.splice(0..0, reasons.iter().map(ToString::to_string));
    Ok(EquationsResult { data, fit })
}

/// The signal of each name: the one that is given, that of the file, or the name itself.
fn bound(
    option: &'static str,
    of: Vec<(String, Option<String>)>,
    given: &[String],
) -> Result<Vec<String>, FitError> {
    let mut signals: Vec<Option<String>> = vec![None; of.len()];
    for text in given.iter().filter(|it| !it.is_empty()) {
        let named = text.split_once('=').and_then(|(name, signal)| {
            let place = of.iter().position(|it| it.0 == name.trim())?;
            Some((place, signal.trim()))
        });
        let (place, signal) = match (named, of.len()) {
            (Some(named), _) => named,
            (None, 1) => (0, text.as_str()),
            _ => {
                return Err(FitError::Binding {
                    option,
                    given: text.clone(),
                    names: of.into_iter().map(|it| it.0).collect(),
                });
            }
        };
        if signals[place].is_some() {
            return Err(FitError::Twice(of[place].0.clone()));
        }
        signals[place] = Some(signal.to_owned());
    }
    let each = signals.into_iter().zip(of);
    Ok(each.map(|(given, (name, own))| given.or(own).unwrap_or(name)).collect())
}

impl EquationsResult {
    /// Everything but the data's numbers, as `--json` prints it.
    ///
    /// # Errors
    /// None that is known: the file is of values that JSON has.
    pub fn as_json(&self) -> Result<Value, FitError> {
        let fit = &self.fit;
        let found = |it: &Found| {
            json!({
                "name": it.unknown.name,
                "value": it.value,
                "deviation": it.deviation,
                "unit": it.unknown.unit,
                "at_bound": it.is_at_bound,
            })
        };
        let list = |of: &[Found]| of.iter().map(found).collect::<Vec<_>>();
        let outputs = fit.outputs.iter().zip(&fit.equations.file.outputs.0).map(|(it, _)| {
            json!({
                "output": it.name,
                "fit": it.fit,
                "held_out_fit": it.held_out_fit,
                "left": it.left,
                "noise": it.noise,
                "samples": it.samples,
            })
        });
        let undetermined = fit.undetermined.iter().map(|it| {
            let kept = it.kept.iter().map(|(name, value, deviation)| {
                json!({"name": name, "value": value, "deviation": deviation})
            });
            json!({"names": it.names, "determined": kept.collect::<Vec<_>>()})
        });
        let rows = fit.correlation.row_iter();
        Ok(json!({
            "equations": self.file(),
            "signals": self.data.signals,
            "parameters": list(&fit.parameters),
            "initial": fit.initial.iter().map(|it| list(it)).collect::<Vec<_>>(),
            "correlation": rows.map(|it| it.iter().copied().collect::<Vec<f64>>()).collect::<Vec<_>>(),
            "outputs": outputs.collect::<Vec<_>>(),
            "undetermined": undetermined.collect::<Vec<_>>(),
            "segments": self.data.runs.iter().map(planesman_equations::Run::end).collect::<Vec<_>>(),
            "searches": {"at_this_minimum": fit.searches.0, "begun": fit.searches.1},
            "data": self.data.description,
            "reasons": fit.reasons,
            "verdict": fit.verdict.to_string(),
        }))
    }

    /// The equations with the parameters that were found as their start, and the noise that is left.
    #[must_use]
    pub fn file(&self) -> EquationsFile {
        let mut file = self.fit.equations.file.clone();
        for found in &self.fit.parameters {
            if let Some(of) = file.parameters.get_mut(&found.unknown.name) {
                of.start = Some(found.value);
                of.deviation = found.deviation;
            }
        }
        for found in self.fit.initial.first().into_iter().flatten() {
            let name = found.unknown.name.trim_end_matches("(0)");
            if let Some(of) = file.states.get_mut(name)
                && let Initial::Sought(sought) = &mut of.initial
            {
                sought.start = found.value;
            }
        }
        let inputs = file.inputs.0.len();
        for ((_, signal), name) in file.inputs.0.iter_mut().zip(&self.data.signals) {
            *signal = Some(name.clone());
        }
        for ((_, of), name) in file.outputs.0.iter_mut().zip(&self.data.signals[inputs..]) {
            of.signal = Some(name.clone());
        }
        file
    }
}
