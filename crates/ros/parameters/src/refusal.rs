//! Why a value was not accepted.

/// Why a parameter, or a parameter file, was not accepted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{reason}", parameter(name))]
pub struct Refusal {
    /// The parameter; empty for a whole file, which the caller names.
    pub name: String,
    /// The value and the rule it breaks.
    pub reason: String,
}

fn parameter(name: &str) -> String {
    match name {
        "" => String::new(),
        name => format!("parameter '{name}': "),
    }
}
