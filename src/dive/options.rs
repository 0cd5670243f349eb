//! How a dive is run, and what keeps two of them apart.

use anyhow::{Result, bail};
use planesman_node::claim::Claim;

/// The end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// When every member has answered.
    Lockstep,
    /// By the wall clock.
    Real {
        /// The real-time factor.
        factor: f64,
        /// Stamps from 0, `/clock` published.
        sim_time: bool,
    },
}

impl Pace {
    /// Whether the vehicle makes `/clock`.
    pub(super) fn owns_time(self) -> bool {
        match self {
            Self::Lockstep => true,
            Self::Real { sim_time, .. } => sim_time,
        }
    }
}

/// How a dive is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The end of a tick.
    pub pace: Pace,
    /// Keep the loop running until Ctrl-C.
    pub keep_running: bool,
    /// Show the dive on a page in the browser.
    pub watch: bool,
    /// The namespace of all nodes.
    pub namespace: String,
    /// The scenario's name or file.
    pub scenario: String,
    /// Print all numbers of the flight.
    pub verbose: bool,
}

/// Ends this dive if another one holds the claim; of several at once exactly one continues.
pub(super) fn yield_to_other_dive(claim: &Claim, options: &Options) -> Result<()> {
    if let Some(holder) = claim.holder() {
        bail!(
            "another dive, {holder}, runs in namespace {}; wait for its end, or choose another ROS_DOMAIN_ID or \
             --namespace",
            options.namespace
        );
    }
    Ok(())
}
