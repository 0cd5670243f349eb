//! Vehicle files in YAML: every dimensional value has its unit (`28 in`) and is checked and converted to SI once.
//!
//! `vehicles/brunner.yaml` and `vehicles/remus_100.yaml` are templates, built in under the names `brunner` and `remus_100`. Also built in
//! is `brunner_as_printed`, the vehicle of the thesis' programs with their errors. Optional entries may be omitted. Without `buoyancy` it
//! equals the weight; `gravity_below_origin` and the coefficients from `z_q_dot` on default to 0. Without `planes`, bow and stern planes
//! only move together; without `roll`, `yaw` or `propulsion` the vehicle does not roll, turn or change its speed by thrust.

use std::path::Path;

use planesman_model_file::ModelFile;
use serde::Deserialize;

use crate::{
    Vehicle,
    axis::Axis,
    coefficients::Geometry,
    identified, positive,
    propulsion::Propulsion,
    six_dof,
    vehicle::{Coefficients, PlaneArms, Port},
};
use planesman_text::yaml::{self, Refusal};
use planesman_units::{Quantity, Rule, readers};

/// Built-in vehicle: the NPS model of Brunner 1988.
pub const BRUNNER: &str = "brunner";

/// Built-in vehicle of programs T2 to T5 of Brunner 1988, with their errors.
pub const BRUNNER_AS_PRINTED: &str = "brunner_as_printed";

/// Built-in vehicle: the REMUS 100 of Prestero 2001.
pub const REMUS_100: &str = "remus_100";

const BRUNNER_FILE: &str = include_str!("../vehicles/brunner.yaml");

/// Built-in vehicles, each with its text.
const BUILT_IN: &[(&str, &str)] = &[
    (BRUNNER, BRUNNER_FILE),
    (
        BRUNNER_AS_PRINTED,
        include_str!("../vehicles/brunner_as_printed.yaml"),
    ),
    (REMUS_100, include_str!("../vehicles/remus_100.yaml")),
];

/// Reason why a vehicle is refused.
#[derive(Debug, thiserror::Error)]
pub enum VehicleError {
    /// The file cannot be read.
    #[error(
        "vehicle file '{file}': {reason}; built in are {}{}",
        names(),
        similar_vehicle(file)
    )]
    Unreadable {
        /// Its path.
        file: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The vehicle has six degrees of freedom.
    #[error(
        "vehicle '{0}' has six degrees of freedom, which only plant_sim (dive, sim, sweep) and six-dof support; this command needs a vehicle of the vertical plane: {names}",
        names = plane_names()
    )]
    OfSixDegrees(String),
    /// The text is not YAML of the expected form.
    #[error("vehicle file '{file}': {reason}")]
    Malformed {
        /// Its path.
        file: String,
        /// Field and line.
        reason: String,
    },
    /// A value violates a rule.
    #[error("vehicle file '{file}': {refusal}")]
    Refused {
        /// Its path.
        file: String,
        /// Field, value and rule.
        refusal: Refusal,
    },
    /// The file of an identified model is not valid.
    #[error(transparent)]
    Model(#[from] planesman_model_file::Error),
    /// No vehicle can be made from the identified model.
    #[error("model file '{file}': {reason}")]
    Identified {
        /// Its path.
        file: String,
        /// The reason.
        reason: identified::Error,
    },
}

/// Loads a built-in vehicle by name, or else the file at that path; the base vehicle of [`load_on`] is [`BRUNNER`].
///
/// # Errors
/// [`VehicleError`], with file, field, value and rule.
pub fn load(name_or_path: &str) -> Result<Vehicle, VehicleError> {
    load_on(name_or_path, BRUNNER)
}

/// Loads a vehicle; the file may also be that of an identified model. The vehicle `base` then gives the missing data ([`identified`]).
///
/// # Errors
/// Same as [`load`].
pub fn load_on(name_or_path: &str, base: &str) -> Result<Vehicle, VehicleError> {
    let text = text_of(name_or_path)?;
    let path = Path::new(name_or_path);
    if !ModelFile::recognises(path, &text) {
        return parse(name_or_path, &text);
    }
    let model = ModelFile::parse(path, &text)?;
    let base = parse(base, &text_of(base)?)?;
    identified::vehicle(&base, &model).map_err(|reason| VehicleError::Identified {
        file: name_or_path.to_owned(),
        reason,
    })
}

/// Geometry of the vehicle that [`load_on`] loads; `None` if its file has no geometry. For an identified model it is the geometry of `base`.
///
/// # Errors
/// Same as [`load`].
pub fn geometry_on(name_or_path: &str, base: &str) -> Result<Option<Geometry>, VehicleError> {
    let text = text_of(name_or_path)?;
    if ModelFile::recognises(Path::new(name_or_path), &text) {
        return geometry(base);
    }
    written(name_or_path, &text).map(|file| file.geometry)
}

/// Geometry of a vehicle; `None` if its file has no geometry.
///
/// # Errors
/// Same as [`load`].
pub fn geometry(name_or_path: &str) -> Result<Option<Geometry>, VehicleError> {
    written(name_or_path, &text_of(name_or_path)?).map(|file| file.geometry)
}

/// A suggestion of the built-in vehicle, as a question.
fn similar_vehicle(name: &str) -> String {
    let plane = BUILT_IN.iter().map(|(name, _)| *name);
    planesman_text::did_you_mean(name, plane.chain(six_dof::built_in()))
}

/// Names of the built-in vehicles of the vertical plane.
fn plane_names() -> String {
    let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

/// The names of built-in vehicles of the vertical plane, and of [`crate::six_dof`].
fn names() -> String {
    let six: Vec<&str> = six_dof::built_in().collect();
    format!(
        "{}; with six degrees of freedom {}",
        plane_names(),
        six.join(", ")
    )
}

/// Text of a built-in vehicle of either kind, or of the file at that path.
///
/// # Errors
/// [`VehicleError::Unreadable`].
pub fn text(name_or_path: &str) -> Result<String, VehicleError> {
    match six_dof::built_in_text(name_or_path) {
        Some(text) => Ok(text.to_owned()),
        None => text_of(name_or_path),
    }
}

/// Text of a built-in vehicle of the vertical plane, or of the file at that path.
fn text_of(name_or_path: &str) -> Result<String, VehicleError> {
    if let Some((_, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_path) {
        return Ok((*text).to_owned());
    }
    let unreadable = |reason| VehicleError::Unreadable {
        file: name_or_path.to_owned(),
        reason,
    };
    if six_dof::built_in().any(|name| name == name_or_path) {
        return Err(VehicleError::OfSixDegrees(name_or_path.to_owned()));
    }
    planesman_text::read(Path::new(name_or_path)).map_err(unreadable)
}

/// Parses the vehicle in `text`; errors name `file`.
///
/// # Errors
/// [`VehicleError::Malformed`], [`VehicleError::OfSixDegrees`] or [`VehicleError::Refused`].
pub fn parse(file: &str, text: &str) -> Result<Vehicle, VehicleError> {
    let written = written(file, text)?;
    match written.check() {
        Ok(()) => Ok(written.vehicle()),
        Err((field, rule)) => Err(VehicleError::Refused {
            file: file.to_owned(),
            refusal: Refusal::at::<Quantity>(text, field, rule),
        }),
    }
}

fn written(file: &str, text: &str) -> Result<VehicleFile, VehicleError> {
    let file = || file.to_owned();
    yaml::from_str(text).map_err(|error| match error {
        _ if six_dof::is_of_six_degrees(text) => VehicleError::OfSixDegrees(file()),
        other => VehicleError::Malformed {
            file: file(),
            reason: other.to_string(),
        },
    })
}

/// The NPS model vehicle of Brunner 1988.
///
/// # Panics
/// Never: a test reads the built-in file.
#[must_use]
pub fn brunner() -> Vehicle {
    parse(BRUNNER, BRUNNER_FILE).expect("the built-in vehicle file is valid")
}

/// The REMUS 100 of Prestero 2001.
///
/// # Panics
/// Never, as [`brunner`].
#[must_use]
pub fn remus_100() -> Vehicle {
    load(REMUS_100).expect("the built-in vehicle file is valid")
}

readers! {
    restoring_arm: Length, Rule::Any;
    gravity_below_origin: Length, Rule::Any, or 0.0;
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleFile {
    name: String,
    reference: Reference,
    particulars: Particulars,
    coefficients: Coefficients,
    planes: Option<PlaneArms>,
    depth_port: Port,
    roll: Option<Axis>,
    yaw: Option<Axis>,
    propulsion: Option<Propulsion>,
    /// Used by the computation of coefficients only.
    #[serde(default)]
    geometry: Option<Geometry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Reference {
    #[serde(with = "positive::length")]
    length: f64,
    #[serde(with = "positive::mass")]
    mass: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Particulars {
    #[serde(with = "positive::mass")]
    mass: f64,
    #[serde(with = "positive::force")]
    weight: f64,
    #[serde(default, with = "positive::optional_force")]
    buoyancy: Option<f64>,
    #[serde(with = "restoring_arm")]
    restoring_arm: f64,
    #[serde(default, with = "gravity_below_origin")]
    gravity_below_origin: f64,
}

impl VehicleFile {
    /// Checks the rules of a vehicle; an error names the field and the allowed values.
    fn check(&self) -> Result<(), (&'static str, &'static str)> {
        let (length, reference_mass) = (self.reference.length, self.reference.mass);
        let (p, c) = (&self.particulars, &self.coefficients);
        let on_hull = |value: f64| value.abs() <= length;
        let planes = |holds: &dyn Fn(&PlaneArms) -> bool| self.planes.as_ref().is_none_or(holds);
        let heave_inertia = p.mass - c.z_w_dot * reference_mass;
        let pitch_inertia = c.i_y_minus_m_q_dot * reference_mass * length * length;
        let coupling = c.z_q_dot * c.m_w_dot * (reference_mass * length).powi(2);
        let passive = "it must not be above zero, because it would add energy to the motion";
        let far = "the distance from the body's origin must not exceed the reference length";
        let rules = [
            (
                p.restoring_arm >= 0.0,
                "particulars.restoring_arm",
                "it must not be below zero, because the vehicle would turn over",
            ),
            (c.z_w_dot <= 0.0, "coefficients.z_w_dot", passive),
            (c.z_w <= 0.0, "coefficients.z_w", passive),
            (c.m_q <= 0.0, "coefficients.m_q", passive),
            (c.z_ww <= 0.0, "coefficients.z_ww", passive),
            (c.m_qq <= 0.0, "coefficients.m_qq", passive),
            (
                c.i_y_minus_m_q_dot > 0.0,
                "coefficients.i_y_minus_m_q_dot",
                "it must be above zero",
            ),
            (
                coupling.abs() < heave_inertia * pitch_inertia,
                "coefficients.z_q_dot",
                "the inertia must be positive: z_q_dot times m_w_dot is at least the inertia of heave times that of pitch",
            ),
            (
                on_hull(p.gravity_below_origin),
                "particulars.gravity_below_origin",
                far,
            ),
            (planes(&|it| on_hull(it.bow)), "planes.bow", far),
            (planes(&|it| on_hull(it.stern)), "planes.stern", far),
            (
                planes(&|it| it.bow > it.stern),
                "planes.bow",
                "it must be ahead of the stern planes",
            ),
            (on_hull(self.depth_port.forward), "depth_port.forward", far),
            (on_hull(self.depth_port.below), "depth_port.below", far),
        ];
        let broken = rules.into_iter().find(|rule| !rule.0);
        broken.map_or(Ok(()), |(_, field, rule)| Err((field, rule)))
    }

    fn vehicle(self) -> Vehicle {
        let p = self.particulars;
        let restoring = p.weight * p.restoring_arm;
        Vehicle {
            name: self.name,
            reference_length: self.reference.length,
            reference_mass: self.reference.mass,
            mass: p.mass,
            weight: p.weight,
            buoyancy: p.buoyancy.unwrap_or(p.weight),
            restoring_arm: p.restoring_arm,
            gravity_below_origin: p.gravity_below_origin,
            coefficients: self.coefficients,
            planes: self.planes,
            roll: self.roll.map(|axis| Axis { restoring, ..axis }),
            yaw: self.yaw,
            propulsion: self.propulsion,
            depth_port: self.depth_port,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(from: &str, to: &str) -> String {
        assert!(BRUNNER_FILE.contains(from), "{from} is not in the file");
        // The first only: the geometry has some of the same numbers.
        let text = BRUNNER_FILE.replacen(from, to, 1);
        parse("mine.yaml", &text).expect_err("refused").to_string()
    }

    #[test]
    fn the_built_in_vehicle_is_the_report_s() {
        let vehicle = brunner();
        assert_eq!(vehicle.name, "brunner");
        assert!((vehicle.weight - 87.19).abs() < 0.01);
        assert!((vehicle.mass - 8.894).abs() < 0.001);
        assert_eq!(load(BRUNNER).expect("built in"), vehicle);
    }

    #[test]
    fn the_older_form_of_a_quantity_is_the_same_vehicle() {
        let older = BRUNNER_FILE
            .replace("0.04 ft lbf s^2", "{value: 0.04, unit: ft lbf s^2}")
            .replace("28.0 in", "{value: 28.0, unit: in}");
        assert_ne!(older, BRUNNER_FILE);
        assert_eq!(parse("mine.yaml", &older).expect("taken"), brunner());
    }

    #[test]
    fn each_built_in_vehicle_is_called_as_its_file_says() {
        for (name, _) in BUILT_IN {
            assert_eq!(load(name).expect("built in").name, *name);
        }
    }

    #[test]
    fn a_value_against_its_rule_is_refused_by_file_field_value_and_rule() {
        assert_eq!(
            refusal("0.609444 slug", "-2 kg"),
            "vehicle file 'mine.yaml': particulars.mass: -2 kg refused: it must be above zero at line 20 column 9"
        );
        for (from, to, parts) in [
            ("0.1 in", "-0.1 in", ["restoring_arm", "turn over"]),
            ("z_w: -1.295", "z_w: 1.295", ["coefficients.z_w:", "1.295"]),
            (
                "m_w: 0.088",
                "m_w: .nan",
                ["coefficients.m_w:", "must be from"],
            ),
            (
                "28.0 in",
                "28.0 kg",
                ["reference.length", "m, cm, mm, in, ft"],
            ),
            ("19.6 lbf", "inf lbf", ["particulars.weight", "must be"]),
            (
                "forward: 0.5 in",
                "forward: 40 in",
                ["depth_port.forward", "reference length"],
            ),
            ("bow: 7.6", "bow: -20", ["planes.bow", "ahead of the stern"]),
            (
                "moment_arm: 0.5",
                "moment_arm: 0",
                ["planes.moment_arm", "above zero"],
            ),
            (
                "q_dot: 0.072",
                "q_dot: 0",
                ["i_y_minus_m_q_dot", "above zero"],
            ),
        ] {
            let refusal = refusal(from, to);
            assert!(parts.iter().all(|p| refusal.contains(p)), "{refusal}");
        }
    }

    #[test]
    fn a_misspelt_or_missing_field_is_refused_by_name() {
        assert!(refusal("restoring_arm", "restoring_harm").contains("restoring_harm"));
        assert!(refusal("name: brunner", "").contains("name"));
        assert!(refusal("0.1 in", "0.1").contains("unit"));
    }

    #[test]
    fn what_is_no_vehicle_file_is_refused() {
        for text in ["", "3", "[1, 2]", "\u{0}", "a: &a [*a, *a]", "{"] {
            assert!(parse("mine.yaml", text).is_err(), "{text}");
        }
        assert!(load("no/such/file.yaml").is_err());
        assert!(load("/").is_err());
        assert!(load("/dev/zero").is_err());
    }
}
