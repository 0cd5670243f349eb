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
mod stonefish;
mod xml;

pub use check::{Finding, Group, Named, findings};

use std::borrow::Cow;

use super::coefficients::{Factor, Term};
use super::damping::Damping;
use super::inertia::{self, Matrix6};
use super::lanes::{Six, Three};
use super::vehicle::{Parts, Vehicle};

/// A file format with a vehicle's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// SDF for gz-sim: hydrodynamics and thruster systems.
    Gazebo,
    /// Stonefish's XML.
    Stonefish,
    /// URDF for DAVE on Gazebo Classic: the plugins of the UUV simulator.
    Dave,
    /// This project's vehicle files.
    Planesman,
}

impl Format {
    /// Name of the simulator.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gazebo => "Gazebo",
            Self::Stonefish => "Stonefish",
            Self::Dave => "DAVE",
            Self::Planesman => "planesman",
        }
    }

    /// Density of the water \[kg/m^3\] where a file gives none: the simulator's default.
    #[must_use]
    pub fn density(self) -> f64 {
        match self {
            Self::Dave => 1028.0,
            Self::Gazebo | Self::Stonefish | Self::Planesman => 1000.0,
        }
    }
}

/// Place of a number in the equations; indices from 0, in the order X, Y, Z, K, M, N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Mass.
    Mass,
    /// Entry of `M_A`.
    AddedMass(usize, usize),
    /// Entry of the linear damping matrix.
    Linear(usize, usize),
    /// Entry of the quadratic damping matrix.
    Quadratic(usize, usize),
    /// Coefficient of `nu_i^2` in equation `i`, without an absolute value.
    Square(usize),
}

/// A number as the file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its place in the equations.
    pub place: Place,
    /// Its name in the file.
    pub name: String,
    /// Its value in the file.
    pub value: f64,
    /// Factor from the file's value to this crate's: sign and axes.
    pub factor: f64,
}

/// Numbers of a vehicle from any format: SI, axes forward, starboard, keel, signs of [`Parts`].
#[derive(Clone, Debug, PartialEq)]
pub struct ModelNumbers {
    /// Format of the file.
    pub format: Format,
    /// Name of the vehicle or of its body.
    pub name: String,
    /// \[kg\]; `None` if the file does not give it.
    pub mass: Option<f64>,
    /// From the origin \[m\].
    pub centre_of_gravity: Three<f64>,
    /// About the centre of gravity \[kg m^2\].
    pub inertia: Option<[Three<f64>; 3]>,
    /// Volume times density \[kg\]; `None` if the volume is unknown.
    pub displaced: Option<f64>,
    /// From the origin \[m\].
    pub centre_of_buoyancy: Option<Three<f64>>,
    /// `M_A`; `None` where the simulator computes it from the shape.
    pub added_mass: Option<Matrix6>,
    /// Damping matrices.
    pub damping: Damping,
    /// Other coefficients.
    pub terms: Vec<Term>,
    /// Degrees of freedom with a damping that is computed from the shape.
    pub damped_by_shape: [bool; 6],
    /// The numbers with their names in the file.
    pub entries: Vec<Entry>,
    /// Entries that the simulator does not use, or that this reader cannot use.
    pub ignored: Vec<String>,
    /// Two entries that each contain the added mass.
    pub added_mass_twice: Option<[&'static str; 2]>,
}

/// Reason why a file is not read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// The text is not XML.
    #[error("invalid XML: {0}")]
    Syntax(String),
    /// The file has no vehicle in a known format.
    #[error(
        "no vehicle found: neither Gazebo's hydrodynamics plugin or fluid_added_mass, nor DAVE's hydrodynamic_model, nor Stonefish's base_link or dynamic"
    )]
    Unknown,
    /// A value is not a list of finite numbers of the required length.
    #[error("{entry}: '{text}' is not {expected}; expand macros first (xacro FILE > vehicle.urdf)")]
    Number {
        /// Entry of the file.
        entry: String,
        /// Its text.
        text: String,
        /// What is accepted.
        expected: String,
    },
    /// A kind of body that this reader does not know.
    #[error("{entry}: '{text}' is not supported: {accepted} are read")]
    Unsupported {
        /// Entry of the file.
        entry: String,
        /// Its text.
        text: String,
        /// What is accepted.
        accepted: &'static str,
    },
}

/// A block for another simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// The XML.
    pub text: String,
    /// What the format cannot express; also in the block's first comment.
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

/// Letters of the equations in names of coefficients.
const ROWS: [char; 6] = ['X', 'Y', 'Z', 'K', 'M', 'N'];
const VELOCITIES: [char; 6] = ['u', 'v', 'w', 'p', 'q', 'r'];

/// Signs between axes forward, starboard, keel and axes forward, port, up.
const FLIP: Six<f64> = [1.0, -1.0, -1.0, 1.0, -1.0, -1.0];

/// A vector in the other axes.
fn flipped(v: Three<f64>) -> Three<f64> {
    std::array::from_fn(|i| FLIP[i] * v[i])
}

/// A symmetric matrix in the other axes.
fn flipped_inertia(a: [Three<f64>; 3]) -> [Three<f64>; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| FLIP[i] * FLIP[j] * a[i][j]))
}

/// Name of a coefficient, as in vehicle files.
fn name(term: &Term, inputs: &[String]) -> String {
    let row = ROWS[term.row];
    let of = |i: usize| VELOCITIES[i];
    match term.of {
        Factor::Velocities(i, j) => format!("{row}_{}{}", of(i), of(j)),
        Factor::Drag(i, j) => format!("{row}_{}|{}|", of(i), of(j)),
        Factor::Velocity(i) => format!("{row}_{}", of(i)),
        Factor::Acceleration(i) => format!("{row}_{}dot", of(i)),
        Factor::Input(k) => format!("{row}_uu {}", inputs[k]),
    }
}

/// The matrix is zero.
fn is_zero(a: &Matrix6) -> bool {
    a.iter().flatten().all(|x| *x == 0.0)
}

impl ModelNumbers {
    /// Numbers of a format before anything is read.
    fn empty(format: Format, name: &str) -> Self {
        Self {
            format,
            name: name.to_owned(),
            mass: None,
            centre_of_gravity: [0.0; 3],
            inertia: None,
            displaced: None,
            centre_of_buoyancy: None,
            added_mass: None,
            damping: Damping::default(),
            terms: Vec::new(),
            damped_by_shape: [false; 6],
            entries: Vec::new(),
            ignored: Vec::new(),
            added_mass_twice: None,
        }
    }

    /// Numbers of a vehicle of this crate. Coefficients in one velocity are moved into the damping matrices.
    #[must_use]
    pub fn of(vehicle: &Vehicle) -> Self {
        let parts: &Parts = vehicle.parts();
        let mut damping = parts.damping.clone();
        let mut terms = Vec::new();
        for term in &parts.terms {
            match term.of {
                Factor::Velocity(j) => damping.linear[term.row][j] -= term.value,
                Factor::Drag(j, k) if j == k => damping.quadratic[term.row][j] -= term.value,
                _ => terms.push(*term),
            }
        }
        let body = &parts.body;
        let across = !parts.cross_flow.is_empty();
        Self {
            mass: Some(body.mass),
            centre_of_gravity: body.centre_of_gravity,
            inertia: Some(inertia::about_origin(
                body.inertia,
                -body.mass,
                body.centre_of_gravity,
            )),
            displaced: Some(body.mass * parts.buoyancy / parts.weight),
            centre_of_buoyancy: Some(parts.centre_of_buoyancy),
            added_mass: Some(parts.added_mass),
            damping,
            terms,
            damped_by_shape: [false, across, across, false, across, across],
            ..Self::empty(Format::Planesman, &parts.name)
        }
    }

    /// Adds a number of the file to the matrix at its place.
    fn put(&mut self, place: Place, name: String, value: f64, factor: f64) {
        let ours = factor * value;
        match place {
            Place::AddedMass(i, j) => self.added_mass.get_or_insert_default()[i][j] += ours,
            Place::Linear(i, j) => self.damping.linear[i][j] += ours,
            Place::Quadratic(i, j) => self.damping.quadratic[i][j] += ours,
            Place::Mass => self.mass = Some(ours),
            Place::Square(_) => {}
        }
        self.entries.push(Entry {
            place,
            name,
            value,
            factor,
        });
    }

    /// Value at a place, in this crate's sign.
    fn value(&self, place: Place) -> f64 {
        match place {
            Place::Mass => self.mass.unwrap_or(0.0),
            Place::AddedMass(i, j) => self.added_mass.map_or(0.0, |a| a[i][j]),
            Place::Linear(i, j) => self.damping.linear[i][j],
            Place::Quadratic(i, j) => self.damping.quadratic[i][j],
            Place::Square(_) => 0.0,
        }
    }

    /// The number with its name in the file; a name like those of vehicle files if the file has none.
    fn entry(&self, place: Place) -> Entry {
        let of_file = self.entries.iter().filter(|it| it.place == place);
        // Of two entries at one place the nonzero one.
        let chosen = of_file.clone().find(|it| it.value != 0.0);
        if let Some(entry) = chosen.or(of_file.clone().next()) {
            return entry.clone();
        }
        let indexed = |group, i: usize, j: usize| format!("{group}_{}{}", i + 1, j + 1);
        let name = match place {
            Place::Mass => "mass".to_owned(),
            Place::AddedMass(i, j) => indexed("added_mass", i, j),
            Place::Linear(i, j) => indexed("linear_damping", i, j),
            Place::Quadratic(i, j) => indexed("quadratic_damping", i, j),
            Place::Square(i) => indexed("square", i, i),
        };
        Entry {
            place,
            name,
            value: self.value(place),
            factor: 1.0,
        }
    }
}
