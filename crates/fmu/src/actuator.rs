//! An actuator in an FMU: the core of `dha_actuator`, tick by tick.
//!
//! After a step the outputs are those of its end: the ram is where `dha_state` has it at that stamp, and the counts are those of the tick before.

use std::path::Path;

use planesman_hydraulics::{
    Actuator, ActuatorFile as Description, ActuatorParameters, Error as ActuatorError,
    actuator_file,
};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand};
use planesman_msgs::std_msgs::msg::Header;
use planesman_parameters::{Parameters as _, Value};

use crate::error::Error;
use crate::subject::{Parameters, Simulation, Subject, changed};
use crate::variable::{Field, Variable, fields};

/// Parameters of the node that are the FMU's: those of one actuator.
const PARAMETERS: [&str; 6] = [
    "position_loop",
    "command_limit",
    "logic.",
    "leakage.",
    "friction.",
    "fault.",
];

/// Those of a circuit of on/off valves.
const OF_A_CIRCUIT: [&str; 1] = ["command_limit"];

/// The loop's command timeout \[s\], longer than any tick: in an FMU an input holds until another is set.
const TIMEOUT: f64 = 60.0;

/// The actuator at the end of the step.
const AT_THE_END: &[Field<DhaState>] = fields! { DhaState:
    ram, "m", "Ram position from neutral";
    ram_velocity, "m/s", "Ram velocity";
    plane_angle, "rad", "Plane angle, positive dive: ram over moment arm";
    pressure, "Pa", "Differential pressure P_d across the ram";
    volume, "m^3", "Net oil metered into the actuator V_T";
    leakage, "m^3", "Net oil gained through drift and leakage since the start";
    sign, "", "Present direction: +1 or -1";
    sliding, "", "The load moves";
    pressure_limited, "", "Auxiliary pistons clamp the pressure";
    at_stop, "", "Ram at an end of its travel";
    energy_supply, "J", "Work of supply and return since the start";
    energy_switching, "J", "Electrical energy of the solenoids";
    energy_viscous, "J", "Work on the load against viscous friction";
    energy_kinetic, "J", "Kinetic energy of ram and load";
    energy_stops, "J", "Energy taken by the stops";
    energy_friction, "J", "Energy taken by Coulomb friction";
    energy_throttling, "J", "Throttled in the valves, or the large volume's";
    energy_throttling_small, "J", "Throttled in the small volume's valve";
    energy_leakage, "J", "Throttled by drift and leakage";
    energy_compressed, "J", "Put into the compressed oil";
    energy_recovered, "J", "Given back by the compressed oil";
    energy_stored, "J", "Put into the auxiliary pistons";
    energy_returned, "J", "Given back by the auxiliary pistons";
    energy_proportional_valve, "J", "Energy an ideal proportional valve would have taken for the same motion";
};

/// What was decided in the last tick of the step.
const IN_THE_TICK: &[Field<DhaState>] = fields! { DhaState:
    commanded_angle, "rad", "Plane angle asked for, limited";
    error, "rad", "Predicted position error at the last pulse decision";
    hydraulic_power, "W", "Mean hydraulic power over the tick";
    limit_cycle_frequency, "Hz", "Frequency of the last whole cycle of the direction; 0: none";
    limit_cycle_amplitude, "rad", "Half of what the planes covered in it; 0: none";
    pulses, "", "Calibrated volumes issued since the start, both signs";
    small_pulses, "", "Of these, small ones of a two-speed actuator";
    sign_changes, "", "Changes of direction issued since the start";
    slewing, "", "A volume was issued in every valve cycle of the tick";
    inhibited, "", "A pulse was refused by the travel limit in the tick";
};

/// An actuator file, read.
pub(crate) struct ActuatorFile {
    parameters: ActuatorParameters,
    variables: Vec<Variable>,
}

impl ActuatorFile {
    /// # Errors
    /// A file or a tick that is not taken.
    pub(crate) fn load(file: &Path, tick: Option<f64>) -> Result<Self, Error> {
        let actuator = file.display().to_string();
        let own = [
            ("actuator", Value::String(actuator)),
            (
                "tick",
                tick.unwrap_or(ActuatorParameters::default().tick).into(),
            ),
            ("command_timeout", TIMEOUT.into()),
        ];
        let parameters = ActuatorParameters::default().with(&own)?;
        new(&parameters)?;
        let own: &[&str] =
            match actuator_file::read(&parameters.actuator).map_err(ActuatorError::from)? {
                Description::Metering(_) => &PARAMETERS,
                Description::Circuit(_) => &OF_A_CIRCUIT,
            };
        let input = Variable::input(
            "plane_command".to_owned(),
            "rad",
            "Plane angle asked for, positive dive",
        );
        let outputs = AT_THE_END.iter().chain(IN_THE_TICK).map(Variable::field);
        let declared = ActuatorParameters::declarations().into_iter();
        let declared = declared.filter(|it| {
            // One actuator moves the planes together.
            it.name != "fault.group" && own.iter().any(|own| it.name.starts_with(own))
        });
        let declared = declared.map(|it| Variable::parameter(it, false));
        Ok(Self {
            variables: [input].into_iter().chain(outputs).chain(declared).collect(),
            parameters,
        })
    }
}

fn new(parameters: &ActuatorParameters) -> Result<Actuator, Error> {
    let tick = (parameters.tick * 1e9).round() as i64;
    Ok(Actuator::new(parameters, tick)?)
}

impl Subject for ActuatorFile {
    fn tick(&self) -> f64 {
        self.parameters.tick
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn begin(&self, parameters: &Parameters) -> Result<Box<dyn Simulation>, Error> {
        let parameters = changed(&self.parameters, parameters)?;
        let tick = (parameters.tick * 1e9).round() as i64;
        let mut simulation = Simulated {
            actuator: new(&parameters)?,
            parameters,
            tick,
            stamp: 0,
            in_the_tick: DhaState::default(),
            at_the_end: DhaState::default(),
        };
        simulation.look_ahead();
        Ok(Box::new(simulation))
    }
}

#[derive(Clone)]
struct Simulated {
    parameters: ActuatorParameters,
    actuator: Actuator,
    /// ns
    tick: i64,
    /// The present instant, ns.
    stamp: i64,
    in_the_tick: DhaState,
    at_the_end: DhaState,
}

impl Simulated {
    /// The state at the present instant: a copy answers a tick there for which no command has come.
    fn look_ahead(&mut self) {
        let answer = self
            .actuator
            .clone()
            .on_silence(Time::from_nanos(self.stamp));
        self.at_the_end = answer.states().into_iter().next().unwrap_or_default();
    }
}

impl Simulation for Simulated {
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let parameters = changed(&self.parameters, parameters)?;
        self.actuator.set_parameters(&parameters)?;
        self.parameters = parameters;
        Ok(())
    }

    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error> {
        let command = PlaneCommand {
            header: Header {
                stamp: Time::from_nanos(self.stamp),
                ..Header::default()
            },
            dive_planes: inputs.first().copied().unwrap_or_default(),
            ..PlaneCommand::default()
        };
        let answer = self.actuator.on_command(&command)?;
        self.in_the_tick = answer.states().into_iter().next().unwrap_or_default();
        self.stamp = self.stamp.saturating_add(self.tick);
        self.look_ahead();
        Ok(())
    }

    fn outputs(&self, _: &[f64]) -> Vec<Value> {
        let at_the_end = AT_THE_END.iter().map(|it| (it.of)(&self.at_the_end));
        let in_the_tick = IN_THE_TICK.iter().map(|it| (it.of)(&self.in_the_tick));
        at_the_end.chain(in_the_tick).collect()
    }

    fn copy(&self) -> Box<dyn Simulation> {
        Box::new(self.clone())
    }
}
