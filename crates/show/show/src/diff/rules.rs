//! Rules of a comparison: topics and fields to ignore, and tolerances.

use std::str::FromStr;

use planesman_text::did_you_mean;

/// A topic, or one of its fields: `TOPIC`, `TOPIC:FIELD`. A topic is given by its full name or by its end (`state` for `/auv/state`); `*` matches
/// any characters. A field includes all fields within it; a list includes its elements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rule {
    topic: String,
    field: Option<String>,
}

/// A field's absolute tolerance: `TOPIC:FIELD=VALUE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    pub(crate) rule: Rule,
    pub(crate) within: f64,
}

/// Errors of rules.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RuleError {
    /// A text in the wrong form.
    #[error("'{0}': {1} is expected")]
    Form(String, &'static str),
    /// Neither recording has such a topic.
    #[error("'{name}': neither recording has such a topic{meant}")]
    NoTopic {
        /// The name.
        name: String,
        /// The most similar topic, as a question.
        meant: String,
    },
    /// No message of these topics contains such a field.
    #[error("'{topic}:{field}': its messages have no such field")]
    NoField {
        /// The topic.
        topic: String,
        /// The field.
        field: String,
    },
}

impl FromStr for Rule {
    type Err = RuleError;

    fn from_str(text: &str) -> Result<Self, RuleError> {
        let (topic, field) = match text.split_once(':') {
            Some((topic, field)) => (topic, Some(field)),
            None => (text, None),
        };
        if topic.is_empty() || field == Some("") {
            return Err(RuleError::Form(text.to_owned(), "TOPIC or TOPIC:FIELD"));
        }
        Ok(Self {
            topic: topic.to_owned(),
            field: field.map(str::to_owned),
        })
    }
}

impl FromStr for Tolerance {
    type Err = RuleError;

    fn from_str(text: &str) -> Result<Self, RuleError> {
        let read = || {
            let (rule, within) = text.rsplit_once('=')?;
            let within = within.parse().ok().filter(|it: &f64| *it >= 0.0)?;
            let rule: Rule = rule.parse().ok()?;
            Some(Self { rule, within })
        };
        read().ok_or_else(|| {
            RuleError::Form(
                text.to_owned(),
                "TOPIC:FIELD=VALUE (for a table COLUMN=VALUE) with a value of 0 or more",
            )
        })
    }
}

impl Rule {
    /// Whether the rule applies to a topic.
    pub(crate) fn is_of(&self, topic: &str) -> bool {
        let end = topic.get(topic.len().saturating_sub(self.topic.len() + 1)..);
        matches(&self.topic, topic)
            || end.and_then(|it| it.strip_prefix('/')) == Some(&self.topic)
            || topic.split(" [").next() == Some(&self.topic)
    }

    /// The field that the rule names.
    pub(crate) fn field(&self) -> Option<&str> {
        self.field.as_deref()
    }

    /// Whether a field of a matching topic is part of the rule's field; `rates[3]` is part of `rates` and of `rates[]`.
    pub(crate) fn holds(&self, place: &str, of_list: &str) -> bool {
        let Some(field) = &self.field else {
            return true;
        };
        [place, of_list].iter().any(|it| {
            let behind = it.strip_prefix(field.as_str());
            behind.is_some_and(|it| it.is_empty() || it.starts_with(['.', '[']))
        })
    }

    /// Checks that the rule matches one of the topics.
    pub(crate) fn check<'t>(
        &self,
        topics: impl Iterator<Item = &'t str> + Clone,
        has_field: impl Fn(&str, &str) -> bool,
    ) -> Result<(), RuleError> {
        let mut of_it = topics.clone().filter(|it| self.is_of(it)).peekable();
        if of_it.peek().is_none() {
            return Err(RuleError::NoTopic {
                name: self.topic.clone(),
                meant: did_you_mean(&self.topic, topics),
            });
        }
        match &self.field {
            Some(field) if !of_it.any(|it| has_field(it, field)) => Err(RuleError::NoField {
                topic: self.topic.clone(),
                field: field.clone(),
            }),
            _ => Ok(()),
        }
    }
}

/// Whether a text matches a pattern in which `*` matches any characters.
fn matches(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(first) else {
        return false;
    };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else {
        return rest.is_empty();
    };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_and_fields_are_named_in_full_by_their_end_or_by_a_pattern() {
        let rule = |text: &str| text.parse::<Rule>().unwrap();
        for (text, is_its) in [
            ("/auv/state", true),
            ("state", true),
            ("auv/state", true),
            ("*", true),
            ("/auv/*", true),
            ("*/st*e", true),
            ("tate", false),
            ("/auv", false),
            ("/auv/state/x", false),
            ("*/x", false),
        ] {
            assert_eq!(rule(text).is_of("/auv/state"), is_its, "{text}");
        }
        assert!(rule("depth").is_of("depth [m]"));
        assert!(rule("s:a.b").holds("a.b.c", "a.b.c") && rule("s:a").holds("a[3]", "a[]"));
        assert!(
            rule("s:a[].x").holds("a[3].x", "a[].x") && rule("s:a[3]").holds("a[3].x", "a[].x")
        );
        assert!(!rule("s:a").holds("ab", "ab") && !rule("s:a[2]").holds("a[3]", "a[]"));
        let tolerance: Tolerance = "state:depth=1e-9".parse().unwrap();
        assert_eq!(
            (tolerance.within, tolerance.rule.field()),
            (1e-9, Some("depth"))
        );
        for text in ["state:depth", "state:=1", "x:y=-1", "x:y=nan", "x:y=z"] {
            assert!(text.parse::<Tolerance>().is_err(), "{text}");
        }
        assert!(":x".parse::<Rule>().is_err());
    }
}
