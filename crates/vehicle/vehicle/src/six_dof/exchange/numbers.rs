//! The numbers of a vehicle in any format, in the signs and axes of this crate.

use super::super::coefficients::{Factor, Term};
use super::super::damping::Damping;
use super::super::inertia::{self, Matrix6};
use super::super::lanes::{Six, Three};
use super::super::vehicle::{Parts, Vehicle};

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

/// A number as written in the file.
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
    #[error("{entry}: '{text}' is not {expected}. Expand macros first (xacro FILE > vehicle.urdf)")]
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

/// Letters of the equations in names of coefficients.
pub(super) const ROWS: [char; 6] = ['X', 'Y', 'Z', 'K', 'M', 'N'];
pub(super) const VELOCITIES: [char; 6] = ['u', 'v', 'w', 'p', 'q', 'r'];

/// Signs between axes forward, starboard, keel and axes forward, port, up.
pub(super) const FLIP: Six<f64> = [1.0, -1.0, -1.0, 1.0, -1.0, -1.0];

/// A vector in the other axes.
pub(super) fn flipped(v: Three<f64>) -> Three<f64> {
    std::array::from_fn(|i| FLIP[i] * v[i])
}

/// A symmetric matrix in the other axes.
pub(super) fn flipped_inertia(a: [Three<f64>; 3]) -> [Three<f64>; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| FLIP[i] * FLIP[j] * a[i][j]))
}

/// Name of a coefficient, as in vehicle files.
pub(super) fn name(term: &Term, inputs: &[String]) -> String {
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
pub(super) fn is_zero(a: &Matrix6) -> bool {
    a.iter().flatten().all(|x| *x == 0.0)
}

impl ModelNumbers {
    /// Numbers of a format before anything is read.
    pub(super) fn empty(format: Format, name: &str) -> Self {
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
    pub(super) fn put(&mut self, place: Place, name: String, value: f64, factor: f64) {
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
    pub(super) fn value(&self, place: Place) -> f64 {
        match place {
            Place::Mass => self.mass.unwrap_or(0.0),
            Place::AddedMass(i, j) => self.added_mass.map_or(0.0, |a| a[i][j]),
            Place::Linear(i, j) => self.damping.linear[i][j],
            Place::Quadratic(i, j) => self.damping.quadratic[i][j],
            Place::Square(_) => 0.0,
        }
    }

    /// The number with its name in the file; a name like those of vehicle files if the file has none.
    pub(super) fn entry(&self, place: Place) -> Entry {
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
