//! The `ros2msg` schema text: a definition followed by all types it uses, as stored by rosbag2 in MCAP.
//!
//! Sections are separated by a line of 80 `=` and begin with `MSG: package/Type`. The order is the same as in rosbag2: depth first through the types
//! used by each definition, sorted by name, each written once.

use std::collections::BTreeSet;

use crate::definition::TypeName;
use crate::error::{Error, MAX_DEPTH, Rule};
use crate::library::Library;
use crate::parse::parse_part;

const SEPARATOR: &str =
    "================================================================================";

impl Library {
    /// The `ros2msg` schema text of a message.
    ///
    /// # Errors
    /// A type that is not in the library, or definitions nested deeper than [`MAX_DEPTH`].
    pub fn schema(&self, name: &TypeName) -> Result<String, Error> {
        let mut text = String::new();
        let mut written = BTreeSet::new();
        self.append_schema(name, &mut text, &mut written, 1)?;
        Ok(text)
    }

    fn append_schema<'a>(
        &'a self,
        name: &'a TypeName,
        text: &mut String,
        written: &mut BTreeSet<&'a TypeName>,
        level: usize,
    ) -> Result<(), Error> {
        let message = self.expect_message(name)?;
        if level > MAX_DEPTH {
            return Err(Rule::TooDeep.at(&message.file, 0));
        }
        if level > 1 {
            text.push_str(&format!("\n{SEPARATOR}\nMSG: {}\n", name.short()));
        }
        text.push_str(&message.text);
        let references: BTreeSet<&TypeName> = message
            .references()
            .into_iter()
            .map(|(name, _)| name)
            .collect();
        for reference in references {
            if written.insert(reference) {
                self.append_schema(reference, text, written, level + 1)?;
            }
        }
        Ok(())
    }
}

/// Parses a `ros2msg` schema text, whose first section defines `type_name`.
///
/// The result has passed [`Library::check`]: all types are defined, no message contains itself or is nested deeper than [`MAX_DEPTH`].
///
/// # Errors
/// The line of the text and the violated rule.
pub fn parse_schema(type_name: &str, text: &str) -> Result<Library, Error> {
    let root = TypeName::parse(type_name)
        .ok_or_else(|| Rule::BadName(type_name.to_owned()).at(type_name, 0))?;
    let file = format!("schema of {root}");
    let mut library = Library::new();
    for section in sections(root, text, &file)? {
        // A definition that is written twice the same is harmless; some writers do so.
        let message = parse_part(section.name, &section.text, &file, section.lines_before)?;
        let known = library.message(&message.name);
        if known.is_none_or(|known| known.fields != message.fields) {
            library.add_message(message)?;
        }
    }
    library.check()?;
    Ok(library)
}

struct Section {
    name: TypeName,
    text: String,
    lines_before: usize,
}

fn sections(root: TypeName, text: &str, file: &str) -> Result<Vec<Section>, Error> {
    let mut sections = Vec::new();
    let mut current = Section {
        name: root,
        text: String::new(),
        lines_before: 0,
    };
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        if !is_separator(line) {
            current.text.push_str(line);
            current.text.push('\n');
            continue;
        }
        let (_, head) = lines.next().unwrap_or((0, ""));
        let name = head
            .strip_prefix("MSG:")
            .and_then(|name| TypeName::parse(name.trim()))
            .ok_or_else(|| Rule::BadSectionHead(head.to_owned()).at(file, index + 2))?;
        let next = Section {
            name,
            text: String::new(),
            lines_before: index + 2,
        };
        sections.push(std::mem::replace(&mut current, next));
    }
    sections.push(current);
    Ok(sections)
}

fn is_separator(line: &str) -> bool {
    let line = line.trim_end();
    line.len() >= SEPARATOR.len() && line.chars().all(|c| c == '=')
}
