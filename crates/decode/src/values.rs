//! The values of a payload, by the paths that were asked for.

/// The values that a decoder read: for each path a list, of one number for a number, of none for a missing element.
#[derive(Clone, Debug, Default)]
pub struct Values {
    pub(crate) slots: Vec<Vec<f64>>,
    pub(crate) names: Vec<String>,
}

impl Values {
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
