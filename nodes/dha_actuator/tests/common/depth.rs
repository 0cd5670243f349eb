//! The AUV's depth loop through the digital hydraulic actuator, in inches and degrees.

use dha_actuator::actuator_file::load;
use dha_actuator::depth_loop::Loop;
use dha_actuator::dha::Demand;
use dha_actuator::units::{DEGREE, INCH};

/// What a dive of 3 ft leaves behind between 250 and 500 s.
#[derive(Debug)]
pub(crate) struct LimitCycle {
    /// Depth, peak to peak and mean error, in.
    pub(crate) depth: f64,
    pub(crate) error: f64,
    /// Plane angle, peak to peak, deg.
    pub(crate) planes: f64,
    /// Volumes commanded in a second.
    pub(crate) pulses: f64,
}

/// Dives with the actuator `name`; `asked` is how it is asked for the angle, by the time in s.
pub(crate) fn dive(name: &str, asked: impl Fn(f64) -> Demand) -> LimitCycle {
    let cycle = Loop::default().dive(&load(name).expect("built in"), asked);
    LimitCycle {
        depth: cycle.depth / INCH,
        error: cycle.error / INCH,
        planes: cycle.planes / DEGREE,
        pulses: cycle.pulses,
    }
}
