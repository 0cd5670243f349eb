//! The controller's parameters: the only place where its defaults and ranges stand.
//!
//! The gains are those of program T6 (Brunner, NPS thesis, 1988, App. C): Kpz = 0.25 rad/ft,
//! Kdz = 0.6 rad·s/ft, Kpy = 0.70, Kr = 2 s; the limits those of its ch. II.B.

use planesman_parameters::{Declaration, Value, Values};

use crate::depth_loop::DepthLoop;
use crate::limits::Limit;
use crate::manoeuvre::{Manoeuvre, Signal, TestSignal};
use crate::pitch_loop::PitchLoop;
use crate::schedule::Schedule;

/// Metres in a foot (exact, by definition).
pub const METRES_PER_FOOT: f64 = 0.3048;

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6};
    vec![
        Declaration::new(
            "mode",
            "depth",
            "What is held: off (planes neutral), pitch, or depth; the test signal is added in each.",
        )
        .choices(Mode::NAMES),
        Declaration::new(
            "depth_setpoint",
            0.0,
            "Depth to hold, positive down, until the schedule or the topic says otherwise.",
        )
        .unit("m")
        .range(-1e4, 1e4),
        Declaration::new(
            "pitch_setpoint",
            0.0,
            "Pitch to hold in mode pitch, bow up positive; behind depth.pitch_limit.",
        )
        .unit("rad")
        .range(-FRAC_PI_2, FRAC_PI_2),
        Declaration::new(
            "depth.p",
            0.25 / METRES_PER_FOOT,
            "Dive angle per metre of depth error, Kpz = 0.25 rad/ft (Brunner 1988, program T6).",
        )
        .unit("rad/m")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.d",
            0.6 / METRES_PER_FOOT,
            "Dive angle taken away per m/s of depth rate, Kdz = 0.6 rad s/ft (Brunner 1988, program T6).",
        )
        .unit("rad s/m")
        .range(0.0, 1e3),
        Declaration::new(
            "depth.pitch_limit",
            FRAC_PI_4,
            "Largest pitch command to either side, 45 degrees (Brunner 1988, ch. II.B).",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "pitch.p",
            0.7,
            "Plane angle per pitch error, Kpy = 0.70 (Brunner 1988, program T6).",
        )
        .unit("rad/rad")
        .range(0.0, 1e3),
        Declaration::new(
            "pitch.rate",
            2.0,
            "Plane angle per pitch rate, Kr = 2 s (Brunner 1988, program T6).",
        )
        .unit("s")
        .range(0.0, 1e3),
        Declaration::new(
            "planes.limit",
            FRAC_PI_6,
            "Largest plane command to either side, 30 degrees (Brunner 1988, ch. II.B).",
        )
        .unit("rad")
        .range(0.0, FRAC_PI_2),
        Declaration::new(
            "state_timeout",
            0.5,
            "Silence of the state topic after which the planes are put to neutral.",
        )
        .unit("s")
        .range(1e-3, 3600.0),
        Declaration::new(
            "schedule.times",
            Value::DoubleArray(Vec::new()),
            "When each scheduled depth begins, since the first state; increasing.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "schedule.depths",
            Value::DoubleArray(Vec::new()),
            "The scheduled depths, one for each time; a setpoint from the topic ends the schedule.",
        )
        .unit("m")
        .range(-1e4, 1e4),
        Declaration::new(
            "identification.signal",
            "none",
            "Test signal added to the plane command, so that sysid has something to learn from.",
        )
        .choices(Signal::NAMES),
        Declaration::new(
            "identification.amplitude",
            5.0_f64.to_radians(),
            "The test signal's amplitude, positive dive; within planes.limit.",
        )
        .unit("rad")
        .range(-FRAC_PI_2, FRAC_PI_2),
        Declaration::new(
            "identification.period",
            1.0,
            "A pulse's length; a doublet's, square wave's or sinusoid's period; the prbs' shortest interval.",
        )
        .unit("s")
        .range(1e-3, 1e6),
        Declaration::new(
            "identification.start",
            0.0,
            "When the test signal begins, since the first state.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "identification.duration",
            0.0,
            "How long the test signal lasts; 0 for without end.",
        )
        .unit("s")
        .range(0.0, 1e9),
        Declaration::new(
            "identification.seed",
            1_i64,
            "Where in its cycle of 1023 intervals the pseudo-random sequence starts.",
        ),
    ]
}

/// What the controller holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Planes neutral but for the test signal.
    Off,
    /// Pitch.
    Pitch,
    /// Depth.
    Depth,
}

impl Mode {
    /// The names, as the parameter takes them.
    pub const NAMES: &'static [&'static str] = &["off", "pitch", "depth"];

    fn named(name: &str) -> Result<Self, String> {
        match name {
            "off" => Ok(Self::Off),
            "pitch" => Ok(Self::Pitch),
            "depth" => Ok(Self::Depth),
            other => Err(format!(
                "mode '{other}' refused: it must be one of {}",
                Self::NAMES.join(", ")
            )),
        }
    }
}

/// The parameters as the loops take them: checked each and together.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// What is held.
    pub mode: Mode,
    /// The standing depth setpoint, m.
    pub depth_setpoint: f64,
    /// The standing pitch setpoint, rad, bow up.
    pub pitch_setpoint: f64,
    /// The outer loop.
    pub depth: DepthLoop,
    /// The inner loop.
    pub pitch: PitchLoop,
    /// The largest plane command, rad.
    pub planes_limit: Limit,
    /// Silence of the state after which the planes are put to neutral, s.
    pub state_timeout: f64,
    /// Depth setpoints over time.
    pub schedule: Schedule,
    /// The test signal.
    pub identification: TestSignal,
}

impl Config {
    /// The loops that a set of [`declarations`]' values describes.
    ///
    /// # Errors
    /// A sentence naming the parameter, when values that are each in range do not go
    /// together: a limit of zero, a schedule whose lists do not match or whose times do not
    /// increase, a test signal beyond the plane limit.
    pub fn from_values(values: &Values) -> Result<Self, String> {
        let limit = |name| {
            Limit::new(values.double(name))
                .map_err(|reason| format!("parameter '{name}': {reason}"))
        };
        let planes_limit = limit("planes.limit")?;
        let signal = Signal::named(values.string("identification.signal"))?;
        let manoeuvre = Manoeuvre {
            signal,
            amplitude: values.double("identification.amplitude"),
            period: values.double("identification.period"),
            start: values.double("identification.start"),
            duration: values.double("identification.duration"),
            seed: values.integer("identification.seed"),
        };
        if signal != Signal::None && manoeuvre.amplitude.abs() > planes_limit.bound() {
            return Err(format!(
                "parameter 'identification.amplitude': {} rad refused: planes.limit ({} rad) \
                 would clip the signal",
                manoeuvre.amplitude,
                planes_limit.bound()
            ));
        }
        Ok(Self {
            mode: Mode::named(values.string("mode"))?,
            depth_setpoint: values.double("depth_setpoint"),
            pitch_setpoint: values.double("pitch_setpoint"),
            depth: DepthLoop {
                p: values.double("depth.p"),
                d: values.double("depth.d"),
                pitch_limit: limit("depth.pitch_limit")?,
            },
            pitch: PitchLoop {
                p: values.double("pitch.p"),
                rate: values.double("pitch.rate"),
            },
            planes_limit,
            state_timeout: values.double("state_timeout"),
            schedule: Schedule::new(
                doubles(values, "schedule.times"),
                doubles(values, "schedule.depths"),
            )
            .map_err(|reason| {
                format!("parameters 'schedule.times', 'schedule.depths': {reason}")
            })?,
            identification: manoeuvre
                .build()
                .map_err(|reason| format!("parameters 'identification.*': {reason}"))?,
        })
    }
}

fn doubles<'v>(values: &'v Values, name: &str) -> &'v [f64] {
    match values.get(name) {
        Some(Value::DoubleArray(list)) => list,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn with(changes: &[(&str, Value)]) -> Result<Config, String> {
        let values = Values::defaults(declarations())
            .with(
                changes
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), value.clone())),
            )
            .map_err(|refusal| refusal.to_string())?;
        Config::from_values(&values)
    }

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
            assert!(!declaration.description.is_empty());
        }
        let config = with(&[]).unwrap();
        assert_eq!(config.mode, Mode::Depth);
        assert!((config.depth.p * METRES_PER_FOOT - 0.25).abs() < 1e-15);
    }

    #[test]
    fn values_that_do_not_go_together_are_refused_by_name() {
        for (changes, word) in [
            (vec![("planes.limit", Value::Double(0.0))], "planes.limit"),
            (
                vec![("depth.pitch_limit", Value::Double(0.0))],
                "depth.pitch_limit",
            ),
            (
                vec![("schedule.times", Value::DoubleArray(vec![1.0]))],
                "schedule.depths",
            ),
            (
                vec![
                    ("identification.signal", Value::from("square")),
                    ("identification.amplitude", Value::Double(0.6)),
                ],
                "planes.limit",
            ),
            (vec![("depth.p", Value::Double(f64::NAN))], "depth.p"),
            (vec![("mode", Value::from("climb"))], "mode"),
        ] {
            let refusal = with(&changes).unwrap_err();
            assert!(refusal.contains(word), "{refusal}");
        }
    }
}
