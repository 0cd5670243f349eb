//! Options of a dive, and the check that no two dives share a namespace.

use anyhow::{Result, bail};
use planesman_node::claim::Claim;

/// What ends a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// The answers of all members.
    Lockstep,
    /// The wall clock.
    Real {
        /// The real-time factor.
        factor: f64,
        /// Stamps start at 0, and `/clock` is published.
        sim_time: bool,
    },
}

impl Pace {
    /// Whether the vehicle publishes `/clock`.
    pub(super) fn owns_time(self) -> bool {
        match self {
            Self::Lockstep => true,
            Self::Real { sim_time, .. } => sim_time,
        }
    }
}

/// Options of a dive.
#[derive(Clone, Debug)]
pub struct Options {
    /// What ends a tick.
    pub pace: Pace,
    /// Keep the loop running until Ctrl-C.
    pub keep_running: bool,
    /// Show the dive on a web page.
    pub watch: bool,
    /// The namespace of all nodes.
    pub namespace: String,
    /// Name or file of the scenario.
    pub scenario: String,
    /// Print all numbers of the flight, and each step of the launch.
    pub verbose: bool,
}

/// Ends this dive if another dive holds the claim to the namespace. Of several that start at once exactly one continues.
pub(super) fn yield_to_other_dive(claim: &Claim, options: &Options) -> Result<()> {
    if let Some(holder) = claim.holder() {
        bail!(
            "another dive, {holder}, runs in namespace {}. Wait until it ends, or choose another ROS_DOMAIN_ID or --namespace",
            options.namespace
        );
    }
    Ok(())
}
