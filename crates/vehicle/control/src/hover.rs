//! Station keeping and way-points with thrusters: along, across, depth and heading; the hull is held level if the thrusters can do it.
//!
//! ```text
//! v_d = limit(Kp (x_d - x))     fixed frame, level and depth apart        r_d = limit(Kp_psi (psi_d - psi))
//! a   = Kv R^T (v_d - v) + R^T I,   I' = Ki (v_d - v)                      likewise in yaw; roll and pitch to 0, without integral
//! tau = M a     thrusts = pinv(B) tau, all made smaller alike where one would pass its most
//! ```
//! A cascade, with the added mass in `M`, so that the gains are independent of the vehicle's mass (Fossen 2011, sec. 12.2 and 12.3). The
//! integral compensates current, trim and the line's pull; it stops while a thruster is saturated. Velocities over ground are computed from
//! differences of positions.

use planesman_vehicle::six_dof::propulsion::{Allocation, Inverse, Thruster};
use planesman_vehicle::six_dof::{self, Six, rotation};

use crate::angle_loop::short_way;
use crate::error::ParameterError;
use crate::limits::bounded;

/// The parameters `hover.*`.
#[derive(Clone, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct HoverParameters {
    /// Vehicle whose thrusters mode hover commands: 'bluerov2_heavy' or the path of a vehicle file with thrusters, the same as plant_sim's; empty: none.
    #[parameter(default = "", read_only)]
    pub vehicle: String,
    /// Position to hold along the initial heading, if there are no way-points.
    #[parameter(default = 0.0, unit = "m", range = -1e6..=1e6)]
    pub x: f64,
    /// Position to hold to starboard of the initial heading, if there are no way-points.
    #[parameter(default = 0.0, unit = "m", range = -1e6..=1e6)]
    pub y: f64,
    /// Largest commanded speed, separately in the horizontal plane and in depth.
    #[parameter(default = 0.5, unit = "m/s", range = 0.001..=5.0)]
    pub speed: f64,
    /// Largest commanded rate of turn.
    #[parameter(default = 0.5, unit = "rad/s", range = 0.001..=5.0)]
    pub turn: f64,
    /// Commanded speed per distance to the target.
    #[parameter(default = 0.6, unit = "1/s", range = 0.0..=100.0)]
    pub position_p: f64,
    /// Commanded rate of turn per heading error.
    #[parameter(default = 1.0, unit = "1/s", range = 0.0..=100.0)]
    pub heading_p: f64,
    /// Commanded rate of turn per angle of roll and pitch.
    #[parameter(default = 4.0, unit = "1/s", range = 0.0..=100.0)]
    pub level_p: f64,
    /// Acceleration per error of a velocity or rate of turn.
    #[parameter(default = 2.5, unit = "1/s", range = 0.0..=100.0)]
    pub velocity_p: f64,
    /// Acceleration per time integral of the error of a velocity or rate of turn.
    #[parameter(default = 0.6, unit = "1/s^2", range = 0.0..=100.0)]
    pub velocity_i: f64,
}

/// The thrusters of a vehicle, and their forces.
#[derive(Clone, Debug)]
pub(crate) struct Thrusters {
    /// Their names.
    pub names: Vec<String>,
    thrusters: Vec<Thruster>,
    commands: Vec<Inverse>,
    /// The maximum thrust of the weakest thruster, N.
    most: f64,
    allocation: Allocation,
    /// Masses and moments of inertia, including added mass.
    inertia: Six<f64>,
}

impl PartialEq for Thrusters {
    fn eq(&self, other: &Self) -> bool {
        (&self.names, &self.thrusters, self.inertia)
            == (&other.names, &other.thrusters, other.inertia)
    }
}

impl Thrusters {
    /// Loads the thrusters of a vehicle by its name, or from the file at a path.
    ///
    /// # Errors
    /// [`ParameterError::Hover`].
    pub(crate) fn load(vehicle: &str) -> Result<Self, ParameterError> {
        let refused = |reason: String| ParameterError::Hover(reason);
        let loaded = six_dof::load(vehicle).map_err(|e| refused(e.to_string()))?;
        let parts = loaded.parts();
        let (names, thrusters): (Vec<String>, Vec<Thruster>) = (parts.thrusters())
            .map(|(input, thruster)| (parts.inputs[input].clone(), thruster.clone()))
            .unzip();
        if names.is_empty() {
            return Err(refused(format!("vehicle '{vehicle}' has no thrusters")));
        }
        if let Some(name) =
            (1..names.len()).find_map(|i| names[..i].iter().find(|it| **it == names[i]))
        {
            return Err(refused(format!(
                "vehicle '{vehicle}': two thrusters have the input '{name}', but each thruster needs its own input"
            )));
        }
        // Without a pair of verticals for roll or pitch those are left to the hull.
        let all: Vec<&Thruster> = thrusters.iter().collect();
        let allocation = Allocation::new(&all)
            .or_else(|_| Allocation::of_rows(&all, &[0, 1, 2, 5]))
            .map_err(|reason| refused(format!("vehicle '{vehicle}': {reason}")))?;
        let commands: Vec<Inverse> = thrusters.iter().map(Inverse::new).collect();
        if let Some(weak) = commands.iter().position(|one| one.most() <= 0.0) {
            let name = &names[weak];
            return Err(refused(format!(
                "vehicle '{vehicle}': thruster '{name}' gives no thrust along its direction with \
                 positive commands"
            )));
        }
        let most = commands
            .iter()
            .map(Inverse::most)
            .fold(f64::INFINITY, f64::min);
        let inertia = loaded.inertia();
        Ok(Self {
            names,
            thrusters,
            commands,
            most,
            allocation,
            inertia: std::array::from_fn(|i| inertia[i][i]),
        })
    }

    /// The commands for accelerations in the body's axes, and whether the thrusters can give them.
    fn commands(&self, wanted: Six<f64>) -> (Vec<f64>, bool) {
        let wrench = std::array::from_fn(|i| bounded(self.inertia[i] * wanted[i]));
        let (given, share) = self.allocation.within(&wrench, self.most);
        let commands = self.commands.iter().zip(given);
        let commands = commands.map(|(one, thrust)| one.command(thrust));
        (commands.collect(), share == 1.0)
    }
}

/// The measured pose of the vehicle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasuredPose {
    /// The position along, to starboard and down in the fixed frame, m.
    pub place: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub angles: [f64; 3],
    /// Their rates, rad/s.
    pub rates: [f64; 3],
}

/// The target of station keeping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    /// Like [`MeasuredPose`].
    pub place: [f64; 3],
    /// rad
    pub heading: f64,
}

/// The state of the control law between ticks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hover {
    last: Option<[f64; 3]>,
    /// The integral terms: in the fixed frame, m/s^2, and in yaw, rad/s^2.
    integral: [f64; 4],
}

/// A vector with its length limited to `most`.
fn limited<const N: usize>(v: [f64; N], most: f64) -> [f64; N] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    match length > most {
        true => v.map(|x| x * most / length),
        false => v,
    }
}

impl Hover {
    /// The commands `dt` seconds after the last.
    pub(crate) fn step(
        &mut self,
        parameters: &HoverParameters,
        thrusters: &Thrusters,
        seen: &MeasuredPose,
        target: &Target,
        dt: f64,
    ) -> Vec<f64> {
        let error: [f64; 3] = std::array::from_fn(|i| bounded(target.place[i] - seen.place[i]));
        let asked = error.map(|e| parameters.position_p * e);
        let [x, y] = limited([asked[0], asked[1]], parameters.speed);
        let [z] = limited([asked[2]], parameters.speed);
        let velocity: [f64; 3] = match self.last.replace(seen.place) {
            Some(last) if dt > 0.0 => {
                std::array::from_fn(|i| bounded((seen.place[i] - last[i]) / dt))
            }
            _ => [0.0; 3],
        };
        let turn = parameters.heading_p * short_way(seen.angles[2], target.heading);
        let [turn] = limited([turn], parameters.turn);
        let lag = [
            x - velocity[0],
            y - velocity[1],
            z - velocity[2],
            turn - seen.rates[2],
        ];
        let wanted: [f64; 4] =
            std::array::from_fn(|i| bounded(parameters.velocity_p * lag[i]) + self.integral[i]);
        let r = rotation::matrix(rotation::from_euler(seen.angles));
        let [a, b, c] = rotation::to_body(&r, [wanted[0], wanted[1], wanted[2]]);
        let [k, m] = [0, 1].map(|i| {
            let rate = bounded(-parameters.level_p * seen.angles[i]);
            bounded(parameters.velocity_p * (rate - seen.rates[i]))
        });
        let (commands, within) = thrusters.commands([a, b, c, k, m, wanted[3]]);
        if within {
            for (integral, lag) in self.integral.iter_mut().zip(lag) {
                *integral = bounded(*integral + parameters.velocity_i * lag * dt);
            }
        }
        commands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rov() -> Thrusters {
        Thrusters::load("bluerov2_heavy").unwrap()
    }

    #[test]
    fn the_commands_give_the_force_that_is_asked_for() {
        let rov = rov();
        let wanted = [0.3, -0.2, 0.25, 0.1, -0.2, 0.5];
        let (commands, within) = rov.commands(wanted);
        assert!(within);
        let mut force: Six<f64> = [0.0; 6];
        for (one, command) in rov.thrusters.iter().zip(&commands) {
            let thrust = one.thrust(*command);
            for (sum, share) in force.iter_mut().zip(one.wrench()) {
                *sum += share * thrust;
            }
        }
        for (i, found) in force.iter().enumerate() {
            let expected = rov.inertia[i] * wanted[i];
            assert!((found - expected).abs() < 0.02, "{force:?}");
        }
    }

    #[test]
    fn more_than_the_thrusters_give_keeps_its_direction() {
        let (commands, within) = rov().commands([50.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(!within);
        assert!(commands.iter().all(|c| c.abs() <= 1.0));
        let level: Vec<f64> = commands[..4].iter().map(|c| c.abs()).collect();
        assert!(
            level.iter().all(|c| (c - level[0]).abs() < 1e-9),
            "{commands:?}"
        );
    }

    #[test]
    fn thrusters_that_share_an_input_or_give_no_thrust_are_refused() {
        let own = include_str!("../../vehicle/vehicles/six_dof/bluerov2_heavy.yaml");
        let folder = std::env::temp_dir().join(format!("planesman-hover-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for (from, to, reason) in [
            (
                "input: rear_port",
                "input: rear_starboard",
                "two thrusters have the input 'rear_starboard'",
            ),
            (
                "[8.9, 176.0, -404.1, 389.9, -140.3]",
                "[-8.9]",
                "thruster 'front_starboard' gives no thrust",
            ),
        ] {
            let file = folder.join("own.yaml");
            std::fs::write(&file, own.replace(from, to)).unwrap();
            let refusal = Thrusters::load(file.to_str().unwrap()).unwrap_err();
            assert!(refusal.to_string().contains(reason), "{refusal}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_vehicle_without_thrusters_is_refused() {
        let refusal = Thrusters::load("lauv").unwrap_err().to_string();
        assert_eq!(
            refusal,
            "parameter 'hover.vehicle': vehicle 'lauv' has no thrusters"
        );
    }
}
