//! The numbers of a subject's file as fixed parameters: each in SI, named by its path in the file.
//!
//! A number that an importer changes is written into the text in SI, and the file's own reader reads the text. An unchanged number stays as
//! written: after conversion it might differ in the last bit.

use std::collections::BTreeMap;
use std::ops::Range;

use planesman_parameters::{Declaration, Value};
use planesman_text::yaml;
use planesman_units::Quantity;

use crate::subject::Parameters;
use crate::variable::Variable;

/// A file's text and its numbers.
pub(crate) struct Numbers {
    text: String,
    all: Vec<Number>,
}

/// A number, and its bytes in the text, including its unit.
struct Number {
    declaration: Declaration,
    place: Range<usize>,
}

impl Numbers {
    /// The numbers in a text that its reader accepts; `is_taken` tests whether the reader accepts a number.
    pub(crate) fn of(text: &str, is_taken: impl Fn(&str) -> bool) -> Self {
        let scalars = yaml::scalars(text).unwrap_or_default().into_iter();
        let numbers = scalars.filter_map(|(path, place)| Number::at(&path, text, place));
        let mut all: Vec<Number> = numbers.collect();
        // A whole number is a count where the reader does not take it as `5.0`.
        let is_real = |numbers: &[&Number]| {
            let point = |it: &&Number| (it.place.clone(), format!("{}.0", &text[it.place.clone()]));
            is_taken(&yaml::edited(text, numbers.iter().map(point)))
        };
        let is_whole = |it: &&Number| matches!(it.declaration.default, Value::Integer(_));
        let whole: Vec<&Number> = all.iter().filter(is_whole).collect();
        let no_counts = is_real(&whole);
        let real = whole.iter().filter(|it| no_counts || is_real(&[**it]));
        let real: Vec<usize> = real.map(|it| it.place.start).collect();
        for number in &mut all {
            if let Value::Integer(value) = number.declaration.default
                && real.contains(&number.place.start)
            {
                number.declaration.default = Value::Double(value as f64);
            }
        }
        Self {
            text: text.to_owned(),
            all,
        }
    }

    /// Each number as a variable.
    pub(crate) fn variables(&self) -> impl Iterator<Item = Variable> {
        let declarations = self.all.iter().map(|it| it.declaration.clone());
        declarations.map(|it| Variable::parameter(it, true))
    }

    /// The text with these values of its numbers.
    pub(crate) fn text(&self, values: &Parameters) -> String {
        let values: BTreeMap<&str, &Value> = values.iter().map(|it| (&*it.0, &it.1)).collect();
        let edits = self.all.iter().filter_map(|number| {
            let own = &number.declaration;
            let value = values.get(&*own.name).filter(|it| ***it != own.default)?;
            let written = format!("{value} {}", own.unit).trim_end().to_owned();
            Some((number.place.clone(), written))
        });
        yaml::edited(&self.text, edits)
    }
}

impl Number {
    /// The number in a scalar; `None` for texts, and for fields that no simulation uses.
    fn at(path: &[String], text: &str, place: Range<usize>) -> Option<Self> {
        let names: Vec<&str> = path.iter().map(String::as_str).collect();
        if matches!(names[..], ["name" | "source"] | ["geometry", ..]) {
            return None;
        }
        let whole = text[place.clone()].trim_end();
        // An anchor stays before its number.
        let written = match whole.split_once(char::is_whitespace) {
            Some((anchor, number)) if anchor.starts_with('&') => number.trim_start(),
            _ => whole,
        };
        let end = place.start + whole.len();
        let Ok(quantity) = written.trim_matches(['"', '\'']).parse::<Quantity>();
        let (value, unit) = match (written.parse(), written.parse::<f64>(), quantity.in_si()) {
            (Ok(whole), ..) => (Value::Integer(whole), ""),
            (_, Ok(number), _) if number.is_finite() => (Value::Double(number), ""),
            (.., Some((number, unit))) => (Value::Double(number), unit),
            _ => return None,
        };
        let name = names.join(".").replace(".[", "[");
        let declaration = Declaration::of(
            name,
            &0.0,
            "A number of the file that describes the exported actuator, vehicle or model",
        )
        .unit(unit);
        Some(Self {
            declaration: Declaration {
                default: value,
                ..declaration
            },
            place: end - written.len()..end,
        })
    }
}
