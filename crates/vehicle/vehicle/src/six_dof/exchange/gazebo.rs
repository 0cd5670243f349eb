//! Gazebo: SDF of gz-sim's systems Hydrodynamics and Thruster (gz-sim main 93bbf3ed of 2026-07-02, version 11.0.0; gz-math 12f4a7bb).
//!
//! | entry | sign of a passive vehicle | source |
//! |---|---|---|
//! | `xDotU` | negative: `force = xDotU u'` | Hydrodynamics.hh, "Added Mass"; Hydrodynamics.cc, `PreUpdate` |
//! | `fluid_added_mass` | positive, about the link's origin | gz-math Inertial.hh; HydrodynamicsUtils.hh, `buildFullCoriolisMatrix` |
//! | `xU`, `xUabsU`, `xUV` | negative: `force = xU u + xUabsU u \|u\| + xUV u v` | HydrodynamicsUtils.hh, `buildDampingMatrix` |
//! | `thrust_coefficient` | `thrust = rho D^4 k w \|w\|`, `w` in rad/s | Thruster.cc, `AngularVelToThrust` |
//!
//! Axes forward, port, up. Added mass is written as `fluid_added_mass`: with DART it is integrated implicitly, and the plugin's own
//! entries are deprecated.

use std::f64::consts::TAU;

use roxmltree::Node;

use super::super::coefficients::{Factor, Term};
use super::super::inertia::Matrix6;
use super::super::lanes::Three;
use super::super::propulsion::{Propulsor, line_of_force};
use super::super::vehicle::Parts;
use super::numbers::{
    FLIP, Format, ModelNumbers, Place, ReadError, flipped, flipped_inertia, is_zero, name,
};
use super::xml::{self, Writer, row};

const ROWS: [&str; 6] = ["x", "y", "z", "k", "m", "n"];
const COLUMNS: [&str; 6] = ["U", "V", "W", "P", "Q", "R"];
const AXES: [&str; 6] = ["x", "y", "z", "p", "q", "r"];

/// Mass of the link that carries a thruster's joint \[kg\].
const PROPELLER_MASS: f64 = 1e-3;

/// Writes the model; returns the XML, and the parts of the vehicle that it does not contain.
pub(super) fn write(parts: &Parts, numbers: &ModelNumbers, density: f64) -> (String, Vec<String>) {
    let mut xml = Writer::default();
    let mut omitted = vec![format!(
        "the density of the water: set <uniform_fluid_density>{density}</uniform_fluid_density> in the world's buoyancy system"
    )];
    xml.open("sdf", &[("version", "1.11")]);
    xml.open("model", &[("name", &parts.name)]);
    write_link(parts, numbers, density, &mut xml);
    xml.open(
        "plugin",
        &[
            ("filename", "gz-sim-hydrodynamics-system"),
            ("name", "gz::sim::systems::Hydrodynamics"),
        ],
    );
    xml.leaf("link_name", "base_link");
    for i in 0..6 {
        for j in 0..6 {
            let sign = -FLIP[i] * FLIP[j];
            let (tag, column) = (format!("{}{}", ROWS[i], COLUMNS[j]), COLUMNS[j]);
            let (linear, quadratic) = (
                numbers.damping.linear[i][j],
                numbers.damping.quadratic[i][j],
            );
            if linear != 0.0 {
                xml.leaf(&tag, sign * linear);
            }
            if quadratic != 0.0 {
                xml.leaf(&format!("{tag}abs{column}"), sign * quadratic);
            }
        }
    }
    for term in &numbers.terms {
        let r = term.row;
        match term.of {
            Factor::Velocities(j, k) => {
                let tag = format!("{}{}{}", ROWS[r], COLUMNS[j], COLUMNS[k]);
                xml.leaf(&tag, FLIP[r] * FLIP[j] * FLIP[k] * term.value);
            }
            Factor::Drag(j, k) => {
                let tag = format!("{}{}abs{}", ROWS[r], COLUMNS[j], COLUMNS[k]);
                xml.leaf(&tag, FLIP[r] * FLIP[j] * term.value);
            }
            _ => omitted.push(name(term, &parts.inputs)),
        }
    }
    xml.close();
    for propulsor in &parts.propulsors {
        write_thruster(parts, propulsor, density, &mut xml, &mut omitted);
    }
    (xml.finish(), omitted)
}

fn write_link(parts: &Parts, numbers: &ModelNumbers, density: f64, xml: &mut Writer) {
    let pose = |place: Three<f64>| row(flipped(place).into_iter().chain([0.0; 3]));
    xml.open("link", &[("name", "base_link")]);
    xml.open("inertial", &[]);
    xml.leaf("pose", pose(numbers.centre_of_gravity));
    xml.leaf("mass", parts.body.mass);
    write_inertia(flipped_inertia(numbers.inertia.unwrap_or_default()), xml);
    xml.open("fluid_added_mass", &[]);
    for i in 0..6 {
        for j in i..6 {
            let value = FLIP[i] * FLIP[j] * parts.added_mass[i][j];
            if value != 0.0 {
                xml.leaf(&format!("{}{}", AXES[i], AXES[j]), value);
            }
        }
    }
    xml.close();
    xml.close();
    // A box of the hull's proportions with the displaced volume, at the centre of buoyancy: what the buoyancy system needs.
    let hull = [parts.hull.length, parts.hull.width, parts.hull.height];
    let size = scaled_to(hull, numbers.displaced.unwrap_or_default() / density);
    xml.open("collision", &[("name", "displacement")]);
    xml.leaf("pose", pose(parts.centre_of_buoyancy));
    xml.open("geometry", &[]);
    xml.open("box", &[]);
    xml.leaf("size", row(size));
    (0..4).for_each(|_| xml.close());
}

fn write_inertia(i: [Three<f64>; 3], xml: &mut Writer) {
    xml.open("inertia", &[]);
    for (tag, value) in [("ixx", i[0][0]), ("ixy", i[0][1]), ("ixz", i[0][2])] {
        xml.leaf(tag, value + 0.0);
    }
    for (tag, value) in [("iyy", i[1][1]), ("iyz", i[1][2]), ("izz", i[2][2])] {
        xml.leaf(tag, value + 0.0);
    }
    xml.close();
}

/// The box of these proportions with a volume \[m^3\].
pub(super) fn scaled_to(size: Three<f64>, volume: f64) -> Three<f64> {
    let factor = libm::cbrt(volume / (size[0] * size[1] * size[2]));
    size.map(|x| factor * x)
}

/// Writes the link and the joint that the thruster system needs.
fn write_joint(link: &str, joint: &str, place: Three<f64>, axis: Three<f64>, xml: &mut Writer) {
    xml.open("link", &[("name", link)]);
    xml.leaf("pose", row(flipped(place).into_iter().chain([0.0; 3])));
    xml.open("inertial", &[]);
    xml.leaf("mass", PROPELLER_MASS);
    let small = 1e-2 * PROPELLER_MASS;
    write_inertia(
        [[small, 0.0, 0.0], [0.0, small, 0.0], [0.0, 0.0, small]],
        xml,
    );
    xml.close();
    xml.close();
    xml.open("joint", &[("name", joint), ("type", "revolute")]);
    xml.leaf("parent", "base_link");
    xml.leaf("child", link);
    xml.open("axis", &[]);
    xml.leaf("xyz", row(flipped(axis)));
    xml.close();
    xml.close();
}

/// Writes a thruster's link, joint and plugin.
fn write_thruster(
    parts: &Parts,
    propulsor: &Propulsor,
    density: f64,
    xml: &mut Writer,
    omitted: &mut Vec<String>,
) {
    let forward = [1.0, 0.0, 0.0];
    let (input, place, axis) = match propulsor {
        Propulsor::Constant { force, .. } => {
            omitted.push(format!("constant thrust of {force} N"));
            return;
        }
        Propulsor::Propeller { input, .. } => (*input, [0.0; 3], forward),
        Propulsor::Force { input, wrench, .. } => match line_of_force(wrench) {
            Some((place, direction)) => (*input, place, direction),
            None => {
                omitted.push(format!("moment '{}'", parts.inputs[*input]));
                return;
            }
        },
        Propulsor::Thruster { input, thruster } => (*input, thruster.position, thruster.direction),
    };
    let input = &parts.inputs[input];
    let (link, joint) = (format!("{input}_propeller"), format!("{input}_joint"));
    write_joint(&link, &joint, place, axis, xml);
    xml.open(
        "plugin",
        &[
            ("filename", "gz-sim-thruster-system"),
            ("name", "gz::sim::systems::Thruster"),
        ],
    );
    xml.leaf("namespace", &parts.name);
    xml.leaf("joint_name", &joint);
    match propulsor {
        Propulsor::Propeller { propeller, .. } => {
            // K_T of n in 1/s to that of w in rad/s; the deduction is part of the thrust.
            let share = 1.0 - propeller.deduction;
            xml.leaf("use_angvel_cmd", true);
            xml.leaf("fluid_density", propeller.density);
            xml.leaf("propeller_diameter", propeller.diameter);
            xml.leaf("alpha_1", share * propeller.thrust[0] / (TAU * TAU));
            xml.leaf("alpha_2", share * propeller.thrust[1] / TAU);
            xml.leaf("wake_fraction", propeller.wake);
            omitted.push(format!("torque of the propeller '{input}'"));
        }
        Propulsor::Force { limits, .. } => {
            xml.leaf("fluid_density", density);
            xml.leaf("max_thrust_cmd", limits[1]);
            xml.leaf("min_thrust_cmd", limits[0]);
        }
        Propulsor::Thruster { thruster, .. } => {
            xml.leaf("fluid_density", density);
            xml.leaf("max_thrust_cmd", thruster.thrust(1.0));
            xml.leaf("min_thrust_cmd", thruster.thrust(-1.0));
            if thruster.dead_zone > 0.0 {
                let edge = thruster.dead_zone * (1.0 + 1e-9);
                xml.leaf("deadband", thruster.thrust(edge).abs());
            }
            omitted.push(format!(
                "curve of '{input}': its command is the thrust in N"
            ));
            if thruster.lag > 0.0 {
                omitted.push(format!("lag of '{input}'"));
            }
        }
        Propulsor::Constant { .. } => {}
    }
    xml.close();
}

/// Reads the link with a hydrodynamics plugin or with added mass; `None` if there is neither.
pub(super) fn read(root: Node<'_, '_>, density: f64) -> Option<Result<ModelNumbers, ReadError>> {
    let is_plugin = |it: &Node<'_, '_>| {
        let of = |attribute| it.attribute(attribute).unwrap_or_default().to_lowercase();
        it.tag_name().name() == "plugin"
            && (of("name").contains("hydrodynamics") || of("filename").contains("hydrodynamics"))
    };
    let plugin = root.descendants().find(is_plugin);
    let fluid = xml::first(root, "fluid_added_mass");
    if plugin.is_none() && fluid.is_none() {
        return None;
    }
    let named = plugin.and_then(|it| xml::child(it, "link_name")?.text());
    // Without a plugin it is the link with the added mass.
    let of_fluid = fluid.and_then(|it| it.parent()?.parent());
    let link = match plugin {
        Some(_) => xml::link(root, named.map(str::trim)),
        None => of_fluid,
    };
    Some(read_link(root, plugin, link, density))
}

fn read_link(
    root: Node<'_, '_>,
    plugin: Option<Node<'_, '_>>,
    link: Option<Node<'_, '_>>,
    density: f64,
) -> Result<ModelNumbers, ReadError> {
    let named = link.and_then(|it| it.attribute("name"));
    let of_plugin = plugin.and_then(|it| xml::child(it, "link_name")?.text());
    let title = named.or(of_plugin).unwrap_or("vehicle").trim();
    let mut into = ModelNumbers::empty(Format::Gazebo, title);
    into.added_mass = Some(Matrix6::default());
    let stated = ["uniform_fluid_density", "default_density"]
        .into_iter()
        .find_map(|tag| {
            let of = xml::first(root, tag)?.parent()?;
            xml::number(of, tag).transpose()
        });
    let density = stated.transpose()?.unwrap_or(density);
    if let Some(link) = link {
        xml::read_inertial(link, &mut into)?;
        xml::read_collisions(link, density, &mut into)?;
        if let Some(fluid) = xml::first(link, "fluid_added_mass") {
            read_fluid(fluid, &mut into)?;
        }
    }
    if let Some(plugin) = plugin {
        read_plugin(plugin, &mut into)?;
    }
    Ok(into)
}

fn read_fluid(fluid: Node<'_, '_>, into: &mut ModelNumbers) -> Result<(), ReadError> {
    for i in 0..6 {
        for j in i..6 {
            let tag = format!("{}{}", AXES[i], AXES[j]);
            let Some(value) = xml::number(fluid, &tag)? else {
                continue;
            };
            let (name, sign) = (format!("fluid_added_mass.{tag}"), FLIP[i] * FLIP[j]);
            into.put(Place::AddedMass(i, j), name, value, sign);
            if i != j {
                into.added_mass.get_or_insert_default()[j][i] += sign * value;
            }
        }
    }
    Ok(())
}

fn read_plugin(plugin: Node<'_, '_>, into: &mut ModelNumbers) -> Result<(), ReadError> {
    let is_disabled = xml::child(plugin, "disable_added_mass")
        .and_then(|it| it.text())
        .is_some_and(|text| ["true", "1"].contains(&text.trim()));
    let has_fluid = !into.added_mass.as_ref().is_none_or(is_zero);
    let mut has_own = false;
    for i in 0..6 {
        for j in 0..6 {
            let sign = -FLIP[i] * FLIP[j];
            let tag = format!("{}Dot{}", ROWS[i], COLUMNS[j]);
            if let Some(value) = xml::number(plugin, &tag)? {
                match is_disabled {
                    true => into.ignored.push(format!("{tag} (disable_added_mass)")),
                    false => into.put(Place::AddedMass(i, j), tag, value, sign),
                }
                has_own |= value != 0.0 && !is_disabled;
            }
            let tag = format!("{}{}", ROWS[i], COLUMNS[j]);
            if let Some(value) = xml::number(plugin, &tag)? {
                into.put(Place::Linear(i, j), tag.clone(), value, sign);
            }
            for k in 0..6 {
                read_product(plugin, [i, j, k], &tag, into)?;
            }
        }
    }
    if has_fluid && has_own {
        into.added_mass_twice = Some(["fluid_added_mass", "xDotU and the like"]);
    }
    Ok(())
}

/// Reads `xVabsW` and `xVW`.
fn read_product(
    plugin: Node<'_, '_>,
    [i, j, k]: [usize; 3],
    prefix: &str,
    into: &mut ModelNumbers,
) -> Result<(), ReadError> {
    let (sign, column) = (FLIP[i] * FLIP[j], COLUMNS[k]);
    let mut add = |of, value| into.terms.push(Term { row: i, of, value });
    let product = xml::number(plugin, &format!("{prefix}{column}"))?;
    if let Some(value) = product {
        add(
            Factor::Velocities(j.min(k), j.max(k)),
            sign * FLIP[k] * value,
        );
    }
    let tag = format!("{prefix}abs{column}");
    if let Some(value) = xml::number(plugin, &tag)? {
        match j == k {
            true => into.put(Place::Quadratic(i, j), tag, value, -sign),
            false => add(Factor::Drag(j, k), sign * value),
        }
    }
    if let (Some(value), true) = (product, i == j && j == k) {
        let factor = sign * FLIP[k];
        into.put(Place::Square(i), format!("{prefix}{column}"), value, factor);
    }
    Ok(())
}
