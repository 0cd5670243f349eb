//! Physical quantities as an actuator file writes them: a number and its unit, `26600 lb/in^5`.
//!
//! Both reports are in inches, pounds (force) and seconds; the models are in SI. Here is the
//! only place where one becomes the other. `lb` is the pound of force throughout, so that a
//! mass is in `lb s^2/in`, as in IBM 66-L03-005.

use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::fmt;

/// Metres in an inch.
pub const INCH: f64 = 0.0254;
/// Newtons in a pound of force.
pub const POUND: f64 = 4.448_221_615_260_5;
/// Pascals in a pound of force per square inch.
pub const PSI: f64 = POUND / (INCH * INCH);
/// Radians in a degree.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A number with its unit, not yet read: what kind of quantity it is, its field decides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written(pub String);

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // A bare number is let through, to be refused where the field's units are known.
        struct Scalar;
        impl Visitor<'_> for Scalar {
            type Value = Written;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number with its unit")
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Written, E> {
                Ok(Written(text.to_owned()))
            }
            fn visit_i64<E: Error>(self, number: i64) -> Result<Written, E> {
                Ok(Written(number.to_string()))
            }
            fn visit_u64<E: Error>(self, number: u64) -> Result<Written, E> {
                Ok(Written(number.to_string()))
            }
            fn visit_f64<E: Error>(self, number: f64) -> Result<Written, E> {
                Ok(Written(number.to_string()))
            }
        }
        deserializer.deserialize_any(Scalar)
    }
}

/// What a quantity measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Plane angle, rad.
    Angle,
    /// Length, m.
    Length,
    /// Area, m^2.
    Area,
    /// Volume, m^3.
    Volume,
    /// Flow of volume, m^3/s.
    Flow,
    /// Force, N.
    Force,
    /// Mass, kg.
    Mass,
    /// Viscous damping, N s/m.
    Damping,
    /// Pressure, Pa.
    Pressure,
    /// Pressure for a volume squeezed in, Pa/m^3.
    OilStiffness,
    /// Time, s.
    Time,
    /// Frequency, Hz.
    Frequency,
}

impl Dimension {
    /// The units it may be written in, each with its SI value.
    #[must_use]
    pub fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Angle => &[("rad", 1.0), ("deg", DEGREE)],
            Self::Length => &[("m", 1.0), ("mm", 1e-3), ("in", INCH)],
            Self::Area => &[("m^2", 1.0), ("mm^2", 1e-6), ("in^2", INCH * INCH)],
            Self::Volume => &[("m^3", 1.0), ("mm^3", 1e-9), ("in^3", INCH * INCH * INCH)],
            Self::Flow => &[
                ("m^3/s", 1.0),
                ("mm^3/s", 1e-9),
                ("in^3/s", INCH * INCH * INCH),
            ],
            Self::Force => &[("N", 1.0), ("lb", POUND)],
            Self::Mass => &[("kg", 1.0), ("lb s^2/in", POUND / INCH)],
            Self::Damping => &[("N s/m", 1.0), ("lb s/in", POUND / INCH)],
            Self::Pressure => &[("Pa", 1.0), ("MPa", 1e6), ("psi", PSI)],
            Self::OilStiffness => &[("Pa/m^3", 1.0), ("lb/in^5", PSI / (INCH * INCH * INCH))],
            Self::Time => &[("s", 1.0), ("ms", 1e-3)],
            Self::Frequency => &[("Hz", 1.0)],
        }
    }

    /// The quantity in SI.
    ///
    /// `per_radian` is the quantity that moves the planes by one radian (per second, for a
    /// flow), where the field may also be given as that angle; `None` where it may not.
    ///
    /// # Errors
    /// The rule that `written` breaks: not a number, not finite, no unit or a foreign one.
    pub fn read(self, written: &Written, per_radian: Option<f64>) -> Result<f64, String> {
        let text = written.0.trim();
        let (number, unit) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let unit = unit.trim();
        let equivalents: [(&str, f64); 2] = match (per_radian, self) {
            (Some(v), Self::Flow) => [("rad/s", v), ("deg/s", v * DEGREE)],
            (Some(v), _) => [("rad", v), ("deg", v * DEGREE)],
            (None, _) => [("", f64::NAN); 2],
        };
        let mut accepted = self
            .units()
            .iter()
            .chain(&equivalents[..if per_radian.is_some() { 2 } else { 0 }]);
        let Some((_, si)) = accepted.clone().find(|(name, _)| *name == unit) else {
            let names: Vec<&str> = accepted.by_ref().map(|(name, _)| *name).collect();
            return Err(format!(
                "it must be a number and one of the units {}",
                names.join(", ")
            ));
        };
        let number: f64 = number
            .parse()
            .map_err(|_| format!("'{number}' is not a number"))?;
        // Milliseconds and the like are divided, so that 5.5 ms is the same number as 0.0055 s.
        let value = match si {
            1e-3 => number / 1e3,
            1e-6 => number / 1e6,
            1e-9 => number / 1e9,
            si => number * si,
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err("it must be finite".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(dimension: Dimension, text: &str) -> Result<f64, String> {
        dimension.read(&Written(text.to_owned()), None)
    }

    #[test]
    fn the_flight_actuators_table_4_1_in_si() {
        let close = |dimension, text, si: f64| {
            let value = read(dimension, text).expect("read");
            assert!((value / si - 1.0).abs() < 5e-4, "{text}: {value} vs {si}");
        };
        close(Dimension::Force, "600 lb", 2669.0);
        close(Dimension::Mass, "0.296 lb s^2/in", 51.84);
        close(Dimension::OilStiffness, "26600 lb/in^5", 1.1192e13);
        close(Dimension::Damping, "12 lb s/in", 2101.5);
        close(Dimension::Pressure, "750 psi", 5.171e6);
        close(Dimension::Volume, "0.152 in^3", 2.4908e-6);
        assert_eq!(read(Dimension::Time, "5.5 ms"), Ok(0.0055));
    }

    #[test]
    fn a_quantity_without_its_unit_or_in_another_one_is_refused() {
        for text in ["12", "12 psi", "twelve in", "inf in", "NaN m", ""] {
            assert!(read(Dimension::Length, text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_volume_may_be_given_as_the_angle_it_makes() {
        let degree = Written("1 deg".to_owned());
        assert_eq!(Dimension::Volume.read(&degree, Some(2.0)), Ok(2.0 * DEGREE));
        assert!(Dimension::Volume.read(&degree, None).is_err());
    }
}
