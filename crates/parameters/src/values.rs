//! A complete, valid set of a node's parameters.

use std::collections::BTreeMap;

use planesman_text::did_you_mean;

use crate::{Declaration, ParameterType, Refusal, Value};

/// Declared parameters with their present values. Always complete and valid: a change
/// is accepted whole or refused whole.
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
                let declared = self.declarations.iter().map(|d| d.name.as_str());
                let reason = format!("it is not declared{}", did_you_mean(&name, declared));
                return Err(Refusal { name, reason });
            };
            let value = declaration.accept(value)?;
            if declaration.read_only && !starting && self.values.get(name.as_str()) != Some(&value)
            {
                return Err(Refusal {
                    name,
                    reason: "it is read-only: set it when the node starts".to_owned(),
                });
            }
            new.values.insert(name, value);
        }
        Ok(new)
    }

    /// The value of `name` in its Rust type.
    ///
    /// # Errors
    /// A [`Refusal`] when the name is not declared, or declared with another type.
    pub fn read<T: ParameterType>(&self, name: &str) -> Result<T, Refusal> {
        let refuse = |reason: String| Refusal {
            name: name.to_owned(),
            reason,
        };
        let value = self
            .get(name)
            .ok_or_else(|| refuse("it is not declared".to_owned()))?;
        T::from_value(value)
            .ok_or_else(|| refuse(format!("{value} refused: another type is declared")))
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
    fn an_integer_is_taken_where_a_double_is_declared() {
        let values = gains()
            .with([("depth.kp".to_owned(), Value::Integer(2))])
            .expect("accepted");
        assert_eq!(read(&values).depth.kp, 2.0);
    }
}
