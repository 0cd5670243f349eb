//! Circuit files: YAML, every quantity with its unit, converted to SI here.
//!
//! `circuits/dfcu.yaml` is an example; [`BUILT_IN`] has the built-in files.

use planesman_text::yaml::{self, Refusal};
use planesman_units::{Quantity, readers};
use serde::de::{Error as _, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use crate::choice::named;
use crate::circuit::{
    Chamber, Circuit, Control, Edge, Level, Line, Load, MOST_LEVELS, MOST_VALVES, Oil, Valves,
};
use crate::coding::Coding;

/// The built-in circuits: name and file.
pub const BUILT_IN: &[(&str, &str)] = &[("dfcu", include_str!("../circuits/dfcu.yaml"))];

/// The shortest accepted time constant, s, and the highest frequency: anything faster would be simulated for ever.
const SHORTEST_TIME: f64 = 1e-6;
const MOST_FREQUENCY: f64 = 20_000.0;
/// The shortest and the longest delay of a line, s: a step is at most a round trip long, and the wave of a round trip is stored.
const LINE_DELAYS: [f64; 2] = [5e-5, 0.5];

/// The reason why a text is not a valid circuit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// The text is not YAML, or a field is missing or unknown.
    #[error("{0}")]
    Malformed(String),
    /// A value violates a rule.
    #[error("{0}")]
    Refused(Refusal),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    load: Load,
    #[serde(deserialize_with = "each_once")]
    chambers: BTreeMap<String, Chamber>,
    /// Flow at the rated pressure drop, m^3/s.
    #[serde(default, with = "leakage")]
    seal_leakage: f64,
    #[serde(deserialize_with = "each_once")]
    supply: BTreeMap<String, Pressure>,
    #[serde(default, deserialize_with = "each_once")]
    lines: BTreeMap<String, LineSection>,
    oil: Oil,
    valves: Valves,
    #[serde(deserialize_with = "each_once")]
    edges: BTreeMap<String, EdgeSection>,
    control: Control,
}

readers! {
    leakage: Flow, [0.0, 1.0], or 0.0;
    pressure: Pressure, [0.0, 1e8];
    length: Length, [1e-3, 1e4];
    diameter: Length, [1e-4, 1.0];
    flow: Flow, [1e-12, 10.0];
    optional total_flow: Flow, [1e-12, 10.0];
}

/// Gauge pressure of a supply level, Pa.
#[derive(Deserialize)]
struct Pressure(#[serde(with = "pressure")] f64);

/// Flow of a valve at the rated pressure drop, m^3/s.
#[derive(Deserialize)]
struct Flow(#[serde(with = "flow")] f64);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineSection {
    #[serde(with = "length")]
    length: f64,
    #[serde(with = "diameter")]
    diameter: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgeSection {
    coding: Option<String>,
    count: Option<usize>,
    #[serde(default, with = "total_flow")]
    flow: Option<f64>,
    flows: Option<Vec<Flow>>,
}

/// A YAML mapping that rejects duplicate keys.
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
                    return Err(A::Error::custom(format!("'{key}' occurs twice")));
                }
                all.insert(key, value);
            }
            Ok(all)
        }
    }

    from.deserialize_map(Each(PhantomData))
}

/// A field that violates a rule: its path, its value if it differs from the file's, and the rule.
struct Broken {
    field: String,
    value: Option<String>,
    rule: String,
}

fn refused<T>(field: &str, value: impl ToString, rule: impl ToString) -> Result<T, Broken> {
    Err(Broken {
        field: field.to_owned(),
        value: Some(value.to_string()),
        rule: rule.to_string(),
    })
}

/// Refuses the file's value of `field`.
fn refused_there<T>(field: &str, rule: impl ToString) -> Result<T, Broken> {
    Err(Broken {
        field: field.to_owned(),
        value: None,
        rule: rule.to_string(),
    })
}

/// Whether a YAML text is a circuit: it has edges.
#[must_use]
pub fn is_circuit(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Head {
        edges: Option<IgnoredAny>,
        chambers: Option<IgnoredAny>,
    }
    yaml::from_str(text).is_ok_and(|head: Head| head.edges.is_some() || head.chambers.is_some())
}

/// The circuit in `text`.
///
/// # Errors
/// [`FileError`], with field, value and rule.
pub fn parse(text: &str) -> Result<Circuit, FileError> {
    let file: File =
        yaml::from_str(text).map_err(|error| FileError::Malformed(error.to_string()))?;
    file.circuit().map_err(|Broken { field, value, rule }| {
        FileError::Refused(match value {
            Some(value) => Refusal { field, value, rule },
            None => Refusal::at::<Quantity>(text, &field, &rule),
        })
    })
}

impl File {
    fn circuit(self) -> Result<Circuit, Broken> {
        let mut levels = levels(&self.supply)?;
        let chambers = chambers(&self.chambers, &self.load)?;
        let edges = edges(&self.edges, &levels, &chambers, self.valves.rated_drop)?;
        add_lines(&self.lines, &self.oil, &mut levels)?;
        let circuit = Circuit {
            name: self.name,
            source: self.source,
            load: self.load,
            chambers,
            seal_leakage: self.seal_leakage / self.valves.rated_drop,
            levels,
            oil: self.oil,
            edges,
            valves: self.valves,
            control: self.control,
        };
        if circuit.largest_speed() <= 0.0 {
            let names: Vec<String> = self.edges.into_keys().collect();
            return refused("edges", names.join(", "), "no pair of edges moves the ram");
        }
        swings_slowly(&circuit)?;
        fills_slowly(&circuit)?;
        moves_slowly(&circuit)?;
        within_the_cylinder(&circuit)?;
        Ok(circuit)
    }
}

/// The supply levels, including the tank T.
fn levels(supply: &BTreeMap<String, Pressure>) -> Result<Vec<Level>, Broken> {
    if !(2..=MOST_LEVELS).contains(&supply.len()) {
        return refused(
            "supply",
            format!("{} levels", supply.len()),
            format!("there must be 2 to {MOST_LEVELS} levels, including the tank T"),
        );
    }
    let is_name = |name: &str| {
        (1..=8).contains(&name.len()) && name.chars().all(|c| c.is_ascii_alphanumeric())
    };
    if let Some(name) = supply.keys().find(|name| !is_name(name)) {
        let rule = "a level's name must have 1 to 8 letters and digits";
        return refused(&format!("supply.{name}"), name, rule);
    }
    let Some(tank) = supply.get("T") else {
        let names: Vec<&str> = supply.keys().map(String::as_str).collect();
        return refused("supply", names.join(", "), "the tank T is missing");
    };
    if let Some((name, _)) = supply.iter().find(|(_, pressure)| pressure.0 < tank.0) {
        let rule = "no level may have a lower pressure than the tank T";
        return refused_there(&format!("supply.{name}"), rule);
    }
    let level = |(name, pressure): (&String, &Pressure)| Level {
        name: name.clone(),
        pressure: pressure.0,
        line: None,
    };
    Ok(supply.iter().map(level).collect())
}

/// Checks that a ram pressed into an elastic stop by the levels stays in the cylinder, and that no plane turns by 90 degrees.
fn within_the_cylinder(circuit: &Circuit) -> Result<(), Broken> {
    let load = &circuit.load;
    let (high, low) = circuit.pressures();
    let [a, b] = &circuit.chambers;
    let out = high * a.area - low * b.area - load.force;
    let back = high * b.area - low * a.area + load.force;
    let deepest = load
        .elastic_stop
        .map_or(0.0, |stop| out.max(back).max(0.0) / stop.stiffness);
    let reach = load.travel + deepest;
    if load.elastic_stop.is_some() && [a, b].iter().any(|it| it.area * reach > 0.99 * it.volume) {
        return refused_there(
            "load.elastic_stop.stiffness",
            format!(
                "at these pressure levels the ram would move {deepest:.3} m into the stop, to the end of its chamber"
            ),
        );
    }
    if reach / load.moment_arm >= std::f64::consts::FRAC_PI_2 {
        return refused_there(
            "load.moment_arm",
            format!(
                "the ram's travel of {reach:.3} m, including stops, would turn the plane by a \
                 right angle or more"
            ),
        );
    }
    Ok(())
}

/// Refuses a load that oscillates so fast that a simulation would never end.
fn swings_slowly(circuit: &Circuit) -> Result<(), Broken> {
    let load = &circuit.load;
    let frequency = circuit.highest_frequency();
    if frequency > MOST_FREQUENCY {
        return refused_there(
            "load.mass",
            format!(
                "load and oil would oscillate at {frequency:.0} Hz; at most {MOST_FREQUENCY} Hz \
                 are allowed"
            ),
        );
    }
    if load.viscous > 0.0 && load.mass / load.viscous < SHORTEST_TIME {
        return refused_there(
            "load.viscous",
            format!("mass divided by damping must be at least {SHORTEST_TIME} s"),
        );
    }
    Ok(())
}

/// Refuses flows that fill a chamber so fast that a simulation would never end.
fn fills_slowly(circuit: &Circuit) -> Result<(), Broken> {
    for (place, edge) in circuit.edges.iter().enumerate() {
        let k: f64 = edge.valves.iter().sum();
        let time = circuit.least_volume(edge.chamber) * circuit.valves.transition.sqrt()
            / (k * circuit.oil.bulk_modulus);
        if time < SHORTEST_TIME {
            return refused(
                &format!("edges.{}", circuit.edge_name(place)),
                format!("{k} m^3/s/sqrt(Pa)"),
                format!(
                    "its valves would fill the chamber within {time:.1e} s when the ram is at the end of its travel; at least {SHORTEST_TIME} s are required"
                ),
            );
        }
    }
    for (chamber, it) in circuit.chambers.iter().enumerate() {
        let time =
            circuit.least_volume(chamber) / (circuit.seal_leakage * circuit.oil.bulk_modulus);
        if it.area > 0.0 && time < SHORTEST_TIME {
            return refused_there(
                "seal_leakage",
                format!(
                    "the leakage would fill the chamber within {time:.1e} s when the ram is at the end of its travel; at least {SHORTEST_TIME} s are required"
                ),
            );
        }
    }
    Ok(())
}

/// Refuses a ram that is too fast for its stops and its valves' delays.
fn moves_slowly(circuit: &Circuit) -> Result<(), Broken> {
    let load = &circuit.load;
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
            format!("the product with the largest speed, {speed:.3} m/s, must be at most 10"),
        );
    }
    let longest = circuit.valves.opening.max(circuit.valves.closing) + circuit.valves.scatter;
    let period = circuit.control.period as f64 * 1e-9;
    if longest > 100.0 * period {
        return refused_there(
            "control.period",
            format!(
                "the valves' delay, {longest} s including scatter, must be at most 100 periods"
            ),
        );
    }
    Ok(())
}

/// Adds the lines to their levels.
fn add_lines(
    lines: &BTreeMap<String, LineSection>,
    oil: &Oil,
    levels: &mut [Level],
) -> Result<(), Broken> {
    for (name, it) in lines {
        let Some(level) = levels.iter().position(|level| level.name == *name) else {
            let names: Vec<&str> = levels.iter().map(|level| &*level.name).collect();
            return refused(
                &format!("lines.{name}"),
                name,
                format!(
                    "a line must have the name of its supply level, one of {}",
                    names.join(", ")
                ),
            );
        };
        let bulk = oil.bulk_modulus;
        let line = Line::new(it.length, it.diameter, bulk, oil.density, oil.viscosity);
        let [least, most] = LINE_DELAYS;
        if !(least..=most).contains(&line.delay) {
            return refused_there(
                &format!("lines.{name}.length"),
                format!(
                    "a pressure wave would take {:.2e} s from end to end of the line; {least} to {most} s are allowed",
                    line.delay
                ),
            );
        }
        if line.resistance > line.impedance {
            return refused_there(
                &format!("lines.{name}.diameter"),
                format!(
                    "the line's laminar resistance, {:.2e} Pa s/m^3, would exceed its impedance, \
                     {:.2e}: friction at its ends is then not a valid model",
                    line.resistance, line.impedance
                ),
            );
        }
        levels[level].line = Some(line);
    }
    Ok(())
}

fn chambers(given: &BTreeMap<String, Chamber>, load: &Load) -> Result<[Chamber; 2], Broken> {
    if let Some(name) = given.keys().find(|name| !["A", "B"].contains(&&***name)) {
        let rule = "the chambers must be A, which x > 0 enlarges, and B";
        return refused("chambers", name, rule);
    }
    for (name, chamber) in given {
        let least = 1.01 * chamber.area * load.travel;
        if chamber.volume <= least {
            let rule = format!(
                "the volume at mid-stroke must be more than 1.01 times the product of area and travel, {least} m^3"
            );
            return refused_there(&format!("chambers.{name}.volume"), rule);
        }
    }
    let Some(a) = given.get("A") else {
        return refused("chambers", "", "chamber A is missing");
    };
    // A single-acting cylinder: whatever stands in for B does not move.
    let nothing = Chamber {
        area: 0.0,
        volume: 1.0,
    };
    Ok([*a, *given.get("B").unwrap_or(&nothing)])
}

/// The valves between levels and chambers.
fn edges(
    given: &BTreeMap<String, EdgeSection>,
    levels: &[Level],
    chambers: &[Chamber; 2],
    rated_drop: f64,
) -> Result<Vec<Edge>, Broken> {
    let mut edges: Vec<Edge> = Vec::new();
    for (name, edge) in given {
        let field = format!("edges.{name}");
        let (level, chamber) = ends(&field, name, levels, chambers)?;
        if edges
            .iter()
            .any(|other| (other.level, other.chamber) == (level, chamber))
        {
            let rule = "this level and this chamber are already connected";
            return refused(&field, name, rule);
        }
        edges.push(Edge {
            level,
            chamber,
            valves: edge.valves(&field, rated_drop)?,
        });
    }
    Ok(edges)
}

/// Level and chamber of an edge name: `P-A`, `B-T`.
fn ends(
    field: &str,
    name: &str,
    levels: &[Level],
    chambers: &[Chamber; 2],
) -> Result<(usize, usize), Broken> {
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
                    "an edge must be LEVEL-CHAMBER or CHAMBER-LEVEL, with the levels {} and the \
                     chambers given",
                    names.join(", ")
                ),
            )
        }
    }
}

impl EdgeSection {
    /// The flow coefficients of the valves.
    fn valves(&self, field: &str, drop: f64) -> Result<Vec<f64>, Broken> {
        match self {
            Self {
                coding: None,
                count: None,
                flow: None,
                flows: Some(flows),
            } => {
                if flows.len() > MOST_VALVES {
                    return refused(
                        &format!("{field}.flows"),
                        format!("{} valves", flows.len()),
                        format!("at most {MOST_VALVES} are allowed"),
                    );
                }
                Ok(flows.iter().map(|flow| flow.0 / drop.sqrt()).collect())
            }
            Self {
                coding: Some(coding),
                count: Some(count),
                flow: Some(total),
                flows: None,
            } => {
                let coding: Coding = named(coding)
                    .or_else(|rule| refused(&format!("{field}.coding"), coding, rule))?;
                if !(1..=MOST_VALVES).contains(count) {
                    let rule = format!("it must be from 1 to {MOST_VALVES}");
                    return refused(&format!("{field}.count"), count, rule);
                }
                Ok(coding.share(total / drop.sqrt(), *count))
            }
            _ => refused(
                field,
                "",
                "give `coding`, `count` and `flow` (all valves open), or `flows` of each valve, at the rated drop",
            ),
        }
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
                "chambers.A.volume: -0.3 L refused",
            ),
            (
                "bulk_modulus: 1.4 GPa",
                "bulk_modulus: 0 GPa",
                "oil.bulk_modulus: 0 GPa refused",
            ),
            (
                "count: 5",
                "count: 1000000",
                "count: 1000000 refused: it must be from 1 to 8",
            ),
            ("air: 0.005", "air: .nan", "oil.air: NaN refused"),
            (
                "mass: 120 kg",
                "mass: .inf kg",
                "load.mass: .inf kg refused",
            ),
            ("T: 0.3 MPa", "R: 0.3 MPa", "the tank T is missing"),
            (
                "T: 0.3 MPa",
                "T: 30 MPa",
                "supply.P: 10 MPa refused: no level may have a lower pressure than the tank T",
            ),
            ("P: 10 MPa", "P: 10 MPa\n  P: 1 MPa", "'P' occurs twice"),
            ("A-T:", "A-X:", "an edge must be LEVEL-CHAMBER"),
            ("law: model", "law: modle", "did you mean"),
            (
                "supply:",
                "lines: {P: {length: 0 m, diameter: 12 mm}}\nsupply:",
                "lines.P.length: 0 m refused: it must be from 0.001 to 10000 m",
            ),
            (
                "supply:",
                "lines: {P: {length: .nan m, diameter: 12 mm}}\nsupply:",
                "lines.P.length: .nan m refused",
            ),
            (
                "supply:",
                "lines: {P: {length: 5 mm, diameter: 12 mm}}\nsupply:",
                "lines.P.length: 5 mm refused: a pressure wave would take 3.94e-6 s from end to end",
            ),
            (
                "supply:",
                "lines: {T: {length: 9000 m, diameter: 12 mm}}\nsupply:",
                "lines.T.length: 9000 m refused: a pressure wave would take 7.09e0 s",
            ),
            (
                "supply:",
                "lines: {R: {length: 1 m, diameter: 12 mm}}\nsupply:",
                "a line must have the name of its supply level, one of P, T",
            ),
            (
                "oil:",
                "lines: {P: {length: 100 m, diameter: 3 mm}}\noil:\n  viscosity: 46 mm^2/s",
                "lines.P.diameter: 3 mm refused: the line's laminar resistance",
            ),
            (
                "oil:",
                "oil:\n  density: 0 kg/m^3",
                "oil.density: 0 kg/m^3 refused",
            ),
            (
                "rated_life: 1e8",
                "rated_life: -1",
                "valves.rated_life: -1 refused",
            ),
            (
                "\nvalves:",
                "\nseal_leakage: 1 m^3/s\nvalves:",
                "seal_leakage: 1 m^3/s refused: the leakage would fill the chamber",
            ),
            (
                "coulomb: 150 N",
                "coulomb: 150 N\n  elastic_stop: {stiffness: 1 N/m, damping: 0}",
                "load.elastic_stop.stiffness: 1 N/m refused",
            ),
            (
                "moment_arm: 0.25 m",
                "moment_arm: 0.15 m",
                "load.moment_arm: 0.15 m refused",
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
