//! A vehicle file whose numbers can be changed in place: units, sources and all other text are preserved.

use std::ops::Range;

use planesman_text::yaml;
use planesman_units::Quantity;

use super::file::{self, FileError, FileSchema, PropulsionSection, Square};
use super::vehicle::Vehicle;

/// Groups of numbers.
const GROUPS: [&str; 10] = [
    ALL,
    "added_mass",
    "linear_damping",
    "quadratic_damping",
    "cross_flow",
    "coefficients",
    "fins",
    "thrust",
    THRUST_CENTRE,
    "body",
];

/// The word for every number.
const ALL: &str = "all";
/// The group of the offsets of all positions of propulsion, m.
const THRUST_CENTRE: &str = "thrust_centre";

/// The size of a number that is 0, as a length \[m\], a rate \[1/s\] of linear damping, and a share of quadratic damping: times the mass.
const LENGTH: f64 = 0.02;
const RATE: f64 = 0.2;
const SHARE: f64 = 1.0;

/// A number of a vehicle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Name: a coefficient's own (`Y_uv`), `linear_damping_26` for row 2 and column 6 of a matrix, `fins_1_slope`, `thrust` for the factor
    /// of all thrust, `thrust_centre_z` for the offset of all positions of propulsion, `buoyancy`, `centre_of_gravity_z`.
    pub name: String,
    /// Group: `added_mass` (`X_udot` too), `linear_damping`, `quadratic_damping`, `cross_flow`, `coefficients`, `fins`, `thrust`, `thrust_centre`, `body`.
    pub group: &'static str,
    /// Value in the file's unit; 1 for a factor, 0 for an offset.
    pub value: f64,
    /// The size of the value, in the file's unit; for a value of 0 the size that it may become.
    pub size: f64,
    /// Its places in the file; several for a factor.
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
    /// Whether a fit estimates the number unless other numbers are named: it is not 0, and no entry of the body or of a position.
    #[must_use]
    pub fn is_sought_by_default(&self) -> bool {
        self.value != 0.0 && self.group != "body"
    }

    /// Whether the number is a damping on the diagonal, which feeds energy if its sign is reversed.
    #[must_use]
    pub fn is_damping(&self) -> bool {
        let place = self.name.rsplit('_').next().unwrap_or_default().as_bytes();
        matches!(self.group, "linear_damping" | "quadratic_damping")
            && matches!(place, [i, j] if i == j)
    }

    /// Value at one of its places for a new value of the number.
    fn at(&self, place: &Place, value: f64) -> f64 {
        match self.group {
            "thrust" => place.value * value,
            THRUST_CENTRE => place.value + value,
            _ => value,
        }
    }
}

/// A vehicle file: its text, its parsed content, and its numbers.
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
        let vehicle = schema
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
                    "{}: the alias {} refused: a fit changes each number at its place. Write the value instead of the alias",
                    path.join(".").replace(".[", "["),
                    text[at].trim_end()
                )));
            }
            let Some((name, group, _)) = entry(&mut schema, &path) else {
                continue;
            };
            let Some((written, bytes)) = number(&text, at) else {
                continue;
            };
            let place = Place {
                path,
                bytes,
                value: written,
            };
            if let Some(known) = numbers.iter_mut().find(|it| it.name == name) {
                known.places.push(place);
                continue;
            }
            let value = match group {
                "thrust" => 1.0,
                THRUST_CENTRE => 0.0,
                _ => written,
            };
            let Some(size) = size(&vehicle, &name, group, value) else {
                continue;
            };
            numbers.push(Number {
                value,
                size,
                name,
                group,
                places: vec![place],
            });
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
            .filter(|(_, it)| it.name == word || it.group == word || word == ALL)
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

/// The size of a number: its own, or one of a number that is 0; `None` of a 0 that stays 0.
fn size(vehicle: &Vehicle, name: &str, group: &str, value: f64) -> Option<f64> {
    if value != 0.0 {
        return Some(value.abs());
    }
    let parts = vehicle.parts();
    let body = parts.body.matrix();
    let mass = |i: usize| body[i][i] + parts.added_mass[i][i];
    let row = |text: &str| text.parse().ok().filter(|row| (1..=6).contains(row));
    let of_matrix = |factor: f64| {
        let place = name.rsplit('_').next()?;
        let (i, j): (usize, usize) = (row(place.get(..1)?)?, row(place.get(1..)?)?);
        (i == j).then(|| factor * mass(i - 1))
    };
    match group {
        "linear_damping" => of_matrix(RATE),
        "quadratic_damping" => of_matrix(SHARE),
        "coefficients" => Some(mass(0)),
        THRUST_CENTRE => Some(LENGTH),
        "body" => Some(LENGTH),
        _ => None,
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
        ["propulsion", k, "position", i] => {
            let axis = place(i)?;
            let position = match file.propulsion.get_mut(place(k)?)? {
                PropulsionSection::Thruster { position, .. } => position,
                PropulsionSection::Force { position, .. } => position.as_mut()?,
                _ => return None,
            };
            let name = format!("{THRUST_CENTRE}_{}", AXES.get(axis)?);
            (name, THRUST_CENTRE, Quantity(position.get_mut(axis)?))
        }
        ["buoyancy"] => ("buoyancy".to_owned(), "body", Quantity(&mut file.buoyancy)),
        ["centre_of_gravity", i] => {
            let axis = AXES.get(place(i)?)?;
            let along = &mut file.centre_of_gravity[place(i)?];
            (format!("centre_of_gravity_{axis}"), "body", Quantity(along))
        }
        _ => return None,
    };
    Some((name, group, entry))
}

/// Names of the axes of a position.
const AXES: [&str; 3] = ["x", "y", "z"];

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
