//! Values of a payload, by requested path.

use std::fmt::Write as _;

use crate::key::{Name, NameKind};

/// The values read by a decoder: one list per path, with one number for a number, and no number for a missing element.
#[derive(Clone, Debug, Default)]
pub struct Values {
    pub(crate) slots: Vec<Vec<f64>>,
    pub(crate) names: Vec<String>,
    /// Names of messages, by slot; empty if missing.
    pub(crate) texts: Vec<Name>,
    /// Name of the present message.
    pub(crate) name: Name,
}

impl Values {
    /// Sets a name.
    pub(crate) fn put_name(&mut self, slot: usize, text: &str, kind: NameKind) {
        if let Some(place) = self.texts.get_mut(slot) {
            place.set(text, kind);
        }
    }

    /// Sets a name to the length of a list.
    pub(crate) fn put_length(&mut self, slot: usize, count: u64) {
        self.put_name(slot, "", NameKind::Counted);
        if let Some(place) = self.texts.get_mut(slot) {
            // Writing to memory never fails.
            let _ = write!(place.text, "{count} numbers");
        }
    }

    /// Values at path `index`: all elements of a list, one value for a number, no value if it is missing.
    #[must_use]
    pub fn list(&self, index: usize) -> &[f64] {
        self.slots.get(index).map_or(&[], Vec::as_slice)
    }

    /// Names read by a decoder of names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number at path `index`, or the first number of a list; `None` if it is missing.
    #[must_use]
    pub fn number(&self, index: usize) -> Option<f64> {
        self.list(index).first().copied()
    }
}
