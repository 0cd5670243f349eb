//! The faults of the envelope, with the names shown to the operator.

/// The way in which the vehicle left its envelope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Too deep.
    Floor,
    /// Too shallow.
    Ceiling,
    /// The bow is too far down.
    BowDown,
    /// The bow is too far up.
    BowUp,
    /// The vehicle's state is missing.
    Silence,
}

impl Fault {
    /// A description for the operator.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Floor => "deeper than safety.floor",
            Self::Ceiling => "shallower than safety.ceiling",
            Self::BowDown => "bow further down than safety.pitch allows",
            Self::BowUp => "bow further up than safety.pitch allows",
            Self::Silence => "no vehicle state within state_timeout",
        }
    }
}
