//! Actuator files: YAML, every quantity with its unit, converted to SI once, here.
//!
//! `actuators/table_4_1.yaml` is the example; the fields are Tables 3-1 and 4-1 of IBM
//! 66-L03-005. [`BUILT_IN`] has the files that are built in; `auv_two_speed` is the example of a `small_volume`.
//! A file with `edges` is a circuit of on/off valves ([`planesman_circuit::file`]).

use std::path::Path;
use std::sync::Arc;

use planesman_circuit::file as circuit_file;
use planesman_parameters::{Choice as _, file};
use planesman_text::did_you_mean;
use planesman_text::yaml::Refusal;
use planesman_units::{DEGREE, Dimension, Quantity, Unit, within};
use serde::Deserialize;

use crate::actuator_model::Model;
use crate::actuator_set::{
    ActuatorFile, ActuatorSet, LimitOption, MOST_CYCLES_IN_FLIGHT, SmallVolume,
};

/// The built-in actuators: name and file.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("auv", include_str!("../actuators/auv.yaml")),
    (
        "auv_two_speed",
        include_str!("../actuators/auv_two_speed.yaml"),
    ),
    ("table_3_1", include_str!("../actuators/table_3_1.yaml")),
    ("table_4_1", include_str!("../actuators/table_4_1.yaml")),
];

/// Electrical energy for one switching of a valve, J, where the file gives none: of a cartridge valve that switches in
/// milliseconds. 50 to 55 V for 6 to 8 ms, the current rising to 3 A: 52.5 V 3 A 7 ms/2 (voltages, times and
/// highest current by F. Breidi, T. Helmus, M. Holland and J. Lumkes, "The Impact of Peak-And-Hold and Reverse Current
/// Driving Strategies on the Dynamic Performance of Commercial Cartridge Valves", ASME/Bath FPMC 2014). A latching valve
/// takes nothing while it holds.
pub const SWITCHING_ENERGY: f64 = 0.55;

/// No solenoid takes more for a switching, J.
const MOST_SWITCHING_ENERGY: f64 = 1e3;

/// The ranges that several fields share: angles of the pulse logic, rad; volumes, m^3; travels of the ram, m; flow times, s.
const ANGLES: [f64; 2] = [1e-6, std::f64::consts::PI];
const VOLUMES: [f64; 2] = [1e-12, 1.0];
const TRAVELS: [f64; 2] = [1e-6, 100.0];
const FLOW_TIMES: [f64; 2] = [1e-5, 100.0];

/// The shortest time constant, s, and the most rad of a valve cycle, that are simulated.
const SHORTEST_TIME: f64 = 1e-6;
const MOST_RADIANS: f64 = 1e4;

/// Why an actuator was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum ActuatorFileError {
    /// The file cannot be read.
    #[error("actuator file '{file}': {reason}; built in are {}{meant}", names())]
    Unreadable {
        /// The path.
        file: String,
        /// The error of the operating system.
        reason: String,
        /// The built-in name that was probably meant, as a question; empty if none is similar.
        meant: String,
    },
    /// The file is not YAML, misses a field, or has one that is not known.
    #[error("actuator file '{file}': {reason}")]
    Malformed {
        /// The path or built-in name.
        file: String,
        /// The reason and the place.
        reason: String,
    },
    /// A circuit of on/off valves, where an actuator of metered volumes is meant.
    #[error(
        "actuator file '{0}' is a circuit of on/off valves, and only an actuator of metered volumes has these; `planesman dha design {0}` is for circuits"
    )]
    Circuit(String),
    /// A value breaks a rule.
    #[error("actuator file '{file}': {field}: '{value}' refused: {rule}")]
    Refused {
        /// The path or built-in name.
        file: String,
        /// The field, dots between levels.
        field: String,
        /// As written.
        value: String,
        /// The accepted values.
        rule: String,
    },
}

/// The names of the built-in actuators.
fn names() -> String {
    let names: Vec<&str> = built_in().map(|(name, _)| name).collect();
    names.join(", ")
}

/// The built-in actuators and circuits: name and file.
pub fn built_in() -> impl Iterator<Item = (&'static str, &'static str)> {
    BUILT_IN.iter().chain(circuit_file::BUILT_IN).copied()
}

/// The built-in actuator `name`, or the one in the file at the path `name`.
///
/// # Errors
/// [`ActuatorFileError`], naming file, field, value and rule.
pub fn load(name: &str) -> Result<ActuatorSet, ActuatorFileError> {
    match read(name)? {
        ActuatorFile::Metering(set) => Ok(*set),
        ActuatorFile::Circuit(_) => Err(ActuatorFileError::Circuit(name.to_owned())),
    }
}

/// The built-in actuator or circuit `name`, or the one in the file at the path `name`.
///
/// # Errors
/// [`ActuatorFileError`], naming file, field, value and rule.
pub fn read(name: &str) -> Result<ActuatorFile, ActuatorFileError> {
    if let Some((name, text)) = built_in().find(|(built_in, _)| *built_in == name) {
        return of_text(name, text);
    }
    let text = file::read(Path::new(name)).map_err(|error| ActuatorFileError::Unreadable {
        file: name.to_owned(),
        reason: match Model::named(name) {
            Some(Model::Ideal | Model::FirstOrder) => "it is a model without hydraulics".to_owned(),
            _ => error.to_string(),
        },
        meant: did_you_mean(name, built_in().map(|(name, _)| name)),
    })?;
    of_text(name, &text)
}

/// The actuator or circuit that `text` describes; `file` is what to call it in errors.
///
/// # Errors
/// [`ActuatorFileError`], naming file, field, value and rule.
pub fn of_text(file: &str, text: &str) -> Result<ActuatorFile, ActuatorFileError> {
    if !circuit_file::is_circuit(text) {
        return Ok(ActuatorFile::Metering(Box::new(parse(file, text)?)));
    }
    let file = file.to_owned();
    match circuit_file::parse(text) {
        Ok(circuit) => Ok(ActuatorFile::Circuit(Arc::new(circuit))),
        Err(circuit_file::FileError::Malformed(reason)) => {
            Err(ActuatorFileError::Malformed { file, reason })
        }
        Err(circuit_file::FileError::Refused(Refusal { field, value, rule })) => {
            Err(ActuatorFileError::Refused {
                file,
                field,
                value,
                rule,
            })
        }
    }
}

/// The actuator that `text` describes; `file` is what to call it in errors.
///
/// # Errors
/// [`ActuatorFileError`], naming file, field, value and rule.
pub fn parse(file: &str, text: &str) -> Result<ActuatorSet, ActuatorFileError> {
    let written: File =
        planesman_text::yaml::from_str(text).map_err(|error| ActuatorFileError::Malformed {
            file: file.to_owned(),
            reason: error.to_string(),
        })?;
    Reader { file }.set(&written)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    load: Load,
    ram: Ram,
    oil: Oil,
    valves: Valves,
    small_volume: Option<Small>,
    leakage: Leakage,
    logic: Logic,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Load {
    mass: Quantity,
    viscous: Quantity,
    coulomb: Quantity,
    moment_arm: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ram {
    area: Quantity,
    area_ratio: f64,
    volume_limit: Option<Quantity>,
    stop: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Oil {
    stiffness: Quantity,
    supply: Quantity,
    #[serde(rename = "return")]
    return_pressure: Quantity,
    clamp_positive: Quantity,
    clamp_negative: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Valves {
    volume: Quantity,
    frequency: Quantity,
    valve_time: Quantity,
    flow_time: Quantity,
    extra_delay: Quantity,
    switching_energy: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Small {
    volume: Quantity,
    flow_time: Quantity,
    quantum: Quantity,
    threshold: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Leakage {
    rate_gain: Quantity,
    error_rate: Quantity,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Logic {
    quantum: Quantity,
    threshold: Quantity,
    inhibit_beyond: Option<Quantity>,
    limit_option: u8,
    limit_feedback: Option<Quantity>,
}

/// One written field: its name, its text, its dimension.
struct Field<'a>(&'static str, &'a Quantity, Dimension);

/// The units of a quantity given as the plane angle it makes, or the turning rate, for a flow.
/// `per_radian` is the quantity that moves the planes by one radian (per second).
fn angles(dimension: Dimension, per_radian: f64) -> [Unit; 2] {
    let (radian, degree) = match dimension {
        Dimension::Flow => ("rad/s", "deg/s"),
        _ => ("rad", "deg"),
    };
    [
        Unit::new(radian, per_radian),
        Unit::new(degree, per_radian * DEGREE),
    ]
}

struct Reader<'a> {
    file: &'a str,
}

impl Reader<'_> {
    fn refused(&self, field: &str, value: impl ToString, rule: impl ToString) -> ActuatorFileError {
        ActuatorFileError::Refused {
            file: self.file.to_owned(),
            field: field.to_owned(),
            value: value.to_string(),
            rule: rule.to_string(),
        }
    }

    fn read(
        &self,
        Field(name, written, dimension): Field<'_>,
        range: [f64; 2],
        per_radian: Option<f64>,
    ) -> Result<f64, ActuatorFileError> {
        let angles = per_radian.map(|per_radian| angles(dimension, per_radian));
        written
            .within(dimension, angles.as_ref().map_or(&[], |units| units), range)
            .map_err(|error| self.refused(name, written, error))
    }

    /// A limit, infinite where the file gives none.
    fn limit(
        &self,
        name: &'static str,
        written: Option<&Quantity>,
        dimension: Dimension,
        range: [f64; 2],
        per_radian: f64,
    ) -> Result<f64, ActuatorFileError> {
        written.map_or(Ok(f64::INFINITY), |written| {
            self.read(Field(name, written, dimension), range, Some(per_radian))
        })
    }

    fn set(&self, file: &File) -> Result<ActuatorSet, ActuatorFileError> {
        use Dimension as D;
        let read = |name, written, dimension, range| {
            self.read(Field(name, written, dimension), range, None)
        };
        let (load, oil, valves) = (&file.load, &file.oil, &file.valves);

        let moment_arm = read("load.moment_arm", &load.moment_arm, D::Length, [1e-4, 1e2])?;
        let area = read("ram.area", &file.ram.area, D::Area, [1e-7, 10.0])?;
        // What moves the planes by one radian.
        let (travel, oil_moved) = (moment_arm, moment_arm * area);
        let read_as_angle = |name, written, dimension, range| {
            self.read(Field(name, written, dimension), range, Some(oil_moved))
        };

        let set = ActuatorSet {
            name: file.name.clone(),
            source: file.source.clone(),
            mass: read("load.mass", &load.mass, D::Mass, [1e-3, 1e7])?,
            viscous: read("load.viscous", &load.viscous, D::Damping, [1e-3, 1e8])?,
            coulomb: read("load.coulomb", &load.coulomb, D::Force, [0.0, 1e8])?,
            moment_arm,
            area,
            area_ratio: within(file.ram.area_ratio, [1.0, 1e3], "")
                .map_err(|rule| self.refused("ram.area_ratio", file.ram.area_ratio, rule))?,
            volume_limit: self.limit(
                "ram.volume_limit",
                file.ram.volume_limit.as_ref(),
                D::Volume,
                VOLUMES,
                oil_moved,
            )?,
            stop: self.limit(
                "ram.stop",
                file.ram.stop.as_ref(),
                D::Length,
                TRAVELS,
                travel,
            )?,
            stiffness: read(
                "oil.stiffness",
                &oil.stiffness,
                D::OilStiffness,
                [1e5, 1e21],
            )?,
            supply: read("oil.supply", &oil.supply, D::Pressure, [1e3, 1e9])?,
            return_pressure: read("oil.return", &oil.return_pressure, D::Pressure, [0.0, 1e9])?,
            clamp_positive: read(
                "oil.clamp_positive",
                &oil.clamp_positive,
                D::Pressure,
                [1.0, 1e9],
            )?,
            clamp_negative: read(
                "oil.clamp_negative",
                &oil.clamp_negative,
                D::Pressure,
                [1.0, 1e9],
            )?,
            volume: read_as_angle("valves.volume", &valves.volume, D::Volume, VOLUMES)?,
            frequency_millihertz: self.millihertz(&valves.frequency)?,
            valve_time: read(
                "valves.valve_time",
                &valves.valve_time,
                D::Time,
                [0.0, 100.0],
            )?,
            flow_time: read("valves.flow_time", &valves.flow_time, D::Time, FLOW_TIMES)?,
            extra_delay: read(
                "valves.extra_delay",
                &valves.extra_delay,
                D::Time,
                [0.0, 100.0],
            )?,
            switching_energy: (valves.switching_energy.as_ref()).map_or(
                Ok(SWITCHING_ENERGY),
                |written| {
                    let range = [0.0, MOST_SWITCHING_ENERGY];
                    read("valves.switching_energy", written, D::Energy, range)
                },
            )?,
            rate_gain: read_as_angle(
                "leakage.rate_gain",
                &file.leakage.rate_gain,
                D::Flow,
                [0.0, 1.0],
            )?,
            error_rate: read_as_angle(
                "leakage.error_rate",
                &file.leakage.error_rate,
                D::Flow,
                [-1.0, 1.0],
            )?,
            quantum: read("logic.quantum", &file.logic.quantum, D::Angle, ANGLES)?,
            threshold: read("logic.threshold", &file.logic.threshold, D::Angle, ANGLES)?,
            small: file
                .small_volume
                .as_ref()
                .map(|small| self.small_volume(small, oil_moved))
                .transpose()?,
            inhibit_beyond: self.limit(
                "logic.inhibit_beyond",
                file.logic.inhibit_beyond.as_ref(),
                D::Length,
                TRAVELS,
                travel,
            )?,
            limit_option: self.limit_option(&file.logic)?,
        };
        self.rules_between_fields(file, &set)?;
        Ok(set)
    }

    fn small_volume(
        &self,
        small: &Small,
        oil_moved: f64,
    ) -> Result<SmallVolume, ActuatorFileError> {
        use Dimension as D;
        let read = |name, written, dimension, range, per_radian| {
            self.read(Field(name, written, dimension), range, per_radian)
        };
        Ok(SmallVolume {
            volume: read(
                "small_volume.volume",
                &small.volume,
                D::Volume,
                VOLUMES,
                Some(oil_moved),
            )?,
            flow_time: read(
                "small_volume.flow_time",
                &small.flow_time,
                D::Time,
                FLOW_TIMES,
                None,
            )?,
            quantum: read(
                "small_volume.quantum",
                &small.quantum,
                D::Angle,
                ANGLES,
                None,
            )?,
            threshold: read(
                "small_volume.threshold",
                &small.threshold,
                D::Angle,
                ANGLES,
                None,
            )?,
        })
    }

    fn millihertz(&self, written: &Quantity) -> Result<u32, ActuatorFileError> {
        let field = "valves.frequency";
        let hertz = self.read(
            Field(field, written, Dimension::Frequency),
            [0.1, 1e4],
            None,
        )?;
        let millihertz = (hertz * 1e3).round();
        if (millihertz - hertz * 1e3).abs() > 1e-6 {
            return Err(self.refused(field, written, "it must be a whole number of millihertz"));
        }
        Ok(millihertz as u32)
    }

    fn limit_option(&self, logic: &Logic) -> Result<LimitOption, ActuatorFileError> {
        let field = "logic.limit_feedback";
        match (logic.limit_option, &logic.limit_feedback) {
            (1, None) => Ok(LimitOption::Unaware),
            (1, Some(written)) => Err(self.refused(
                field,
                written,
                "limit option 1 has no feedback from the actuator; leave the field out",
            )),
            (2, Some(written)) => self
                .read(
                    Field(field, written, Dimension::Angle),
                    [0.0, ANGLES[1]],
                    None,
                )
                .map(LimitOption::Aware),
            (2, None) => Err(self.refused(
                field,
                "",
                "limit option 2 books this angle for an inhibited volume; give it",
            )),
            (other, _) => Err(self.refused("logic.limit_option", other, "it must be 1 or 2")),
        }
    }

    fn rules_between_fields(
        &self,
        file: &File,
        set: &ActuatorSet,
    ) -> Result<(), ActuatorFileError> {
        let check = |holds: bool, field: &str, value: &dyn ToString, rule: &str| {
            if holds {
                Ok(())
            } else {
                Err(self.refused(field, value.to_string(), rule))
            }
        };
        check(
            set.area_ratio > 1.0,
            "ram.area_ratio",
            &set.area_ratio,
            "it must exceed 1: the larger area is the left one",
        )?;
        check(
            set.return_pressure < set.supply,
            "oil.return",
            &file.oil.return_pressure,
            "it must be below oil.supply",
        )?;
        let resting = set.supply / set.area_ratio;
        for (field, written, clamp, room, bound) in [
            (
                "oil.clamp_positive",
                &file.oil.clamp_positive,
                set.clamp_positive,
                set.supply - resting,
                "oil.supply less oil.supply/ram.area_ratio",
            ),
            (
                "oil.clamp_negative",
                &file.oil.clamp_negative,
                set.clamp_negative,
                resting - set.return_pressure,
                "oil.supply/ram.area_ratio less oil.return",
            ),
        ] {
            check(
                clamp <= room * (1.0 + 1e-12),
                field,
                written,
                &format!(
                    "it must not exceed {bound}, {room:.6} Pa, or oil would flow from low to high pressure"
                ),
            )?;
            check(
                clamp * set.area > set.coulomb * 1.001,
                field,
                written,
                "on ram.area it must overcome load.coulomb, or the ram never moves",
            )?;
        }
        if let (Some(small), Some(written)) = (&set.small, &file.small_volume) {
            check(
                small.volume < set.volume,
                "small_volume.volume",
                &written.volume,
                "it must be below valves.volume",
            )?;
            check(
                small.threshold <= set.threshold && small.threshold > small.quantum / 2.0,
                "small_volume.threshold",
                &written.threshold,
                "it must not exceed logic.threshold, and must exceed half of small_volume.quantum",
            )?;
            check(
                small.flow_time <= set.flow_time,
                "small_volume.flow_time",
                &written.flow_time,
                "it must not exceed valves.flow_time",
            )?;
        }
        let reach = set.delay() + set.flow_time;
        check(
            reach <= set.cycle() * MOST_CYCLES_IN_FLIGHT as f64,
            "valves.flow_time",
            &file.valves.flow_time,
            "extra_delay + valve_time + flow_time must end within 8 cycles of valves.frequency",
        )?;
        check(
            set.natural_frequency() * set.cycle() <= MOST_RADIANS,
            "oil.stiffness",
            &file.oil.stiffness,
            "the load must turn less than 10000 rad in a valve cycle",
        )?;
        check(
            set.mass / set.viscous >= SHORTEST_TIME,
            "load.viscous",
            &file.load.viscous,
            "load.mass over it must be at least 1e-6 s",
        )?;
        let leakage_rate = set.pressure_leakage() * set.stiffness;
        let damped = (leakage_rate * set.viscous / set.mass).sqrt();
        check(
            leakage_rate * SHORTEST_TIME <= 1.0 && damped * set.cycle() <= MOST_RADIANS,
            "leakage.rate_gain",
            &file.leakage.rate_gain,
            "it would empty the oil too fast: oil.supply over 2 rate_gain oil.stiffness must be at least 1e-6 s, and times load.mass over load.viscous at least (1e-4 valve cycles)^2",
        )?;
        check(
            set.threshold > set.quantum / 2.0,
            "logic.threshold",
            &file.logic.threshold,
            "it must exceed half of logic.quantum, or the logic never rests",
        )?;
        let nothing = Quantity::default();
        check(
            set.inhibit_beyond <= set.stop,
            "logic.inhibit_beyond",
            file.logic.inhibit_beyond.as_ref().unwrap_or(&nothing),
            "with a ram.stop it must be given and lie within it",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_units::{INCH, POUND_FORCE, PSI};

    fn auv_with(field: &str, replacement: &str) -> Result<ActuatorSet, ActuatorFileError> {
        let text = include_str!("../actuators/auv.yaml");
        let line = text
            .lines()
            .find(|line| line.trim_start().starts_with(field))
            .expect("the field is in the file");
        parse("mine.yaml", &text.replace(line, replacement))
    }

    #[test]
    fn the_built_in_actuators_load() {
        for (name, _) in BUILT_IN {
            let set = load(name).expect(name);
            assert!(!set.source.is_empty());
        }
        let polaris = load("table_4_1").expect("built in");
        assert!((polaris.mass - 0.296 * POUND_FORCE / INCH).abs() < 1e-12);
        assert!((polaris.clamp_negative / PSI - 750.0).abs() < 1e-9);
        assert_eq!(polaris.stop, f64::INFINITY);
        let auv = load("auv").expect("built in");
        assert!((auv.plane_quantum() - 0.5 * DEGREE).abs() < 1e-16);
        assert!((auv.stop - 33.0 * DEGREE * 0.5 * INCH).abs() < 1e-15);
    }

    #[test]
    fn a_refusal_names_the_file_the_field_the_value_and_the_rule() {
        for (field, line, rule) in [
            ("mass:", "  mass: -1 kg", "from 0.001 to 10000000 kg"),
            (
                "mass:",
                "  mass: 0.002",
                "one of the units kg, slug, lb s^2/in",
            ),
            (
                "mass:",
                "  mass: 2 stone",
                "one of the units kg, slug, lb s^2/in",
            ),
            ("coulomb:", "  coulomb: 10 lb", "overcome load.coulomb"),
            ("frequency:", "  frequency: 0.01 Hz", "from 0.1 to 10000 Hz"),
            ("frequency:", "  frequency: 80.0001 Hz", "millihertz"),
            ("flow_time:", "  flow_time: 1 s", "within 8 cycles"),
            (
                "threshold:",
                "  threshold: 0.2 deg",
                "half of logic.quantum",
            ),
            ("limit_option:", "  limit_option: 3", "1 or 2"),
            ("limit_option:", "  limit_option: 2", "limit option 2"),
            ("stiffness:", "  stiffness: 5e20 Pa/m^3", "10000 rad"),
            ("area_ratio:", "  area_ratio: .nan", "from 1 to 1000"),
            ("area_ratio:", "  area_ratio: 1", "exceed 1"),
            ("viscous:", "  viscous: 1e20 N s/m", "to 100000000 N s/m"),
            ("viscous:", "  viscous: 1e7 N s/m", "at least 1e-6 s"),
            ("moment_arm:", "  moment_arm: 1e308 m", "to 100 m"),
            ("rate_gain:", "  rate_gain: 1e308 m^3/s", "to 1 m^3/s"),
            ("rate_gain:", "  rate_gain: 0.01 m^3/s", "too fast"),
            ("return:", "  return: 200 psi", "below oil.supply"),
            ("switching_energy:", "  switching_energy: -1 J", "from 0"),
            (
                "switching_energy:",
                "  switching_energy: 1e300 J",
                "to 1000 J",
            ),
            ("switching_energy:", "  switching_energy: 1 W", "J, mJ"),
        ] {
            let error = auv_with(field, line).expect_err(line).to_string();
            assert!(
                error.contains("mine.yaml") && error.contains(rule),
                "{error}"
            );
        }
    }

    #[test]
    fn every_number_of_a_file_has_a_range() {
        let text = include_str!("../actuators/auv_two_speed.yaml");
        let mut tried = 0;
        for (path, at) in planesman_text::yaml::scalars(text).expect("YAML") {
            if path.len() < 2 {
                continue;
            }
            let written = text[at.clone()].trim_end();
            let unit = written.split_once(' ').map_or("", |it| it.1);
            for number in ["1e308", "-1e308", "1e-308", ".nan"] {
                let mut changed = text.to_owned();
                let number_and_unit = format!("{number} {unit} ");
                changed.replace_range(at.clone(), &number_and_unit);
                // Nothing leaks, or is late, at less than can be noticed.
                let vanishes = number == "1e-308"
                    && [
                        "coulomb",
                        "return",
                        "valve_time",
                        "extra_delay",
                        "rate_gain",
                        "error_rate",
                    ]
                    .contains(&path[path.len() - 1].as_str());
                let read = parse("mine.yaml", &changed);
                assert_eq!(read.is_err(), !vanishes, "{path:?}: {number_and_unit}");
                tried += 1;
            }
        }
        assert!(tried > 80, "{tried}");
    }

    #[test]
    fn an_unknown_a_missing_or_a_doubled_field_is_refused() {
        for (field, line) in [
            ("mass:", "  mas: 1 kg"),
            ("mass:", ""),
            ("mass:", "  mass: 1 kg\n  mass: 1 kg"),
            ("mass:", "  mass: [1, 2]"),
        ] {
            let error = auv_with(field, line).expect_err(line).to_string();
            assert!(error.contains("mine.yaml"), "{error}");
        }
        assert!(parse("x", "").is_err());
        assert!(parse("x", "\u{0}\u{ff}").is_err());
        assert!(load("no/such/file.yaml").is_err());
    }

    #[test]
    fn a_small_volume_is_smaller_than_the_large_one_in_every_way() {
        let text = include_str!("../actuators/auv_two_speed.yaml");
        let set = load("auv_two_speed").expect("built in");
        let small = set.small.expect("given");
        assert!((small.volume / set.volume - 0.25).abs() < 1e-12);
        let (large_half, small_half) = text.split_once("small_volume:").expect("there");
        for (field, line) in [
            ("volume:", "  volume: 1.1 deg"),
            ("flow_time:", "  flow_time: 7 ms"),
            ("threshold:", "  threshold: 0.7 deg"),
            ("threshold:", "  threshold: 0.1 deg"),
            ("quantum:", "  quantum: 0.4 deg"),
            ("quantum:", ""),
        ] {
            let whole = |small: &str| format!("{large_half}small_volume:{small}");
            let first = small_half
                .lines()
                .find(|l| l.trim_start().starts_with(field))
                .expect("a field");
            let error = parse("mine.yaml", &whole(&small_half.replacen(first, line, 1)))
                .expect_err(line)
                .to_string();
            assert!(error.contains(field.trim_end_matches(':')), "{error}");
        }
    }

    #[test]
    fn limit_option_2_carries_its_feedback() {
        let set = auv_with(
            "limit_option:",
            "  limit_option: 2\n  limit_feedback: 0 deg",
        )
        .expect("accepted");
        assert_eq!(set.limit_option, LimitOption::Aware(0.0));
    }
}
