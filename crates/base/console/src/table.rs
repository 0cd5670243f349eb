//! Tables on standard output: aligned to the terminal, or as Markdown, CSV or JSON.

use std::fmt::Display;
use std::io::IsTerminal as _;
use std::iter;

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, Width, presets};
use maud::{Markup, html};
use serde_json::{Map, Value};

/// Width without a terminal, columns.
const WIDTH: u16 = 80;

planesman_text::choices! {
    /// Output format of a table.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Format {
        Table = "table": "Aligned columns within the terminal's width, 80 columns elsewhere",
        Md = "md": "Markdown",
        Csv = "csv": "Comma-separated values with a header row",
        Json = "json": "A list of objects with the column names as keys",
    }
}

impl Format {
    /// The requested format; by default an aligned table on a terminal and Markdown elsewhere.
    #[must_use]
    pub fn or_by_output(asked: Option<Self>) -> Self {
        let elsewhere = if std::io::stdout().is_terminal() {
            Self::Table
        } else {
            Self::Md
        };
        asked.unwrap_or(elsewhere)
    }
}

/// Rows with named columns.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new<const N: usize>(columns: [&str; N]) -> Self {
        Self::of(columns)
    }

    /// Like [`Table::new`], for any number of columns.
    #[must_use]
    pub fn of<'a>(columns: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            columns: columns.into_iter().map(str::to_owned).collect(),
            rows: Vec::new(),
        }
    }

    /// The table as HTML.
    #[must_use]
    pub fn html(&self) -> Markup {
        self.html_with(|cell| html! { (cell) })
    }

    /// The table as HTML; `made` converts the text of each cell.
    #[must_use]
    pub fn html_with(&self, made: impl Fn(&str) -> Markup) -> Markup {
        let of_words: Vec<bool> = (0..self.columns.len())
            .map(|it| self.is_of_words(it))
            .collect();
        let class = |column: usize| of_words[column].then_some("word");
        html! {
            div.scroll { table {
                thead { tr { @for (at, column) in self.columns.iter().enumerate() {
                    @if column.is_empty() { td {} } @else { th class=[class(at)] { (column) } }
                } } }
                @for row in &self.rows { tr {
                    @for (at, cell) in row.iter().enumerate() { td class=[class(at)] { (made(cell)) } }
                } }
            } }
        }
    }

    /// Whether most cells of a column do not begin with a number.
    fn is_of_words(&self, column: usize) -> bool {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        let numbers = cells.filter(|cell| {
            let first = cell.split_whitespace().next().unwrap_or_default();
            first.parse::<f64>().is_ok()
        });
        2 * numbers.count() < self.rows.len()
    }

    /// Whether the table has no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// All cells.
    pub fn cells(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().flatten().map(String::as_str)
    }

    /// Adds a row with one cell per column.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The table as text, with a line end after the last line.
    #[must_use]
    pub fn text(&self, format: Format) -> String {
        match format {
            Format::Table => self.within(terminal().unwrap_or(WIDTH)),
            Format::Md => self.markdown(),
            Format::Csv => self.csv(),
            Format::Json => self.json(),
        }
    }

    /// Aligned columns within the terminal's width, or unlimited without a terminal.
    #[must_use]
    pub fn aligned(&self) -> String {
        self.within(terminal().unwrap_or(u16::MAX))
    }

    fn within(&self, width: u16) -> String {
        let mut table = comfy_table::Table::new();
        table
            .load_preset(presets::NOTHING)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(width)
            .set_header(&self.columns);
        for row in &self.rows {
            table.add_row(row.iter().map(|text| {
                let is_number = text.parse::<f64>().is_ok();
                let side = if is_number {
                    CellAlignment::Right
                } else {
                    CellAlignment::Left
                };
                Cell::new(text).set_alignment(side)
            }));
        }
        self.keep_words_whole(&mut table, width);
        table.trim_fmt() + "\n"
    }

    /// Makes each column as wide as its longest word, if the terminal is wide enough.
    fn keep_words_whole(&self, table: &mut comfy_table::Table, width: u16) {
        let longest = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            let words = cells
                .chain(self.columns.get(column))
                .flat_map(|cell| cell.split(' '));
            words.map(|word| word.chars().count()).max().unwrap_or(0)
        };
        // A space parts two columns.
        let least: Vec<usize> = (0..self.columns.len()).map(|it| longest(it) + 1).collect();
        let fits = least.iter().sum::<usize>() <= usize::from(width);
        for (column, least) in table.column_iter_mut().zip(least) {
            column.set_padding((0, 1));
            if let (true, Ok(least)) = (fits, u16::try_from(least)) {
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(least)));
            }
        }
    }

    fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("|{}\n", "---|".repeat(self.columns.len()));
        let rows = self.rows.iter().map(|row| line(row));
        line(&self.columns) + &rule + &rows.collect::<String>()
    }

    fn csv(&self) -> String {
        let mut writer = csv::WriterBuilder::new()
            .flexible(true)
            .from_writer(Vec::new());
        for row in iter::once(&self.columns).chain(&self.rows) {
            writer.write_record(row).expect("memory takes it");
        }
        let bytes = writer.into_inner().expect("memory takes it");
        String::from_utf8(bytes).expect("cells are UTF-8")
    }

    fn json(&self) -> String {
        let value = |text: &String| match serde_json::from_str(text.trim_start_matches('+')) {
            Ok(Value::Number(number)) => Value::Number(number),
            _ => Value::String(text.clone()),
        };
        let object = |row: &Vec<String>| -> Map<String, Value> {
            let cells = self.columns.iter().zip(row);
            cells
                .map(|(name, cell)| (name.clone(), value(cell)))
                .collect()
        };
        let rows: Vec<_> = self.rows.iter().map(object).collect();
        serde_json::to_string_pretty(&rows).expect("names and texts are JSON") + "\n"
    }
}

/// Width of the terminal, columns; `None` if standard output is not a terminal.
#[must_use]
pub fn terminal() -> Option<u16> {
    let (_, columns) = console::Term::stdout().size_checked()?;
    Some(columns)
}

/// Whether standard output is a terminal.
#[must_use]
pub fn is_terminal() -> bool {
    terminal().is_some()
}

/// Prints text as [`wrapped`] returns it, with a line end after the last line.
///
/// # Errors
/// When standard output cannot be written.
pub fn print_wrapped(text: impl Display) -> std::io::Result<()> {
    crate::print(wrapped(&text.to_string()))
}

/// Text wrapped to the terminal's width, if standard output is a terminal; continuation lines are indented by two columns more.
#[must_use]
pub fn wrapped(text: &str) -> String {
    terminal().map_or_else(|| text.to_owned(), |width| wrapped_at(text, width))
}

fn wrapped_at(text: &str, width: u16) -> String {
    let line = |line: &str| {
        let indent = &line[..line.len() - line.trim_start().len()];
        let further = format!("{indent}  ");
        let options = textwrap::Options::new(width.into()).subsequent_indent(&further);
        textwrap::fill(line, options) + "\n"
    };
    text.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(["name", "depth, m"]);
        table.row(["a, b".to_owned(), "-1.50".to_owned()]);
        table.row(["c".to_owned(), "never".to_owned()]);
        table
    }

    #[test]
    fn a_table_is_written_in_every_format() {
        let text = |format| table().text(format);
        assert_eq!(
            text(Format::Md),
            "| name | depth, m |\n|---|---|\n| a, b | -1.50 |\n| c | never |\n"
        );
        assert_eq!(
            text(Format::Csv),
            "name,\"depth, m\"\n\"a, b\",-1.50\nc,never\n"
        );
        let json: Value = serde_json::from_str(&text(Format::Json)).expect("JSON");
        assert_eq!(json[0]["depth, m"], -1.5);
        assert_eq!(json[1]["depth, m"], "never");
    }

    #[test]
    fn a_wide_table_stays_within_its_width() {
        let mut wide = Table::new(["a rather long name of a column"; 9]);
        wide.row(["a rather long cell of so many words"; 9].map(str::to_owned));
        let text = wide.within(80);
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        assert!(text.lines().count() > 4, "{text}");
        assert!(text.contains("rather") && text.contains("column"), "{text}");
    }

    #[test]
    fn a_sentence_goes_on_behind_its_indent() {
        assert_eq!(
            wrapped_at("- one two three four\nshort\n", 12),
            "- one two\n  three four\nshort\n"
        );
    }
}
