//! A message of any kind of log, and the trait of its readers.

use std::io;
use std::rc::Rc;

/// The field name of a variable with a single number; a signal may omit it.
pub(crate) const VALUE: &str = "value";

/// Maximum number of fields in a message.
pub(crate) const FIELDS: usize = 1000;

/// A message of a log.
#[derive(Debug, Default)]
pub(crate) struct LogMessage {
    pub(crate) topic: String,
    /// The sender and the instance.
    pub(crate) labels: [String; 2],
    /// ns.
    pub(crate) stamp: i64,
    pub(crate) names: Rc<[String]>,
    /// One value for each name.
    pub(crate) values: Vec<Option<f64>>,
}

impl LogMessage {
    /// Begins a message without values.
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
    /// The number of bytes read so far.
    fn position(&self) -> u64;
    /// Notes on data that could not be read.
    fn notes(&self) -> Vec<String>;
}
