//! Dimensions, and the units of each.
//!
//! The foot, the inch and the pound-force are exact by definition (NIST SP 811, App. B); the slug is
//! 1 lbf s^2/ft. `lb` is the pound-force too, as in IBM 66-L03-005, where a mass is in `lb s^2/in`.

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

/// A unit of some dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// How it is written.
    pub symbol: &'static str,
    multiplier: f64,
    divisor: f64,
}

impl Unit {
    /// The unit that is `multiplier` SI units.
    #[must_use]
    pub const fn new(symbol: &'static str, multiplier: f64) -> Self {
        Self {
            symbol,
            multiplier,
            divisor: 1.0,
        }
    }

    /// The unit of which `divisor` make an SI unit. Division rounds correctly: 5.5 ms is 0.0055 s.
    #[must_use]
    pub const fn fraction(symbol: &'static str, divisor: f64) -> Self {
        Self {
            symbol,
            multiplier: 1.0,
            divisor,
        }
    }

    /// A number in SI as so many of this unit.
    #[must_use]
    pub fn of_si(self, number: f64) -> f64 {
        number * self.divisor / self.multiplier
    }

    /// So many of this unit in SI.
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

/// The symbol of a unit, however it is spelt.
pub(crate) fn symbol(spelt: &str) -> &str {
    let known = SPELLINGS.iter().find(|(other, _)| *other == spelt);
    known.map_or(spelt, |(_, symbol)| symbol)
}

/// The dimension of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Plane angle, rad.
    Angle,
    /// Turning rate, rad/s.
    Rate,
    /// Length, m.
    Length,
    /// Area, m^2.
    Area,
    /// Volume, m^3.
    Volume,
    /// Flow of volume, m^3/s.
    Flow,
    /// Speed, m/s.
    Speed,
    /// Acceleration, m/s^2.
    Acceleration,
    /// Time, s.
    Time,
    /// Frequency, Hz.
    Frequency,
    /// Mass, kg.
    Mass,
    /// Moment of inertia, kg m^2.
    Inertia,
    /// Density, kg/m^3.
    Density,
    /// Kinematic viscosity, m^2/s.
    Viscosity,
    /// Force, N.
    Force,
    /// Moment, N m; per radian too.
    Moment,
    /// Viscous damping of a translation, N s/m.
    Damping,
    /// Viscous damping of a rotation, N m s (per radian).
    RotaryDamping,
    /// Pressure, Pa.
    Pressure,
    /// Stiffness of enclosed oil, Pa/m^3: pressure per volume pressed in.
    OilStiffness,
    /// Stiffness of a spring, N/m.
    Stiffness,
    /// Energy, J.
    Energy,
}

impl Dimension {
    /// All of them.
    const ALL: [Self; 22] = [
        Self::Angle,
        Self::Rate,
        Self::Length,
        Self::Area,
        Self::Volume,
        Self::Flow,
        Self::Speed,
        Self::Acceleration,
        Self::Time,
        Self::Frequency,
        Self::Mass,
        Self::Inertia,
        Self::Density,
        Self::Viscosity,
        Self::Force,
        Self::Moment,
        Self::Damping,
        Self::RotaryDamping,
        Self::Pressure,
        Self::OilStiffness,
        Self::Stiffness,
        Self::Energy,
    ];

    /// The dimension whose SI unit is written so, as `m/s`.
    #[must_use]
    pub fn of_si_unit(symbol: &str) -> Option<Self> {
        let is_its = |dimension: &Self| dimension.units()[0].symbol == symbol;
        Self::ALL.into_iter().find(is_its)
    }

    /// The dimension that has a unit of this symbol: no two have the same.
    pub(crate) fn of_unit(symbol: &str) -> Option<Self> {
        let has = |dimension: &Self| dimension.units().iter().any(|unit| unit.symbol == symbol);
        Self::ALL.into_iter().find(has)
    }

    /// The smallest magnitude beside 0 and the largest, SI, of any quantity that a file or an option gives: from a valve to a
    /// ship. Beyond them a number is a slip, with which a computation would overflow or never end.
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

    /// The units a quantity of this dimension may have, the SI unit first.
    #[must_use]
    pub fn units(self) -> &'static [Unit] {
        use Unit as U;
        match self {
            Self::Angle => const { &[U::new("rad", 1.0), U::new("deg", DEGREE)] },
            Self::Rate => const { &[U::new("rad/s", 1.0), U::new("deg/s", DEGREE)] },
            Self::Length => {
                const {
                    &[
                        U::new("m", 1.0),
                        U::fraction("cm", 1e2),
                        U::fraction("mm", 1e3),
                        U::new("in", INCH),
                        U::new("ft", FOOT),
                    ]
                }
            }
            Self::Area => {
                const {
                    &[
                        U::new("m^2", 1.0),
                        U::fraction("cm^2", 1e4),
                        U::fraction("mm^2", 1e6),
                        U::new("in^2", INCH * INCH),
                        U::new("ft^2", FOOT * FOOT),
                    ]
                }
            }
            Self::Volume => {
                const {
                    &[
                        U::new("m^3", 1.0),
                        U::fraction("L", 1e3),
                        U::fraction("cm^3", 1e6),
                        U::fraction("mm^3", 1e9),
                        U::new("in^3", INCH * INCH * INCH),
                        U::new("ft^3", FOOT * FOOT * FOOT),
                    ]
                }
            }
            Self::Flow => {
                const {
                    &[
                        U::new("m^3/s", 1.0),
                        U::fraction("L/min", 6e4),
                        U::fraction("mm^3/s", 1e9),
                        U::new("in^3/s", INCH * INCH * INCH),
                    ]
                }
            }
            Self::Speed => {
                const {
                    &[
                        U::new("m/s", 1.0),
                        U::new("ft/s", FOOT),
                        U::new("kn", KNOT),
                        U::fraction("km/h", 3.6),
                    ]
                }
            }
            Self::Acceleration => const { &[U::new("m/s^2", 1.0), U::new("ft/s^2", FOOT)] },
            Self::Time => const { &[U::new("s", 1.0), U::fraction("ms", 1e3)] },
            Self::Frequency => const { &[U::new("Hz", 1.0)] },
            Self::Mass => {
                const {
                    &[
                        U::new("kg", 1.0),
                        U::new("slug", SLUG),
                        U::new("lb s^2/in", POUND_FORCE / INCH),
                    ]
                }
            }
            Self::Inertia => const { &[U::new("kg m^2", 1.0), U::new("ft lbf s^2", FOOT_POUND)] },
            Self::Density => {
                const {
                    &[
                        U::new("kg/m^3", 1.0),
                        U::new("slug/ft^3", SLUG / (FOOT * FOOT * FOOT)),
                    ]
                }
            }
            Self::Viscosity => {
                const {
                    &[
                        U::new("m^2/s", 1.0),
                        U::fraction("mm^2/s", 1e6),
                        U::new("ft^2/s", FOOT * FOOT),
                    ]
                }
            }
            Self::Force => {
                const {
                    &[
                        U::new("N", 1.0),
                        U::new("kN", 1e3),
                        U::new("lbf", POUND_FORCE),
                        U::new("lb", POUND_FORCE),
                    ]
                }
            }
            Self::Moment => const { &[U::new("N m", 1.0), U::new("ft lbf", FOOT_POUND)] },
            Self::Damping => {
                const { &[U::new("N s/m", 1.0), U::new("lb s/in", POUND_FORCE / INCH)] }
            }
            Self::RotaryDamping => {
                const { &[U::new("N m s", 1.0), U::new("ft lbf s", FOOT_POUND)] }
            }
            Self::Pressure => {
                const {
                    &[
                        U::new("Pa", 1.0),
                        U::new("kPa", 1e3),
                        U::new("bar", 1e5),
                        U::new("MPa", 1e6),
                        U::new("GPa", 1e9),
                        U::new("psi", PSI),
                    ]
                }
            }
            Self::Stiffness => const { &[U::new("N/m", 1.0), U::new("lb/in", POUND_FORCE / INCH)] },
            Self::OilStiffness => {
                const {
                    &[
                        U::new("Pa/m^3", 1.0),
                        U::new("lb/in^5", PSI / (INCH * INCH * INCH)),
                    ]
                }
            }
            Self::Energy => const { &[U::new("J", 1.0), U::fraction("mJ", 1e3)] },
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
