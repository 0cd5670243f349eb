//! A signal by name: `TOPIC:FIELD`, one number of a message.
//!
//! - `TOPIC` is a topic as ROS names it. A name with a leading `/` means only that topic; without the slash, it means any topic that ends in the
//!   name: `state` finds `/auv/state`.
//! - `FIELD` is a path into the message: `pitch_rate`, `position[0]`, `position[shoulder]`, `twist.twist.angular.y`.
//!
//! A field that is a list, without an index, is the signal's time history over the interval that begins at the message's stamp: evenly
//! spaced samples from beginning to end, linear in between (for example `planesman_msgs/PlaneMotion`). A motion as an input gives a mean, by the
//! trapezoid rule, and a first moment; as an output its first sample, the value at the stamp. As an input, a field with a single number is held over
//! the interval.

use std::fmt;
use std::str::FromStr;

use planesman_decode::FieldPath;
use planesman_record::Input;
use thiserror::Error;

/// The largest accepted magnitude. The limit is beyond any physical signal in any unit, and small enough that no sum of squares overflows.
pub const LARGEST: f64 = 1e30;

/// The reason why a signal is refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SignalError {
    /// The text is not a valid signal name.
    #[error("invalid signal '{text}': {rule}; write TOPIC:FIELD, as in odom:twist.twist.angular.y")]
    Syntax {
        /// The text.
        text: String,
        /// The violated rule.
        rule: String,
    },
    /// A message has no number there, for example if a list is empty.
    #[error("signal '{0}': the message has no number in this field")]
    Absent(String),
    /// A number is NaN or infinite.
    #[error("signal '{0}': the number is not finite")]
    NotFinite(String),
    /// A number is beyond [`LARGEST`].
    #[error("signal '{signal}': {number} refused: it must lie within ±{LARGEST:e}")]
    TooLarge {
        /// The signal.
        signal: String,
        /// The number.
        number: f64,
    },
}

/// A reference to one number of one topic's messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signal {
    topic: String,
    path: FieldPath,
}

impl FromStr for Signal {
    type Err = SignalError;

    /// Reads `TOPIC:FIELD`.
    fn from_str(text: &str) -> Result<Self, SignalError> {
        let refuse = |rule: &str| {
            Err(SignalError::Syntax {
                text: text.to_owned(),
                rule: rule.to_owned(),
            })
        };
        let Some((topic, field)) = text.split_once(':') else {
            return refuse("there is no ':'");
        };
        let topic_is_named = topic
            .strip_prefix('/')
            .unwrap_or(topic)
            .split('/')
            .all(is_name);
        if !topic_is_named {
            return refuse("the topic is not a ROS topic name");
        }
        let path = match field.parse() {
            Ok(path) => path,
            Err(reason) => return refuse(&format!("{reason}")),
        };
        Ok(Self {
            topic: topic.to_owned(),
            path,
        })
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.topic, self.path)
    }
}

impl Signal {
    /// The topic, as written.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// The field, as written.
    #[must_use]
    pub fn path(&self) -> &FieldPath {
        &self.path
    }

    /// Whether messages on `topic` contain this signal.
    #[must_use]
    pub fn is_on(&self, topic: &str) -> bool {
        if topic == self.topic {
            return true;
        }
        !self.topic.starts_with('/')
            && topic
                .strip_suffix(self.topic.as_str())
                .is_some_and(|before| before.ends_with('/'))
    }

    /// The signal over the interval that begins at the message's stamp, from the message's numbers.
    ///
    /// # Errors
    /// [`SignalError`], if there is no number, or one is not finite or beyond [`LARGEST`].
    pub fn input(&self, numbers: &[f64]) -> Result<Input, SignalError> {
        self.check(numbers)?;
        Input::through(numbers).ok_or_else(|| self.none())
    }

    /// The signal at the message's stamp.
    ///
    /// # Errors
    /// Like [`Signal::input`].
    pub fn output(&self, numbers: &[f64]) -> Result<f64, SignalError> {
        let first = numbers.first().ok_or_else(|| self.none())?;
        self.check(std::slice::from_ref(first))?;
        Ok(*first)
    }

    fn none(&self) -> SignalError {
        SignalError::Absent(self.to_string())
    }

    /// Refuses the first number that is not finite or beyond [`LARGEST`].
    fn check(&self, numbers: &[f64]) -> Result<(), SignalError> {
        // Written so that NaN is refused too.
        let refused = |number: &&f64| !(-LARGEST..=LARGEST).contains(*number);
        match numbers.iter().find(refused) {
            None => Ok(()),
            Some(number) if !number.is_finite() => Err(SignalError::NotFinite(self.to_string())),
            Some(number) => Err(SignalError::TooLarge {
                signal: self.to_string(),
                number: *number,
            }),
        }
    }
}

/// Whether `name` consists of letters, digits and underscores, and does not begin with a digit.
fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(text: &str) -> Signal {
        text.parse().unwrap()
    }

    #[test]
    fn a_list_is_the_course_over_the_interval() {
        let planes = signal("plane_motion:dive_planes");
        let input = planes.input(&[0.0, 1.0, 2.0]).unwrap();
        assert!((input.mean - 1.0).abs() < 1e-15);
        assert!((input.moment - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(planes.output(&[0.0, 1.0, 2.0]).unwrap(), 0.0);
        assert_eq!(planes.input(&[7.0]).unwrap(), Input::held(7.0));
    }

    #[test]
    fn a_relative_topic_is_found_in_any_namespace_and_an_absolute_one_in_its_own() {
        for (reference, topic, found) in [
            ("state:x", "state", true),
            ("state:x", "/state", true),
            ("state:x", "/auv/state", true),
            ("state:x", "/auv/dha_state", false),
            ("auv/state:x", "/fleet/auv/state", true),
            ("/auv/state:x", "/auv/state", true),
            ("/auv/state:x", "/other/auv/state", false),
            ("/auv/state:x", "state", false),
        ] {
            assert_eq!(signal(reference).is_on(topic), found, "{reference} {topic}");
        }
    }

    #[test]
    fn what_is_no_reference_is_refused_with_the_form() {
        for text in [
            "",
            ":",
            "state",
            "state:",
            ":x",
            "a b:x",
            "state:x..y",
            "state:x[",
            "state:x[a ]",
            "state:x[]",
            "state:x[1]y",
            "state:[1]",
            "9:x",
            "//a:x",
            "a/:x",
        ] {
            let refusal = text.parse::<Signal>().unwrap_err().to_string();
            assert!(refusal.contains("TOPIC:FIELD"), "{refusal}");
        }
    }

    #[test]
    fn what_is_no_finite_number_is_refused_with_the_signals_name() {
        for (numbers, reason) in [
            (&[][..], "no number"),
            (&[f64::NAN], "not finite"),
            (&[1.0, f64::INFINITY], "not finite"),
            (&[-1e31], "1e30"),
        ] {
            let refusal = signal("t:x").input(numbers).unwrap_err().to_string();
            assert!(
                refusal.contains(reason) && refusal.contains("t:x"),
                "{refusal}"
            );
        }
    }
}
