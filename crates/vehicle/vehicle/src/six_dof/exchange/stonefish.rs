//! Stonefish: XML of a robot (patrykcieslak/stonefish b21eb8e1 of 2026-07-14, version 1.6.0).
//!
//! Stonefish computes added mass and drag from the shape. The file has drag coefficients along the body's axes, at least 0: a negative one
//! is ignored with its triple (SolidEntity.cpp, `SetHydrodynamicCoefficients`). Axes forward, starboard, keel (docs/theory.rst), inertia
//! about the centre of gravity (`SetArbitraryPhysicalProperties`), thrust along +x of the thruster's frame (Thruster.cpp, `Update`).
//!
//! ```text
//! quadratic_drag C_d: force = 1/2 rho C_d A v^2      viscous_drag C_f: force = rho C_f S v      (SolidEntity.cpp, CorrectHydrodynamicForces)
//! ```
//! `A` is the projected area, `S` the area along which the water slides. The sum over the faces (`ComputeHydrodynamicForcesSubmerged`) has
//! `v^3` since version 1.4, contrary to this formula: the two agree at 1 m/s.

use roxmltree::Node;

use super::super::lanes::{Six, Three};
use super::super::propulsion::{Propulsor, line_of_force};
use super::super::vehicle::Parts;
use super::dave;
use super::gazebo::scaled_to;
use super::numbers::{Format, ModelNumbers, Place, ReadError, name};
use super::xml::{self, Shape, Writer, row};

/// Writes the robot; returns the XML, and the parts of the vehicle that it does not contain.
pub(super) fn write(parts: &Parts, numbers: &ModelNumbers, density: f64) -> (String, Vec<String>) {
    let mut xml = Writer::default();
    let mut omitted = vec![
        format!("the density of the water: set <water density=\"{density}\"/> in the ocean"),
        "added mass: computed from the shape".to_owned(),
        "damping in roll, pitch, yaw: computed from the shape".to_owned(),
    ];
    let damping = [
        ("linear_damping", &numbers.damping.linear),
        ("quadratic_damping", &numbers.damping.quadratic),
    ];
    for (entry, matrix) in damping {
        let others = (0..6).flat_map(|i| (0..6).map(move |j| (i, j)));
        let others = others.filter(|(i, j)| i != j && matrix[*i][*j] != 0.0);
        omitted.extend(others.map(|(i, j)| format!("{entry}_{}{}", i + 1, j + 1)));
    }
    omitted.extend(numbers.terms.iter().map(|it| name(it, &parts.inputs)));
    let hull = [parts.hull.length, parts.hull.width, parts.hull.height];
    let size = scaled_to(hull, numbers.displaced.unwrap_or_default() / density);
    let [quadratic, linear] = factors(&Shape::cuboid(size), density);
    let inertia = numbers.inertia.unwrap_or_default();
    if [inertia[0][1], inertia[0][2], inertia[1][2]] != [0.0; 3] {
        omitted.push("products of inertia".to_owned());
    }
    xml.open("scenario", &[]);
    xml.open(
        "robot",
        &[
            ("name", &parts.name),
            ("fixed", "false"),
            ("self_collisions", "false"),
        ],
    );
    xml.open(
        "base_link",
        &[
            ("name", "base_link"),
            ("type", "box"),
            ("physics", "submerged"),
            ("buoyant", "true"),
        ],
    );
    xml.empty("dimensions", &[("xyz", &row(size))]);
    let placed = |tag: &str, place: Three<f64>, xml: &mut Writer| {
        xml.empty(tag, &[("xyz", &row(place)), ("rpy", "0 0 0")]);
    };
    placed("origin", parts.centre_of_buoyancy, &mut xml);
    xml.empty("mass", &[("value", &parts.body.mass.to_string())]);
    xml.empty("inertia", &[("xyz", &row((0..3).map(|i| inertia[i][i])))]);
    placed("cg", numbers.centre_of_gravity, &mut xml);
    let of = |matrix: &[Six<f64>; 6], by: Three<f64>| row((0..3).map(|i| matrix[i][i] / by[i]));
    let viscous = of(&numbers.damping.linear, linear);
    let drag = of(&numbers.damping.quadratic, quadratic);
    xml.empty(
        "hydrodynamics",
        &[("viscous_drag", &viscous), ("quadratic_drag", &drag)],
    );
    xml.empty("material", &[("name", "Neutral")]);
    xml.empty("look", &[("name", "Yellow")]);
    xml.close();
    for propulsor in &parts.propulsors {
        write_thruster(parts, propulsor, &mut xml, &mut omitted);
    }
    placed("world_transform", [0.0; 3], &mut xml);
    (xml.finish(), omitted)
}

/// Force per coefficient and per `v^2`, and per coefficient and `v`, along each axis.
fn factors(shape: &Shape, density: f64) -> [Three<f64>; 2] {
    [
        shape.front.map(|area| 0.5 * density * area),
        shape.skin.map(|area| density * area),
    ]
}

fn write_thruster(parts: &Parts, it: &Propulsor, xml: &mut Writer, omitted: &mut Vec<String>) {
    let propeller = |xml: &mut Writer| {
        xml.empty("mesh", &[("filename", "propeller.obj"), ("scale", "1.0")]);
        xml.empty("material", &[("name", "Neutral")]);
        xml.empty("look", &[("name", "Yellow")]);
        xml.close();
    };
    let (place, direction) = match it {
        Propulsor::Force {
            input,
            limits,
            wrench,
        } => {
            let name = &parts.inputs[*input];
            let Some(line) = line_of_force(wrench) else {
                omitted.push(format!("moment '{name}'"));
                return;
            };
            xml.open("actuator", &[("name", name), ("type", "simple_thruster")]);
            let [low, high] = limits.map(|x| x.to_string());
            xml.empty(
                "specs",
                &[("lower_thrust_limit", &low), ("upper_thrust_limit", &high)],
            );
            xml.open("propeller", &[("right", "true")]);
            propeller(xml);
            line
        }
        Propulsor::Thruster { input, thruster } => {
            let name = &parts.inputs[*input];
            xml.open("actuator", &[("name", name), ("type", "thruster")]);
            xml.empty(
                "specs",
                &[("max_setpoint", "1"), ("normalized_setpoint", "true")],
            );
            // A left-handed one would reverse the thrust.
            xml.open("propeller", &[("diameter", "0.1"), ("right", "true")]);
            propeller(xml);
            match thruster.lag > 0.0 {
                true => {
                    xml.open("rotor_dynamics", &[("type", "first_order")]);
                    xml.empty("time_constant", &[("value", &thruster.lag.to_string())]);
                    xml.close();
                }
                false => xml.empty("rotor_dynamics", &[("type", "zero_order")]),
            }
            xml.open("thrust_model", &[("type", "linear_interpolation")]);
            let [commands, thrusts] = dave::samples(thruster);
            xml.empty("input", &[("value", &commands)]);
            xml.empty("output", &[("value", &thrusts)]);
            xml.close();
            omitted.push(format!("curve of '{name}' between its points"));
            (thruster.position, thruster.direction)
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
    // Yaw and pitch that turn x into the direction.
    let [x, y, z] = direction;
    let (pitch, yaw) = (libm::atan2(-z, libm::hypot(x, y)), libm::atan2(y, x));
    let angles = row([0.0, pitch, yaw]);
    xml.empty("origin", &[("xyz", &row(place)), ("rpy", &angles)]);
    xml.empty("link", &[("name", "base_link")]);
    xml.close();
}

/// Reads a base link or dynamic body.
pub(super) fn read(
    root: Node<'_, '_>,
    body: Node<'_, '_>,
    density: f64,
) -> Result<ModelNumbers, ReadError> {
    let title = body
        .parent()
        .filter(|it| it.tag_name().name() == "robot")
        .unwrap_or(body);
    let mut into =
        ModelNumbers::empty(Format::Stonefish, title.attribute("name").unwrap_or("body"));
    into.damped_by_shape = [true; 6];
    let water = xml::first(root, "water").map(|it| xml::number(it, "density"));
    let density = water.transpose()?.flatten().unwrap_or(density);
    if let Some(mass) = xml::number(body, "mass")? {
        into.put(Place::Mass, "mass".to_owned(), mass, 1.0);
    }
    let (gravity, turned) = xml::pose(body, "cg")?;
    into.centre_of_gravity = gravity;
    let moments = xml::child(body, "inertia").map(|it| xml::triple(it, "xyz"));
    into.inertia = moments
        .transpose()?
        .flatten()
        .map(|[x, y, z]| xml::rotated(&turned, &[[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]));
    let shape = shape(body)?;
    let (place, turned) = xml::pose(body, "origin")?;
    let mut by = [[0.0; 3]; 2];
    match shape {
        Some(shape) => {
            into.displaced = Some(density * shape.volume);
            into.centre_of_buoyancy = Some(place);
            // Areas along the body's axes: exact for a shape turned by right angles.
            let along = turned.map(|row| row.map(f64::abs));
            by = factors(&shape, density).map(|of| super::super::lanes::product(&along, &of));
        }
        None => into
            .ignored
            .push("volume and areas of the mesh: not computed".to_owned()),
    }
    if let Some(it) = xml::child(body, "hydrodynamics") {
        for (k, tag) in ["quadratic_drag", "viscous_drag"].into_iter().enumerate() {
            for (i, value) in xml::triple(it, tag)?.into_iter().flatten().enumerate() {
                let place = [Place::Quadratic(i, i), Place::Linear(i, i)][k];
                into.put(
                    place,
                    format!("{tag}.{}", ["x", "y", "z"][i]),
                    value,
                    by[k][i],
                );
            }
        }
    }
    Ok(into)
}

/// The shape of a body; `None` for a mesh.
fn shape(body: Node<'_, '_>) -> Result<Option<Shape>, ReadError> {
    let kind = body.attribute("type").unwrap_or_default();
    let sizes = xml::child(body, "dimensions");
    let of = |name| sizes.map_or(Ok(None), |it| xml::number(it, name));
    match kind {
        "box" => {
            let size = sizes.map_or(Ok(None), |it| xml::triple(it, "xyz"))?;
            Ok(size.map(Shape::cuboid))
        }
        "sphere" => Ok(of("radius")?.map(Shape::sphere)),
        "cylinder" => {
            let sizes = of("radius")?.zip(of("height")?);
            Ok(sizes.map(|(radius, height)| Shape::cylinder(radius, height)))
        }
        "model" => Ok(None),
        other => Err(ReadError::Unsupported {
            entry: "type".to_owned(),
            text: other.to_owned(),
            accepted: "box, sphere, cylinder and model",
        }),
    }
}
