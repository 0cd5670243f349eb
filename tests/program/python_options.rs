//! The options of Python's `fit` are those that the library declares, with their types and their help.

use std::path::Path;

use planesman_fit::FitOptions;
use planesman_fit::declaration::{Declaration, OptionGroup as _};

const COMMITTED: &str = include_str!("../../python/planesman/_options.py");

const HEAD: &str = r#""""The options of `fit`, as the library declares them. This file is written by the test python_options::, which compares it."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import Literal, TypedDict

Path = str | PathLike[str]
Span = tuple[float | None, float | None]


class FitOptions(TypedDict, total=False):
    """The options of `fit` and `fit_all`: those of `planesman sysid fit`, of which docs/sysid.md says more."""

"#;

/// The longest line of a docstring.
const WIDTH: usize = 140;

/// An option with its type and its docstring.
fn field(option: &Declaration) -> String {
    let doc = option.doc(|name, value| match value {
        None => format!("`{name}`"),
        Some(value) => format!("`{name}=\"{value}\"`"),
    });
    let mut lines = vec!["    \"\"\"".to_owned()];
    for (place, word) in doc.split(' ').enumerate() {
        let last = lines.last_mut().expect("a line");
        match last.len() + word.len() < WIDTH {
            true if place == 0 => *last += word,
            true => *last += &format!(" {word}"),
            false => lines.push(format!("    {word}")),
        }
    }
    format!(
        "    {}: {}\n{}\"\"\"\n",
        option.name,
        option.python(),
        lines.join("\n")
    )
}

#[test]
fn the_committed_file_is_what_the_declarations_say() {
    let fields = FitOptions::declarations().into_iter().map(field);
    let written = HEAD.to_owned() + &fields.collect::<String>();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("_options.py");
    std::fs::write(&path, &written).expect("written");
    assert!(
        written == COMMITTED,
        "write it anew: cp {} python/planesman/_options.py",
        path.display()
    );
}
