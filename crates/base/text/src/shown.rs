//! Escaping of foreign text.

use std::fmt::{self, Display, Write};

/// Text made safe for a terminal or a page: escape sequences, marks that change the reading direction, and invalid characters are written as
/// `\u001b`, which JSON and YAML accept too. Line ends and tabs are kept.
pub fn shown<T: Display>(text: T) -> Shown<T> {
    Shown(text)
}

/// Result of [`shown`].
#[derive(Clone, Copy, Debug)]
pub struct Shown<T>(T);

impl<T: Display> Display for Shown<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Filter(f), "{}", self.0)
    }
}

struct Filter<'a, 'b>(&'a mut fmt::Formatter<'b>);

impl Write for Filter<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut rest = text;
        while let Some((at, sign)) = rest.char_indices().find(|(_, sign)| acts(*sign)) {
            let (before, behind) = rest.split_at(at);
            self.0.write_str(before)?;
            write!(self.0, "\\u{:04x}", u32::from(sign))?;
            rest = &behind[sign.len_utf8()..];
        }
        self.0.write_str(rest)
    }
}

/// Whether a character also has an effect, in addition to being displayed.
fn acts(sign: char) -> bool {
    let is_layout = matches!(sign, '\n' | '\t');
    let turns =
        matches!(sign, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let is_none = matches!(sign, '\u{feff}' | '\u{fffe}' | '\u{ffff}');
    (sign.is_control() && !is_layout) || turns || is_none
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_act_on_a_terminal_is_written_out() {
        for (text, expected) in [
            ("depth [m]\tü\n", "depth [m]\tü\n"),
            ("\u{1b}[31mred\u{1b}[0m", "\\u001b[31mred\\u001b[0m"),
            ("\u{1b}]0;title\u{7}", "\\u001b]0;title\\u0007"),
            ("over\rwritten", "over\\u000dwritten"),
            ("\u{9b}2J", "\\u009b2J"),
            ("a\u{202e}b", "a\\u202eb"),
            ("\u{feff}a\u{ffff}", "\\ufeffa\\uffff"),
        ] {
            assert_eq!(shown(text).to_string(), expected);
        }
        assert_eq!(shown(format_args!("{}{}", 1, '\0')).to_string(), "1\\u0000");
    }
}
