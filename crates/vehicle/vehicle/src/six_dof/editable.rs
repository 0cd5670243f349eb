//! A vehicle file whose numbers can be changed in place: units, sources and all other text are preserved.

use std::ops::Range;

use planesman_text::yaml;
use planesman_units::Quantity;

use super::file::{self, FileError, FileSchema, PropulsionSection, Square};
use super::vehicle::Vehicle;

/// Groups of numbers.
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
    /// Name: a coefficient's own (`Y_uv`), `linear_damping_26` for row 2 and column 6 of a matrix, `fins_1_slope`, `thrust` for the factor
    /// of all thrust, `buoyancy`, `centre_of_gravity_z`.
    pub name: String,
    /// Group: `added_mass` (`X_udot` too), `linear_damping`, `quadratic_damping`, `cross_flow`, `coefficients`, `fins`, `thrust`, `body`.
    pub group: &'static str,
    /// Value in the file's unit; 1 for a factor.
    pub value: f64,
    /// Places of the number in the file; several places for a factor.
    places: Vec<Place>,
}

/// Place of a number in a file.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    path: Vec<String>,
    bytes: Range<usize>,
    /// Value there, in the file's unit.
    value: f64,
}

impl Number {
    /// Value to write at one of the places, for a new value of the number.
    fn at(&self, place: &Place, value: f64) -> f64 {
        match self.group {
            "thrust" => place.value * value,
            _ => value,
        }
    }
}

/// A vehicle file: its text, its parsed content, and its numbers that are not 0.
#[derive(Clone, Debug)]
pub struct EditableFile {
    file: String,
    text: String,
    schema: FileSchema,
    numbers: Vec<Number>,
}

/// Change of a number: its index in [`EditableFile::numbers`], and its new value.
pub type Change = (usize, f64);

impl EditableFile {
    /// Loads a built-in vehicle by name, or else the file at that path.
    ///
    /// # Errors
    /// [`FileError`], as in [`file::load`].
    pub fn load(name_or_path: &str) -> Result<Self, FileError> {
        let text = file::text(name_or_path)?.into_owned();
        let mut schema = file::schema(name_or_path, &text)?;
        schema
            .vehicle()
            .map_err(|reason| file::refused(name_or_path, reason))?;
        let malformed = |reason| FileError::Malformed {
            file: name_or_path.to_owned(),
            reason,
        };
        let scalars = yaml::scalars(&text).map_err(|error| malformed(error.to_string()))?;
        let mut numbers: Vec<Number> = Vec::new();
        for (path, at) in scalars {
            // What is changed at its anchor would change here too.
            if text[at.clone()].starts_with('*') {
                return Err(malformed(format!(
                    "{}: the alias {} refused: a fit changes each number at its place; write the \
                     value instead of the alias",
                    path.join(".").replace(".[", "["),
                    text[at].trim_end()
                )));
            }
            let Some((name, group, _)) = entry(&mut schema, &path) else {
                continue;
            };
            let Some((value, bytes)) = number(&text, at).filter(|it| it.0 != 0.0) else {
                continue;
            };
            let place = Place { path, bytes, value };
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
            schema,
            numbers,
        })
    }

    /// The numbers, in the order of the file.
    #[must_use]
    pub fn numbers(&self) -> &[Number] {
        &self.numbers
    }

    /// Indices of the number or group with this name; `None` if the name is unknown.
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
    /// [`FileError::Refused`], if it is not physical.
    pub fn vehicle(&self, changes: &[Change]) -> Result<Vehicle, FileError> {
        let mut schema = self.schema.clone();
        for (index, value) in changes {
            let of = &self.numbers[*index];
            for place in &of.places {
                if let Some((.., entry)) = entry(&mut schema, &place.path) {
                    entry.set(of.at(place, *value));
                }
            }
        }
        let vehicle = schema.vehicle();
        vehicle.map_err(|reason| file::refused(&self.file, reason))
    }

    /// The text with some numbers changed. Each change has a remark (`95 % +- 0.2`) that replaces the line's comment; `name` is the new
    /// vehicle's name, `head` a comment above it.
    #[must_use]
    pub fn text(&self, name: &str, head: &str, changes: &[(Change, String)]) -> String {
        let text = self.changed(changes);
        let named = text.lines().map(|line| match line.starts_with("name:") {
            true => format!("name: {name}"),
            false => line.to_owned(),
        });
        let head = head.lines().map(|line| format!("# {line}"));
        let lines: Vec<String> = head.chain(["#".to_owned()]).chain(named).collect();
        lines.join("\n") + "\n"
    }

    fn changed(&self, changes: &[(Change, String)]) -> String {
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        for ((index, value), remark) in changes {
            let of = &self.numbers[*index];
            for place in &of.places {
                let after = of.at(place, *value);
                // Digits beyond any interval.
                let written: f64 = format!("{after:.7e}").parse().unwrap_or(after);
                edits.push((place.bytes.clone(), written.to_string()));
            }
            let last = of.places.last().map_or(0, |it| it.bytes.end);
            let rest = self.text[last..].split('\n').next().unwrap_or_default();
            let own = rest.find(" #").unwrap_or(rest.len());
            let comment = last + rest[..own].trim_end_matches(' ').len()..last + rest.len();
            let remark = format!("{}: {remark}", of.name);
            match edits.iter_mut().find(|it| it.0 == comment) {
                Some((_, text)) => *text += &format!("; {remark}"),
                None => edits.push((comment, format!("  # fitted, {remark}"))),
            }
        }
        edits.sort_by_key(|it| it.0.start);
        yaml::edited(&self.text, edits)
    }
}

/// A number of a file that can be changed.
enum Entry<'a> {
    Number(&'a mut f64),
    Quantity(&'a mut Quantity),
}

impl Entry<'_> {
    /// Sets the number, in the file's unit.
    fn set(self, value: f64) {
        match self {
            Self::Number(number) => *number = value,
            Self::Quantity(quantity) => *quantity = quantity.with_number(value),
        }
    }
}

/// The entry at a path, with its name and group; `None` if it is not a coefficient.
fn entry<'a>(
    file: &'a mut FileSchema,
    path: &[String],
) -> Option<(String, &'static str, Entry<'a>)> {
    use Entry::{Number, Quantity};
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    let (name, group, entry) = match path[..] {
        ["coefficients", "values", name] => {
            let derivative = name.strip_suffix("dot").and_then(|it| it.split_once('_'));
            let group = match derivative {
                // Of a pair off the diagonal both would have to change.
                Some(pair) if !DIAGONAL.contains(&pair) => return None,
                Some(_) => "added_mass",
                None => "coefficients",
            };
            let values = &mut file.coefficients.as_mut()?.values;
            (name.to_owned(), group, Number(values.get_mut(name)?))
        }
        ["added_mass", first, ref second @ ..] if second.first().is_none_or(|it| *it == first) => {
            matrix_entry("added_mass", &mut file.added_mass, &path)?
        }
        ["linear_damping", ..] => matrix_entry("linear_damping", &mut file.linear_damping, &path)?,
        ["quadratic_damping", ..] => {
            matrix_entry("quadratic_damping", &mut file.quadratic_damping, &path)?
        }
        ["cross_flow", "drag"] => {
            let drag = &mut file.cross_flow.as_mut()?.drag;
            ("cross_flow_drag".to_owned(), "cross_flow", Number(drag))
        }
        ["fins", k, of @ ("slope" | "drag")] => {
            let fin = file.fins.get_mut(place(k)?)?;
            let number = if of == "slope" {
                &mut fin.slope
            } else {
                &mut fin.drag
            };
            let name = format!("fins_{}_{of}", place(k)? + 1);
            (name, "fins", Number(number))
        }
        [
            "propulsion",
            k,
            of @ ("curve" | "thrust" | "force"),
            ref rest @ ..,
        ] => {
            let index = rest.first().map(|it| place(it));
            let entry = match (file.propulsion.get_mut(place(k)?)?, of, index) {
                (PropulsionSection::Constant { force, .. }, "force", None) => Quantity(force),
                (PropulsionSection::Propeller { thrust, .. }, "thrust", Some(i)) => {
                    Number(thrust.get_mut(i?)?)
                }
                (PropulsionSection::Thruster { curve, .. }, "curve", Some(i)) => {
                    Number(curve.get_mut(i?)?)
                }
                _ => return None,
            };
            ("thrust".to_owned(), "thrust", entry)
        }
        ["buoyancy"] => ("buoyancy".to_owned(), "body", Quantity(&mut file.buoyancy)),
        ["centre_of_gravity", i] => {
            let axis = ["x", "y", "z"].get(place(i)?)?;
            let along = &mut file.centre_of_gravity[place(i)?];
            (format!("centre_of_gravity_{axis}"), "body", Quantity(along))
        }
        _ => return None,
    };
    Some((name, group, entry))
}

/// Index in a list, from the form `[3]`.
fn place(text: &str) -> Option<usize> {
    let place = text.strip_prefix('[')?.strip_suffix(']')?;
    place.parse().ok()
}

/// The entry of a matrix at a path.
fn matrix_entry<'a>(
    group: &'static str,
    matrix: &'a mut Option<Square>,
    path: &[&str],
) -> Option<(String, &'static str, Entry<'a>)> {
    let (i, j, number) = match (matrix.as_mut()?, path) {
        (Square::Diagonal(diagonal), [_, i]) => {
            let i = place(i)?;
            (i, i, diagonal.get_mut(i)?)
        }
        (Square::Full(rows), [_, i, j]) => {
            let (i, j) = (place(i)?, place(j)?);
            (i, j, rows.get_mut(i)?.get_mut(j)?)
        }
        _ => return None,
    };
    let name = format!("{group}_{}{}", i + 1, j + 1);
    Some((name, group, Entry::Number(number)))
}

const DIAGONAL: [(&str, &str); 6] = [
    ("X", "u"),
    ("Y", "v"),
    ("Z", "w"),
    ("K", "p"),
    ("M", "q"),
    ("N", "r"),
];

/// The number at the start of a scalar, and its bytes; a unit may follow.
fn number(text: &str, at: Range<usize>) -> Option<(f64, Range<usize>)> {
    let scalar = text[at.clone()].trim_end();
    let length = scalar
        .find(|c: char| !c.is_ascii_digit() && !"+-.eE".contains(c))
        .unwrap_or(scalar.len());
    let value = scalar[..length].parse().ok()?;
    Some((value, at.start..at.start + length))
}
