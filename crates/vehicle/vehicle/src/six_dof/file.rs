//! Files of vehicles with six degrees of freedom: YAML; dimensional values have a unit, coefficients and matrices are in SI.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use planesman_text::yaml;
use planesman_units::{Dimension, Quantity, Rule, readers, within};
use serde::Deserialize;

use super::coefficients::{self, Factor, Term};
use super::damping::{CrossFlow, Damping};
use super::fins::{Fin, Section};
use super::hull::Hull;
use super::inertia::{self, Matrix6, RigidBody};
use super::lanes::{Three, cross, six};
use super::propulsion::{Propeller, Propulsor, Thruster};
use super::vehicle::{Parts, Unphysical, Vehicle};
use crate::positive;

/// Built-in vehicles, each with its text.
const BUILT_IN: &[(&str, &str)] = &[
    (
        "remus_100_printed",
        include_str!("../../vehicles/six_dof/remus_100_printed.yaml"),
    ),
    (
        "remus_100_6dof",
        include_str!("../../vehicles/six_dof/remus_100_6dof.yaml"),
    ),
    (
        "bluerov2_heavy",
        include_str!("../../vehicles/six_dof/bluerov2_heavy.yaml"),
    ),
    ("lauv", include_str!("../../vehicles/six_dof/lauv.yaml")),
];

/// Reason why a vehicle is refused.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error(
        "vehicle file '{file}': {reason}; built-in vehicles with six degrees of freedom: {}",
        names()
    )]
    Unreadable {
        /// Its path.
        file: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The text is not YAML of the expected form.
    #[error("vehicle file '{file}': {reason}")]
    Malformed {
        /// Its path.
        file: String,
        /// Field and line.
        reason: String,
    },
    /// A value violates a rule.
    #[error("vehicle file '{file}': {reason}")]
    Refused {
        /// Its path.
        file: String,
        /// Entry, value and rule.
        reason: Unphysical,
    },
}

fn names() -> String {
    built_in().collect::<Vec<_>>().join(", ")
}

/// Names of the built-in vehicles.
pub fn built_in() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// Text of a built-in vehicle.
pub(crate) fn built_in_text(name: &str) -> Option<&'static str> {
    let found = BUILT_IN.iter().find(|(built_in, _)| *built_in == name);
    found.map(|(_, text)| *text)
}

/// Whether the text describes a vehicle with six degrees of freedom: such a file lists its inputs.
pub(crate) fn is_of_six_degrees(text: &str) -> bool {
    let head: Result<Head, _> = yaml::from_str(text);
    head.is_ok_and(|head| head.inputs.is_some())
}

/// The part of a file that distinguishes six degrees of freedom from the vertical plane.
#[derive(Deserialize)]
struct Head {
    inputs: Option<serde::de::IgnoredAny>,
}

/// Loads a built-in vehicle by name, or else the file at that path.
///
/// # Errors
/// [`FileError`], with file, entry, value and rule.
pub fn load(name_or_path: &str) -> Result<Vehicle, FileError> {
    parse(name_or_path, &text(name_or_path)?)
}

/// Text of a built-in vehicle, or else of the file at that path.
pub(super) fn text(name_or_path: &str) -> Result<Cow<'static, str>, FileError> {
    if let Some(text) = built_in_text(name_or_path) {
        return Ok(Cow::Borrowed(text));
    }
    let text = planesman_text::read(Path::new(name_or_path));
    text.map(Cow::Owned)
        .map_err(|reason| FileError::Unreadable {
            file: name_or_path.to_owned(),
            reason,
        })
}

/// Parses the vehicle in `text`; errors name `file`.
///
/// # Errors
/// [`FileError::Malformed`] or [`FileError::Refused`].
pub fn parse(file: &str, text: &str) -> Result<Vehicle, FileError> {
    let vehicle = schema(file, text)?.vehicle();
    vehicle.map_err(|reason| refused(file, reason))
}

/// Parses the content of the file in `text` without conversion.
pub(super) fn schema(file: &str, text: &str) -> Result<FileSchema, FileError> {
    yaml::from_str(text).map_err(|error| FileError::Malformed {
        file: file.to_owned(),
        reason: error.to_string(),
    })
}

pub(super) fn refused(file: &str, reason: Unphysical) -> FileError {
    FileError::Refused {
        file: file.to_owned(),
        reason,
    }
}

readers! {
    any_inertia: Inertia, Rule::Any, or 0.0;
    array 3 place: Length, Rule::Any;
    shape: Number, [1e-3, 1e4];
}

/// Content of a file. The numbers that a fit may change ([`super::EditableFile`]) are checked by [`vehicle`](Self::vehicle), all others
/// when they are read.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileSchema {
    name: String,
    inputs: Vec<Input>,
    #[serde(with = "positive::mass")]
    mass: f64,
    #[serde(with = "positive::force")]
    weight: f64,
    pub(super) buoyancy: Quantity,
    pub(super) centre_of_gravity: [Quantity; 3],
    #[serde(with = "place")]
    centre_of_buoyancy: Three<f64>,
    inertia: Inertia,
    pub(super) added_mass: Option<Square>,
    pub(super) linear_damping: Option<Square>,
    pub(super) quadratic_damping: Option<Square>,
    pub(super) cross_flow: Option<CrossFlow>,
    pub(super) coefficients: Option<CoefficientsSection>,
    #[serde(default)]
    pub(super) fins: Vec<FinSection>,
    #[serde(default)]
    pub(super) propulsion: Vec<PropulsionSection>,
    hull: Option<Hull>,
}

/// An input with its name; `reversed` if the source counts its angle with the opposite sign.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Input {
    name: String,
    /// The input's letters in the names of coefficients: `dr` in `Y_uudr`.
    #[serde(default)]
    letters: String,
    /// Whether the source counts it with the opposite sign.
    #[serde(default)]
    reversed: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Inertia {
    about: About,
    #[serde(with = "positive::inertia")]
    xx: f64,
    #[serde(with = "positive::inertia")]
    yy: f64,
    #[serde(with = "positive::inertia")]
    zz: f64,
    #[serde(default, with = "any_inertia")]
    xy: f64,
    #[serde(default, with = "any_inertia")]
    xz: f64,
    #[serde(default, with = "any_inertia")]
    yz: f64,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum About {
    Origin,
    CentreOfGravity,
}

/// A matrix, given by its diagonal or in full.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Square {
    Diagonal([f64; 6]),
    Full(Box<Matrix6>),
}

impl Square {
    fn matrix(&self, entry: &str) -> Result<Matrix6, Unphysical> {
        let matrix = match self {
            Self::Full(matrix) => **matrix,
            Self::Diagonal(diagonal) => std::array::from_fn(|i| {
                std::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 })
            }),
        };
        for value in matrix.iter().flatten() {
            number(entry, *value, [-MOST_COEFFICIENT, MOST_COEFFICIENT])?;
        }
        Ok(matrix)
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CoefficientsSection {
    /// Whether the table includes the products of added mass, such as `X_wq` and `M_uw`; otherwise they are computed in addition.
    includes_added_mass: bool,
    pub(super) values: BTreeMap<String, f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FinSection {
    input: String,
    #[serde(with = "place")]
    position: Three<f64>,
    chord: Three<f64>,
    normal: Three<f64>,
    #[serde(with = "positive::area")]
    area: f64,
    #[serde(with = "positive::density")]
    density: f64,
    pub(super) slope: f64,
    pub(super) drag: f64,
    #[serde(with = "shape")]
    oswald: f64,
    #[serde(with = "shape")]
    aspect: f64,
    #[serde(with = "positive::angle")]
    stall: f64,
    #[serde(with = "shape")]
    sharpness: f64,
}

/// A propulsor. The parser's errors do not name a field in a form selected by `kind`; [`Self::propulsor`] checks these fields.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PropulsionSection {
    Constant {
        force: Quantity,
        moment: Quantity,
    },
    Force {
        input: String,
        limits: [Quantity; 2],
        #[serde(default)]
        axis: Axis,
        position: Option<[Quantity; 3]>,
    },
    Propeller {
        input: String,
        density: Quantity,
        diameter: Quantity,
        thrust: [f64; 2],
        torque: [f64; 2],
        wake: f64,
        deduction: f64,
        hand: Hand,
        full_rotation: Option<Quantity>,
    },
    Thruster {
        input: String,
        position: [Quantity; 3],
        direction: Three<f64>,
        curve: Vec<f64>,
        #[serde(default)]
        dead_zone: f64,
        lag: Option<Quantity>,
    },
}

/// The force or moment that an input is, with the symbols of SNAME.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
pub(super) enum Axis {
    #[default]
    X,
    Y,
    Z,
    K,
    M,
    N,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Hand {
    Right,
    Left,
}

/// Largest magnitude of a coefficient or matrix entry, SI; entries of ships are smaller.
const MOST_COEFFICIENT: f64 = 1e15;

/// Converts a quantity to SI and checks its rule.
fn si(entry: &str, q: &Quantity, dimension: Dimension, rule: Rule) -> Result<f64, Unphysical> {
    q.by_rule(dimension, rule)
        .map_err(|rule| Unphysical::new(entry, format!("{q} refused: {rule}")))
}

/// Checks the range of a number without a unit.
fn number(entry: &str, value: f64, range: [f64; 2]) -> Result<f64, Unphysical> {
    within(value, range, "")
        .map_err(|rule| Unphysical::new(entry, format!("{value} refused: {rule}")))
}

fn above_zero(entry: &str, q: &Quantity, dimension: Dimension) -> Result<f64, Unphysical> {
    si(entry, q, dimension, Rule::AboveZero)
}

fn metres(entry: &str, [x, y, z]: &[Quantity; 3]) -> Result<Three<f64>, Unphysical> {
    let metres = |q| si(entry, q, Dimension::Length, Rule::Any);
    Ok([metres(x)?, metres(y)?, metres(z)?])
}

/// Normalizes a direction to length 1.
fn direction(entry: &str, [x, y, z]: Three<f64>) -> Result<Three<f64>, Unphysical> {
    let length = (x * x + y * y + z * z).sqrt();
    match length > 0.0 && length.is_finite() {
        true => Ok([x / length, y / length, z / length]),
        false => Err(Unphysical::new(
            entry,
            format!("{:?} is not a direction", [x, y, z]),
        )),
    }
}

impl FileSchema {
    /// Creates the vehicle of this file.
    ///
    /// # Errors
    /// [`Unphysical`]: the entry, its value and the rule that it breaks.
    pub(super) fn vehicle(&self) -> Result<Vehicle, Unphysical> {
        let input = |entry: &str, name: &str| {
            let place = self.inputs.iter().position(|input| input.name == name);
            place.ok_or_else(|| Unphysical::new(entry, format!("'{name}' is not an input")))
        };
        let matrix = |square: &Option<Square>, entry| {
            (square.as_ref()).map_or(Ok(Matrix6::default()), |square| square.matrix(entry))
        };
        let (added_mass, terms) = self.added_mass_and_terms()?;
        let fins = self.fins.iter().enumerate();
        let fins = fins.map(|(k, fin)| fin.fin(&format!("fins[{k}]"), &input));
        let propulsors = self.propulsion.iter().enumerate();
        let propulsors =
            propulsors.map(|(k, it)| it.propulsor(&format!("propulsion[{k}]"), &input));
        let buoyancy = above_zero("buoyancy", &self.buoyancy, Dimension::Force)?;
        if let Some(strips) = &self.cross_flow {
            if strips.ends[0] >= strips.ends[1] {
                let reason = "its ends must be given aft first, then fore";
                return Err(Unphysical::new("cross_flow", reason));
            }
            number("cross_flow.drag", strips.drag, [0.0, 1e3])?;
        }
        Vehicle::new(Parts {
            body: self.body()?,
            weight: self.weight,
            buoyancy,
            hull: self.hull.unwrap_or_else(|| Hull::of_buoyancy(buoyancy)),
            centre_of_buoyancy: self.centre_of_buoyancy,
            added_mass,
            damping: Damping {
                linear: matrix(&self.linear_damping, "linear_damping")?,
                quadratic: matrix(&self.quadratic_damping, "quadratic_damping")?,
            },
            cross_flow: self.cross_flow.into_iter().collect(),
            terms,
            fins: fins.collect::<Result<_, _>>()?,
            propulsors: propulsors.collect::<Result<_, _>>()?,
            inputs: self.inputs.iter().map(|input| input.name.clone()).collect(),
            name: self.name.clone(),
        })
    }

    fn body(&self) -> Result<RigidBody, Unphysical> {
        let centre_of_gravity = metres("centre_of_gravity", &self.centre_of_gravity)?;
        let Inertia { xx, yy, zz, .. } = self.inertia;
        let Inertia { xy, xz, yz, .. } = self.inertia;
        let inertia = [[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]];
        Ok(RigidBody {
            mass: self.mass,
            centre_of_gravity,
            inertia: match self.inertia.about {
                About::Origin => inertia,
                About::CentreOfGravity => {
                    inertia::about_origin(inertia, self.mass, centre_of_gravity)
                }
            },
        })
    }

    /// Added mass, and the coefficients beyond it.
    fn added_mass_and_terms(&self) -> Result<(Matrix6, Vec<Term>), Unphysical> {
        let letters: Vec<&str> = self.inputs.iter().map(|it| it.letters.as_str()).collect();
        let mut terms = Vec::new();
        for (name, value) in self.coefficients.iter().flat_map(|it| &it.values) {
            let entry = format!("coefficients.{name}");
            number(&entry, *value, [-MOST_COEFFICIENT, MOST_COEFFICIENT])?;
            let mut term = coefficients::term(name, *value, &letters)
                .map_err(|e| Unphysical::new(entry, e.to_string()))?;
            if let Factor::Input(k) = term.of {
                term.value *= if self.inputs[k].reversed { -1.0 } else { 1.0 };
            }
            terms.push(term);
        }
        let added_mass = match &self.added_mass {
            Some(matrix) => matrix.matrix("added_mass")?,
            None => coefficients::added_mass(&terms),
        };
        match &self.coefficients {
            Some(section) if section.includes_added_mass => {
                terms = coefficients::beyond_added_mass(&terms, &added_mass);
            }
            _ => terms.retain(|term| !matches!(term.of, Factor::Acceleration(_))),
        }
        Ok((added_mass, terms))
    }
}

/// Index of an input, from the entry and the name it contains.
trait FindInput: Fn(&str, &str) -> Result<usize, Unphysical> {}
impl<F: Fn(&str, &str) -> Result<usize, Unphysical>> FindInput for F {}

impl FinSection {
    fn fin(&self, entry: &str, input: &impl FindInput) -> Result<Fin, Unphysical> {
        let at = |field: &str| format!("{entry}.{field}");
        let chord = direction(&at("chord"), self.chord)?;
        let normal = direction(&at("normal"), self.normal)?;
        if super::lanes::dot(chord, normal).abs() > 1e-9 {
            return Err(Unphysical::new(
                at("normal"),
                "the normal must be perpendicular to the chord",
            ));
        }
        Ok(Fin {
            input: input(&at("input"), &self.input)?,
            position: self.position,
            chord,
            normal,
            area: self.area,
            density: self.density,
            section: Section {
                slope: number(&at("slope"), self.slope, [1e-3, 1e4])?,
                drag: number(&at("drag"), self.drag, [0.0, 1e3])?,
                oswald: self.oswald,
                aspect: self.aspect,
                stall: self.stall,
                sharpness: self.sharpness,
            },
        })
    }
}

impl PropulsionSection {
    fn propulsor(&self, entry: &str, find: &impl FindInput) -> Result<Propulsor, Unphysical> {
        let at = |field: &str| format!("{entry}.{field}");
        let si = |field: &str, q, dimension| si(&at(field), q, dimension, Rule::Any);
        let above_zero = |field: &str, q, dimension| above_zero(&at(field), q, dimension);
        let number = |field: &str, value, range| number(&at(field), value, range);
        Ok(match self {
            Self::Constant { force, moment } => Propulsor::Constant {
                force: si("force", force, Dimension::Force)?,
                moment: si("moment", moment, Dimension::Moment)?,
            },
            Self::Force {
                input,
                limits,
                axis,
                position,
            } => force(
                entry,
                find(&at("input"), input)?,
                limits,
                (*axis, position.as_ref()),
            )?,
            Self::Propeller {
                input,
                density,
                diameter,
                thrust,
                torque,
                wake,
                deduction,
                hand,
                full_rotation,
            } => {
                let pair = |field: &str, [k0, k1]: [f64; 2]| -> Result<_, Unphysical> {
                    let one = |k| number(field, k, [-1e3, 1e3]);
                    Ok([one(k0)?, one(k1)?])
                };
                let rotation = |q| above_zero("full_rotation", q, Dimension::Rate);
                Propulsor::Propeller {
                    input: find(&at("input"), input)?,
                    propeller: Propeller {
                        density: above_zero("density", density, Dimension::Density)?,
                        diameter: above_zero("diameter", diameter, Dimension::Length)?,
                        thrust: pair("thrust", *thrust)?,
                        torque: pair("torque", *torque)?,
                        wake: number("wake", *wake, [-1.0, 1.0])?,
                        deduction: number("deduction", *deduction, [-1.0, 1.0])?,
                        hand: match hand {
                            Hand::Right => 1.0,
                            Hand::Left => -1.0,
                        },
                        full_rotation: full_rotation.as_ref().map(rotation).transpose()?,
                    },
                }
            }
            Self::Thruster {
                input,
                position,
                direction: push,
                curve,
                dead_zone,
                lag,
            } => {
                let lag = lag.as_ref().map(|q| above_zero("lag", q, Dimension::Time));
                let curve = curve.iter().map(|k| number("curve", *k, [-1e9, 1e9]));
                Propulsor::Thruster {
                    input: find(&at("input"), input)?,
                    thruster: Thruster {
                        position: metres(&at("position"), position)?,
                        direction: direction(&at("direction"), *push)?,
                        curve: curve.collect::<Result<_, _>>()?,
                        dead_zone: number("dead_zone", *dead_zone, [0.0, 1.0])?,
                        lag: lag.transpose()?.unwrap_or(0.0),
                    },
                }
            }
        })
    }
}

/// A force or moment that is an input, at a position.
fn force(
    entry: &str,
    input: usize,
    limits: &[Quantity; 2],
    (axis, position): (Axis, Option<&[Quantity; 3]>),
) -> Result<Propulsor, Unphysical> {
    let at = |field: &str| format!("{entry}.{field}");
    let place = axis as usize;
    let is_force = place < 3;
    let dimension = match is_force {
        true => Dimension::Force,
        false => Dimension::Moment,
    };
    let limit = |q| si(&at("limits"), q, dimension, Rule::Any);
    let limits = [limit(&limits[0])?, limit(&limits[1])?];
    if limits[0] >= limits[1] {
        let reason = format!("{limits:?} refused: the first limit must be below the second");
        return Err(Unphysical::new(at("limits"), reason));
    }
    let position = match position {
        Some(_) if !is_force => {
            let reason = "a moment acts at no position";
            return Err(Unphysical::new(at("position"), reason));
        }
        Some(position) => metres(&at("position"), position)?,
        None => [0.0; 3],
    };
    let unit: Three<f64> = std::array::from_fn(|i| if i == place % 3 { 1.0 } else { 0.0 });
    Ok(Propulsor::Force {
        input,
        limits,
        wrench: match is_force {
            true => six(unit, cross(position, unit)),
            false => six([0.0; 3], unit),
        },
    })
}
