//! HTML page of the books of numbers: totals and contents, the numbers by family with a filter, the figures missing in the copies of the
//! reports, and the errata.

use maud::{Markup, html};
use planesman_reports::book::{Book, Chapter, Comparison, Line, Names, Report, VERDICTS};

use planesman_show::pages::{document, figures};
use planesman_text::number;

const STYLE: &str = "
td.name { text-align: left; min-width: 14rem; } td.name small { display: block; color: var(--muted); }
td.name a { color: inherit; text-decoration: none; } td.name a:hover { text-decoration: underline; }
td.source, td.unit, td.verdict { text-align: left; }
td.note { text-align: left; font-size: 13px; min-width: 14rem; max-width: 26rem; }
tr[data-verdict='contradicts'] td.verdict { background: var(--bad-ground); }
tr[data-verdict='approximate'] td.verdict { background: var(--fair-ground); }
tr[data-verdict='agrees'] td.verdict { background: var(--good-ground); }
tr:target { outline: 2px solid var(--accent); }
nav { font-size: 14px; } nav a, .columns td a { display: inline-block; min-height: 24px; line-height: 24px; } nav ul { margin: .2rem 0; padding-left: 1.1rem; } nav summary { margin: 0; font-weight: normal; }
.filter { position: sticky; top: 0; z-index: 2; background: var(--background); padding: .5rem 0; display: flex; flex-wrap: wrap; gap: .5rem 1rem; align-items: center; border-bottom: 1px solid var(--rule); }
.filter input { flex: 1; min-width: 10rem; max-width: 24rem; }
[id] { scroll-margin-top: 4rem; }
.family th:nth-child(3), .family th:nth-child(n+6) { text-align: left; } .family td.note { padding-left: .6rem; }
.family table { min-width: 40rem; } .family thead th { position: static; }
";

/// Verdicts counted at the top.
const COMPARED: [&str; 3] = ["agrees", "approximate", "contradicts"];

const SCRIPT: &str = include_str!("page.js");

/// A page that is built report by report.
#[derive(Default)]
pub(crate) struct Page {
    summaries: Vec<Markup>,
    numbers: Vec<Markup>,
    reports: Vec<Markup>,
    /// Number of printed and compared numbers: numbers that agree, agree approximately, and do not agree.
    printed: [usize; 3],
}

impl Page {
    /// Adds a report with its figures, procedure, numbers and errata.
    pub(crate) fn add(
        &mut self,
        report: &Report,
        book: &Book,
        names: &Names,
        comparison: &Comparison<'_>,
        chapters: &[Chapter],
        procedure: Option<&str>,
    ) {
        let place = |part: &str| slug(&format!("{} {part}", report.name));
        let families = families(names, comparison);
        let contents = html! {
            ul {
                @for chapter in chapters { li { a href=(format!("#{}", place(chapter.title))) { (chapter.title) } } }
                @if procedure.is_some() { li { a href=(format!("#{}", place("procedure"))) { "The procedure step by step" } } }
                @if !book.errata().is_empty() { li { a href=(format!("#{}", place("errata"))) { "Errata" } } }
                li { details { summary { "Numbers" }
                    ul { @for (family, _) in &families { li { a href=(format!("#{}", place(family))) { (family) } } } }
                } }
            }
        };
        for (total, verdict) in self.printed.iter_mut().zip(COMPARED) {
            *total += comparison.count(verdict);
        }
        self.summaries.push(summary(report, comparison, &contents));
        self.numbers.push(html! {
            h2 { (report.name) ": numbers" }
            @for (family, lines) in &families {
                details.family id=(place(family)) { summary { (family) " (" (lines.len()) ")" } (numbers(book, names, lines)) }
            }
        });
        self.reports.push(html! {
            @for Chapter { title, note, figures: plots } in chapters {
                h2 id=(place(title)) { (report.name) ": " (title) }
                @if !note.is_empty() { p { (note) } }
                (figures(plots))
            }
            @if let Some(procedure) = procedure {
                h2 id=(place("procedure")) { (report.name) ": the procedure step by step" }
                details { summary { "Each step with its numbers" } pre { (procedure) } }
            }
            @if !book.errata().is_empty() {
                h2 id=(place("errata")) { (report.name) ": errata" }
                div.scroll { table {
                    @for (number, text) in book.errata() {
                        tr id=(number) { td { (number) } td.note style="max-width: 60rem" { (text) } }
                    }
                } }
            }
        });
    }

    /// HTML text of the page.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let [agree, nearly, not] = self.printed;
        let body = html! {
            h1 { "Two reports and recorded validations, recomputed" }
            ul.verdict { li { "Of " (agree + nearly + not) " printed numbers compared, " (agree) " agree, " (nearly) " agree approximately, " (not) " do not." } }
            p.lead { "Every printed number compared with the recomputed one, and the figures that are missing in the copies." }
            div.columns { @for summary in &self.summaries { (summary) } }
            div.filter id="numbers" {
                input type="search" placeholder="words, such as: Table 1 damping" aria-label="show only rows that contain these words";
                select aria-label="verdict" {
                    option value="" { "every verdict" }
                    @for (verdict, _) in VERDICTS { option value=(verdict) { (verdict) } }
                }
                output {}
            }
            @for numbers in &self.numbers { (numbers) }
            @for report in &self.reports { (report) }
        };
        document(
            "Two reports and recorded validations, recomputed",
            STYLE,
            &body,
            SCRIPT,
        )
    }
}

/// The count of each verdict, with a link to its numbers, and the contents.
fn summary(report: &Report, comparison: &Comparison<'_>, contents: &Markup) -> Markup {
    html! {
        div {
            h2 { (report.name) }
            p { (report.citation) }
            div.scroll { table {
                @for (verdict, meaning) in VERDICTS {
                    tr { td { a href="#numbers" data-pick=(verdict) { (meaning) } } td { (comparison.count(verdict)) } }
                }
                tr { td { b { "numbers" } } td { b { (comparison.lines.len()) } } }
            } }
            nav aria-label=(format!("Contents, {}", report.name)) { (contents) }
        }
    }
}

/// The lines grouped by the plain name of their family, in the book's order.
fn families<'a, 'b>(
    names: &'a Names,
    comparison: &'a Comparison<'b>,
) -> Vec<(&'a str, Vec<&'a Line<'b>>)> {
    let mut families: Vec<(&str, Vec<&Line<'_>>)> = Vec::new();
    for line in &comparison.lines {
        let family = names.family(line.entry);
        match families.iter_mut().find(|(name, _)| *name == family) {
            Some((_, lines)) => lines.push(line),
            None => families.push((family, vec![line])),
        }
    }
    families
}

fn numbers(book: &Book, names: &Names, lines: &[&Line<'_>]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "number" } th { "printed" } th { "page" } th { "recomputed" } th { "within" } th { "unit" } th { "verdict" } th { "remarks" } } }
            @for line in lines {
                @let entry = line.entry;
                tr id=(entry.id) data-verdict=(line.told()) {
                    td.name {
                        a href=(format!("#{}", entry.id)) { (names.name(entry).unwrap_or_else(|| entry.id.clone())) }
                        small { (entry.id) }
                    }
                    td { (written(entry.printed)) }
                    td.source { (entry.source) }
                    td { (written(line.value)) }
                    td { (written(entry.slack.or(entry.tolerance))) }
                    td.unit { (entry.unit) }
                    td.verdict { (line.told()) }
                    td.note {
                        @if let Some(change) = line.change() { b { "Changed from the book: " (change) ". " } }
                        @if let Some(note) = &entry.note { (note) ". " }
                        @if let Some((number, text)) = book.erratum_of(entry) {
                            a href=(format!("#{number}")) title=(text) { (number) }
                        }
                    }
                }
            }
        } }
    }
}

/// A name made suitable for an address.
fn slug(name: &str) -> String {
    let letters = name.to_lowercase();
    let words = letters.split(|it: char| !it.is_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("-")
}

/// A number with six significant digits; empty if there is no number.
fn written(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}
