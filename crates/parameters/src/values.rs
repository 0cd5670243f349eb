//! A complete, valid set of a node's parameters.

use std::collections::BTreeMap;

use crate::{Declaration, Value};

/// Why a parameter, or a parameter file, was not accepted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{reason}", parameter(name))]
pub struct Refusal {
    /// The parameter; empty for a whole file, which the caller names.
    pub name: String,
    /// The value and the rule it breaks.
    pub reason: String,
}

fn parameter(name: &str) -> String {
    match name {
        "" => String::new(),
        name => format!("parameter '{name}': "),
    }
}

/// Declared parameters with their present values. Always complete and valid: a change
/// is accepted whole or refused whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    declarations: Vec<Declaration>,
    values: BTreeMap<&'static str, Value>,
}

impl Values {
    /// The declared defaults.
    #[must_use]
    pub fn defaults(declarations: Vec<Declaration>) -> Self {
        let values = declarations
            .iter()
            .map(|d| (d.name, d.default.clone()))
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

    /// The value of `name`, `None` when it is not declared.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// This set with the changes made, at start-up: read-only parameters may change too.
    ///
    /// # Errors
    /// The first [`Refusal`]: an undeclared name, or a value against its declaration.
    pub fn with(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, Refusal> {
        self.changed(changes, true)
    }

    /// This set with the changes made, at run time: read-only parameters are refused.
    ///
    /// # Errors
    /// The first [`Refusal`]: an undeclared or read-only name, or a value against its declaration.
    pub fn with_live(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, Refusal> {
        self.changed(changes, false)
    }

    fn changed(
        &self,
        changes: impl IntoIterator<Item = (String, Value)>,
        starting: bool,
    ) -> Result<Self, Refusal> {
        let mut new = self.clone();
        for (name, value) in changes {
            let Some(declaration) = self.declaration(&name) else {
                return Err(Refusal {
                    name,
                    reason: "it is not declared".to_owned(),
                });
            };
            let value = declaration.accept(value)?;
            if declaration.read_only && !starting && self.values.get(name.as_str()) != Some(&value)
            {
                return Err(Refusal {
                    name,
                    reason: "it is read-only: set it when the node starts".to_owned(),
                });
            }
            new.values.insert(declaration.name, value);
        }
        Ok(new)
    }

    /// The double `name`.
    ///
    /// # Panics
    /// When no double of that name is declared: a mistake in the program, not in its input.
    #[must_use]
    pub fn double(&self, name: &str) -> f64 {
        match self.values.get(name) {
            Some(Value::Double(v)) => *v,
            other => panic!("no double parameter '{name}' is declared ({other:?})"),
        }
    }

    /// The integer `name`. Panics as [`Values::double`] does.
    #[must_use]
    pub fn integer(&self, name: &str) -> i64 {
        match self.values.get(name) {
            Some(Value::Integer(v)) => *v,
            other => panic!("no integer parameter '{name}' is declared ({other:?})"),
        }
    }

    /// The boolean `name`. Panics as [`Values::double`] does.
    #[must_use]
    pub fn bool(&self, name: &str) -> bool {
        match self.values.get(name) {
            Some(Value::Bool(v)) => *v,
            other => panic!("no bool parameter '{name}' is declared ({other:?})"),
        }
    }

    /// The text `name`. Panics as [`Values::double`] does.
    #[must_use]
    pub fn string(&self, name: &str) -> &str {
        match self.values.get(name) {
            Some(Value::String(v)) => v,
            other => panic!("no string parameter '{name}' is declared ({other:?})"),
        }
    }

    /// The list of texts `name`. Panics as [`Values::double`] does.
    #[must_use]
    pub fn strings(&self, name: &str) -> &[String] {
        match self.values.get(name) {
            Some(Value::StringArray(v)) => v,
            other => panic!("no string-array parameter '{name}' is declared ({other:?})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gains() -> Values {
        Values::defaults(vec![
            Declaration::new("depth.kp", 0.25, "depth gain")
                .unit("rad/m")
                .range(0.0, 10.0),
            Declaration::new("rate", 20.0, "control rate").read_only(),
            Declaration::new("mode", "depth", "what is held").choices(&["off", "depth"]),
        ])
    }

    #[test]
    fn a_bad_value_is_refused_with_its_name_value_and_rule() {
        for (name, value, rule) in [
            ("depth.kp", Value::Double(f64::NAN), "finite"),
            ("depth.kp", Value::Double(-1.0), "[0, 10] rad/m"),
            ("depth.kp", Value::Bool(true), "a double is declared"),
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
        assert_eq!(before.double("depth.kp"), 0.25);
    }

    #[test]
    fn an_integer_is_taken_where_a_double_is_declared() {
        let values = gains()
            .with([("depth.kp".to_owned(), Value::Integer(2))])
            .expect("accepted");
        assert_eq!(values.double("depth.kp"), 2.0);
    }
}
