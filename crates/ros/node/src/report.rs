//! A node's exit report for the launcher.

use crate::error::{Error, Result};
use std::{collections::BTreeMap, env, path::Path};

use planesman_text::write_text;
use serde::{Deserialize, Serialize};

use crate::{
    endpoint::{Direction, Endpoint},
    shared::Shared,
};

/// Environment variable with the report's file.
pub const VARIABLE: &str = "PLANESMAN_EXIT_REPORT";

/// Number of messages per topic, by absolute name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExitReport {
    /// The node's full name.
    pub node: String,
    /// Messages sent.
    pub published: BTreeMap<String, u64>,
    /// Messages received.
    pub received: BTreeMap<String, u64>,
    /// Messages refused because of their content, in either direction; topics without any are omitted.
    pub refused: BTreeMap<String, u64>,
    /// Messages that could not be sent; topics without any are omitted.
    pub dropped: BTreeMap<String, u64>,
}

impl ExitReport {
    pub(crate) fn of(shared: &Shared) -> Self {
        let endpoints = shared.endpoints.borrow();
        let sum = |count: fn(&Endpoint) -> Option<u64>| {
            let mut sums = BTreeMap::new();
            for endpoint in endpoints.iter() {
                if let Some(number) = count(endpoint) {
                    *sums.entry(endpoint.topic.clone()).or_insert(0) += number;
                }
            }
            sums
        };
        Self {
            node: shared.names.full(),
            published: sum(|e| (e.direction == Direction::Publisher).then(|| e.passed.get())),
            received: sum(|e| (e.direction == Direction::Subscription).then(|| e.passed.get())),
            refused: sum(|e| Some(e.refused.get()).filter(|n| *n > 0)),
            dropped: sum(|e| Some(e.dropped.get()).filter(|n| *n > 0)),
        }
    }

    /// Writes the report to the file named by [`VARIABLE`], if set. The file appears completely or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn write(&self) -> Result<()> {
        match env::var_os(VARIABLE) {
            None => Ok(()),
            Some(path) => self.write_to(Path::new(&path)),
        }
    }

    fn write_to(&self, path: &Path) -> Result<()> {
        let refused = |reason: String| Error::environment(VARIABLE, reason);
        // A device would be replaced by the file that is moved there.
        if path.metadata().is_ok_and(|there| !there.is_file()) {
            return Err(refused(format!("{} is not a regular file", path.display())));
        }
        serde_json::to_vec_pretty(self)
            .map_err(Into::into)
            .and_then(|text| write_text(path, text))
            .map_err(|reason| refused(format!("{}: {reason}", path.display())))
    }
}

#[cfg(test)]
mod tests {
    use std::{fs, os::unix::net::UnixListener};

    use super::*;

    #[test]
    fn a_report_takes_the_place_of_a_report_alone() {
        let report = ExitReport {
            node: "/auv/plant_sim".to_owned(),
            ..ExitReport::default()
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.json");
        for _ in 0..2 {
            report.write_to(&path).expect("written");
            let text = fs::read(&path).expect("readable");
            let read: ExitReport = serde_json::from_slice(&text).expect("a report");
            assert_eq!(read, report);
        }
        let special = folder.path().join("socket");
        let _socket = UnixListener::bind(&special).expect("made");
        let refusal = report.write_to(&special).expect_err("refused");
        assert!(
            refusal.to_string().contains("not a regular file"),
            "{refusal}"
        );
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }
}
