//! Units in FMI: exponents of the base units of SI.

/// The base units of FMI that are used.
const BASE: [&str; 5] = ["kg", "m", "s", "A", "rad"];

/// Derived units: exponents of [`BASE`].
const DERIVED: [(&str, [i32; 5]); 6] = [
    ("N", [1, 1, -2, 0, 0]),
    ("Pa", [1, -1, -2, 0, 0]),
    ("J", [1, 2, -2, 0, 0]),
    ("W", [1, 2, -3, 0, 0]),
    ("V", [1, 2, -3, -1, 0]),
    ("Hz", [0, 0, -1, 0, 0]),
];

/// The exponents of a unit in the notation of parameters and messages: `N m s^2`, `kg/m^3`. `None` for an unknown unit.
fn exponents(unit: &str) -> Option<[i32; 5]> {
    let mut found = [0; 5];
    for (place, part) in unit.split('/').enumerate() {
        let sign = if place == 0 { 1 } else { -1 };
        for factor in part.split_whitespace() {
            let (symbol, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let power: i32 = power.parse().ok()?;
            let base = BASE.iter().position(|it| *it == symbol);
            let derived = DERIVED.iter().find(|it| it.0 == symbol).map(|it| it.1);
            let of = base
                .map(|at| std::array::from_fn(|i| i32::from(i == at)))
                .or(derived)?;
            for (sum, one) in found.iter_mut().zip(of) {
                *sum += sign * power * one;
            }
        }
    }
    Some(found)
}

/// The definition of a unit in `UnitDefinitions`, with degrees in addition to radians; an unknown unit has only its name.
pub(crate) fn definition(unit: &str) -> String {
    let base = exponents(unit).map_or_else(String::new, |exponents| {
        let named = BASE.iter().zip(exponents).filter(|it| it.1 != 0);
        let named = named.map(|(base, power)| format!(" {base}=\"{power}\""));
        format!("<BaseUnit{}/>", named.collect::<String>())
    });
    let display = match unit.strip_prefix("rad") {
        Some(per) if per.is_empty() || per.starts_with('/') => {
            let factor = 180.0 / std::f64::consts::PI;
            format!("<DisplayUnit name=\"deg{per}\" factor=\"{factor:?}\"/>")
        }
        _ => String::new(),
    };
    format!("<Unit name=\"{unit}\">{base}{display}</Unit>")
}
