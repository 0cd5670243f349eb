//! A quantity as written by users: `28 in`.
//!
//! The number comes first, then the unit; the space between them is optional (`1ft/s`). Files also accept the older mapping
//! `{value: 28, unit: in}`. On the command line a number without unit is in SI.

use std::{convert::Infallible, fmt, str::FromStr};

use serde::de::{
    self, Deserialize, Deserializer, MapAccess, Visitor, value::MapAccessDeserializer,
};

use crate::dimension::symbol;
use crate::{Dimension, Unit};

/// The reason why a quantity is refused. The text states the rule; the caller adds the field and the value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The unit is missing or belongs to another dimension; contains the accepted units.
    #[error("it must be a number with one of the units {}", .0.join(", "))]
    Unit(Vec<&'static str>),
    /// The text before the unit is not a number.
    #[error("'{0}' is not a number")]
    Number(String),
    /// The magnitude is implausible for the dimension; contains the limits in SI and the SI unit.
    #[error("its magnitude must be 0, or from {:e} to {:e} {}", .0[0], .0[1], .1)]
    Magnitude([f64; 2], &'static str),
    /// The value is 0 or less.
    #[error("it must be above zero")]
    NotAboveZero,
    /// The value is outside the range of its field, or is NaN.
    #[error("it must be from {least} to {most}{}{unit}", if .unit.is_empty() { "" } else { " " })]
    Within {
        /// Smallest value, SI.
        least: f64,
        /// The largest value, SI.
        most: f64,
        /// SI unit; empty for a number without unit.
        unit: &'static str,
    },
    /// A number outside the range, with or without a unit; on the command line.
    #[error("a number from {least} to {most} {} is expected, or one with its unit: {}", .units[0], .units.join(", "))]
    Range {
        /// Smallest value, SI.
        least: f64,
        /// The largest value, SI.
        most: f64,
        /// Units of the dimension, SI first.
        units: Vec<&'static str>,
    },
}

/// A number with its unit, as written. The [`Dimension`] depends on the field.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Quantity(String);

impl Quantity {
    /// The value in SI.
    ///
    /// # Errors
    /// [`Error`]: not a number, a unit of another dimension, or a magnitude outside [`Dimension::magnitudes`].
    pub fn si(&self, dimension: Dimension) -> Result<f64, Error> {
        self.si_or(dimension, &[])
    }

    /// The value in SI; accepts the `further` units in addition to those of the dimension.
    ///
    /// # Errors
    /// Those of [`si`](Self::si).
    pub fn si_or(&self, dimension: Dimension, further: &[Unit]) -> Result<f64, Error> {
        plausible(self.converted(dimension, further)?, dimension)
    }

    /// The value in SI within the range `[least, most]` of its field; `further` units are accepted too.
    ///
    /// # Errors
    /// [`Error`]: not a number, a unit of another dimension, or a value outside the range.
    pub fn within(
        &self,
        dimension: Dimension,
        further: &[Unit],
        range: [f64; 2],
    ) -> Result<f64, Error> {
        let value = self.converted(dimension, further)?;
        within(value, range, dimension.units()[0].symbol)
    }

    /// The value in SI, checked by the rule of its field.
    ///
    /// # Errors
    /// [`Error`]: not a number, a unit of another dimension, or a value that violates the rule.
    pub fn by_rule(&self, dimension: Dimension, rule: Rule) -> Result<f64, Error> {
        rule.check(self.converted(dimension, &[])?, dimension)
    }

    /// Another number with the same unit.
    #[must_use]
    pub fn with_number(&self, number: f64) -> Self {
        Self(format!("{number} {}", self.parts().1))
    }

    fn converted(&self, dimension: Dimension, further: &[Unit]) -> Result<f64, Error> {
        let (number, spelt) = self.parts();
        let symbol = symbol(spelt);
        let units = || dimension.units().iter().chain(further);
        let unit = units()
            .find(|unit| unit.symbol == symbol)
            .ok_or_else(|| Error::Unit(units().map(|unit| unit.symbol).collect()))?;
        Ok(unit.si(parsed(number)?))
    }

    /// The value of a command-line argument in SI; a number without unit is in SI.
    ///
    /// # Errors
    /// Those of [`si`](Self::si).
    pub fn argument(&self, dimension: Dimension) -> Result<f64, Error> {
        match self.parts() {
            (number, "") if !number.is_empty() => plausible(parsed(number)?, dimension),
            _ => self.si(dimension),
        }
    }

    /// The value of an argument within `[least, most]`, both in SI; a number without unit is in SI.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn argument_within(
        &self,
        dimension: Dimension,
        least: f64,
        most: f64,
    ) -> Result<f64, Error> {
        match self.argument(dimension) {
            Ok(value) if (least..=most).contains(&value) => Ok(value),
            _ => Err(Error::Range {
                least,
                most,
                units: dimension.units().iter().map(|unit| unit.symbol).collect(),
            }),
        }
    }

    /// The value in SI and the SI unit, determined by the unit alone; `None` without a number or with an unknown unit.
    #[must_use]
    pub fn in_si(&self) -> Option<(f64, &'static str)> {
        let dimension = Dimension::of_unit(symbol(self.parts().1))?;
        Some((self.si(dimension).ok()?, dimension.units()[0].symbol))
    }

    /// The number and the unit.
    fn parts(&self) -> (&str, &str) {
        let text = self.0.trim();
        let (number, unit) = match text.split_once(char::is_whitespace) {
            // A unit may have spaces of its own: `1ft lbf`.
            Some((number, unit)) if number.parse::<f64>().is_ok() => (number, unit),
            _ => {
                let in_number = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
                text.split_at(text.find(|c| !in_number(c)).unwrap_or(text.len()))
            }
        };
        (number, unit.trim())
    }
}

fn parsed(number: &str) -> Result<f64, Error> {
    number
        .parse()
        .map_err(|_| Error::Number(number.escape_debug().to_string()))
}

/// The value, if its magnitude is plausible for the dimension.
pub(crate) fn plausible(value: f64, dimension: Dimension) -> Result<f64, Error> {
    let [least, most] = dimension.magnitudes();
    match value == 0.0 || (least..=most).contains(&value.abs()) {
        true => Ok(value),
        false => Err(Error::Magnitude([least, most], dimension.units()[0].symbol)),
    }
}

/// Checks that a number is within the range `[least, most]` of its field; `unit` is empty for a number without unit.
///
/// # Errors
/// [`Error::Within`]: outside the range, or NaN.
pub fn within(value: f64, [least, most]: [f64; 2], unit: &'static str) -> Result<f64, Error> {
    match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Error::Within { least, most, unit }),
    }
}

impl fmt::Display for Quantity {
    /// Prints the quantity as written, with control characters escaped.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_debug())
    }
}

impl FromStr for Quantity {
    type Err = Infallible;

    /// Accepts any text; [`si`](Self::si) checks it once the dimension is known.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Written(Ok::<_, Infallible>))
    }
}

/// The older form, with value and unit as separate fields.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Mapping {
    value: f64,
    unit: String,
}

/// Reads either form and passes the quantity on. A number without unit is passed on too, so that its refusal names the units.
pub(crate) struct Written<F>(pub(crate) F);

impl<T, R: fmt::Display, F: FnOnce(Quantity) -> Result<T, R>> Written<F> {
    fn read<E: de::Error>(self, text: String) -> Result<T, E> {
        (self.0)(Quantity(text)).map_err(E::custom)
    }
}

impl<'de, T, R: fmt::Display, F: FnOnce(Quantity) -> Result<T, R>> Visitor<'de> for Written<F> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number with its unit, such as 28 in")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        self.read(text.to_owned())
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<T, E> {
        self.read(number.to_string())
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<T, E> {
        self.read(number.to_string())
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<T, E> {
        // A message repeats it: 1e308 in three hundred digits would hide the rest.
        self.read(match number.abs() {
            0.0 | 1e-6..1e15 => number.to_string(),
            _ => format!("{number:e}"),
        })
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        let Mapping { value, unit } = Mapping::deserialize(MapAccessDeserializer::new(map))?;
        self.read(format!("{value} {unit}"))
    }
}

/// Rule for the number of a field, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Any plausible value of the dimension ([`Dimension::magnitudes`]).
    Any,
    /// A plausible value above zero.
    AboveZero,
    /// A value from the first number to the second.
    Within([f64; 2]),
}

impl From<[f64; 2]> for Rule {
    fn from(range: [f64; 2]) -> Self {
        Self::Within(range)
    }
}

impl Rule {
    /// The value in SI, if it satisfies the rule.
    ///
    /// # Errors
    /// [`Error::Magnitude`], [`Error::NotAboveZero`] or [`Error::Within`].
    pub fn check(self, value: f64, dimension: Dimension) -> Result<f64, Error> {
        match self {
            Self::Within(range) => within(value, range, dimension.units()[0].symbol),
            Self::AboveZero if value <= 0.0 => {
                plausible(value, dimension).and(Err(Error::NotAboveZero))
            }
            Self::AboveZero | Self::Any => plausible(value, dimension),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DEGREE, FOOT};

    fn quantity(text: &str) -> Quantity {
        text.parse().unwrap()
    }

    fn si(dimension: Dimension, text: &str) -> Result<f64, Error> {
        quantity(text).si(dimension)
    }

    #[test]
    fn the_report_s_values_in_si() {
        let close = |dimension, text, expected: f64| {
            let value = si(dimension, text).unwrap();
            assert!((value / expected - 1.0).abs() < 5e-4, "{text}: {value}");
        };
        // IBM 66-L03-005, Table 4-1, and Brunner 1988, Fig. 23.
        close(Dimension::Force, "600 lb", 2669.0);
        close(Dimension::Mass, "0.296 lb s^2/in", 51.84);
        close(Dimension::OilStiffness, "26600 lb/in^5", 1.1192e13);
        close(Dimension::Damping, "12 lb s/in", 2101.5);
        close(Dimension::Pressure, "750 psi", 5.171e6);
        close(Dimension::Volume, "0.152 in^3", 2.4908e-6);
        close(Dimension::Length, "28 in", 0.7112);
        close(Dimension::Mass, "0.609 slug", 8.888);
        assert_eq!(si(Dimension::Time, "5.5 ms"), Ok(0.0055));
    }

    #[test]
    fn every_unit_is_read_with_and_without_a_space_and_from_the_older_mapping() {
        use Dimension as D;
        for dimension in [
            D::Angle,
            D::Rate,
            D::Length,
            D::Area,
            D::Volume,
            D::Flow,
            D::Speed,
            D::Acceleration,
            D::Time,
            D::Frequency,
            D::Mass,
            D::Inertia,
            D::Density,
            D::Viscosity,
            D::Force,
            D::Moment,
            D::Damping,
            D::RotaryDamping,
            D::Pressure,
            D::OilStiffness,
            D::Stiffness,
            D::Energy,
        ] {
            for unit in dimension.units() {
                let symbol = unit.symbol;
                let expected = Ok(unit.si(-12.5));
                assert_eq!(Dimension::of_unit(symbol), Some(dimension), "{symbol}");
                for text in [
                    format!("-12.5 {symbol}"),
                    format!(" -1.25e1  {symbol} "),
                    format!("-12.5{symbol}"),
                    format!("{{value: -12.5, unit: {symbol}}}"),
                ] {
                    let read: Quantity = serde_yaml_ng::from_str(&text).unwrap();
                    assert_eq!(read.si(dimension), expected, "{text}");
                }
            }
        }
    }

    #[test]
    fn a_unit_tells_its_dimension() {
        assert_eq!(quantity("8.04 cm^2").in_si(), Some((8.04 / 1e4, "m^2")));
        assert_eq!(quantity("30deg").in_si(), Some((30.0 * DEGREE, "rad")));
        for text in ["12", "12 stone", "m", "inf m", "auv"] {
            assert_eq!(quantity(text).in_si(), None, "{text}");
        }
    }

    #[test]
    fn a_quantity_without_its_unit_or_in_another_one_is_rejected_with_the_right_ones() {
        let reason = si(Dimension::Mass, "1 lbf").unwrap_err().to_string();
        let units = "kg, slug, lb s^2/in";
        assert_eq!(
            reason,
            format!("it must be a number with one of the units {units}")
        );
        for text in [
            "12",
            "12 psi",
            "twelve in",
            "in",
            "inf in",
            "NaN m",
            "1e999 m",
            "1e m",
            "",
        ] {
            assert!(si(Dimension::Length, text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_magnitude_of_no_valve_and_no_ship_is_rejected_and_so_is_what_lies_outside_a_field_s_range()
    {
        assert_eq!(si(Dimension::Mass, "-0 kg"), Ok(0.0));
        let reason = si(Dimension::Length, "1e308 m").unwrap_err().to_string();
        assert_eq!(reason, "its magnitude must be 0, or from 1e-9 to 1e10 m");
        for text in ["1e-300 m", "-1e11 m", "1e300 in"] {
            assert!(si(Dimension::Length, text).is_err(), "{text}");
        }
        let within = |text| quantity(text).within(Dimension::Time, &[], [0.0, 10.0]);
        assert_eq!(within("10 s"), Ok(10.0));
        let reason = within("1e300 s").unwrap_err().to_string();
        assert_eq!(reason, "it must be from 0 to 10 s");
        let reason = super::within(f64::NAN, [1.0, 2.0], "")
            .unwrap_err()
            .to_string();
        assert_eq!(reason, "it must be from 1 to 2");
    }

    #[test]
    fn a_field_may_accept_further_units() {
        let further = [Unit::new("rad", 2.0), Unit::new("deg", 2.0 * DEGREE)];
        let degree = quantity("1 deg");
        assert_eq!(degree.si_or(Dimension::Volume, &further), Ok(2.0 * DEGREE));
        assert!(degree.si(Dimension::Volume).is_err());
    }

    #[test]
    fn a_bare_argument_is_in_si() {
        let speed = |text: &str| quantity(text).argument(Dimension::Speed);
        assert_eq!(speed("0.5"), Ok(0.5));
        assert_eq!(speed("1ft/s"), Ok(FOOT));
        // A nautical mile an hour.
        for text in ["2kn", "2 knots", "2kt"] {
            assert_eq!(speed(text), Ok(2.0 * 1852.0 / 3600.0), "{text}");
        }
        assert_eq!(speed("36km/h"), Ok(10.0));
        for text in ["", "fast", "1 kg", "inf", "1e999"] {
            assert!(speed(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_no_quantity_is_rejected_by_what_is_missing() {
        let reason = |text: &str| {
            let read: Result<Quantity, _> = serde_yaml_ng::from_str(text);
            read.unwrap_err().to_string()
        };
        assert!(reason("{value: 1}").contains("unit"));
        assert!(reason("{value: 1, unit: m, per: s}").contains("per"));
        assert!(reason("[1, m]").contains("such as 28 in"));
        assert!(reason("true").contains("such as 28 in"));
    }
}
