//! Checks of a vehicle's numbers from any format: mass, inertia, damping, buoyancy.

use std::fmt;

use nalgebra::SMatrix;

use super::super::coefficients::Factor;
use super::super::inertia::{self, Matrix6, RigidBody};
use super::super::lanes::Three;
use super::numbers::{Entry, Format, ModelNumbers, Place, is_zero, name};

/// Group of numbers that a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// `M_A`.
    AddedMass,
    /// Damping proportional to the velocity.
    Linear,
    /// Damping proportional to its square.
    Quadratic,
}

/// An entry with its name and value from the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Named(pub String, pub f64);

/// Something in the numbers that is not physical. Values are those of the file unless stated otherwise.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// The mass is not above 0.
    Mass(Named),
    /// A principal moment is not above 0, or exceeds the sum of the other two; in ascending order \[kg m^2\].
    Inertia(Three<f64>),
    /// The inertia of body and water together is not positive definite: its smallest eigenvalue.
    MassMatrix(f64),
    /// A diagonal entry has the wrong sign for its format; the number is the sign that it must have, or 0.
    Sign(Group, Named, f64),
    /// The added mass is not symmetric: two mirrored entries.
    Asymmetric([Named; 2]),
    /// Two mirrored entries of the damping feed energy for some velocities, with the two diagonal entries in this crate's sign.
    Coupling(Group, [Named; 2], [f64; 2]),
    /// A force per square of a velocity, without absolute value, is larger than the drag: it accelerates one direction of motion. With the
    /// largest magnitude allowed.
    Square(Named, f64),
    /// Two entries contain the added mass, and the simulator uses both.
    AddedMassTwice([&'static str; 2]),
    /// The mass is so much above the displaced mass \[kg\] that it probably contains the added mass, which the file also gives.
    MassWithAddedMass(Named, f64),
    /// Mass and displaced mass \[kg\] differ by more than a tenth.
    Buoyancy(Named, f64),
    /// Height of the centre of buoyancy above the centre of gravity \[m\]; it is negative.
    MetacentricHeight(f64),
    /// Index of a degree of freedom without damping of its own.
    NoDamping(usize),
}

/// Names of the degrees of freedom.
const DEGREES: [&str; 6] = ["surge", "sway", "heave", "roll", "pitch", "yaw"];

/// Largest difference of mass and displaced mass, relative to the displaced mass.
const BUOYANCY: f64 = 0.1;

/// Mass over displaced mass from which on the mass probably contains the added mass.
const WITH_ADDED_MASS: f64 = 1.3;

/// Relative size of rounding errors of printed tables.
const PRINTING: f64 = 1e-3;

/// Relative size of rounding errors.
const ROUNDING: f64 = 1e-9;

/// Violations of physical laws in the numbers, worst first.
#[must_use]
pub fn findings(numbers: &ModelNumbers) -> Vec<Finding> {
    let mut all = Vec::new();
    check_mass(numbers, &mut all);
    for group in [Group::Linear, Group::Quadratic] {
        check_damping(numbers, group, &mut all);
    }
    check_squares(numbers, &mut all);
    check_buoyancy(numbers, &mut all);
    let bare = |i: &usize| {
        let of = |place| numbers.value(place) == 0.0;
        of(Place::Linear(*i, *i)) && of(Place::Quadratic(*i, *i)) && !numbers.damped_by_shape[*i]
    };
    all.extend((0..6).filter(bare).map(Finding::NoDamping));
    all
}

impl From<Entry> for Named {
    fn from(entry: Entry) -> Self {
        Self(entry.name, entry.value)
    }
}

/// The finding that this diagonal entry has the wrong sign.
fn wrong_sign(group: Group, entry: Entry) -> Finding {
    let expected = entry.factor.signum();
    Finding::Sign(group, entry.into(), expected)
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
    if numbers.mass.is_some_and(|mass| mass <= 0.0) {
        all.push(Finding::Mass(numbers.entry(Place::Mass).into()));
    }
    let inertia = numbers.inertia.filter(|inertia| {
        let matrix = nalgebra::Matrix3::from_fn(|i, j| inertia[i][j]);
        let mut moments: Three<f64> = matrix.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        let [a, b, c] = moments;
        let is_possible = a > 0.0 && c <= (a + b) * (1.0 + 1e-6);
        if !is_possible {
            all.push(Finding::Inertia(moments));
        }
        is_possible
    });
    let Some(added) = numbers.added_mass else {
        return;
    };
    let negative: Vec<usize> = (0..6).filter(|i| added[*i][*i] < 0.0).collect();
    all.extend(negative.iter().map(|i| {
        let entry = numbers.entry(Place::AddedMass(*i, *i));
        wrong_sign(Group::AddedMass, entry)
    }));
    for (i, j) in pairs() {
        let (one, other) = (added[i][j], added[j][i]);
        let size = one.abs().max(other.abs());
        if (one - other).abs() > PRINTING * size + ROUNDING * norm(&added) {
            let both = [Place::AddedMass(i, j), Place::AddedMass(j, i)];
            all.push(Finding::Asymmetric(both.map(|it| numbers.entry(it).into())));
        }
    }
    // A wrong sign, mass or inertia explains a matrix that is not definite.
    let mass = numbers
        .mass
        .filter(|mass| *mass > 0.0 && negative.is_empty());
    if let Some((mass, inertia)) = mass.zip(inertia) {
        let at = numbers.centre_of_gravity;
        let body = RigidBody {
            mass,
            centre_of_gravity: at,
            inertia: inertia::about_origin(inertia, mass, at),
        };
        let smallest = least_eigenvalue(&inertia::added(&body.matrix(), &added));
        if smallest <= 0.0 {
            all.push(Finding::MassMatrix(smallest));
        }
    }
    all.extend(numbers.added_mass_twice.map(Finding::AddedMassTwice));
}

fn check_damping(numbers: &ModelNumbers, group: Group, all: &mut Vec<Finding>) {
    let (matrix, place): (_, fn(usize, usize) -> Place) = match group {
        Group::Quadratic => (&numbers.damping.quadratic, Place::Quadratic),
        _ => (&numbers.damping.linear, Place::Linear),
    };
    let before = all.len();
    for (i, row) in matrix.iter().enumerate() {
        let entry = numbers.entry(place(i, i));
        // Stonefish's coefficients of a mesh have no area here, but a sign.
        let is_ignored = numbers.format == Format::Stonefish && entry.value < 0.0;
        if row[i] < 0.0 || is_ignored {
            all.push(wrong_sign(group, entry));
        }
    }
    // A wrong sign explains the couplings.
    if all.len() > before {
        return;
    }
    let mean = |i: usize, j: usize| 0.5 * (matrix[i][j] + matrix[j][i]);
    let excess = |(i, j): (usize, usize)| {
        let product = matrix[i][i] * matrix[j][j];
        mean(i, j) * mean(i, j) - product - ROUNDING * norm(matrix) * norm(matrix)
    };
    let mut feeding: Vec<_> = match group {
        Group::Quadratic => pairs()
            .filter(|(i, j)| feeds_energy(matrix, *i, *j))
            .collect(),
        _ => pairs().filter(|pair| excess(*pair) > 0.0).collect(),
    };
    let is_linear = group == Group::Linear;
    if is_linear && feeding.is_empty() && least_eigenvalue(matrix) < -ROUNDING * norm(matrix) {
        // Three or more velocities together: the strongest pair is named.
        feeding.extend(pairs().max_by(|a, b| excess(*a).total_cmp(&excess(*b))));
    }
    all.extend(feeding.into_iter().map(|(i, j)| {
        let both = [place(i, j), place(j, i)].map(|it| numbers.entry(it).into());
        Finding::Coupling(group, both, [matrix[i][i], matrix[j][j]])
    }));
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
            let of_file = numbers
                .entries
                .iter()
                .find(|it| it.place == Place::Square(i));
            let own = || Named(name(term, &[]), term.value);
            let named = of_file.cloned().map_or_else(own, Named::from);
            all.push(Finding::Square(named, limit));
        }
    }
}

fn check_buoyancy(numbers: &ModelNumbers, all: &mut Vec<Finding>) {
    let Some(mass) = numbers.mass else {
        return;
    };
    if let Some(displaced) = numbers.displaced {
        let named = Named::from(numbers.entry(Place::Mass));
        let has_added = numbers.added_mass.is_some_and(|added| !is_zero(&added));
        if has_added && mass > WITH_ADDED_MASS * displaced {
            all.push(Finding::MassWithAddedMass(named, displaced));
        } else if (mass - displaced).abs() > BUOYANCY * displaced {
            all.push(Finding::Buoyancy(named, displaced));
        }
    }
    let height = (numbers.centre_of_buoyancy).map(|at| numbers.centre_of_gravity[2] - at[2]);
    all.extend(
        height
            .filter(|it| *it < -ROUNDING)
            .map(Finding::MetacentricHeight),
    );
}

impl Finding {
    /// Name of the kind of finding.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Mass(_) => "mass",
            Self::Inertia(_) => "inertia",
            Self::MassMatrix(_) => "mass_matrix",
            Self::Sign(Group::AddedMass, ..) => "added_mass_sign",
            Self::Sign(..) => "damping_sign",
            Self::Asymmetric(_) => "added_mass_asymmetric",
            Self::Coupling(..) => "damping_coupling",
            Self::Square(..) => "square_without_sign",
            Self::AddedMassTwice(_) => "added_mass_twice",
            Self::MassWithAddedMass(..) => "mass_with_added_mass",
            Self::Buoyancy(..) => "buoyancy",
            Self::MetacentricHeight(_) => "metacentric_height",
            Self::NoDamping(_) => "no_damping",
        }
    }

    /// Entries of the file that the finding names.
    #[must_use]
    pub fn entries(&self) -> &[Named] {
        match self {
            Self::Mass(one)
            | Self::Sign(_, one, _)
            | Self::Square(one, _)
            | Self::MassWithAddedMass(one, _)
            | Self::Buoyancy(one, _) => std::slice::from_ref(one),
            Self::Asymmetric(both) | Self::Coupling(_, both, _) => both,
            _ => &[],
        }
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AddedMass => "added mass",
            Self::Linear => "linear damping",
            Self::Quadratic => "quadratic damping",
        })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mass(Named(name, value)) => write!(f, "{name} is {value} kg: it must be above 0"),
            Self::Inertia([a, b, c]) => write!(
                f,
                "inertia has the principal moments {a:.4}, {b:.4}, {c:.4} kg m^2: each must be above 0 and at most the sum of the others"
            ),
            Self::MassMatrix(smallest) => write!(
                f,
                "mass, inertia and added mass together have the eigenvalue {smallest:.3e}: all must be above 0"
            ),
            Self::Sign(group, Named(name, value), sign) => {
                let sign = if *sign < 0.0 { "negative" } else { "positive" };
                write!(
                    f,
                    "{name} is {value}: {group} must be 0 or {sign} in this entry, otherwise it feeds energy"
                )
            }
            Self::Asymmetric([Named(a, x), Named(b, y)]) => {
                write!(
                    f,
                    "{a} is {x}, but {b} is {y}: added mass must be symmetric"
                )
            }
            Self::Coupling(group, [Named(a, x), Named(b, y)], [c, d]) => write!(
                f,
                "{a} {x} and {b} {y} feed energy: {group} couples two velocities more than their own damping, {c} and {d}, allows"
            ),
            Self::Square(Named(name, value), limit) => write!(
                f,
                "{name} is {value}: it feeds energy in one direction of motion; at most the quadratic damping {limit} is allowed, or use the form with an absolute value"
            ),
            Self::AddedMassTwice([a, b]) => {
                write!(
                    f,
                    "{a} and {b} both contain the added mass, which then acts twice: keep one of them"
                )
            }
            Self::MassWithAddedMass(Named(name, mass), displaced) => write!(
                f,
                "{name} is {mass} kg, {:.2} times the displaced {displaced:.4} kg: it probably contains the added mass, which then acts twice; use the mass of the vehicle with its enclosed water",
                mass / displaced
            ),
            Self::Buoyancy(Named(name, mass), displaced) => write!(
                f,
                "{name} is {mass} kg, but volume times density is {displaced:.4} kg: they should differ by at most 10 %; count the enclosed water in both or in neither"
            ),
            Self::MetacentricHeight(height) => write!(
                f,
                "the centre of gravity is {:.4} m above the centre of buoyancy: it must be below, otherwise the vehicle capsizes",
                -height
            ),
            Self::NoDamping(degree) => write!(
                f,
                "{} has no linear and no quadratic damping: give it one of them, otherwise this motion never decays",
                DEGREES[*degree]
            ),
        }
    }
}
