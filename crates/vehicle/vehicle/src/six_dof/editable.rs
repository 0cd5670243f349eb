//! A vehicle file whose numbers are changed where they stand: units, sources and everything else of the text stay.

use std::ops::Range;

use super::file::{self, FileError};
use super::vehicle::Vehicle;

/// Numbers that are named together.
const GROUPS: [&str; 8] = [
    "added_mass",
    "linear_damping",
    "quadratic_damping",
    "cross_flow",
    "coefficients",
    "fins",
    "thrust",
    "body",
];

/// A number of a vehicle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its name: a coefficient's own (`Y_uv`), `linear_damping_26` for row 2 and column 6 of a matrix, `fins_1_slope`, `thrust` for the
    /// factor of all thrust, `buoyancy`, `centre_of_gravity_z`.
    pub name: String,
    /// What it belongs to: `added_mass` (`X_udot` too), `linear_damping`, `quadratic_damping`, `cross_flow`, `coefficients`, `fins`, `thrust`, `body`.
    pub group: &'static str,
    /// Its value, in the file's unit; 1 for a factor.
    pub value: f64,
    /// Where it stands; several numbers for a factor.
    places: Vec<Range<usize>>,
}

/// A vehicle file as text, with the numbers in it that are not 0.
#[derive(Clone, Debug)]
pub struct EditableFile {
    file: String,
    text: String,
    numbers: Vec<Number>,
}

/// A change of a number: its place in [`EditableFile::numbers`], and its new value.
pub type Change = (usize, f64);

impl EditableFile {
    /// A built-in vehicle by its name, or else the one in the file at that path.
    ///
    /// # Errors
    /// [`FileError`], as of [`file::load`].
    pub fn load(name_or_path: &str) -> Result<Self, FileError> {
        let text = file::text(name_or_path)?.into_owned();
        file::parse(name_or_path, &text)?;
        let places =
            planesman_text::yaml::scalars(&text).map_err(|error| FileError::Malformed {
                file: name_or_path.to_owned(),
                reason: error.to_string(),
            })?;
        let mut numbers: Vec<Number> = Vec::new();
        for (path, place) in places {
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            let Some((name, group)) = named(&path) else {
                continue;
            };
            let Some((value, place)) = number(&text, place).filter(|it| it.0 != 0.0) else {
                continue;
            };
            match numbers.iter_mut().find(|it| it.name == name) {
                Some(factor) => factor.places.push(place),
                None => numbers.push(Number {
                    value: if group == "thrust" { 1.0 } else { value },
                    name,
                    group,
                    places: vec![place],
                }),
            }
        }
        Ok(Self {
            file: name_or_path.to_owned(),
            text,
            numbers,
        })
    }

    /// The numbers, in the order of the file.
    #[must_use]
    pub fn numbers(&self) -> &[Number] {
        &self.numbers
    }

    /// Those that a word names: a number's name or a group; `None` when it is neither.
    #[must_use]
    pub fn named(&self, word: &str) -> Option<Vec<usize>> {
        let all = self.numbers.iter().enumerate();
        let found: Vec<usize> = all
            .filter(|(_, it)| it.name == word || it.group == word)
            .map(|it| it.0)
            .collect();
        (!found.is_empty() || GROUPS.contains(&word)).then_some(found)
    }

    /// The vehicle with some numbers changed.
    ///
    /// # Errors
    /// [`FileError::Refused`] when it is not physical.
    pub fn vehicle(&self, changes: &[Change]) -> Result<Vehicle, FileError> {
        file::parse(&self.file, &self.changed(changes, None))
    }

    /// The text with some numbers changed, each with a remark (`95 % +- 0.2`) in place of the line's own; `name` is the new vehicle's, `head` a comment above it.
    #[must_use]
    pub fn text(&self, name: &str, head: &str, changes: &[(Change, String)]) -> String {
        let (changes, remarks): (Vec<Change>, Vec<String>) = changes.iter().cloned().unzip();
        let text = self.changed(&changes, Some(&remarks));
        let named = text.lines().map(|line| match line.starts_with("name:") {
            true => format!("name: {name}"),
            false => line.to_owned(),
        });
        let head = head.lines().map(|line| format!("# {line}"));
        let lines: Vec<String> = head.chain(["#".to_owned()]).chain(named).collect();
        lines.join("\n") + "\n"
    }

    fn changed(&self, changes: &[Change], remarks: Option<&[String]>) -> String {
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        for (k, (place, value)) in changes.iter().enumerate() {
            let of = &self.numbers[*place];
            for at in &of.places {
                let before = self.text[at.clone()].parse::<f64>().unwrap_or(of.value);
                let after = match of.group {
                    "thrust" => before * value,
                    _ => *value,
                };
                let written = match remarks {
                    // Digits beyond any interval.
                    Some(_) => format!("{after:.7e}").parse().unwrap_or(after),
                    None => after,
                };
                edits.push((at.clone(), written.to_string()));
            }
            let last = of.places.last().map_or(0, |it| it.end);
            if let Some(remark) = remarks.map(|it| &it[k]) {
                let rest = self.text[last..].split('\n').next().unwrap_or_default();
                let remark = format!("{}: {remark}", of.name);
                let from = last + rest.find(" #").unwrap_or(rest.len());
                let end = last + rest.len();
                match edits.iter_mut().find(|it| it.0 == (from..end)) {
                    Some((_, text)) => *text += &format!("; {remark}"),
                    None => edits.push((from..end, format!("  # fitted, {remark}"))),
                }
            }
        }
        edits.sort_by_key(|it| it.0.start);
        let mut text = String::with_capacity(self.text.len() + 64 * edits.len());
        let mut from = 0;
        for (at, new) in edits {
            let between = &self.text[from..at.start];
            text += match new.starts_with("  #") {
                true => between.trim_end_matches(' '),
                false => between,
            };
            text += &new;
            from = at.end;
        }
        text + &self.text[from..]
    }
}

/// The name and group of what a path leads to; `None` for what is no coefficient.
fn named(path: &[&str]) -> Option<(String, &'static str)> {
    let place = |text: &str| -> Option<usize> {
        let place = text.strip_prefix('[')?.strip_suffix(']')?;
        place.parse().ok()
    };
    let matrix = |group: &'static str, i: usize, j: usize| {
        Some((format!("{group}_{}{}", i + 1, j + 1), group))
    };
    match *path {
        ["coefficients", "values", name] => {
            let derivative = name.strip_suffix("dot").and_then(|it| it.split_once('_'));
            match derivative {
                // Of a pair off the diagonal both would have to change.
                Some(pair) if !DIAGONAL.contains(&pair) => None,
                Some(_) => Some((name.to_owned(), "added_mass")),
                None => Some((name.to_owned(), "coefficients")),
            }
        }
        ["added_mass", i] => matrix("added_mass", place(i)?, place(i)?),
        ["added_mass", i, j] if i == j => matrix("added_mass", place(i)?, place(j)?),
        ["linear_damping", i] => matrix("linear_damping", place(i)?, place(i)?),
        ["linear_damping", i, j] => matrix("linear_damping", place(i)?, place(j)?),
        ["quadratic_damping", i] => matrix("quadratic_damping", place(i)?, place(i)?),
        ["quadratic_damping", i, j] => matrix("quadratic_damping", place(i)?, place(j)?),
        ["cross_flow", "drag"] => Some(("cross_flow_drag".to_owned(), "cross_flow")),
        ["fins", k, of @ ("slope" | "drag")] => {
            Some((format!("fins_{}_{of}", place(k)? + 1), "fins"))
        }
        ["propulsion", _, "curve" | "thrust", _] | ["propulsion", _, "force"] => {
            Some(("thrust".to_owned(), "thrust"))
        }
        ["buoyancy"] => Some(("buoyancy".to_owned(), "body")),
        ["centre_of_gravity", i] => {
            let axis = ["x", "y", "z"].get(place(i)?)?;
            Some((format!("centre_of_gravity_{axis}"), "body"))
        }
        _ => None,
    }
}

const DIAGONAL: [(&str, &str); 6] = [
    ("X", "u"),
    ("Y", "v"),
    ("Z", "w"),
    ("K", "p"),
    ("M", "q"),
    ("N", "r"),
];

/// The number that a scalar begins with, and its bytes; a unit may follow.
fn number(text: &str, at: Range<usize>) -> Option<(f64, Range<usize>)> {
    let scalar = text[at.clone()].trim_end();
    let length = scalar
        .find(|c: char| !c.is_ascii_digit() && !"+-.eE".contains(c))
        .unwrap_or(scalar.len());
    let value = scalar[..length].parse().ok()?;
    Some((value, at.start..at.start + length))
}
