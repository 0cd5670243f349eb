//! Units in the names of columns, or in a line below them.

/// Units that may end a column's name after `_`.
const UNITS: &[&str] = &[
    "s", "ms", "us", "ns", "sec", "msec", "usec", "nsec", "min", "h", "m", "cm", "mm", "km", "ft",
    "in", "nm", "kn", "kt", "kts", "mps", "kmh", "mph", "fps", "deg", "rad", "dps", "degs", "rads",
    "radps", "degps", "rpm", "Hz", "hz", "kHz", "g", "kg", "N", "kN", "Nm", "V", "mV", "v", "A",
    "mA", "W", "kW", "Ohm", "T", "uT", "G", "Pa", "hPa", "kPa", "MPa", "bar", "mbar", "psi", "C",
    "degC", "K", "F", "pct", "percent", "l", "L", "lpm", "lbf", "lb",
];

/// Units that occur below names only.
const MORE_UNITS: [&str; 25] = [
    "UTC",
    "knots",
    "kV",
    "%",
    "\u{b0}",
    "\u{b0}C",
    "\u{b5}s",
    "\u{fffd}",
    "\u{fffd}C",
    "grad",
    "unitless",
    "none",
    "1",
    "bool",
    "enum",
    "raw",
    "volt",
    "volts",
    "Volts",
    "seconds",
    "degrees",
    "radians",
    "TS",
    "RN",
    "Smp",
];

/// Whether a text is a unit, as in a line below the names: `deg/s`, `[m]`, `-`.
pub(crate) fn is_unit(text: &str) -> bool {
    let bare = text.trim_matches(['[', ']', '(', ')']);
    let is_one = |it: &str| {
        let it = it.trim_end_matches(|it: char| it.is_ascii_digit() || it == '-');
        it.is_empty() || UNITS.contains(&it) || MORE_UNITS.contains(&it)
    };
    bare.len() != text.len() || bare.split(['/', '*', '^', '\u{b7}', ' ']).all(is_one)
}

/// The name and the unit of a column `NAME [UNIT]`, `NAME (UNIT)` or `NAME_UNIT`.
pub(crate) fn with_unit(column: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        let unclosed = column.strip_suffix(close);
        if let Some((name, unit)) = unclosed.and_then(|it| it.rsplit_once(open)) {
            return (name.trim_end(), Some(unit.trim()));
        }
    }
    match column.rsplit_once('_') {
        Some((name, unit)) if !name.is_empty() && UNITS.contains(&unit) => (name, Some(unit)),
        _ => (column, None),
    }
}
