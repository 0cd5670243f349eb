//! Python keyword arguments as options of fits and of their data.

use std::collections::HashMap;

use anyhow::{Result, anyhow, bail};
use planesman_fit::declaration::{OptionGroup, Range, Takes, Value as _, choose};
use planesman_fit::rules::{Rule, RuleError};
use planesman_fit::{DataOptions, FitError, FitOptions, Sources};
use planesman_units::{Dimension, FOOT};
use planesman_vehicle::heave::heave_of;
use planesman_vehicle::linearised::Output;
use planesman_vehicle::transfer::{self, Input};
use planesman_vehicle::vehicle_file::BRUNNER;
use pyo3::FromPyObject;

/// The range of a transfer function's speed, m/s.
const SPEEDS: Range = Range::Quantity(
    Dimension::Speed,
    *transfer::SPEEDS.start(),
    *transfer::SPEEDS.end(),
);
/// The range of a transfer function's sampling rate, Hz.
const RATES: Range = Range::Number(Rule::new(
    *transfer::RATES.start(),
    *transfer::RATES.end(),
    "a number from 0.01 to 10000 is expected",
));

/// Two edges of a range, `None` where the range is open.
type Edges = (Option<f64>, Option<f64>);

/// A value of a Python keyword argument.
#[derive(Clone, Debug, FromPyObject)]
pub(crate) enum Keyword {
    Flag(bool),
    Count(i64),
    Number(f64),
    Spans(Vec<Edges>),
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Text(String),
}

impl Keyword {
    /// The value as Python would write it.
    fn written(&self) -> String {
        let edge = |it: &Option<f64>| it.map_or(String::new(), |it| it.to_string());
        match self {
            Self::Flag(true) => "True".to_owned(),
            Self::Flag(false) => "False".to_owned(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) if number.is_nan() => "nan".to_owned(),
            Self::Number(number) => format!("{number:?}"),
            Self::Spans(spans) => {
                let each = spans.iter().map(|(from, to)| edge(from) + ".." + &edge(to));
                each.collect::<Vec<_>>().join(",")
            }
            Self::Numbers(numbers) => {
                let each = numbers.iter().map(f64::to_string);
                each.collect::<Vec<_>>().join(",")
            }
            Self::Texts(texts) => texts.join(","),
            Self::Text(text) => text.clone(),
        }
    }

    /// The values one by one, for an option that takes several.
    fn each(&self) -> Vec<String> {
        match self {
            Self::Spans(spans) if !spans.is_empty() => spans
                .iter()
                .map(|it| Self::Spans(vec![*it]).written())
                .collect(),
            Self::Texts(texts) => texts.clone(),
            _ => vec![self.written()],
        }
    }
}

/// The options of a transfer function: base of an identified vehicle, signals, speed \[m/s\] and sampling rate \[Hz\].
pub(crate) struct Transfer {
    pub(crate) base: String,
    pub(crate) input: Input,
    pub(crate) output: Output,
    pub(crate) speed: f64,
    pub(crate) rate: f64,
}

/// Keyword arguments by their names.
pub(crate) struct Keywords(pub(crate) HashMap<String, Keyword>);

impl Keywords {
    /// Takes a keyword out and converts its value by `read`; `None` if the caller did not give it.
    fn read<T>(
        &mut self,
        option: &'static str,
        read: impl FnOnce(&str) -> Result<T, RuleError>,
    ) -> Result<Option<T>, FitError> {
        let given = self.0.remove(option).map(|it| it.written());
        let read = given.map(|value| {
            read(&value).map_err(|rule| FitError::Value {
                option,
                value,
                rule,
            })
        });
        read.transpose()
    }

    /// Takes the keywords of declared options.
    fn declared<T: OptionGroup>(&mut self, mut options: T) -> Result<T> {
        for option in T::declarations() {
            let Some(given) = self.0.remove(option.name) else {
                continue;
            };
            let texts = given.each();
            if texts.len() > 1 && option.kind().takes != Takes::Several {
                bail!(
                    "the argument '{}' cannot be used multiple times",
                    option.name
                )
            }
            for text in texts {
                options.put(option, &text)?;
            }
        }
        Ok(options)
    }

    /// Takes a keyword that names signals.
    fn texts(&mut self, option: &'static str) -> Vec<String> {
        let given = self.0.remove(option);
        given.map_or_else(Vec::new, |it| it.each())
    }

    /// Refuses the first keyword that no option took.
    fn end(self) -> Result<()> {
        match self.0.into_keys().next() {
            None => Ok(()),
            Some(name) => Err(anyhow!("'{name}' is not an option")),
        }
    }

    /// Takes the options of a fit.
    ///
    /// # Errors
    /// An unknown keyword, or a value that its option refuses.
    pub(crate) fn fit(mut self, sources: Sources) -> Result<FitOptions> {
        let mut options = self.declared(FitOptions::default())?;
        options.vehicle.look_up(heave_of)?;
        let signals = &mut options.signals;
        signals.data.sources = sources;
        signals.input = self.texts("input").concat();
        signals.output = self.texts("output").concat();
        signals.other_inputs = self.texts("other_inputs");
        signals.other_outputs = self.texts("other_outputs");
        self.end()?;
        Ok(options)
    }

    /// Takes the options of a transfer function.
    ///
    /// # Errors
    /// Same as [`Self::fit`].
    pub(crate) fn transfer(mut self) -> Result<Transfer> {
        let base = self.read("base", |it| Ok(it.to_owned()))?;
        let input = |it: &str| choose(it, &Input::ALL, Input::described, |_| &[]);
        let output = |it: &str| choose(it, &Output::ALL, Output::described, |_| &[]);
        let speed = self.read("speed", |it| f64::read(it, &SPEEDS))?;
        let rate = self.read("rate", |it| f64::read(it, &RATES))?;
        let found = Transfer {
            base: base.unwrap_or_else(|| BRUNNER.to_owned()),
            input: self.read("input", input)?.unwrap_or(Input::DivePlanes),
            output: self.read("output", output)?.unwrap_or(Output::PitchRate),
            speed: speed.unwrap_or(FOOT),
            rate: rate.unwrap_or(20.0),
        };
        self.end()?;
        Ok(found)
    }

    /// Takes the options for reading data.
    ///
    /// # Errors
    /// Same as [`Self::fit`].
    pub(crate) fn only_data(mut self, sources: Sources) -> Result<DataOptions> {
        let options = self.declared(DataOptions::default())?;
        self.end()?;
        Ok(DataOptions { sources, ..options })
    }
}
