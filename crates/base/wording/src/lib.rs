//! Names of options in messages. A library names an option by its field; each front end sets once how its users write options.

use std::fmt::{self, Display};
use std::sync::OnceLock;

/// Form of options in messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wording {
    /// Fields: `max_gap 2`.
    #[default]
    Fields,
    /// Command-line options: `--max-gap 2`.
    CommandLine,
    /// Python keyword arguments: `max_gap=2`.
    Python,
}

static WORDING: OnceLock<Wording> = OnceLock::new();

/// Sets the form for all messages of this process; only the first call has an effect.
pub fn use_wording(wording: Wording) {
    WORDING.get_or_init(|| wording);
}

/// An option, by its field's name.
#[must_use]
pub const fn option(name: &str) -> Setting<'_, &'static str> {
    Setting { name, value: None }
}

/// An option with a value; a value in capitals is a placeholder.
#[must_use]
pub const fn setting<T: Display>(name: &str, value: T) -> Setting<'_, T> {
    Setting {
        name,
        value: Some(value),
    }
}

/// An option with or without a value, formatted in the form of the process.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a, T> {
    name: &'a str,
    value: Option<T>,
}

impl<T: Display> Setting<'_, T> {
    fn write(&self, f: &mut fmt::Formatter<'_>, wording: Wording) -> fmt::Result {
        let name = self.name;
        match (wording, &self.value) {
            (Wording::Fields, None) => f.write_str(name),
            (Wording::Fields, Some(value)) => write!(f, "{name} {value}"),
            (Wording::CommandLine, None) => write!(f, "--{}", name.replace('_', "-")),
            (Wording::CommandLine, Some(value)) => {
                write!(f, "--{} {value}", name.replace('_', "-"))
            }
            (Wording::Python, None) => f.write_str(name),
            (Wording::Python, Some(value)) => python(f, name, &value.to_string()),
        }
    }
}

impl<T: Display> Display for Setting<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, WORDING.get().copied().unwrap_or_default())
    }
}

/// Defines an enum whose values each have a word, used in options and files, and optionally a line of help from the doc comment.
#[macro_export]
macro_rules! choices {
    (
        $(#[$meta:meta])*
        $vis:vis enum $enum:ident {
            $($(#[$of:meta])* $value:ident = $name:literal: $about:expr,)+
        }
    ) => {
        $crate::choices! {
            $(#[$meta])*
            $vis enum $enum {
                $(#[doc = $about] $(#[$of])* $value = $name,)+
            }
        }

        impl $enum {
            /// Word and line of help.
            #[must_use]
            $vis const fn described(self) -> (&'static str, &'static str) {
                match self {
                    $(Self::$value => ($name, $about),)+
                }
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $enum:ident {
            $($(#[$of:meta])* $value:ident = $name:literal,)+
        }
    ) => {
        $(#[$meta])*
        $vis enum $enum {
            $($(#[$of])* $value,)+
        }

        impl $enum {
            /// All values.
            $vis const ALL: [Self; [$($name),+].len()] = [$(Self::$value),+];

            /// Word of the value.
            #[must_use]
            $vis const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)+
                }
            }
        }
    };
}

/// A Python keyword argument: numbers and placeholders unchanged, ranges as pairs, words in quotes. Options that write files are methods of the
/// model; changes of a scenario are named by what they change.
fn python(f: &mut fmt::Formatter<'_>, name: &str, value: &str) -> fmt::Result {
    let stands = |it: &str| it.len() > 1 && it.chars().all(|c| c.is_ascii_uppercase() || c == ':');
    let is_number = |it: &str| it.parse::<f64>().is_ok();
    let edge = |it: &str| match it {
        "" => "None".to_owned(),
        it => it.to_lowercase(),
    };
    match (name, value.split_once("..")) {
        ("model", _) => write!(f, "model.save('{value}')"),
        ("html", _) => f.write_str("model.plot()"),
        ("set" | "vary", _) => f.write_str(value),
        (_, Some((from, to))) => write!(f, "{name}=({}, {})", edge(from), edge(to)),
        _ if is_number(value) || stands(value) || value == "N" => write!(f, "{name}={value}"),
        _ => write!(f, "{name}='{value}'"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct By<'a>(Setting<'a, &'a str>, Wording);

    impl Display for By<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.0.write(f, self.1)
        }
    }

    #[test]
    fn an_option_is_written_as_the_user_of_each_front_end_writes_it() {
        let cases = [
            (option("max_gap"), ["max_gap", "--max-gap", "max_gap"]),
            (setting("order", "3"), ["order 3", "--order 3", "order=3"]),
            (
                setting("method", "armax"),
                ["method armax", "--method armax", "method='armax'"],
            ),
            (
                setting("window", "FROM..TO"),
                ["window FROM..TO", "--window FROM..TO", "window=(from, to)"],
            ),
            (
                setting("window", "..5"),
                ["window ..5", "--window ..5", "window=(None, 5)"],
            ),
            (
                setting("reference", "TOPIC:FIELD"),
                [
                    "reference TOPIC:FIELD",
                    "--reference TOPIC:FIELD",
                    "reference=TOPIC:FIELD",
                ],
            ),
            (
                setting("model", "model.yaml"),
                [
                    "model model.yaml",
                    "--model model.yaml",
                    "model.save('model.yaml')",
                ],
            ),
            (
                setting("set", "a.b=1"),
                ["set a.b=1", "--set a.b=1", "a.b=1"],
            ),
        ];
        let wordings = [Wording::Fields, Wording::CommandLine, Wording::Python];
        for (setting, expected) in cases {
            assert_eq!(wordings.map(|it| By(setting, it).to_string()), expected);
        }
    }
}
