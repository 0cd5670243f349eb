//! The parameters, checked and in the models' own types: what a [`Plant`](crate::core::Plant) flies by.

use planesman_linear::LARGEST_POLE_STEP;
use planesman_vehicle::{
    Axis, Body, BodyMotion, Derivatives, Drive, Environment, Motion, PitchDamping, Restoring,
    Seaway, ShapingFilter, State, Tank, Tether, Turning, Variant, Vehicle,
    linearised::{self, Output},
};

use crate::{
    error::Error,
    parameters::{self, DampingLaw, PlantParameters, Propulsion, RestoringMoment},
    sensors::Sensors,
};

/// The parameters, checked and in the models' own types.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) motion: BodyMotion,
    /// The waves and their filter over a tick; `None`: it is calm.
    pub(crate) seaway: Option<(Seaway, ShapingFilter)>,
    pub(crate) sensors: Sensors,
    pub(crate) initial: Body,
    pub(crate) seed: u64,
    pub(crate) tick_nanos: i64,
    pub(crate) steps: u32,
    vehicle: String,
    pub(crate) frame_prefix: String,
}

impl Settings {
    pub(crate) fn new(parameters: &PlantParameters, vehicle: &Vehicle) -> Result<Self, Error> {
        let (tick_nanos, steps) = tick_and_steps(parameters.tick, parameters.step)?;
        let outside = &parameters.environment;
        let environment = Environment {
            density: outside.density,
            gravity: outside.gravity,
            atmospheric_pressure: outside.atmospheric_pressure,
        };
        let (speed, variant) = (parameters.speed, variant(parameters));
        let vertical = Motion {
            derivatives: variant.of(vehicle.derivatives(speed)),
            restoring: match parameters.restoring {
                RestoringMoment::SmallAngle => Restoring::SmallAngle,
                RestoringMoment::Sine | RestoringMoment::None => Restoring::Sine,
            },
            environment,
            step: tick_nanos as f64 * 1e-9 / f64::from(steps),
        };
        let drive = drive(parameters.propulsion, vehicle, variant)?;
        let design_speed = drive.as_ref().map_or(0.0, |d| d.propulsion.design_speed);
        let fastest = variant.of(vehicle.derivatives(speed.max(design_speed)));
        refuse_fast_modes(vehicle, &fastest, vertical.step)?;
        let turning = |axis: Option<Axis>| {
            axis.map(|axis| Turning::new(axis, vertical.step))
                .transpose()
                .map_err(|reason| Error::Turning {
                    vehicle: vehicle.name.clone(),
                    reason,
                })
        };
        let bottom = outside.bottom;
        let plane = State {
            depth: parameters.initial_depth,
            pitch: parameters.initial_pitch,
            ..State::default()
        };
        Ok(Self {
            motion: BodyMotion {
                vertical,
                roll: turning(vehicle.roll.map(|axis| variant.of_roll(axis)))?,
                course: turning(vehicle.course)?,
                drive,
                current: [outside.current.x, outside.current.y, outside.current.z],
                tank: Tank {
                    bottom: (bottom > 0.0).then_some(bottom),
                },
                tether: Tether {
                    diameter: outside.tether.diameter,
                    drag_coefficient: outside.tether.drag_coefficient,
                    above: outside.tether.above,
                },
            },
            seaway: seaway(&outside.seaway, tick_nanos as f64 * 1e-9)?,
            sensors: parameters::sensors_of(parameters),
            initial: Body::upright(plane, speed),
            seed: parameters.seed,
            tick_nanos,
            steps,
            vehicle: parameters.vehicle.clone(),
            frame_prefix: frame_prefix(&parameters.frame_prefix)?,
        })
    }

    /// The settings that cannot change once the plant is made.
    pub(crate) fn fixed(&self) -> (&str, i64, u32) {
        (&self.vehicle, self.tick_nanos, self.steps)
    }
}

/// The vehicle's derivatives at the speed and in the variant that the parameters ask for.
#[must_use]
pub fn derivatives(parameters: &PlantParameters, vehicle: &Vehicle) -> Derivatives {
    variant(parameters).of(vehicle.derivatives(parameters.speed))
}

fn variant(parameters: &PlantParameters) -> Variant {
    let viscous = parameters.pitch_damping_viscous;
    let rate = parameters.pitch_damping_rate;
    Variant {
        damping: match parameters.pitch_damping {
            DampingLaw::Secant => PitchDamping::Secant { viscous, rate },
            DampingLaw::Tangent => PitchDamping::Tangent { viscous, rate },
            DampingLaw::Quadratic => PitchDamping::Quadratic { viscous },
            DampingLaw::Coefficient => PitchDamping::Coefficient,
        },
        heave_moment: parameters.heave_moment,
        restoring_moment: parameters.restoring != RestoringMoment::None,
        heave: true,
    }
}

/// The tick in whole nanoseconds, and how many steps it is.
fn tick_and_steps(tick: f64, step: f64) -> Result<(i64, u32), Error> {
    let [tick_nanos, step_nanos] = [tick, step].map(|seconds| (seconds * 1e9).round() as i64);
    if step_nanos <= 0 || tick_nanos <= 0 || tick_nanos % step_nanos != 0 {
        return Err(Error::Steps { step, tick });
    }
    let steps =
        u32::try_from(tick_nanos / step_nanos).map_err(|_| Error::SmallStep { step, tick })?;
    Ok((tick_nanos, steps))
}

/// Thrust and drag, when the speed is not held.
fn drive(
    propulsion: Propulsion,
    vehicle: &Vehicle,
    variant: Variant,
) -> Result<Option<Drive>, Error> {
    if propulsion == Propulsion::Held {
        return Ok(None);
    }
    let Some(propulsion) = vehicle.propulsion else {
        return Err(Error::NoPropulsion(vehicle.name.clone()));
    };
    Ok(Some(Drive {
        propulsion,
        vehicle: vehicle.clone(),
        variant,
    }))
}

/// The waves asked for; `None` when it is calm.
fn seaway(waves: &parameters::Seaway, tick: f64) -> Result<Option<(Seaway, ShapingFilter)>, Error> {
    let seaway = Seaway {
        force: waves.force,
        moment: waves.moment,
        period: waves.period,
        damping: waves.damping,
    };
    if seaway.is_calm() {
        return Ok(None);
    }
    let filter = seaway.filter(tick).map_err(Error::Seaway)?;
    Ok(Some((seaway, filter)))
}

/// Refuses a step that the vehicle's fastest mode would outrun.
fn refuse_fast_modes(vehicle: &Vehicle, fastest: &Derivatives, step: f64) -> Result<(), Error> {
    let speed = fastest.speed;
    let poles = linearised::response(fastest, Output::PitchRate)
        .and_then(|system| system.poles())
        .map_err(|reason| Error::Speed {
            vehicle: vehicle.name.clone(),
            speed,
            reason,
        })?;
    let fastest = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    if fastest * step > LARGEST_POLE_STEP {
        return Err(Error::FastMode {
            step,
            vehicle: vehicle.name.clone(),
            mode: fastest,
            speed,
        });
    }
    Ok(())
}

fn frame_prefix(prefix: &str) -> Result<String, Error> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
    if prefix.len() > 100 || !prefix.chars().all(allowed) {
        return Err(Error::FramePrefix(prefix.escape_debug().to_string()));
    }
    Ok(prefix.to_owned())
}
