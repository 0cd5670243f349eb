//! Numbers with their units, as vehicle files write them: `{value: 28, unit: in}`.
//!
//! Imperial values convert here and nowhere else. The foot, the inch and the pound-force are
//! exact by definition (NIST SP 811, App. B); the slug is 1 lbf s^2/ft.

use std::fmt;

use serde::Deserialize;

/// Metres in a foot.
pub const FOOT: f64 = 0.3048;
/// Metres in an inch.
pub const INCH: f64 = 0.0254;
/// Newtons in a pound-force.
pub const POUND_FORCE: f64 = 4.448_221_615_260_5;
/// Kilograms in a slug.
pub const SLUG: f64 = 14.593_902_94;

/// What a quantity measures: the units it may be given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Metres, or what converts to them.
    Length,
    /// Kilograms, or what converts to them.
    Mass,
    /// Newtons, or what converts to them.
    Force,
    /// Square metres, or what converts to them.
    Area,
    /// Cubic metres, or what converts to them.
    Volume,
    /// Kilograms per cubic metre, or what converts to them.
    Density,
    /// Kinematic: square metres per second, or what converts to them.
    Viscosity,
    /// Metres per second, or what converts to them.
    Speed,
    /// Metres per second squared, or what converts to them.
    Acceleration,
    /// Radians per second, or what converts to them.
    Rate,
    /// Seconds, or what converts to them.
    Time,
    /// Newton metres, or what converts to them; per radian too.
    Moment,
    /// Kilogram square metres, or what converts to them.
    Inertia,
    /// Newton metre seconds (per radian), or what converts to them.
    RotaryDamping,
}

impl Dimension {
    /// The units and their size in SI.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Length => &[
                ("m", 1.0),
                ("cm", 0.01),
                ("mm", 0.001),
                ("in", INCH),
                ("ft", FOOT),
            ],
            Self::Mass => &[("kg", 1.0), ("slug", SLUG)],
            Self::Force => &[("N", 1.0), ("lbf", POUND_FORCE)],
            Self::Area => &[
                ("m^2", 1.0),
                ("cm^2", 1e-4),
                ("in^2", INCH * INCH),
                ("ft^2", FOOT * FOOT),
            ],
            Self::Volume => &[
                ("m^3", 1.0),
                ("L", 1e-3),
                ("in^3", INCH * INCH * INCH),
                ("ft^3", FOOT * FOOT * FOOT),
            ],
            Self::Density => &[("kg/m^3", 1.0), ("slug/ft^3", SLUG / (FOOT * FOOT * FOOT))],
            Self::Viscosity => &[("m^2/s", 1.0), ("ft^2/s", FOOT * FOOT)],
            Self::Speed => &[("m/s", 1.0), ("ft/s", FOOT)],
            Self::Acceleration => &[("m/s^2", 1.0), ("ft/s^2", FOOT)],
            Self::Rate => &[("rad/s", 1.0), ("deg/s", std::f64::consts::PI / 180.0)],
            Self::Time => &[("s", 1.0), ("ms", 1e-3)],
            Self::Moment => &[("N m", 1.0), ("ft lbf", FOOT * POUND_FORCE)],
            Self::Inertia => &[("kg m^2", 1.0), ("ft lbf s^2", FOOT * POUND_FORCE)],
            Self::RotaryDamping => &[("N m s", 1.0), ("ft lbf s", FOOT * POUND_FORCE)],
        }
    }
}

/// A number with its unit.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// The unit's symbol.
    pub unit: String,
}

impl Quantity {
    /// The value in SI.
    ///
    /// # Errors
    /// What is wrong and what would be right, when the value is not finite or the unit is none
    /// of the dimension's.
    pub fn si(&self, dimension: Dimension) -> Result<f64, String> {
        let units = dimension.units();
        let Some((_, size)) = units.iter().find(|(symbol, _)| *symbol == self.unit) else {
            let known: Vec<&str> = units.iter().map(|(symbol, _)| *symbol).collect();
            return Err(format!(
                "unit '{}' is none of {}",
                self.unit.escape_debug(),
                known.join(", ")
            ));
        };
        let si = self.value * size;
        if si.is_finite() {
            Ok(si)
        } else {
            Err(format!("{self} is not finite"))
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.value, self.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(value: f64, unit: &str) -> Quantity {
        Quantity {
            value,
            unit: unit.to_owned(),
        }
    }

    #[test]
    fn twenty_eight_inches_are_0_7112_metres() {
        let metres = quantity(28.0, "in")
            .si(Dimension::Length)
            .expect("a length");
        assert!((metres - 0.7112).abs() < 1e-15);
    }

    #[test]
    fn a_slug_is_a_pound_force_second_squared_per_foot() {
        assert!((SLUG - POUND_FORCE / FOOT).abs() < 1e-8);
    }

    #[test]
    fn a_unit_of_another_dimension_is_refused_with_the_right_ones() {
        let refusal = quantity(1.0, "lbf")
            .si(Dimension::Mass)
            .expect_err("no mass");
        assert_eq!(refusal, "unit 'lbf' is none of kg, slug");
        assert!(quantity(f64::INFINITY, "kg").si(Dimension::Mass).is_err());
    }
}
