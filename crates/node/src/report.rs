//! A node's exit report, for the launcher.

use std::{collections::BTreeMap, env, fs, path::PathBuf};

use anyhow::Context as _;
use serde::{Deserialize, Serialize};

use crate::{
    endpoint::{Direction, Endpoint},
    shared::Shared,
};

/// The environment variable that names the file for the report.
pub const VARIABLE: &str = "PLANESMAN_EXIT_REPORT";

/// The number of messages per topic, by absolute name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExitReport {
    /// The node's full name.
    pub node: String,
    /// Messages sent.
    pub published: BTreeMap<String, u64>,
    /// Messages received.
    pub received: BTreeMap<String, u64>,
    /// Messages refused for what they hold, either way; topics with none are left out.
    pub refused: BTreeMap<String, u64>,
    /// Messages that could not be sent; topics with none are left out.
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

    /// Writes the report where [`VARIABLE`] says, if it does. The file appears whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn write(&self) -> anyhow::Result<()> {
        let Some(path) = env::var_os(VARIABLE).map(PathBuf::from) else {
            return Ok(());
        };
        let mut unfinished = path.clone().into_os_string();
        unfinished.push(format!(".{}.part", std::process::id()));
        fs::write(&unfinished, serde_json::to_vec_pretty(self)?)
            .and_then(|()| fs::rename(&unfinished, &path))
            .with_context(|| format!("{VARIABLE}: {}", path.display()))
    }
}
