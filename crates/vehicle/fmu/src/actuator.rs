//! An actuator in an FMU: the core of `dha_actuator`, run tick by tick.
//!
//! After a step, the outputs are those at its end: the ram's position equals that of `dha_state` at that stamp, and the counts are those of the
//! previous tick.

use planesman_circuit::MOST_FORCE;
use planesman_hydraulics::{
    Actuator, ActuatorFile, ActuatorParameters, Error as ActuatorError, actuator_file,
};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand};
use planesman_msgs::std_msgs::msg::Header;
use planesman_parameters::Value;

use crate::error::Error;
use crate::node::Core;
use crate::variable::{Field, Variable, fields};

/// Beginnings of the names of the node's parameters that the FMU has: the parameters of one actuator.
const PARAMETERS: [&str; 6] = [
    "position_loop",
    "command_limit",
    "logic.",
    "leakage.",
    "friction.",
    "fault.",
];

/// Beginnings of the names of the parameters of a circuit of on/off valves.
const OF_A_CIRCUIT: [&str; 1] = ["command_limit"];

/// Outputs that belong to the end of the step.
const AT_THE_END: &[Field<DhaState>] = fields! { DhaState:
    ram, "m", "Ram position from neutral";
    ram_velocity, "m/s", "Ram velocity";
    plane_angle, "rad", "Plane angle, positive dive: ram over moment arm";
    pressure, "Pa", "Differential pressure P_d across the ram; for a circuit p_A - p_B";
    volume, "m^3", "Net oil metered into the actuator V_T; for a circuit net oil taken from the supply levels";
    leakage, "m^3", "Net oil gained by drift and leakage since the start";
    sign, "", "Current direction: +1 or -1";
    sliding, "", "The load moves";
    pressure_limited, "", "Auxiliary pistons clamp the pressure";
    at_stop, "", "Ram at an end of its travel";
    energy_supply, "J", "Work of supply and return since the start";
    energy_switching, "J", "Electrical energy of the solenoids";
    energy_viscous, "J", "Work on the load against viscous friction";
    energy_kinetic, "J", "Kinetic energy of ram and load; for a circuit also the energy of spring, weight and load force";
    energy_stops, "J", "Energy absorbed by the stops";
    energy_friction, "J", "Energy lost to Coulomb friction";
    energy_throttling, "J", "Throttling loss in the valves; for two volumes, in the valve of the large volume";
    energy_throttling_small, "J", "Throttling loss in the valve of the small volume";
    energy_leakage, "J", "Throttling loss caused by drift and leakage";
    energy_compressed, "J", "Energy stored in the compressed oil";
    energy_recovered, "J", "Energy returned by the compressed oil";
    energy_stored, "J", "Energy stored in the auxiliary pistons";
    energy_returned, "J", "Energy returned by the auxiliary pistons";
    energy_proportional_valve, "J", "Energy that an ideal proportional valve would have used for \
        the same motion";
};

/// Outputs decided in the last tick of the step.
const IN_THE_TICK: &[Field<DhaState>] = fields! { DhaState:
    commanded_angle, "rad", "Commanded plane angle, after limiting";
    error, "rad", "Predicted position error at the last pulse decision";
    hydraulic_power, "W", "Mean hydraulic power over the tick";
    limit_cycle_frequency, "Hz", "Limit cycle: frequency of the last complete cycle; 0 if there is none";
    limit_cycle_amplitude, "rad", "Limit cycle: half of the planes' range of motion in the last complete cycle; 0 if there is none";
    pulses, "", "Number of calibrated volumes issued since the start, in both directions; for a circuit the number of valve switchings";
    small_pulses, "", "Number of small volumes issued since the start, for a two-speed actuator";
    sign_changes, "", "Number of changes of direction issued since the start";
    slewing, "", "1 if a volume was issued in every valve cycle of the tick";
    inhibited, "", "1 if the travel limit refused a pulse in the tick";
};

/// Outputs that a circuit of on/off valves does not have.
const OF_METERING: [&str; 11] = [
    "leakage",
    "pressure_limited",
    "energy_throttling_small",
    "energy_stored",
    "energy_returned",
    "limit_cycle_frequency",
    "limit_cycle_amplitude",
    "small_pulses",
    "sign_changes",
    "slewing",
    "inhibited",
];

/// The gauge pressures of a circuit's chambers.
const CHAMBERS: [(&str, &str); 2] = [
    ("p_A", "Gauge pressure in chamber A"),
    ("p_B", "Gauge pressure in chamber B"),
];

/// The number of a circuit's chambers; 0 for an actuator of metered volumes.
fn chambers(file: &ActuatorFile) -> usize {
    match file {
        ActuatorFile::Metering(_) => 0,
        ActuatorFile::Circuit(it) => it.chambers.iter().filter(|it| it.area > 0.0).count(),
    }
}

/// The outputs among some fields, for an actuator with this many chambers.
fn outputs(
    fields: &'static [Field<DhaState>],
    chambers: usize,
) -> impl Iterator<Item = &'static Field<DhaState>> {
    let is_its = move |it: &&Field<DhaState>| chambers == 0 || !OF_METERING.contains(&it.name);
    fields.iter().filter(is_its)
}

/// An actuator and its current tick.
#[derive(Clone)]
pub(crate) struct Ticking {
    actuator: Actuator,
    chambers: usize,
    /// ns
    tick: i64,
    /// The current instant, ns.
    stamp: i64,
    in_the_tick: DhaState,
    at_the_end: DhaState,
    /// p_A and p_B there, Pa.
    pressures: [f64; 2],
}

impl Ticking {
    /// The state at the current instant, computed with a copy for a tick without a command.
    fn look_ahead(&mut self) -> Result<(), Error> {
        let mut ahead = self.actuator.clone();
        let answer = ahead.on_silence(Time::from_nanos(self.stamp))?;
        self.at_the_end = answer.states().into_iter().next().unwrap_or_default();
        self.pressures = answer.chamber_pressures().next().unwrap_or_default();
        Ok(())
    }
}

impl Core for Ticking {
    type Parameters = ActuatorParameters;
    type File = ActuatorFile;

    const FILE: &'static str = "actuator";
    /// The loop's command timeout is longer than any tick, because in an FMU an input is held until the next is set.
    const HELD: &'static [(&'static str, f64)] = &[("command_timeout", 60.0)];

    fn read(name: &str, text: &str) -> Result<ActuatorFile, Error> {
        Ok(actuator_file::of_text(name, text).map_err(ActuatorError::from)?)
    }

    fn variables(file: &ActuatorFile) -> Vec<Variable> {
        let command = "Commanded plane angle, positive dive";
        let mut variables = vec![Variable::input("plane_command".to_owned(), "rad", command)];
        let chambers = chambers(file);
        if chambers > 0 {
            let load_force = "Force on the ram, against positive motion";
            let load_force = Variable::input("load_force".to_owned(), "N", load_force);
            variables.push(load_force.within(-MOST_FORCE, MOST_FORCE));
        }
        let like = Value::Double(0.0);
        let pressure = |(name, description): &(&str, &'static str)| {
            Variable::output((*name).to_owned(), &like, "Pa", description)
        };
        variables.extend(outputs(AT_THE_END, chambers).map(Variable::field));
        variables.extend(CHAMBERS.iter().take(chambers).map(pressure));
        variables.extend(outputs(IN_THE_TICK, chambers).map(Variable::field));
        variables
    }

    fn has(file: &ActuatorFile, parameter: &str) -> bool {
        let own: &[&str] = match file {
            ActuatorFile::Metering(_) => &PARAMETERS,
            ActuatorFile::Circuit(_) => &OF_A_CIRCUIT,
        };
        // One actuator moves the planes together.
        parameter != "fault.group" && own.iter().any(|it| parameter.starts_with(it))
    }

    fn new(parameters: &ActuatorParameters, file: ActuatorFile) -> Result<Self, Error> {
        let tick = (parameters.tick * 1e9).round() as i64;
        let mut new = Self {
            chambers: chambers(&file),
            actuator: Actuator::of_files(parameters, tick, |_| Ok(file.clone()))?,
            tick,
            stamp: 0,
            in_the_tick: DhaState::default(),
            at_the_end: DhaState::default(),
            pressures: [0.0; 2],
        };
        new.look_ahead()?;
        Ok(new)
    }

    fn set_parameters(&mut self, parameters: &ActuatorParameters) -> Result<(), Error> {
        Ok(self.actuator.set_parameters(parameters)?)
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
        if let Some(force) = inputs.get(1) {
            self.actuator.set_load_force(*force)?;
        }
        let answer = self.actuator.on_command(&command)?;
        self.in_the_tick = answer.states().into_iter().next().unwrap_or_default();
        self.stamp = self.stamp.saturating_add(self.tick);
        self.look_ahead()
    }

    fn outputs(&self) -> Vec<Value> {
        let at_the_end = outputs(AT_THE_END, self.chambers).map(|it| (it.of)(&self.at_the_end));
        let pressures = self.pressures.iter().take(self.chambers);
        let in_the_tick = outputs(IN_THE_TICK, self.chambers).map(|it| (it.of)(&self.in_the_tick));
        let pressures = pressures.map(|it| Value::Double(*it));
        at_the_end.chain(pressures).chain(in_the_tick).collect()
    }
}
