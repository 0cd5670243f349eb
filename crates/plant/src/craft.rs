//! The vehicle that is flown: one of the vertical plane, or one of six degrees of freedom.

use planesman_vehicle::six_dof::{self, Commands, Conditions, Sea, Tick};
use planesman_vehicle::{
    Acceleration, Body, BodyMotion, Boundary, Contact, Derivatives, GeneralisedForce, Inputs, Port,
    Vehicle, vehicle_file,
};

use crate::error::Error;
use crate::parameters::PlantParameters;
use crate::sensors;

/// The vehicle that the parameters name.
#[derive(Clone, Debug)]
pub enum Craft {
    /// Of the vertical plane, with roll and yaw as axes of their own.
    Plane(Box<Vehicle>),
    /// Of six coupled degrees of freedom.
    SixDof(Box<Tick>),
}

impl Craft {
    /// The vehicle of that name, or of the file at that path.
    ///
    /// # Errors
    /// The refusal and its reason.
    pub fn load(parameters: &PlantParameters) -> Result<Self, Error> {
        let (name, base) = (&parameters.vehicle, &parameters.vehicle_base);
        if six_dof::is_one(name) {
            let tick = Tick::new(six_dof::load(name)?).map_err(|reason| Error::Unmoved {
                vehicle: name.clone(),
                reason,
            })?;
            return Ok(Self::SixDof(Box::new(tick)));
        }
        Ok(Self::Plane(Box::new(vehicle_file::load_on(name, base)?)))
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Plane(vehicle) => &vehicle.name,
            Self::SixDof(tick) => &tick.vehicle().parts().name,
        }
    }

    /// Whether thrusters alone move it.
    #[must_use]
    pub fn is_of_thrusters_alone(&self) -> bool {
        match self {
            Self::Plane(_) => false,
            Self::SixDof(tick) => tick.is_of_thrusters_alone(),
        }
    }

    /// The thrusters' names, in the order of their commands.
    #[must_use]
    pub fn thrusters(&self) -> &[String] {
        match self {
            Self::Plane(_) => &[],
            Self::SixDof(tick) => tick.thrusters(),
        }
    }

    /// Where it senses depth: a vehicle of six degrees at its origin.
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

/// How it moves, with what the parameters say of it.
#[derive(Clone, Debug)]
pub(crate) enum Equations {
    /// Of the plane.
    Plane(Box<BodyMotion>),
    /// Of six degrees.
    SixDof {
        /// The vehicle.
        tick: Box<Tick>,
        /// The water.
        sea: Sea,
        /// Surge through the water \[m/s\], where it is held.
        held_speed: Option<f64>,
        /// The longest step \[s\].
        step: f64,
    },
}

/// Where the vehicle is.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// As messages and sensors see it.
    pub(crate) body: Body,
    /// Of a vehicle of six degrees, whose attitude has no angles.
    state: Option<six_dof::State>,
    /// Where its thrusters are, as shares of full command.
    thrusters: Vec<f64>,
}

impl Equations {
    /// Of a body there.
    pub(crate) fn place(&self, body: Body) -> Place {
        Place {
            body,
            state: match self {
                Self::Plane(_) => None,
                Self::SixDof { sea, .. } => Some(six_dof::State::of_body(&body, sea.current)),
            },
            thrusters: Vec::new(),
        }
    }

    /// The water's velocity \[m/s\]: forward, right, down in the fixed frame.
    pub(crate) fn current(&self) -> [f64; 3] {
        match self {
            Self::Plane(motion) => motion.current,
            Self::SixDof { sea, .. } => sea.current,
        }
    }

    /// Depth of the bottom \[m\]; `None`: there is none.
    pub(crate) fn bottom(&self) -> Option<f64> {
        match self {
            Self::Plane(motion) => motion.depth_limits.bottom,
            Self::SixDof { sea, .. } => sea.bottom,
        }
    }

    /// Gives the body the speed that is held, if one is.
    pub(crate) fn hold_speed(&self, place: &mut Place) {
        match self {
            Self::Plane(motion) if motion.drive.is_none() => {
                place.body.speed = motion.vertical.derivatives.speed;
            }
            Self::SixDof {
                held_speed: Some(speed),
                ..
            } => {
                let (from, to) = (place.body.speed, *speed);
                place.body.speed = to;
                if let Some(state) = &mut place.state {
                    state.velocity[0] += to - from;
                }
            }
            _ => {}
        }
    }

    /// As [`BodyMotion::advance`]; `wanted` of the thrusters.
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
                let place = Place {
                    body,
                    state: None,
                    thrusters: Vec::new(),
                };
                Ok((place, contact))
            }
            Self::SixDof {
                tick, sea, step, ..
            } => {
                let state = from.state.unwrap_or_else(|| self.state_of(&from.body));
                let commands = Commands {
                    from: &from.thrusters,
                    to: wanted,
                };
                let (after, contact) =
                    tick.advance(&self.conditions(load), &state, inputs, commands, steps)?;
                let place = Place {
                    body: after.body(sea.current),
                    state: Some(after),
                    thrusters: tick.thrusters_after(commands, f64::from(steps) * step),
                };
                Ok((place, contact))
            }
        }
    }

    fn state_of(&self, body: &Body) -> six_dof::State {
        six_dof::State::of_body(body, self.current())
    }

    /// Of six degrees; of the plane there are none to tell.
    fn conditions(&self, load: GeneralisedForce) -> Conditions<'_> {
        static CALM: Sea = Sea::STILL;
        let (sea, holds_speed, step) = match self {
            Self::Plane(motion) => (&CALM, true, motion.vertical.step),
            Self::SixDof {
                sea,
                held_speed,
                step,
                ..
            } => (sea, held_speed.is_some(), *step),
        };
        Conditions {
            sea,
            time: 0.0,
            holds_speed,
            load: [0.0, 0.0, load.heave, 0.0, load.pitch, 0.0],
            step,
        }
    }

    /// What the accelerometers at the origin feel \[m/s^2\], forward, left, up.
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
            Self::SixDof { tick, .. } => {
                let state = place.state.unwrap_or_else(|| self.state_of(&place.body));
                let commands = Commands {
                    from: &place.thrusters,
                    to: &place.thrusters,
                };
                let [u, v, w, ..] =
                    tick.acceleration(&self.conditions(load), &state, inputs, commands);
                sensors::specific_force_of(&state, [u, v, w], gravity)
            }
        }
    }

    /// The depth rate \[m/s\], positive down, and what the vehicle touches.
    pub(crate) fn depth_rate_and_contact(&self, place: &Place) -> (f64, Option<Boundary>) {
        let Body { plane, .. } = place.body;
        let rate = place.body.depth_rate(self.current());
        match self {
            Self::Plane(motion) => (
                motion.depth_limits.confined_rate(plane.depth, rate),
                motion.depth_limits.touched(plane.depth),
            ),
            Self::SixDof { tick, sea, .. } => {
                let state = place.state.unwrap_or_else(|| self.state_of(&place.body));
                (rate, tick.touched(sea, &state))
            }
        }
    }

    /// The thrusters' names.
    pub(crate) fn thrusters(&self) -> &[String] {
        match self {
            Self::Plane(_) => &[],
            Self::SixDof { tick, .. } => tick.thrusters(),
        }
    }

    /// The equations of the plane.
    pub(crate) fn plane(&self) -> Option<&BodyMotion> {
        match self {
            Self::Plane(motion) => Some(motion),
            Self::SixDof { .. } => None,
        }
    }
}

/// The derivatives of a craft's vertical plane at a speed \[m/s\] through the water, before any variant of its equations.
pub(crate) fn derivatives(craft: &Craft, speed: f64) -> Derivatives {
    match craft {
        Craft::Plane(vehicle) => vehicle.derivatives(speed),
        Craft::SixDof(tick) => tick.derivatives(speed),
    }
}
