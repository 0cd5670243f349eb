//! The simulated vehicle: a model of the vertical plane, or one with six degrees of freedom.

use planesman_vehicle::six_dof::{self, Commands, Conditions, Sea, Tick};
use planesman_vehicle::{
    Acceleration, Body, BodyMotion, Boundary, Contact, Derivatives, GeneralisedForce, Inputs, Port,
    Vehicle,
    vehicle_file::{self, VehicleError},
};

use crate::error::Error;
use crate::parameters::PlantParameters;
use crate::sensors;

/// Model of the vehicle that the parameters name.
#[derive(Clone, Debug)]
pub enum VehicleModel {
    /// Vertical plane, with roll and yaw as separate axes.
    Plane(Box<Vehicle>),
    /// Six coupled degrees of freedom.
    SixDof(Box<Tick>),
}

impl VehicleModel {
    /// Loads the vehicle of that name, or of the file at that path.
    ///
    /// # Errors
    /// If the vehicle is refused.
    pub fn load(parameters: &PlantParameters) -> Result<Self, Error> {
        let (name, base) = (&parameters.vehicle, &parameters.vehicle_base);
        match vehicle_file::load_on(name, base) {
            Err(VehicleError::OfSixDegrees(of)) if of == *name => {
                Self::of_six_degrees(name, six_dof::load(name)?)
            }
            of_the_plane => Ok(Self::Plane(Box::new(of_the_plane?))),
        }
    }

    /// Parses the text of a vehicle file; errors call it `file`.
    ///
    /// # Errors
    /// If the vehicle is refused.
    pub fn parse(file: &str, text: &str) -> Result<Self, Error> {
        match vehicle_file::parse(file, text) {
            Err(VehicleError::OfSixDegrees(_)) => {
                Self::of_six_degrees(file, six_dof::parse(file, text)?)
            }
            of_the_plane => Ok(Self::Plane(Box::new(of_the_plane?))),
        }
    }

    fn of_six_degrees(name: &str, vehicle: six_dof::Vehicle) -> Result<Self, Error> {
        let tick = Tick::new(vehicle).map_err(|reason| Error::Unmoved {
            vehicle: name.to_owned(),
            reason,
        })?;
        Ok(Self::SixDof(Box::new(tick)))
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Plane(vehicle) => &vehicle.name,
            Self::SixDof(tick) => &tick.vehicle().parts().name,
        }
    }

    /// Whether the vehicle has only thrusters.
    #[must_use]
    pub fn is_of_thrusters_alone(&self) -> bool {
        match self {
            Self::Plane(_) => false,
            Self::SixDof(tick) => tick.is_of_thrusters_alone(),
        }
    }

    /// Names of the thrusters, in the order of their commands.
    #[must_use]
    pub fn thrusters(&self) -> &[String] {
        match self {
            Self::Plane(_) => &[],
            Self::SixDof(tick) => tick.thrusters(),
        }
    }

    /// Position of the depth port; a vehicle with six degrees of freedom senses depth at its origin.
    pub(crate) fn depth_port(&self) -> Port {
        match self {
            Self::Plane(vehicle) => vehicle.depth_port,
            Self::SixDof(_) => Port {
                forward: 0.0,
                below: 0.0,
            },
        }
    }
}

/// Equations of motion with the settings from the parameters.
#[derive(Clone, Debug)]
pub(crate) enum Equations {
    /// A vehicle of the vertical plane.
    Plane(Box<BodyMotion>),
    /// A vehicle with six degrees of freedom.
    SixDof(Box<SixDof>),
}

/// A vehicle with six degrees of freedom in its water.
#[derive(Clone, Debug)]
pub(crate) struct SixDof {
    /// The vehicle.
    pub(crate) tick: Tick,
    /// The water.
    pub(crate) sea: Sea,
    /// Surge velocity through the water \[m/s\], if it is held.
    pub(crate) held_speed: Option<f64>,
    /// The longest step \[s\].
    pub(crate) step: f64,
}

impl SixDof {
    fn conditions(&self, load: GeneralisedForce) -> Conditions<'_> {
        Conditions {
            sea: &self.sea,
            time: 0.0,
            holds_speed: self.held_speed.is_some(),
            load: [0.0, 0.0, load.heave, 0.0, load.pitch, 0.0],
            step: self.step,
        }
    }

    /// State of the equations; before the first tick it follows from the body.
    fn state(&self, place: &Place) -> six_dof::State {
        let of_body = || six_dof::State::of_body(&place.body, self.sea.current);
        place.state.unwrap_or_else(of_body)
    }
}

/// State of the vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// State as messages and sensors use it.
    pub(crate) body: Body,
    /// State of a vehicle with six degrees of freedom after its first tick; its attitude is not stored as angles.
    state: Option<six_dof::State>,
    /// State of the thrusters, as shares of full command.
    thrusters: Vec<f64>,
}

impl Place {
    /// State of this body with its thrusters at rest.
    pub(crate) fn of(body: Body) -> Self {
        Self {
            body,
            state: None,
            thrusters: Vec::new(),
        }
    }
}

impl Equations {
    /// Velocity of the water \[m/s\]: forward, right, down in the fixed frame.
    pub(crate) fn current(&self) -> [f64; 3] {
        match self {
            Self::Plane(motion) => motion.current,
            Self::SixDof(six) => six.sea.current,
        }
    }

    /// Depth of the bottom \[m\]; `None` without a bottom.
    pub(crate) fn bottom(&self) -> Option<f64> {
        match self {
            Self::Plane(motion) => motion.depth_limits.bottom,
            Self::SixDof(six) => six.sea.bottom,
        }
    }

    /// Sets the body's speed to the constant speed, if the speed is held constant.
    pub(crate) fn hold_speed(&self, place: &mut Place) {
        match self {
            Self::Plane(motion) if motion.drive.is_none() => {
                place.body.speed = motion.vertical.derivatives.speed;
            }
            Self::Plane(_) => {}
            Self::SixDof(six) => {
                if let Some(speed) = six.held_speed {
                    let from = std::mem::replace(&mut place.body.speed, speed);
                    if let Some(state) = &mut place.state {
                        state.velocity[0] += speed - from;
                    }
                }
            }
        }
    }

    /// Like [`BodyMotion::advance`]; `wanted` are the thrusters' commands.
    pub(crate) fn advance(
        &self,
        from: &Place,
        inputs: &Inputs<'_>,
        wanted: &[f64],
        load: GeneralisedForce,
        steps: u32,
    ) -> Result<(Place, Option<Contact>), Error> {
        match self {
            Self::Plane(motion) => {
                let (body, contact) = motion.advance(&from.body, inputs, load, steps)?;
                Ok((Place::of(body), contact))
            }
            Self::SixDof(six) => {
                let commands = Commands {
                    from: &from.thrusters,
                    to: wanted,
                };
                let (conditions, state) = (six.conditions(load), six.state(from));
                let (after, contact) =
                    (six.tick).advance(&conditions, &state, inputs, commands, steps)?;
                let place = Place {
                    body: after.body(six.sea.current),
                    state: Some(after),
                    thrusters: (six.tick).thrusters_after(commands, f64::from(steps) * six.step),
                };
                Ok((place, contact))
            }
        }
    }

    /// Specific force at the origin \[m/s^2\], forward, left, up.
    pub(crate) fn specific_force(
        &self,
        place: &Place,
        inputs: &Inputs<'_>,
        load: GeneralisedForce,
        gravity: f64,
    ) -> [f64; 3] {
        match self {
            Self::Plane(motion) => {
                let acceleration: Acceleration = motion.acceleration(&place.body, inputs, load);
                sensors::specific_force(&place.body, &acceleration, gravity)
            }
            Self::SixDof(six) => {
                let (conditions, state) = (six.conditions(load), six.state(place));
                let commands = Commands {
                    from: &place.thrusters,
                    to: &place.thrusters,
                };
                let [u, v, w, ..] = six.tick.acceleration(&conditions, &state, inputs, commands);
                sensors::specific_force_of(&state, [u, v, w], gravity)
            }
        }
    }

    /// Depth rate \[m/s\], positive down, and contact with surface or bottom.
    pub(crate) fn depth_rate_and_contact(&self, place: &Place) -> (f64, Option<Boundary>) {
        let Body { plane, .. } = place.body;
        let rate = place.body.depth_rate(self.current());
        match self {
            Self::Plane(motion) => (
                motion.depth_limits.confined_rate(plane.depth, rate),
                motion.depth_limits.touched(plane.depth),
            ),
            Self::SixDof(six) => (rate, six.tick.touched(&six.sea, &six.state(place))),
        }
    }

    /// Equations of the vertical plane; `None` for six degrees of freedom.
    pub(crate) fn plane(&self) -> Option<&BodyMotion> {
        match self {
            Self::Plane(motion) => Some(motion),
            Self::SixDof(_) => None,
        }
    }
}

/// Derivatives of a vehicle's vertical plane at a speed through the water \[m/s\], before any variant of its equations.
pub(crate) fn derivatives(craft: &VehicleModel, speed: f64) -> Derivatives {
    match craft {
        VehicleModel::Plane(vehicle) => vehicle.derivatives(speed),
        VehicleModel::SixDof(tick) => tick.derivatives(speed),
    }
}
