//! Reads numbers of files directly into SI, checked by the rule of their field.
//!
//! [`readers!`](crate::readers) declares the readers of a file's fields, each with its dimension and rule; a field then has the attribute
//! `#[serde(with = "mass")]`. A refusal is `-2 kg refused: it must be above zero`; the parser adds the field's path.

use std::fmt;

use serde::de::{self, Deserializer, Visitor};

use crate::quantity::{Rule, Written, within};
use crate::{Dimension, Quantity};

/// Reads a number with its unit into SI, checked by the rule of its field.
///
/// # Errors
/// The value and the violated rule.
pub fn quantity<'de, D: Deserializer<'de>>(
    deserializer: D,
    dimension: Dimension,
    rule: impl Into<Rule>,
) -> Result<f64, D::Error> {
    let rule = rule.into();
    deserializer.deserialize_any(Written(|written: Quantity| {
        let value = written.by_rule(dimension, rule);
        value.map_err(|rule| format!("{written} refused: {rule}"))
    }))
}

/// Reads a number without unit, within the range of its field.
///
/// # Errors
/// The value and the range.
pub fn number<'de, D: Deserializer<'de>>(
    deserializer: D,
    range: [f64; 2],
) -> Result<f64, D::Error> {
    deserializer.deserialize_f64(Bare(range))
}

/// Reads a number within a range.
struct Bare([f64; 2]);

impl Visitor<'_> for Bare {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<f64, E> {
        let refused = |rule| E::custom(format!("{value} refused: {rule}"));
        within(value, self.0, "").map_err(refused)
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<f64, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<f64, E> {
        self.visit_f64(value as f64)
    }
}

/// Declares readers of fields, for `#[serde(with = "NAME")]`: a dimension, or `Number`, and the accepted values, a [`Rule`] or a range in SI. With
/// `or` and a value, an empty field has that value; `default = "NAME::default"` gives it to a missing field too. `optional` reads an
/// `Option<f64>` (with `default` for a missing field), `array 3` an `[f64; 3]`.
///
/// ```
/// planesman_units::readers! {
///     mass: Mass, [1e-3, 1e7];
///     air: Number, [1e-6, 0.5];
///     scatter: Time, [0.0, 1.0], or 0.0;
///     optional lift_aft: Length, planesman_units::Rule::AboveZero;
///     array 3 position: Length, planesman_units::Rule::Any;
/// }
///
/// #[derive(serde::Deserialize)]
/// struct Load {
///     #[serde(with = "mass")]
///     mass: f64,
///     #[serde(default = "scatter::default", with = "scatter")]
///     scatter: f64,
/// }
/// ```
#[macro_export]
macro_rules! readers {
    () => {};
    (optional $name:ident: $kind:ident, $rule:expr; $($rest:tt)*) => {
        $crate::readers!(@module $name, Option<Given>, Option<f64>, |it| it.map(|it| it.0), $kind, $rule);
        $crate::readers!($($rest)*);
    };
    (array $count:literal $name:ident: $kind:ident, $rule:expr; $($rest:tt)*) => {
        $crate::readers!(@module $name, [Given; $count], [f64; $count], |it| it.map(|it| it.0), $kind, $rule);
        $crate::readers!($($rest)*);
    };
    ($name:ident: $kind:ident, $rule:expr, or $default:expr; $($rest:tt)*) => {
        $crate::readers!(
            @module $name, Option<Given>, f64, |it| it.map_or_else(default, |it| it.0), $kind, $rule,
            pub(crate) fn default() -> f64 { $default }
        );
        $crate::readers!($($rest)*);
    };
    ($name:ident: $kind:ident, $rule:expr; $($rest:tt)*) => {
        $crate::readers!(@module $name, Given, f64, |it| it.0, $kind, $rule);
        $crate::readers!($($rest)*);
    };
    (@module $name:ident, $given:ty, $value:ty, $taken:expr, $kind:ident, $rule:expr $(, $default:item)?) => {
        pub(crate) mod $name {
            #[allow(unused_imports)]
            use super::*;

            /// A number that satisfies the rule.
            struct Given(f64);

            impl<'de> serde::Deserialize<'de> for Given {
                fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                    $crate::readers!(@read d, $kind, $rule).map(Self)
                }
            }

            $($default)?

            pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(d: D) -> Result<$value, D::Error> {
                <$given as serde::Deserialize>::deserialize(d).map($taken)
            }
        }
    };
    (@read $from:ident, Number, $range:expr) => {
        $crate::read::number($from, $range)
    };
    (@read $from:ident, $dimension:ident, $rule:expr) => {
        $crate::read::quantity($from, $crate::Dimension::$dimension, $rule)
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::readers! {
        mass: Mass, [1e-3, 1e7];
        air: Number, [0.0, 0.5];
        scatter: Time, [0.0, 1.0], or 0.25;
        optional arm: Length, Rule::AboveZero;
        array 2 ends: Length, Rule::Any;
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    struct Part {
        #[serde(with = "mass")]
        mass: f64,
        #[serde(with = "air")]
        air: f64,
        #[serde(default = "scatter::default", with = "scatter")]
        scatter: f64,
        #[serde(default, with = "arm")]
        arm: Option<f64>,
        #[serde(with = "ends")]
        ends: [f64; 2],
    }

    fn part(text: &str) -> Result<Part, String> {
        #[derive(serde::Deserialize)]
        struct File {
            part: Part,
        }
        let file: Result<File, _> = serde_yaml_ng::from_str(&format!("part: {{{text}}}"));
        file.map(|it| it.part).map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_are_read_in_si_and_an_empty_or_missing_field_has_its_default() {
        let missing = part("mass: 2 kg, air: 0, ends: [-1 m, 1 ft]").unwrap();
        let expected = Part {
            mass: 2.0,
            air: 0.0,
            scatter: 0.25,
            arm: None,
            ends: [-1.0, crate::FOOT],
        };
        assert_eq!(missing, expected);
        let empty = "mass: 2 kg, air: 0, ends: [-1 m, 1 ft], scatter: ~, arm: ~";
        assert_eq!(part(empty).unwrap(), expected);
        let given = "mass: 2 kg, air: 0, ends: [-1 m, 1 ft], scatter: 1 ms, arm: 5 cm";
        let given = part(given).unwrap();
        assert_eq!((given.scatter, given.arm), (0.001, Some(0.05)));
    }

    #[test]
    fn a_refusal_names_the_path_the_value_and_the_rule() {
        for (text, said) in [
            (
                "mass: -1 kg",
                "part.mass: -1 kg refused: it must be from 0.001 to 10000000 kg",
            ),
            (
                "mass: 1 m",
                "part.mass: 1 m refused: it must be a number with one of the units kg",
            ),
            (
                "mass: [1]",
                "part.mass: invalid type: sequence, expected a number with its unit",
            ),
            (
                "air: .nan",
                "part.air: NaN refused: it must be from 0 to 0.5",
            ),
            (
                "air: x",
                "part.air: invalid type: string \"x\", expected a number",
            ),
            (
                "scatter: 2 s",
                "part.scatter: 2 s refused: it must be from 0 to 1 s",
            ),
            ("arm: 0 m", "part.arm: 0 m refused: it must be above zero"),
            (
                "ends: [1 m, 2 kg]",
                "part.ends[1]: 2 kg refused: it must be a number with one of the units m",
            ),
        ] {
            let reason = part(text).unwrap_err();
            assert!(reason.starts_with(said), "{text}: {reason}");
        }
    }
}
