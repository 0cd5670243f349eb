//! The values of a payload, by the paths that were asked for.

use std::fmt::Write as _;

use crate::key::{Name, NameKind};

/// The values that a decoder read: for each path a list, of one number for a number, of none for a missing element.
#[derive(Clone, Debug, Default)]
pub struct Values {
    pub(crate) slots: Vec<Vec<f64>>,
    pub(crate) names: Vec<String>,
    /// What messages are called, by slot; empty where one is not there.
    pub(crate) texts: Vec<Name>,
    /// What the message looked at is called.
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

    /// The values at path `index`: all elements of a list, one for a number, none if it is missing.
    #[must_use]
    pub fn list(&self, index: usize) -> &[f64] {
        self.slots.get(index).map_or(&[], Vec::as_slice)
    }

    /// The names that a decoder of names read.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number path `index` led to, the first of a list; `None` if it is not there.
    #[must_use]
    pub fn number(&self, index: usize) -> Option<f64> {
        self.list(index).first().copied()
    }
}
