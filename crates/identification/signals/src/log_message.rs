//! A message of a log of any kind, and what reads them.

use std::io;
use std::rc::Rc;

/// The field of a variable that is one number; a signal may leave it out.
pub(crate) const VALUE: &str = "value";

/// Fields of a message at most.
pub(crate) const FIELDS: usize = 1000;

/// A message of a log.
#[derive(Debug, Default)]
pub(crate) struct LogMessage {
    pub(crate) topic: String,
    /// Who sent it, and which instance it is of.
    pub(crate) labels: [String; 2],
    /// ns.
    pub(crate) stamp: i64,
    pub(crate) names: Rc<[String]>,
    /// One for each name.
    pub(crate) values: Vec<Option<f64>>,
}

impl LogMessage {
    /// Begins a message that has no values yet.
    pub(crate) fn begin(&mut self, topic: &str, stamp: i64, names: &Rc<[String]>) {
        topic.clone_into(&mut self.topic);
        self.labels.iter_mut().for_each(String::clear);
        self.values.clear();
        (self.stamp, self.names) = (stamp, Rc::clone(names));
    }
}

/// The messages of a log, from the first.
pub(crate) trait LogReader {
    /// Reads the next message; returns whether there is one.
    fn next(&mut self, message: &mut LogMessage) -> io::Result<bool>;
    /// The bytes that have been read.
    fn position(&self) -> u64;
    /// What could not be read.
    fn notes(&self) -> Vec<String>;
}
