//! A complete, valid set of a node's parameters.

use std::collections::BTreeMap;

use planesman_text::did_you_mean;

use crate::{Declaration, ParameterType, Refusal, Value};

/// A renamed word in parameter names: old and new.
const RENAMED: (&str, &str) = ("course", "heading");

/// `; the parameter is now called 'NAME'` for a renamed parameter, otherwise `; did you mean 'NAME'?` with the most similar declared name; empty if
/// no name is similar.
#[must_use]
pub fn probably_meant(name: &str, declarations: &[Declaration]) -> String {
    let names = || declarations.iter().map(|d| d.name.as_str());
    let renamed = name.replace(RENAMED.0, RENAMED.1);
    if renamed != name && names().any(|known| known == renamed) {
        return format!("; the parameter is now called '{renamed}'");
    }
    did_you_mean(name, names())
}

/// Declared parameters with their present values. Always complete and valid: changes are accepted or refused as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    declarations: Vec<Declaration>,
    values: BTreeMap<String, Value>,
}

impl Values {
    /// The declared defaults.
    #[must_use]
    pub fn defaults(declarations: Vec<Declaration>) -> Self {
        let values = declarations
            .iter()
            .map(|d| (d.name.clone(), d.default.clone()))
            .collect();
        Self {
            declarations,
            values,
        }
    }

    /// The declarations, in declared order.
    #[must_use]
    pub fn declarations(&self) -> &[Declaration] {
        &self.declarations
    }

    /// The declaration of `name`.
    #[must_use]
    pub fn declaration(&self, name: &str) -> Option<&Declaration> {
        self.declarations.iter().find(|d| d.name == name)
    }

    /// The value of `name`; `None` if it is not declared.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// This set after changes at the start, when read-only parameters may change too.
    ///
    /// # Errors
    /// The first [`Refusal`]: an undeclared name, or a value refused by its declaration.
    pub fn with(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, Refusal> {
        self.changed(changes, true)
    }

    /// This set after changes at run time, when read-only parameters are refused.
    ///
    /// # Errors
    /// The first [`Refusal`]: an undeclared or read-only name, or a value refused by its declaration.
    pub fn with_live(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, Refusal> {
        self.changed(changes, false)
    }

    /// The changes to declared parameters, and a warning about each undeclared one, with the nearest name.
    pub fn declared(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> (Vec<(String, Value)>, Vec<String>) {
        let (known, unknown): (Vec<_>, Vec<_>) = changes
            .into_iter()
            .partition(|(name, _)| self.declaration(name).is_some());
        let line = |(name, _): (String, Value)| {
            let meant = probably_meant(&name, &self.declarations);
            format!("parameter '{name}' is not declared and was ignored{meant}")
        };
        (known, unknown.into_iter().map(line).collect())
    }

    fn changed(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
        starting: bool,
    ) -> Result<Self, Refusal> {
        let mut new = self.clone();
        for (name, value) in changes {
            let Some(declaration) = self.declaration(&name) else {
                let reason = format!(
                    "it is not declared{}",
                    probably_meant(&name, &self.declarations)
                );
                return Err(Refusal { name, reason });
            };
            let value = declaration.accept(value)?;
            if declaration.read_only && !starting && self.values.get(name.as_str()) != Some(&value)
            {
                return Err(Refusal {
                    name,
                    reason: "the parameter is read-only. Set it when you start the node".to_owned(),
                });
            }
            new.values.insert(name, value);
        }
        Ok(new)
    }

    /// The value of `name` as a Rust type.
    ///
    /// # Errors
    /// A [`Refusal`] if the name is not declared, or has another type.
    pub fn read<T: ParameterType>(&self, name: &str) -> Result<T, Refusal> {
        let refuse = |reason: String| Refusal {
            name: name.to_owned(),
            reason,
        };
        let value = self
            .get(name)
            .ok_or_else(|| refuse("the parameter is not declared".to_owned()))?;
        T::from_value(value)
            .ok_or_else(|| refuse(format!("{value} refused: the parameter has another type")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Choice;
    use crate::Parameters;

    #[derive(Clone, Copy, Debug, PartialEq, Choice)]
    enum Mode {
        Off,
        Depth,
    }

    #[derive(Clone, Debug, PartialEq, Parameters)]
    struct Gains {
        depth: Depth,
        /// control rate
        #[parameter(default = 20.0, read_only)]
        rate: f64,
        /// what is held
        #[parameter(default = Mode::Depth)]
        mode: Mode,
        /// samples
        #[parameter(default = 3, range = 1..=6)]
        order: usize,
    }

    #[derive(Clone, Debug, PartialEq, Parameters)]
    struct Depth {
        /// depth gain
        #[parameter(default = 0.25, unit = "rad/m", range = 0.0..=10.0)]
        kp: f64,
    }

    fn gains() -> Values {
        Values::of::<Gains>()
    }

    fn read(values: &Values) -> Gains {
        Gains::from_values(values).expect("declared")
    }

    #[test]
    fn a_struct_is_declared_and_read_by_its_fields() {
        let values = gains();
        let names: Vec<&str> = values
            .declarations()
            .iter()
            .map(|d| d.name.as_str())
            .collect();
        assert_eq!(names, ["depth.kp", "rate", "mode", "order"]);
        assert_eq!(read(&gains()), Gains::default());
        let changed = gains()
            .with([
                ("mode".to_owned(), Value::from("off")),
                ("order".to_owned(), Value::Integer(6)),
            ])
            .expect("accepted");
        assert_eq!((read(&changed).mode, read(&changed).order), (Mode::Off, 6));
        assert!(Gains::from_values(&Values::of::<Depth>()).is_err());
    }

    #[test]
    fn a_bad_value_is_refused_with_its_name_value_and_rule() {
        for (name, value, rule) in [
            ("depth.kp", Value::Double(f64::NAN), "finite"),
            ("depth.kp", Value::Double(-1.0), "[0, 10] rad/m"),
            ("depth.kp", Value::Bool(true), "a number is expected"),
            ("mode", Value::from("climb"), "one of off, depth"),
            ("kp", Value::Double(1.0), "not declared"),
        ] {
            let refusal = gains()
                .with([(name.to_owned(), value)])
                .expect_err("refused")
                .to_string();
            assert!(
                refusal.contains(name) && refusal.contains(rule),
                "{refusal}"
            );
        }
    }

    #[test]
    fn a_set_of_changes_is_taken_whole_or_not_at_all() {
        let before = gains();
        let outcome = before.with_live([
            ("depth.kp".to_owned(), Value::Double(1.0)),
            ("rate".to_owned(), Value::Double(10.0)),
        ]);
        assert!(outcome.is_err());
        assert_eq!(read(&before).depth.kp, 0.25);
    }

    #[test]
    fn what_ros2_param_makes_of_a_value_that_it_has_read_is_taken() {
        let lists = Values::defaults(
            [
                Value::StringArray(vec!["a".to_owned()]),
                Value::DoubleArray(vec![1.0]),
                Value::IntegerArray(vec![1]),
            ]
            .map(|default| Declaration {
                default,
                ..Declaration::of("list".to_owned(), &0.0, "")
            })
            .into(),
        );
        for declaration in lists.declarations() {
            for empty in [
                Value::BoolArray(Vec::new()),
                Value::StringArray(Vec::new()),
                Value::ByteArray(Vec::new()),
            ] {
                let taken = declaration.accept(empty).expect("an empty list");
                assert_eq!(
                    taken.type_with_article(),
                    declaration.default.type_with_article()
                );
            }
            let refusal = declaration.accept(Value::BoolArray(vec![true]));
            assert!(refusal.is_err(), "{refusal:?}");
        }
        let sent = [
            ("mode", Value::Bool(false)),
            ("depth.kp", Value::from("1e+0")),
        ];
        let taken = gains().with(sent.map(|(name, value)| (name.to_owned(), value)));
        let taken = read(&taken.expect("taken"));
        assert_eq!((taken.mode, taken.depth.kp), (Mode::Off, 1.0));
        let on = gains().with([("mode".to_owned(), Value::Bool(true))]);
        assert!(on.is_err(), "{on:?}");
    }

    #[test]
    fn an_integer_is_taken_where_a_double_is_declared() {
        let values = gains()
            .with([("depth.kp".to_owned(), Value::Integer(2))])
            .expect("accepted");
        assert_eq!(read(&values).depth.kp, 2.0);
    }
}
