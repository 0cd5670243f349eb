//! The declaration of a parameter.

use crate::{ParameterType, Refusal, Value};

/// A declared parameter: what `ros2 param describe` shows, and what a new value must obey.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// The name, dots between levels: `depth.kp`.
    pub name: String,
    /// The default, which also fixes the type.
    pub default: Value,
    /// Its description, in a sentence.
    pub description: &'static str,
    /// The unit, `""` for text, booleans and pure numbers.
    pub unit: &'static str,
    /// The direction in which its numbers are positive, as `down`; `""` where none is given.
    pub positive: &'static str,
    /// The closed interval that every number in the value must lie in.
    pub range: Option<(f64, f64)>,
    /// The only texts accepted, empty when any is.
    pub choices: &'static [&'static str],
    /// Set at start-up only.
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

    /// The unit its numbers are in.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// The direction in which its numbers are positive, as `down`.
    #[must_use]
    pub fn positive(mut self, direction: &'static str) -> Self {
        self.positive = direction;
        self
    }

    /// The closed interval its numbers must lie in.
    #[must_use]
    pub fn range(mut self, low: impl Into<f64>, high: impl Into<f64>) -> Self {
        self.range = Some((low.into(), high.into()));
        self
    }

    /// Fixes it once the node has started.
    #[must_use]
    pub fn read_only(mut self) -> Self {
        self.read_only = true;
        self
    }

    /// The value, in this parameter's type, if it obeys the declaration.
    ///
    /// # Errors
    /// A [`Refusal`] naming the parameter, the value and the rule, when the type is
    /// another, a number is not finite or out of range, or a text is not among the choices.
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
                return refuse(format!("it must lie in [{low}, {high}]{unit}{sign}"));
            }
        }
        if let Value::String(text) = &value
            && !self.choices.is_empty()
            && !self.choices.contains(&text.as_str())
        {
            return refuse(format!("it must be one of {}", self.choices.join(", ")));
        }
        Ok(value)
    }
}
