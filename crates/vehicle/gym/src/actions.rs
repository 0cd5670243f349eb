//! Converts actions in -1 to 1 to the inputs of a vehicle: an input over its range, or a force or moment distributed over all thrusters.

use planesman_vehicle::six_dof::propulsion::{Allocation, Inverse, Thruster};
use planesman_vehicle::six_dof::{Parts, Vehicle};

use crate::refused::Refused;

/// The axes of a vehicle with thrusters only, in the order of forces and moments.
const AXES: [&str; 6] = ["surge", "sway", "heave", "roll", "pitch", "yaw"];

/// Converts actions to inputs.
#[derive(Clone, Debug)]
pub(crate) struct Actions {
    /// Constant inputs; inputs of thrusters are 0 if axes are used.
    held: Vec<f64>,
    /// The target of each action, with the value at -1 and at 1.
    moved: Vec<(Moved, [f64; 2])>,
    shared: Option<Shared>,
}

#[derive(Clone, Debug)]
enum Moved {
    /// An input, by its index.
    Input(usize),
    /// A force or moment: the thrust of each thruster \[N\] per N or N m.
    Axis(Vec<f64>),
}

/// Thrusters that share forces and moments.
#[derive(Clone, Debug)]
struct Shared {
    /// The constant thrust of each \[N\].
    held: Vec<f64>,
    /// The input of each, and its curve.
    thrusters: Vec<(usize, Inverse)>,
}

impl Actions {
    /// For a vehicle with these names of moved and constant inputs or axes.
    pub(crate) fn new(
        vehicle: &Vehicle,
        moved: &[(String, [f64; 2])],
        held: &[(String, f64)],
    ) -> Result<Self, Refused> {
        let parts = vehicle.parts();
        let refused = |entry: &str, reason: String| Err(Refused::option(entry, reason));
        if moved.is_empty() {
            return refused("actions", format!("none given; {}", choices(parts)));
        }
        let mut all = Self {
            held: vec![0.0; parts.inputs.len()],
            moved: Vec::new(),
            shared: None,
        };
        for (name, value) in held {
            if !value.is_finite() {
                return refused("held", format!("{name} {value} is not finite"));
            }
            match all.resolve(parts, "held", name)? {
                Moved::Input(k) => all.held[k] = *value,
                Moved::Axis(thrusts) => {
                    for (sum, thrust) in all
                        .shared
                        .iter_mut()
                        .flat_map(|it| &mut it.held)
                        .zip(thrusts)
                    {
                        *sum += value * thrust;
                    }
                }
            }
        }
        for (name, range) in moved {
            if !(range[0] < range[1] && range.iter().all(|x| x.is_finite())) {
                return refused(
                    "actions",
                    format!(
                        "{name} {range:?}: give the smallest and the largest value, in this order"
                    ),
                );
            }
            if held.iter().any(|(other, _)| other == name) {
                return refused(
                    "held",
                    format!("{name} is set to a constant, but an action already moves it"),
                );
            }
            let one = all.resolve(parts, "actions", name)?;
            all.moved.push((one, *range));
        }
        let by_input = |(one, _): &(Moved, _)| matches!(one, Moved::Input(_));
        if all.shared.is_some() && all.moved.iter().any(by_input) {
            return refused(
                "actions",
                "actions are either axes or single thrusters, not both".to_owned(),
            );
        }
        Ok(all)
    }

    /// The target that a name refers to.
    fn resolve(&mut self, parts: &Parts, entry: &str, name: &str) -> Result<Moved, Refused> {
        if let Some(k) = parts.inputs.iter().position(|input| input == name) {
            return Ok(Moved::Input(k));
        }
        let axis = AXES.iter().position(|axis| *axis == name);
        let (Some(axis), Some(thrusters)) = (axis, thrusters(parts)) else {
            let reason = format!("'{name}' is none; {}", choices(parts));
            return Err(Refused::option(entry, reason));
        };
        let all: Vec<&Thruster> = thrusters.iter().map(|(_, thruster)| *thruster).collect();
        let allocation =
            Allocation::new(&all).map_err(|e| Refused::option(entry, e.to_string()))?;
        let mut wanted = [0.0; 6];
        wanted[axis] = 1.0;
        self.shared.get_or_insert_with(|| Shared {
            held: vec![0.0; all.len()],
            thrusters: thrusters
                .iter()
                .map(|(k, it)| (*k, Inverse::new(it)))
                .collect(),
        });
        Ok(Moved::Axis(allocation.thrusts(&wanted)))
    }

    /// The inputs for actions, which are limited to -1 to 1. `thrusts` is a work buffer.
    pub(crate) fn inputs(&self, actions: &[f32], inputs: &mut Vec<f64>, thrusts: &mut Vec<f64>) {
        inputs.clone_from(&self.held);
        if let Some(shared) = &self.shared {
            thrusts.clone_from(&shared.held);
        }
        for ((moved, [least, most]), action) in self.moved.iter().zip(actions) {
            let share = 0.5 * (f64::from(*action).clamp(-1.0, 1.0) + 1.0);
            let value = least + share * (most - least);
            match moved {
                Moved::Input(k) => inputs[*k] = value,
                Moved::Axis(each) => {
                    for (sum, thrust) in thrusts.iter_mut().zip(each) {
                        *sum += value * thrust;
                    }
                }
            }
        }
        for ((k, curve), thrust) in self.shared.iter().flat_map(|it| &it.thrusters).zip(thrusts) {
            inputs[*k] = curve.command(*thrust);
        }
    }
}

/// The thrusters with their inputs, if the vehicle has nothing else.
fn thrusters(parts: &Parts) -> Option<Vec<(usize, &Thruster)>> {
    let all: Vec<_> = parts.thrusters().collect();
    (!all.is_empty() && all.len() == parts.propulsors.len()).then_some(all)
}

fn choices(parts: &Parts) -> String {
    let axes = if thrusters(parts).is_some() {
        &AXES[..]
    } else {
        &[]
    };
    let names = axes
        .iter()
        .copied()
        .chain(parts.inputs.iter().map(String::as_str));
    let names: Vec<&str> = names.collect();
    format!("{} has {}", parts.name, names.join(", "))
}

#[cfg(test)]
mod tests {
    use planesman_vehicle::six_dof::{State, Water, load};

    use super::*;

    /// What the thrusters then push is what was asked for, by the vehicle's own forces.
    #[test]
    fn axes_push_with_the_force_and_moment_asked_for() {
        let vehicle = load("bluerov2_heavy").expect("built in");
        let ask: [(&str, [f64; 2]); 3] = [
            ("surge", [-12.0, 12.0]),
            ("heave", [-20.0, -15.0]),
            ("yaw", [-2.0, 2.0]),
        ];
        let moved = ask.map(|(name, range)| (name.to_owned(), range));
        let actions = Actions::new(&vehicle, &moved, &[("sway".to_owned(), 5.0)]).expect("axes");
        let (mut inputs, mut thrusts) = (Vec::new(), Vec::new());
        actions.inputs(&[1.0; 3], &mut inputs, &mut thrusts);
        let state = State::of_row([
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        ]);
        let pushed = vehicle
            .forces(&state, &inputs, &Water::at_rest())
            .propulsion;
        for (got, asked) in pushed.iter().zip([12.0, 5.0, -15.0, 0.0, 0.0, 2.0]) {
            assert!((got - asked).abs() < 0.02, "{pushed:?}");
        }
    }

    #[test]
    fn a_command_of_a_curve_gives_its_thrust_and_the_most_beyond() {
        let vehicle = load("bluerov2_heavy").expect("built in");
        let thruster = thrusters(vehicle.parts()).expect("thrusters")[0].1;
        let curve = Inverse::new(thruster);
        for thrust in [-30.0, -3.0, -0.01, 0.0, 0.2, 7.0, 29.0] {
            let got = thruster.thrust(curve.command(thrust));
            assert!((got - thrust).abs() < 2e-3, "{thrust} {got}");
        }
        assert!(thruster.thrust(curve.command(1e9)) > 30.0);
    }
}
