//! Table of a model's poles with 95 % intervals; artefacts of sampling are marked.

use maud::{Markup, html};
use planesman_identification::{Reading, SIGMAS_95, Uncertain};
use planesman_linear::digits::with_interval;
use planesman_linear::{ComplexFunctions as _, is_sampling_artefact};

use planesman_console::Table;

/// Remark on a pole that the samples cannot determine.
pub(crate) const ARTEFACT: &str = "artefact of sampling";

/// Explanation of the remark, below the table.
pub(crate) const NOTE: &str = "An artefact of sampling is a pole at half the sampling rate or faster: the sampled model needs such a pole, but the data does not show whether the system has it.";

/// The table with its explanation, each cell formatted by a callback; nothing for models without poles.
pub(crate) fn table_with_note(
    models: &[(&str, Reading<'_>)],
    cell: impl Fn(&str) -> Markup,
) -> Markup {
    let table = table(models);
    let has_artefact = table.cells().any(|it| it == ARTEFACT);
    html! {
        @if !table.is_empty() {
            (table.html_with(cell))
            p { "Poles with their 95 % intervals; a complex pair has one row." @if has_artefact { " " (NOTE) } }
        }
    }
}

/// Table of the poles of models, in z and in s, each pair once.
fn table(models: &[(&str, Reading<'_>)]) -> Table {
    let names: &[&str] = if models.len() > 1 { &["model"] } else { &[] };
    let columns = ["pole in z", "pole in s [1/s]", "what it does"];
    let mut table = Table::of(names.iter().copied().chain(columns));
    for (name, reading) in models {
        let poles = reading.slowest_first().unwrap_or_default();
        // A finite impulse response has poles at 0 alone.
        if poles.iter().all(|it| it.value.modulus() == 0.0) {
            continue;
        }
        for pole in poles {
            let s = reading.in_s(&pole);
            let does = match &s {
                Some(s) if !is_sampling_artefact(pole.value) => s.mode_text(),
                _ => ARTEFACT.to_owned(),
            };
            // The logarithm of a negative pole is no system's.
            let s = s.filter(|_| pole.value.im != 0.0 || pole.value.re > 0.0);
            let s = s.map_or_else(|| "none".to_owned(), |it| text(&it));
            let cells = [text(&pole), s, does];
            let name = names.iter().map(|_| (*name).to_owned());
            table.row(name.chain(cells));
        }
    }
    table
}

/// A pole with its 95 % interval; for a complex pair, the pole with positive imaginary part.
pub(crate) fn text(pole: &Uncertain) -> String {
    let real = interval(pole.value.re, pole.real_deviation());
    match pole.value.im {
        0.0 => real,
        im => format!("{real}, ± ({}) i", interval(im, pole.imaginary_deviation())),
    }
}

/// A value with its 95 % interval; the value alone if the interval is unknown.
fn interval(value: f64, deviation: f64) -> String {
    with_interval(value, SIGMAS_95 * deviation)
}

#[cfg(test)]
mod tests {
    use planesman_msgs::planesman_msgs::msg::ModelEstimate;

    use super::*;
    use planesman_console::Format;

    #[test]
    fn a_pole_near_zero_is_an_artefact_and_each_has_its_interval() {
        // (z - 0.9)(z - 0.01), the coefficients with a standard deviation of a thousandth.
        let mut model = ModelEstimate {
            sample_time: 0.1,
            a: vec![-0.91, 0.009],
            b: vec![0.1, 0.0],
            covariance: vec![0.0; 16],
            ..ModelEstimate::default()
        };
        for place in 0..4 {
            model.covariance[5 * place] = 1e-6;
        }
        let estimate = planesman_identifier::estimate_of(&model).unwrap();
        let text = table(&[("", Reading::new(&estimate, 0))]);
        let text = text.text(Format::Csv);
        let rows: Vec<&str> = text.lines().skip(1).collect();
        // dp/da1 = -p/(p - 0.01), dp/da2 = -1/(p - 0.01): 1.9600e-3 sqrt(0.9^2 + 1)/0.89 = 0.0030; of s the same over p T, 0.0329;
        // of the time constant that over s^2, 0.0297.
        assert_eq!(
            rows[0],
            "0.9000 ± 0.0030,-1.054 ± 0.033,time constant 0.949 ± 0.030 s"
        );
        assert!(rows[1].starts_with("0.0100 ± 0.0022,-46.1 ± 2.2"), "{text}");
        assert!(rows[1].ends_with(ARTEFACT), "{text}");
    }
}
