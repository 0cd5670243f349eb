//! The declaration of a parameter.

use crate::{ParameterType, Refusal, Value};

/// A declared parameter: the content of `ros2 param describe`, and the rule for new values.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// Name of the parameter; dots separate groups, for example `depth.kp`.
    pub name: String,
    /// Default value, which also determines the type.
    pub default: Value,
    /// Description, one sentence.
    pub description: &'static str,
    /// Unit; `""` for text, booleans and pure numbers.
    pub unit: &'static str,
    /// Direction of positive numbers, such as `down`; `""` if no direction is given.
    pub positive: &'static str,
    /// Closed interval for every number in the value.
    pub range: Option<(f64, f64)>,
    /// Allowed texts; empty if any text is allowed.
    pub choices: &'static [&'static str],
    /// Whether the parameter can be set only at the start.
    pub read_only: bool,
}

impl Declaration {
    /// A parameter of the type `T`, without unit or range, changeable at run time.
    #[must_use]
    pub fn of<T: ParameterType>(name: String, default: &T, description: &'static str) -> Self {
        Self {
            name,
            default: default.to_value(),
            description,
            unit: "",
            positive: "",
            range: None,
            choices: T::CHOICES,
            read_only: false,
        }
    }

    /// Sets the unit of its numbers.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Sets the direction of positive numbers, such as `down`.
    #[must_use]
    pub fn positive(mut self, direction: &'static str) -> Self {
        self.positive = direction;
        self
    }

    /// Sets the closed interval of its numbers.
    #[must_use]
    pub fn range(mut self, low: impl Into<f64>, high: impl Into<f64>) -> Self {
        self.range = Some((low.into(), high.into()));
        self
    }

    /// Makes the parameter read-only after the start of the node.
    #[must_use]
    pub fn read_only(mut self) -> Self {
        self.read_only = true;
        self
    }

    /// Checks a value and returns it in this parameter's type.
    ///
    /// # Errors
    /// A [`Refusal`] with the parameter, the value and the rule, for a wrong type, a number that is not finite or out of range, or a text that is not
    /// among the choices.
    pub fn accept(&self, value: Value) -> Result<Value, Refusal> {
        let value = match value {
            // `ros2 param set` sends YAML 1.1's `on` and `off` as booleans.
            Value::Bool(on) if self.choices.contains(&["off", "on"][usize::from(on)]) => {
                Value::from(["off", "on"][usize::from(on)])
            }
            value => value.coerced_like(&self.default),
        };
        let refuse = |rule: String| {
            Err(Refusal {
                name: self.name.clone(),
                reason: format!("{value} refused: {rule}"),
            })
        };
        if std::mem::discriminant(&value) != std::mem::discriminant(&self.default) {
            return refuse(format!("{} is expected", self.default.type_with_article()));
        }
        for number in value.numbers() {
            if !number.is_finite() {
                return refuse("numbers must be finite".to_owned());
            }
            if let Some((low, high)) = self.range
                && !(low..=high).contains(&number)
            {
                let behind = |separator: &str, text: &str| match text {
                    "" => String::new(),
                    text => format!("{separator}{text}"),
                };
                let unit = behind(" ", self.unit);
                let sign = behind(", positive ", self.positive);
                return refuse(format!("the value must lie in [{low}, {high}]{unit}{sign}"));
            }
        }
        if let Value::String(text) = &value
            && !self.choices.is_empty()
            && !self.choices.contains(&text.as_str())
        {
            return refuse(format!(
                "the value must be one of {}",
                self.choices.join(", ")
            ));
        }
        Ok(value)
    }
}
