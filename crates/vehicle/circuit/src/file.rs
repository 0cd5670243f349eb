//! Circuit files: YAML, every quantity with its unit, converted to SI once, here.
//!
//! `circuits/dfcu.yaml` is the example; [`BUILT_IN`] has the files that are built in.

use planesman_parameters::Choice;
use planesman_text::did_you_mean;
use planesman_units::{Dimension as D, Quantity, within};
use serde::de::{Deserialize, Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use crate::circuit::{
    Chamber, Circuit, Control, Edge, ElasticStop, Level, Line, Load, MOST_LEVELS, MOST_VALVES, Oil,
    Valves,
};
use crate::coding::Coding;

/// The built-in circuits: name and file.
pub const BUILT_IN: &[(&str, &str)] = &[("dfcu", include_str!("../circuits/dfcu.yaml"))];

/// The shortest time constant that is taken, s, and the highest frequency: what is faster would be simulated for ever.
const SHORTEST_TIME: f64 = 1e-6;
const MOST_FREQUENCY: f64 = 20_000.0;
/// The shortest and the longest delay of a line, s: a step is at most a round trip long, and the wave of a round trip is kept.
const LINE_DELAYS: [f64; 2] = [5e-5, 0.5];
/// Density of mineral oil, kg/m^3.
const DENSITY: f64 = 870.0;

/// Why a text describes no circuit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// Not YAML, or a field is missing or not known.
    #[error("{0}")]
    Malformed(String),
    /// A value breaks a rule.
    #[error("{field}: '{value}' refused: {rule}")]
    Refused {
        /// The field, dots between levels.
        field: String,
        /// As written.
        value: String,
        /// The accepted values.
        rule: String,
    },
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    load: WrittenLoad,
    #[serde(deserialize_with = "each_once")]
    chambers: BTreeMap<String, WrittenChamber>,
    seal_leakage: Option<Quantity>,
    #[serde(deserialize_with = "each_once")]
    supply: BTreeMap<String, Quantity>,
    #[serde(default, deserialize_with = "each_once")]
    lines: BTreeMap<String, WrittenLine>,
    oil: WrittenOil,
    valves: WrittenValves,
    #[serde(deserialize_with = "each_once")]
    edges: BTreeMap<String, WrittenEdge>,
    control: WrittenControl,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLoad {
    mass: Quantity,
    viscous: Quantity,
    coulomb: Quantity,
    #[serde(default)]
    stepping: f64,
    spring: Option<Quantity>,
    force: Option<Quantity>,
    travel: Quantity,
    elastic_stop: Option<WrittenStop>,
    moment_arm: Quantity,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenStop {
    stiffness: Quantity,
    /// s/m
    damping: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenChamber {
    area: Quantity,
    volume: Quantity,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLine {
    length: Quantity,
    diameter: Quantity,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenOil {
    bulk_modulus: Quantity,
    air: f64,
    #[serde(default = "fast")]
    polytropic: f64,
    density: Option<Quantity>,
    viscosity: Option<Quantity>,
}

fn fast() -> f64 {
    1.4
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenValves {
    rated_drop: Quantity,
    transition: Option<Quantity>,
    opening: Quantity,
    closing: Quantity,
    scatter: Option<Quantity>,
    rated_life: f64,
    energy: Option<Quantity>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEdge {
    coding: Option<String>,
    count: Option<usize>,
    flow: Option<Quantity>,
    flows: Option<Vec<Quantity>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenControl {
    law: String,
    period: Quantity,
    /// 1/s
    gain: f64,
    dead_zone: Option<Quantity>,
    #[serde(default)]
    switching_cost: f64,
    #[serde(default)]
    energy_cost: f64,
    pressure_limit: Option<Quantity>,
    force_filter: Option<Quantity>,
}

/// A mapping in which no key stands twice.
fn each_once<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    from: D,
) -> Result<BTreeMap<String, T>, D::Error> {
    struct Each<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Each<T> {
        type Value = BTreeMap<String, T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a mapping")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut all = BTreeMap::new();
            while let Some((key, value)) = map.next_entry::<String, T>()? {
                if all.contains_key(&key) {
                    return Err(A::Error::custom(format!("'{key}' stands there twice")));
                }
                all.insert(key, value);
            }
            Ok(all)
        }
    }

    from.deserialize_map(Each(PhantomData))
}

fn refused<T>(field: &str, value: impl ToString, rule: impl ToString) -> Result<T, FileError> {
    Err(FileError::Refused {
        field: field.to_owned(),
        value: value.to_string(),
        rule: rule.to_string(),
    })
}

/// The quantity in SI, within `[least, most]`.
fn read(
    field: &str,
    written: &Quantity,
    dimension: D,
    least: f64,
    most: f64,
) -> Result<f64, FileError> {
    let value = written.within(dimension, &[], [least, most]);
    value.or_else(|rule| refused(field, written, rule))
}

fn number(field: &str, value: f64, least: f64, most: f64) -> Result<f64, FileError> {
    within(value, [least, most], "").or_else(|rule| refused(field, value, rule))
}

fn or_zero(
    field: &str,
    written: Option<&Quantity>,
    dimension: D,
    most: f64,
) -> Result<f64, FileError> {
    written.map_or(Ok(0.0), |written| {
        read(field, written, dimension, 0.0, most)
    })
}

/// The choice of this name.
fn named<T: Choice>(field: &str, name: &str) -> Result<T, FileError> {
    match T::named(name) {
        Some(choice) => Ok(choice),
        None => refused(
            field,
            name,
            format!(
                "it must be one of {}{}",
                T::NAMES.join(", "),
                did_you_mean(name, T::NAMES.iter().copied())
            ),
        ),
    }
}

/// Whether a YAML text is meant to be a circuit: it has edges.
#[must_use]
pub fn is_circuit(text: &str) -> bool {
    #[derive(serde::Deserialize)]
    struct Head {
        edges: Option<IgnoredAny>,
        chambers: Option<IgnoredAny>,
    }
    planesman_text::yaml::from_str(text)
        .is_ok_and(|head: Head| head.edges.is_some() || head.chambers.is_some())
}

/// The circuit that `text` describes.
///
/// # Errors
/// [`FileError`], naming field, value and rule.
pub fn parse(text: &str) -> Result<Circuit, FileError> {
    let file: File = planesman_text::yaml::from_str(text)
        .map_err(|error| FileError::Malformed(error.to_string()))?;
    let mut levels: Vec<Level> = Vec::new();
    if !(2..=MOST_LEVELS).contains(&file.supply.len()) {
        return refused(
            "supply",
            format!("{} levels", file.supply.len()),
            format!("2 to {MOST_LEVELS} are taken, the tank T among them"),
        );
    }
    for (name, written) in &file.supply {
        let field = format!("supply.{name}");
        if name.is_empty() || name.len() > 8 || !name.chars().all(|c| c.is_ascii_alphanumeric()) {
            return refused(
                &field,
                name,
                "a level's name is of 1 to 8 letters and digits",
            );
        }
        levels.push(Level {
            name: name.clone(),
            pressure: read(&field, written, D::Pressure, 0.0, 1e8)?,
            line: None,
        });
    }
    if !file.supply.contains_key("T") {
        return refused(
            "supply",
            file.supply.keys().cloned().collect::<Vec<_>>().join(", "),
            "the tank T is missing",
        );
    }
    let tank = levels
        .iter()
        .find(|level| level.name == "T")
        .map_or(0.0, |level| level.pressure);
    if let Some(level) = levels.iter().find(|level| level.pressure < tank) {
        return refused(
            &format!("supply.{}", level.name),
            &file.supply[&level.name],
            "no level may have less pressure than the tank T",
        );
    }
    let load = load(&file.load)?;
    let chambers = chambers(&file.chambers, &load)?;
    let valves = &file.valves;
    let drop = read(
        "valves.rated_drop",
        &valves.rated_drop,
        D::Pressure,
        1e3,
        1e8,
    )?;
    let delay = |field, written| read(field, written, D::Time, 0.0, 1.0);
    let common = Valves {
        opening: delay("valves.opening", &valves.opening)?,
        closing: delay("valves.closing", &valves.closing)?,
        scatter: or_zero("valves.scatter", valves.scatter.as_ref(), D::Time, 1.0)?,
        transition: valves.transition.as_ref().map_or(Ok(5e4), |written| {
            read("valves.transition", written, D::Pressure, 1e2, 1e6)
        })?,
        rated_life: number("valves.rated_life", valves.rated_life, 1.0, 1e12)?,
        energy: or_zero("valves.energy", valves.energy.as_ref(), D::Energy, 1e3)?,
    };
    let mut edges = Vec::new();
    for (name, edge) in &file.edges {
        let field = format!("edges.{name}");
        let (level, chamber) = ends(&field, name, &levels, &chambers)?;
        if edges
            .iter()
            .any(|other: &Edge| (other.level, other.chamber) == (level, chamber))
        {
            return refused(
                &field,
                name,
                "this level and this chamber are connected already",
            );
        }
        edges.push(Edge {
            level,
            chamber,
            valves: edge_valves(&field, edge, drop)?,
        });
    }
    let oil = Oil {
        bulk_modulus: read(
            "oil.bulk_modulus",
            &file.oil.bulk_modulus,
            D::Pressure,
            1e6,
            1e11,
        )?,
        // Without any air a chamber that is drawn empty would have a pressure below zero.
        air: number("oil.air", file.oil.air, 1e-6, 0.5)?,
        polytropic: number("oil.polytropic", file.oil.polytropic, 1.0, 1.7)?,
    };
    lines(&file, &oil, &mut levels)?;
    let written = &file.control;
    let period =
        (read("control.period", &written.period, D::Time, 1e-4, 10.0)? * 1e9).round() as i64;
    let control = Control {
        law: named("control.law", &written.law)?,
        period,
        gain: number("control.gain", written.gain, 0.0, 1e4)?,
        dead_zone: or_zero(
            "control.dead_zone",
            written.dead_zone.as_ref(),
            D::Length,
            1.0,
        )?,
        switching_cost: number("control.switching_cost", written.switching_cost, 0.0, 1.0)?,
        energy_cost: number("control.energy_cost", written.energy_cost, 0.0, 10.0)?,
        pressure_limit: written
            .pressure_limit
            .as_ref()
            .map_or(Ok(f64::INFINITY), |limit| {
                read("control.pressure_limit", limit, D::Pressure, 1e3, 1e9)
            })?,
        force_filter: or_zero(
            "control.force_filter",
            written.force_filter.as_ref(),
            D::Time,
            10.0,
        )?,
    };
    let circuit = Circuit {
        name: file.name.clone(),
        source: file.source.clone(),
        load,
        chambers,
        seal_leakage: match &file.seal_leakage {
            None => 0.0,
            // Written as the flow at the rated pressure drop.
            Some(written) => read("seal_leakage", written, D::Flow, 0.0, 1.0)? / drop,
        },
        levels,
        oil,
        edges,
        valves: common,
        control,
    };
    if circuit.largest_speed() <= 0.0 {
        return refused(
            "edges",
            file.edges.keys().cloned().collect::<Vec<_>>().join(", "),
            "no pair of edges moves the ram",
        );
    }
    fast_enough(&circuit, &file)?;
    within_the_cylinder(&circuit, &file)?;
    Ok(circuit)
}

/// What the levels press into a stop stays in the cylinder, and no plane turns by a quarter.
fn within_the_cylinder(circuit: &Circuit, file: &File) -> Result<(), FileError> {
    let load = &circuit.load;
    let (high, low) = circuit.pressures();
    let [a, b] = &circuit.chambers;
    let out = high * a.area - low * b.area - load.force;
    let back = high * b.area - low * a.area + load.force;
    let deepest = load
        .elastic_stop
        .map_or(0.0, |stop| out.max(back).max(0.0) / stop.stiffness);
    let reach = load.travel + deepest;
    if [a, b].iter().any(|it| it.area * reach > 0.99 * it.volume)
        && let Some(stop) = &file.load.elastic_stop
    {
        return refused(
            "load.elastic_stop.stiffness",
            &stop.stiffness,
            format!(
                "the levels would press the ram {deepest:.3} m into it, to the end of its chamber"
            ),
        );
    }
    if reach / load.moment_arm >= std::f64::consts::FRAC_PI_2 {
        return refused(
            "load.moment_arm",
            &file.load.moment_arm,
            format!(
                "the ram's way of {reach:.3} m, stops included, would turn the plane by a right angle or more"
            ),
        );
    }
    Ok(())
}

/// What would take steps so short that a simulation never ends is refused.
fn fast_enough(circuit: &Circuit, file: &File) -> Result<(), FileError> {
    let load = &circuit.load;
    let frequency = circuit.highest_frequency();
    if frequency > MOST_FREQUENCY {
        return refused(
            "load.mass",
            &file.load.mass,
            format!(
                "load and oil would swing at {frequency:.0} Hz; at most {MOST_FREQUENCY} Hz are taken"
            ),
        );
    }
    if load.viscous > 0.0 && load.mass / load.viscous < SHORTEST_TIME {
        return refused(
            "load.viscous",
            &file.load.viscous,
            format!("mass over damping must be at least {SHORTEST_TIME} s"),
        );
    }
    for (place, edge) in circuit.edges.iter().enumerate() {
        let k: f64 = edge.valves.iter().sum();
        let time = circuit.least_volume(edge.chamber) * circuit.valves.transition.sqrt()
            / (k * circuit.oil.bulk_modulus);
        if time < SHORTEST_TIME {
            return refused(
                &format!("edges.{}", circuit.edge_name(place)),
                format!("{k} m^3/s/sqrt(Pa)"),
                format!(
                    "its valves would fill the chamber at the end of its travel within {time:.1e} s; at least {SHORTEST_TIME} s are taken"
                ),
            );
        }
    }
    for (chamber, it) in circuit.chambers.iter().enumerate() {
        let time =
            circuit.least_volume(chamber) / (circuit.seal_leakage * circuit.oil.bulk_modulus);
        if it.area > 0.0
            && time < SHORTEST_TIME
            && let Some(written) = &file.seal_leakage
        {
            return refused(
                "seal_leakage",
                written,
                format!(
                    "it would fill the chamber at the end of its travel within {time:.1e} s; at least {SHORTEST_TIME} s are taken"
                ),
            );
        }
    }
    let speed = circuit.largest_speed();
    if load.travel / speed < 1e3 * SHORTEST_TIME {
        return refused(
            "edges",
            format!("{speed} m/s"),
            "the valves would drive the ram through its travel within a millisecond",
        );
    }
    if let Some(stop) = load.elastic_stop
        && stop.damping * speed > 10.0
    {
        return refused(
            "load.elastic_stop.damping",
            stop.damping,
            format!("times the largest speed, {speed:.3} m/s, it must be at most 10"),
        );
    }
    let longest = circuit.valves.opening.max(circuit.valves.closing) + circuit.valves.scatter;
    let period = circuit.control.period as f64 * 1e-9;
    if longest > 100.0 * period {
        return refused(
            "control.period",
            &file.control.period,
            format!("the valves' delay, {longest} s with scatter, must be at most 100 periods"),
        );
    }
    Ok(())
}

/// Gives their lines to the levels.
fn lines(file: &File, oil: &Oil, levels: &mut [Level]) -> Result<(), FileError> {
    let written = file.oil.density.as_ref();
    let density = written.map_or(Ok(DENSITY), |written| {
        read("oil.density", written, D::Density, 100.0, 1e4)
    })?;
    let written = file.oil.viscosity.as_ref();
    let viscosity = or_zero("oil.viscosity", written, D::Viscosity, 1.0)?;
    for (name, written) in &file.lines {
        let Some(level) = levels.iter().position(|level| level.name == *name) else {
            let names: Vec<&str> = levels.iter().map(|level| &*level.name).collect();
            return refused(
                &format!("lines.{name}"),
                name,
                format!(
                    "a line is named as its supply level, of {}",
                    names.join(", ")
                ),
            );
        };
        let field = |what: &str| format!("lines.{name}.{what}");
        let length = read(&field("length"), &written.length, D::Length, 1e-3, 1e4)?;
        let diameter = read(&field("diameter"), &written.diameter, D::Length, 1e-4, 1.0)?;
        let line = Line::new(length, diameter, oil.bulk_modulus, density, viscosity);
        let [least, most] = LINE_DELAYS;
        if !(least..=most).contains(&line.delay) {
            return refused(
                &field("length"),
                &written.length,
                format!(
                    "a wave would take {:.2e} s from end to end; from {least} to {most} s are taken",
                    line.delay
                ),
            );
        }
        if line.resistance > line.impedance {
            return refused(
                &field("diameter"),
                &written.diameter,
                format!(
                    "the line's laminar resistance, {:.2e} Pa s/m^3, would exceed its impedance, {:.2e}: friction at its ends would not stand for it",
                    line.resistance, line.impedance
                ),
            );
        }
        levels[level].line = Some(line);
    }
    Ok(())
}

fn load(written: &WrittenLoad) -> Result<Load, FileError> {
    Ok(Load {
        mass: read("load.mass", &written.mass, D::Mass, 1e-3, 1e7)?,
        viscous: read("load.viscous", &written.viscous, D::Damping, 0.0, 1e8)?,
        coulomb: read("load.coulomb", &written.coulomb, D::Force, 0.0, 1e8)?,
        stepping: number("load.stepping", written.stepping, 0.0, 1.0)?,
        spring: or_zero("load.spring", written.spring.as_ref(), D::Stiffness, 1e9)?,
        force: written.force.as_ref().map_or(Ok(0.0), |force| {
            read("load.force", force, D::Force, -1e8, 1e8)
        })?,
        travel: read("load.travel", &written.travel, D::Length, 1e-4, 100.0)?,
        elastic_stop: match &written.elastic_stop {
            None => None,
            Some(stop) => Some(ElasticStop {
                stiffness: read(
                    "load.elastic_stop.stiffness",
                    &stop.stiffness,
                    D::Stiffness,
                    1.0,
                    1e12,
                )?,
                damping: number("load.elastic_stop.damping", stop.damping, 0.0, 1e4)?,
            }),
        },
        moment_arm: read(
            "load.moment_arm",
            &written.moment_arm,
            D::Length,
            1e-4,
            100.0,
        )?,
    })
}

fn chambers(
    written: &BTreeMap<String, WrittenChamber>,
    load: &Load,
) -> Result<[Chamber; 2], FileError> {
    if let Some(name) = written
        .keys()
        .find(|name| !["A", "B"].contains(&name.as_str()))
    {
        return refused(
            "chambers",
            name,
            "the chambers are A, which x > 0 enlarges, and B",
        );
    }
    let chamber = |name: &str| -> Result<Option<Chamber>, FileError> {
        let Some(chamber) = written.get(name) else {
            return Ok(None);
        };
        let field = |what: &str| format!("chambers.{name}.{what}");
        let area = read(&field("area"), &chamber.area, D::Area, 1e-7, 10.0)?;
        let volume = read(&field("volume"), &chamber.volume, D::Volume, 1e-9, 100.0)?;
        if volume <= 1.01 * area * load.travel {
            return refused(
                &field("volume"),
                &chamber.volume,
                format!(
                    "at mid-stroke it must be more than 1.01 times area times travel, {} m^3",
                    1.01 * area * load.travel
                ),
            );
        }
        Ok(Some(Chamber { area, volume }))
    };
    let Some(a) = chamber("A")? else {
        return refused("chambers", "", "chamber A is missing");
    };
    // A single-acting cylinder: whatever stands in for B does not move.
    Ok([
        a,
        chamber("B")?.unwrap_or(Chamber {
            area: 0.0,
            volume: 1.0,
        }),
    ])
}

/// Level and chamber of an edge: `P-A`, `B-T`.
fn ends(
    field: &str,
    name: &str,
    levels: &[Level],
    chambers: &[Chamber; 2],
) -> Result<(usize, usize), FileError> {
    let level = |name: &str| levels.iter().position(|level| level.name == name);
    let chamber = |name: &str| {
        ["A", "B"]
            .iter()
            .position(|known| *known == name)
            .filter(|place| chambers[*place].area > 0.0)
    };
    let ends = name.split_once('-').and_then(|(one, two)| {
        level(one)
            .zip(chamber(two))
            .or_else(|| level(two).zip(chamber(one)))
    });
    match ends {
        Some(ends) => Ok(ends),
        None => {
            let names: Vec<&str> = levels.iter().map(|level| level.name.as_str()).collect();
            refused(
                field,
                name,
                format!(
                    "an edge is written as LEVEL-CHAMBER or CHAMBER-LEVEL, of the levels {} and the chambers given",
                    names.join(", ")
                ),
            )
        }
    }
}

/// The flow coefficients of an edge's valves.
fn edge_valves(field: &str, edge: &WrittenEdge, drop: f64) -> Result<Vec<f64>, FileError> {
    let flow = |field: &str, written: &Quantity| {
        Ok(read(field, written, D::Flow, 1e-12, 10.0)? / drop.sqrt())
    };
    match edge {
        WrittenEdge {
            coding: None,
            count: None,
            flow: None,
            flows: Some(flows),
        } => {
            if flows.len() > MOST_VALVES {
                return refused(
                    &format!("{field}.flows"),
                    format!("{} valves", flows.len()),
                    format!("at most {MOST_VALVES} are taken"),
                );
            }
            flows
                .iter()
                .enumerate()
                .map(|(place, written)| flow(&format!("{field}.flows[{place}]"), written))
                .collect()
        }
        WrittenEdge {
            coding: Some(coding),
            count: Some(count),
            flow: Some(total),
            flows: None,
        } => {
            let coding: Coding = named(&format!("{field}.coding"), coding)?;
            if !(1..=MOST_VALVES).contains(count) {
                return refused(
                    &format!("{field}.count"),
                    count,
                    format!("it must be from 1 to {MOST_VALVES}"),
                );
            }
            Ok(coding.share(flow(&format!("{field}.flow"), total)?, *count))
        }
        _ => refused(
            field,
            "",
            "give `coding`, `count` and `flow` (all valves open), or `flows` of each valve, at the rated drop",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt as _;
    use rand_pcg::{Pcg64, rand_core::SeedableRng as _};

    fn refusal(from: &str, to: &str) -> String {
        let text = BUILT_IN[0].1;
        assert!(text.contains(from), "{from}");
        parse(&text.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn the_built_in_circuits_are_circuits() {
        for (name, text) in BUILT_IN {
            assert!(is_circuit(text), "{name}");
            parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }

    #[test]
    fn what_is_not_physical_is_refused_with_its_field() {
        let cases = [
            (
                "volume: 0.30 L",
                "volume: -0.3 L",
                "chambers.A.volume: '-0.3 L' refused",
            ),
            (
                "bulk_modulus: 1.4 GPa",
                "bulk_modulus: 0 GPa",
                "oil.bulk_modulus: '0 GPa' refused",
            ),
            (
                "count: 5",
                "count: 1000000",
                "count: '1000000' refused: it must be from 1 to 8",
            ),
            ("air: 0.005", "air: .nan", "oil.air: 'NaN' refused"),
            (
                "mass: 120 kg",
                "mass: .inf kg",
                "load.mass: '.inf kg' refused",
            ),
            ("T: 0.3 MPa", "R: 0.3 MPa", "the tank T is missing"),
            (
                "T: 0.3 MPa",
                "T: 30 MPa",
                "supply.P: '10 MPa' refused: no level may have less pressure than the tank T",
            ),
            (
                "P: 10 MPa",
                "P: 10 MPa\n  P: 1 MPa",
                "'P' stands there twice",
            ),
            ("A-T:", "A-X:", "an edge is written as LEVEL-CHAMBER"),
            ("law: model", "law: modle", "did you mean"),
            (
                "supply:",
                "lines: {P: {length: 0 m, diameter: 12 mm}}\nsupply:",
                "lines.P.length: '0 m' refused: it must be from 0.001 to 10000 m",
            ),
            (
                "supply:",
                "lines: {P: {length: .nan m, diameter: 12 mm}}\nsupply:",
                "lines.P.length: '.nan m' refused",
            ),
            (
                "supply:",
                "lines: {P: {length: 5 mm, diameter: 12 mm}}\nsupply:",
                "lines.P.length: '5 mm' refused: a wave would take 3.94e-6 s from end to end",
            ),
            (
                "supply:",
                "lines: {T: {length: 9000 m, diameter: 12 mm}}\nsupply:",
                "lines.T.length: '9000 m' refused: a wave would take 7.09e0 s",
            ),
            (
                "supply:",
                "lines: {R: {length: 1 m, diameter: 12 mm}}\nsupply:",
                "a line is named as its supply level, of P, T",
            ),
            (
                "oil:",
                "lines: {P: {length: 100 m, diameter: 3 mm}}\noil:\n  viscosity: 46 mm^2/s",
                "lines.P.diameter: '3 mm' refused: the line's laminar resistance",
            ),
            (
                "oil:",
                "oil:\n  density: 0 kg/m^3",
                "oil.density: '0 kg/m^3' refused",
            ),
            (
                "rated_life: 1e8",
                "rated_life: -1",
                "valves.rated_life: '-1' refused",
            ),
            (
                "\nvalves:",
                "\nseal_leakage: 1 m^3/s\nvalves:",
                "seal_leakage: '1 m^3/s' refused: it would fill the chamber",
            ),
            (
                "coulomb: 150 N",
                "coulomb: 150 N\n  elastic_stop: {stiffness: 1 N/m, damping: 0}",
                "load.elastic_stop.stiffness: '1 N/m' refused",
            ),
            (
                "moment_arm: 0.25 m",
                "moment_arm: 0.15 m",
                "load.moment_arm: '0.15 m' refused",
            ),
            ("\nedges:", "\nedge:", "unknown field `edge`"),
        ];
        for (from, to, said) in cases {
            let error = refusal(from, to);
            assert!(error.contains(said), "{to}: {error}");
        }
    }

    /// The text with each of its numbers multiplied by a power of ten of up to so many digits.
    fn stretched(text: &str, random: &mut Pcg64, digits: f64) -> String {
        let mut stretched = String::new();
        for piece in text.split_inclusive([' ', '{', ',', '\n']) {
            match piece.trim_end_matches([' ', ',', '\n', '}']).parse::<f64>() {
                Ok(number) if random.random::<f64>() < 0.15 => {
                    let factor = libm::pow(10.0, digits * (2.0 * random.random::<f64>() - 1.0));
                    let rest =
                        piece.trim_start_matches(|c: char| c.is_ascii_digit() || ".-e".contains(c));
                    stretched += &format!("{:e}{rest}", number * factor);
                }
                _ => stretched += piece,
            }
        }
        stretched
    }

    /// The file's single-acting cylinder.
    fn without_b(text: &str) -> String {
        let stays = |line: &&str| {
            !["B:", "P-B:", "B-T:"].contains(&line.split_whitespace().next().unwrap_or(""))
        };
        text.lines()
            .filter(stays)
            .map(|line| format!("{line}\n"))
            .collect()
    }

    #[test]
    fn whatever_is_taken_is_simulated_to_its_end_in_finite_numbers() {
        let mut random = Pcg64::seed_from_u64(3);
        let (mut taken, mut refused) = (0, 0);
        let whole = BUILT_IN[0].1.replace(
            "  coulomb: 150 N\n",
            "  coulomb: 150 N\n  spring: 2e4 N/m\n  force: 300 N\n  stepping: 0.1\n  elastic_stop: {stiffness: 5e6 N/m, damping: 2}\n",
        ) + "seal_leakage: 0.02 L/min\n";
        let lines = "lines: {P: {length: 3 m, diameter: 12 mm}, T: {length: 2 m, diameter: 16 mm}}\n\noil:\n  viscosity: 46 mm^2/s\n";
        let with_lines = BUILT_IN[0].1.replace("oil:\n", lines);
        let files = [BUILT_IN[0].1, &whole, &without_b(&whole), &with_lines];
        for case in 0..1600 {
            let digits = 5.0 * random.random::<f64>();
            let text = stretched(files[case % 4], &mut random, digits);
            let Ok(circuit) = parse(&text) else {
                refused += 1;
                continue;
            };
            taken += 1;
            let travel = circuit.load.travel;
            let point = |time, position, force| crate::Point {
                time,
                position,
                force,
            };
            let points = vec![
                point(0.0, -0.5 * travel, 0.0),
                point(0.02, 0.5 * travel, 1e4),
                point(0.04, 0.0, -1e4),
            ];
            let cycle = crate::LoadCycle::new(points).unwrap();
            let figures = crate::run(&circuit.into(), &cycle, 1e-6, 1, |_, row| {
                assert!(row.iter().all(|number| number.is_finite()), "{text}");
            });
            assert!(figures.steps < 100_000, "{} {text}", figures.steps);
            assert!(
                figures.energy.is_finite() && figures.life >= 0.0,
                "{figures:?} {text}"
            );
        }
        assert!(taken > 50 && refused > 50, "{taken} {refused}");
    }
}
