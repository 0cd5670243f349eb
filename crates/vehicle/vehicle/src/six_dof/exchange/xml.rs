//! XML: a writer of elements, and readers of the inertia and shape of links in SDF and URDF.

use std::fmt::{Display, Write as _};

use roxmltree::Node;

use super::super::lanes::{Three, product};
use super::super::rotation;
use super::numbers::{ModelNumbers, Place, ReadError, flipped, flipped_inertia};

/// Text of an XML tree.
#[derive(Default)]
pub(super) struct Writer {
    text: String,
    open: Vec<&'static str>,
}

/// Replaces the characters that XML reserves.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// Numbers separated by spaces; zeros have no sign.
pub(super) fn row(numbers: impl IntoIterator<Item = f64>) -> String {
    let all = numbers.into_iter().map(|x| (x + 0.0).to_string());
    all.collect::<Vec<_>>().join(" ")
}

impl Writer {
    fn tag(&mut self, tag: &str, attributes: &[(&str, &str)], end: &str) {
        let _ = write!(self.text, "{:1$}<{tag}", "", 2 * self.open.len());
        for (name, value) in attributes {
            let _ = write!(self.text, " {name}=\"{}\"", escaped(value));
        }
        self.text += end;
    }

    pub(super) fn open(&mut self, tag: &'static str, attributes: &[(&str, &str)]) {
        self.tag(tag, attributes, ">\n");
        self.open.push(tag);
    }

    pub(super) fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            let _ = writeln!(self.text, "{:1$}</{tag}>", "", 2 * self.open.len());
        }
    }

    /// An element with a text.
    pub(super) fn leaf(&mut self, tag: &str, text: impl Display) {
        self.tag(tag, &[], ">");
        let _ = writeln!(self.text, "{}</{tag}>", escaped(&text.to_string()));
    }

    /// An element with attributes only.
    pub(super) fn empty(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.tag(tag, attributes, "/>\n");
    }

    /// The text, with all elements closed.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }
}

/// The first element of this name below the node.
pub(super) fn first<'a, 'b>(node: Node<'a, 'b>, tag: &str) -> Option<Node<'a, 'b>> {
    node.descendants().find(|it| it.tag_name().name() == tag)
}

/// The child of this name.
pub(super) fn child<'a, 'b>(node: Node<'a, 'b>, tag: &str) -> Option<Node<'a, 'b>> {
    node.children().find(|it| it.tag_name().name() == tag)
}

/// The link of this name, or the only link.
pub(super) fn link<'a, 'b>(root: Node<'a, 'b>, name: Option<&str>) -> Option<Node<'a, 'b>> {
    let mut links = root.descendants().filter(|it| {
        let is_body = child(*it, "inertial").is_some() || child(*it, "collision").is_some();
        it.tag_name().name() == "link" && is_body
    });
    match name {
        Some(name) => links.find(|it| it.attribute("name") == Some(name)),
        None => links.next(),
    }
}

/// Finite numbers of a text, as many as one of `counts`.
pub(super) fn numbers(entry: &str, text: &str, counts: &[usize]) -> Result<Vec<f64>, ReadError> {
    let parsed: Option<Vec<f64>> = text.split_whitespace().map(|x| x.parse().ok()).collect();
    let parsed = parsed.filter(|all| all.iter().all(|x| x.is_finite()));
    parsed
        .filter(|all| counts.contains(&all.len()))
        .ok_or_else(|| {
            let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
            ReadError::Number {
                entry: entry.to_owned(),
                text: text.trim().chars().take(80).collect(),
                expected: format!("{} finite number(s)", counts.join(" or ")),
            }
        })
}

/// Number in a child's text, or in its attribute `value`, or in an attribute of this name.
pub(super) fn number(node: Node<'_, '_>, tag: &str) -> Result<Option<f64>, ReadError> {
    let inner = child(node, tag).and_then(|it| it.attribute("value").or(it.text()));
    let text = inner.or_else(|| node.attribute(tag));
    let one = text.map(|text| numbers(tag, text, &[1])).transpose()?;
    Ok(one.map(|all| all[0]))
}

fn three(all: &[f64]) -> Three<f64> {
    std::array::from_fn(|i| all.get(i).copied().unwrap_or(0.0))
}

/// Three numbers of an attribute.
pub(super) fn triple(node: Node<'_, '_>, attribute: &str) -> Result<Option<Three<f64>>, ReadError> {
    let text = node.attribute(attribute);
    let all = text
        .map(|text| numbers(attribute, text, &[3]))
        .transpose()?;
    Ok(all.map(|all| three(&all)))
}

/// Place and rotation of an element: `pose` of SDF, or `origin` of URDF and Stonefish.
pub(super) fn pose(
    node: Node<'_, '_>,
    tag: &str,
) -> Result<(Three<f64>, [Three<f64>; 3]), ReadError> {
    let (place, angles) = match child(node, tag) {
        None => ([0.0; 3], [0.0; 3]),
        Some(it) => match it.text().filter(|text| !text.trim().is_empty()) {
            Some(text) => {
                let all = numbers(tag, text, &[6])?;
                (three(&all), three(&all[3..]))
            }
            None => (
                triple(it, "xyz")?.unwrap_or_default(),
                triple(it, "rpy")?.unwrap_or_default(),
            ),
        },
    };
    Ok((place, rotation::matrix(rotation::from_euler(angles))))
}

/// `R I R^T`.
pub(super) fn rotated(r: &[Three<f64>; 3], inertia: &[Three<f64>; 3]) -> [Three<f64>; 3] {
    // Rows of the symmetric I become columns of R I.
    let half = inertia.map(|row| product(r, &row));
    std::array::from_fn(|i| product(r, &half.map(|column| column[i])))
}

/// Volume, projected areas and skin areas of a shape along its axes, as the drag of a convex body needs them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shape {
    /// \[m^3\]
    pub(super) volume: f64,
    /// Area seen along each axis \[m^2\].
    pub(super) front: Three<f64>,
    /// `int (1 - (n e)^2) dA` \[m^2\]: area along which the water slides.
    pub(super) skin: Three<f64>,
}

impl Shape {
    pub(super) fn cuboid([x, y, z]: Three<f64>) -> Self {
        let [a, b, c] = [y * z, x * z, x * y];
        Self {
            volume: x * y * z,
            front: [a, b, c],
            skin: [2.0 * (b + c), 2.0 * (a + c), 2.0 * (a + b)],
        }
    }

    pub(super) fn sphere(radius: f64) -> Self {
        let front = std::f64::consts::PI * radius * radius;
        Self {
            volume: 4.0 / 3.0 * front * radius,
            front: [front; 3],
            skin: [8.0 / 3.0 * front; 3],
        }
    }

    /// A cylinder about its z axis.
    pub(super) fn cylinder(radius: f64, height: f64) -> Self {
        let end = std::f64::consts::PI * radius * radius;
        let side = std::f64::consts::PI * radius * height;
        let across = 2.0 * end + side;
        Self {
            volume: end * height,
            front: [2.0 * radius * height, 2.0 * radius * height, end],
            skin: [across, across, 2.0 * side],
        }
    }
}

/// Volume of a `geometry` element \[m^3\]; `None` for a mesh.
fn volume(geometry: Node<'_, '_>) -> Result<Option<f64>, ReadError> {
    let size = |it: Node<'_, '_>| -> Result<Option<f64>, ReadError> {
        let text = child(it, "size")
            .and_then(|it| it.text())
            .or(it.attribute("size"));
        let size = text.map(|text| numbers("size", text, &[3])).transpose()?;
        Ok(size.map(|all| Shape::cuboid(three(&all)).volume))
    };
    if let Some(it) = child(geometry, "box") {
        return size(it);
    }
    if let Some(it) = child(geometry, "sphere") {
        return Ok(number(it, "radius")?.map(|r| Shape::sphere(r).volume));
    }
    if let Some(it) = child(geometry, "cylinder") {
        let sizes = number(it, "radius")?.zip(number(it, "length")?);
        return Ok(sizes.map(|(r, l)| Shape::cylinder(r, l).volume));
    }
    Ok(None)
}

/// Reads mass, inertia and centre of gravity of a link of SDF or URDF, whose axes are forward, port and up.
pub(super) fn read_inertial(link: Node<'_, '_>, into: &mut ModelNumbers) -> Result<(), ReadError> {
    let Some(inertial) = child(link, "inertial") else {
        return Ok(());
    };
    let is_sdf = child(inertial, "pose").is_some();
    let (place, r) = pose(inertial, if is_sdf { "pose" } else { "origin" })?;
    into.centre_of_gravity = flipped(place);
    if let Some(mass) = number(inertial, "mass")? {
        into.put(Place::Mass, "mass".to_owned(), mass, 1.0);
    }
    if let Some(it) = child(inertial, "inertia") {
        let of = |name| Ok(number(it, name)?.unwrap_or(0.0));
        let (xy, xz, yz) = (of("ixy")?, of("ixz")?, of("iyz")?);
        let tensor = [
            [of("ixx")?, xy, xz],
            [xy, of("iyy")?, yz],
            [xz, yz, of("izz")?],
        ];
        into.inertia = Some(flipped_inertia(rotated(&r, &tensor)));
    }
    Ok(())
}

/// Reads volume and centre of buoyancy from a link's collision shapes, as Gazebo's buoyancy system does.
pub(super) fn read_collisions(
    link: Node<'_, '_>,
    density: f64,
    into: &mut ModelNumbers,
) -> Result<(), ReadError> {
    let (mut total, mut moment) = (0.0, [0.0; 3]);
    for it in link
        .children()
        .filter(|it| it.tag_name().name() == "collision")
    {
        let Some(volume) = child(it, "geometry").map(volume).transpose()?.flatten() else {
            into.ignored.push(
                "a collision that is not a box, cylinder or sphere: volume unknown".to_owned(),
            );
            return Ok(());
        };
        let is_sdf = child(it, "pose").is_some();
        let (place, _) = pose(it, if is_sdf { "pose" } else { "origin" })?;
        total += volume;
        (0..3).for_each(|i| moment[i] += volume * place[i]);
    }
    if total > 0.0 {
        into.displaced = Some(density * total);
        into.centre_of_buoyancy = Some(flipped(moment.map(|x| x / total)));
    }
    Ok(())
}
