//! The node's parameters, and the six services of `rcl_interfaces` that read and change them.
//!
//! A change is checked against the declarations, and then the complete set against the node's own rule. Only a set that passes both becomes
//! effective; the node receives it as one event.

use crate::error::{BoxedError, Error, Result};
use planesman_msgs::rcl_interfaces::{
    msg::{
        FloatingPointRange, IntegerRange, ListParametersResult, Parameter, ParameterDescriptor,
        ParameterType, ParameterValue, SetParametersResult,
    },
    srv::{ListParametersRequest, SetParametersRequest},
};
use planesman_parameters::{Declaration, Parameters, Refusal, Value, Values, file};

use crate::{
    args::{ParameterSource, RosArguments},
    names::NodeNames,
    qos_overrides,
};

/// Parameters of every node.
#[derive(Parameters)]
struct OfEveryNode {
    /// take the time from /clock
    #[parameter(default = false)]
    use_sim_time: bool,
    /// serve ~/get_type_description
    #[parameter(default = true, read_only)]
    start_type_description_service: bool,
    /// serve ~/get_logger_levels and ~/set_logger_levels
    #[parameter(default = false, read_only)]
    enable_logger_service: bool,
}

/// If this variable is set, an undeclared parameter is an error when the node starts.
pub const STRICT_PARAMETERS: &str = "PLANESMAN_STRICT_PARAMETERS";

/// Answer to an accepted parameter.
const SUCCESS: SetParametersResult = SetParametersResult {
    successful: true,
    reason: String::new(),
};

/// Rule for a complete set of values, beyond the declaration of each.
type Validate = Box<dyn Fn(&Values) -> Result<(), BoxedError>>;

/// The values in force, and the rule for new values.
pub(crate) struct ParameterServer {
    pub(crate) values: Values,
    validate: Validate,
}

impl ParameterServer {
    /// The declared defaults with the values given by the arguments. Undeclared names are ignored with a warning, as in rcl, so that one file can
    /// serve a whole robot; with `strict` they are an error.
    ///
    /// # Errors
    /// A file that cannot be read, or a value refused by its declaration or the rule.
    pub(crate) fn at_start<P: Parameters + 'static>(
        validate: fn(&P) -> Result<(), BoxedError>,
        names: &NodeNames,
        arguments: &RosArguments,
        strict: bool,
    ) -> Result<Self> {
        let declarations = [P::declarations(), OfEveryNode::declarations()].concat();
        let validate = move |values: &Values| validate(&P::from_values(values)?);
        let mut changes = Vec::new();
        for source in &arguments.parameters {
            match source {
                ParameterSource::File(path) => {
                    let refused = |reason: BoxedError| Error::ParameterFile {
                        path: path.display().to_string(),
                        reason: reason.to_string(),
                    };
                    let text = file::read(path).map_err(|e| refused(e.into()))?;
                    let found = file::overrides_for(&text, &names.full());
                    changes.extend(found.map_err(|e| refused(e.into()))?);
                }
                ParameterSource::Assignment { node, name, value } => {
                    if node.as_deref().is_none_or(|node| node == names.name) {
                        changes.push((name.clone(), value.clone()));
                    }
                }
            }
        }
        let mut overrides: Vec<_> = (changes.iter())
            .filter_map(|(name, _)| qos_overrides::declaration(name))
            .collect();
        overrides.sort_by(|a, b| a.name.cmp(&b.name));
        overrides.dedup_by(|a, b| a.name == b.name);
        let defaults = Values::defaults([declarations, overrides].concat());
        if !strict {
            let (declared, unknown) = defaults.declared(changes);
            for line in unknown {
                log::warn!("{line}");
            }
            changes = declared;
        }
        let values = defaults.with(changes)?;
        validate(&values).map_err(Error::Parameters)?;
        Ok(Self {
            values,
            validate: Box::new(validate),
        })
    }

    /// Whether the node's time comes from `/clock`.
    pub(crate) fn uses_sim_time(&self) -> bool {
        OfEveryNode::from_values(&self.values).is_ok_and(|it| it.use_sim_time)
    }

    /// Whether the node serves descriptions of its types.
    pub(crate) fn describes_types(&self) -> bool {
        OfEveryNode::from_values(&self.values).is_ok_and(|it| it.start_type_description_service)
    }

    /// Whether the node serves the levels of its loggers.
    pub(crate) fn serves_logger_levels(&self) -> bool {
        OfEveryNode::from_values(&self.values).is_ok_and(|it| it.enable_logger_service)
    }

    /// Applies all changes, or no change if one is refused; returns the changed parameters.
    pub(crate) fn change(
        &mut self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Vec<Parameter>, BoxedError> {
        let new = self.values.with_live(changes)?;
        (self.validate)(&new)?;
        let changed = new
            .declarations()
            .iter()
            .filter(|d| new.get(&d.name) != self.values.get(&d.name))
            .map(|d| Parameter {
                name: d.name.clone(),
                value: message_of(new.get(&d.name)),
            })
            .collect();
        self.values = new;
        Ok(changed)
    }

    /// `set_parameters`: sets all together if they are valid as a set, since `ros2 param load` sets a file's parameters this way; otherwise each
    /// one separately. Returns the results and the changes.
    pub(crate) fn set_each(
        &mut self,
        request: SetParametersRequest,
    ) -> (Vec<SetParametersResult>, Vec<Parameter>) {
        if let Ok(changed) = self.take(request.parameters.clone()) {
            return (vec![SUCCESS; request.parameters.len()], changed);
        }
        let mut all_changed = Vec::new();
        let results = request
            .parameters
            .into_iter()
            .map(|parameter| {
                let (result, changed) = self.set_together(vec![parameter]);
                all_changed.extend(changed);
                result
            })
            .collect();
        (results, all_changed)
    }

    /// `set_parameters_atomically`: sets all parameters or no parameter. Returns the result and the changes.
    pub(crate) fn set_together(
        &mut self,
        parameters: Vec<Parameter>,
    ) -> (SetParametersResult, Vec<Parameter>) {
        match self.take(parameters) {
            Ok(changed) => (SUCCESS, changed),
            Err(reason) => {
                let reason = reason.to_string();
                log::warn!("{reason}");
                let result = SetParametersResult {
                    successful: false,
                    reason,
                };
                (result, Vec::new())
            }
        }
    }

    /// Applies all parameters, or no parameter if one is refused.
    fn take(&mut self, parameters: Vec<Parameter>) -> Result<Vec<Parameter>, BoxedError> {
        let changes: Result<Vec<_>, Refusal> = parameters
            .into_iter()
            .map(|Parameter { name, value }| match value_of(value) {
                Some(value) => Ok((name, value)),
                None => Err(Refusal {
                    name,
                    reason: "a parameter cannot be unset".to_owned(),
                }),
            })
            .collect();
        self.change(changes?)
    }

    /// `get_parameters`: a value per name; "not set" for undeclared names.
    pub(crate) fn get(&self, names: &[String]) -> Vec<ParameterValue> {
        names
            .iter()
            .map(|name| message_of(self.values.get(name)))
            .collect()
    }

    /// `get_parameter_types`: a type per name; "not set" for undeclared names.
    pub(crate) fn types(&self, names: &[String]) -> Vec<u8> {
        self.get(names)
            .into_iter()
            .map(|value| value.r#type)
            .collect()
    }

    /// `describe_parameters`: a descriptor per name.
    pub(crate) fn describe(&self, names: &[String]) -> Vec<ParameterDescriptor> {
        names
            .iter()
            .map(|name| match self.values.declaration(name) {
                Some(declaration) => descriptor_of(declaration),
                None => ParameterDescriptor {
                    name: name.clone(),
                    ..ParameterDescriptor::default()
                },
            })
            .collect()
    }

    /// `list_parameters` as in `rclcpp`: names at most `depth` name levels below one of the prefixes (0: any depth), and their prefixes.
    pub(crate) fn list(&self, request: &ListParametersRequest) -> ListParametersResult {
        let shallow = |rest: &str| {
            request.depth == ListParametersRequest::DEPTH_RECURSIVE
                || (rest.matches('.').count() as u64) < request.depth
        };
        let below = |name: &str, prefix: &str| {
            name == prefix
                || name
                    .strip_prefix(prefix)
                    .and_then(|rest| rest.strip_prefix('.'))
                    .is_some_and(shallow)
        };
        let mut names: Vec<String> = self
            .values
            .declarations()
            .iter()
            .map(|d| d.name.as_str())
            .filter(|name| match request.prefixes.as_slice() {
                [] => shallow(name),
                prefixes => prefixes.iter().any(|prefix| below(name, prefix)),
            })
            .map(str::to_owned)
            .collect();
        names.sort();
        let mut prefixes: Vec<String> = names
            .iter()
            .filter_map(|name| Some(name.rsplit_once('.')?.0.to_owned()))
            .collect();
        prefixes.dedup();
        ListParametersResult { names, prefixes }
    }
}

/// Prefix of the list of choices in a descriptor's constraints, since ROS has no field for choices.
const ONE_OF: &str = "one of ";

/// The choices in a descriptor's constraints; `None` if another node uses another wording.
#[must_use]
pub fn choices_in(constraints: &str) -> Option<Vec<&str>> {
    Some(constraints.strip_prefix(ONE_OF)?.split(", ").collect())
}

/// The descriptor that `ros2 param describe` shows.
fn descriptor_of(declaration: &Declaration) -> ParameterDescriptor {
    let unit = match declaration.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let mut descriptor = ParameterDescriptor {
        name: declaration.name.clone(),
        r#type: message_of(Some(&declaration.default)).r#type,
        description: format!("{}{unit}", declaration.description),
        read_only: declaration.read_only,
        ..ParameterDescriptor::default()
    };
    if !declaration.choices.is_empty() {
        descriptor.additional_constraints = ONE_OF.to_owned() + &declaration.choices.join(", ");
    }
    if let Some((low, high)) = declaration.range {
        if matches!(
            declaration.default,
            Value::Integer(_) | Value::IntegerArray(_)
        ) {
            descriptor.integer_range = vec![IntegerRange {
                from_value: low as i64,
                to_value: high as i64,
                step: 0,
            }];
        } else {
            descriptor.floating_point_range = vec![FloatingPointRange {
                from_value: low,
                to_value: high,
                step: 0.0,
            }];
        }
    }
    descriptor
}

/// A value as a message; not set for `None`.
#[must_use]
pub fn message_of(value: Option<&Value>) -> ParameterValue {
    let mut message = ParameterValue::default();
    message.r#type = match value.cloned() {
        None => ParameterType::PARAMETER_NOT_SET,
        Some(Value::Bool(v)) => {
            message.bool_value = v;
            ParameterType::PARAMETER_BOOL
        }
        Some(Value::Integer(v)) => {
            message.integer_value = v;
            ParameterType::PARAMETER_INTEGER
        }
        Some(Value::Double(v)) => {
            message.double_value = v;
            ParameterType::PARAMETER_DOUBLE
        }
        Some(Value::String(v)) => {
            message.string_value = v;
            ParameterType::PARAMETER_STRING
        }
        Some(Value::ByteArray(v)) => {
            message.byte_array_value = v;
            ParameterType::PARAMETER_BYTE_ARRAY
        }
        Some(Value::BoolArray(v)) => {
            message.bool_array_value = v;
            ParameterType::PARAMETER_BOOL_ARRAY
        }
        Some(Value::IntegerArray(v)) => {
            message.integer_array_value = v;
            ParameterType::PARAMETER_INTEGER_ARRAY
        }
        Some(Value::DoubleArray(v)) => {
            message.double_array_value = v;
            ParameterType::PARAMETER_DOUBLE_ARRAY
        }
        Some(Value::StringArray(v)) => {
            message.string_array_value = v;
            ParameterType::PARAMETER_STRING_ARRAY
        }
    };
    message
}

/// Value of a message; `None` if it is not set or has an unknown type.
#[must_use]
pub fn value_of(message: ParameterValue) -> Option<Value> {
    match message.r#type {
        ParameterType::PARAMETER_BOOL => Some(Value::Bool(message.bool_value)),
        ParameterType::PARAMETER_INTEGER => Some(Value::Integer(message.integer_value)),
        ParameterType::PARAMETER_DOUBLE => Some(Value::Double(message.double_value)),
        ParameterType::PARAMETER_STRING => Some(Value::String(message.string_value)),
        ParameterType::PARAMETER_BYTE_ARRAY => Some(Value::ByteArray(message.byte_array_value)),
        ParameterType::PARAMETER_BOOL_ARRAY => Some(Value::BoolArray(message.bool_array_value)),
        ParameterType::PARAMETER_INTEGER_ARRAY => {
            Some(Value::IntegerArray(message.integer_array_value))
        }
        ParameterType::PARAMETER_DOUBLE_ARRAY => {
            Some(Value::DoubleArray(message.double_array_value))
        }
        ParameterType::PARAMETER_STRING_ARRAY => {
            Some(Value::StringArray(message.string_array_value))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Choice;

    #[derive(Parameters)]
    struct Controller {
        depth: Depth,
        /// model order
        #[parameter(default = 2, range = 1..=6)]
        order: i64,
        /// what is held
        #[parameter(default = Mode::Depth)]
        mode: Mode,
    }

    #[derive(Parameters)]
    struct Depth {
        /// depth gain
        #[parameter(default = 0.25, unit = "rad/m", range = 0.0..=10.0)]
        kp: f64,
        /// largest command
        #[parameter(default = 0.5, unit = "rad")]
        limit: f64,
    }

    #[derive(Clone, Copy, Choice)]
    enum Mode {
        Off,
        Depth,
    }

    fn started(line: &str, strict: bool) -> Result<ParameterServer> {
        let line_of_arguments = format!("x --ros-args {line}");
        let (_, arguments) =
            crate::args::split(line_of_arguments.split_whitespace().map(str::to_owned))?;
        let names = NodeNames::remapped("controller", "/auv", &[])?;
        ParameterServer::at_start(
            |Controller { depth, .. }| {
                if depth.kp * depth.limit > 1.0 {
                    return Err("depth.kp * depth.limit must not exceed 1".into());
                }
                Ok(())
            },
            &names,
            &arguments,
            strict,
        )
    }

    fn gains(line: &str) -> Result<ParameterServer> {
        started(line, true)
    }

    fn parameter(name: &str, value: Value) -> Parameter {
        Parameter {
            name: name.to_owned(),
            value: message_of(Some(&value)),
        }
    }

    #[test]
    fn the_last_assignment_for_this_node_holds_at_start() {
        let gains = gains("-p depth.kp:=0.5 -p depth.kp:=1 -p other:depth.kp:=2").expect("good");
        assert_eq!(gains.values.read("depth.kp"), Ok(1.0));
        assert!(!gains.uses_sim_time());
    }

    #[test]
    fn a_bad_start_is_refused_with_its_reason() {
        for (line, reason) in [
            ("-p kp:=1", "not declared"),
            ("-p depth.kp:=.nan", "finite"),
            ("-p depth.kp:=8.0", "must not exceed 1"),
            ("--params-file /nowhere.yaml", "/nowhere.yaml"),
        ] {
            let refusal = format!("{:#}", gains(line).err().expect(line));
            assert!(refusal.contains(reason), "{refusal}");
        }
    }

    #[test]
    fn a_name_that_is_not_declared_is_ignored_unless_the_start_is_strict() {
        let line = "-p robot_description:=<robot/> -p depth.kp:=0.5 -p depth.kq:=1";
        let gains = started(line, false).expect("taken");
        assert_eq!(gains.values.read("depth.kp"), Ok(0.5));
        let refusal = started("-p depth.kq:=1", true).err().expect("strict");
        assert!(
            refusal.to_string().contains("did you mean 'depth.kp'?"),
            "{refusal}"
        );
        assert!(
            started("-p depth.kp:=high", false).is_err(),
            "its type is another"
        );
    }

    #[test]
    fn each_is_taken_alone_or_all_together_by_the_rule_for_the_set() {
        let both = vec![
            parameter("depth.limit", Value::Double(2.0)),
            parameter("depth.kp", Value::Double(4.0)),
        ];
        let mut each = gains("").expect("good");
        let (results, changed) = each.set_each(SetParametersRequest {
            parameters: both.clone(),
        });
        let successes: Vec<bool> = results.iter().map(|r| r.successful).collect();
        assert_eq!(successes, [true, false]);
        assert!(results[1].reason.contains("must not exceed 1"));
        assert_eq!(changed.len(), 1);

        let lower_limit = [
            parameter("depth.kp", Value::Double(4.0)),
            parameter("depth.limit", Value::Double(0.25)),
        ];
        let mut either_way = gains("").expect("good");
        let (results, changed) = either_way.set_each(SetParametersRequest {
            parameters: lower_limit.to_vec(),
        });
        assert!(results.iter().all(|it| it.successful) && results.len() == 2);
        assert_eq!(changed, lower_limit);

        let mut together = gains("").expect("good");
        let (result, changed) = together.set_together(both);
        assert!(!result.successful && changed.is_empty());
        assert_eq!(together.values.read("depth.limit"), Ok(0.5));
        let (results, _) = together.set_each(SetParametersRequest {
            parameters: vec![parameter("depth.kp", Value::Double(f64::NAN))],
        });
        assert!(results[0].reason.contains("finite"));
        let unset = Parameter {
            name: "depth.kp".to_owned(),
            ..Parameter::default()
        };
        assert!(!together.set_together(vec![unset]).0.successful);
    }

    #[test]
    fn descriptors_tell_unit_range_and_choices() {
        let names = ["depth.kp", "order", "mode", "nothing"].map(str::to_owned);
        let found = gains("").expect("good").describe(&names);
        assert_eq!(found[0].description, "depth gain [rad/m]");
        assert_eq!(found[0].floating_point_range[0].to_value, 10.0);
        assert_eq!(found[1].integer_range[0].to_value, 6);
        let constraints = &found[2].additional_constraints;
        assert_eq!(constraints, "one of off, depth");
        assert_eq!(choices_in(constraints).as_deref(), Some(Mode::NAMES));
        assert_eq!(choices_in("must be even"), None);
        assert_eq!(found[3].r#type, ParameterType::PARAMETER_NOT_SET);
    }

    #[test]
    fn the_list_goes_as_deep_as_asked() {
        let gains = gains("").expect("good");
        let list = |prefixes: &[&str], depth| {
            gains.list(&ListParametersRequest {
                prefixes: prefixes.iter().map(|p| (*p).to_owned()).collect(),
                depth,
            })
        };
        let all = list(&[], 0);
        assert_eq!(
            all.names,
            [
                "depth.kp",
                "depth.limit",
                "enable_logger_service",
                "mode",
                "order",
                "start_type_description_service",
                "use_sim_time"
            ]
        );
        assert_eq!(all.prefixes, ["depth"]);
        assert_eq!(
            list(&[], 1).names,
            [
                "enable_logger_service",
                "mode",
                "order",
                "start_type_description_service",
                "use_sim_time"
            ]
        );
        assert_eq!(list(&["depth"], 1).names, ["depth.kp", "depth.limit"]);
        assert_eq!(list(&["dep"], 0).names, [] as [&str; 0]);
    }
}
