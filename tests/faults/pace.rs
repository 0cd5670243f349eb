//! The three ways in which a vehicle's time goes on.

/// The end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pace {
    Lockstep,
    /// The wall clock, so many times faster.
    Real(u32),
}

pub(crate) const PACES: [Pace; 3] = [Pace::Lockstep, Pace::Real(1), Pace::Real(10)];

impl Pace {
    pub(crate) fn name(self) -> String {
        match self {
            Self::Lockstep => "lockstep".to_owned(),
            Self::Real(factor) => format!("factor_{factor}"),
        }
    }

    /// Whether the vehicle makes `/clock`.
    pub(crate) fn owns_time(self) -> bool {
        self != Self::Real(1)
    }

    /// The arguments of `planesman dive`.
    pub(crate) fn arguments(self) -> Vec<String> {
        match self {
            Self::Lockstep => vec!["--lockstep".to_owned()],
            Self::Real(factor) => vec!["--factor".to_owned(), factor.to_string()],
        }
    }

    /// The length of a short flight, s of vehicle time.
    pub(crate) fn duration(self) -> f64 {
        match self {
            Self::Real(1) => 5.0,
            _ => 20.0,
        }
    }

    /// Ticks after which the loop is in full flight.
    pub(crate) fn early(self) -> i64 {
        match self {
            Self::Real(1) => 20,
            _ => 100,
        }
    }
}
