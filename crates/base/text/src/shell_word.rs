//! Words of a command line.

/// A word quoted for a shell, if necessary.
///
/// ```
/// use planesman_text::shell_word;
/// assert_eq!(shell_word("state:pitch"), "state:pitch");
/// assert_eq!(shell_word("it's"), r"'it'\''s'");
/// ```
#[must_use]
pub fn shell_word(text: &str) -> String {
    let is_plain = |sign: char| sign.is_alphanumeric() || "/:._-+=,".contains(sign);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}
