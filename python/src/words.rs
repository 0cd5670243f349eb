//! Messages of the program in Python's words: `order=3` for `--order 3`.

use pyo3::prelude::*;

/// What stands for a file that the program writes, and in Python is a method of the model.
const METHODS: [(&str, &str); 2] = [
    ("--model model.yaml", "model.save('model.yaml')"),
    ("--html model.html", "model.plot()"),
];

/// Changes of a scenario are named by what they change.
const CHANGES: [&str; 2] = ["--set ", "--vary "];

/// The message with keywords in place of the command line's options.
#[pyfunction]
pub(crate) fn in_python(message: &str) -> String {
    let mut message = message.to_owned();
    for (option, method) in METHODS {
        message = message.replace(option, method);
    }
    for option in CHANGES {
        message = message.replace(option, "");
    }
    let mut rest = message.as_str();
    let mut told = String::new();
    while let Some(at) = rest.find("--") {
        let (before, option) = (&rest[..at], &rest[at + 2..]);
        let is_name = |c: char| c.is_ascii_lowercase() || c == '-';
        let end = option.find(|c| !is_name(c)).unwrap_or(option.len());
        let name = option[..end].trim_end_matches('-');
        let begins = before.ends_with([' ', '(', '\'']) || before.is_empty();
        // A command of another program is as it is.
        let quoted = (told.matches('`').count() + before.matches('`').count()) % 2 == 1;
        if name.is_empty() || !begins || quoted {
            told += &rest[..at + 2];
            rest = option;
            continue;
        }
        rest = &option[name.len()..];
        told += before;
        let keyword = name.replace('-', "_");
        if let Some(shorter) = told.strip_suffix("sysid fit ") {
            told = format!("{shorter}fit({keyword}=...)");
            continue;
        }
        told += &keyword;
        // What clap shows of the value: `--order <N>`.
        if let Some((_, behind)) = rest.strip_prefix(" <").and_then(|it| it.split_once('>')) {
            rest = behind;
        } else if let Some((value, behind)) = value(name, rest) {
            told += &format!("={value}");
            rest = behind;
        }
    }
    told + rest
}

/// The value behind an option, as Python writes it, and what follows: a number, a word that the option knows, or what stands for
/// one, in capitals.
fn value<'a>(option: &str, rest: &'a str) -> Option<(String, &'a str)> {
    let rest = rest.strip_prefix(' ')?;
    let end = rest.find([' ', ',', ';', ')', '\'']).unwrap_or(rest.len());
    let end = rest[..end].trim_end_matches(':').len();
    let (word, behind) = rest.split_at(end);
    let stands = |it: &str| it.len() > 1 && it.chars().all(|c| c.is_ascii_uppercase() || c == ':');
    if let Some((from, to)) = word.split_once("..") {
        let edge = |it: &str| it.is_empty() || it.parse::<f64>().is_ok() || stands(it);
        let text = |it: &str| match it {
            "" => "None".to_owned(),
            it => it.to_lowercase(),
        };
        return (edge(from) && edge(to))
            .then(|| (format!("({}, {})", text(from), text(to)), behind));
    }
    if word.parse::<f64>().is_ok() || stands(word) || word == "N" {
        return Some((word.to_owned(), behind));
    }
    let name = option.replace('-', "_");
    let options = planesman_fit::options();
    let (_, words) = options.iter().find(|(it, _)| *it == name)?;
    words.contains(&word).then(|| (format!("'{word}'"), behind))
}
