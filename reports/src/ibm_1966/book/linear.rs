//! Numbers of Section V: margins, resonance and bandwidth of the linear model with PS-2.

use planesman_linear::Error;

use crate::book::Recomputed;
use crate::ibm_1966::case::Case;
use crate::ibm_1966::flight_control::FlightControl;
use planesman_hydraulics::linearised::Ram;
use planesman_units::DEGREE;

/// Frequency range of both gain limits, rad/s.
const MARGINS: (f64, f64) = (0.5, 150.0);
/// Frequency range of the resonance, rad/s.
const RESONANCE: (f64, f64) = (2.0, 6.0);
/// Frequency range of the bandwidth, rad/s.
const BANDWIDTH: (f64, f64) = (6.0, 15.0);

/// Values of the family `lin`, for a flight control with the base gains.
///
/// # Errors
/// Errors of the linear model.
pub(super) fn recomputed(case: &Case) -> Result<Recomputed, Error> {
    let plant = case.surrogate.plant();
    let linear = FlightControl::new(&plant, &case.gains, &case.set, Ram::Rigid)?;
    let (frequency, magnitude) = linear.peak(RESONANCE.0, RESONANCE.1);
    let bandwidth = linear.bandwidth(BANDWIDTH.0, BANDWIDTH.1);
    let margins = linear.open_loop.gain_margins(MARGINS.0, MARGINS.1);
    let mut values = vec![
        ("peak.frequency", frequency),
        ("peak.magnitude", magnitude),
        ("bandwidth", bandwidth.unwrap_or(f64::NAN)),
    ];
    if let [crossover] = linear.open_loop.phase_margins()?[..] {
        values.push(("phase_margin.frequency", crossover.frequency));
        values.push(("phase_margin.angle", crossover.margin / DEGREE));
    }
    if let [low, high] = margins[..] {
        values.push(("gain_limits.low_frequency", low.frequency));
        values.push(("gain_limits.low", low.factor));
        values.push(("gain_limits.high_frequency", high.frequency));
        values.push(("gain_limits.high", high.factor));
    }
    Ok(values
        .into_iter()
        .map(|(name, value)| (format!("lin.{}.{name}", case.surrogate), value))
        .collect())
}
