//! ROS 2's parameter types (`rcl_interfaces/msg/ParameterType`).

use std::fmt;

use planesman_text::shown;

/// Value of a parameter. The variants are those of `ParameterType`, without "not set".
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `PARAMETER_BOOL`
    Bool(bool),
    /// `PARAMETER_INTEGER`
    Integer(i64),
    /// `PARAMETER_DOUBLE`
    Double(f64),
    /// `PARAMETER_STRING`
    String(String),
    /// `PARAMETER_BYTE_ARRAY`
    ByteArray(Vec<u8>),
    /// `PARAMETER_BOOL_ARRAY`
    BoolArray(Vec<bool>),
    /// `PARAMETER_INTEGER_ARRAY`
    IntegerArray(Vec<i64>),
    /// `PARAMETER_DOUBLE_ARRAY`
    DoubleArray(Vec<f64>),
    /// `PARAMETER_STRING_ARRAY`
    StringArray(Vec<String>),
}

impl Value {
    /// The type with an article, such as `a whole number`, `text`.
    #[must_use]
    pub fn type_with_article(&self) -> &'static str {
        match self {
            Self::Bool(_) => "true or false",
            Self::Integer(_) => "a whole number",
            Self::Double(_) => "a number",
            Self::String(_) => "text",
            Self::ByteArray(_) => "a list of bytes",
            Self::BoolArray(_) => "a list of true or false",
            Self::IntegerArray(_) => "a list of whole numbers",
            Self::DoubleArray(_) => "a list of numbers",
            Self::StringArray(_) => "a list of texts",
        }
    }

    /// All numbers in the value, for range checks; empty for text and booleans.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Integer(i) => vec![*i as f64],
            Self::Double(d) => vec![*d],
            Self::IntegerArray(v) => v.iter().map(|i| *i as f64).collect(),
            Self::DoubleArray(v) => v.clone(),
            _ => Vec::new(),
        }
    }

    /// Converts the value to the type of `like` if nothing is lost: an integer for a declared double, an empty list for any list. Otherwise returns
    /// it unchanged.
    ///
    /// `ros2 param` uses YAML 1.1: it sends every empty list as a list of booleans, and `1e+18` as text.
    #[must_use]
    pub fn coerced_like(self, like: &Self) -> Self {
        match (self, like) {
            (Self::Integer(i), Self::Double(_)) => Self::Double(i as f64),
            (Self::IntegerArray(v), Self::DoubleArray(_)) => {
                Self::DoubleArray(v.into_iter().map(|i| i as f64).collect())
            }
            (Self::String(text), Self::Double(_)) if text.contains(['e', 'E']) => {
                text.parse().map_or(Self::String(text), Self::Double)
            }
            (value, like) if value.is_empty_list() => like.emptied().unwrap_or(value),
            (value, _) => value,
        }
    }

    fn is_empty_list(&self) -> bool {
        self.emptied().is_some_and(|empty| empty == *self)
    }

    /// The empty list of the same type; `None` if the value is not a list.
    fn emptied(&self) -> Option<Self> {
        match self {
            Self::Bool(_) | Self::Integer(_) | Self::Double(_) | Self::String(_) => None,
            Self::ByteArray(_) => Some(Self::ByteArray(Vec::new())),
            Self::BoolArray(_) => Some(Self::BoolArray(Vec::new())),
            Self::IntegerArray(_) => Some(Self::IntegerArray(Vec::new())),
            Self::DoubleArray(_) => Some(Self::DoubleArray(Vec::new())),
            Self::StringArray(_) => Some(Self::StringArray(Vec::new())),
        }
    }
}

/// Text in quotes, valid in YAML and JSON.
fn quoted(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len() + 2);
    for sign in text.chars() {
        match sign {
            '"' | '\\' => escaped.extend(['\\', sign]),
            '\n' => escaped.push_str("\\n"),
            '\t' => escaped.push_str("\\t"),
            _ => escaped.push(sign),
        }
    }
    format!("\"{}\"", shown(escaped))
}

/// Writes the value in the form of a parameter file.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(v) => write!(f, "{v}"),
            Self::Integer(v) => write!(f, "{v}"),
            Self::Double(v) => write!(f, "{v:?}"),
            Self::String(v) => write!(f, "{}", quoted(v)),
            Self::ByteArray(v) => write!(f, "{v:?}"),
            Self::BoolArray(v) => write!(f, "{v:?}"),
            Self::IntegerArray(v) => write!(f, "{v:?}"),
            Self::DoubleArray(v) => write!(f, "{v:?}"),
            Self::StringArray(v) => {
                let texts: Vec<String> = v.iter().map(|text| quoted(text)).collect();
                write!(f, "[{}]", texts.join(", "))
            }
        }
    }
}

impl From<bool> for Value {
    fn from(v: bool) -> Self {
        Self::Bool(v)
    }
}
impl From<i64> for Value {
    fn from(v: i64) -> Self {
        Self::Integer(v)
    }
}
impl From<f64> for Value {
    fn from(v: f64) -> Self {
        Self::Double(v)
    }
}
impl From<&str> for Value {
    fn from(v: &str) -> Self {
        Self::String(v.to_owned())
    }
}
impl From<&[&str]> for Value {
    fn from(v: &[&str]) -> Self {
        Self::StringArray(v.iter().map(|s| (*s).to_owned()).collect())
    }
}
