//! Files of vehicles of six degrees of freedom: YAML, each dimensional value with its unit, coefficients and matrices in SI.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use planesman_units::{Dimension, Quantity, within};
use serde::Deserialize;

use super::coefficients::{self, Factor};
use super::damping::{CrossFlow, Damping};
use super::fins::{Fin, Section};
use super::hull::Hull;
use super::inertia::{self, Matrix6, RigidBody};
use super::lanes::Three;
use super::propulsion::{Propeller, Propulsor, Thruster};
use super::vehicle::{Parts, Unphysical, Vehicle};

/// The vehicles that need no file, each with its text.
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

/// Why a vehicle was not taken.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file could not be read.
    #[error(
        "vehicle file '{file}': {reason} (built in with six degrees of freedom are {})",
        names()
    )]
    Unreadable {
        /// Its path.
        file: String,
        /// The system's error.
        reason: std::io::Error,
    },
    /// The text is not YAML of the right form.
    #[error("vehicle file '{file}': {reason}")]
    Malformed {
        /// Its path.
        file: String,
        /// The field and the line.
        reason: String,
    },
    /// A value breaks a rule.
    #[error("vehicle file '{file}': {reason}")]
    Refused {
        /// Its path.
        file: String,
        /// The entry, its value and the rule.
        reason: Unphysical,
    },
}

fn names() -> String {
    built_in().collect::<Vec<_>>().join(", ")
}

/// The names of the vehicles that need no file.
pub fn built_in() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// The text of a built-in vehicle.
pub(crate) fn built_in_text(name: &str) -> Option<&'static str> {
    let found = BUILT_IN.iter().find(|(built_in, _)| *built_in == name);
    found.map(|(_, text)| *text)
}

/// Whether the text of a file is of a vehicle of six degrees: it names its inputs.
pub(crate) fn is_of_six_degrees(text: &str) -> bool {
    let head: Result<Head, _> = planesman_text::yaml::from_str(text);
    head.is_ok_and(|head| head.inputs.is_some())
}

/// What tells a file of six degrees from one of the plane.
#[derive(Deserialize)]
struct Head {
    inputs: Option<serde::de::IgnoredAny>,
}

/// A built-in vehicle by its name, or else the one in the file at that path.
///
/// # Errors
/// [`FileError`], which names the file, the entry, the value and the rule.
pub fn load(name_or_path: &str) -> Result<Vehicle, FileError> {
    parse(name_or_path, &text(name_or_path)?)
}

/// The text of a built-in vehicle, or else of the file at that path.
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

/// The vehicle in `text`; `file` is named in errors.
///
/// # Errors
/// [`FileError::Malformed`] or [`FileError::Refused`].
pub fn parse(file: &str, text: &str) -> Result<Vehicle, FileError> {
    let written: Written =
        planesman_text::yaml::from_str(text).map_err(|e| FileError::Malformed {
            file: file.to_owned(),
            reason: e.to_string(),
        })?;
    written.vehicle().map_err(|reason| FileError::Refused {
        file: file.to_owned(),
        reason,
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    inputs: Vec<Input>,
    mass: Quantity,
    weight: Quantity,
    buoyancy: Quantity,
    centre_of_gravity: [Quantity; 3],
    centre_of_buoyancy: [Quantity; 3],
    inertia: Inertia,
    added_mass: Option<Square>,
    linear_damping: Option<Square>,
    quadratic_damping: Option<Square>,
    cross_flow: Option<CrossFlowSection>,
    coefficients: Option<CoefficientsSection>,
    #[serde(default)]
    fins: Vec<FinSection>,
    #[serde(default)]
    propulsion: Vec<PropulsionSection>,
    hull: Option<HullSection>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HullSection {
    length: Quantity,
    width: Quantity,
    height: Quantity,
}

/// An input by its name; a source that counts its angle to the other side says so.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Input {
    name: String,
    /// Its letters in the names of coefficients: `dr` in `Y_uudr`.
    #[serde(default)]
    letters: String,
    /// The source counts it positive to the other side.
    #[serde(default)]
    reversed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Inertia {
    about: About,
    xx: Quantity,
    yy: Quantity,
    zz: Quantity,
    xy: Option<Quantity>,
    xz: Option<Quantity>,
    yz: Option<Quantity>,
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum About {
    Origin,
    CentreOfGravity,
}

/// A matrix: its diagonal, or all of it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Square {
    Diagonal([f64; 6]),
    Full(Box<Matrix6>),
}

impl Square {
    fn matrix(self, entry: &str) -> Result<Matrix6, Unphysical> {
        let matrix = match self {
            Self::Full(matrix) => *matrix,
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CrossFlowSection {
    density: Quantity,
    drag: f64,
    width: Quantity,
    ends: [Quantity; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CoefficientsSection {
    /// The table prints the products of added mass too, as `X_wq` and `M_uw`; else they are computed beside it.
    includes_added_mass: bool,
    values: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FinSection {
    input: String,
    position: [Quantity; 3],
    chord: Three<f64>,
    normal: Three<f64>,
    area: Quantity,
    density: Quantity,
    slope: f64,
    drag: f64,
    oswald: f64,
    aspect: f64,
    stall: Quantity,
    sharpness: f64,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum PropulsionSection {
    Constant {
        force: Quantity,
        moment: Quantity,
    },
    Force {
        input: String,
        limits: [Quantity; 2],
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

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Hand {
    Right,
    Left,
}

fn si(entry: &str, q: &Quantity, dimension: Dimension) -> Result<f64, Unphysical> {
    q.si(dimension)
        .map_err(|rule| Unphysical::new(entry, format!("{q} refused: {rule}")))
}

/// The largest magnitude of a coefficient or an entry of a matrix, SI: those of a ship are below.
const MOST_COEFFICIENT: f64 = 1e15;

/// A number without a unit, within its range.
fn number(entry: &str, value: f64, range: [f64; 2]) -> Result<f64, Unphysical> {
    within(value, range, "")
        .map_err(|rule| Unphysical::new(entry, format!("{value} refused: {rule}")))
}

fn above_zero(entry: &str, q: &Quantity, dimension: Dimension) -> Result<f64, Unphysical> {
    match si(entry, q, dimension)? {
        value if value > 0.0 => Ok(value),
        _ => Err(Unphysical::new(
            entry,
            format!("{q} refused: it must be above zero"),
        )),
    }
}

fn place(entry: &str, [x, y, z]: &[Quantity; 3]) -> Result<Three<f64>, Unphysical> {
    let metres = |q| si(entry, q, Dimension::Length);
    Ok([metres(x)?, metres(y)?, metres(z)?])
}

/// A direction of length 1.
fn direction(entry: &str, [x, y, z]: Three<f64>) -> Result<Three<f64>, Unphysical> {
    let length = (x * x + y * y + z * z).sqrt();
    match length > 0.0 && length.is_finite() {
        true => Ok([x / length, y / length, z / length]),
        false => Err(Unphysical::new(
            entry,
            format!("{:?} is no direction", [x, y, z]),
        )),
    }
}

impl Written {
    fn vehicle(self) -> Result<Vehicle, Unphysical> {
        let input = |entry: &str, name: &str| {
            let place = self.inputs.iter().position(|input| input.name == name);
            place.ok_or_else(|| Unphysical::new(entry, format!("'{name}' is none of the inputs")))
        };
        let mass = above_zero("mass", &self.mass, Dimension::Mass)?;
        let centre_of_gravity = place("centre_of_gravity", &self.centre_of_gravity)?;
        let inertia = self.inertia.matrix()?;
        let body = RigidBody {
            mass,
            centre_of_gravity,
            inertia: match self.inertia.about {
                About::Origin => inertia,
                About::CentreOfGravity => inertia::about_origin(inertia, mass, centre_of_gravity),
            },
        };
        let letters: Vec<&str> = self
            .inputs
            .iter()
            .map(|input| input.letters.as_str())
            .collect();
        let mut terms = Vec::new();
        let mut includes_added_mass = false;
        if let Some(section) = &self.coefficients {
            includes_added_mass = section.includes_added_mass;
            for (name, value) in &section.values {
                let entry = format!("coefficients.{name}");
                number(&entry, *value, [-MOST_COEFFICIENT, MOST_COEFFICIENT])?;
                let mut term = coefficients::term(name, *value, &letters)
                    .map_err(|e| Unphysical::new(entry, e.to_string()))?;
                if let Factor::Input(k) = term.of {
                    term.value *= if self.inputs[k].reversed { -1.0 } else { 1.0 };
                }
                terms.push(term);
            }
        }
        let added_mass = match self.added_mass {
            Some(matrix) => matrix.matrix("added_mass")?,
            None => coefficients::added_mass(&terms),
        };
        let terms = match includes_added_mass {
            true => coefficients::beyond_added_mass(&terms, &added_mass),
            false => terms
                .into_iter()
                .filter(|term| !matches!(term.of, Factor::Acceleration(_)))
                .collect(),
        };
        let matrix = |square: Option<Square>, entry| {
            square.map_or(Ok(Matrix6::default()), |square| square.matrix(entry))
        };
        let fins = self
            .fins
            .iter()
            .enumerate()
            .map(|(k, fin)| fin.fin(&format!("fins[{k}]"), &input))
            .collect::<Result<_, _>>()?;
        let propulsors = self
            .propulsion
            .iter()
            .enumerate()
            .map(|(k, propulsor)| propulsor.propulsor(&format!("propulsion[{k}]"), &input))
            .collect::<Result<_, _>>()?;
        let buoyancy = above_zero("buoyancy", &self.buoyancy, Dimension::Force)?;
        let hull = match &self.hull {
            None => Hull::of_buoyancy(buoyancy),
            Some(hull) => Hull {
                length: above_zero("hull.length", &hull.length, Dimension::Length)?,
                width: above_zero("hull.width", &hull.width, Dimension::Length)?,
                height: above_zero("hull.height", &hull.height, Dimension::Length)?,
            },
        };
        Vehicle::new(Parts {
            body,
            weight: above_zero("weight", &self.weight, Dimension::Force)?,
            buoyancy,
            hull,
            centre_of_buoyancy: place("centre_of_buoyancy", &self.centre_of_buoyancy)?,
            added_mass,
            damping: Damping {
                linear: matrix(self.linear_damping, "linear_damping")?,
                quadratic: matrix(self.quadratic_damping, "quadratic_damping")?,
            },
            cross_flow: self
                .cross_flow
                .map(|section| section.checked())
                .transpose()?
                .into_iter()
                .collect(),
            terms,
            fins,
            propulsors,
            inputs: self.inputs.iter().map(|input| input.name.clone()).collect(),
            name: self.name,
        })
    }
}

impl Inertia {
    fn matrix(&self) -> Result<[Three<f64>; 3], Unphysical> {
        let own = |entry, q| above_zero(entry, q, Dimension::Inertia);
        let cross = |entry, q: &Option<Quantity>| match q {
            Some(q) => si(entry, q, Dimension::Inertia),
            None => Ok(0.0),
        };
        let (x, y, z) = (
            own("inertia.xx", &self.xx)?,
            own("inertia.yy", &self.yy)?,
            own("inertia.zz", &self.zz)?,
        );
        let (xy, xz, yz) = (
            cross("inertia.xy", &self.xy)?,
            cross("inertia.xz", &self.xz)?,
            cross("inertia.yz", &self.yz)?,
        );
        Ok([[x, -xy, -xz], [-xy, y, -yz], [-xz, -yz, z]])
    }
}

impl CrossFlowSection {
    fn checked(&self) -> Result<CrossFlow, Unphysical> {
        let [aft, fore] = &self.ends;
        let ends = [
            si("cross_flow.ends", aft, Dimension::Length)?,
            si("cross_flow.ends", fore, Dimension::Length)?,
        ];
        if ends[0] >= ends[1] {
            let reason = "its ends must be aft and fore";
            return Err(Unphysical::new("cross_flow", reason));
        }
        Ok(CrossFlow {
            density: above_zero("cross_flow.density", &self.density, Dimension::Density)?,
            drag: number("cross_flow.drag", self.drag, [0.0, 1e3])?,
            width: above_zero("cross_flow.width", &self.width, Dimension::Length)?,
            ends,
        })
    }
}

impl FinSection {
    fn fin(
        &self,
        entry: &str,
        input: &impl Fn(&str, &str) -> Result<usize, Unphysical>,
    ) -> Result<Fin, Unphysical> {
        let at = |field: &str| format!("{entry}.{field}");
        let positive = |field: &str, value: f64| number(&at(field), value, [1e-3, 1e4]);
        let (chord, normal) = (
            direction(&at("chord"), self.chord)?,
            direction(&at("normal"), self.normal)?,
        );
        if super::lanes::dot(chord, normal).abs() > 1e-9 {
            return Err(Unphysical::new(at("normal"), "not across the chord"));
        }
        Ok(Fin {
            input: input(&at("input"), &self.input)?,
            position: place(&at("position"), &self.position)?,
            chord,
            normal,
            area: above_zero(&at("area"), &self.area, Dimension::Area)?,
            density: above_zero(&at("density"), &self.density, Dimension::Density)?,
            section: Section {
                slope: positive("slope", self.slope)?,
                drag: number(&at("drag"), self.drag, [0.0, 1e3])?,
                oswald: positive("oswald", self.oswald)?,
                aspect: positive("aspect", self.aspect)?,
                stall: above_zero(&at("stall"), &self.stall, Dimension::Angle)?,
                sharpness: positive("sharpness", self.sharpness)?,
            },
        })
    }
}

impl PropulsionSection {
    fn propulsor(
        &self,
        entry: &str,
        find: &impl Fn(&str, &str) -> Result<usize, Unphysical>,
    ) -> Result<Propulsor, Unphysical> {
        Ok(match self {
            Self::Constant { force, moment } => Propulsor::Constant {
                force: si(&format!("{entry}.force"), force, Dimension::Force)?,
                moment: si(&format!("{entry}.moment"), moment, Dimension::Moment)?,
            },
            Self::Force { input, limits } => {
                let limit = |q| si(&format!("{entry}.limits"), q, Dimension::Force);
                let limits = [limit(&limits[0])?, limit(&limits[1])?];
                if limits[0] >= limits[1] {
                    let reason = format!("{limits:?}: the first must be below the second");
                    return Err(Unphysical::new(format!("{entry}.limits"), reason));
                }
                Propulsor::Force {
                    input: find(&format!("{entry}.input"), input)?,
                    limits,
                }
            }
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
                let at = |field: &str| format!("{entry}.{field}");
                let pair = |field: &str, [k0, k1]: [f64; 2]| -> Result<_, Unphysical> {
                    let one = |k| number(&at(field), k, [-1e3, 1e3]);
                    Ok([one(k0)?, one(k1)?])
                };
                Propulsor::Propeller {
                    input: find(&format!("{entry}.input"), input)?,
                    propeller: Propeller {
                        density: above_zero(
                            &format!("{entry}.density"),
                            density,
                            Dimension::Density,
                        )?,
                        diameter: above_zero(
                            &format!("{entry}.diameter"),
                            diameter,
                            Dimension::Length,
                        )?,
                        thrust: pair("thrust", *thrust)?,
                        torque: pair("torque", *torque)?,
                        wake: number(&at("wake"), *wake, [-1.0, 1.0])?,
                        deduction: number(&at("deduction"), *deduction, [-1.0, 1.0])?,
                        hand: match hand {
                            Hand::Right => 1.0,
                            Hand::Left => -1.0,
                        },
                        full_rotation: full_rotation
                            .as_ref()
                            .map(|q| {
                                above_zero(&format!("{entry}.full_rotation"), q, Dimension::Rate)
                            })
                            .transpose()?,
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
            } => Propulsor::Thruster {
                input: find(&format!("{entry}.input"), input)?,
                thruster: Thruster {
                    position: place(&format!("{entry}.position"), position)?,
                    direction: direction(&format!("{entry}.direction"), *push)?,
                    curve: (curve.iter())
                        .map(|k| number(&format!("{entry}.curve"), *k, [-1e9, 1e9]))
                        .collect::<Result<_, _>>()?,
                    dead_zone: number(&format!("{entry}.dead_zone"), *dead_zone, [0.0, 1.0])?,
                    lag: match lag {
                        None => 0.0,
                        Some(lag) => above_zero(&format!("{entry}.lag"), lag, Dimension::Time)?,
                    },
                },
            },
        })
    }
}
