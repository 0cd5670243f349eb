//! Units of the page: one per quantity, in charts, parameters and setpoints. On the wire everything is in SI.

use std::collections::BTreeMap;

use planesman_units::{Dimension, Quantity, Unit};
use serde::Serialize;

use crate::Error;

/// SI units, and the units in which the page shows them.
const SHOWN: [(&str, &str); 3] = [("rad", "deg"), ("rad/s", "deg/s"), ("Pa", "kPa")];

/// The page's unit for an SI unit; `None` if the page shows the SI unit, as for a gain or a count.
fn shown(si: &str) -> Option<(Dimension, Unit)> {
    let dimension = Dimension::of_si_unit(si)?;
    let (_, symbol) = SHOWN.iter().find(|(it, _)| *it == si)?;
    let unit = dimension.units().iter().find(|it| it.symbol == *symbol)?;
    Some((dimension, *unit))
}

/// Symbol of the unit on the page.
pub(crate) fn symbol(si: &str) -> &str {
    shown(si).map_or(si, |(_, unit)| unit.symbol)
}

/// Converts a number from SI to the page's unit.
pub(crate) fn on_page(number: f64, si: &str) -> f64 {
    match shown(si) {
        // Twelve digits, as 30 degrees are no whole number of radians.
        Some((_, unit)) => {
            let text = format!("{:.11e}", unit.of_si(number));
            text.parse().unwrap_or(number)
        }
        None => number,
    }
}

/// Converts a text of the page to SI: a number in the page's unit, or with its own (`1ft`, `10 deg`).
///
/// # Errors
/// A sentence that says what is expected.
pub(crate) fn parse(text: &str, si: &str) -> Result<f64, Error> {
    let text = text.trim();
    let number = text.strip_suffix(symbol(si)).unwrap_or(text).trim_end();
    if let Ok(number) = number.parse::<f64>() {
        let number = shown(si).map_or(number, |(_, unit)| unit.si(number));
        return match number.is_finite() {
            true => Ok(number),
            false => Err(Error::NotFinite(text.to_owned())),
        };
    }
    let Some(dimension) = Dimension::of_si_unit(si) else {
        return Err(Error::Number(text.to_owned()));
    };
    let quantity: Quantity = text.parse().unwrap_or_default();
    quantity.si(dimension).map_err(|_| {
        let units: Vec<&str> = dimension.units().iter().map(|it| it.symbol).collect();
        Error::Unit {
            text: text.to_owned(),
            units: units.join(", "),
            unit: symbol(si).to_owned(),
        }
    })
}

/// A unit of the page: its symbol, and the factor from SI.
#[derive(Serialize)]
pub(crate) struct UnitLabel {
    symbol: &'static str,
    scale: f64,
}

/// The units that differ from SI, by SI unit.
pub(crate) fn told() -> BTreeMap<&'static str, UnitLabel> {
    let each = SHOWN.iter().filter_map(|(si, _)| Some((*si, shown(si)?.1)));
    each.map(|(si, unit)| {
        let told = UnitLabel {
            symbol: unit.symbol,
            scale: unit.of_si(1.0),
        };
        (si, told)
    })
    .collect()
}

/// Splits a description into its text and the unit at its end: `Speed [m/s]`.
pub(crate) fn described(description: &str) -> (&str, &str) {
    let unit = description
        .strip_suffix(']')
        .and_then(|it| it.rsplit_once(" ["));
    unit.unwrap_or((description, ""))
}

/// SI units of a message's own fields, from the comments of its definition: `float64 depth  # m, positive down`.
pub(crate) fn of_fields(definition: &str) -> BTreeMap<String, &'static str> {
    let own = definition.lines().take_while(|it| !it.starts_with("==="));
    own.filter_map(|line| {
        let (field, comment) = line.split_once('#')?;
        let name = field.split_whitespace().nth(1)?;
        let unit = comment.split(',').next()?.trim();
        let dimension = Dimension::of_si_unit(unit)?;
        Some((name.to_owned(), dimension.units()[0].symbol))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::Message as _;
    use planesman_msgs::planesman_msgs::msg::DhaState;

    #[test]
    fn a_number_is_in_the_units_of_the_page_and_may_bring_its_own() {
        let close = |text, si, expected: f64| {
            let found = parse(text, si).expect(text);
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        };
        close("1ft", "m", 0.3048);
        close("2", "m", 2.0);
        close("10deg", "rad", 0.174_532_925_199_432_95);
        close(" 10 ", "rad", 0.174_532_925_199_432_95);
        close("0.2 rad", "rad", 0.2);
        close("1e2 kPa", "Pa", 1e5);
        close("0.8", "rad/m", 0.8);
        close("0.8 rad/m", "rad/m", 0.8);
        close("3", "", 3.0);
        for (text, si) in [
            ("10deg", "m"),
            ("much", "m"),
            ("", "rad"),
            ("inf", "m"),
            ("x", ""),
        ] {
            assert!(parse(text, si).is_err(), "{text} {si}");
        }
        let refusal = parse("3 kg", "rad").expect_err("no angle").to_string();
        assert!(
            refusal.contains("rad, deg") && refusal.contains("in deg"),
            "{refusal}"
        );
    }

    #[test]
    fn what_the_page_has_reads_back() {
        let right = std::f64::consts::FRAC_PI_2;
        assert_eq!(on_page(right, "rad"), 90.0);
        assert!((parse("90", "rad").expect("an angle") - right).abs() < 1e-15);
        assert_eq!(on_page(0.3, "m"), 0.3);
        assert_eq!(symbol("rad/s"), "deg/s");
        assert_eq!(symbol("rad/m"), "rad/m");
    }

    #[test]
    fn the_unit_of_a_parameter_and_of_a_field_are_found_in_their_texts() {
        assert_eq!(
            described("Limit of the planes [rad]"),
            ("Limit of the planes", "rad")
        );
        assert_eq!(described("A share"), ("A share", ""));
        let fields = of_fields(DhaState::DEFINITION);
        assert_eq!(fields["plane_angle"], "rad");
        assert_eq!(fields["pressure"], "Pa");
        assert!(!fields.contains_key("pulses") && !fields.contains_key("group"));
    }
}
