//! A model of equations: names resolved, every expression on one tape.
//!
//! ```text
//! x_dot = f(x, u, p, t),   y = h(x, u, p, t)
//! ```

use std::collections::{BTreeMap, BTreeSet};

use planesman_text::did_you_mean;

use crate::error::EquationsError;
use crate::expression::{Names, Numbers, Root, Tape, is_reserved, parse};
use crate::file::{EquationsFile, Initial, Output, Parameter, State, UNKNOWN};

/// Maximum number of states, inputs, outputs and estimated parameters, each.
const MOST: usize = 64;
/// Time since the segment's first sample, s.
const TIME: &str = "t";

/// An estimated number.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Its name.
    pub name: String,
    /// The initial guess.
    pub start: f64,
    /// The minimum and the maximum; infinite if not given.
    pub bounds: (f64, f64),
    /// The unit; empty if not given.
    pub unit: String,
}

/// The initial value of a state.
#[derive(Clone, Debug)]
pub(crate) enum Begin {
    Sought(Unknown),
    Given(Root),
}

/// An output of a model.
#[derive(Clone, Debug)]
pub(crate) struct OutputEquation {
    pub(crate) name: String,
    pub(crate) root: Root,
    pub(crate) noise: Option<f64>,
}

/// A model of equations.
#[derive(Clone, Debug)]
pub struct Equations {
    /// The equations as in the file.
    pub file: EquationsFile,
    /// The estimated parameters.
    pub unknowns: Vec<Unknown>,
    pub(crate) tape: Tape,
    pub(crate) derivatives: Vec<Root>,
    pub(crate) begins: Vec<Begin>,
    pub(crate) outputs: Vec<OutputEquation>,
}

impl Equations {
    /// Resolves the names of a file.
    ///
    /// # Errors
    /// [`EquationsError::Entry`]: a name that is unknown, stands twice or in no equation; definitions that go in a circle; what is
    /// expression, or a parameter has no start, or one outside of its bounds.
    pub fn new(file: EquationsFile) -> Result<Self, EquationsError> {
        check_counts(&file)?;
        let mut unknowns = Vec::new();
        let mut fixed = BTreeMap::new();
        for (name, of) in &file.parameters.0 {
            match of.fixed {
                Some(value) => {
                    fixed.insert(name.as_str(), known(name, of, value)?);
                }
                None => unknowns.push(unknown(name, of)?),
            }
        }
        let names = file.inputs.names().chain(file.states.names());
        let names = names.chain(unknowns.iter().map(|it| &it.name));
        let mut slots: BTreeMap<&str, usize> = BTreeMap::new();
        for (slot, name) in names.map(String::as_str).chain([TIME]).enumerate() {
            slots.insert(name, slot);
        }
        check_names(&file)?;
        let definitions = file.definitions.0.iter();
        let mut tape = TapeWriter {
            tape: Tape::default(),
            names: Binder {
                definitions: definitions.map(|(a, b)| (a.as_str(), b.as_str())).collect(),
                slots,
                fixed,
                nodes: BTreeMap::new(),
                open: Vec::new(),
                used: BTreeSet::new(),
            },
            states: file.inputs.0.len()..file.inputs.0.len() + file.states.0.len(),
        };
        for name in file.definitions.names() {
            let refuse = |reason| EquationsError::entry(format!("definitions: {name}"), reason);
            (tape.names.node(&mut tape.tape, name, 0)).map_err(refuse)?;
        }
        let (mut derivatives, mut begins) = (Vec::new(), Vec::new());
        for (name, of) in &file.states.0 {
            let entry = format!("states: {name}: derivative");
            derivatives.push(tape.root(entry, &of.derivative)?);
            begins.push(tape.begin(name, of)?);
        }
        let outputs = file.outputs.0.iter();
        let outputs: Result<Vec<_>, _> = outputs.map(|(name, of)| tape.output(name, of)).collect();
        let outputs = outputs?;
        let given = begins.iter().filter_map(|it| match it {
            Begin::Given(root) => Some(root),
            Begin::Sought(_) => None,
        });
        let roots = derivatives
            .iter()
            .chain(given)
            .chain(outputs.iter().map(|it| &it.root));
        check_used(&file, &tape.names, roots)?;
        let tape = tape.tape;
        if unknowns.is_empty() && !begins.iter().any(|it| matches!(it, Begin::Sought(_))) {
            return Err(EquationsError::NothingSought);
        }
        Ok(Self {
            unknowns,
            tape,
            derivatives,
            begins,
            outputs,
            file,
        })
    }

    pub(crate) fn inputs(&self) -> usize {
        self.file.inputs.0.len()
    }

    pub(crate) fn states(&self) -> usize {
        self.derivatives.len()
    }

    /// The slots of the estimated parameters among the variables.
    pub(crate) fn parameters(&self) -> std::ops::Range<usize> {
        let first = self.inputs() + self.states();
        first..first + self.unknowns.len()
    }

    /// The estimated initial states, with their numbers.
    pub(crate) fn sought_states(&self) -> impl Iterator<Item = (usize, &Unknown)> {
        let begins = self.begins.iter().enumerate();
        begins.filter_map(|(state, it)| match it {
            Begin::Sought(unknown) => Some((state, unknown)),
            Begin::Given(_) => None,
        })
    }

    /// Refuses equations with a value that is not finite; the error names the equation and the variables' values.
    pub(crate) fn check_finite(&self, variables: &[f64]) -> Result<(), EquationsError> {
        let mut numbers = Numbers::default();
        self.tape.evaluate(variables, &mut numbers);
        let states = self.file.states.names().zip(&self.derivatives);
        let states = states.map(|(name, root)| (format!("states: {name}: derivative"), root));
        let outputs = self.outputs.iter();
        let outputs = outputs.map(|it| (format!("outputs: {}: equation", it.name), &it.root));
        let bad = states
            .chain(outputs)
            .find(|it| !numbers.value(it.1).is_finite());
        let Some((entry, root)) = bad else {
            return Ok(());
        };
        let names = self.file.inputs.names().chain(self.file.states.names());
        let names = names.chain(self.unknowns.iter().map(|it| &it.name));
        let named = names.zip(variables).enumerate();
        let at = named.filter(|(slot, _)| root.variables.contains(slot));
        let at: Vec<String> = at
            .map(|(_, (name, value))| format!("{name} = {value}"))
            .collect();
        Err(EquationsError::NotFinite {
            entry,
            when: "at the start".to_owned(),
            at: at.join(", "),
        })
    }
}

fn check_counts(file: &EquationsFile) -> Result<(), EquationsError> {
    for (kind, count) in [
        ("inputs", file.inputs.0.len()),
        ("outputs", file.outputs.0.len()),
        ("states", file.states.0.len()),
        ("parameters", file.parameters.0.len()),
    ] {
        if count > MOST {
            let reason = format!("{count} are more than {MOST}");
            return Err(EquationsError::entry(kind, reason));
        }
    }
    if file.outputs.is_empty() {
        return Err(EquationsError::entry("outputs", "there is none"));
    }
    Ok(())
}

/// Refuses a parameter or an input that no equation uses.
fn check_used<'a>(
    file: &EquationsFile,
    binder: &Binder<'_>,
    roots: impl Iterator<Item = &'a Root>,
) -> Result<(), EquationsError> {
    let used: BTreeSet<usize> = roots.flat_map(|it| it.variables.iter().copied()).collect();
    let is_used = |name: &String| match binder.slots.get(name.as_str()) {
        Some(slot) => used.contains(slot),
        None => binder.used.contains(name.as_str()),
    };
    for (kind, mut names) in [
        ("parameters", file.parameters.names().collect::<Vec<_>>()),
        ("inputs", file.inputs.names().collect()),
    ] {
        names.retain(|it| !is_used(it));
        if let Some(name) = names.first() {
            return Err(EquationsError::entry(
                format!("{kind}: {name}"),
                "no equation uses this name; remove it, or correct the name in the equation",
            ));
        }
    }
    Ok(())
}

/// The state while the tape is written.
struct TapeWriter<'a> {
    tape: Tape,
    names: Binder<'a>,
    /// The slots of the states.
    states: std::ops::Range<usize>,
}

impl TapeWriter<'_> {
    fn root(&mut self, entry: String, text: &str) -> Result<Root, EquationsError> {
        let node = parse(text, &mut self.tape, &mut self.names, 0);
        let node = node.map_err(|error| EquationsError::entry(entry, error))?;
        Ok(self.tape.root(node))
    }

    fn begin(&mut self, name: &str, of: &State) -> Result<Begin, EquationsError> {
        let entry = format!("states: {name}: initial");
        let sought = |start: f64, min: Option<f64>, max: Option<f64>| {
            let of = Parameter {
                start: Some(start),
                min,
                max,
                unit: of.unit.clone(),
                ..Parameter::default()
            };
            bounded(&entry, format!("{name}(0)"), &of).map(Begin::Sought)
        };
        match &of.initial {
            Initial::Text(text) if text == UNKNOWN => sought(0.0, None, None),
            Initial::Sought(it) => sought(it.start, it.min, it.max),
            Initial::Known(value) => {
                in_range(&format!("states: {name}"), "initial", Some(*value))?;
                self.root(entry, &value.to_string()).map(Begin::Given)
            }
            Initial::Text(text) => {
                let root = self.root(entry.clone(), text)?;
                let time = self.names.slots[TIME];
                let is_of_states = |slot: &usize| self.states.contains(slot) || *slot == time;
                match root.variables.iter().any(is_of_states) {
                    false => Ok(Begin::Given(root)),
                    true => Err(EquationsError::entry(
                        entry,
                        "an initial state must be 'unknown', a number, or an expression of \
                         parameters and inputs, without states or t",
                    )),
                }
            }
        }
    }

    fn output(&mut self, name: &str, of: &Output) -> Result<OutputEquation, EquationsError> {
        let entry = format!("outputs: {name}");
        in_range(&entry, "noise", of.noise)?;
        if of.noise.is_some_and(|it| it <= 0.0) {
            return Err(EquationsError::entry(
                format!("{entry}: noise"),
                "a standard deviation above 0 is expected",
            ));
        }
        Ok(OutputEquation {
            name: name.to_owned(),
            root: self.root(format!("{entry}: equation"), &of.equation)?,
            noise: of.noise,
        })
    }
}

fn known(name: &str, of: &Parameter, value: f64) -> Result<f64, EquationsError> {
    let entry = format!("parameters: {name}");
    if of.start.or(of.min).or(of.max).is_some() {
        let reason = "a fixed value cannot have start, min or max";
        return Err(EquationsError::entry(entry, reason));
    }
    in_range(&entry, "fixed", Some(value))?;
    Ok(value)
}

/// The largest magnitude of a number in a file: the squares of such numbers are finite.
const LARGEST: f64 = 1e100;

/// Refuses a number that is too large, infinite or NaN.
fn in_range(entry: &str, field: &str, value: Option<f64>) -> Result<(), EquationsError> {
    let Some(value) = value.filter(|it| !(-LARGEST..=LARGEST).contains(it)) else {
        return Ok(());
    };
    let without = match field {
        "min" | "max" => format!("; for no bound leave out {field}"),
        _ => String::new(),
    };
    let reason = format!(
        "{value:e} refused: a number from -{LARGEST:e} to {LARGEST:e} is expected{without}"
    );
    Err(EquationsError::entry(format!("{entry}: {field}"), reason))
}

fn unknown(name: &str, of: &Parameter) -> Result<Unknown, EquationsError> {
    bounded(&format!("parameters: {name}"), name.to_owned(), of)
}

fn bounded(entry: &str, name: String, of: &Parameter) -> Result<Unknown, EquationsError> {
    let refuse = |reason: String| Err(EquationsError::entry(entry, reason));
    for (field, value) in [("start", of.start), ("min", of.min), ("max", of.max)] {
        in_range(entry, field, value)?;
    }
    let bounds = (
        of.min.unwrap_or(f64::NEG_INFINITY),
        of.max.unwrap_or(f64::INFINITY),
    );
    if bounds.0 >= bounds.1 {
        return refuse(format!("min {} is not below max {}", bounds.0, bounds.1));
    }
    let start = match (of.start, of.min, of.max) {
        (Some(start), ..) => start,
        (None, Some(min), Some(max)) if min > 0.0 => (min * max).sqrt(),
        (None, Some(min), Some(max)) => 0.5 * (min + max),
        _ => {
            return refuse(
                "give a start value (start: VALUE, or min and max), or a known value (fixed: VALUE)"
                    .to_owned(),
            );
        }
    };
    if !(bounds.0..=bounds.1).contains(&start) {
        return refuse(format!(
            "start {start} is not within {}..{}",
            bounds.0, bounds.1
        ));
    }
    Ok(Unknown {
        name,
        start,
        bounds,
        unit: of.unit.clone().unwrap_or_default(),
    })
}

/// Refuses names that are used twice, or are invalid.
fn check_names(file: &EquationsFile) -> Result<(), EquationsError> {
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    let named = |kind: &'static str, names: Vec<&String>| {
        let names: Vec<(&'static str, String)> =
            names.into_iter().map(|it| (kind, it.clone())).collect();
        names
    };
    let all = [
        named("inputs", file.inputs.names().collect()),
        named("states", file.states.names().collect()),
        named("parameters", file.parameters.names().collect()),
        named("definitions", file.definitions.names().collect()),
    ];
    let all: Vec<(&str, String)> = all.into_iter().flatten().collect();
    for (kind, name) in &all {
        let entry = || format!("{kind}: {name}");
        let begins = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        if !begins || !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
            let reason =
                "a name has letters, digits and underscores, and does not begin with a digit";
            return Err(EquationsError::entry(entry(), reason));
        }
        if is_reserved(name) || name == TIME {
            let reason =
                "this is the name of a function, of pi, or of the time t; choose another name";
            return Err(EquationsError::entry(entry(), reason));
        }
        if let Some(other) = seen.insert(name, kind) {
            let reason = format!("{other} has this name too; choose another name");
            return Err(EquationsError::entry(entry(), reason));
        }
    }
    Ok(())
}

/// Resolves names while expressions are added to the tape.
struct Binder<'a> {
    slots: BTreeMap<&'a str, usize>,
    fixed: BTreeMap<&'a str, f64>,
    definitions: BTreeMap<&'a str, &'a str>,
    /// The nodes of names.
    nodes: BTreeMap<String, usize>,
    /// Definitions that are being read.
    open: Vec<String>,
    /// Fixed parameters that are used.
    used: BTreeSet<String>,
}

impl Names for Binder<'_> {
    fn node(&mut self, tape: &mut Tape, name: &str, depth: usize) -> Result<usize, String> {
        if self.fixed.contains_key(name) {
            self.used.insert(name.to_owned());
        }
        if let Some(node) = self.nodes.get(name) {
            return Ok(*node);
        }
        let node = if let Some(slot) = self.slots.get(name) {
            tape.variable(*slot)
        } else if let Some(value) = self.fixed.get(name) {
            tape.constant(*value)
        } else if let Some(text) = self.definitions.get(name).copied() {
            if self.open.iter().any(|it| it == name) {
                let circle = [&self.open[..], &[name.to_owned()]].concat();
                return Err(format!("definitions are circular: {}", circle.join(" -> ")));
            }
            self.open.push(name.to_owned());
            let found = parse(text, tape, self, depth);
            self.open.pop();
            found.map_err(|error| match self.open.is_empty() {
                true => error.to_string(),
                false => format!("in definition {name}, {error}"),
            })?
        } else {
            let known = self.slots.keys().chain(self.fixed.keys());
            let known: Vec<&str> = known.chain(self.definitions.keys()).copied().collect();
            let meant = did_you_mean(name, known.iter().copied());
            return Err(format!(
                "'{name}' is not an input, state, parameter or definition{meant}"
            ));
        };
        self.nodes.insert(name.to_owned(), node);
        Ok(node)
    }
}
