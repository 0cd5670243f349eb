//! A configuration's orbits: which of them it comes to from where the ram rests at first, and what becomes of one as a parameter
//! changes.

use planesman_console::{Format, Table, wrapped};
use planesman_hydraulics::ActuatorSet;
use planesman_hydraulics::actuator_file::ActuatorFileError;
use planesman_units::{DEGREE, INCH};

use crate::depth_loop::{Case, DiveError};
use crate::limit_cycles::{INCHES, described};
use crate::orbit::Orbit;
use crate::watched::Motion;

/// Places of the ram on either side of the middle.
const PLACES: i32 = 4;
/// Steps from a parameter's value to another.
const STEPS: i32 = 20;
/// How often a step is halved before the orbit has ended.
const HALVED: i32 = 6;

/// The motion from a place of the ram.
#[derive(Clone, Debug)]
pub struct Basin {
    /// Where the ram rests at first, in quanta.
    pub ram: f64,
    /// Where it ends.
    pub motion: Motion,
    /// The mean depth error then, m.
    pub error: f64,
}

/// The motions from nine places of the ram, within half a quantum of the middle.
///
/// # Errors
/// Those of [`Case::run_from`].
pub fn basins(case: &Case) -> Result<Vec<Basin>, DiveError> {
    let mut places: Vec<f64> = (-PLACES..=PLACES)
        .map(|place| 0.5 * f64::from(place) / f64::from(PLACES))
        .collect();
    // From the middle first.
    places.rotate_left(PLACES as usize);
    let motions = case.motions(&places)?.into_iter().zip(places);
    let basins = motions.map(|((dive, motion), ram)| {
        let outputs = &dive.watched.outputs;
        Basin {
            ram,
            motion,
            error: outputs.iter().sum::<f64>() / outputs.len() as f64,
        }
    });
    let mut basins: Vec<Basin> = basins.collect();
    basins.sort_by(|a, b| a.ram.total_cmp(&b.ram));
    Ok(basins)
}

/// The configurations' basins as a table.
#[must_use]
pub fn basins_text(found: &[(&Case, Vec<Basin>)], format: Format) -> String {
    let mut table = Table::new([
        "configuration",
        "M_theta",
        "ram, quanta",
        "motion",
        "f, Hz",
        "depth pp, in",
        "mean error, in",
    ]);
    for (case, basin) in found
        .iter()
        .flat_map(|(case, basins)| basins.iter().map(move |basin| (case, basin)))
    {
        let [frequency, depth] = match &basin.motion {
            Motion::Orbit(orbit) => [
                format!("{:.4}", orbit.turns()),
                format!("{:.4}", orbit.swing() / INCH),
            ],
            _ => ["-", "-"].map(str::to_owned),
        };
        table.row([
            case.name.clone(),
            case.restoring.to_string(),
            format!("{:+.3}", basin.ram),
            described(&basin.motion, INCHES),
            frequency,
            depth,
            format!("{:.4}", basin.error / INCH),
        ]);
    }
    table.text(format)
}

/// A parameter that an orbit is followed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Varied {
    /// Coulomb friction, as a factor.
    Friction,
    /// Both leakages, as a factor.
    Leakage,
    /// The thresholds of the logic, as a factor.
    Threshold,
    /// M_theta, ft lb.
    Restoring,
    /// K_i, 1/s.
    Integral,
}

impl Varied {
    /// Each.
    pub const ALL: [Self; 5] = [
        Self::Friction,
        Self::Leakage,
        Self::Threshold,
        Self::Restoring,
        Self::Integral,
    ];

    /// Its name, and what it is.
    #[must_use]
    pub fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Friction => ("friction", "Coulomb friction, as a factor"),
            Self::Leakage => ("leakage", "Both leakages, as a factor"),
            Self::Threshold => ("threshold", "The logic's thresholds, as a factor"),
            Self::Restoring => ("restoring", "M_theta, ft lb"),
            Self::Integral => ("integral", "K_i, 1/s"),
        }
    }

    /// Its value in a configuration.
    fn of(self, case: &Case) -> f64 {
        match self {
            Self::Friction | Self::Leakage | Self::Threshold => 1.0,
            Self::Restoring => case.restoring,
            Self::Integral => case.integral,
        }
    }

    /// The configuration and its actuator with another value.
    fn set(self, case: &Case, value: f64) -> Result<(Case, ActuatorSet), ActuatorFileError> {
        let (mut case, mut set) = (case.clone(), case.set()?);
        match self {
            Self::Friction => set.coulomb *= value,
            Self::Leakage => {
                set.rate_gain *= value;
                set.error_rate *= value;
            }
            Self::Threshold => {
                set.threshold *= value;
                if let Some(small) = &mut set.small {
                    small.threshold *= value;
                }
            }
            Self::Restoring => case.restoring = value,
            Self::Integral => case.integral = value,
        }
        Ok((case, set))
    }
}

/// An orbit over a parameter.
#[derive(Clone, Debug)]
pub struct Branch {
    /// The values with their orbits, in order.
    pub orbits: Vec<(f64, Orbit)>,
    /// The value before which it ends, where it does.
    pub ends: Option<f64>,
}

/// The orbit of a configuration followed from its parameter's value to another, each from the one before by Newton's method;
/// none where it has no orbit.
///
/// # Errors
/// Those of [`Case::run`].
pub fn branch(case: &Case, varied: Varied, to: f64) -> Result<Option<Branch>, DiveError> {
    let mut dive = case.run()?;
    let (Motion::Orbit(orbit), Some(mut cycle)) = case.motion(&mut dive)? else {
        return Ok(None);
    };
    let mut value = varied.of(case);
    let whole = (to - value) / f64::from(STEPS);
    let mut step = whole;
    let mut orbits = vec![(value, orbit)];
    while value != to {
        let next = match (to - value).abs() <= step.abs() * (1.0 + 1e-9) {
            true => to,
            false => value + step,
        };
        let (changed, set) = varied.set(case, next)?;
        let mut actuation = changed.actuation()?;
        actuation.set = set;
        let around = changed.around();
        let body = cycle.body().within(&around)?;
        let start = cycle.clone().changed(|mut state| {
            state.body = body;
            state.with_actuator(&actuation.set)
        });
        match actuation.orbit(start) {
            Some((orbit, found)) => {
                (value, cycle, step) = (next, found, whole);
                orbits.push((value, orbit));
            }
            None if step.abs() > whole.abs() / f64::from(1 << HALVED) => step *= 0.5,
            None => {
                let ends = Some(next);
                return Ok(Some(Branch { orbits, ends }));
            }
        }
    }
    Ok(Some(Branch { orbits, ends: None }))
}

/// The configurations' branches as a table; for people also where one ends.
#[must_use]
pub fn branches_text(found: &[(&Case, Branch)], varied: Varied, format: Format) -> String {
    let (name, _) = varied.described();
    let mut table = Table::new([
        "configuration",
        "M_theta",
        name,
        "f, Hz",
        "depth pp, in",
        "planes pp, deg",
        "multiplier",
        "deviations",
    ]);
    let mut ends = String::new();
    for (case, branch) in found {
        for (value, orbit) in &branch.orbits {
            table.row([
                case.name.clone(),
                case.restoring.to_string(),
                format!("{value:.4}"),
                format!("{:.4}", orbit.turns()),
                format!("{:.4}", orbit.swing() / INCH),
                format!("{:.4}", orbit.stroke() / DEGREE),
                format!("{:.3}", orbit.growth()),
                if orbit.stable() { "decay" } else { "grow" }.to_owned(),
            ]);
        }
        if let Some(value) = branch.ends {
            ends += &format!(
                "\n{}, M_theta {}: ends before {name} = {value:.4}. There the logic would decide otherwise, or no cycle of these decisions closes.",
                case.name, case.restoring
            );
        }
    }
    let mut text = table.text(format);
    if !ends.is_empty() && matches!(format, Format::Table | Format::Md) {
        text += &wrapped(&format!("{ends}\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth_loop::cases;
    use planesman_linear::Complex;

    #[test]
    fn a_branch_tells_where_deviations_grow() {
        let orbit = |multiplier: f64| Orbit {
            period: 1.0,
            decisions: Vec::new(),
            multipliers: vec![Complex::new(multiplier, 0.0)],
            samples: Vec::new(),
            output: (0.0, 0.0, 0.0),
            angle: (0.0, 0.0),
        };
        let branch = Branch {
            orbits: vec![(1.0, orbit(0.9)), (0.5, orbit(-1042.0))],
            ends: None,
        };
        let case = cases().unwrap().remove(0);
        let text = branches_text(&[(&case, branch)], Varied::Friction, Format::Csv);
        let last = |line: usize| {
            text.lines()
                .nth(line)
                .and_then(|it| it.split(',').next_back())
        };
        assert_eq!((last(1), last(2)), (Some("decay"), Some("grow")), "{text}");
    }
}
