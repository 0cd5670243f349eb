//! An error in one line.

use std::error::Error;
use std::iter;

/// Largest length of an error, characters: it may quote a value of a file of any length.
const ERROR: usize = 4000;

/// An error with its causes, each once, since many messages already end with their cause. If it is longer than 4000 characters, the middle is
/// left out.
#[must_use]
pub fn in_one_line(error: &(dyn Error + 'static)) -> String {
    let mut next = Some(error);
    let causes = iter::from_fn(|| {
        let cause = next?;
        next = cause.source();
        Some(cause.to_string())
    });
    let said = causes.fold(String::new(), |said, cause| {
        if said.is_empty() {
            cause
        } else if said.ends_with(&cause) {
            said
        } else {
            format!("{said}: {cause}")
        }
    });
    let omitted = said.chars().count().saturating_sub(ERROR);
    if omitted == 0 {
        return said;
    }
    let place = |character: usize| {
        said.char_indices()
            .nth(character)
            .map_or(said.len(), |(at, _)| at)
    };
    let (end, start) = (place(ERROR / 2), place(ERROR / 2 + omitted));
    format!("{} [{omitted} characters] {}", &said[..end], &said[start..])
}

#[cfg(test)]
mod tests {
    use super::in_one_line;
    use anyhow::anyhow;

    #[test]
    fn a_cause_that_the_message_ends_with_is_said_once() {
        let twice = anyhow!("missing field")
            .context("file: missing field")
            .context("scenario");
        assert_eq!(in_one_line(twice.as_ref()), "scenario: file: missing field");
        assert_eq!(in_one_line(anyhow!("b").context("a").as_ref()), "a: b");
    }

    #[test]
    fn of_a_long_error_its_start_and_its_end_are_said() {
        let value = "ü".repeat(100_000);
        let error = anyhow!("{value}, expected f64").context("file");
        let said = in_one_line(error.as_ref());
        assert!(said.starts_with("file: ü"), "{said}");
        assert!(said.ends_with("ü, expected f64"), "{said}");
        assert!(said.contains(" [96020 characters] "), "{said}");
    }
}
