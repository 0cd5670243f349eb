//! The position loop alone with a constant command: the limit cycle of drift and quantum, without a moved body.

use planesman_console::{Format, Table};
use planesman_hydraulics::actuator_file::{ActuatorFileError, load};
use planesman_hydraulics::{Demand, Dha, Options};
use planesman_units::DEGREE;

use crate::studies::limit_cycles::described;
use crate::studies::orbit::{Actuation, Body, Lags, State};
use crate::studies::watched::{Done, Motion, Watched};

/// Beginning and end of the observation, ms.
const WATCHED: (i64, i64) = (20_000, 270_000);
/// Nanoseconds per millisecond.
const STEP_NANOS: i64 = 1_000_000;
/// Commanded angle, in quanta: not in the middle of a step.
const HELD: f64 = 3.3;

/// Actuators with their logic options.
const ROWS: [(&str, &str, Options); 7] = [
    ("auv", "single speed", Options::SINGLE_SPEED),
    ("auv", "precision", Options::PRECISION),
    ("auv_two_speed", "two speed", Options::TWO_SPEED),
    ("table_3_1", "single speed", Options::SINGLE_SPEED),
    ("table_3_1", "precision", Options::PRECISION),
    ("table_4_1", "single speed", Options::SINGLE_SPEED),
    ("table_4_1", "precision", Options::PRECISION),
];

/// Constant command without a body.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// Commanded angle, rad.
    angle: f64,
    /// Last angle of the actuator, rad.
    seen: f64,
}

impl Body for Held {
    fn advance(&mut self, [_, _, end]: [f64; 3], _: f64) {
        self.seen = end;
    }

    fn asked(&self) -> f64 {
        self.angle
    }

    fn output(&self) -> f64 {
        self.seen - self.angle
    }

    fn coordinates(&self) -> Vec<f64> {
        Vec::new()
    }

    fn displace(&mut self, _: &[f64]) {}
}

/// An actuator's position loop, with its motion.
#[derive(Clone, Debug)]
pub struct Row {
    /// The actuator's name.
    pub actuator: &'static str,
    /// Name of the logic.
    pub logic: &'static str,
    /// Kind of motion.
    pub motion: Motion,
    /// Simulated cycles per second and stroke, rad, if it follows an orbit.
    pub simulated: Option<(f64, f64)>,
}

/// Position loops of the built-in actuators, each at a constant angle.
///
/// # Errors
/// Errors of the actuators' files, which are compiled in.
pub fn rows() -> Result<Vec<Row>, ActuatorFileError> {
    ROWS.iter()
        .map(|(actuator, name, logic)| {
            let set = load(actuator)?;
            let angle = HELD * set.quantum;
            let demand = Demand {
                logic: *logic,
                ..Demand::angle(angle)
            };
            let mut dha = Dha::new(&set);
            let mut watched = Watched::new(1e-9 * STEP_NANOS as f64, 1e-3 * WATCHED.0 as f64);
            let state = |dha: &Dha, millis: i64| State {
                body: Held { angle, seen: angle },
                hydraulics: *dha.hydraulics(),
                sign: dha.sign(),
                time: 1e-3 * millis as f64,
            };
            // A tenth of a second ago.
            let mut recent = [state(&dha, 0); 2];
            for step in 1..=WATCHED.1 {
                let nanos = step * STEP_NANOS;
                if step % 50 == 0 {
                    recent = [state(&dha, step - 1), recent[0]];
                }
                let before = Done::of(&dha);
                dha.advance_to(nanos, demand);
                if step > WATCHED.0 {
                    let seen = dha.angle(nanos);
                    watched.outputs.push(seen - angle);
                    watched.angles.push(seen);
                    watched.take_decision(&dha, before, (nanos, angle), &recent[1]);
                }
            }
            let actuation = Actuation {
                set,
                logic: *logic,
                position_loop: true,
                lags: Lags {
                    asked: 0.5,
                    measured: 0.5,
                },
            };
            let motion = watched.motion(&actuation);
            let simulated = match &motion {
                Motion::Orbit(orbit) => {
                    let turns = orbit.turns() / (1.0 + watched.apart(orbit).0);
                    Some((turns, watched.stroke(orbit.period)))
                }
                _ => None,
            };
            Ok(Row {
                actuator,
                logic: name,
                motion,
                simulated,
            })
        })
        .collect()
}

/// The table as text.
#[must_use]
pub fn text(rows: &[Row], format: Format) -> String {
    let mut table = Table::new([
        "position loop alone",
        "logic",
        "motion",
        "f, Hz",
        "planes pp, deg",
    ]);
    for row in rows {
        let [frequency, stroke] = match (&row.motion, row.simulated) {
            (Motion::Orbit(orbit), Some((turns, stroke))) => [
                format!("{:.4} ({turns:.4})", orbit.turns()),
                format!("{:.4} ({:.4})", orbit.stroke() / DEGREE, stroke / DEGREE),
            ],
            _ => ["-", "-"].map(str::to_owned),
        };
        table.row([
            row.actuator.to_owned(),
            row.logic.to_owned(),
            described(&row.motion, (DEGREE, "deg")),
            frequency,
            stroke,
        ]);
    }
    table.text(format)
}
