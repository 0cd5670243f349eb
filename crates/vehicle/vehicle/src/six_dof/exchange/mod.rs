//! Vehicles in the files of other simulators: export, reading, and checks of what was read.
//!
//! - [`export()`]: a vehicle as a block for Gazebo, Stonefish or DAVE, with the list of what the block cannot express.
//! - [`read()`]: such a block as [`ModelNumbers`], in the signs and axes of this crate.
//! - [`findings`]: which of these numbers are not physical.
//!
//! Each format's module names the source and version that fix its signs. The simulators themselves are not run.

mod check;
mod dave;
mod gazebo;
mod numbers;
mod stonefish;
mod xml;

pub use check::{Finding, Group, Named, findings};
pub use numbers::{Entry, Format, ModelNumbers, Place, ReadError};

use std::borrow::Cow;

use super::vehicle::Vehicle;

/// A block for another simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// The XML.
    pub text: String,
    /// The parts of the vehicle that the format cannot express; the block's first comment lists them too.
    pub omitted: Vec<String>,
}

/// Writes the vehicle for another simulator, in water of a density \[kg/m^3\]; `None` for [`Format::Planesman`].
///
/// The displaced mass is the mass times buoyancy over weight, so that any value of g leads to the same ratio of the two forces.
#[must_use]
pub fn export(vehicle: &Vehicle, format: Format, density: f64) -> Option<Export> {
    let numbers = ModelNumbers::of(vehicle);
    let parts = vehicle.parts();
    let mut omitted = Vec::new();
    if !parts.cross_flow.is_empty() {
        omitted.push("cross-flow drag".to_owned());
    }
    if !parts.fins.is_empty() {
        omitted.push(format!("{} fins", parts.fins.len()));
    }
    let (body, of_format) = match format {
        Format::Gazebo => gazebo::write(parts, &numbers, density),
        Format::Stonefish => stonefish::write(parts, &numbers, density),
        Format::Dave => dave::write(parts, &numbers, density),
        Format::Planesman => return None,
    };
    omitted.extend(of_format);
    let mut about = format!(
        "{} for {}, written by planesman in water of {density} kg/m^3.",
        parts.name,
        format.name()
    );
    for it in &omitted {
        about += &format!("\n     Not expressed: {it}");
    }
    let text = format!(
        "<?xml version=\"1.0\"?>\n<!-- {} -->\n{body}",
        about.replace("--", "- -")
    );
    Some(Export { text, omitted })
}

/// Reads the first vehicle of an XML text. `density` \[kg/m^3\] is used where the file gives none; its default is [`Format::density`].
///
/// # Errors
/// [`ReadError`].
pub fn read(text: &str, density: Option<f64>) -> Result<ModelNumbers, ReadError> {
    let text = declared(text);
    let document =
        roxmltree::Document::parse(&text).map_err(|e| ReadError::Syntax(e.to_string()))?;
    let root = document.root();
    let water = |format: Format| density.unwrap_or(format.density());
    if let Some(model) = xml::first(root, "hydrodynamic_model") {
        return dave::read(root, model, water(Format::Dave));
    }
    if let Some(read) = gazebo::read(root, water(Format::Gazebo)) {
        return read;
    }
    let body = xml::first(root, "base_link").or_else(|| xml::first(root, "dynamic"));
    body.map_or(Err(ReadError::Unknown), |body| {
        stonefish::read(root, body, water(Format::Stonefish))
    })
}

/// The text with a declaration of each undeclared namespace prefix in its first element: SDF has `gz:` without one.
fn declared(text: &str) -> Cow<'_, str> {
    let mut text = Cow::Borrowed(text);
    for _ in 0..MOST_PREFIXES {
        let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = roxmltree::Document::parse(&text)
        else {
            break;
        };
        let root = first_element(&text);
        let ends = |c: char| c.is_whitespace() || c == '>' || c == '/';
        let end = text[root..]
            .find(ends)
            .map_or(text.len(), |length| root + length);
        text.to_mut()
            .insert_str(end, &format!(" xmlns:{prefix}=\"{prefix}\""));
    }
    text
}

/// Position of the name of the first element, after comments and declarations.
fn first_element(text: &str) -> usize {
    let mut at = 0;
    while let Some(open) = text[at..].find('<') {
        at += open + 1;
        let end = match &text[at..] {
            rest if rest.starts_with("!--") => "-->",
            rest if rest.starts_with(['!', '?']) => ">",
            _ => return at,
        };
        at += text[at..].find(end).unwrap_or(0);
    }
    text.len()
}

/// Largest number of undeclared prefixes in a file.
const MOST_PREFIXES: usize = 8;
