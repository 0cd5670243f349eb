//! Error of a refused value.

/// The reason why a parameter, or a parameter file, was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{reason}", parameter(name))]
pub struct Refusal {
    /// Name of the parameter; empty for a whole file, which the caller names.
    pub name: String,
    /// The value and the rule it violates.
    pub reason: String,
}

fn parameter(name: &str) -> String {
    match name {
        "" => String::new(),
        name => format!("parameter '{name}': "),
    }
}
