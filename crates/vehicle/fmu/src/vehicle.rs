//! A vehicle in an FMU: the core of `plant_sim`, run tick by tick, with its true state and without instruments.

use std::f64::consts::FRAC_PI_2;

use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, ThrusterCommand, VehicleState};
use planesman_parameters::Value;
use planesman_plant::{Plant, PlantParameters, VehicleModel};

use crate::error::Error;
use crate::node::Core;
use crate::variable::{Field, Variable, fields};

/// Beginnings of the names of the node's parameters that the FMU has: motion and water, not instruments.
const PARAMETERS: [&str; 12] = [
    "speed",
    "propulsion",
    "restoring",
    "pitch_damping",
    "heave_moment",
    "initial_",
    "environment.density",
    "environment.bottom",
    "environment.current.",
    "environment.seaway.",
    "environment.tether.",
    "seed",
];

const OUTPUTS: &[Field<VehicleState>] = fields! { VehicleState:
    distance, "m", "Position along the initial heading since the start";
    cross_track, "m", "Position to starboard of the initial heading";
    depth, "m", "Depth, positive down";
    depth_rate, "m/s", "Depth rate, positive down";
    roll, "rad", "Roll, positive starboard side down";
    roll_rate, "rad/s", "Rate of the roll angle";
    pitch, "rad", "Pitch, positive bow up";
    pitch_rate, "rad/s", "Rate of the pitch angle";
    yaw, "rad", "Yaw from the initial heading, positive to starboard";
    yaw_rate, "rad/s", "Rate of the yaw angle";
    surge, "m/s", "Velocity through the water, forward";
    heave, "m/s", "Velocity through the water, down";
    contact, "", "1: the vehicle touched the surface in the last tick; 2: it touched the bottom";
};

/// The sway, which `state` lacks.
fn sway() -> Variable {
    let description = "Velocity through the water, to starboard";
    Variable::output("sway".to_owned(), &Value::Double(0.0), "m/s", description)
}

/// The inputs that move a vehicle over a tick.
#[derive(Clone, Debug, PartialEq)]
enum Drive {
    DivePlanes,
    BowSternDifferential,
    RollDifferential,
    Rudder,
    Thrust,
    Thruster(String),
}

impl Drive {
    /// The inputs of a vehicle.
    fn of(craft: &VehicleModel) -> Vec<Self> {
        let has = |name: &str| match craft {
            VehicleModel::Plane(_) => false,
            VehicleModel::SixDof(tick) => tick.vehicle().parts().inputs.iter().any(|it| it == name),
        };
        let (planes, apart, roll, rudder, thrust) = match craft {
            VehicleModel::Plane(it) => (
                true,
                it.planes.is_some(),
                it.roll.is_some(),
                it.yaw.is_some(),
                it.propulsion.is_some(),
            ),
            VehicleModel::SixDof(tick) => {
                let (bow, stern, rudder) = (has("bow_planes"), has("stern_planes"), has("rudder"));
                let known = [bow, stern, rudder].iter().filter(|it| **it).count();
                let all = tick.vehicle().parts().inputs.len();
                let thrust = all > known + tick.thrusters().len();
                (bow || stern, bow && stern, false, rudder, thrust)
            }
        };
        let of_planes = [
            (planes, Self::DivePlanes),
            (apart, Self::BowSternDifferential),
            (roll, Self::RollDifferential),
            (rudder, Self::Rudder),
            (thrust, Self::Thrust),
        ];
        let there = of_planes.into_iter().filter(|(there, _)| *there);
        let thrusters = craft.thrusters().iter().cloned().map(Self::Thruster);
        there.map(|it| it.1).chain(thrusters).collect()
    }

    fn variable(&self) -> Variable {
        let angle = |name: &str, description| {
            Variable::input(name.to_owned(), "rad", description).within(-FRAC_PI_2, FRAC_PI_2)
        };
        let share =
            |name: String, description| Variable::input(name, "", description).within(-1.0, 1.0);
        match self {
            Self::DivePlanes => angle(
                "dive_planes",
                "Angle of bow and stern planes, positive dive",
            ),
            Self::BowSternDifferential => angle(
                "bow_stern_differential",
                "Angle added to the bow planes and subtracted from the stern planes",
            ),
            Self::RollDifferential => angle(
                "roll_differential",
                "Angle added to the starboard bow plane and subtracted from the port bow plane",
            ),
            Self::Rudder => angle("rudder", "Rudder angle, positive turns to starboard"),
            Self::Thrust => share(
                "thrust".to_owned(),
                "Thrust as a share of full thrust, if the parameter propulsion is thrust",
            ),
            Self::Thruster(name) => share(
                format!("thrusters.{name}"),
                "Command of the thruster as a share of its full command",
            ),
        }
    }
}

/// A vehicle with its inputs.
#[derive(Clone)]
pub(crate) struct Driven {
    plant: Plant,
    drives: Vec<Drive>,
}

impl Core for Driven {
    type Parameters = PlantParameters;
    type File = VehicleModel;

    const FILE: &'static str = "vehicle";
    const FIXED: &'static [&'static str] = &["initial_", "seed"];

    fn read(name: &str, text: &str) -> Result<VehicleModel, Error> {
        Ok(VehicleModel::parse(name, text)?)
    }

    fn variables(craft: &VehicleModel) -> Vec<Variable> {
        let inputs = Drive::of(craft).into_iter().map(|it| it.variable());
        let outputs = OUTPUTS.iter().map(Variable::field).chain([sway()]);
        inputs.chain(outputs).collect()
    }

    fn has(_: &VehicleModel, parameter: &str) -> bool {
        PARAMETERS.iter().any(|it| parameter.starts_with(it))
    }

    fn new(parameters: &PlantParameters, craft: VehicleModel) -> Result<Self, Error> {
        Ok(Self {
            drives: Drive::of(&craft),
            plant: Plant::of(craft, parameters)?,
        })
    }

    fn set_parameters(&mut self, parameters: &PlantParameters) -> Result<(), Error> {
        Ok(self.plant.set_parameters(parameters)?)
    }

    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error> {
        let mut motion = PlaneMotion {
            duration: Duration::from_nanos(self.plant.tick_nanos()),
            dive_planes: vec![0.0; 2],
            ..PlaneMotion::default()
        };
        let mut thrusters = ThrusterCommand::default();
        for (drive, value) in self.drives.iter().zip(inputs) {
            let held = vec![*value; 2];
            match drive {
                Drive::DivePlanes => motion.dive_planes = held,
                Drive::BowSternDifferential => motion.bow_stern_differential = held,
                Drive::RollDifferential => motion.roll_differential = held,
                Drive::Rudder => motion.rudder = held,
                Drive::Thrust => motion.thrust = held,
                Drive::Thruster(name) => {
                    thrusters.name.push(name.clone());
                    thrusters.command.push(*value);
                }
            }
        }
        if !thrusters.name.is_empty() {
            self.plant.set_thrusters(&thrusters)?;
        }
        Ok(self.plant.advance(Some(&motion))?)
    }

    fn outputs(&self) -> Vec<Value> {
        let state = self.plant.state(Time::default());
        let fields = OUTPUTS.iter().map(|it| (it.of)(&state));
        fields
            .chain([Value::Double(self.plant.body().sway)])
            .collect()
    }
}
