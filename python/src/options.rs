//! Keywords of Python as the options of fits and of their data.

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

/// Speeds and rates of a transfer function.
const SPEEDS: Range = Range::Quantity(
    Dimension::Speed,
    *transfer::SPEEDS.start(),
    *transfer::SPEEDS.end(),
);
const RATES: Range = Range::Number(Rule::new(
    *transfer::RATES.start(),
    *transfer::RATES.end(),
    "a number from 0.01 to 10000 is expected",
));

/// Two edges, `None` where open.
type Edges = (Option<f64>, Option<f64>);

/// A value as Python gives it.
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
    /// As Python writes it.
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

    /// Each of its values, where an option takes several.
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

/// What a transfer function is of: the base of an identified vehicle, signals, speed \[m/s\] and sampling rate \[Hz\].
pub(crate) struct Transfer {
    pub(crate) base: String,
    pub(crate) input: Input,
    pub(crate) output: Output,
    pub(crate) speed: f64,
    pub(crate) rate: f64,
}

/// Keywords by their names.
pub(crate) struct Keywords(pub(crate) HashMap<String, Keyword>);

impl Keywords {
    /// A keyword by `read`; `None` where it is not given.
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

    /// The keywords of declared options.
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

    /// The signals of a keyword.
    fn texts(&mut self, option: &'static str) -> Vec<String> {
        let given = self.0.remove(option);
        given.map_or_else(Vec::new, |it| it.each())
    }

    /// Refuses what is left.
    fn end(self) -> Result<()> {
        match self.0.into_keys().next() {
            None => Ok(()),
            Some(name) => Err(anyhow!("'{name}' is no option")),
        }
    }

    /// The options of a fit.
    ///
    /// # Errors
    /// A keyword that is not one of them, a value that it does not take.
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

    /// What a transfer function is of.
    ///
    /// # Errors
    /// As [`Self::fit`].
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

    /// What is read, and how.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(crate) fn only_data(mut self, sources: Sources) -> Result<DataOptions> {
        let options = self.declared(DataOptions::default())?;
        self.end()?;
        Ok(DataOptions { sources, ..options })
    }
}
