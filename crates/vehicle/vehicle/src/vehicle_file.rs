//! Vehicle files: YAML, every dimensional value with its unit (`28 in`), checked and converted to SI once.
//!
//! `vehicles/brunner.yaml` and `vehicles/remus_100.yaml` are the patterns, and are built in under the
//! names `brunner` and `remus_100`; so is `brunner_as_printed`, the vehicle that the thesis' programs
//! describe with their errors. What a vehicle does not have is left out: `buoyancy` is then the
//! weight, `gravity_below_origin` and the coefficients from `z_q_dot` on are 0, and without `planes`,
//! `roll`, `yaw` or `propulsion` its bow and stern planes move together alone, and it does not heel,
//! turn or go by thrust.

use std::path::Path;

use planesman_model_file::ModelFile;
use serde::Deserialize;

use crate::{
    Vehicle,
    axis::Axis,
    coefficients::Geometry,
    identified,
    propulsion::Propulsion,
    six_dof,
    vehicle::{Coefficients, PlaneArms, Port},
};
use planesman_units::{Dimension, Quantity, within};

/// The vehicle that needs no file: the NPS model of Brunner 1988.
pub const BRUNNER: &str = "brunner";

/// The vehicle of programs T2 to T5 with their errors left in, of Brunner 1988 too.
pub const BRUNNER_AS_PRINTED: &str = "brunner_as_printed";

/// The REMUS 100 of Prestero 2001.
pub const REMUS_100: &str = "remus_100";

const BRUNNER_FILE: &str = include_str!("../vehicles/brunner.yaml");

/// The vehicles that need no file, each with its text.
const BUILT_IN: &[(&str, &str)] = &[
    (BRUNNER, BRUNNER_FILE),
    (
        BRUNNER_AS_PRINTED,
        include_str!("../vehicles/brunner_as_printed.yaml"),
    ),
    (REMUS_100, include_str!("../vehicles/remus_100.yaml")),
];

/// Why a vehicle was not taken.
#[derive(Debug, thiserror::Error)]
pub enum VehicleError {
    /// The file could not be read.
    #[error(
        "vehicle file '{file}': {reason} (built in are {}){}",
        names(),
        meant(file)
    )]
    Unreadable {
        /// Its path.
        file: String,
        /// The system's error.
        reason: std::io::Error,
    },
    /// It has six degrees of freedom.
    #[error(
        "vehicle '{0}' has six degrees of freedom, which plant_sim (dive, sim, sweep) and six-dof take; here one of the vertical plane is asked for: {names}",
        names = plane_names()
    )]
    OfSixDegrees(String),
    /// The text is not YAML of the right form.
    #[error("vehicle file '{file}': {reason}")]
    Malformed {
        /// Its path.
        file: String,
        /// The field and the line.
        reason: String,
    },
    /// A value breaks a rule.
    #[error("vehicle file '{file}': {field}: {reason}")]
    Refused {
        /// Its path.
        file: String,
        /// The field, dots between levels.
        field: &'static str,
        /// The value and the rule.
        reason: String,
    },
    /// An identified model's file is not well formed.
    #[error(transparent)]
    Model(#[from] planesman_model_file::Error),
    /// No vehicle follows the identified model.
    #[error("model file '{file}': {reason}")]
    Identified {
        /// Its path.
        file: String,
        /// Why not.
        reason: identified::Error,
    },
}

/// A built-in vehicle by its name, or else the one in the file at that path; as [`load_on`] the
/// vehicle [`BRUNNER`].
///
/// # Errors
/// [`VehicleError`], which names the file, the field, the value and the rule.
pub fn load(name_or_path: &str) -> Result<Vehicle, VehicleError> {
    load_on(name_or_path, BRUNNER)
}

/// The same, where the file may be an identified model's; it takes what it does not say from the vehicle
/// `base` ([`identified`]).
///
/// # Errors
/// As [`load`].
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

/// The geometry of the vehicle that [`load_on`] takes, `None` when its file has none; of an identified model
/// it is the base's.
///
/// # Errors
/// As [`load`].
pub fn geometry_on(name_or_path: &str, base: &str) -> Result<Option<Geometry>, VehicleError> {
    let text = text_of(name_or_path)?;
    if ModelFile::recognises(Path::new(name_or_path), &text) {
        return geometry(base);
    }
    written(name_or_path, &text).map(|file| file.geometry)
}

/// The geometry of a vehicle, `None` when its file has none.
///
/// # Errors
/// As [`load`].
pub fn geometry(name_or_path: &str) -> Result<Option<Geometry>, VehicleError> {
    written(name_or_path, &text_of(name_or_path)?).map(|file| file.geometry)
}

/// The built-in vehicle that was probably meant, as a question.
fn meant(name: &str) -> String {
    let plane = BUILT_IN.iter().map(|(name, _)| *name);
    planesman_text::did_you_mean(name, plane.chain(six_dof::built_in()))
}

/// The names of the built-in vehicles of the vertical plane.
fn plane_names() -> String {
    let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

/// Those too that [`crate::six_dof`] has.
fn names() -> String {
    let six: Vec<&str> = six_dof::built_in().collect();
    format!(
        "{}; with six degrees of freedom {}",
        plane_names(),
        six.join(", ")
    )
}

/// The text of a built-in vehicle, of the plane or of six degrees of freedom, or of the file at that path.
///
/// # Errors
/// [`VehicleError::Unreadable`].
pub fn text(name_or_path: &str) -> Result<String, VehicleError> {
    match six_dof::built_in_text(name_or_path) {
        Some(text) => Ok(text.to_owned()),
        None => text_of(name_or_path),
    }
}

/// The text of a built-in vehicle of the plane, or of the file at that path.
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

/// The vehicle in `text`; `file` is named in errors.
///
/// # Errors
/// [`VehicleError::Malformed`], [`VehicleError::OfSixDegrees`] or [`VehicleError::Refused`].
pub fn parse(file: &str, text: &str) -> Result<Vehicle, VehicleError> {
    written(file, text)?
        .vehicle()
        .map_err(|(field, reason)| VehicleError::Refused {
            file: file.to_owned(),
            field,
            reason,
        })
}

fn written(file: &str, text: &str) -> Result<VehicleFile, VehicleError> {
    planesman_text::yaml::from_str(text).map_err(|e| match six_dof::is_of_six_degrees(text) {
        true => VehicleError::OfSixDegrees(file.to_owned()),
        false => VehicleError::Malformed {
            file: file.to_owned(),
            reason: e.to_string(),
        },
    })
}

/// The NPS model vehicle of Brunner 1988.
///
/// # Panics
/// Never: a test reads the file that is compiled in.
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

/// The largest magnitude of a coefficient, which has no dimension: those of vehicles are below 10.
const MOST_COEFFICIENT: f64 = 1e4;

/// A field and what is wrong with it.
type Refusal = (&'static str, String);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleFile {
    name: String,
    reference: ReferenceSection,
    particulars: ParticularsSection,
    coefficients: CoefficientsSection,
    planes: Option<PlanesSection>,
    depth_port: PortSection,
    roll: Option<AxisSection>,
    yaw: Option<AxisSection>,
    propulsion: Option<PropulsionSection>,
    /// Read by the coefficient workbench alone.
    #[serde(default)]
    geometry: Option<Geometry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ReferenceSection {
    length: Quantity,
    mass: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParticularsSection {
    mass: Quantity,
    weight: Quantity,
    buoyancy: Option<Quantity>,
    restoring_arm: Quantity,
    gravity_below_origin: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CoefficientsSection {
    z_w_dot: f64,
    z_w: f64,
    z_q: f64,
    z_delta: f64,
    m_w: f64,
    m_q: f64,
    i_y_minus_m_q_dot: f64,
    m_delta: f64,
    #[serde(default)]
    z_q_dot: f64,
    #[serde(default)]
    m_w_dot: f64,
    #[serde(default)]
    z_ww: f64,
    #[serde(default)]
    z_qq: f64,
    #[serde(default)]
    m_ww: f64,
    #[serde(default)]
    m_qq: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanesSection {
    bow: Quantity,
    stern: Quantity,
    moment_arm: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PortSection {
    forward: Quantity,
    below: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisSection {
    gain: Quantity,
    reference_speed: Quantity,
    inertia: Quantity,
    damping: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PropulsionSection {
    frontal_area: Quantity,
    wetted_area: Quantity,
    plate_length: Quantity,
    added_mass: Quantity,
    design_speed: Quantity,
}

impl VehicleFile {
    fn vehicle(self) -> Result<Vehicle, Refusal> {
        let VehicleFile {
            name,
            reference,
            particulars,
            coefficients: c,
            planes,
            depth_port,
            roll,
            yaw,
            propulsion,
            geometry: _,
        } = self;
        let length = above_zero("reference.length", &reference.length, Dimension::Length)?;
        let restoring_arm = si(
            "particulars.restoring_arm",
            &particulars.restoring_arm,
            Dimension::Length,
        )?;
        require(
            restoring_arm >= 0.0,
            "particulars.restoring_arm",
            &particulars.restoring_arm,
            "must not be below zero: the vehicle would turn over",
        )?;
        let reference_mass = above_zero("reference.mass", &reference.mass, Dimension::Mass)?;
        let mass = above_zero("particulars.mass", &particulars.mass, Dimension::Mass)?;
        let weight = above_zero("particulars.weight", &particulars.weight, Dimension::Force)?;
        let coefficients = c.checked()?;
        let heave_inertia = mass - coefficients.z_w_dot * reference_mass;
        let pitch_inertia = coefficients.i_y_minus_m_q_dot * reference_mass * length * length;
        let coupling =
            coefficients.z_q_dot * coefficients.m_w_dot * (reference_mass * length).powi(2);
        require(
            coupling.abs() < heave_inertia * pitch_inertia,
            "coefficients.z_q_dot",
            coefficients.z_q_dot,
            "must leave the inertia positive: z_q_dot m_w_dot is at least that of heave times pitch",
        )?;
        Ok(Vehicle {
            name,
            reference_length: length,
            reference_mass,
            mass,
            weight,
            buoyancy: match &particulars.buoyancy {
                Some(q) => above_zero("particulars.buoyancy", q, Dimension::Force)?,
                None => weight,
            },
            restoring_arm,
            gravity_below_origin: match &particulars.gravity_below_origin {
                Some(q) => on_the_hull("particulars.gravity_below_origin", q, length)?,
                None => 0.0,
            },
            coefficients,
            planes: planes.map(|p| p.arms(length)).transpose()?,
            roll: roll
                .map(|r| r.axis(ROLL_FIELDS, weight * restoring_arm))
                .transpose()?,
            yaw: yaw.map(|c| c.axis(YAW_FIELDS, 0.0)).transpose()?,
            propulsion: propulsion.map(PropulsionSection::checked).transpose()?,
            depth_port: Port {
                forward: on_the_hull("depth_port.forward", &depth_port.forward, length)?,
                below: on_the_hull("depth_port.below", &depth_port.below, length)?,
            },
        })
    }
}

/// The names of an axis' gain, reference speed, inertia and damping.
type AxisFields = [&'static str; 4];

const ROLL_FIELDS: AxisFields = [
    "roll.gain",
    "roll.reference_speed",
    "roll.inertia",
    "roll.damping",
];

const YAW_FIELDS: AxisFields = [
    "yaw.gain",
    "yaw.reference_speed",
    "yaw.inertia",
    "yaw.damping",
];

impl AxisSection {
    fn axis(&self, fields: AxisFields, restoring: f64) -> Result<Axis, Refusal> {
        let [gain, reference_speed, inertia, damping] = fields;
        Ok(Axis {
            gain: above_zero(gain, &self.gain, Dimension::Moment)?,
            reference_speed: above_zero(reference_speed, &self.reference_speed, Dimension::Speed)?,
            inertia: above_zero(inertia, &self.inertia, Dimension::Inertia)?,
            damping: above_zero(damping, &self.damping, Dimension::RotaryDamping)?,
            restoring,
        })
    }
}

impl PlanesSection {
    fn arms(&self, length: f64) -> Result<PlaneArms, Refusal> {
        let bow = on_the_hull("planes.bow", &self.bow, length)?;
        let stern = on_the_hull("planes.stern", &self.stern, length)?;
        let rule = "must be ahead of the stern planes";
        require(bow > stern, "planes.bow", &self.bow, rule)?;
        let arm = |arm| above_zero("planes.moment_arm", arm, Dimension::Length);
        let moment_arm = self.moment_arm.as_ref().map(arm).transpose()?;
        Ok(PlaneArms {
            bow,
            stern,
            moment_arm,
        })
    }
}

impl PropulsionSection {
    fn checked(self) -> Result<Propulsion, Refusal> {
        let Self {
            frontal_area,
            wetted_area,
            plate_length,
            added_mass,
            design_speed,
        } = self;
        Ok(Propulsion {
            frontal_area: above_zero("propulsion.frontal_area", &frontal_area, Dimension::Area)?,
            wetted_area: above_zero("propulsion.wetted_area", &wetted_area, Dimension::Area)?,
            plate_length: above_zero("propulsion.plate_length", &plate_length, Dimension::Length)?,
            added_mass: above_zero("propulsion.added_mass", &added_mass, Dimension::Mass)?,
            design_speed: above_zero("propulsion.design_speed", &design_speed, Dimension::Speed)?,
        })
    }
}

impl CoefficientsSection {
    fn checked(self) -> Result<Coefficients, Refusal> {
        for (field, value) in [
            ("coefficients.z_w_dot", self.z_w_dot),
            ("coefficients.z_w", self.z_w),
            ("coefficients.z_q", self.z_q),
            ("coefficients.z_delta", self.z_delta),
            ("coefficients.m_w", self.m_w),
            ("coefficients.m_q", self.m_q),
            ("coefficients.i_y_minus_m_q_dot", self.i_y_minus_m_q_dot),
            ("coefficients.m_delta", self.m_delta),
            ("coefficients.z_q_dot", self.z_q_dot),
            ("coefficients.m_w_dot", self.m_w_dot),
            ("coefficients.z_ww", self.z_ww),
            ("coefficients.z_qq", self.z_qq),
            ("coefficients.m_ww", self.m_ww),
            ("coefficients.m_qq", self.m_qq),
        ] {
            let range = [-MOST_COEFFICIENT, MOST_COEFFICIENT];
            within(value, range, "").map_err(|rule| (field, format!("{value} refused: {rule}")))?;
        }
        for (field, value) in [
            ("coefficients.z_w_dot", self.z_w_dot),
            ("coefficients.z_w", self.z_w),
            ("coefficients.m_q", self.m_q),
            ("coefficients.z_ww", self.z_ww),
            ("coefficients.m_qq", self.m_qq),
        ] {
            let rule = "must not be above zero: it would feed energy to the motion";
            require(value <= 0.0, field, value, rule)?;
        }
        require(
            self.i_y_minus_m_q_dot > 0.0,
            "coefficients.i_y_minus_m_q_dot",
            self.i_y_minus_m_q_dot,
            "must be above zero",
        )?;
        Ok(Coefficients {
            z_w_dot: self.z_w_dot,
            z_w: self.z_w,
            z_q: self.z_q,
            z_delta: self.z_delta,
            m_w: self.m_w,
            m_q: self.m_q,
            i_y_minus_m_q_dot: self.i_y_minus_m_q_dot,
            m_delta: self.m_delta,
            z_q_dot: self.z_q_dot,
            m_w_dot: self.m_w_dot,
            z_ww: self.z_ww,
            z_qq: self.z_qq,
            m_ww: self.m_ww,
            m_qq: self.m_qq,
        })
    }
}

fn above_zero(field: &'static str, q: &Quantity, dimension: Dimension) -> Result<f64, Refusal> {
    let si = si(field, q, dimension)?;
    require(si > 0.0, field, q, "must be above zero")?;
    Ok(si)
}

fn si(field: &'static str, q: &Quantity, dimension: Dimension) -> Result<f64, Refusal> {
    q.si(dimension)
        .map_err(|rule| (field, format!("{q} refused: {rule}")))
}

fn on_the_hull(field: &'static str, q: &Quantity, length: f64) -> Result<f64, Refusal> {
    let si = si(field, q, Dimension::Length)?;
    let rule = "must not be farther from the body's origin than the reference length";
    require(si.abs() <= length, field, q, rule)?;
    Ok(si)
}

fn require(
    holds: bool,
    field: &'static str,
    value: impl std::fmt::Display,
    rule: &str,
) -> Result<(), Refusal> {
    if holds {
        Ok(())
    } else {
        Err((field, format!("{value} refused: it {rule}")))
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
            "vehicle file 'mine.yaml': particulars.mass: -2 kg refused: it must be above zero"
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
