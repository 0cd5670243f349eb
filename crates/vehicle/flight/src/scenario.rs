//! Scenario files: duration, sampling time, seed, and parameters per node.
//!
//! The same file serves the processes over DDS (as a ROS 2 parameter file) and the loop in one process, with the same declarations and
//! checks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::error::{During, Error, Result, refuse, refused};
use planesman_control::ControllerParameters;
use planesman_parameters::{Declaration, Parameters, Value, Values, file, probably_meant};
use planesman_plant::{PlantParameters, VehicleModel};
use planesman_text::{did_you_mean, setting, shown, yaml};
use planesman_units::{Dimension, Quantity};
use serde::Deserialize;

use crate::nodes::{self, NODES};

/// Built-in scenarios: name and text.
pub const BUILTIN: &[(&str, &str)] = &[
    (
        "bluerov2",
        include_str!("../../../../launch-scripts/scenarios/bluerov2.yaml"),
    ),
    (
        "dive",
        include_str!("../../../../launch-scripts/scenarios/dive.yaml"),
    ),
    (
        "lauv",
        include_str!("../../../../launch-scripts/scenarios/lauv.yaml"),
    ),
    (
        "open_loop",
        include_str!("../../../../launch-scripts/scenarios/open_loop.yaml"),
    ),
    (
        "remus_100",
        include_str!("../../../../launch-scripts/scenarios/remus_100.yaml"),
    ),
    (
        "turning_circle",
        include_str!("../../../../launch-scripts/scenarios/turning_circle.yaml"),
    ),
    (
        "way_depths",
        include_str!("../../../../launch-scripts/scenarios/way_depths.yaml"),
    ),
    (
        "zigzag",
        include_str!("../../../../launch-scripts/scenarios/zigzag.yaml"),
    ),
];

/// The names of the built-in scenarios.
#[must_use]
pub fn builtin_names() -> Vec<&'static str> {
    BUILTIN.iter().map(|(name, _)| *name).collect()
}

/// A scenario: duration, sampling time, seed, and the parameters that differ from their defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    description: String,
    /// Duration, s of simulated time.
    pub duration: f64,
    /// Sampling time of the loop, s.
    pub tick: f64,
    /// Seed of all random numbers.
    pub seed: u32,
    /// For each node the given parameters, by full name, in their declared types.
    parameters: BTreeMap<&'static str, BTreeMap<String, Value>>,
    /// Parameters that were set after the file was written, each once.
    changed: Vec<ParameterName>,
}

/// Content of a scenario file.
#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a mapping with a description, a duration and parameters"
)]
struct ScenarioFile {
    description: String,
    duration: f64,
    #[serde(default = "default_tick")]
    tick: f64,
    #[serde(default = "default_seed")]
    seed: u32,
    #[serde(default)]
    parameters: BTreeMap<String, serde_yaml_ng::Value>,
    /// `NODE.PARAMETER`, as [`Scenario::changed`].
    #[serde(default)]
    changed: Vec<String>,
}

fn default_tick() -> f64 {
    0.05
}

fn default_seed() -> u32 {
    1
}

/// A parameter of a node, as on the command line: `NODE.PARAMETER`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterName {
    /// The node.
    pub node: &'static str,
    /// Name of the parameter, with dots between groups.
    pub name: String,
}

impl ParameterName {
    /// Splits `NODE.PARAMETER=TEXT` into the parameter and the text.
    ///
    /// # Errors
    /// If the form is wrong or no such node exists.
    pub fn split(change: &str) -> Result<(Self, &str)> {
        let (name, text) = change
            .split_once('=')
            .filter(|(name, _)| name.contains('.'))
            .ok_or_else(|| refused!("refused; NODE.PARAMETER=VALUE is expected"))?;
        Ok((name.parse()?, text))
    }

    /// Its declaration.
    ///
    /// # Errors
    /// If the node declares no such parameter.
    pub fn declaration(&self) -> Result<Declaration> {
        let declared = nodes::declarations(self.node).unwrap_or_default();
        if let Some(declaration) = declared.iter().find(|it| it.name == self.name) {
            return Ok(declaration.clone());
        }
        let meant = probably_meant(&self.name, &declared);
        refuse!("{} has no parameter '{}'{meant}", self.node, self.name)
    }

    /// Parses a value from the command line: as in a scenario, or a number with a unit of the parameter's dimension (`1ft/s`).
    ///
    /// # Errors
    /// If the text is not a YAML value of a ROS type, or the parameter's declaration refuses it.
    pub fn value(&self, text: &str) -> Result<Value> {
        let declaration = self.declaration()?;
        let value = file::parse_value(&self.name, text)?;
        let value = match (&value, Dimension::of_si_unit(declaration.unit)) {
            (Value::String(text), Some(dimension)) => {
                let Ok(quantity) = text.parse::<Quantity>();
                let symbols: Vec<&str> = dimension.units().iter().map(|it| it.symbol).collect();
                let units = symbols.join(", ");
                Value::Double(quantity.argument(dimension).map_err(|_| {
                    let rule =
                        format!("give a number in {}, or a number with its unit", symbols[0]);
                    refused!("'{text}' refused: {rule}: {units}")
                })?)
            }
            _ => value,
        };
        Ok(declaration.accept(value)?)
    }
}

impl FromStr for ParameterName {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (node, name) = text
            .split_once('.')
            .ok_or_else(|| refused!("'{text}' refused; NODE.PARAMETER is expected"))?;
        Ok(Self {
            node: known_node(node)?,
            name: name.to_owned(),
        })
    }
}

/// Name of a known node.
fn known_node(name: &str) -> Result<&'static str> {
    let known = NODES.into_iter().find(|it| *it == name);
    known.ok_or_else(|| {
        refused!(
            "unknown node '{name}'; known: {}{}",
            NODES.join(", "),
            did_you_mean(name, NODES)
        )
    })
}

impl std::fmt::Display for ParameterName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.node, self.name)
    }
}

impl Scenario {
    /// Whether this is the name of a built-in scenario, or the path of a file.
    #[must_use]
    pub fn is_there(name_or_path: &str) -> bool {
        BUILTIN.iter().any(|(name, _)| *name == name_or_path)
            || Path::new(name_or_path).exists()
            || installed(name_or_path).is_some()
    }

    /// Loads a built-in scenario by name, a scenario file by path, or a scenario of the installed ROS package by name.
    ///
    /// # Errors
    /// If there is no such scenario, its text is invalid, or a node would refuse its parameters; the message gives source, value and rule.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_with(name_or_path, &[])
    }

    /// Like [`Scenario::load`], with parameters set as `NODE.PARAMETER=VALUE`.
    ///
    /// # Errors
    /// Same as [`Scenario::load`], and if a change has a wrong form.
    pub fn load_with(name_or_path: &str, changes: &[String]) -> Result<Self> {
        let mut path = PathBuf::from(name_or_path);
        let text = match BUILTIN.iter().find(|(name, _)| *name == name_or_path) {
            Some((_, text)) => (*text).to_owned(),
            None => {
                if let Some(installed) = installed(name_or_path).filter(|_| !path.exists()) {
                    path = installed;
                }
                read(&path)?
            }
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse_with(
            &text,
            folder,
            changes,
            &format!("scenario '{name_or_path}'"),
        )
    }

    /// Like [`Scenario::load_with`], from the YAML text of a scenario in `folder`; errors call the scenario `name`.
    ///
    /// # Errors
    /// Same as [`Scenario::load_with`].
    pub fn parse_with(text: &str, folder: &Path, changes: &[String], name: &str) -> Result<Self> {
        let mut scenario = Self::parse(text).during(|| name.to_owned())?;
        scenario.find_files(folder)?;
        for change in changes {
            scenario
                .set(change)
                .during(|| setting("set", change).to_string())?;
        }
        scenario.find_files(Path::new(""))?;
        let checked = scenario.hover_what_flies().and_then(|()| scenario.check());
        checked.during(|| name.to_owned())?;
        Ok(scenario)
    }

    /// Sets `hover.vehicle` of the controller to the simulated vehicle if it has thrusters, unless the scenario sets it.
    ///
    /// # Errors
    /// If the simulated vehicle cannot be loaded. Otherwise the controller's check would refuse the missing `hover.vehicle`.
    fn hover_what_flies(&mut self) -> Result<()> {
        let plant: PlantParameters = self.parameters_of("plant_sim")?;
        let is_given = self.given("depth_controller", "hover.vehicle").is_some();
        let craft =
            VehicleModel::load(&plant).map_err(|reason| refused!("plant_sim.vehicle: {reason}"))?;
        if !is_given && !craft.thrusters().is_empty() {
            let given = self.parameters.entry("depth_controller").or_default();
            given.insert("hover.vehicle".to_owned(), plant.vehicle.as_str().into());
        }
        Ok(())
    }

    /// Returns the scenario with another duration (s), tick (s) or seed.
    ///
    /// # Errors
    /// If a value is refused, by the scenario or by a node.
    pub fn timed(
        &self,
        duration: Option<f64>,
        tick: Option<f64>,
        seed: Option<u32>,
    ) -> Result<Self> {
        let scenario = Self {
            duration: duration.unwrap_or(self.duration),
            tick: tick.unwrap_or(self.tick),
            seed: seed.unwrap_or(self.seed),
            ..self.clone()
        };
        scenario.check()?;
        Ok(scenario)
    }

    /// Sets a parameter as `NODE.PARAMETER=VALUE`; the description mentions it.
    fn set(&mut self, change: &str) -> Result<()> {
        let (parameter, text) = ParameterName::split(change)?;
        let value = parameter.value(text)?;
        self.put(&parameter, value)?;
        self.changed.retain(|other| *other != parameter);
        self.changed.push(parameter);
        Ok(())
    }

    /// Sets a parameter to a value. The plant's duration and seed, and the ticks of all nodes, belong to the scenario itself.
    ///
    /// # Errors
    /// If the parameter is not declared, or its declaration refuses the value.
    pub fn put(&mut self, parameter: &ParameterName, value: Value) -> Result<()> {
        let ParameterName { node, name } = parameter;
        let value = parameter.declaration()?.accept(value)?;
        match (*node, name.as_str(), &value) {
            ("plant_sim", "duration", Value::Double(duration)) => self.duration = *duration,
            ("plant_sim" | "dha_actuator", "tick", Value::Double(tick)) => self.tick = *tick,
            ("plant_sim", "seed", Value::Integer(seed)) => {
                self.seed = u32::try_from(*seed).map_err(|it| refused!("{it}"))?
            }
            _ => {
                let given = self.parameters.entry(node).or_default();
                given.insert(name.clone(), value);
            }
        }
        Ok(())
    }

    /// The value in the scenario; `None` if the declared default applies.
    pub fn given(&self, node: &str, name: &str) -> Option<&Value> {
        self.parameters.get(node)?.get(name)
    }

    /// Whether a parameter was set after the file was written.
    pub fn is_changed(&self, parameter: &ParameterName) -> bool {
        self.changed.contains(parameter)
    }

    /// Makes relative file paths absolute; the scenario file's `folder` comes before the working directory. The text stored with the flight
    /// therefore contains absolute paths.
    fn find_files(&mut self, folder: &Path) -> Result<()> {
        for (node, parameter) in nodes::files() {
            let Some(Value::String(name)) = self.given(node, parameter).cloned() else {
                continue;
            };
            // A built-in name is no path.
            let is_relative = Path::new(&name).is_relative() && name.contains(['.', '/']);
            let places = [folder.join(&name), name.clone().into()];
            let existing = places.iter().find(|place| place.is_file());
            if let (true, Some(place)) = (is_relative, existing) {
                let path = std::path::absolute(place)?;
                let parameter = ParameterName {
                    node,
                    name: parameter.to_owned(),
                };
                self.put(&parameter, Value::String(path.display().to_string()))?;
            }
        }
        Ok(())
    }

    /// Checks duration and tick, each node's parameters, and the files they name.
    ///
    /// # Errors
    /// The first refusal.
    pub fn check(&self) -> Result<()> {
        self.check_times()?;
        for node in NODES {
            nodes::validate(node, &self.values(node)?)
                .map_err(|reason| refused!("node {node}: {reason}"))?;
        }
        self.check_thrusters()
    }

    /// Checks that the controller commands the vehicle's own thrusters: over DDS no node would listen to others.
    fn check_thrusters(&self) -> Result<()> {
        let plant: PlantParameters = self.parameters_of("plant_sim")?;
        let controller: ControllerParameters = self.parameters_of("depth_controller")?;
        let (flown, hovers) = (&plant.vehicle, &controller.hover.vehicle);
        if hovers.is_empty() {
            let craft = VehicleModel::load(&plant).map_err(|reason| refused!("{reason}"))?;
            if !craft.thrusters().is_empty() {
                refuse!(
                    "plant_sim's vehicle '{flown}' has thrusters, which depth_controller must command. Set depth_controller.hover.vehicle={flown}"
                );
            }
            return Ok(());
        }
        if hovers == flown {
            return Ok(());
        }
        let commanded = PlantParameters {
            vehicle: hovers.clone(),
            ..plant.clone()
        };
        let names = |parameters: &PlantParameters| -> Result<Vec<String>> {
            let craft = VehicleModel::load(parameters).map_err(|reason| refused!("{reason}"))?;
            Ok(craft.thrusters().to_vec())
        };
        let (has, commanded) = (names(&plant)?, names(&commanded)?);
        if let Some(name) = commanded.iter().find(|name| !has.contains(name)) {
            refuse!(
                "depth_controller's hover.vehicle: '{hovers}' refused: vehicle '{flown}' of plant_sim has no thruster '{name}'"
            );
        }
        Ok(())
    }

    fn check_times(&self) -> Result<()> {
        for (name, value) in [("duration", self.duration), ("tick", self.tick)] {
            if !(value.is_finite() && value > 0.0) {
                refuse!("{name}: {value} refused: it must be positive and finite, in s");
            }
        }
        if self.duration > 86_400.0 {
            refuse!(
                "duration: {} refused: the limit is one day, 86400 s",
                self.duration
            );
        }
        Ok(())
    }

    /// Parses a scenario from YAML text.
    ///
    /// # Errors
    /// If the text is not a scenario, gives a parameter twice, or violates a parameter's declaration.
    pub fn parse(text: &str) -> Result<Self> {
        let file: ScenarioFile = yaml::from_str(text)?;
        let mut scenario = Self {
            description: file.description,
            duration: file.duration,
            tick: file.tick,
            seed: file.seed,
            parameters: BTreeMap::new(),
            changed: Vec::new(),
        };
        scenario.check_times()?;
        for (node, section) in &file.parameters {
            let node = known_node(node).during(|| "parameters")?;
            scenario
                .take(node, section)
                .during(|| format!("node {node}"))?;
        }
        for node in NODES {
            scenario.values(node)?;
        }
        let changed = file.changed.iter().map(|it| it.parse());
        scenario.changed = changed.collect::<Result<_>>().during(|| "changed")?;
        Ok(scenario)
    }

    /// Reads the parameters that a file gives for `node`, nested or by full names.
    fn take(&mut self, node: &'static str, section: &serde_yaml_ng::Value) -> Result<()> {
        let mut there = BTreeSet::new();
        for (name, value) in file::flatten(section)? {
            if !there.insert(name.clone()) {
                refuse!("parameter '{name}' is given twice");
            }
            let own = (self.duration, self.tick, self.seed);
            self.put(
                &ParameterName {
                    node,
                    name: name.clone(),
                },
                value,
            )?;
            if own != (self.duration, self.tick, self.seed) {
                refuse!("parameter '{name}' refused: set it by the scenario's own entry '{name}'");
            }
        }
        Ok(())
    }

    /// Description of the file, and the changes since.
    #[must_use]
    pub fn description(&self) -> String {
        let mut text = self.description.clone();
        for parameter in &self.changed {
            let Ok((value, unit)) = self.value_of(parameter) else {
                continue;
            };
            let unit = if unit.is_empty() {
                ""
            } else {
                &format!(" {unit}")
            };
            text += &format!("; {parameter}={}{unit}", plain(&value));
        }
        text
    }

    /// Value of a parameter, with its unit.
    fn value_of(&self, parameter: &ParameterName) -> Result<(Value, &'static str)> {
        let values = self.values(parameter.node)?;
        let value = values.get(&parameter.name).cloned();
        Ok((
            value.ok_or_else(|| refused!("{parameter} is not declared"))?,
            parameter.declaration()?.unit,
        ))
    }

    /// The scenario as the text of a file: all given values, without defaults.
    #[must_use]
    pub fn to_yaml(&self) -> String {
        let mut text = format!(
            "description: {}\nduration: {}\ntick: {}\nseed: {}\n",
            Value::from(self.description.as_str()),
            Value::Double(self.duration),
            Value::Double(self.tick),
            self.seed
        );
        if !self.changed.is_empty() {
            text += "changed: # parameters changed after the file was written\n";
        }
        for parameter in &self.changed {
            text += &format!("  - {parameter}\n");
        }
        if !self.parameters.is_empty() {
            text += "parameters:\n";
        }
        for (node, given) in &self.parameters {
            text += &format!("  {node}:\n");
            for (name, value) in given {
                text += &format!("    {name}: {value}\n");
            }
        }
        text
    }

    /// Number of ticks.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        (self.duration / self.tick).round() as u64
    }

    /// Sampling time, ns.
    #[must_use]
    pub fn tick_nanos(&self) -> i64 {
        (self.tick * 1e9).round() as i64
    }

    /// Declared parameters of `node`, with this scenario's values.
    ///
    /// # Errors
    /// If a value violates its declaration.
    pub fn values(&self, node: &str) -> Result<Values> {
        let Some(declarations) = nodes::declarations(node) else {
            refuse!("unknown node '{node}'");
        };
        let own: Vec<(&str, Value)> = match node {
            "plant_sim" => vec![
                ("tick", self.tick.into()),
                ("duration", self.duration.into()),
                ("seed", i64::from(self.seed).into()),
            ],
            "dha_actuator" => vec![("tick", self.tick.into())],
            "sysid" => vec![("sample_time", self.tick.into())],
            _ => Vec::new(),
        };
        let own = own
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value));
        let given = self.parameters.get(node).cloned().unwrap_or_default();
        Values::defaults(declarations)
            .with(own.chain(given))
            .during(|| format!("node {node}"))
    }

    /// Parameters of `node` in the struct that it declares.
    ///
    /// # Errors
    /// If a value violates its declaration, or the node declares another struct.
    pub fn parameters_of<P: Parameters>(&self, node: &str) -> Result<P> {
        Ok(P::from_values(&self.values(node)?)?)
    }

    /// Like [`Scenario::values`], with `extra` changes per node by the launcher.
    ///
    /// # Errors
    /// If a value violates its declaration.
    pub fn launched_values(&self, node: &str, extra: &[(&str, &str, Value)]) -> Result<Values> {
        let changes = extra
            .iter()
            .filter(|(n, _, _)| *n == node)
            .map(|(_, name, value)| ((*name).to_owned(), value.clone()));
        Ok(self.values(node)?.with(changes)?)
    }

    /// Parameters of all nodes as one ROS 2 parameter file for the namespace, with `extra` changes per node by the launcher. With
    /// `sim_time`, all nodes except the source of `/clock` follow it.
    ///
    /// # Errors
    /// If a value violates its declaration.
    pub fn parameter_file(
        &self,
        namespace: &str,
        extra: &[(&str, &str, Value)],
        sim_time: bool,
    ) -> Result<String> {
        let mut text = format!("# {}\n", shown(self.description().replace('\n', " ")));
        for node in NODES {
            let values = self.launched_values(node, extra)?;
            text += &format!("{namespace}/{node}:\n  ros__parameters:\n");
            if node != "plant_sim" {
                text += &format!("    use_sim_time: {sim_time}\n");
            }
            for declaration in values.declarations() {
                if let Some(value) = values.get(&declaration.name) {
                    text += &format!("    {}: {value}\n", declaration.name);
                }
            }
        }
        Ok(text)
    }
}

/// A value for a cell or label: words without quotes, numbers with the shortest exact digits.
pub fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => shown(text).to_string(),
        Value::Double(number) => number.to_string(),
        other => other.to_string(),
    }
}

/// First parameter that differs from its expected value, with both values.
pub fn difference(values: &Values, actual: impl Fn(&str) -> Option<Value>) -> Option<String> {
    values.declarations().iter().find_map(|declaration| {
        let name = &declaration.name;
        let (right, actual) = (values.get(name)?, actual(name));
        let shown = |it: &Value| it.to_string();
        (actual.as_ref() != Some(right)).then(|| {
            let actual = actual.as_ref().map_or("not set".to_owned(), shown);
            format!("{name} is {actual}, not {right}")
        })
    })
}

/// File of a scenario that is installed with the ROS package, by its bare name.
fn installed(name: &str) -> Option<PathBuf> {
    let is_bare = !name.is_empty() && !name.contains(['.', '/']);
    let mut files = installed_folders().map(|folder| folder.join(format!("{name}.yaml")));
    files.find(|file| is_bare && file.is_file())
}

/// Folders with the scenarios of this project's installed ROS packages.
fn installed_folders() -> impl Iterator<Item = PathBuf> {
    let prefixes = std::env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
    let prefixes: Vec<PathBuf> = std::env::split_paths(&prefixes).collect();
    let prefixes = prefixes
        .into_iter()
        .filter(|prefix| !prefix.as_os_str().is_empty());
    prefixes.map(|prefix| prefix.join("share/planesman/scenarios"))
}

/// Names of the built-in and the installed scenarios.
fn known_names() -> BTreeSet<String> {
    let files = installed_folders().filter_map(|folder| folder.read_dir().ok());
    let files = files.flatten().flatten().map(|entry| entry.path());
    let files = files.filter(|file| file.extension().is_some_and(|it| it == "yaml"));
    let stems = files.filter_map(|file| Some(file.file_stem()?.to_str()?.to_owned()));
    let built_in = builtin_names().into_iter().map(str::to_owned);
    stems.chain(built_in).collect()
}

fn read(path: &Path) -> Result<String> {
    let names: Vec<String> = known_names().into_iter().collect();
    let meant = did_you_mean(&path.to_string_lossy(), names.iter().map(String::as_str));
    if !path.exists() {
        refuse!(
            "unknown scenario '{}'; give a YAML file or one of {}{meant}",
            path.display(),
            names.join(", ")
        );
    }
    file::read(path).during(|| format!("scenario '{}'", path.display()))
}

#[cfg(test)]
mod tests {
    use planesman_text::in_one_line;

    use super::*;

    #[test]
    fn the_built_in_scenarios_are_valid() {
        for (name, _) in BUILTIN {
            Scenario::load(name).expect(name);
        }
    }

    #[test]
    fn thrusters_of_another_vehicle_are_refused() {
        let mut scenario = Scenario::load("bluerov2").unwrap();
        let vehicle = "plant_sim.vehicle".parse().unwrap();
        scenario.put(&vehicle, Value::from("lauv")).unwrap();
        let refusal = scenario.check().unwrap_err().to_string();
        assert!(
            refusal.contains("vehicle 'lauv' of plant_sim has no thruster"),
            "{refusal}"
        );
    }

    #[test]
    fn a_bad_scenario_names_the_value_and_the_rule() {
        for (text, expected) in [
            ("{description: d, duration: -1}", "duration: -1"),
            ("{description: d, duration: .nan}", "duration: NaN"),
            ("{description: d, duration: 1, speed: 2}", "speed"),
            (
                "{description: d, duration: 1, parameters: {rudder: {}}}",
                "unknown node 'rudder'",
            ),
            (
                "{description: d, duration: 1, parameters: {plant_sim: {speed: fast}}}",
                "speed",
            ),
            (
                "{description: d, duration: 1, parameters: {depth_controller: {depth.p: .nan}}}",
                "finite",
            ),
            (
                "{description: d, duration: 1, parameters: {depth_controller: {depth.p: 1, depth: {p: 2}}}}",
                "'depth.p' is given twice",
            ),
            (
                "{description: d, duration: 1, parameters: {plant_sim: {seed: 2}}}",
                "the scenario's own entry 'seed'",
            ),
        ] {
            let error = in_one_line(&Scenario::parse(text).expect_err(text));
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn a_parameter_is_set_from_the_command_line_and_kept_in_the_text() {
        let set = |change: &str| Scenario::load_with("dive", &[change.to_owned()]);
        let changed = set("depth_controller.depth.p=1.5").expect("set");
        for scenario in [
            &changed,
            &Scenario::parse(&changed.to_yaml()).expect("kept"),
        ] {
            let controller: ControllerParameters = scenario
                .parameters_of("depth_controller")
                .expect("declared");
            assert_eq!(controller.depth.p, 1.5);
            assert_eq!(scenario.duration, 90.0);
            let description = scenario.description();
            assert!(description.ends_with("; depth_controller.depth.p=1.5 rad/m"));
        }
        for (change, reason) in [
            ("depth_controller.depth.p", "NODE.PARAMETER=VALUE"),
            ("depth_control.depth.p=1", "did you mean 'depth_controller'"),
            ("depth_controller.depht.p=1", "did you mean 'depth.p'"),
            (
                "depth_controller.course.p=1",
                "the parameter is now called 'heading.p'",
            ),
            ("depth_controller.depth.p=-1", "[0, 1000]"),
        ] {
            let refusal = in_one_line(&set(change).expect_err(change));
            assert!(refusal.contains(reason), "{refusal}");
        }
    }

    /// A value of the parameter other than that, where its declaration has one that needs no file.
    fn another(declaration: &Declaration, than: &Value) -> Option<Value> {
        let texts = declaration.choices.iter();
        let candidates: Vec<Value> = match than {
            Value::Bool(value) => vec![Value::Bool(!value)],
            Value::Integer(value) => vec![Value::Integer(value + 1), Value::Integer(value - 1)],
            Value::Double(value) => [value * 0.75, value + 0.5, value - 0.5]
                .map(Value::Double)
                .into(),
            Value::String(_) => texts.map(|text| Value::from(&**text)).collect(),
            Value::DoubleArray(list) => {
                vec![Value::DoubleArray([list.as_slice(), &[1.0]].concat())]
            }
            Value::StringArray(_) => [["one"], ["other"]].map(|it| it.as_slice().into()).into(),
            _ => Vec::new(),
        };
        let accepted = candidates.into_iter();
        let mut accepted = accepted.filter_map(|value| declaration.accept(value).ok());
        accepted.find(|value| value != than)
    }

    /// Every parameter of every node, with two values other than the scenario's.
    fn settings(scenario: &Scenario) -> Vec<(ParameterName, [Value; 2])> {
        let mut settings = Vec::new();
        for node in NODES {
            let values = scenario.values(node).expect("values");
            for declaration in values.declarations() {
                let has = values.get(&declaration.name).expect("declared");
                let Some(first) = another(declaration, has) else {
                    continue;
                };
                let second = another(declaration, &first).expect("as many");
                let name = declaration.name.clone();
                // The tick of the loop, which plant_sim.tick is already.
                if (node, name.as_str()) != ("dha_actuator", "tick") {
                    settings.push((ParameterName { node, name }, [first, second]));
                }
            }
        }
        settings
    }

    /// Puts each value, as `--set` does, and finds the last one of each parameter: in the values that the nodes are given, in the
    /// text that is kept, and in the description.
    fn last_values_hold(scenario: &Scenario, puts: &[(&ParameterName, &Value)]) {
        let mut scenario = scenario.clone();
        let mut last: Vec<(&ParameterName, &Value)> = Vec::new();
        for (parameter, value) in puts {
            let change = format!("{parameter}={value}");
            scenario.set(&change).expect(&change);
            last.retain(|it| it.0 != *parameter);
            last.push((parameter, value));
        }
        let kept = Scenario::parse(&scenario.to_yaml()).expect("kept");
        assert_eq!(kept, scenario);
        let description = scenario.description();
        for (parameter, value) in last {
            let values = kept.values(parameter.node).expect("values");
            assert_eq!(values.get(&parameter.name), Some(value), "{puts:?}");
            let told = format!("; {parameter}={}", plain(value));
            assert_eq!(description.matches(&told).count(), 1, "{description}");
        }
    }

    #[test]
    fn of_any_settings_in_any_order_the_last_value_of_each_parameter_holds() {
        use proptest::prelude::*;
        for (name, _) in BUILTIN {
            let scenario = Scenario::load(name).expect(name);
            let settings = settings(&scenario);
            assert!(settings.len() > 200, "{}", settings.len());
            let setting = || (0..settings.len(), 0..2_usize);
            let config = ProptestConfig {
                cases: 300,
                failure_persistence: None,
                rng_seed: proptest::test_runner::RngSeed::Fixed(31),
                ..ProptestConfig::default()
            };
            let mut runner = proptest::test_runner::TestRunner::new(config);
            let triples = [setting(), setting(), setting()];
            let outcome = runner.run(&triples, |chosen| {
                let puts = chosen.map(|(place, which)| {
                    let (parameter, values) = &settings[place];
                    (parameter, &values[which])
                });
                last_values_hold(&scenario, &puts);
                Ok(())
            });
            outcome.expect(name);
        }
    }

    /// The parameters that a scenario gives are those that once were nested in its file.
    #[test]
    fn every_pair_of_a_parameter_that_a_scenario_gives_and_any_other_holds_in_both_orders() {
        for (name, _) in BUILTIN {
            let scenario = Scenario::load(name).expect(name);
            let settings = settings(&scenario);
            let mut pairs = 0;
            for (given, [value, _]) in &settings {
                if scenario.given(given.node, &given.name).is_none() {
                    continue;
                }
                for (other, [first, _]) in settings.iter().filter(|it| it.0 != *given) {
                    let puts = [(given, value), (other, first)];
                    for order in [[0, 1], [1, 0]] {
                        let mut scenario = scenario.clone();
                        for (parameter, value) in order.map(|place| puts[place]) {
                            scenario.put(parameter, value.clone()).expect("declared");
                        }
                        for (parameter, value) in puts {
                            let values = scenario.values(parameter.node).expect("values");
                            assert_eq!(values.get(&parameter.name), Some(value), "{puts:?}");
                        }
                        pairs += 1;
                    }
                }
            }
            assert!(pairs > 1000, "{pairs}");
        }
    }

    #[test]
    fn the_parameter_file_gives_each_node_what_is_flown() {
        let extra = [("plant_sim", "time", Value::from("lockstep"))];
        for (name, _) in BUILTIN {
            let scenario = Scenario::load(name).expect(name);
            let text = scenario.parameter_file("/auv", &extra, true).expect(name);
            for node in NODES {
                let flown = scenario.launched_values(node, &extra).expect(name);
                let in_file = file::overrides_for(&text, &format!("/auv/{node}")).expect(name);
                let in_file = in_file.into_iter().filter(|it| it.0 != "use_sim_time");
                let in_file = Values::defaults(flown.declarations().to_vec()).with(in_file);
                let in_file = in_file.expect(name);
                let difference = difference(&flown, |name| in_file.get(name).cloned());
                assert_eq!(difference, None, "{name}, {node}");
            }
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
        let vehicle = include_str!("../../vehicle/vehicles/brunner.yaml");
        let beside = write("vehicles/own.yaml", vehicle);
        let text =
            "{description: d, duration: 1, parameters: {plant_sim: {vehicle: vehicles/own.yaml}}}";
        let scenario = Scenario::load(&write("flight.yaml", text)).expect("found");
        for scenario in [
            &scenario,
            &Scenario::parse(&scenario.to_yaml()).expect("kept"),
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
        let text = text.replace("vehicles/own.yaml", "../vehicle/vehicles/brunner.yaml");
        let scenario = Scenario::load(&write("other.yaml", &text)).expect("found");
        let here = std::path::absolute("../vehicle/vehicles/brunner.yaml").expect("a path");
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
