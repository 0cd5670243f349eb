//! The books of numbers on one self-contained HTML page, with the figures that are lost from the reports' copies.

use anyhow::Result;
use maud::{Markup, html};
use planesman_book::{Book, Chapter, Reckoning, Report, Verdict};

use super::listing::{totals, verdict, written};
use crate::page::{document, figures as drawn};

const OWN_STYLE: &str = "
td.contradicts { background: #fde2d4; } td.approximate { background: #fff4d6; }
td.note { text-align: left; font-size: 13px; max-width: 22rem; }
body { max-width: 72rem; }
";

/// A page that is written report by report.
#[derive(Default)]
pub struct Page {
    titles: Vec<&'static str>,
    reports: Vec<Markup>,
}

impl Page {
    /// Adds a report with its figures, account, numbers and errata.
    ///
    /// # Errors
    /// When a figure cannot be drawn.
    pub fn add(
        &mut self,
        report: &Report,
        book: &Book,
        reckoning: &Reckoning<'_>,
        account: Option<&str>,
    ) -> Result<()> {
        let mut chapters = Vec::new();
        for Chapter {
            title,
            note,
            figures,
        } in (report.figures)()?
        {
            chapters.push(html! { h2 { (title) } p { (note) } (drawn(&figures)) });
        }
        self.titles.push(report.name);
        self.reports.push(html! {
            h1 { (report.name) ", computed again" }
            p.lead { (report.citation) }
            pre { (totals(reckoning).trim()) }
            @for chapter in chapters { (chapter) }
            @if let Some(account) = account { pre { (account) } }
            h2 { "Numbers" }
            (numbers(book, reckoning))
            h2 { "Errata" }
            table {
                @for (number, text) in book.errata() {
                    tr id=(number) { td { (number) } td.note { (text) } }
                }
            }
        });
        Ok(())
    }

    /// The page's text.
    #[must_use]
    pub fn text(&self) -> String {
        let title = format!("{}, computed again", self.titles.join(", "));
        let body = html! { @for report in &self.reports { (report) } };
        document(&title, OWN_STYLE, &body, "")
    }
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
                    td { (written(entry.printed)) } td { (written(line.value)) }
                    td { (written(entry.slack.or(entry.tolerance))) }
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
