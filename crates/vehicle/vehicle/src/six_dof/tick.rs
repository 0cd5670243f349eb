//! A tick of the loop: planes, rudder and thrust set the vehicle's inputs, and the equations are integrated over the tick.
//!
//! ```text
//! stern_planes = dive planes - differential    bow_planes = dive planes + differential    rudder = rudder
//! force: share of its limit    propeller: share of its full rotation    thruster: its own command
//! ```

use planesman_linear::{DORMAND_PRINCE_NODES, dormand_prince_step};

use super::equations::{FixedTerms, State};
use super::lanes::{Six, Three};
use super::propulsion::Propulsor;
use super::rotation::{self, normalised};
use super::vehicle::Vehicle;
use super::water::{Sea, Water};
use crate::attitude::Attitude;
use crate::axis::AxisState;
use crate::body::{Body, Inputs, Positions};
use crate::depth_limits::{Boundary, Contact};
use crate::motion::Diverged;
use crate::steps::Steps;

/// Evaluations of the derivative in a step.
const NODES: usize = DORMAND_PRINCE_NODES.len();

/// Largest estimated error of a step, sum over the state's numbers in SI.
const TOLERANCE: f64 = 1e-10;

/// Actuator of a vehicle's input.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Actuator {
    BowPlanes,
    SternPlanes,
    Rudder,
    /// Share of thrust, multiplied by one factor ahead and another astern.
    Thrust {
        ahead: f64,
        astern: f64,
    },
    /// Thruster with its index in the commands, and its lag \[s\].
    Thruster(usize, f64),
}

/// Commands of the thrusters over a tick, in the order of [`Tick::thrusters`]; a missing command is 0.
#[derive(Clone, Copy, Debug)]
pub struct Commands<'a> {
    /// State of the thrusters at its start.
    pub from: &'a [f64],
    /// Targets of the thrusters, each reached with its lag.
    pub to: &'a [f64],
}

impl Commands<'_> {
    /// No commands: for a vehicle without thrusters, or with thrusters at rest.
    pub const NONE: Commands<'static> = Commands { from: &[], to: &[] };

    /// State of a thruster at `t` \[s\] from the start.
    fn at(&self, place: usize, lag: f64, t: f64) -> f64 {
        let of = |row: &[f64]| row.get(place).copied().unwrap_or(0.0);
        let (from, to) = (of(self.from), of(self.to));
        match lag > 0.0 {
            true => to + (from - to) * libm::exp(-t / lag),
            false => to,
        }
    }
}

/// An input that no actuator of the loop moves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "input '{input}' refused: no actuator of the loop can move it. An angle must have the \
     name rudder, stern_planes or bow_planes; a force along x needs limits, and a propeller its \
     full_rotation; any other input must be a thruster's command"
)]
pub struct Unmoved {
    /// Its name.
    pub input: String,
}

/// A vehicle, the actuators of its inputs, and the sea around it.
#[derive(Clone, Debug)]
pub struct Tick {
    vehicle: Vehicle,
    actuators: Vec<Actuator>,
    /// Names of the inputs that are thrusters' commands.
    thrusters: Vec<String>,
}

/// Conditions that are constant during ticks.
#[derive(Clone, Debug)]
pub struct Conditions<'a> {
    /// The water.
    pub sea: &'a Sea,
    /// Start of the tick \[s\], for water that changes with time.
    pub time: f64,
    /// Whether surge through the water is held, by any necessary force along x.
    pub holds_speed: bool,
    /// External constant force \[N\] and moment \[N m\].
    pub load: Six<f64>,
    /// Longest step \[s\].
    pub step: f64,
}

impl Tick {
    /// Creates a tick for a vehicle whose inputs have the names of the loop's actuators.
    ///
    /// # Errors
    /// [`Unmoved`], with the name of the input without an actuator.
    pub fn new(vehicle: Vehicle) -> Result<Self, Unmoved> {
        let mut thrusters = Vec::new();
        let mut actuator = |(place, name): (usize, &String)| {
            let of = vehicle.parts.propulsors.iter().find_map(|one| match one {
                Propulsor::Force {
                    input,
                    limits,
                    wrench,
                } if *input == place && wrench[0] > 0.0 => Some(Actuator::Thrust {
                    ahead: limits[1].max(0.0),
                    astern: (-limits[0]).max(0.0),
                }),
                Propulsor::Propeller { input, propeller } if *input == place => {
                    let full = propeller.full_rotation?;
                    Some(Actuator::Thrust {
                        ahead: full,
                        astern: full,
                    })
                }
                Propulsor::Thruster { input, thruster } if *input == place => {
                    let known = thrusters.len();
                    thrusters.push(name.clone());
                    Some(Actuator::Thruster(known, thruster.lag))
                }
                _ => None,
            });
            of.or(match name.as_str() {
                "rudder" => Some(Actuator::Rudder),
                "stern_planes" => Some(Actuator::SternPlanes),
                "bow_planes" => Some(Actuator::BowPlanes),
                _ => None,
            })
            .ok_or_else(|| Unmoved {
                input: name.clone(),
            })
        };
        let inputs = vehicle.parts.inputs.iter().enumerate();
        let actuators = inputs.map(&mut actuator).collect::<Result<_, _>>()?;
        Ok(Self {
            vehicle,
            actuators,
            thrusters,
        })
    }

    /// The vehicle.
    #[must_use]
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Names of the thrusters, in the order of their commands.
    #[must_use]
    pub fn thrusters(&self) -> &[String] {
        &self.thrusters
    }

    /// Whether the vehicle has only thrusters: no plane, rudder or propeller.
    #[must_use]
    pub fn is_of_thrusters_alone(&self) -> bool {
        !self.thrusters.is_empty() && self.thrusters.len() == self.actuators.len()
    }

    /// State of the thrusters `t` \[s\] after the start of their commands.
    #[must_use]
    pub fn thrusters_after(&self, commands: Commands<'_>, t: f64) -> Vec<f64> {
        let of = |actuator: &Actuator| match actuator {
            Actuator::Thruster(place, lag) => Some(commands.at(*place, *lag, t)),
            _ => None,
        };
        self.actuators.iter().filter_map(of).collect()
    }

    /// Writes the vehicle's inputs for the actuators' positions, and for the thrusters' commands `t` \[s\] after their start, into a row.
    pub(super) fn put_inputs(
        &self,
        positions: &Positions,
        commands: Commands<'_>,
        t: f64,
        row: &mut [f64],
    ) {
        let of = |actuator: &Actuator| match actuator {
            Actuator::BowPlanes => positions.dive_planes + positions.bow_stern_differential,
            Actuator::SternPlanes => positions.dive_planes - positions.bow_stern_differential,
            Actuator::Rudder => positions.rudder,
            Actuator::Thrust { ahead, astern } => match positions.thrust {
                share if share < 0.0 => share * astern,
                share => share * ahead,
            },
            Actuator::Thruster(place, lag) => commands.at(*place, *lag, t),
        };
        for (input, actuator) in row.iter_mut().zip(&self.actuators) {
            *input = of(actuator);
        }
    }

    /// Derivative of the state.
    fn rates(
        &self,
        conditions: &Conditions<'_>,
        steady: Option<&Water<f64>>,
        state: &State,
        held: &FixedTerms<'_, f64>,
        time: f64,
    ) -> [f64; 13] {
        let water = match steady {
            Some(water) => *water,
            None => {
                let [u, v, w, ..] = state.velocity;
                let over_ground = rotation::to_fixed(&rotation::matrix(state.attitude), [u, v, w]);
                conditions.sea.at(state.position, over_ground, time)
            }
        };
        let mut rates = self.vehicle.derivative_under(state, held, &water);
        if conditions.load != [0.0; 6] {
            let by_load = super::lanes::product(&self.vehicle.inverse_inertia, &conditions.load);
            for (rate, by_load) in rates[7..].iter_mut().zip(by_load) {
                *rate += by_load;
            }
        }
        if conditions.holds_speed {
            let r = rotation::matrix(state.attitude);
            // The force along x under which surge through the water stays: each row moves by the inverse inertia's first column.
            let turning = [state.velocity[3], state.velocity[4], state.velocity[5]];
            let stream = rotation::to_body(&r, water.velocity);
            let carried = super::lanes::cross(stream, turning)[0]
                + rotation::to_body(&r, water.acceleration)[0];
            let inverse = &self.vehicle.inverse_inertia;
            let force = (carried - rates[7]) / inverse[0][0];
            for (row, rate) in inverse.iter().zip(&mut rates[7..]) {
                *rate += row[0] * force;
            }
        }
        rates
    }

    /// Acceleration `nu'` of the body \[m/s^2, rad/s^2\] at the start of the actuators' paths.
    #[must_use]
    pub fn acceleration(
        &self,
        conditions: &Conditions<'_>,
        state: &State,
        inputs: &Inputs<'_>,
        commands: Commands<'_>,
    ) -> Six<f64> {
        let [positions] = inputs.over(0.0, 0.0, &[0.0]);
        let mut row = vec![0.0; self.actuators.len()];
        self.put_inputs(&positions, commands, 0.0, &mut row);
        let held = self.vehicle.held(&row);
        let rates = self.rates(conditions, None, state, &held, conditions.time);
        std::array::from_fn(|i| rates[7 + i])
    }

    /// State after a number of longest steps along the actuators' paths, which begin at the first step, and the thrusters' commands; also
    /// the first contact, with its time from the start.
    ///
    /// # Errors
    /// [`Diverged`], if the state is not finite or outside the range of vehicles.
    pub fn advance(
        &self,
        conditions: &Conditions<'_>,
        from: &State,
        inputs: &Inputs<'_>,
        commands: Commands<'_>,
        steps: u32,
    ) -> Result<(State, Option<Contact>), Diverged> {
        let longest = conditions.step;
        let duration = f64::from(steps) * longest;
        let mut state = *from;
        let mut contact = None;
        let (mut t, mut steps) = (0.0, Steps::new(longest, TOLERANCE));
        let water = conditions.sea.at([0.0; 3], [0.0; 3], 0.0);
        let steady = conditions.sea.is_steady().then_some(&water);
        // A row of inputs for each node; of a vehicle without inputs one that is not used.
        let count = self.actuators.len().max(1);
        let mut rows = vec![0.0; NODES * count];
        while t < duration {
            let (h, is_last) = steps.next(duration - t);
            let positions = inputs.over(t, h, &DORMAND_PRINCE_NODES);
            for (k, row) in rows.chunks_mut(count).enumerate() {
                self.put_inputs(
                    &positions[k],
                    commands,
                    t + DORMAND_PRINCE_NODES[k] * h,
                    row,
                );
            }
            // What hangs on the inputs alone, once where they stand still.
            let stand = rows.chunks(count).all(|row| *row == rows[..count]);
            let held: Vec<FixedTerms<'_, f64>> =
                (rows.chunks(count).take(if stand { 1 } else { NODES }))
                    .map(|row| self.vehicle.held(&row[..self.actuators.len()]))
                    .collect();
            let nodes: [(f64, &FixedTerms<'_, f64>); NODES] = std::array::from_fn(|k| {
                let time = conditions.time + t + DORMAND_PRINCE_NODES[k] * h;
                (time, &held[if stand { 0 } else { k }])
            });
            let (row, error) = dormand_prince_step(&state.row(), h, &nodes, |(time, held), row| {
                self.rates(conditions, steady, &State::of_row(*row), held, *time)
            });
            let error: f64 = error.iter().map(|error| error.abs()).sum();
            if !steps.accept(h, error) {
                continue;
            }
            let mut next = State::of_row(row);
            check(&next)?;
            next.attitude = normalised(next.attitude);
            contact = contact.or_else(|| {
                if [&state, &next]
                    .iter()
                    .all(|it| self.is_far(conditions.sea, it))
                {
                    return None;
                }
                let [before, after] = [&state, &next].map(|it| self.clearances(conditions.sea, it));
                first_contact(before, after, h).map(|(boundary, time)| Contact {
                    boundary,
                    time: t + time,
                })
            });
            state = next;
            t = if is_last { duration } else { t + h };
        }
        Ok((state, contact))
    }

    /// Distances of the hull below the surface and above the bottom \[m\]; `None` without a surface or bottom.
    fn clearances(&self, sea: &Sea, state: &State) -> [Option<f64>; 2] {
        let r = rotation::matrix(state.attitude);
        let [lowest, highest] = self.vehicle.extent(state.position[2], &r);
        [
            sea.has_surface.then_some(highest),
            sea.bottom.map(|bottom| bottom - lowest),
        ]
    }

    /// Whether the vehicle touches neither surface nor bottom in any attitude.
    fn is_far(&self, sea: &Sea, state: &State) -> bool {
        let (reach, depth) = (self.vehicle.reach(), state.position[2]);
        (!sea.has_surface || depth > reach)
            && sea.bottom.is_none_or(|bottom| bottom - depth > reach)
    }

    /// Boundary that the hull touches.
    #[must_use]
    pub fn touched(&self, sea: &Sea, state: &State) -> Option<Boundary> {
        if self.is_far(sea, state) {
            return None;
        }
        let [surface, bottom] = self.clearances(sea, state);
        let is_past = |clearance: Option<f64>| clearance.is_some_and(|it| it <= 0.0);
        match (is_past(surface), is_past(bottom)) {
            (true, _) => Some(Boundary::Surface),
            (_, true) => Some(Boundary::Bottom),
            _ => None,
        }
    }
}

/// First contact within a step of `h` \[s\], by linear interpolation between the distances before and after the step.
fn first_contact(
    before: [Option<f64>; 2],
    after: [Option<f64>; 2],
    h: f64,
) -> Option<(Boundary, f64)> {
    let passed = |i: usize| {
        let (from, to) = (before[i]?, after[i]?);
        (from > 0.0 && to <= 0.0).then(|| h * from / (from - to))
    };
    match (passed(0), passed(1)) {
        (Some(up), Some(down)) if down < up => Some((Boundary::Bottom, down)),
        (Some(up), _) => Some((Boundary::Surface, up)),
        (None, Some(down)) => Some((Boundary::Bottom, down)),
        (None, None) => None,
    }
}

impl State {
    /// The state in the form of the loop's other vehicles: angles with their rates, and velocities through water that moves by `current`
    /// (north, east, down \[m/s\]).
    ///
    /// The rates of roll and yaw are the rates of the angles, which are unbounded as pitch approaches 90 degrees.
    #[must_use]
    pub fn body(&self, current: Three<f64>) -> Body {
        let r = rotation::matrix(self.attitude);
        let [roll, pitch, yaw] = rotation::euler(self.attitude);
        let [u, v, w, p, q, turn] = self.velocity;
        let [c_x, c_y, c_z] = rotation::to_body(&r, current);
        let (sin, cos) = libm::sincos(roll);
        let (about_level, turning) = (q * cos - turn * sin, q * sin + turn * cos);
        let cos_pitch = libm::cos(pitch).max(1e-9);
        let yaw_rate = turning / cos_pitch;
        let mut body = Body {
            across: self.position[1],
            speed: u - c_x,
            sway: v - c_y,
            roll: AxisState {
                angle: roll,
                rate: p + yaw_rate * libm::sin(pitch),
            },
            yaw: AxisState {
                angle: yaw,
                rate: yaw_rate,
            },
            ..Body::default()
        };
        (body.plane.distance, body.plane.depth) = (self.position[0], self.position[2]);
        (body.plane.pitch, body.plane.pitch_rate) = (pitch, about_level);
        body.plane.heave = w - c_z;
        body
    }

    /// Converts such a body to a state in water that moves by `current`.
    #[must_use]
    pub fn of_body(body: &Body, current: Three<f64>) -> Self {
        let Attitude { roll, pitch, yaw } = body.attitude();
        let attitude = rotation::from_euler([roll, pitch, yaw]);
        let [c_x, c_y, c_z] = rotation::to_body(&rotation::matrix(attitude), current);
        let [p, q, r] = body.rates();
        Self {
            position: [body.plane.distance, body.across, body.plane.depth],
            attitude,
            velocity: [
                body.speed + c_x,
                body.sway + c_y,
                body.plane.heave + c_z,
                p,
                q,
                r,
            ],
        }
    }
}

/// Limits of a vehicle's motion, beyond which numbers soon overflow: position \[m\], velocity \[m/s\], rates \[rad/s\].
const FARTHEST: f64 = 1e9;
const FASTEST: f64 = 1e3;

fn check(state: &State) -> Result<(), Diverged> {
    let named = [
        ("position [m]", &state.position[..], FARTHEST),
        ("velocity [m/s]", &state.velocity[..3], FASTEST),
        ("rate of turn [rad/s]", &state.velocity[3..], FASTEST),
        ("attitude", &state.attitude[..], 2.0),
    ];
    for (quantity, values, limit) in named {
        // NaN is not within.
        if let Some(value) = values
            .iter()
            .find(|value| !(-limit..=limit).contains(*value))
        {
            return Err(Diverged {
                quantity,
                value: *value,
                limit,
            });
        }
    }
    Ok(())
}
