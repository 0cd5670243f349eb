//! Path of a field in a message: names separated by dots, indices or names of elements in brackets.
//!
//! A name in brackets is written as it is, with blanks and other characters: `values[motor driver: left]`. A name that is an integer, contains
//! brackets or quotes, or begins or ends with a blank is written in double quotes, with its own quotes doubled: `values["7"]`, `values["a[0]"]`.

use std::fmt;
use std::str::FromStr;

/// Path of a field: `twist.twist.angular.y`, `position[0]`, `position[shoulder]`, `transforms[1].header`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FieldPath {
    /// Steps from the message inwards.
    pub steps: Vec<Step>,
}

/// One step of a path.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Step {
    /// The field with this name.
    Field(String),
    /// The list element with this index.
    Index(usize),
    /// The element with this name, if another list of the message names the elements or each element has a name. As first step of a path: the message
    /// itself, if it has this name.
    Named(String),
}

/// The reason why a text is not a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PathError {
    /// An empty name, or one with other characters.
    #[error("a field name consists of letters, digits and underscores")]
    Name,
    /// Brackets that contain neither an integer nor a name.
    #[error(
        "in brackets an integer or the name of an element is expected; a name that is a number, contains brackets or quotes, or begins or ends with a blank \
         must be in double quotes: [\"7\"]"
    )]
    Index,
    /// A name followed by something other than a dot or brackets.
    #[error("an index must be in brackets")]
    Bracket,
}

impl FromStr for FieldPath {
    type Err = PathError;

    fn from_str(text: &str) -> Result<Self, PathError> {
        let mut steps = Vec::new();
        let mut rest = text;
        // The message of that name, `[base_link].pose`.
        if let Some((Ok(step @ Step::Named(_)), behind)) = bracketed(text)
            && let Some(behind) = behind.strip_prefix('.')
        {
            steps.push(step);
            rest = behind;
        }
        loop {
            let (name, behind) = rest.split_at(rest.find(['.', '[']).unwrap_or(rest.len()));
            if !is_name(name) {
                return Err(PathError::Name);
            }
            steps.push(Step::Field(name.to_owned()));
            rest = behind;
            // A name in brackets may have dots.
            while let Some((step, behind)) = bracketed(rest) {
                steps.push(step?);
                rest = behind;
            }
            rest = match rest.strip_prefix('.') {
                Some(behind) => behind,
                None if rest.is_empty() => return Ok(Self { steps }),
                None => return Err(PathError::Bracket),
            };
        }
    }
}

/// The step in the brackets at the beginning of a text, and the rest of the text.
fn bracketed(text: &str) -> Option<(Result<Step, PathError>, &str)> {
    let within = text.strip_prefix('[')?;
    let Some(quoted) = within.strip_prefix('"') else {
        let (name, behind) = within.split_once(']')?;
        let step = match name.bytes().all(|it| it.is_ascii_digit()) {
            true => name.parse().map(Step::Index).map_err(|_| PathError::Index),
            false if needs_quotes(name) => Err(PathError::Index),
            false => Ok(Step::Named(name.to_owned())),
        };
        return Some((step.and_then(printable), behind));
    };
    // A quote that stands twice is one of the name.
    let mut name = String::new();
    let mut rest = quoted;
    loop {
        let (part, behind) = rest.split_once('"')?;
        name += part;
        match behind.strip_prefix('"') {
            Some(behind) => {
                name.push('"');
                rest = behind;
            }
            None => return Some((printable(Step::Named(name)), behind.strip_prefix(']')?)),
        }
    }
}

/// A step, unless its name contains characters that cannot be written.
fn printable(step: Step) -> Result<Step, PathError> {
    match &step {
        Step::Named(name) if name.is_empty() || name.contains(char::is_control) => {
            Err(PathError::Index)
        }
        _ => Ok(step),
    }
}

/// Whether a name in brackets needs quotes to be unambiguous.
fn needs_quotes(name: &str) -> bool {
    name.bytes().all(|it| it.is_ascii_digit())
        || name.contains(['[', ']', '"'])
        || name.trim() != name
}

/// Whether `name` consists of letters, digits and underscores and does not begin with a digit.
fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl fmt::Display for FieldPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, step) in self.steps.iter().enumerate() {
            match step {
                Step::Field(name) if number == 0 => f.write_str(name)?,
                Step::Field(name) => write!(f, ".{name}")?,
                Step::Index(index) => write!(f, "[{index}]")?,
                Step::Named(name) if needs_quotes(name) => {
                    write!(f, "[\"{}\"]", name.replace('"', "\"\""))?;
                }
                Step::Named(name) => write!(f, "[{name}]")?,
            }
        }
        Ok(())
    }
}

impl FieldPath {
    /// Path of the field `name` below this path.
    #[must_use]
    pub fn field(&self, name: &str) -> Self {
        self.with(Step::Field(name.to_owned()))
    }

    /// Path of element `index` below this path.
    pub(crate) fn element(&self, index: usize) -> Self {
        self.with(Step::Index(index))
    }

    /// The path extended by one step.
    #[must_use]
    pub fn with(&self, step: Step) -> Self {
        let mut steps = self.steps.clone();
        steps.push(step);
        Self { steps }
    }

    /// Paths of the elements that are chosen by name, each with its name.
    pub fn named(&self) -> impl Iterator<Item = (Self, &str)> {
        let steps = self.steps.iter().enumerate();
        steps.filter_map(|(number, step)| match step {
            Step::Named(name) => Some((self.first(number), name.as_str())),
            Step::Field(_) | Step::Index(_) => None,
        })
    }

    /// Path of the first `steps` steps.
    #[must_use]
    pub fn first(&self, steps: usize) -> Self {
        Self {
            steps: self.steps[..steps].to_vec(),
        }
    }

    /// The path with the element after its first `steps` steps chosen by name instead of by index; a missing step is inserted.
    #[must_use]
    pub fn choosing(&self, steps: usize, name: &str) -> Self {
        let mut chosen = self.clone();
        let step = Step::Named(name.to_owned());
        match chosen.steps.get_mut(steps.wrapping_sub(1)) {
            Some(index) => *index = step,
            None => chosen.steps.insert(0, step),
        }
        chosen
    }

    /// Path without its last step.
    pub(crate) fn parent(&self) -> Self {
        let (_, before) = self.steps.split_last().unwrap_or((&Step::Index(0), &[]));
        Self {
            steps: before.to_vec(),
        }
    }

    /// The list that the last step indexes, and the index; `None` if the last step is a name.
    /// step is a name.
    #[must_use]
    pub fn in_list(&self) -> Option<(Self, usize)> {
        match self.steps.last()? {
            Step::Index(index) => Some((self.parent(), *index)),
            Step::Field(_) | Step::Named(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_written_as_it_was_read() {
        for text in [
            "x",
            "_a9",
            "a.b.c",
            "a[0]",
            "a[3].b[12].c",
            "a[b]",
            "a[arm.b-1/c].d",
            "[odom->base_link].a",
            "a[motor driver: left].values[Temperature (C)].b",
            "[\"7\"].a[\"b[0]\"]",
            "a[\" said \"\"so\"\" \"][\"]\"]",
            "a[\"12\"]",
        ] {
            assert_eq!(text.parse::<FieldPath>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn what_is_no_path_is_refused_with_the_rule() {
        for (text, rule) in [
            ("", PathError::Name),
            ("a..b", PathError::Name),
            ("9a", PathError::Name),
            ("[1]", PathError::Name),
            ("a[", PathError::Bracket),
            ("a[1]b", PathError::Bracket),
            ("a[]", PathError::Index),
            ("a[ ]", PathError::Index),
            ("a[b[0]]", PathError::Index),
            ("a[b ]", PathError::Index),
            ("a[b\nc]", PathError::Index),
            ("a[\"\"]", PathError::Index),
            ("a[\"b]", PathError::Bracket),
            ("a[b\"]", PathError::Index),
            ("a[\"b\"c]", PathError::Bracket),
            ("a.b.", PathError::Name),
            ("a[99999999999999999999999]", PathError::Index),
        ] {
            assert_eq!(text.parse::<FieldPath>().unwrap_err(), rule, "{text}");
        }
    }

    #[test]
    fn an_element_knows_its_list() {
        let path: FieldPath = "a.b[3]".parse().unwrap();
        assert_eq!(path.in_list(), Some(("a.b".parse().unwrap(), 3)));
        assert_eq!("a.b".parse::<FieldPath>().unwrap().in_list(), None);
    }
}
