//! Results as self-contained HTML pages: text, tables, and plots that the reader's browser draws.
//!
//! Each page is a function of results; it reads and writes no files.
//!
//! - [`flights`]: a dive, or a comparison of several; [`sweep`]: the cases of a sweep.
//! - [`fit`]: a model; [`several`]: a model with several inputs and outputs; [`compare`]: a comparison of models; [`tables`]: the same results as
//!   tables for a terminal.
//! - [`equations`]: user-written state equations; [`continuous`]: a continuous-time transfer function; both also as text for a terminal.
//! - [`tuning`]: gains for a model, also as text for a terminal.
//! - [`review`]: data, model, validation, margins and robustness on one page, each number with its samples (`evidence`).
//! - [`diff`]: a comparison of two recordings.
//! - [`coefficients`]: a vehicle's coefficients, as tables for a terminal.
//! - `cards`: the verdict and its main numbers, at the top of a page.
//! - [`document`], [`figures`]: any other page, and the plots on it.

use crate::plot::{HeatMap, PAGE, PLOTS, Plot, PlotError, THEME, THEME_SCRIPT, UPLOT, UPLOT_STYLE};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use planesman_text::shown;

pub(crate) mod cards;
pub mod coefficients;
pub mod compare;
pub mod continuous;
pub mod diff;
pub mod equations;
mod evidence;
pub mod fit;
pub mod flights;
mod poles;
pub mod review;
pub mod several;
pub mod six_dof;
mod space;
pub mod sweep;
pub mod tables;
pub mod tuning;

/// Content policy: a page loads nothing from elsewhere, even if a text contains markup.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'";

/// A self-contained page, with `own_style` after the common style and `own_script` after the plots' script. Foreign texts must pass through
/// [`shown`].
#[must_use]
pub fn document(title: &str, own_style: &str, body: &Markup, own_script: &str) -> String {
    // The page itself has no carriage returns; a file from elsewhere may.
    let text = |text: &str| shown(text.replace('\r', "")).to_string();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (text(title)) }
                @for style in [THEME, PAGE, UPLOT_STYLE, own_style] { style { (PreEscaped(style)) } }
            }
            body {
                header {}
                main {
                    (PreEscaped(text(&body.0)))
                    noscript { p.warn { "The plots need JavaScript, which is off in this browser." } }
                }
                @for script in [UPLOT, THEME_SCRIPT, PLOTS, own_script] { script { (PreEscaped(script)) } }
            }
        }
    }
    .into_string()
}

/// A plot with heading and note; nothing for an empty plot. For a plot that cannot be drawn, for example with huge numbers, the reason is
/// shown instead.
pub(crate) fn figure(plot: &Plot<'_>) -> Markup {
    if plot.is_empty() {
        return html! {};
    }
    drawn(&plot.title, &plot.note, "plot", plot.data())
}

/// A heat map with its heading.
pub(crate) fn heat_map(title: &str, map: &HeatMap) -> Markup {
    drawn(title, "", "plot", map.data())
}

fn drawn(title: &str, note: &str, class: &str, data: Result<String, PlotError>) -> Markup {
    html! {
        figure class=(class) {
            div.head { h2 { (title) } }
            @if !note.is_empty() { p { (note) } }
            @match data {
                Ok(data) => {
                    script type="application/json" { (PreEscaped(data)) }
                    div.legend {}
                    div.area {}
                }
                Err(error) => p.warn { (error) },
            }
        }
    }
}

/// Plots side by side if there is room; the first one over the full width.
#[must_use]
pub fn figures_with_first(plots: &[Plot<'_>]) -> Markup {
    let Some((first, others)) = plots.split_first() else {
        return html! {};
    };
    html! {
        div.plots {
            @if !first.is_empty() { (drawn(&first.title, &first.note, "plot wide", first.data())) }
            @for plot in others { (figure(plot)) }
        }
    }
}

/// Plots side by side if there is room.
#[must_use]
pub fn figures(plots: &[Plot<'_>]) -> Markup {
    html! { div.plots { @for plot in plots { (figure(plot)) } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_text_of_others_as_text_and_loads_nothing() {
        let hostile = "<script>alert(1)</script>\u{1b}[31m\u{202e}";
        let plot = Plot::new(hostile, [hostile, hostile]).line(hostile, [(0.0, 1.0)]);
        let page = document(hostile, "", &html! { p { (hostile) } (figure(&plot)) }, "");
        assert!(!page.contains("<script>alert") && !page.contains('\u{1b}'));
        assert!(!page.contains('\u{202e}'));
        for tag in ["<link", "<img", "<iframe", " src="] {
            assert!(!page.contains(tag), "{tag}");
        }
        assert!(page.ends_with("</html>"));
    }

    #[test]
    fn a_plot_that_cannot_be_drawn_says_why() {
        let plot = Plot::new("far", ["s", "m"]).line("a", [(0.0, 1e300)]);
        assert!(figure(&plot).0.contains("1e300"));
        assert_eq!(figure(&Plot::new("none", ["s", "m"])).0, "");
    }
}
