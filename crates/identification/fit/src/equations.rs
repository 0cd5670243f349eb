//! User-defined state equations, fitted to data.

use planesman_equations::{
    Equations, EquationsFile, EquationsFit, EstimatedParameter, Initial, fit,
};
use planesman_linear::rows;
use planesman_parallel::Progress;
use serde_json::{Value, json};

use crate::declaration::OptionGroup as _;
use crate::error::FitError;
use crate::options::FitOptions;
use crate::stamped::StampedRuns;

/// Options whose values the equations define.
const OF_STRUCTURE: [&str; 5] = ["order", "numerator", "delay", "no_offset", "at_rest"];

/// Equations fitted to data.
#[derive(Debug)]
pub struct EquationsResult {
    /// The data.
    pub data: StampedRuns,
    /// The fit.
    pub fit: EquationsFit,
}

/// Reads the data and fits the equations. Of the options, only the signals and the data with its windows are used. Each signal is
/// `NAME=SIGNAL`, or `SIGNAL` for a single input or output. Signals that are not named are taken from the file, or have the name of the input or
/// output.
///
/// # Errors
/// If the equations are invalid, a signal matches none of their names, an option does not apply to equations, or the data cannot be read.
pub fn fit_equations(
    options: &FitOptions,
    file: EquationsFile,
    progress: &dyn Progress,
) -> Result<EquationsResult, FitError> {
    options.check_stamped()?;
    let given = options.given();
    if let Some(option) = given.iter().find(|it| OF_STRUCTURE.contains(&it.name)) {
        return Err(FitError::NotOf(
            option.name,
            "equations, which define it in their file",
        ));
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
    fit.reasons
        .splice(0..0, reasons.iter().map(ToString::to_string));
    Ok(EquationsResult { data, fit })
}

/// The signal for each name: the given signal, the file's signal, or the name itself.
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
    Ok(each
        .map(|(given, (name, own))| given.or(own).unwrap_or(name))
        .collect())
}

impl EquationsResult {
    /// The output of `--json`, without the information on the data.
    ///
    /// # Errors
    /// Never in practice: the file contains only values that JSON can represent.
    pub fn as_json(&self) -> Result<Value, FitError> {
        let fit = &self.fit;
        let found = |it: &EstimatedParameter| {
            json!({
                "name": it.unknown.name,
                "value": it.value,
                "deviation": it.deviation,
                "unit": it.unknown.unit,
                "at_bound": it.is_at_bound,
            })
        };
        let list = |of: &[EstimatedParameter]| of.iter().map(found).collect::<Vec<_>>();
        let outputs = fit
            .outputs
            .iter()
            .zip(&fit.equations.file.outputs.0)
            .map(|(it, _)| {
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
        Ok(json!({
            "equations": self.file(),
            "signals": self.data.signals,
            "parameters": list(&fit.parameters),
            "initial": fit.initial.iter().map(|it| list(it)).collect::<Vec<_>>(),
            "correlation": rows(&fit.correlation),
            "outputs": outputs.collect::<Vec<_>>(),
            "undetermined": undetermined.collect::<Vec<_>>(),
            "segments": self.data.runs.iter().map(planesman_equations::Run::end).collect::<Vec<_>>(),
            "searches": {"at_this_minimum": fit.searches.0, "begun": fit.searches.1},
            "data": self.data.description,
            "reasons": fit.reasons,
            "verdict": fit.verdict_text(),
        }))
    }

    /// The equations with the estimated parameters as their start, and the remaining noise.
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

#[cfg(test)]
mod tests {
    use planesman_equations::text_of;

    use super::*;
    use crate::continuous::fit_continuous;
    use crate::data::DataOptions;

    const FILE: &str = "
inputs: [u]
outputs: {y: {equation: x}}
states: {x: {derivative: -a*x + b*u}}
parameters: {a: {start: 1, min: 0.01}, b: {start: 1}}
";

    /// x' = -2 x + 3 u, a sample every 0.1 s, in closed form; 30 samples are missing.
    fn options() -> FitOptions {
        let share = libm::exp(-0.2_f64);
        let u: Vec<f64> = (0..400_u32)
            .map(|k| f64::from(u8::from((k / 7 * 5 % 3) == 0)) - 0.3)
            .collect();
        let mut x = vec![0.4];
        for k in 1..u.len() {
            x.push(share * x[k - 1] + 1.5 * (1.0 - share) * u[k - 1]);
        }
        let hum = |k: usize| 0.01 * libm::sin(0.7 * (k * k) as f64);
        let missing = 200..230;
        let y = x.iter().enumerate();
        let y = y.map(|(k, x)| {
            if missing.contains(&k) {
                f64::NAN
            } else {
                x + hum(k)
            }
        });
        let columns = vec![("volts".to_owned(), u), ("y".to_owned(), y.collect())];
        let mut options = FitOptions::default();
        options.signals.data = DataOptions::columns(columns);
        options.signals.data.sample_time = Some(0.1);
        options.signals.input = "u=volts".to_owned();
        options
    }

    fn file() -> EquationsFile {
        text_of(FILE).unwrap()
    }

    #[test]
    fn equations_are_fitted_over_a_gap_and_written_back_with_what_was_found() {
        let found = fit_equations(&options(), file(), &()).unwrap();
        assert_eq!(found.data.runs.len(), 2, "{:?}", found.data.description);
        for (of, truth) in found.fit.parameters.iter().zip([2.0, 3.0]) {
            assert!((of.value - truth).abs() < 0.02, "{} {truth}", of.value);
        }
        let written = found.file();
        let start = written.parameters.0[0].1.start.unwrap();
        assert_eq!(start, found.fit.parameters[0].value);
        assert_eq!(written.inputs.0[0].1.as_deref(), Some("volts"));
        let again = fit_equations(
            &FitOptions {
                signals: crate::SignalOptions {
                    input: String::new(),
                    ..options().signals
                },
                ..FitOptions::default()
            },
            written,
            &(),
        )
        .unwrap();
        assert!((again.fit.parameters[0].value - start).abs() < 1e-6);
        let json = found.as_json().unwrap();
        assert_eq!(json["parameters"][0]["name"], "a");
        assert!(json["verdict"].as_str().unwrap().contains("good"), "{json}");
    }

    #[test]
    fn a_transfer_function_in_s_is_fitted_to_the_same_data() {
        let mut options = options();
        options.signals.input = "volts".to_owned();
        options.signals.output = "y".to_owned();
        options.structure.order = Some(1);
        let found = fit_continuous(&options, &()).unwrap();
        for (at, truth) in [2.0, 3.0, 0.0].into_iter().enumerate() {
            assert!(
                (found.fit.parameters[at] - truth).abs() < 0.02,
                "{:?}",
                found.fit.parameters
            );
        }
        let json = found.as_json().unwrap();
        assert_eq!(json["continuous"]["den"].as_array().unwrap().len(), 2);
        options.structure.delay = Some(3);
        let refusal = fit_continuous(&options, &()).unwrap_err().to_string();
        assert!(
            refusal.contains("delay is a number of samples"),
            "{refusal}"
        );
    }

    #[test]
    fn what_says_nothing_of_equations_is_refused() {
        let refusal = |change: &dyn Fn(&mut FitOptions)| {
            let mut options = options();
            change(&mut options);
            fit_equations(&options, file(), &())
                .unwrap_err()
                .to_string()
        };
        for (change, said) in [
            (
                (&|it: &mut FitOptions| it.structure.order = Some(2)) as &dyn Fn(&mut FitOptions),
                "order does not apply to equations",
            ),
            (
                &|it| it.signals.grid.rate = Some(10.0),
                "rate does not apply to a fit at the original stamps",
            ),
            (
                &|it| it.signals.other_inputs = vec!["v=x".to_owned()],
                "'u' is given twice",
            ),
            (&|it| it.signals.output = "speed".to_owned(), "speed"),
        ] {
            let refusal = refusal(change);
            assert!(refusal.contains(said), "{said}: {refusal}");
        }
        let two = FILE.replace("[u]", "[u, v]").replace("b*u", "b*u + v");
        let refusal = fit_equations(
            &FitOptions {
                signals: crate::SignalOptions {
                    input: "volts".to_owned(),
                    ..options().signals
                },
                ..FitOptions::default()
            },
            text_of(&two).unwrap(),
            &(),
        );
        let refusal = refusal.unwrap_err().to_string();
        assert!(
            refusal.contains(
                "input volts does not name an input of the equations. They have the inputs u, v. Write input NAME=SIGNAL"
            ),
            "{refusal}"
        );
    }
}
