//! A vehicle with some numbers multiplied by factors, for the variation of uncertain numbers.

use super::coefficients::{Factor, term};
use super::propulsion::Propulsor;
use super::vehicle::{Parts, Unphysical, Vehicle};

/// Names that scale several numbers at once.
const GROUPS: &str = "mass, inertia, weight, buoyancy, centre_of_gravity, centre_of_buoyancy, added_mass, linear_damping, quadratic_damping, cross_flow, fins, thrust";

impl Vehicle {
    /// Returns the vehicle with each named number multiplied by its factor.
    ///
    /// A name is a group: `mass` (with the body's inertia), `inertia`, `weight`, `buoyancy`, `centre_of_gravity`, `centre_of_buoyancy`,
    /// `added_mass`, `linear_damping`, `quadratic_damping`, `cross_flow` (its drag), `fins` (their areas), `thrust` (of propellers and
    /// thrusters). Or it is a coefficient by its row and product: `Y_uv`, `N_uu_rudder` (with the input's name). Matrix entries also have such names:
    /// `X_u` (linear damping), `Z_w|w|` (quadratic damping), `M_qdot` (added mass, with its mirrored entry).
    ///
    /// # Errors
    /// [`Unphysical`], if a name is unknown or its numbers are all 0, or if the result is not physical.
    pub fn scaled<'a>(
        &self,
        factors: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Self, Unphysical> {
        let mut parts = self.parts.clone();
        for (name, factor) in factors {
            let mut is_there = false;
            for number in numbers(&mut parts, name)? {
                is_there |= *number != 0.0;
                *number *= factor;
            }
            if !is_there {
                let reason = format!(
                    "vehicle '{}' has no such number, or only zeros; a factor has no effect",
                    self.parts.name
                );
                return Err(Unphysical::new(name, reason));
            }
        }
        Self::new(parts)
    }
}

/// The numbers with a name.
fn numbers<'p>(parts: &'p mut Parts, name: &str) -> Result<Vec<&'p mut f64>, Unphysical> {
    let body = &mut parts.body;
    let inertia = body.inertia.iter_mut().flatten();
    Ok(match name {
        "mass" => std::iter::once(&mut body.mass).chain(inertia).collect(),
        "inertia" => inertia.collect(),
        "weight" => vec![&mut parts.weight],
        "buoyancy" => vec![&mut parts.buoyancy],
        "centre_of_gravity" => body.centre_of_gravity.iter_mut().collect(),
        "centre_of_buoyancy" => parts.centre_of_buoyancy.iter_mut().collect(),
        "added_mass" => parts.added_mass.iter_mut().flatten().collect(),
        "linear_damping" => parts.damping.linear.iter_mut().flatten().collect(),
        "quadratic_damping" => parts.damping.quadratic.iter_mut().flatten().collect(),
        "cross_flow" => parts.cross_flow.iter_mut().map(|it| &mut it.drag).collect(),
        "fins" => parts.fins.iter_mut().map(|fin| &mut fin.area).collect(),
        "thrust" => parts.propulsors.iter_mut().flat_map(of_thrust).collect(),
        coefficient => {
            let inputs: Vec<String> = parts.inputs.iter().map(|it| format!("_{it}")).collect();
            let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
            let named = term(coefficient, 1.0, &inputs).map_err(|e| {
                Unphysical::new(
                    coefficient,
                    format!(
                        "unknown name; use one of {GROUPS}; as a \
                    coefficient: {e}"
                    ),
                )
            })?;
            let row = named.row;
            let [added_mass, damping] = [&mut parts.added_mass, &mut parts.damping.linear];
            let quadratic = &mut parts.damping.quadratic;
            let mut found: Vec<&mut f64> = match named.of {
                Factor::Acceleration(j) => {
                    let both = added_mass.iter_mut().enumerate().flat_map(|(i, of)| {
                        of.iter_mut().enumerate().map(move |(k, x)| ((i, k), x))
                    });
                    let is_meant = |place| place == (row, j) || place == (j, row);
                    both.filter_map(|(place, x)| is_meant(place).then_some(x))
                        .collect()
                }
                Factor::Velocity(j) => vec![&mut damping[row][j]],
                Factor::Drag(i, j) if i == j => vec![&mut quadratic[row][j]],
                Factor::Drag(..) | Factor::Velocities(..) | Factor::Input(_) => Vec::new(),
            };
            let terms = parts.terms.iter_mut();
            let same = terms.filter(|term| (term.row, term.of) == (row, named.of));
            found.extend(same.map(|term| &mut term.value));
            found
        }
    })
}

/// Thrust and torque of a propulsor; a force that is an input has no separate number.
fn of_thrust(propulsor: &mut Propulsor) -> Vec<&mut f64> {
    match propulsor {
        Propulsor::Constant { force, moment } => vec![force, moment],
        Propulsor::Force { .. } => Vec::new(),
        Propulsor::Propeller { propeller, .. } => {
            let (thrust, torque) = (&mut propeller.thrust, &mut propeller.torque);
            thrust.iter_mut().chain(torque).collect()
        }
        Propulsor::Thruster { thruster, .. } => thruster.curve.iter_mut().collect(),
    }
}
