//! Actuator files in YAML. Every quantity has its unit; only this module converts it to SI.
//!
//! `actuators/table_4_1.yaml` is the example; the fields are Tables 3-1 and 4-1 of IBM 66-L03-005. [`BUILT_IN`] lists the built-in files;
//! `auv_two_speed` is the example of a `small_volume`. A file with `edges` is a circuit of on/off valves ([`planesman_circuit::file`]).

use std::borrow::Cow;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use planesman_circuit::file as circuit_file;
use planesman_parameters::{Choice as _, file};
use planesman_text::did_you_mean;
use planesman_text::yaml::{self, Refusal};
use planesman_units::{DEGREE, Dimension, Quantity, Unit, readers};
use serde::Deserialize;

use crate::actuator_model::Model;
use crate::actuator_set::{
    ActuatorFile, ActuatorSet, LimitOption, MOST_CYCLES_IN_FLIGHT, Oil, RamLoad, SmallVolume,
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

/// Default electrical energy for one switching of a valve, J: the value of a cartridge valve that switches in milliseconds. 50 to 55 V for
/// 6 to 8 ms, the current rising to 3 A: 52.5 V 3 A 7 ms/2 (voltages, times and highest current by F. Breidi, T. Helmus, M. Holland and J.
/// Lumkes, "The Impact of Peak-And-Hold and Reverse Current Driving Strategies on the Dynamic Performance of Commercial Cartridge Valves",
/// ASME/Bath FPMC 2014). A latching valve draws no energy while it holds.
pub const SWITCHING_ENERGY: f64 = 0.55;

/// Limits of the simulation: the shortest time constant, s, and the most rad in one valve cycle.
const SHORTEST_TIME: f64 = 1e-6;
const MOST_RADIANS: f64 = 1e4;

/// The reason why an actuator was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum ActuatorFileError {
    /// The file cannot be read.
    #[error("actuator file '{file}': {reason}; built in are {}{meant}", names())]
    Unreadable {
        /// The path.
        file: String,
        /// Reason from the operating system.
        reason: String,
        /// A suggestion of the built-in name, as a question; empty if no name is similar.
        meant: String,
    },
    /// The file is not YAML, lacks a field, or has an unknown field.
    #[error("actuator file '{file}': {reason}")]
    Malformed {
        /// The path or built-in name.
        file: String,
        /// Reason, and place in the file.
        reason: String,
    },
    /// The file is a circuit of on/off valves, but an actuator of metered volumes is needed.
    #[error(
        "actuator file '{0}' is a circuit of on/off valves, but this command needs an actuator of metered volumes. For circuits use `planesman dha design {0}`"
    )]
    Circuit(String),
    /// A value breaks a rule.
    #[error("actuator file '{file}': {refusal}")]
    Refused {
        /// The path or built-in name.
        file: String,
        /// Field, value and rule.
        refusal: Refusal,
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

/// Loads the built-in actuator `name`, or the file at the path `name`.
///
/// # Errors
/// [`ActuatorFileError`], with file, field, value and rule.
pub fn load(name: &str) -> Result<ActuatorSet, ActuatorFileError> {
    match read(name)? {
        ActuatorFile::Metering(set) => Ok(*set),
        ActuatorFile::Circuit(_) => Err(ActuatorFileError::Circuit(name.to_owned())),
    }
}

/// Reads the built-in actuator or circuit `name`, or the file at the path `name`.
///
/// # Errors
/// [`ActuatorFileError`], with file, field, value and rule.
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

/// Parses the actuator or circuit in `text`; errors call it `file`.
///
/// # Errors
/// [`ActuatorFileError`], with file, field, value and rule.
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
        Err(circuit_file::FileError::Refused(refusal)) => {
            Err(ActuatorFileError::Refused { file, refusal })
        }
    }
}

/// Parses the actuator in `text`; errors call it `file`.
///
/// # Errors
/// [`ActuatorFileError`], with file, field, value and rule.
pub fn parse(file: &str, text: &str) -> Result<ActuatorSet, ActuatorFileError> {
    let written: File = yaml::from_str(text).map_err(|error| ActuatorFileError::Malformed {
        file: file.to_owned(),
        reason: error.to_string(),
    })?;
    let set = written.set();
    set.map_err(|(field, rule)| ActuatorFileError::Refused {
        file: file.to_owned(),
        refusal: Refusal::at::<Quantity>(text, field, &rule),
    })
}

/// A field, and the rule that its value violates.
type Broken = (&'static str, String);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    load: RamLoad,
    ram: Ram,
    oil: Oil,
    valves: Valves,
    small_volume: Option<Small>,
    leakage: Leakage,
    logic: Logic,
}

readers! {
    area: Area, [1e-7, 10.0];
    area_ratio: Number, [1.0, 1e3];
    frequency: Frequency, [0.1, 1e4];
    delay: Time, [0.0, 100.0];
    flow_time: Time, [1e-5, 100.0];
    // No solenoid takes more.
    switching_energy: Energy, [0.0, 1e3], or SWITCHING_ENERGY;
    angle: Angle, [1e-6, PI];
    optional limit_feedback: Angle, [0.0, PI];
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ram {
    #[serde(with = "area")]
    area: f64,
    #[serde(with = "area_ratio")]
    area_ratio: f64,
    volume_limit: Option<Quantity>,
    stop: Option<Quantity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Valves {
    volume: Quantity,
    #[serde(with = "frequency")]
    frequency: f64,
    #[serde(with = "delay")]
    valve_time: f64,
    #[serde(with = "flow_time")]
    flow_time: f64,
    #[serde(with = "delay")]
    extra_delay: f64,
    #[serde(default = "switching_energy::default", with = "switching_energy")]
    switching_energy: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Small {
    volume: Quantity,
    #[serde(with = "flow_time")]
    flow_time: f64,
    #[serde(with = "angle")]
    quantum: f64,
    #[serde(with = "angle")]
    threshold: f64,
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
    #[serde(with = "angle")]
    quantum: f64,
    #[serde(with = "angle")]
    threshold: f64,
    inhibit_beyond: Option<Quantity>,
    limit_option: u8,
    #[serde(default, with = "limit_feedback")]
    limit_feedback: Option<f64>,
}

/// Reads a quantity in SI and checks its range; the file may also give the quantity as a plane angle, or a flow as a turning rate. `per_radian` is
/// the quantity that moves the planes by 1 rad, or by 1 rad/s.
fn angle_or(
    dimension: Dimension,
    range: [f64; 2],
    per_radian: f64,
) -> impl Fn(&'static str, &Quantity) -> Result<f64, Broken> {
    let (radian, degree) = match dimension {
        Dimension::Flow => ("rad/s", "deg/s"),
        _ => ("rad", "deg"),
    };
    let angles = [
        Unit::new(radian, per_radian),
        Unit::new(degree, per_radian * DEGREE),
    ];
    move |field, written| {
        let value = written.within(dimension, &angles, range);
        value.map_err(|rule| (field, rule.to_string()))
    }
}

impl File {
    fn set(self) -> Result<ActuatorSet, Broken> {
        let (ram, valves, logic) = (&self.ram, &self.valves, &self.logic);
        // What moves the planes by one radian.
        let travel = self.load.moment_arm;
        let oil_moved = travel * ram.area;
        let volume = angle_or(Dimension::Volume, [1e-12, 1.0], oil_moved);
        let length = angle_or(Dimension::Length, [1e-6, 100.0], travel);
        let flow = |least| angle_or(Dimension::Flow, [least, 1.0], oil_moved);
        let length_or_none = |field, written: &Option<Quantity>| {
            (written.as_ref()).map_or(Ok(f64::INFINITY), |it| length(field, it))
        };
        let millihertz = (valves.frequency * 1e3).round();
        if (millihertz - valves.frequency * 1e3).abs() > 1e-6 {
            let rule = "it must be a whole number of millihertz";
            return Err(("valves.frequency", rule.to_owned()));
        }
        let small = |it: &Small| {
            Ok(SmallVolume {
                volume: volume("small_volume.volume", &it.volume)?,
                flow_time: it.flow_time,
                quantum: it.quantum,
                threshold: it.threshold,
            })
        };
        let set = ActuatorSet {
            area: ram.area,
            area_ratio: ram.area_ratio,
            volume_limit: (ram.volume_limit.as_ref())
                .map_or(Ok(f64::INFINITY), |it| volume("ram.volume_limit", it))?,
            stop: length_or_none("ram.stop", &ram.stop)?,
            volume: volume("valves.volume", &valves.volume)?,
            frequency_millihertz: millihertz as u32,
            valve_time: valves.valve_time,
            flow_time: valves.flow_time,
            extra_delay: valves.extra_delay,
            switching_energy: valves.switching_energy,
            rate_gain: flow(0.0)("leakage.rate_gain", &self.leakage.rate_gain)?,
            error_rate: flow(-1.0)("leakage.error_rate", &self.leakage.error_rate)?,
            quantum: logic.quantum,
            threshold: logic.threshold,
            small: self.small_volume.as_ref().map(small).transpose()?,
            inhibit_beyond: length_or_none("logic.inhibit_beyond", &logic.inhibit_beyond)?,
            limit_option: logic.limit_option()?,
            name: self.name,
            source: self.source,
            load: self.load,
            oil: self.oil,
        };
        set.check()?;
        Ok(set)
    }
}

impl Logic {
    fn limit_option(&self) -> Result<LimitOption, Broken> {
        let (field, rule) = match (self.limit_option, self.limit_feedback) {
            (1, None) => return Ok(LimitOption::Unaware),
            (2, Some(feedback)) => return Ok(LimitOption::Aware(feedback)),
            (1, Some(_)) => (
                "logic.limit_feedback",
                "limit option 1 uses no feedback from the actuator; leave the field out",
            ),
            (2, None) => (
                "logic.limit_feedback",
                "limit option 2 needs this angle, which it counts for an inhibited volume",
            ),
            _ => ("logic.limit_option", "it must be 1 or 2"),
        };
        Err((field, rule.to_owned()))
    }
}

/// Whether a rule is satisfied, with the rule's field and the allowed values.
type CheckedRule = (bool, &'static str, Cow<'static, str>);

impl ActuatorSet {
    /// Checks the rules that relate several fields.
    fn check(&self) -> Result<(), Broken> {
        let logic: [CheckedRule; 2] = [
            (
                self.threshold > self.quantum / 2.0,
                "logic.threshold",
                "it must exceed half of logic.quantum; otherwise the logic never rests".into(),
            ),
            (
                self.inhibit_beyond <= self.stop,
                "logic.inhibit_beyond",
                "if ram.stop is given, this limit must be given too and lie within ram.stop".into(),
            ),
        ];
        let rules = self.pressure_rules().into_iter();
        let small = self.small.iter().flat_map(|it| self.small_rules(it));
        let all = rules.chain(small).chain(self.time_rules()).chain(logic);
        let broken = all.into_iter().find(|rule| !rule.0);
        broken.map_or(Ok(()), |(_, field, rule)| Err((field, rule.into_owned())))
    }

    /// Rules for the pressures: no backward flow, and enough force to move the ram.
    fn pressure_rules(&self) -> [CheckedRule; 6] {
        let oil = &self.oil;
        let resting = oil.supply / self.area_ratio;
        let clamped = |field, clamp: f64, room: f64, bound| {
            let rule = format!(
                "it must not exceed {bound}, {room:.6} Pa; otherwise oil would flow from low to high pressure"
            );
            (clamp <= room * (1.0 + 1e-12), field, rule.into())
        };
        let moves = |field, clamp: f64| {
            let rule = "the pressure times ram.area must exceed load.coulomb; otherwise the ram never moves";
            let holds = clamp * self.area > self.load.coulomb * 1.001;
            (holds, field, rule.into())
        };
        [
            (
                self.area_ratio > 1.0,
                "ram.area_ratio",
                "the ratio must exceed 1: the left side has the larger area".into(),
            ),
            (
                oil.return_pressure < oil.supply,
                "oil.return",
                "it must be below oil.supply".into(),
            ),
            clamped(
                "oil.clamp_positive",
                oil.clamp_positive,
                oil.supply - resting,
                "oil.supply less oil.supply/ram.area_ratio",
            ),
            moves("oil.clamp_positive", oil.clamp_positive),
            clamped(
                "oil.clamp_negative",
                oil.clamp_negative,
                resting - oil.return_pressure,
                "oil.supply/ram.area_ratio less oil.return",
            ),
            moves("oil.clamp_negative", oil.clamp_negative),
        ]
    }

    /// Rules for the small volume: smaller than the large volume in every respect.
    fn small_rules(&self, small: &SmallVolume) -> [CheckedRule; 3] {
        [
            (
                small.volume < self.volume,
                "small_volume.volume",
                "it must be below valves.volume".into(),
            ),
            (
                small.threshold <= self.threshold && small.threshold > small.quantum / 2.0,
                "small_volume.threshold",
                "it must not exceed logic.threshold, and must exceed half of small_volume.quantum"
                    .into(),
            ),
            (
                small.flow_time <= self.flow_time,
                "small_volume.flow_time",
                "it must not exceed valves.flow_time".into(),
            ),
        ]
    }

    /// Rules for the times: volumes arrive in time, and no time constant is too short to simulate.
    fn time_rules(&self) -> [CheckedRule; 4] {
        let load = &self.load;
        let leakage_rate = self.pressure_leakage() * self.oil.stiffness;
        let damped = (leakage_rate * load.viscous / load.mass).sqrt();
        let flow_ends = self.delay() + self.flow_time;
        [
            (
                flow_ends <= self.cycle() * MOST_CYCLES_IN_FLIGHT as f64,
                "valves.flow_time",
                "extra_delay + valve_time + flow_time must end within 8 cycles of valves.frequency"
                    .into(),
            ),
            (
                self.natural_frequency() * self.cycle() <= MOST_RADIANS,
                "oil.stiffness",
                "the load must oscillate by less than 10000 rad in a valve cycle".into(),
            ),
            (
                load.mass / load.viscous >= SHORTEST_TIME,
                "load.viscous",
                "load.mass divided by this value must be at least 1e-6 s".into(),
            ),
            (
                leakage_rate * SHORTEST_TIME <= 1.0 && damped * self.cycle() <= MOST_RADIANS,
                "leakage.rate_gain",
                "the oil would leak away too fast: oil.supply / (2 rate_gain oil.stiffness) must be at least 1e-6 s, and its product with load.mass / load.viscous at least (1e-4 valve cycles)^2".into(),
            ),
        ]
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
        assert!((polaris.load.mass - 0.296 * POUND_FORCE / INCH).abs() < 1e-12);
        assert!((polaris.oil.clamp_negative / PSI - 750.0).abs() < 1e-9);
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
            ("coulomb:", "  coulomb: 10 lb", "must exceed load.coulomb"),
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
