//! Page that compares two recordings: the first difference, the topics, and time histories of differing fields.

use crate::diff::{Comparison, History};
use crate::plot::Plot;
use maud::html;

use crate::pages::{document, figures};

const TIME: &str = "time from the first stamp [s]";

/// The HTML page of a comparison.
#[must_use]
pub fn page(comparison: &Comparison, histories: &[History]) -> String {
    let [a, b] = &comparison.names;
    let headline = comparison.headline();
    let title = format!("{a} and {b}");
    let body = html! {
        h1 { (title) }
        ul.verdict { li { (headline) "." } }
        p.lead { "A: " (a) ". B: " (b) "." }
        @for remark in comparison.remarks() { p.warn { (remark) "." } }
        h2 { @if comparison.is_table { "Columns" } @else { "Topics" } }
        (comparison.short_table().html())
        @if !histories.is_empty() {
            h2 { "Differing fields" }
            @for history in histories { (figures(&plots(history))) }
        }
    };
    document(&title, "", &body, "")
}

/// Plots of a field's values and of their difference.
fn plots(history: &History) -> [Plot<'_>; 2] {
    let name = match &*history.field {
        "" => history.topic.clone(),
        field => format!("{} {field}", history.topic),
    };
    let [a, b] = &history.values;
    let values = Plot::new(name.clone(), [TIME, "value"]).linked("diff");
    let difference = Plot::new(format!("{name}: difference"), [TIME, "B less A"]).linked("diff");
    [
        values
            .line("A", a.iter().copied())
            .dashed("B", b.iter().copied()),
        difference.line("B less A", history.difference.iter().copied()),
    ]
}
