//! Options with a single declaration, which the library's checks, the command line and Python read.

use std::ops::RangeInclusive;

use planesman_text::did_you_mean;
use planesman_units::{Dimension, Quantity};

use crate::error::{FitError, RuleError};
use crate::rules::{FINITE, Rule, Span, whole};

/// An option's declaration.
#[derive(Debug)]
pub struct Declaration {
    /// Name of the option and of its field.
    pub name: &'static str,
    /// The lines of its doc comment.
    pub(crate) lines: &'static [&'static str],
    /// The section of the help that lists it.
    pub section: &'static str,
    /// The placeholder for the value in the help; if empty, the name in capitals.
    pub value: &'static str,
    /// Its letter.
    pub short: Option<char>,
    /// Another name.
    pub alias: Option<&'static str>,
    /// Its range.
    pub range: Range,
    /// Another option that this one requires.
    pub needs: Option<&'static str>,
    /// Another option that must not be given with this one.
    pub excludes: Option<&'static str>,
    /// Whether the option applies only to a sampled model with one input and one output.
    pub of_one: bool,
    /// Whether the option applies only to signals on a grid.
    pub of_grid: bool,
    /// Its type.
    pub(crate) kind: fn() -> Kind,
}

/// The allowed values, if they are fewer than the type allows.
#[derive(Debug)]
pub enum Range {
    /// All values of the type.
    Any,
    /// Whole numbers.
    Count(RangeInclusive<i64>),
    /// Numbers.
    Number(Rule),
    /// A range of a quantity, in SI; text may use another unit of the dimension.
    Quantity(Dimension, f64, f64),
    /// Pairs of a lower and an upper bound.
    Span(Span),
}

/// The type of an option's value.
#[derive(Debug)]
pub struct Kind {
    /// The option's name in Python.
    python: &'static str,
    /// The allowed words; empty for other types.
    pub words: Vec<Word>,
    /// Number of values that the option takes.
    pub takes: Takes,
    /// Whether a value may begin with a hyphen.
    pub hyphen: bool,
    /// Checks a value without storing it.
    pub accept: fn(&str, &Range) -> Result<(), RuleError>,
}

/// Number of values that an option takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// No value, because the option is a flag.
    Nothing,
    /// One.
    One,
    /// One value for each occurrence of the option.
    Several,
}

/// A word that an option accepts.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// The word.
    pub name: &'static str,
    /// Its help.
    pub about: &'static str,
    /// Synonyms of the word.
    pub also: &'static [&'static str],
}

impl Declaration {
    /// An option without a range.
    pub(crate) const fn new(
        name: &'static str,
        section: &'static str,
        lines: &'static [&'static str],
        kind: fn() -> Kind,
    ) -> Self {
        Self {
            name,
            lines,
            section,
            value: "",
            short: None,
            alias: None,
            range: Range::Any,
            needs: None,
            excludes: None,
            of_one: false,
            of_grid: false,
            kind,
        }
    }

    /// The option's doc comment. `write` formats the options in backticks: a name, or a name with a value as in `` `method frf` ``.
    #[must_use]
    pub fn doc(&self, write: fn(&str, Option<&str>) -> String) -> String {
        let lines: Vec<&str> = self.lines.iter().map(|it| it.trim()).collect();
        let text = lines.join(" ");
        let part = |(place, part): (usize, &str)| match (place % 2, part.split_once(' ')) {
            (0, _) => part.to_owned(),
            (_, None) => write(part, None),
            (_, Some((name, value))) => write(name, Some(value)),
        };
        text.split('`').enumerate().map(part).collect()
    }

    /// Its type.
    #[must_use]
    pub fn kind(&self) -> Kind {
        (self.kind)()
    }

    /// Python's name of the type.
    #[must_use]
    pub fn python(&self) -> String {
        let kind = self.kind();
        let words: Vec<String> = kind
            .words
            .iter()
            .map(|it| format!("{:?}", it.name))
            .collect();
        match (&self.range, kind.takes) {
            _ if !words.is_empty() => format!("Literal[{}]", words.join(", ")),
            (Range::Quantity(..), _) => format!("{} | str", kind.python),
            (_, Takes::Several) => format!("{0} | Sequence[{0}]", kind.python),
            _ => kind.python.to_owned(),
        }
    }
}

/// A group of options.
pub trait OptionGroup: Default {
    /// Each option with its value. Fields without a declaration are not included.
    fn values(&self) -> Vec<(&'static Declaration, &dyn Slot)> {
        Vec::new()
    }

    /// The value of the option with this name.
    fn value_mut(&mut self, _name: &str) -> Option<&mut dyn Slot> {
        None
    }

    /// The declarations, in the order of the fields.
    #[must_use]
    fn declarations() -> Vec<&'static Declaration> {
        let default = Self::default();
        default.values().into_iter().map(|it| it.0).collect()
    }

    /// Parses a value and stores it; an option with several values adds it to the list.
    ///
    /// # Errors
    /// [`FitError::Value`].
    fn put(&mut self, option: &Declaration, text: &str) -> Result<(), FitError> {
        let Some(value) = self.value_mut(option.name) else {
            return Ok(());
        };
        let put = value.put(text, &option.range);
        put.map_err(|rule| FitError::value(option.name, text, rule))
    }

    /// The options whose value is not the default.
    fn given(&self) -> Vec<&'static Declaration> {
        let default = Self::default();
        let both = self.values().into_iter().zip(default.values());
        let given = both.filter(|(value, default)| value.1.written() != default.1.written());
        given.map(|(value, _)| value.0).collect()
    }

    /// Checks each value, and required and conflicting options.
    ///
    /// # Errors
    /// [`FitError::Value`], [`FitError::Needs`], [`FitError::Excludes`].
    fn check_values(&self) -> Result<(), FitError> {
        for (option, value) in self.values() {
            let refused = |(written, rule)| FitError::value(option.name, written, rule);
            value.check(&option.range).map_err(refused)?;
        }
        let given = self.given();
        let is_given = |name: &&str| given.iter().any(|it| it.name == *name);
        for option in &given {
            if let Some(needed) = option.needs.filter(|it| !is_given(it)) {
                return Err(FitError::Needs(option.name, needed));
            }
            if let Some(other) = option.excludes.filter(is_given) {
                return Err(FitError::Excludes(option.name, other));
            }
        }
        Ok(())
    }
}

/// The value of an option: a single value, an optional value, or several.
pub trait Slot {
    /// Its type.
    fn kind() -> Kind
    where
        Self: Sized;
    /// Parses a value and stores or adds it.
    ///
    /// # Errors
    /// [`RuleError`].
    fn put(&mut self, text: &str, range: &Range) -> Result<(), RuleError>;
    /// The value as text, one entry for each.
    fn written(&self) -> Vec<String>;
    /// Checks the value.
    ///
    /// # Errors
    /// The value as text, and the reason why it is refused.
    fn check(&self, range: &Range) -> Result<(), (String, RuleError)>;
}

/// A single value of an option.
pub trait Value: Sized {
    /// Python's name of the type.
    const PYTHON: &'static str;
    /// Number of values that an option of this type takes.
    const TAKES: Takes = Takes::One;
    /// Whether a value may begin with a hyphen; true also for numbers that the range may refuse.
    const HYPHEN: bool = true;

    /// The allowed words.
    #[must_use]
    fn words() -> Vec<Word> {
        Vec::new()
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`RuleError`].
    fn read(text: &str, range: &Range) -> Result<Self, RuleError>;

    /// The value as text, in the form that [`read`](Self::read) parses.
    fn written(&self) -> String;

    /// Checks a value that was not parsed from text.
    ///
    /// # Errors
    /// [`RuleError`].
    fn check(&self, range: &Range) -> Result<(), RuleError> {
        Self::read(&self.written(), range).map(drop)
    }
}

fn kind<T: Value>(takes: Takes) -> Kind {
    Kind {
        python: T::PYTHON,
        words: T::words(),
        takes,
        hyphen: T::HYPHEN,
        accept: |text, range| T::read(text, range).map(drop),
    }
}

fn check_each<'a, T: Value + 'a>(
    values: impl IntoIterator<Item = &'a T>,
    range: &Range,
) -> Result<(), (String, RuleError)> {
    let mut values = values.into_iter();
    values.try_for_each(|it| it.check(range).map_err(|rule| (it.written(), rule)))
}

impl<T: Value> Slot for T {
    fn kind() -> Kind {
        kind::<T>(T::TAKES)
    }

    fn put(&mut self, text: &str, range: &Range) -> Result<(), RuleError> {
        *self = T::read(text, range)?;
        Ok(())
    }

    fn written(&self) -> Vec<String> {
        vec![Value::written(self)]
    }

    fn check(&self, range: &Range) -> Result<(), (String, RuleError)> {
        check_each([self], range)
    }
}

impl<T: Value> Slot for Option<T> {
    fn kind() -> Kind {
        kind::<T>(Takes::One)
    }

    fn put(&mut self, text: &str, range: &Range) -> Result<(), RuleError> {
        *self = Some(T::read(text, range)?);
        Ok(())
    }

    fn written(&self) -> Vec<String> {
        self.iter().map(Value::written).collect()
    }

    fn check(&self, range: &Range) -> Result<(), (String, RuleError)> {
        check_each(self, range)
    }
}

impl<T: Value> Slot for Vec<T> {
    fn kind() -> Kind {
        kind::<T>(Takes::Several)
    }

    fn put(&mut self, text: &str, range: &Range) -> Result<(), RuleError> {
        self.push(T::read(text, range)?);
        Ok(())
    }

    fn written(&self) -> Vec<String> {
        self.iter().map(Value::written).collect()
    }

    fn check(&self, range: &Range) -> Result<(), (String, RuleError)> {
        check_each(self, range)
    }
}

impl Value for bool {
    const PYTHON: &'static str = "bool";
    const TAKES: Takes = Takes::Nothing;

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        match text {
            "True" => Ok(true),
            "False" => Ok(false),
            _ => Err(RuleError::Own("True or False is expected".to_owned())),
        }
    }

    fn written(&self) -> String {
        if *self { "True" } else { "False" }.to_owned()
    }
}

impl Value for usize {
    const PYTHON: &'static str = "int";

    fn read(text: &str, range: &Range) -> Result<Self, RuleError> {
        match range {
            Range::Count(range) => whole(text, range),
            _ => whole(text, &(0..=i64::MAX)),
        }
    }

    fn written(&self) -> String {
        self.to_string()
    }
}

impl Value for f64 {
    const PYTHON: &'static str = "float";

    fn read(text: &str, range: &Range) -> Result<Self, RuleError> {
        match range {
            Range::Number(rule) => rule.parse(text),
            Range::Quantity(dimension, least, most) => {
                let Ok(quantity) = text.parse::<Quantity>();
                let value = quantity.argument_within(*dimension, *least, *most);
                value.map_err(|refusal| RuleError::Own(refusal.to_string()))
            }
            _ => FINITE.parse(text),
        }
    }

    fn written(&self) -> String {
        self.to_string()
    }
}

impl Value for (f64, f64) {
    const PYTHON: &'static str = "Span";

    fn read(text: &str, range: &Range) -> Result<Self, RuleError> {
        match range {
            Range::Span(rule) => rule.parse(text),
            _ => crate::rules::WINDOW.parse(text),
        }
    }

    fn written(&self) -> String {
        format!("{}..{}", self.0, self.1)
    }
}

impl Value for String {
    const PYTHON: &'static str = "str";
    const HYPHEN: bool = false;

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        Ok(text.to_owned())
    }

    fn written(&self) -> String {
        self.clone()
    }
}

/// The item of `all` with this name.
///
/// # Errors
/// [`RuleError::Own`], with a list of the allowed names.
pub fn choose<T: Copy>(
    text: &str,
    all: &[T],
    described: fn(T) -> (&'static str, &'static str),
    also: fn(T) -> &'static [&'static str],
) -> Result<T, RuleError> {
    let is_it = |it: &&T| described(**it).0 == text || also(**it).contains(&text);
    all.iter().find(is_it).copied().ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|it| described(*it).0).collect();
        let meant = did_you_mean(text, names.iter().copied());
        RuleError::Own(format!("possible values are {}{meant}", names.join(", ")))
    })
}

/// Makes enumerations usable as values of options; the second argument gives synonyms of a value.
macro_rules! choices {
    ($($type:ty, $also:expr;)*) => {$(
        impl $crate::declaration::Value for $type {
            const PYTHON: &'static str = "str";
            const HYPHEN: bool = false;

            fn words() -> Vec<$crate::declaration::Word> {
                let word = |it: Self| $crate::declaration::Word {
                    name: it.described().0,
                    about: it.described().1,
                    also: $also(it),
                };
                Self::ALL.map(word).into()
            }

            fn read(text: &str, _: &$crate::declaration::Range) -> Result<Self, $crate::error::RuleError> {
                $crate::declaration::choose(text, &Self::ALL, Self::described, $also)
            }

            fn written(&self) -> String {
                self.described().0.to_owned()
            }
        }
    )*};
}

/// Defines a struct of options. A field with a default is an option. The option's doc comment is the help text of all front ends. After the default
/// follow the fields of its [`Declaration`] that differ from the usual values. A field without a default is a group of options, or a value that is
/// not an option.
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $group:ident in $section:literal {
            $(
                $(#[doc = $line:literal])*
                $name:ident: $type:ty $(= $default:expr $(, $key:ident: $value:expr)*)?;
            )*
        }
    ) => {
        $(#[$meta])*
        pub struct $group {
            $($(#[doc = $line])* pub $name: $type,)*
        }

        impl Default for $group {
            fn default() -> Self {
                Self {
                    $($name: options!(@default $($default)?),)*
                }
            }
        }

        impl $crate::declaration::OptionGroup for $group {
            fn values(&self) -> Vec<(&'static $crate::declaration::Declaration, &dyn $crate::declaration::Slot)> {
                let mut all = Vec::new();
                $(options!(@values all, self.$name, $name: $type, $section, [$($line),*] $(, $default, [$($key: $value),*])?);)*
                all
            }

            fn value_mut(&mut self, name: &str) -> Option<&mut dyn $crate::declaration::Slot> {
                $(options!(@value_mut name, self.$name, $name $(, $default)?);)*
                None
            }
        }
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
    (@values $all:ident, $field:expr, $name:ident: $type:ty, $section:literal, $lines:tt) => {
        $all.extend($crate::declaration::OptionGroup::values(&$field))
    };
    (@values $all:ident, $field:expr, $name:ident: $type:ty, $section:literal, $lines:tt, $default:expr, [$($key:ident: $value:expr),*]) => {{
        static DECLARATION: $crate::declaration::Declaration = $crate::declaration::Declaration {
            $($key: $value,)*
            ..$crate::declaration::Declaration::new(
                stringify!($name),
                $section,
                &$lines,
                <$type as $crate::declaration::Slot>::kind,
            )
        };
        $all.push((&DECLARATION, &$field as &dyn $crate::declaration::Slot));
    }};
    (@value_mut $asked:ident, $field:expr, $name:ident) => {
        if let Some(found) = $crate::declaration::OptionGroup::value_mut(&mut $field, $asked) {
            return Some(found);
        }
    };
    (@value_mut $asked:ident, $field:expr, $name:ident, $default:expr) => {
        if $asked == stringify!($name) {
            return Some(&mut $field);
        }
    };
}

pub(crate) use {choices, options};
