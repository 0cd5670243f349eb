//! The book of numbers on one self-contained HTML page, with the figures that are lost from the report's copy.

use anyhow::{Result, anyhow};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use planesman_book::{Book, Reckoning, Verdict};

use super::figures::{self, Figure};
use super::listing::{number, totals, verdict};
use super::{root_loci, time_responses};
use crate::page::{STYLE, legend};

const OWN_STYLE: &str = "
td.contradicts { background: #fde2d4; } td.approximate { background: #fff4d6; }
td.note { text-align: left; font-size: 13px; max-width: 22rem; }
body { max-width: 72rem; }
";

/// The page's text.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn page(book: &Book, reckoning: &Reckoning<'_>) -> Result<String> {
    let programs = drawn(figures::figures())?;
    let loci = drawn(root_loci::figures()?)?;
    let responses = drawn(time_responses::figures().map_err(|reason| anyhow!(reason))?)?;
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Brunner 1988, computed again" }
                style { (PreEscaped(STYLE)) (PreEscaped(OWN_STYLE)) }
            }
            body {
                h1 { "Brunner 1988, computed again" }
                p.lead { "G. M. Brunner, Experimental Verification of AUV Performance, Naval Postgraduate School, March 1988." }
                pre { (totals(reckoning).trim()) }
                h2 { "Figures B1 to B10" }
                p { "The copy of the report has lost them. These are what programs T2 to T5 put out, with the errors they had." }
                (programs)
                h2 { "Root loci" }
                (loci)
                h2 { "Time responses of the depth loop" }
                (responses)
                h2 { "Numbers" }
                (numbers(book, reckoning))
                h2 { "Errata" }
                table {
                    @for (number, text) in book.errata() {
                        tr id=(number) { td { (number) } td.note { (text) } }
                    }
                }
            }
        }
    }
    .into_string())
}

fn drawn(figures: Vec<Figure>) -> Result<Markup> {
    let mut drawn = Vec::new();
    for Figure { note, plot } in figures {
        drawn.push(html! {
            h3 { (plot.title) }
            p.lead { (note) }
            (legend(&plot))
            (PreEscaped(plot.svg()?))
        });
    }
    Ok(html! { @for figure in drawn { (figure) } })
}

fn numbers(book: &Book, reckoning: &Reckoning<'_>) -> Markup {
    html! {
        table {
            tr { th { "number" } th { "source" } th { "unit" } th { "printed" } th { "recomputed" } th { "within" } th { "verdict" } th { "remarks" } }
            @for line in &reckoning.lines {
                @let entry = line.entry;
                @let class = match line.verdict {
                    Some(Verdict::Contradicts) => "contradicts",
                    Some(Verdict::Approximate) => "approximate",
                    _ => "",
                };
                tr {
                    td { (entry.id) } td { (entry.source) } td { (entry.unit) }
                    td { (number(entry.printed)) } td { (number(line.value)) }
                    td { (number(entry.slack.or(entry.tolerance))) }
                    td class=(class) { (verdict(line)) }
                    td.note {
                        @if let Some(news) = line.news() { b { "Not as in the book: " (news) ". " } }
                        @if let Some(note) = &entry.note { (note) ". " }
                        @if let Some((number, _)) = book.erratum_of(entry) {
                            a href=(format!("#{number}")) { (number) }
                        }
                    }
                }
            }
        }
    }
}
