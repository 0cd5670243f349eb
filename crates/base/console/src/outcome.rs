//! Output of a command, in the order common to all commands.

use std::fmt::{self, Display};
use std::path::Path;

use planesman_text::shell_word;

use crate::wrapped;

/// Output of a command: the answer, the numbers that support it, the files written, the next commands.
///
/// ```
/// use planesman_console::Outcome;
///
/// let outcome = Outcome::new("Stable.").numbers("gain margin  11.4 dB\n");
/// let outcome = outcome.file("Page", "loop.html".as_ref()).next("planesman dive", "fly it");
/// let text = "Stable.\n\ngain margin  11.4 dB\n\nPage: loop.html\n\nNext:\n  planesman dive  # fly it\n";
/// assert_eq!(outcome.to_string(), text);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Sentences and tables, separated by empty lines.
    parts: Vec<String>,
    files: String,
    next: Vec<(String, &'static str)>,
}

impl Outcome {
    /// An output whose answer consists of one or more sentences.
    #[must_use]
    pub fn new(answer: impl Display) -> Self {
        Self::default().numbers(answer)
    }

    /// Adds lines or a table with the numbers that support the answer.
    #[must_use]
    pub fn numbers(mut self, text: impl Display) -> Self {
        self.parts.push(text.to_string());
        self
    }

    /// Adds a written file: its kind, such as `Page`, and its path.
    #[must_use]
    pub fn file(mut self, kind: &str, path: &Path) -> Self {
        self.files += &(file_line(kind, path) + "\n");
        self
    }

    /// Adds a next command with its purpose.
    #[must_use]
    pub fn next(mut self, command: impl Into<String>, purpose: &'static str) -> Self {
        self.next.push((command.into(), purpose));
        self
    }

    /// Prints the output. Sentences are wrapped to the terminal, commands are not.
    ///
    /// # Errors
    /// When standard output cannot be written.
    pub fn print(mut self) -> std::io::Result<()> {
        self.parts.iter_mut().for_each(|it| *it = wrapped(it));
        crate::print(self)
    }
}

impl Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.next.iter().map(|it| it.0.chars().count()).max();
        let width = width.unwrap_or(0);
        let next = self.next.iter();
        let next = next.map(|(command, purpose)| format!("\n  {command:width$}  # {purpose}"));
        let next = Some(next.collect::<String>()).filter(|it| !it.is_empty());
        let next = next.map(|it| format!("Next:{it}"));
        let parts = self.parts.iter().chain([&self.files]).chain(&next);
        let parts = parts
            .map(|it| it.trim_end().trim_start_matches('\n'))
            .filter(|it| !it.is_empty());
        writeln!(f, "{}", parts.collect::<Vec<_>>().join("\n\n"))
    }
}

/// Output line for a written file.
#[must_use]
pub fn file_line(kind: &str, path: &Path) -> String {
    format!("{kind}: {}", path.display())
}

/// The running command line, for copying.
#[must_use]
pub fn called() -> String {
    let arguments = std::env::args().skip(1).map(|it| shell_word(&it));
    let words = std::iter::once("planesman".to_owned()).chain(arguments);
    words.collect::<Vec<_>>().join(" ")
}
