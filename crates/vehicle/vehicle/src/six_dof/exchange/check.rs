//! Checks of a vehicle's numbers from any format: mass, inertia, damping, buoyancy.

use std::fmt;

use nalgebra::SMatrix;

use super::super::coefficients::Factor;
use super::super::inertia::{self, Matrix6, RigidBody};
use super::super::lanes::Three;
use super::{Entry, Format, ModelNumbers, Place, is_zero};

/// Sign that a number of a file must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Not negative.
    Positive,
    /// Not positive.
    Negative,
}

/// Order of a damping force in the velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Proportional to the velocity.
    Linear,
    /// Proportional to its square.
    Quadratic,
}

/// Something in the numbers that is not physical. Entries have their names and values from the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// The mass is not above 0.
    Mass {
        /// Its entry.
        entry: String,
        /// \[kg\]
        value: f64,
    },
    /// A principal moment is not above 0, or exceeds the sum of the other two.
    Inertia {
        /// Principal moments about the centre of gravity, in ascending order \[kg m^2\].
        moments: Three<f64>,
    },
    /// The inertia of body and water together is not positive definite.
    MassMatrix {
        /// Its smallest eigenvalue.
        smallest: f64,
    },
    /// A diagonal entry of the added mass has the wrong sign for its format.
    AddedMassSign {
        /// The entry.
        entry: String,
        /// Its value in the file.
        value: f64,
        /// Sign of this entry in a physical file.
        expected: Sign,
    },
    /// The added mass is not symmetric.
    AddedMassAsymmetric {
        /// Two mirrored entries.
        entries: [String; 2],
        /// Their values in the file.
        values: [f64; 2],
    },
    /// A diagonal entry of the damping accelerates the vehicle.
    DampingSign {
        /// Order of the force.
        order: Order,
        /// The entry.
        entry: String,
        /// Its value in the file.
        value: f64,
        /// Sign of this entry in a physical file.
        expected: Sign,
    },
    /// Two mirrored entries of the damping feed energy in some combination of their velocities.
    DampingCoupling {
        /// Order of the force.
        order: Order,
        /// The entries.
        entries: [String; 2],
        /// Their values in the file.
        values: [f64; 2],
        /// The two diagonal entries, in this crate's sign.
        diagonal: [f64; 2],
    },
    /// A force per square of a velocity without absolute value is larger than the drag: it accelerates one direction of motion.
    SquareWithoutSign {
        /// The entry.
        entry: String,
        /// Its value in the file.
        value: f64,
        /// Largest magnitude: the quadratic damping of the same degree.
        limit: f64,
    },
    /// Two entries contain the added mass, and the simulator uses both.
    AddedMassTwice {
        /// The entries.
        entries: [&'static str; 2],
    },
    /// The mass is so much above the displaced mass that it probably contains the added mass, which the file also gives.
    MassWithAddedMass {
        /// Entry of the mass.
        entry: String,
        /// \[kg\]
        mass: f64,
        /// Volume times density \[kg\].
        displaced: f64,
    },
    /// Mass and displaced mass differ by more than a tenth.
    Buoyancy {
        /// Entry of the mass.
        entry: String,
        /// \[kg\]
        mass: f64,
        /// Volume times density \[kg\].
        displaced: f64,
    },
    /// The centre of gravity is above the centre of buoyancy.
    MetacentricHeight {
        /// Height of the centre of buoyancy above the centre of gravity \[m\], negative here.
        height: f64,
    },
    /// A degree of freedom without damping of its own.
    NoDamping {
        /// Index of the degree, from 0 for surge.
        degree: usize,
    },
}

/// Names of the degrees of freedom.
const DEGREES: [&str; 6] = ["surge", "sway", "heave", "roll", "pitch", "yaw"];

/// Largest difference of mass and displaced mass, relative to the displaced mass.
const BUOYANCY: f64 = 0.1;

/// Mass over displaced mass from which on the mass probably contains the added mass.
const WITH_ADDED_MASS: f64 = 1.3;

/// Relative size of rounding errors.
const ROUNDING: f64 = 1e-9;

/// What is not physical in the numbers, worst first.
#[must_use]
pub fn findings(numbers: &ModelNumbers) -> Vec<Finding> {
    let mut all = Vec::new();
    check_mass(numbers, &mut all);
    for order in [Order::Linear, Order::Quadratic] {
        check_damping(numbers, order, &mut all);
    }
    check_squares(numbers, &mut all);
    check_buoyancy(numbers, &mut all);
    let bare = |i: &usize| {
        let of = |place| numbers.value(place) == 0.0;
        of(Place::Linear(*i, *i)) && of(Place::Quadratic(*i, *i)) && !numbers.damped_by_shape[*i]
    };
    all.extend(
        (0..6)
            .filter(bare)
            .map(|degree| Finding::NoDamping { degree }),
    );
    all
}

impl ModelNumbers {
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

/// The sign that makes the number positive in this crate.
fn expected(entry: &Entry) -> Sign {
    match entry.factor < 0.0 {
        true => Sign::Negative,
        false => Sign::Positive,
    }
}

fn least_eigenvalue(a: &Matrix6) -> f64 {
    let of = |i: usize, j: usize| 0.5 * (a[i][j] + a[j][i]);
    SMatrix::<f64, 6, 6>::from_fn(of)
        .symmetric_eigenvalues()
        .min()
}

fn norm(a: &Matrix6) -> f64 {
    a.iter().flatten().map(|x| x.abs()).fold(0.0, f64::max)
}

/// Pairs of indices above the diagonal.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j)))
}

fn check_mass(numbers: &ModelNumbers, all: &mut Vec<Finding>) {
    if let Some(value) = numbers.mass.filter(|mass| *mass <= 0.0) {
        let entry = numbers.entry(Place::Mass).name;
        all.push(Finding::Mass { entry, value });
    }
    let is_possible = numbers.inertia.is_none_or(|inertia| {
        let matrix = nalgebra::Matrix3::from_fn(|i, j| inertia[i][j]);
        let mut moments: Three<f64> = matrix.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        let [a, b, c] = moments;
        let is_possible = a > 0.0 && c <= (a + b) * (1.0 + 1e-6);
        if !is_possible {
            all.push(Finding::Inertia { moments });
        }
        is_possible
    });
    let Some(added) = numbers.added_mass else {
        return;
    };
    let negative: Vec<usize> = (0..6).filter(|i| added[*i][*i] < 0.0).collect();
    for i in &negative {
        let entry = numbers.entry(Place::AddedMass(*i, *i));
        all.push(Finding::AddedMassSign {
            expected: expected(&entry),
            entry: entry.name,
            value: entry.value,
        });
    }
    for (i, j) in pairs() {
        if (added[i][j] - added[j][i]).abs() > ROUNDING * norm(&added) {
            let both = [Place::AddedMass(i, j), Place::AddedMass(j, i)].map(|it| numbers.entry(it));
            all.push(Finding::AddedMassAsymmetric {
                values: [both[0].value, both[1].value],
                entries: both.map(|it| it.name),
            });
        }
    }
    // Of the body alone, if the water's part has a wrong sign: that is said already.
    if let (Some(mass), Some(inertia), true) = (
        numbers.mass.filter(|mass| *mass > 0.0),
        numbers.inertia.filter(|_| is_possible),
        negative.is_empty(),
    ) {
        let at = numbers.centre_of_gravity;
        let body = RigidBody {
            mass,
            centre_of_gravity: at,
            inertia: inertia::about_origin(inertia, mass, at),
        };
        let smallest = least_eigenvalue(&inertia::added(&body.matrix(), &added));
        if smallest <= 0.0 {
            all.push(Finding::MassMatrix { smallest });
        }
    }
    if let Some(entries) = numbers.added_mass_twice {
        all.push(Finding::AddedMassTwice { entries });
    }
}

fn check_damping(numbers: &ModelNumbers, order: Order, all: &mut Vec<Finding>) {
    let (matrix, place): (_, fn(usize, usize) -> Place) = match order {
        Order::Linear => (&numbers.damping.linear, Place::Linear),
        Order::Quadratic => (&numbers.damping.quadratic, Place::Quadratic),
    };
    let before = all.len();
    for i in 0..6 {
        let entry = numbers.entry(place(i, i));
        // Stonefish's coefficients of a mesh have no area here, but a sign.
        let is_ignored = numbers.format == Format::Stonefish && entry.value < 0.0;
        if matrix[i][i] < 0.0 || is_ignored {
            all.push(Finding::DampingSign {
                order,
                expected: expected(&entry),
                entry: entry.name,
                value: entry.value,
            });
        }
    }
    let feeds = |(i, j): &(usize, usize)| match order {
        Order::Linear => {
            let mean = 0.5 * (matrix[*i][*j] + matrix[*j][*i]);
            mean * mean > matrix[*i][*i] * matrix[*j][*j] + ROUNDING * norm(matrix) * norm(matrix)
        }
        Order::Quadratic => feeds_energy(matrix, *i, *j),
    };
    let mut coupling = |(i, j): (usize, usize)| {
        let both = [place(i, j), place(j, i)].map(|it| numbers.entry(it));
        all.push(Finding::DampingCoupling {
            order,
            values: [both[0].value, both[1].value],
            entries: both.map(|it| it.name),
            diagonal: [matrix[i][i], matrix[j][j]],
        });
    };
    let of_pairs: Vec<_> = pairs().filter(feeds).collect();
    let is_definite =
        order == Order::Quadratic || least_eigenvalue(matrix) >= -ROUNDING * norm(matrix);
    match of_pairs.is_empty() && !is_definite {
        // Three or more velocities together: the strongest pair is named.
        true => {
            let strength = |(i, j): &(usize, usize)| {
                let mean = 0.5 * (matrix[*i][*j] + matrix[*j][*i]);
                mean * mean / (matrix[*i][*i] * matrix[*j][*j]).max(f64::MIN_POSITIVE)
            };
            let strongest = pairs().max_by(|a, b| strength(a).total_cmp(&strength(b)));
            strongest.into_iter().for_each(&mut coupling);
        }
        false => of_pairs.into_iter().for_each(&mut coupling),
    }
    // A negative diagonal entry explains its couplings.
    if matches!(all.get(before), Some(Finding::DampingSign { .. })) {
        all.retain(|it| !matches!(it, Finding::DampingCoupling { order: of, .. } if *of == order));
    }
}

/// Whether `nu_i Q_ij |nu_j| nu_j`, summed over two velocities, is negative for some of them: with their ratio `t > 0` and their relative
/// sign `s`, the power is `Q_ii t^3 + s Q_ji t^2 + s Q_ij t + Q_jj`.
fn feeds_energy(q: &Matrix6, i: usize, j: usize) -> bool {
    let (a, d) = (q[i][i], q[j][j]);
    if q[i][j] == 0.0 && q[j][i] == 0.0 {
        return false;
    }
    [1.0, -1.0].into_iter().any(|s| {
        let (b, c) = (s * q[j][i], s * q[i][j]);
        let power = |t: f64| ((a * t + b) * t + c) * t + d;
        let size = |t: f64| ((a.abs() * t + b.abs()) * t + c.abs()) * t + d.abs();
        // Where the derivative 3 a t^2 + 2 b t + c is 0, and far out.
        let root = (b * b - 3.0 * a * c).max(0.0).sqrt();
        let at = [
            (root - b) / (3.0 * a),
            -(root + b) / (3.0 * a),
            -c / (2.0 * b),
            1e-6,
            1e6,
        ];
        let positive = at.into_iter().filter(|t| *t > 0.0 && t.is_finite());
        positive.into_iter().any(|t| power(t) < -ROUNDING * size(t))
    })
}

fn check_squares(numbers: &ModelNumbers, all: &mut Vec<Finding>) {
    for term in &numbers.terms {
        let i = term.row;
        let limit = numbers.damping.quadratic[i][i];
        if term.of == Factor::Velocities(i, i) && term.value.abs() > limit {
            let entry = numbers.entry(Place::Square(i));
            let is_of_file = numbers.entries.iter().any(|it| it.place == entry.place);
            let (name, value) = match is_of_file {
                true => (entry.name, entry.value),
                false => (super::name(term, &[]), term.value),
            };
            all.push(Finding::SquareWithoutSign {
                entry: name,
                value,
                limit,
            });
        }
    }
}

fn check_buoyancy(numbers: &ModelNumbers, all: &mut Vec<Finding>) {
    if let (Some(mass), Some(displaced)) = (numbers.mass, numbers.displaced) {
        let entry = numbers.entry(Place::Mass).name;
        let has_added = numbers.added_mass.is_some_and(|added| !is_zero(&added));
        if has_added && mass > WITH_ADDED_MASS * displaced {
            all.push(Finding::MassWithAddedMass {
                entry,
                mass,
                displaced,
            });
        } else if (mass - displaced).abs() > BUOYANCY * displaced {
            all.push(Finding::Buoyancy {
                entry,
                mass,
                displaced,
            });
        }
    }
    if let Some(buoyancy) = numbers
        .centre_of_buoyancy
        .filter(|_| numbers.mass.is_some())
    {
        let height = numbers.centre_of_gravity[2] - buoyancy[2];
        if height < -ROUNDING {
            all.push(Finding::MetacentricHeight { height });
        }
    }
}

impl Finding {
    /// Name of the kind of finding.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Mass { .. } => "mass",
            Self::Inertia { .. } => "inertia",
            Self::MassMatrix { .. } => "mass_matrix",
            Self::AddedMassSign { .. } => "added_mass_sign",
            Self::AddedMassAsymmetric { .. } => "added_mass_asymmetric",
            Self::DampingSign { .. } => "damping_sign",
            Self::DampingCoupling { .. } => "damping_coupling",
            Self::SquareWithoutSign { .. } => "square_without_sign",
            Self::AddedMassTwice { .. } => "added_mass_twice",
            Self::MassWithAddedMass { .. } => "mass_with_added_mass",
            Self::Buoyancy { .. } => "buoyancy",
            Self::MetacentricHeight { .. } => "metacentric_height",
            Self::NoDamping { .. } => "no_damping",
        }
    }
}

impl fmt::Display for Sign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Positive => "0 or positive",
            Self::Negative => "0 or negative",
        })
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
        })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mass { entry, value } => {
                write!(f, "{entry} is {value} kg: it must be above 0")
            }
            Self::Inertia { moments: [a, b, c] } => write!(
                f,
                "inertia has the principal moments {a:.4}, {b:.4}, {c:.4} kg m^2: each must be above 0 and at most the sum of the others"
            ),
            Self::MassMatrix { smallest } => write!(
                f,
                "mass, inertia and added mass together have the eigenvalue {smallest:.3e}: all must be above 0"
            ),
            Self::AddedMassSign {
                entry,
                value,
                expected,
            } => write!(
                f,
                "{entry} is {value}: added mass must be {expected} here, or the water pushes an accelerating vehicle"
            ),
            Self::AddedMassAsymmetric {
                entries: [a, b],
                values: [x, y],
            } => write!(
                f,
                "{a} is {x}, but {b} is {y}: added mass must be symmetric"
            ),
            Self::DampingSign {
                order,
                entry,
                value,
                expected,
            } => write!(
                f,
                "{entry} is {value}: {order} damping must be {expected} here, or it feeds energy"
            ),
            Self::DampingCoupling {
                order,
                entries: [a, b],
                values: [x, y],
                diagonal: [d, e],
            } => write!(
                f,
                "{a} {x} and {b} {y} feed energy: {order} coupling is too large for the damping {d} and {e} of its two velocities"
            ),
            Self::SquareWithoutSign {
                entry,
                value,
                limit,
            } => write!(
                f,
                "{entry} is {value}, without an absolute value: it feeds energy in one direction of motion; at most {limit} is allowed, the quadratic damping"
            ),
            Self::AddedMassTwice { entries: [a, b] } => write!(
                f,
                "{a} and {b} both contain the added mass, and it acts twice: keep one of them"
            ),
            Self::MassWithAddedMass {
                entry,
                mass,
                displaced,
            } => write!(
                f,
                "{entry} is {mass} kg, {:.2} times the displaced {displaced:.4} kg: it probably contains the added mass, which acts twice; use the mass of the vehicle with its enclosed water",
                mass / displaced
            ),
            Self::Buoyancy {
                entry,
                mass,
                displaced,
            } => write!(
                f,
                "{entry} is {mass} kg, but volume times density {displaced:.4} kg: they should differ by at most 10 %; is the mass dry and the volume with water inside, or the reverse?"
            ),
            Self::MetacentricHeight { height } => write!(
                f,
                "the centre of gravity is {:.4} m above the centre of buoyancy: the vehicle capsizes",
                -height
            ),
            Self::NoDamping { degree } => write!(
                f,
                "{} has neither linear nor quadratic damping of its own: a motion in it does not decay",
                DEGREES[*degree]
            ),
        }
    }
}
