//! Keywords of Python as the options of fits and of their data.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use anyhow::{Result, anyhow, bail};
use planesman_fit::rules::{self, Rule, RuleError, Span};
use planesman_fit::{
    DataOptions, FitError, FitOptions, GridOptions, KnownVehicle, MethodChoice, PreparationOptions,
    RecursionOptions, SignalOptions, Sources, StructureOptions, Validation, VehicleOptions,
};
use planesman_identification::analysis::CurveChoice;
use planesman_identification::estimators::Form;
use planesman_signals::{Clock, Method, Outliers, SegmentChoice, TableTime, TimeUnit, Trend};
use planesman_text::did_you_mean;
use planesman_units::{Dimension, FOOT, Quantity};
use planesman_vehicle::heave::{HeaveError, heave_of};
use planesman_vehicle::linearised::Output;
use planesman_vehicle::transfer::{self, Input};
use planesman_vehicle::vehicle_file::BRUNNER;
use pyo3::FromPyObject;

/// Speeds and rates of a transfer function.
const SPEEDS: Rule = Rule::new(
    *transfer::SPEEDS.start(),
    *transfer::SPEEDS.end(),
    "a number from 0.001 to 100 is expected",
);
const RATES: Rule = Rule::new(
    *transfer::RATES.start(),
    *transfer::RATES.end(),
    "a number from 0.01 to 10000 is expected",
);

/// What the chunks of each file of a bag may unpack to, MB.
const MOST_UNPACKED: RangeInclusive<i64> = 1..=1_000_000_000;

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

    fn number(&self) -> Option<f64> {
        match self {
            Self::Count(count) => Some(*count as f64),
            Self::Number(number) => Some(*number),
            _ => None,
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
        read: impl FnOnce(&Keyword) -> Result<T, RuleError>,
    ) -> Result<Option<T>> {
        let Some(given) = self.0.remove(option) else {
            return Ok(None);
        };
        let refused = |rule| {
            let value = given.written();
            FitError::Value {
                option,
                value,
                rule,
            }
        };
        Ok(Some(read(&given).map_err(refused)?))
    }

    fn number(&mut self, option: &'static str, rule: Rule) -> Result<Option<f64>> {
        self.read(option, |given| match given.number() {
            Some(number) => rule.check(&given.written(), number),
            None => rule.parse(&given.written()),
        })
    }

    /// A number in SI, or text with its unit.
    fn quantity(
        &mut self,
        option: &'static str,
        dimension: Dimension,
        rule: Rule,
    ) -> Result<Option<f64>> {
        self.read(option, |given| {
            let number = given.number().map(|it| rule.check("", it));
            match number {
                Some(Ok(number)) => Ok(number),
                _ => {
                    let Ok(quantity) = given.written().parse::<Quantity>();
                    let value = quantity.argument_within(dimension, rule.least, rule.most);
                    value.map_err(|refusal| RuleError::Own(refusal.to_string()))
                }
            }
        })
    }

    fn count(&mut self, option: &'static str, range: RangeInclusive<i64>) -> Result<Option<usize>> {
        self.read(option, |given| {
            let count = match given {
                Keyword::Count(count) => *count,
                other => (other.written().parse::<i64>())
                    .map_err(|refused| RuleError::Own(refused.to_string()))?,
            };
            let checked = usize::try_from(count).ok();
            let checked = checked.filter(|_| range.contains(&count));
            checked.ok_or_else(|| RuleError::Count(count.into(), range))
        })
    }

    fn flag(&mut self, option: &'static str) -> Result<bool> {
        let flag = self.read(option, |given| match given {
            Keyword::Flag(flag) => Ok(*flag),
            _ => Err(RuleError::Own("True or False is expected".to_owned())),
        });
        Ok(flag?.unwrap_or_default())
    }

    fn text(&mut self, option: &'static str) -> Option<String> {
        self.0.remove(option).map(|it| it.written())
    }

    /// Several signals.
    fn texts(&mut self, option: &'static str) -> Vec<String> {
        match self.0.remove(option) {
            None => Vec::new(),
            Some(Keyword::Texts(texts)) => texts,
            Some(one) => vec![one.written()],
        }
    }

    fn choice<T: Copy>(
        &mut self,
        option: &'static str,
        all: &[T],
        described: fn(T) -> (&'static str, &'static str),
        also: fn(T) -> &'static [&'static str],
    ) -> Result<Option<T>> {
        let Some(name) = self.text(option) else {
            return Ok(None);
        };
        let is_it = |it: &&T| described(**it).0 == name || also(**it).contains(&name.as_str());
        if let Some(found) = all.iter().find(is_it) {
            return Ok(Some(*found));
        }
        let names: Vec<&str> = all.iter().map(|it| described(*it).0).collect();
        let meant = did_you_mean(&name, names.iter().copied());
        let (option, names) = (option.replace('_', "-"), names.join(", "));
        bail!("invalid value '{name}' for '{option}' [possible values: {names}]{meant}")
    }

    fn spans(&mut self, option: &'static str, rule: Span) -> Result<Vec<(f64, f64)>> {
        let spans = self.read(option, |given| match given {
            Keyword::Spans(spans) => spans.iter().map(|it| edges(it, &rule)).collect(),
            other => Ok(vec![rule.parse(&other.written())?]),
        });
        Ok(spans?.unwrap_or_default())
    }

    /// Refuses what is left.
    fn end(self) -> Result<()> {
        match self.0.into_keys().next() {
            None => Ok(()),
            Some(name) => Err(anyhow!("'{name}' is no option")),
        }
    }

    fn data(&mut self, sources: Sources) -> Result<DataOptions> {
        let sample_time = self.quantity("sample_time", Dimension::Time, rules::SAMPLE_TIME)?;
        Ok(DataOptions {
            sources,
            stamp: self.choice("stamp", &Clock::ALL, Clock::described, |_| &[])?,
            time: TableTime {
                column: self.text("time"),
                unit: self.choice("time_unit", &TimeUnit::ALL, TimeUnit::described, |_| &[])?,
                sample_time,
            },
            most_unpacked: (self.count("most_unpacked", MOST_UNPACKED)?)
                .map(|it| it as u64 * 1_000_000),
        })
    }

    fn grid(&mut self) -> Result<GridOptions> {
        let default = GridOptions::default();
        let method =
            |it: &mut Self, option| it.choice(option, &Method::ALL, Method::described, |_| &[]);
        Ok(GridOptions {
            rate: self.number("rate", rules::RATE)?,
            window: self.spans("window", rules::WINDOW)?,
            input_method: method(self, "input_method")?.unwrap_or(default.input_method),
            output_method: method(self, "output_method")?.unwrap_or(default.output_method),
            max_gap: self.number("max_gap", rules::MAX_GAP)?,
            unwrap: self
                .read("unwrap", |given| rules::unwrap(&given.written()))?
                .unwrap_or_default(),
        })
    }

    fn preparation(&mut self) -> Result<PreparationOptions> {
        let outliers = self.choice("outliers", &Outliers::ALL, Outliers::described, |_| &[])?;
        let segment = self.choice(
            "segment",
            &SegmentChoice::ALL,
            SegmentChoice::described,
            |_| &[],
        )?;
        let detrend = self.choice("detrend", &Trend::ALL, Trend::described, |_| &[])?;
        Ok(PreparationOptions {
            outliers: outliers.unwrap_or_default(),
            prefilter: one("prefilter", self.spans("prefilter", rules::BAND)?)?,
            segment: segment.unwrap_or_default(),
            detrend: detrend.unwrap_or_default(),
        })
    }

    fn validation(&mut self) -> Result<Option<Validation>> {
        if let Some(Keyword::Text(_)) = self.0.get("validation") {
            return self.read("validation", |given| given.written().parse());
        }
        let window = one("validation", self.spans("validation", rules::WINDOW)?)?;
        Ok(window.map(|(from, to)| Validation::Window(from, to)))
    }

    fn structure(&mut self) -> Result<StructureOptions> {
        let at_one = |it: &mut Self, option| it.count(option, rules::AT_ONE);
        Ok(StructureOptions {
            order: self.count("order", rules::ORDER)?,
            process: self.choice("process", &Form::ALL, Form::described, |_| &[])?,
            coherence: self.number("coherence", rules::COHERENCE)?,
            numerator: self.count("numerator", rules::NUMERATOR)?,
            delay: self.count("delay", rules::DELAY)?,
            zeros_at_one: at_one(self, "zeros_at_one")?.unwrap_or_default(),
            integrators: at_one(self, "integrators")?.unwrap_or_default(),
            no_offset: self.flag("no_offset")?,
            at_rest: self.flag("at_rest")?,
            prewindow: self.flag("prewindow")?,
            own_numerators: self.flag("own_numerators")?,
        })
    }

    fn vehicle(&mut self) -> Result<VehicleOptions> {
        let heave = self.read("heave", |given| match given {
            Keyword::Numbers(numbers) => rules::four(numbers),
            other => rules::heave(&other.written()),
        })?;
        let speed = self.quantity("speed", Dimension::Speed, rules::SPEED)?;
        let known = self.text("vehicle").map(|name| {
            let heave = speed.map(|speed| heave_of(&name, speed));
            Ok::<_, HeaveError>(KnownVehicle {
                heave: heave.transpose()?,
            })
        });
        let size = |it: &mut Self, option| it.number(option, rules::NOT_NEGATIVE);
        Ok(VehicleOptions {
            heave,
            vehicle: known.transpose()?,
            heave_doubt: size(self, "heave_doubt")?.unwrap_or_default(),
            speed,
            inertia: self.number("inertia", rules::ABOVE_ZERO)?,
            noise: self.number("noise", rules::ABOVE_ZERO)?,
            bias_drift: size(self, "bias_drift")?.unwrap_or_default(),
            disturbance: size(self, "disturbance")?.unwrap_or_default(),
        })
    }

    /// The options of a fit.
    ///
    /// # Errors
    /// A keyword that is not one of them, a value that it does not take.
    pub(crate) fn fit(mut self, sources: Sources) -> Result<FitOptions> {
        let method = self.choice(
            "method",
            &MethodChoice::ALL,
            MethodChoice::described,
            MethodChoice::also_known,
        )?;
        let options = FitOptions {
            signals: SignalOptions {
                data: self.data(sources)?,
                input: self.text("input").unwrap_or_default(),
                output: self.text("output").unwrap_or_default(),
                other_inputs: self.texts("other_inputs"),
                other_outputs: self.texts("other_outputs"),
                reference: self.text("reference"),
                grid: self.grid()?,
                preparation: self.preparation()?,
            },
            validation: self.validation()?,
            method: method.unwrap_or_default(),
            structure: self.structure()?,
            vehicle: self.vehicle()?,
            recursion: RecursionOptions {
                forgetting: self.number("forgetting", rules::FORGETTING)?,
                initial_covariance: self.number("initial_covariance", rules::ABOVE_ZERO)?,
            },
            bootstrap: self.count("bootstrap", rules::BOOTSTRAP)?,
            curve: self
                .choice("curve", &CurveChoice::ALL, CurveChoice::described, |_| &[])?
                .unwrap_or_default(),
        };
        self.end()?;
        Ok(options)
    }

    /// What a transfer function is of.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(crate) fn transfer(mut self) -> Result<Transfer> {
        let input = self.choice("input", &Input::ALL, Input::described, |_| &[])?;
        let output = self.choice("output", &Output::ALL, Output::described, |_| &[])?;
        let found = Transfer {
            base: self.text("base").unwrap_or_else(|| BRUNNER.to_owned()),
            input: input.unwrap_or(Input::DivePlanes),
            output: output.unwrap_or(Output::PitchRate),
            speed: self
                .quantity("speed", Dimension::Speed, SPEEDS)?
                .unwrap_or(FOOT),
            rate: self.number("rate", RATES)?.unwrap_or(20.0),
        };
        self.end()?;
        Ok(found)
    }

    /// What is read, and how.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(crate) fn only_data(mut self, sources: Sources) -> Result<DataOptions> {
        let options = self.data(sources)?;
        self.end()?;
        Ok(options)
    }
}

/// Two edges that the rule lets.
fn edges((from, to): &Edges, rule: &Span) -> Result<(f64, f64), RuleError> {
    let written = Keyword::Spans(vec![(*from, *to)]).written();
    let edges = (from.unwrap_or(rule.open.0), to.unwrap_or(rule.open.1));
    rule.check(&written, edges)
}

/// At most one of them.
fn one(option: &str, spans: Vec<(f64, f64)>) -> Result<Option<(f64, f64)>> {
    match spans[..] {
        [] => Ok(None),
        [span] => Ok(Some(span)),
        _ => bail!("the argument '{option}' cannot be used multiple times"),
    }
}
