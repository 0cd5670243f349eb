//! What the program adds to identification: vehicles and pages.
//!
//! - [`page`]: a model with everything there is to know of it, as one HTML page.

use anyhow::{Context, Result, anyhow};
use planesman_vehicle::linearised;
use planesman_vehicle::vehicle_file;
use sysid::fit_command::{self, FitArgs};

pub mod page;

/// Runs `planesman sysid fit`: as `sysid fit`, with heave of a vehicle that is named, and its page.
///
/// # Errors
/// As [`fit_command::fit`] and [`fit_command::tell`]; a vehicle that is refused; a page that cannot be drawn or
/// written.
pub fn fit(args: &FitArgs) -> Result<()> {
    let named = args.named_vehicle();
    let heave = named.map(|(vehicle, speed)| heave(vehicle, speed));
    let found = fit_command::fit(args, heave.transpose()?)?;
    fit_command::tell(args, &found)?;
    if let Some(path) = &args.html {
        std::fs::write(path, page::page(&found.analysis, &found.record)?)
            .with_context(|| format!("{}", path.display()))?;
        planesman_node::complain!("{}: the page", path.display());
    }
    Ok(())
}

/// nu, zeta, eta and epsilon of a vehicle about level flight: how heave turns it, 1/(m s), is damped, 1/s, and
/// follows pitch rate, m/s, and planes, m/s^2 per rad.
fn heave(vehicle: &str, speed: f64) -> Result<[f64; 4]> {
    let vehicle = vehicle_file::load(vehicle).map_err(|reason| anyhow!("{reason}"))?;
    let linear = linearised::state_space(&vehicle, speed)
        .with_context(|| format!("vehicle '{}' at {speed} m/s", vehicle.name))?;
    // Of heave and pitch rate, which stand first.
    let (a, b) = (&linear.a, &linear.b);
    Ok([a[(1, 0)], -a[(0, 0)], a[(0, 1)], b[(0, 0)]])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn heave_of_the_thesis_vehicle_is_that_of_its_coefficients() {
        // Brunner 1988, Table 1 (p. 41): Z'w -1.295, Z'q + m' 0.196, Z'delta 0.095, M'w 0.088, m' - Z'w_dot 1.046,
        // I'y 0.072 with M'q_dot; 28 in long.
        let (speed, length) = (2.1 * 0.3048, 28.0 * 0.0254);
        let rate = speed / length;
        let expected = [
            0.088 / 0.072 * rate / length,
            1.295 / 1.046 * rate,
            0.196 / 1.046 * rate * length,
            0.095 / 1.046 * rate * speed,
        ];
        let found = heave("brunner", speed).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    }
}
