//! A scenario file: duration, sampling time, seed, and parameters per node.
//!
//! The same file feeds the processes over DDS (as a ROS 2 parameter file) and the
//! in-process composition, through the same declarations and the same checks.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use planesman_parameters::{Declaration, Parameters, Value, Values, file};
use planesman_text::{did_you_mean, shown, yaml};
use planesman_units::{Dimension, Quantity};
use serde::{Deserialize, Serialize};

use crate::nodes::{self, NODES};

/// The parameters that name a file, or something built in.
const FILES: [(&str, &str); 8] = [
    ("plant_sim", "vehicle"),
    ("plant_sim", "vehicle_base"),
    ("depth_controller", "gains.file"),
    ("dha_actuator", "actuator"),
    ("dha_actuator", "bow.actuator"),
    ("dha_actuator", "stern.actuator"),
    ("dha_actuator", "roll.actuator"),
    ("dha_actuator", "rudder.actuator"),
];

/// The scenarios that come with the program: name and text.
pub const BUILTIN: [(&str, &str); 4] = [
    (
        "dive",
        include_str!("../launch-scripts/scenarios/dive.yaml"),
    ),
    (
        "open_loop",
        include_str!("../launch-scripts/scenarios/open_loop.yaml"),
    ),
    (
        "remus_100",
        include_str!("../launch-scripts/scenarios/remus_100.yaml"),
    ),
    (
        "way_depths",
        include_str!("../launch-scripts/scenarios/way_depths.yaml"),
    ),
];

/// A scenario file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a mapping with a description, a duration and parameters"
)]
pub struct Scenario {
    /// A description, one sentence.
    pub description: String,
    /// Duration, s of vehicle time.
    pub duration: f64,
    /// The sampling time of the loop, s.
    #[serde(default = "default_tick")]
    pub tick: f64,
    /// The seed of everything random.
    #[serde(default = "default_seed")]
    pub seed: u32,
    /// Parameters per node, as in a ROS 2 parameter file.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_yaml_ng::Value>,
    /// The text it was read from.
    #[serde(skip)]
    source: String,
}

fn default_tick() -> f64 {
    0.05
}

fn default_seed() -> u32 {
    1
}

/// A parameter of a node, as the command line names it: `NODE.PARAMETER`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterName {
    /// The node.
    pub node: String,
    /// The parameter, dots between levels.
    pub name: String,
}

impl ParameterName {
    /// The parameter and the text behind it, of `NODE.PARAMETER=TEXT`.
    ///
    /// # Errors
    /// When it is not of that form, or there is no such node.
    pub fn split(change: &str) -> Result<(Self, &str)> {
        let form = || anyhow!("NODE.PARAMETER=VALUE is expected");
        let (name, text) = change.split_once('=').ok_or_else(form)?;
        let (node, name) = name.split_once('.').ok_or_else(form)?;
        if !NODES.contains(&node) {
            bail!("there is no node '{node}'{}", did_you_mean(node, NODES));
        }
        let parameter = Self {
            node: node.to_owned(),
            name: name.to_owned(),
        };
        Ok((parameter, text))
    }

    /// Its declaration, if it is declared.
    #[must_use]
    pub fn declaration(&self) -> Option<Declaration> {
        let declared = nodes::declarations(&self.node)?.into_iter();
        declared.into_iter().find(|it| it.name == self.name)
    }

    /// A value as the command line writes it: as in a scenario, or a number with a unit of the parameter's dimension
    /// (`1ft/s`).
    ///
    /// # Errors
    /// When the text is not YAML.
    pub fn value(&self, text: &str) -> Result<serde_yaml_ng::Value> {
        let value: serde_yaml_ng::Value = yaml::from_str(text)?;
        let with_unit = || {
            let declaration = self.declaration()?;
            let dimension = Dimension::of_si_unit(declaration.unit)?;
            let Ok(quantity) = value.as_str()?.parse::<Quantity>();
            quantity.si(dimension).ok()
        };
        Ok(with_unit().map_or_else(|| value.clone(), Into::into))
    }
}

impl std::fmt::Display for ParameterName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.node, self.name)
    }
}

impl Scenario {
    /// Whether there is a built-in scenario of this name, or a file at this path.
    #[must_use]
    pub fn is_there(name_or_path: &str) -> bool {
        BUILTIN.iter().any(|(name, _)| *name == name_or_path) || Path::new(name_or_path).exists()
    }

    /// A built-in scenario by its name, or a scenario file by its path.
    ///
    /// # Errors
    /// When there is neither, the text is not a valid scenario, or a node would refuse its
    /// parameters; the message names the source, the value and the rule.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_with(name_or_path, &[])
    }

    /// As [`Scenario::load`], with parameters set as `NODE.PARAMETER=VALUE`.
    ///
    /// # Errors
    /// As [`Scenario::load`], and when a change is not of that form.
    pub fn load_with(name_or_path: &str, changes: &[String]) -> Result<Self> {
        let text = match BUILTIN.iter().find(|(name, _)| *name == name_or_path) {
            Some((_, text)) => (*text).to_owned(),
            None => read(Path::new(name_or_path))?,
        };
        let folder = Path::new(name_or_path).parent().unwrap_or(Path::new(""));
        Self::parse_with(
            &text,
            folder,
            changes,
            &format!("scenario '{name_or_path}'"),
        )
    }

    /// As [`Scenario::load_with`], from the YAML text of a scenario in `folder`; errors call it `name`.
    ///
    /// # Errors
    /// As [`Scenario::load_with`].
    pub fn parse_with(text: &str, folder: &Path, changes: &[String], name: &str) -> Result<Self> {
        let mut scenario = Self::parse(text).with_context(|| name.to_owned())?;
        scenario.find_files(folder)?;
        for change in changes {
            scenario
                .set(change)
                .with_context(|| format!("--set {change}"))?;
        }
        scenario.find_files(Path::new(""))?;
        scenario.check().with_context(|| name.to_owned())?;
        Ok(scenario)
    }

    /// The same with another duration (s), tick (s) or seed.
    ///
    /// # Errors
    /// A value that is refused; a node that refuses its parameters with it.
    pub fn timed(
        &self,
        duration: Option<f64>,
        tick: Option<f64>,
        seed: Option<u32>,
    ) -> Result<Self> {
        let changed = Self {
            duration: duration.unwrap_or(self.duration),
            tick: tick.unwrap_or(self.tick),
            seed: seed.unwrap_or(self.seed),
            ..self.clone()
        };
        let scenario = Self::parse(&serde_yaml_ng::to_string(&changed)?)?;
        scenario.check()?;
        Ok(scenario)
    }

    /// Sets a parameter as `NODE.PARAMETER=VALUE`; the description says so.
    fn set(&mut self, change: &str) -> Result<()> {
        let (parameter, value) = ParameterName::split(change)?;
        self.put(&parameter.node, &parameter.name, parameter.value(value)?)?;
        self.description = format!("{}; {change}", self.description);
        self.source = serde_yaml_ng::to_string(self)?;
        Ok(())
    }

    /// Sets a parameter, also in the text that is kept with the flight.
    fn put(&mut self, node: &str, parameter: &str, value: serde_yaml_ng::Value) -> Result<()> {
        self.enter(node, parameter, value)?;
        self.values(node)?;
        self.source = serde_yaml_ng::to_string(self)?;
        Ok(())
    }

    /// Sets a parameter, unchecked, for one flight of many: the text that is kept with a flight stays.
    ///
    /// # Errors
    /// When the scenario's section of the node is not a mapping.
    pub(crate) fn enter(
        &mut self,
        node: &str,
        parameter: &str,
        value: serde_yaml_ng::Value,
    ) -> Result<()> {
        let section = self
            .parameters
            .entry(node.to_owned())
            .or_insert_with(|| serde_yaml_ng::Mapping::new().into());
        // The last entry counts, also where the file has the parameter in a nested mapping.
        let entries = section
            .as_mapping_mut()
            .ok_or_else(|| anyhow!("the parameters of {node} are not a mapping"))?;
        entries.remove(parameter);
        entries.insert(parameter.into(), value);
        Ok(())
    }

    /// Makes the relative paths of files absolute: those in `folder`, where the scenario's file is, before those in the
    /// working directory. So they are also in the text that is kept with the flight.
    fn find_files(&mut self, folder: &Path) -> Result<()> {
        for (node, parameter) in FILES {
            let Some(Value::String(name)) = self.values(node)?.get(parameter).cloned() else {
                continue;
            };
            // A built-in name is no path.
            let is_relative = Path::new(&name).is_relative() && name.contains(['.', '/']);
            let places = [folder.join(&name), name.clone().into()];
            let found = places.iter().find(|place| place.is_file());
            if let (true, Some(place)) = (is_relative, found) {
                let path = std::path::absolute(place)?;
                self.put(node, parameter, path.display().to_string().into())?;
            }
        }
        Ok(())
    }

    /// Each node's own rule for its parameters, and the files they name.
    ///
    /// # Errors
    /// The refusal of the first node that would refuse.
    pub(crate) fn check(&self) -> Result<()> {
        for node in NODES {
            nodes::validate(node, &self.values(node)?)
                .map_err(|reason| anyhow!("node {node}: {reason}"))?;
        }
        Ok(())
    }

    /// A scenario from its YAML text.
    ///
    /// # Errors
    /// When the text is no scenario or a parameter breaks its declaration.
    pub fn parse(text: &str) -> Result<Self> {
        let mut scenario: Self = yaml::from_str(text)?;
        scenario.source = text.to_owned();
        for (name, value) in [("duration", scenario.duration), ("tick", scenario.tick)] {
            if !(value.is_finite() && value > 0.0) {
                bail!("{name}: {value} refused: it must be positive and finite, in s");
            }
        }
        if scenario.duration > 86_400.0 {
            bail!(
                "duration: {} refused: at most a day, 86400 s",
                scenario.duration
            );
        }
        for node in scenario.parameters.keys() {
            if !NODES.contains(&node.as_str()) {
                bail!(
                    "parameters: there is no node '{node}'{}; there are {}",
                    did_you_mean(node, NODES),
                    NODES.join(", ")
                );
            }
        }
        for node in NODES {
            scenario.values(node)?;
        }
        Ok(scenario)
    }

    /// The text it was read from.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The number of ticks flown.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        (self.duration / self.tick).round() as u64
    }

    /// The declared parameters of `node`, with this scenario's values.
    ///
    /// # Errors
    /// When a value breaks its declaration.
    pub fn values(&self, node: &str) -> Result<Values> {
        let Some(declarations) = nodes::declarations(node) else {
            bail!("there is no node '{node}'");
        };
        let mut changes: Vec<(String, Value)> = match node {
            "plant_sim" => vec![
                ("tick".to_owned(), self.tick.into()),
                ("duration".to_owned(), self.duration.into()),
                ("seed".to_owned(), i64::from(self.seed).into()),
            ],
            "dha_actuator" => vec![("tick".to_owned(), self.tick.into())],
            "sysid" => vec![("sample_time".to_owned(), self.tick.into())],
            _ => Vec::new(),
        };
        if let Some(section) = self.parameters.get(node) {
            changes.extend(file::flatten(section)?);
        }
        Values::defaults(declarations)
            .with(changes)
            .with_context(|| format!("node {node}"))
    }

    /// The parameters of `node` as the struct that it declares.
    ///
    /// # Errors
    /// When a value breaks its declaration, or the node declares another struct.
    pub fn parameters_of<P: Parameters>(&self, node: &str) -> Result<P> {
        Ok(P::from_values(&self.values(node)?)?)
    }

    /// All nodes' parameters as one ROS 2 parameter file for the namespace, with
    /// `extra` changes per node that only the launcher knows. With `sim_time`, whoever does not
    /// make `/clock` follows it.
    ///
    /// # Errors
    /// When a value breaks its declaration.
    pub fn parameter_file(
        &self,
        namespace: &str,
        extra: &[(&str, &str, Value)],
        sim_time: bool,
    ) -> Result<String> {
        let mut text = format!("# {}\n", shown(self.description.replace('\n', " ")));
        for node in NODES {
            let changes = extra
                .iter()
                .filter(|(n, _, _)| *n == node)
                .map(|(_, name, value)| ((*name).to_owned(), value.clone()));
            let values = self.values(node)?.with(changes)?;
            writeln!(text, "{namespace}/{node}:\n  ros__parameters:")?;
            if node != "plant_sim" {
                writeln!(text, "    use_sim_time: {sim_time}")?;
            }
            for declaration in values.declarations() {
                if let Some(value) = values.get(&declaration.name) {
                    writeln!(text, "    {}: {value}", declaration.name)?;
                }
            }
        }
        Ok(text)
    }
}

fn read(path: &Path) -> Result<String> {
    let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
    file::read(path).with_context(|| {
        format!(
            "no scenario '{}': a YAML file or one of: {}",
            path.display(),
            names.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use depth_controller::ControllerParameters;

    #[test]
    fn the_built_in_scenarios_are_valid() {
        for (name, _) in BUILTIN {
            Scenario::load(name).expect(name);
        }
    }

    #[test]
    fn a_bad_scenario_names_the_value_and_the_rule() {
        for (text, expected) in [
            ("{description: d, duration: -1}", "duration: -1"),
            ("{description: d, duration: .nan}", "duration: NaN"),
            ("{description: d, duration: 1, speed: 2}", "speed"),
            (
                "{description: d, duration: 1, parameters: {rudder: {}}}",
                "no node 'rudder'",
            ),
            (
                "{description: d, duration: 1, parameters: {plant_sim: {speed: fast}}}",
                "speed",
            ),
            (
                "{description: d, duration: 1, parameters: {depth_controller: {depth.p: .nan}}}",
                "finite",
            ),
        ] {
            let error = format!("{:#}", Scenario::parse(text).expect_err(text));
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn a_parameter_is_set_from_the_command_line_and_kept_in_the_text() {
        let set = |change: &str| Scenario::load_with("dive", &[change.to_owned()]);
        let changed = set("depth_controller.depth.p=1.5").expect("set");
        for scenario in [&changed, &Scenario::parse(changed.source()).expect("kept")] {
            let controller: ControllerParameters = scenario
                .parameters_of("depth_controller")
                .expect("declared");
            assert_eq!(controller.depth.p, 1.5);
            assert_eq!(scenario.duration, 90.0);
            assert!(
                scenario
                    .description
                    .ends_with("; depth_controller.depth.p=1.5")
            );
        }
        for (change, reason) in [
            ("depth_controller.depth.p", "NODE.PARAMETER=VALUE"),
            ("depth_control.depth.p=1", "did you mean 'depth_controller'"),
            ("depth_controller.depht.p=1", "did you mean 'depth.p'"),
            ("depth_controller.depth.p=-1", "[0, 1000]"),
        ] {
            let refusal = format!("{:#}", set(change).expect_err(change));
            assert!(refusal.contains(reason), "{refusal}");
        }
    }

    #[test]
    fn a_file_is_looked_for_beside_the_scenario_and_kept_by_its_absolute_path() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(&path, text).expect("written");
            path.display().to_string()
        };
        let vehicle = include_str!("../crates/vehicle/vehicles/brunner.yaml");
        let beside = write("vehicles/own.yaml", vehicle);
        let text =
            "{description: d, duration: 1, parameters: {plant_sim: {vehicle: vehicles/own.yaml}}}";
        let scenario = Scenario::load(&write("flight.yaml", text)).expect("found");
        for scenario in [
            &scenario,
            &Scenario::parse(scenario.source()).expect("kept"),
        ] {
            let vehicle = scenario.values("plant_sim").expect("values");
            assert_eq!(vehicle.get("vehicle"), Some(&Value::String(beside.clone())));
            let actuator = scenario.values("dha_actuator").expect("values");
            assert_eq!(
                actuator.get("actuator"),
                Some(&Value::String("auv".to_owned()))
            );
        }
        // From the working directory, where it is not beside the scenario.
        let text = text.replace("vehicles/own.yaml", "crates/vehicle/vehicles/brunner.yaml");
        let scenario = Scenario::load(&write("other.yaml", &text)).expect("found");
        let here = std::path::absolute("crates/vehicle/vehicles/brunner.yaml").expect("a path");
        let vehicle = scenario.values("plant_sim").expect("values");
        assert_eq!(
            vehicle.get("vehicle"),
            Some(&Value::String(here.display().to_string()))
        );
    }

    #[test]
    fn the_parameter_file_reads_back_to_the_same_values() {
        let scenario = Scenario::load("dive").expect("scenario");
        let text = scenario
            .parameter_file("/auv", &[], false)
            .expect("written");
        for node in NODES {
            let read = file::overrides_for(&text, &format!("/auv/{node}")).expect("read");
            let values = scenario.values(node).expect("values");
            let declared = read.into_iter().filter(|(name, _)| name != "use_sim_time");
            assert_eq!(values.with(declared).expect("valid"), values);
        }
    }

    #[test]
    fn no_text_breaks_the_parameter_file_or_adds_to_it() {
        let scenario = Scenario::parse(
            r#"{description: "\e[31m\a\n/auv/sysid: 1\r/auv/sysid: 2\N/auv/sysid: 3\L\uFEFF\uFFFF", duration: 1}"#,
        )
        .expect("a scenario");
        let output =
            "\u{1b} \u{ad}e\u{301}\u{200b}\u{feff}\u{ffff}\u{1f980}\t\r\n\u{85}\u{2028}\"'\\ü";
        for value in [Value::from(output), Value::from(&[output, "b"][..])] {
            let name = match value {
                Value::String(_) => "output",
                _ => "topics",
            };
            let text = scenario
                .parameter_file("/auv", &[("recorder", name, value.clone())], false)
                .expect("written");
            let read = file::overrides_for(&text, "/auv/recorder").expect("read");
            assert!(read.contains(&(name.to_owned(), value)), "{text}");
        }
    }
}
