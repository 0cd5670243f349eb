//! DAVE on Gazebo Classic: URDF with the plugins of the UUV simulator (Field-Robotics-Lab/dave e54ea16b of 2023-12-04, uuv_simulator
//! bfb40cb1 of 2020-06-15, version 0.6.13). DAVE for ROS 2 (IOES-Lab/dave 2bd7ccef) uses Gazebo's system instead.
//!
//! | entry | sign of a passive vehicle | source |
//! |---|---|---|
//! | `added_mass` | positive: `force = -M_A nu'` | HydrodynamicModel.cc, `ApplyHydrodynamicForces` |
//! | `linear_damping`, `quadratic_damping` | negative: `force = D nu + Q nu \|nu\|`, of `Q` only the diagonal | the same, `ComputeDampingMatrix` |
//! | `linear_damping_forward_speed` | negative: `force = u D_u nu` | the same |
//!
//! The matrices are in axes forward, starboard, keel (`ToNED`), the centre of buoyancy and the inertia in those of the link: forward,
//! port, up. Default density 1028 kg/m^3 (UnderwaterObjectPlugin.cc).

use roxmltree::Node;

use super::super::coefficients::{Factor, Term};
use super::super::inertia::Matrix6;
use super::super::propulsion::{Propulsor, line_of_force};
use super::super::vehicle::Parts;
use super::numbers::{Format, ModelNumbers, Place, ReadError, flipped, flipped_inertia, name};
use super::xml::{self, Writer, row};

/// Points of a thruster's curve.
const POINTS: i32 = 40;

/// Writes the robot; returns the XML, and the parts of the vehicle that it does not contain.
pub(super) fn write(parts: &Parts, numbers: &ModelNumbers, density: f64) -> (String, Vec<String>) {
    let mut xml = Writer::default();
    let mut omitted = Vec::new();
    xml.open("robot", &[("name", &parts.name)]);
    xml.open("link", &[("name", "base_link")]);
    let place = row(flipped(numbers.centre_of_gravity));
    write_inertial(
        &place,
        parts.body.mass,
        numbers.inertia.unwrap_or_default(),
        &mut xml,
    );
    xml.close();
    xml.open("gazebo", &[]);
    xml.open(
        "plugin",
        &[
            ("name", "uuv_plugin"),
            ("filename", "libuuv_underwater_object_ros_plugin.so"),
        ],
    );
    xml.leaf("fluid_density", density);
    xml.leaf("flow_velocity_topic", "hydrodynamics/current_velocity");
    xml.open("link", &[("name", "base_link")]);
    xml.leaf("neutrally_buoyant", 0);
    xml.leaf("volume", numbers.displaced.unwrap_or_default() / density);
    xml.open("box", &[]);
    xml.leaf("width", parts.hull.width);
    xml.leaf("length", parts.hull.length);
    xml.leaf("height", parts.hull.height);
    xml.close();
    xml.leaf("center_of_buoyancy", row(flipped(parts.centre_of_buoyancy)));
    xml.open("hydrodynamic_model", &[]);
    xml.leaf("type", "fossen");
    let all = |a: &Matrix6, sign: f64| row(a.iter().flatten().map(|x| sign * x));
    xml.leaf("added_mass", all(&parts.added_mass, 1.0));
    xml.leaf("linear_damping", all(&numbers.damping.linear, -1.0));
    let mut forward = Matrix6::default();
    for term in &numbers.terms {
        match term.of {
            Factor::Velocities(0, j) => forward[term.row][j] += term.value,
            _ => omitted.push(name(term, &parts.inputs)),
        }
    }
    xml.leaf("linear_damping_forward_speed", all(&forward, 1.0));
    let quadratic = &numbers.damping.quadratic;
    xml.leaf("quadratic_damping", row((0..6).map(|i| -quadratic[i][i])));
    for (i, of) in quadratic.iter().enumerate() {
        let others = (0..6).filter(|j| *j != i && of[*j] != 0.0);
        omitted.extend(others.map(|j| format!("quadratic_damping_{}{}", i + 1, j + 1)));
    }
    (0..4).for_each(|_| xml.close());
    for (id, propulsor) in parts.propulsors.iter().enumerate() {
        write_thruster(parts, id, propulsor, &mut xml, &mut omitted);
    }
    (xml.finish(), omitted)
}

fn write_inertial(place: &str, mass: f64, inertia: [[f64; 3]; 3], xml: &mut Writer) {
    let i = flipped_inertia(inertia).map(|row| row.map(|x| (x + 0.0).to_string()));
    xml.open("inertial", &[]);
    xml.empty("origin", &[("xyz", place), ("rpy", "0 0 0")]);
    xml.empty("mass", &[("value", &mass.to_string())]);
    xml.empty(
        "inertia",
        &[
            ("ixx", &i[0][0]),
            ("ixy", &i[0][1]),
            ("ixz", &i[0][2]),
            ("iyy", &i[1][1]),
            ("iyz", &i[1][2]),
            ("izz", &i[2][2]),
        ],
    );
    xml.close();
}

/// Thrust \[N\] at commands from -1 to 1: two lists of a conversion function.
pub(super) fn samples(thruster: &super::super::propulsion::Thruster) -> [String; 2] {
    let commands = || (-POINTS / 2..=POINTS / 2).map(|k| f64::from(k) / f64::from(POINTS / 2));
    [
        row(commands()),
        row(commands().map(|command| thruster.thrust(command))),
    ]
}

fn write_thruster(
    parts: &Parts,
    id: usize,
    propulsor: &Propulsor,
    xml: &mut Writer,
    omitted: &mut Vec<String>,
) {
    let (input, place, axis, curve, lag) = match propulsor {
        Propulsor::Thruster { input, thruster } => {
            let curve = samples(thruster);
            let of = &parts.inputs[*input];
            omitted.push(format!("curve of '{of}' between {} points", POINTS + 1));
            (
                of,
                thruster.position,
                thruster.direction,
                curve,
                thruster.lag,
            )
        }
        Propulsor::Force {
            input,
            limits: [low, high],
            wrench,
        } => {
            let input = &parts.inputs[*input];
            let Some((place, direction)) = line_of_force(wrench) else {
                omitted.push(format!("moment '{input}'"));
                return;
            };
            let curve = [row([*low, *high]), row([*low, *high])];
            (input, place, direction, curve, 0.0)
        }
        Propulsor::Propeller { input, .. } => {
            omitted.push(format!("propeller '{}'", parts.inputs[*input]));
            return;
        }
        Propulsor::Constant { force, .. } => {
            omitted.push(format!("constant thrust of {force} N"));
            return;
        }
    };
    let (link, joint) = (format!("thruster_{id}"), format!("thruster_{id}_joint"));
    xml.open("link", &[("name", &link)]);
    let small = [[1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0], [0.0, 0.0, 1e-5]];
    write_inertial("0 0 0", 1e-3, small, xml);
    xml.close();
    xml.open("joint", &[("name", &joint), ("type", "continuous")]);
    xml.empty("origin", &[("xyz", &row(flipped(place))), ("rpy", "0 0 0")]);
    xml.empty("axis", &[("xyz", &row(flipped(axis)))]);
    xml.empty("parent", &[("link", "base_link")]);
    xml.empty("child", &[("link", &link)]);
    xml.close();
    xml.open("gazebo", &[]);
    let plugin = format!("{input}_thruster_model");
    xml.open(
        "plugin",
        &[
            ("name", &plugin),
            ("filename", "libuuv_thruster_ros_plugin.so"),
        ],
    );
    xml.leaf("linkName", &link);
    xml.leaf("jointName", &joint);
    xml.leaf("thrusterID", id);
    xml.open("dynamics", &[]);
    match lag > 0.0 {
        true => {
            xml.leaf("type", "FirstOrder");
            xml.leaf("timeConstant", lag);
        }
        false => xml.leaf("type", "ZeroOrder"),
    }
    xml.close();
    xml.open("conversion", &[]);
    xml.leaf("type", "LinearInterp");
    xml.leaf("inputValues", &curve[0]);
    xml.leaf("outputValues", &curve[1]);
    (0..3).for_each(|_| xml.close());
}

/// Reads the link with this `hydrodynamic_model`.
pub(super) fn read(
    root: Node<'_, '_>,
    model: Node<'_, '_>,
    density: f64,
) -> Result<ModelNumbers, ReadError> {
    let link = model.parent().unwrap_or(root);
    let title = link.attribute("name").unwrap_or("vehicle");
    let mut into = ModelNumbers::empty(Format::Dave, title);
    if let Some(body) = xml::link(root, Some(title)) {
        xml::read_inertial(body, &mut into)?;
    }
    let plugin = link.parent().unwrap_or(root);
    let density = xml::number(plugin, "fluid_density")?.unwrap_or(density);
    into.displaced = xml::number(link, "volume")?.map(|volume| density * volume);
    let neutral = xml::child(link, "neutrally_buoyant").and_then(|it| it.text());
    if neutral.is_some_and(|text| ["1", "true"].contains(&text.trim())) {
        // The plugin then uses the link's mass and not the volume.
        into.displaced = into.mass;
        into.ignored.push("volume (neutrally_buoyant)".to_owned());
    }
    let centre = xml::child(link, "center_of_buoyancy").and_then(|it| it.text());
    let centre = centre.map(|text| xml::numbers("center_of_buoyancy", text, &[3]));
    let centre = centre.transpose()?.unwrap_or(vec![0.0; 3]);
    into.centre_of_buoyancy = Some(flipped([centre[0], centre[1], centre[2]]));
    into.added_mass = Some(Matrix6::default());
    let list = |tag: &str, counts: &[usize]| {
        let text = xml::child(model, tag).and_then(|it| it.text());
        text.map(|text| xml::numbers(tag, text, counts)).transpose()
    };
    let entry = |tag: &str, i: usize, j: usize| format!("{tag}[{},{}]", i + 1, j + 1);
    for (tag, counts) in [
        ("added_mass", &[36][..]),
        ("linear_damping", &[6, 36]),
        ("quadratic_damping", &[6, 36]),
        ("linear_damping_forward_speed", &[6, 36]),
    ] {
        let Some(all) = list(tag, counts)? else {
            continue;
        };
        for (k, value) in all.iter().enumerate() {
            let (i, j) = if all.len() == 6 {
                (k, k)
            } else {
                (k / 6, k % 6)
            };
            match tag {
                "added_mass" => into.put(Place::AddedMass(i, j), entry(tag, i, j), *value, 1.0),
                "linear_damping" => into.put(Place::Linear(i, j), entry(tag, i, j), *value, -1.0),
                "quadratic_damping" if i == j => {
                    into.put(Place::Quadratic(i, j), entry(tag, i, j), *value, -1.0);
                }
                "quadratic_damping" if *value != 0.0 => {
                    into.ignored
                        .push(format!("{}: only the diagonal is used", entry(tag, i, j)));
                }
                "linear_damping_forward_speed" if *value != 0.0 => into.terms.push(Term {
                    row: i,
                    of: Factor::Velocities(0, j),
                    value: *value,
                }),
                _ => {}
            }
        }
    }
    Ok(into)
}
