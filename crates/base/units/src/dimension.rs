//! Dimensions, and the units of each.
//!
//! The foot, the inch and the pound-force are exact by definition (NIST SP 811, App. B); the slug is
//! 1 lbf s^2/ft. `lb` can also mean the pound-force, as in IBM 66-L03-005, where a mass is in `lb s^2/in`.

/// Metres in a foot.
pub const FOOT: f64 = 0.3048;
/// Metres in an inch.
pub const INCH: f64 = 0.0254;
/// Metres per second in a knot: a nautical mile of 1852 m an hour (NIST SP 811, App. B).
pub const KNOT: f64 = 1852.0 / 3600.0;
/// Newtons in a pound-force.
pub const POUND_FORCE: f64 = 4.448_221_615_260_5;
/// Newton metres in a foot-pound, joules as well.
pub const FOOT_POUND: f64 = FOOT * POUND_FORCE;
/// Kilograms in a slug.
pub const SLUG: f64 = 14.593_902_94;
/// Pascals in a pound-force per square inch.
pub const PSI: f64 = POUND_FORCE / (INCH * INCH);
/// Radians in a degree.
pub const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A unit of a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Symbol.
    pub symbol: &'static str,
    multiplier: f64,
    divisor: f64,
}

impl Unit {
    /// A unit of `multiplier` SI units.
    #[must_use]
    pub const fn new(symbol: &'static str, multiplier: f64) -> Self {
        Self {
            symbol,
            multiplier,
            divisor: 1.0,
        }
    }

    /// A unit of which `divisor` make one SI unit. Division rounds correctly: 5.5 ms is 0.0055 s.
    #[must_use]
    pub const fn fraction(symbol: &'static str, divisor: f64) -> Self {
        Self {
            symbol,
            multiplier: 1.0,
            divisor,
        }
    }

    /// Converts a number from SI to this unit.
    #[must_use]
    pub fn of_si(self, number: f64) -> f64 {
        number * self.divisor / self.multiplier
    }

    /// Converts a number from this unit to SI.
    #[must_use]
    pub fn si(self, number: f64) -> f64 {
        number * self.multiplier / self.divisor
    }
}

/// Other spellings of units.
const SPELLINGS: [(&str, &str); 7] = [
    ("knot", "kn"),
    ("knots", "kn"),
    ("kt", "kn"),
    ("kts", "kn"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("\u{b0}", "deg"),
];

/// Symbol of a unit, for any of its spellings.
pub(crate) fn symbol(spelt: &str) -> &str {
    let known = SPELLINGS.iter().find(|(other, _)| *other == spelt);
    known.map_or(spelt, |(_, symbol)| symbol)
}

/// A unit as `SYMBOL = SI VALUE` or `SYMBOL / NUMBER PER SI UNIT`.
macro_rules! unit {
    ($symbol:literal = $multiplier:expr) => {
        Unit::new($symbol, $multiplier)
    };
    ($symbol:literal / $divisor:expr) => {
        Unit::fraction($symbol, $divisor)
    };
}

macro_rules! dimensions {
    ($(#[doc = $doc:literal] $name:ident: $($symbol:literal $sign:tt $factor:expr),+;)+) => {
        /// Dimension of a quantity.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Dimension {
            $(#[doc = $doc] $name,)+
        }

        impl Dimension {
            const ALL: &[Self] = &[$(Self::$name),+];

            /// The units of this dimension, the SI unit first.
            #[must_use]
            pub fn units(self) -> &'static [Unit] {
                match self {
                    $(Self::$name => const { &[$(unit!($symbol $sign $factor)),+] },)+
                }
            }
        }
    };
}

dimensions! {
    /// Plane angle, rad.
    Angle: "rad" = 1.0, "deg" = DEGREE;
    /// Angular rate, rad/s.
    Rate: "rad/s" = 1.0, "deg/s" = DEGREE;
    /// Length, m.
    Length: "m" = 1.0, "cm" / 1e2, "mm" / 1e3, "in" = INCH, "ft" = FOOT;
    /// Area, m^2.
    Area: "m^2" = 1.0, "cm^2" / 1e4, "mm^2" / 1e6, "in^2" = INCH * INCH, "ft^2" = FOOT * FOOT;
    /// Volume, m^3.
    Volume: "m^3" = 1.0, "L" / 1e3, "cm^3" / 1e6, "mm^3" / 1e9, "in^3" = INCH * INCH * INCH, "ft^3" = FOOT * FOOT * FOOT;
    /// Volume flow, m^3/s.
    Flow: "m^3/s" = 1.0, "L/min" / 6e4, "mm^3/s" / 1e9, "in^3/s" = INCH * INCH * INCH;
    /// Speed, m/s.
    Speed: "m/s" = 1.0, "ft/s" = FOOT, "kn" = KNOT, "km/h" / 3.6;
    /// Acceleration, m/s^2.
    Acceleration: "m/s^2" = 1.0, "ft/s^2" = FOOT;
    /// Time, s.
    Time: "s" = 1.0, "ms" / 1e3;
    /// Frequency, Hz.
    Frequency: "Hz" = 1.0;
    /// Mass, kg.
    Mass: "kg" = 1.0, "slug" = SLUG, "lb s^2/in" = POUND_FORCE / INCH;
    /// Moment of inertia, kg m^2.
    Inertia: "kg m^2" = 1.0, "ft lbf s^2" = FOOT_POUND;
    /// Density, kg/m^3.
    Density: "kg/m^3" = 1.0, "slug/ft^3" = SLUG / (FOOT * FOOT * FOOT);
    /// Kinematic viscosity, m^2/s.
    Viscosity: "m^2/s" = 1.0, "mm^2/s" / 1e6, "ft^2/s" = FOOT * FOOT;
    /// Force, N.
    Force: "N" = 1.0, "kN" = 1e3, "lbf" = POUND_FORCE, "lb" = POUND_FORCE;
    /// Moment, N m; also per radian.
    Moment: "N m" = 1.0, "ft lbf" = FOOT_POUND;
    /// Viscous damping of a translation, N s/m.
    Damping: "N s/m" = 1.0, "lb s/in" = POUND_FORCE / INCH;
    /// Viscous damping of a rotation, N m s (per radian).
    RotaryDamping: "N m s" = 1.0, "ft lbf s" = FOOT_POUND;
    /// Pressure, Pa.
    Pressure: "Pa" = 1.0, "kPa" = 1e3, "bar" = 1e5, "MPa" = 1e6, "GPa" = 1e9, "psi" = PSI;
    /// Stiffness of enclosed oil, Pa/m^3: pressure per volume forced in.
    OilStiffness: "Pa/m^3" = 1.0, "lb/in^5" = PSI / (INCH * INCH * INCH);
    /// Stiffness of a spring, N/m.
    Stiffness: "N/m" = 1.0, "lb/in" = POUND_FORCE / INCH;
    /// Energy, J.
    Energy: "J" = 1.0, "mJ" / 1e3;
}

impl Dimension {
    /// The dimension with this SI unit, such as `m/s`.
    #[must_use]
    pub fn of_si_unit(symbol: &str) -> Option<Self> {
        let is_its = |dimension: &Self| dimension.units()[0].symbol == symbol;
        Self::ALL.iter().copied().find(is_its)
    }

    /// The dimension with this unit; no two dimensions share a unit.
    pub(crate) fn of_unit(symbol: &str) -> Option<Self> {
        let has = |dimension: &Self| dimension.units().iter().any(|unit| unit.symbol == symbol);
        Self::ALL.iter().copied().find(has)
    }

    /// Smallest non-zero and largest plausible magnitude of a quantity in a file or option, SI: from a valve to a ship. Numbers outside are mistakes,
    /// with which a computation would overflow or never end.
    #[must_use]
    pub const fn magnitudes(self) -> [f64; 2] {
        match self {
            Self::Angle | Self::Rate => [1e-9, 1e4],
            Self::Area | Self::Volume | Self::Flow => [1e-18, 1e9],
            Self::Density | Self::Viscosity => [1e-12, 1e6],
            Self::OilStiffness => [1e-3, 1e21],
            Self::Length | Self::Speed | Self::Acceleration | Self::Time | Self::Frequency => {
                [1e-9, 1e10]
            }
            _ => [1e-12, 1e18],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slug_is_a_pound_force_second_squared_per_foot() {
        assert!((SLUG - POUND_FORCE / FOOT).abs() < 1e-8);
    }
}
