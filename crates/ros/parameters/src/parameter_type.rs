//! Rust types of parameters.

use crate::Value;

/// A text parameter with a fixed list of values; derived for an enum without fields.
pub trait Choice: Copy {
    /// The values as users write them, in snake case.
    const NAMES: &'static [&'static str];

    /// The value as users write it.
    fn name(self) -> &'static str;

    /// The variant with this name.
    fn named(name: &str) -> Option<Self>;
}

/// A Rust type that a parameter may have.
pub trait ParameterType: Sized {
    /// Allowed texts; empty if any text is allowed.
    const CHOICES: &'static [&'static str] = &[];

    /// Conversion to the ROS value.
    fn to_value(&self) -> Value;

    /// Conversion from a ROS value; `None` if it has another type or does not fit.
    fn from_value(value: &Value) -> Option<Self>;
}

macro_rules! parameter_types {
    ($($rust:ty => $ros:ident),* $(,)?) => {$(
        impl ParameterType for $rust {
            fn to_value(&self) -> Value {
                Value::$ros(self.clone())
            }

            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::$ros(it) => Some(it.clone()),
                    _ => None,
                }
            }
        }
    )*};
}

parameter_types! {
    bool => Bool,
    i64 => Integer,
    f64 => Double,
    String => String,
    Vec<f64> => DoubleArray,
    Vec<String> => StringArray,
}

macro_rules! counts {
    ($($rust:ty),*) => {$(
        impl ParameterType for $rust {
            fn to_value(&self) -> Value {
                Value::Integer(i64::try_from(*self).unwrap_or(i64::MAX))
            }

            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::Integer(count) => Self::try_from(*count).ok(),
                    _ => None,
                }
            }
        }
    )*};
}

counts!(u32, u64, usize);
