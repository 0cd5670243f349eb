//! The checked parameters in the models' own types, which a [`Plant`](crate::core::Plant) uses.

use planesman_parameters::Choice as _;
use planesman_vehicle::{
    Body, BodyMotion, DepthLimits, Derivatives, Drive, Environment, GeneralisedForce, Inputs,
    Motion, PitchDamping, Restoring, Seaway, ShapingFilter, State, Tether, Variant, Vehicle,
    six_dof::{Sea, Tick},
};

use crate::{
    craft::{self, Equations, SixDof, VehicleModel},
    error::Error,
    parameters::{self, DampingLaw, PlantParameters, Propulsion, RestoringMoment},
    sensors::Sensors,
};

/// The parameters, checked and in the models' own types.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) equations: Equations,
    pub(crate) environment: Environment,
    /// Waves and their filter over a tick; `None` in calm water.
    pub(crate) seaway: Option<(Seaway, ShapingFilter)>,
    pub(crate) sensors: Sensors,
    pub(crate) initial: Body,
    /// The drag `N |q| q`, if pitch damping uses a straight line instead of this drag.
    pub(crate) drag: Option<Drag>,
    pub(crate) seed: u64,
    pub(crate) tick_nanos: i64,
    pub(crate) steps: u32,
    vehicle: String,
    pub(crate) frame_prefix: String,
    pub(crate) map_to_odom: bool,
}

impl Settings {
    pub(crate) fn new(parameters: &PlantParameters, craft: &VehicleModel) -> Result<Self, Error> {
        let tick_nanos = (parameters.tick * 1e9).round() as i64;
        let tick = tick_nanos as f64 * 1e-9;
        let steps = (tick / parameters.step - 1e-9).ceil();
        let outside = &parameters.environment;
        let environment = Environment {
            density: outside.density,
            gravity: outside.gravity,
            atmospheric_pressure: outside.atmospheric_pressure,
        };
        let step = tick / steps;
        let equations = match craft {
            VehicleModel::Plane(vehicle) => Equations::Plane(Box::new(of_the_plane(
                parameters,
                vehicle,
                environment,
                step,
            )?)),
            VehicleModel::SixDof(tick) => of_six_degrees(parameters, tick, step)?,
        };
        let plane = State {
            depth: parameters.initial_depth,
            pitch: parameters.initial_pitch,
            ..State::default()
        };
        Ok(Self {
            equations,
            environment,
            seaway: seaway(&outside.seaway, tick)?,
            sensors: parameters::sensors_of(parameters),
            initial: Body::upright(plane, parameters.speed),
            drag: drag(parameters),
            seed: parameters.seed,
            tick_nanos,
            steps: steps as u32,
            vehicle: parameters.vehicle.clone(),
            frame_prefix: frame_prefix(&parameters.frame_prefix)?,
            map_to_odom: parameters.map_to_odom,
        })
    }

    /// Settings that are fixed after creation.
    pub(crate) fn fixed(&self) -> (&str, i64, u32) {
        (&self.vehicle, self.tick_nanos, self.steps)
    }
}

/// Equations of a vehicle of the vertical plane.
fn of_the_plane(
    parameters: &PlantParameters,
    vehicle: &Vehicle,
    environment: Environment,
    step: f64,
) -> Result<BodyMotion, Error> {
    let (outside, variant) = (&parameters.environment, variant(parameters));
    Ok(BodyMotion {
        vertical: Motion {
            derivatives: variant.apply(vehicle.derivatives(parameters.speed)),
            restoring: match parameters.restoring {
                RestoringMoment::SmallAngle => Restoring::SmallAngle,
                RestoringMoment::Sine | RestoringMoment::None => Restoring::Sine,
            },
            environment,
            step,
        },
        roll: vehicle.roll.map(|axis| variant.apply_to_roll(axis)),
        yaw: vehicle.yaw,
        drive: drive(parameters.propulsion, vehicle, variant)?,
        current: [outside.current.x, outside.current.y, outside.current.z],
        depth_limits: DepthLimits {
            bottom: (outside.bottom > 0.0).then_some(outside.bottom),
        },
        tether: Tether {
            diameter: outside.tether.diameter,
            drag_coefficient: outside.tether.drag_coefficient,
            above: outside.tether.above,
        },
    })
}

/// Equations of a vehicle with six degrees of freedom.
fn of_six_degrees(
    parameters: &PlantParameters,
    tick: &Tick,
    step: f64,
) -> Result<Equations, Error> {
    let outside = &parameters.environment;
    let of_the_plane = [
        ("restoring", parameters.restoring != RestoringMoment::Sine),
        (
            "pitch_damping",
            parameters.pitch_damping != DampingLaw::Coefficient,
        ),
        ("heave_moment", !parameters.heave_moment),
        ("environment.tether.diameter", outside.tether.diameter > 0.0),
    ];
    if let Some((parameter, _)) = of_the_plane.into_iter().find(|(_, is_set)| *is_set) {
        return Err(Error::NotOfSixDof {
            parameter,
            vehicle: parameters.vehicle.clone(),
        });
    }
    let bottom = (outside.bottom > 0.0).then_some(outside.bottom);
    // The ground throws out what begins in it, the deeper the harder.
    if let Some(bottom) = bottom.filter(|bottom| parameters.initial_depth > *bottom) {
        return Err(Error::InTheGround {
            depth: parameters.initial_depth,
            bottom,
        });
    }
    Ok(Equations::SixDof(Box::new(SixDof {
        tick: tick.clone(),
        sea: Sea {
            current: [outside.current.x, outside.current.y, outside.current.z],
            has_surface: true,
            bottom,
            ..Sea::default()
        },
        held_speed: (parameters.propulsion == Propulsion::Held).then_some(parameters.speed),
        step,
    })))
}

/// The drag `N |q| q` replaced by a law that is linear about one pitch rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drag {
    /// `N` \[N m s^2/rad^2\]
    viscous: f64,
    /// \[rad/s\]
    pub(crate) rate: f64,
    /// Name of the law.
    pub(crate) law: &'static str,
}

impl Drag {
    /// Sources of heave and pitch energy against the drag: speed, planes, weight and waves at the state and inputs of a tick.
    pub(crate) fn supply(
        &self,
        motion: &BodyMotion,
        body: &Body,
        inputs: &Inputs<'_>,
        waves: GeneralisedForce,
    ) -> Supply {
        let d = Derivatives {
            m_q: 0.0,
            m_qq: -self.viscous,
            ..motion.derivatives(body)
        };
        let planes = d.plane_force(
            inputs.dive_planes.largest(),
            inputs.bow_stern_differential.largest(),
        );
        let lever = match motion.vertical.restoring {
            Restoring::Sine => 1.0,
            Restoring::SmallAngle => body.plane.pitch.abs().max(1.0),
        };
        let tether = motion.tether.moment(
            body.plane.depth,
            d.speed,
            motion.vertical.environment.density,
        );
        Supply {
            force: planes.heave.abs() + waves.heave.abs() + d.excess_weight.abs(),
            moment: planes.pitch.abs()
                + waves.pitch.abs()
                + d.restoring.abs() * lever
                + tether.abs(),
            derivatives: d,
        }
    }
}

/// Upper bounds of the force \[N\] and moment \[N m\] on a hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supply {
    derivatives: Derivatives,
    force: f64,
    moment: f64,
}

impl Supply {
    /// Upper bound of the resulting kinetic energy of heave and pitch \[J\].
    pub(crate) fn most_energy(&self) -> f64 {
        self.derivatives
            .most_kinetic_energy(self.force, self.moment)
    }

    /// Whether this state's bound is not above that of another; the energy grows with force and moment.
    pub(crate) fn is_within(&self, other: &Self) -> bool {
        self.force <= other.force
            && self.moment <= other.moment
            && self.derivatives == other.derivatives
    }
}

fn drag(parameters: &PlantParameters) -> Option<Drag> {
    let law = parameters.pitch_damping;
    let is_linear = matches!(law, DampingLaw::Secant | DampingLaw::Tangent);
    is_linear.then(|| Drag {
        viscous: parameters.pitch_damping_viscous,
        rate: parameters.pitch_damping_rate,
        law: law.name(),
    })
}

/// Derivatives of the vehicle at the speed and in the variant of the parameters.
#[must_use]
pub fn derivatives(parameters: &PlantParameters, craft: &VehicleModel) -> Derivatives {
    variant(parameters).apply(craft::derivatives(craft, parameters.speed))
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

/// Thrust and drag; `None` if the speed is held.
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

/// Waves of the parameters; `None` in calm water.
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

fn frame_prefix(prefix: &str) -> Result<String, Error> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
    if prefix.len() > 100 || !prefix.chars().all(allowed) {
        return Err(Error::FramePrefix(prefix.escape_debug().to_string()));
    }
    Ok(prefix.to_owned())
}
