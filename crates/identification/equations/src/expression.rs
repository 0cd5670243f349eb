//! Expressions from a file of equations, and their exact partial derivatives.
//!
//! ```text
//! + - * / ^ (or **), parentheses, numbers, names, pi
//! abs sign sqrt exp log sin cos tan asin acos atan sinh cosh tanh    of one expression
//! min max atan2                                                      of two
//! deadzone(x, lo, hi) = x - saturate(x, lo, hi),   saturate(x, lo, hi) = min(max(x, lo), hi)
//! ```
//! All expressions of a model are on one tape, each operation after its operands. The tape is evaluated once; the derivatives of one result with
//! respect to all variables are computed backwards (reverse mode; Griewank and Walther, *Evaluating Derivatives*, 2nd ed. 2008, ch. 3). At a corner
//! (for example of `abs` at 0) the derivative is one-sided.

/// Maximum nesting depth of parentheses and calls.
pub(crate) const DEPTH: usize = 64;
/// Maximum number of operations of a model.
const MOST_NODES: usize = 20_000;

/// The reason why a text is not a valid expression.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("character {place}: {reason}")]
pub struct ExpressionError {
    /// The character, from 1.
    pub place: usize,
    /// Why.
    pub reason: String,
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unary {
    Negative,
    Abs,
    Sign,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
}

/// A function of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Min,
    Max,
    Atan2,
}

const UNARY: [(&str, Unary); 14] = [
    ("abs", Unary::Abs),
    ("sign", Unary::Sign),
    ("sqrt", Unary::Sqrt),
    ("exp", Unary::Exp),
    ("log", Unary::Log),
    ("sin", Unary::Sin),
    ("cos", Unary::Cos),
    ("tan", Unary::Tan),
    ("asin", Unary::Asin),
    ("acos", Unary::Acos),
    ("atan", Unary::Atan),
    ("sinh", Unary::Sinh),
    ("cosh", Unary::Cosh),
    ("tanh", Unary::Tanh),
];
const BINARY: [(&str, Binary); 3] = [
    ("min", Binary::Min),
    ("max", Binary::Max),
    ("atan2", Binary::Atan2),
];
/// Functions of three arguments, built from functions of two.
const TERNARY: [&str; 2] = ["deadzone", "saturate"];

/// Whether a name is that of a function, or pi.
pub(crate) fn is_reserved(name: &str) -> bool {
    functions().any(|it| it == name) || name == "pi"
}

fn functions() -> impl Iterator<Item = &'static str> {
    let unary = UNARY.iter().map(|it| it.0);
    unary.chain(BINARY.iter().map(|it| it.0)).chain(TERNARY)
}

/// The sign, 0 at 0.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

impl Unary {
    fn value(self, x: f64) -> f64 {
        match self {
            Self::Negative => -x,
            Self::Abs => x.abs(),
            Self::Sign => sign(x),
            Self::Sqrt => x.sqrt(),
            Self::Exp => libm::exp(x),
            Self::Log => libm::log(x),
            Self::Sin => libm::sin(x),
            Self::Cos => libm::cos(x),
            Self::Tan => libm::tan(x),
            Self::Asin => libm::asin(x),
            Self::Acos => libm::acos(x),
            Self::Atan => libm::atan(x),
            Self::Sinh => libm::sinh(x),
            Self::Cosh => libm::cosh(x),
            Self::Tanh => libm::tanh(x),
        }
    }

    /// The derivative at `x`, where the function has the value `y`.
    fn slope(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Negative => -1.0,
            Self::Abs => sign(x),
            Self::Sign => 0.0,
            Self::Sqrt => 0.5 / y,
            Self::Exp => y,
            Self::Log => 1.0 / x,
            Self::Sin => libm::cos(x),
            Self::Cos => -libm::sin(x),
            Self::Tan => 1.0 + y * y,
            Self::Asin => 1.0 / (1.0 - x * x).sqrt(),
            Self::Acos => -1.0 / (1.0 - x * x).sqrt(),
            Self::Atan => 1.0 / (1.0 + x * x),
            Self::Sinh => libm::cosh(x),
            Self::Cosh => libm::sinh(x),
            Self::Tanh => 1.0 - y * y,
        }
    }
}

impl Binary {
    fn value(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => libm::pow(a, b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
            Self::Atan2 => libm::atan2(a, b),
        }
    }

    /// The derivatives with respect to both arguments, where the function has the value `y`.
    fn slopes(self, a: f64, b: f64, y: f64) -> (f64, f64) {
        match self {
            Self::Add => (1.0, 1.0),
            Self::Subtract => (1.0, -1.0),
            Self::Multiply => (b, a),
            Self::Divide => (1.0 / b, -y / b),
            Self::Power => {
                let by_base = if b == 0.0 {
                    0.0
                } else {
                    b * libm::pow(a, b - 1.0)
                };
                (by_base, if a > 0.0 { y * libm::log(a) } else { 0.0 })
            }
            Self::Min if a <= b => (1.0, 0.0),
            Self::Max if a >= b => (1.0, 0.0),
            Self::Min | Self::Max => (0.0, 1.0),
            Self::Atan2 => {
                let square = a * a + b * b;
                (b / square, -a / square)
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Node {
    Constant(f64),
    Variable(usize),
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
}

/// Expressions, each operation after its operands.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tape {
    nodes: Vec<Node>,
}

/// A result on a tape, and the nodes that it depends on.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    node: usize,
    /// The nodes that the result needs, last first.
    needed: Vec<usize>,
    /// The variables among the arguments.
    pub(crate) variables: Vec<usize>,
}

/// The values along a tape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbers {
    values: Vec<f64>,
    adjoints: Vec<f64>,
}

impl Tape {
    fn push(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    pub(crate) fn constant(&mut self, value: f64) -> usize {
        self.push(Node::Constant(value))
    }

    pub(crate) fn variable(&mut self, slot: usize) -> usize {
        self.push(Node::Variable(slot))
    }

    pub(crate) fn root(&self, node: usize) -> Root {
        let mut is_needed = vec![false; node + 1];
        is_needed[node] = true;
        for at in (0..=node).rev() {
            if is_needed[at] {
                match self.nodes[at] {
                    Node::Unary(_, a) => is_needed[a] = true,
                    Node::Binary(_, a, b) => (is_needed[a], is_needed[b]) = (true, true),
                    Node::Constant(_) | Node::Variable(_) => {}
                }
            }
        }
        let needed: Vec<usize> = (0..=node).rev().filter(|at| is_needed[*at]).collect();
        let variables = needed.iter().filter_map(|at| match self.nodes[*at] {
            Node::Variable(slot) => Some(slot),
            _ => None,
        });
        let mut variables: Vec<usize> = variables.collect();
        variables.sort_unstable();
        variables.dedup();
        Root {
            node,
            needed,
            variables,
        }
    }

    /// Computes all values.
    pub(crate) fn evaluate(&self, variables: &[f64], numbers: &mut Numbers) {
        let values = &mut numbers.values;
        values.clear();
        for node in &self.nodes {
            values.push(match *node {
                Node::Constant(value) => value,
                Node::Variable(slot) => variables[slot],
                Node::Unary(of, a) => of.value(values[a]),
                Node::Binary(of, a, b) => of.value(values[a], values[b]),
            });
        }
    }

    /// Adds the derivatives of a result with respect to the variables, after [`Tape::evaluate`].
    pub(crate) fn slopes(&self, root: &Root, numbers: &mut Numbers, slopes: &mut [f64]) {
        let Numbers { values, adjoints } = numbers;
        adjoints.resize(values.len(), 0.0);
        for at in &root.needed {
            adjoints[*at] = 0.0;
        }
        adjoints[root.node] = 1.0;
        for at in &root.needed {
            let adjoint = adjoints[*at];
            // 0 times an infinite slope, as of sqrt at 0, is no number and no effect.
            if adjoint == 0.0 {
                continue;
            }
            match self.nodes[*at] {
                Node::Constant(_) => {}
                Node::Variable(slot) => slopes[slot] += adjoint,
                Node::Unary(of, a) => adjoints[a] += adjoint * of.slope(values[a], values[*at]),
                Node::Binary(of, a, b) => {
                    let (by_a, by_b) = of.slopes(values[a], values[b], values[*at]);
                    adjoints[a] += adjoint * by_a;
                    adjoints[b] += adjoint * by_b;
                }
            }
        }
    }
}

impl Numbers {
    pub(crate) fn value(&self, root: &Root) -> f64 {
        self.values[root.node]
    }
}

/// Resolves names: returns the node of a name, added to the tape if new, or the reason why it is unknown.
pub(crate) trait Names {
    fn node(&mut self, tape: &mut Tape, name: &str, depth: usize) -> Result<usize, String>;
}

/// Adds an expression to a tape; `depth` is its nesting depth within others.
pub(crate) fn parse(
    text: &str,
    tape: &mut Tape,
    names: &mut dyn Names,
    depth: usize,
) -> Result<usize, ExpressionError> {
    let characters: Vec<char> = text.chars().collect();
    let mut parser = Parser {
        characters,
        at: 0,
        depth,
        tape,
        names,
    };
    let node = parser.sum()?;
    parser.blanks();
    match parser.peek() {
        None => Ok(node),
        Some(found) => parser.refuse(format!("an operator is expected, not '{}'", shown(found))),
    }
}

fn shown(character: char) -> String {
    character.escape_debug().to_string()
}

struct Parser<'a> {
    characters: Vec<char>,
    at: usize,
    depth: usize,
    tape: &'a mut Tape,
    names: &'a mut dyn Names,
}

type Parsed = Result<usize, ExpressionError>;

impl Parser<'_> {
    fn peek(&self) -> Option<char> {
        self.characters.get(self.at).copied()
    }

    fn blanks(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Consumes a text if it comes next, after blanks.
    fn take(&mut self, text: &str) -> bool {
        self.blanks();
        let stands = text
            .chars()
            .enumerate()
            .all(|(i, c)| self.characters.get(self.at + i) == Some(&c));
        if stands {
            self.at += text.chars().count();
        }
        stands
    }

    fn refuse_at<T>(&self, at: usize, reason: String) -> Result<T, ExpressionError> {
        Err(ExpressionError {
            place: at + 1,
            reason,
        })
    }

    fn refuse<T>(&self, reason: String) -> Result<T, ExpressionError> {
        self.refuse_at(self.at, reason)
    }

    fn push(&mut self, node: Node) -> Parsed {
        if self.tape.nodes.len() >= MOST_NODES {
            return self.refuse(format!(
                "the equations have more than {MOST_NODES} operations"
            ));
        }
        Ok(self.tape.push(node))
    }

    fn sum(&mut self) -> Parsed {
        let mut left = self.product()?;
        loop {
            let of = match () {
                () if self.take("+") => Binary::Add,
                () if self.take("-") => Binary::Subtract,
                () => return Ok(left),
            };
            let right = self.product()?;
            left = self.push(Node::Binary(of, left, right))?;
        }
    }

    fn product(&mut self) -> Parsed {
        let mut left = self.signed()?;
        loop {
            let of = match () {
                () if self.take("*") => Binary::Multiply,
                () if self.take("/") => Binary::Divide,
                () => return Ok(left),
            };
            let right = self.signed()?;
            left = self.push(Node::Binary(of, left, right))?;
        }
    }

    /// A power with or without a sign: `-x^2` is `-(x^2)`.
    fn signed(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > DEPTH {
            return self.refuse(format!(
                "expressions are nested more than {DEPTH} levels deep"
            ));
        }
        let found = match () {
            () if self.take("-") => {
                let of = self.signed()?;
                self.push(Node::Unary(Unary::Negative, of))
            }
            () if self.take("+") => self.signed(),
            () => self.power(),
        };
        self.depth -= 1;
        found
    }

    fn power(&mut self) -> Parsed {
        let base = self.primary()?;
        if self.take("^") || self.take("**") {
            let exponent = self.signed()?;
            return self.push(Node::Binary(Binary::Power, base, exponent));
        }
        Ok(base)
    }

    fn primary(&mut self) -> Parsed {
        if self.take("(") {
            let inner = self.sum()?;
            return match self.take(")") {
                true => Ok(inner),
                false => self.refuse("')' is missing".to_owned()),
            };
        }
        match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.named(),
            Some(c) => self.refuse(format!(
                "a number, a name or '(' is expected, not '{}'",
                shown(c)
            )),
            None => self.refuse("a number, a name or '(' is expected".to_owned()),
        }
    }

    fn number(&mut self) -> Parsed {
        let first = self.at;
        let mut before = ' ';
        while let Some(c) = self.peek() {
            let is_sign_of_exponent = "+-".contains(c) && "eE".contains(before);
            if !(c.is_ascii_digit() || ".eE".contains(c) || is_sign_of_exponent) {
                break;
            }
            before = c;
            self.at += 1;
        }
        let text: String = self.characters[first..self.at].iter().collect();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => self.push(Node::Constant(value)),
            _ => self.refuse_at(first, format!("'{text}' is not a number")),
        }
    }

    fn named(&mut self) -> Parsed {
        let first = self.at;
        while (self.peek()).is_some_and(|c| c.is_alphanumeric() || c == '_') {
            self.at += 1;
        }
        let name: String = self.characters[first..self.at].iter().collect();
        if self.take("(") {
            return self.call(&name, first);
        }
        if name == "pi" {
            return self.push(Node::Constant(std::f64::consts::PI));
        }
        if is_reserved(&name) {
            return self.refuse(format!("'{name}' is a function: '(' is expected"));
        }
        let found = self.names.node(self.tape, &name, self.depth + 1);
        found.or_else(|reason| self.refuse_at(first, reason))
    }

    fn call(&mut self, name: &str, first: usize) -> Parsed {
        let wanted = match name {
            _ if TERNARY.contains(&name) => 3,
            _ if BINARY.iter().any(|it| it.0 == name) => 2,
            _ if UNARY.iter().any(|it| it.0 == name) => 1,
            _ => {
                let known: Vec<&str> = functions().collect();
                return self.refuse_at(
                    first,
                    format!(
                        "there is no function '{name}'; there are {}",
                        known.join(", ")
                    ),
                );
            }
        };
        let mut of = vec![self.sum()?];
        while self.take(",") {
            of.push(self.sum()?);
        }
        if !self.take(")") {
            return self.refuse("',' or ')' is expected".to_owned());
        }
        if of.len() != wanted {
            let reason = format!(
                "number of arguments of {name}: {wanted} expected, {} given",
                of.len()
            );
            return self.refuse_at(first, reason);
        }
        if let Some((_, function)) = UNARY.iter().find(|it| it.0 == name) {
            return self.push(Node::Unary(*function, of[0]));
        }
        if let Some((_, function)) = BINARY.iter().find(|it| it.0 == name) {
            return self.push(Node::Binary(*function, of[0], of[1]));
        }
        let above = self.push(Node::Binary(Binary::Max, of[0], of[1]))?;
        let within = self.push(Node::Binary(Binary::Min, above, of[2]))?;
        match name {
            "saturate" => Ok(within),
            _ => self.push(Node::Binary(Binary::Subtract, of[0], within)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Letters;

    impl Names for Letters {
        fn node(&mut self, tape: &mut Tape, name: &str, _: usize) -> Result<usize, String> {
            match ["x", "y", "z"].iter().position(|it| *it == name) {
                Some(slot) => Ok(tape.variable(slot)),
                None => Err(format!("'{name}' is unknown")),
            }
        }
    }

    fn root(text: &str) -> Result<(Tape, Root), ExpressionError> {
        let mut tape = Tape::default();
        let node = parse(text, &mut tape, &mut Letters, 0)?;
        let root = tape.root(node);
        Ok((tape, root))
    }

    fn value(text: &str, at: [f64; 3]) -> f64 {
        let (tape, root) = root(text).unwrap();
        let mut numbers = Numbers::default();
        tape.evaluate(&at, &mut numbers);
        numbers.value(&root)
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, expected) in [
            ("2 + 3*4", 14.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("2**3^2", 512.0),
            ("8/4/2", 1.0),
            ("5 - 3 - 1", 1.0),
            ("2e-1 + .5", 0.7),
            ("cos(pi)", -1.0),
            ("atan2(1, 0)*2/pi", 1.0),
            ("deadzone(x, -1, 2) + 10*saturate(x, -1, 2)", 21.0),
            ("deadzone(-3, -1, 2)", -2.0),
            ("sign(0) + abs(-y)*max(x, z)", 6.0),
        ] {
            let found = value(text, [3.0, 2.0, -1.0]);
            assert!((found - expected).abs() < 1e-15, "{text}: {found}");
        }
    }

    #[test]
    fn slopes_are_those_of_central_differences() {
        let at = [0.7, 1.3, -0.4];
        for text in [
            "x*y - z/x",
            "x^y + (x + 2)^3",
            "exp(x*z) + log(y) + sqrt(x*y)",
            "sin(x)*cos(y)*tan(z) + tanh(x*y)",
            "abs(z)*z + max(x, y)*min(x, z)",
            "atan2(z, y) + asin(z) + acos(x) + atan(y)",
            "sinh(x)*cosh(z)",
            "deadzone(y, z, x)^2 + saturate(y, z, x)*z",
        ] {
            let (tape, root) = root(text).unwrap();
            let mut numbers = Numbers::default();
            tape.evaluate(&at, &mut numbers);
            let mut slopes = [0.0; 3];
            tape.slopes(&root, &mut numbers, &mut slopes);
            for (slot, slope) in slopes.iter().enumerate() {
                let moved = |by: f64| {
                    let mut at = at;
                    at[slot] += by;
                    value(text, at)
                };
                let expected = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!(
                    (slope - expected).abs() < 1e-8,
                    "{text}, {slot}: {slope} {expected}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_expression_is_refused_with_its_place() {
        for (text, said) in [
            ("", "character 1: a number, a name or '(' is expected"),
            ("x + ", "character 5: a number"),
            ("x y", "character 3: an operator is expected, not 'y'"),
            ("(x", "character 3: ')' is missing"),
            ("x*foo(y)", "character 3: there is no function 'foo'"),
            ("max(x)", "number of arguments of max: 2 expected, 1 given"),
            ("q", "character 1: 'q' is unknown"),
            ("1.2.3", "'1.2.3' is not a number"),
            ("sin*2", "'sin' is a function"),
        ] {
            let refusal = root(text).unwrap_err().to_string();
            assert!(refusal.contains(said), "{text}: {refusal}");
        }
        let deep = "(".repeat(100_000);
        assert!(
            root(&deep)
                .unwrap_err()
                .to_string()
                .contains("64 levels deep")
        );
        let deep = "-".repeat(100_000);
        assert!(
            root(&deep)
                .unwrap_err()
                .to_string()
                .contains("64 levels deep")
        );
    }
}
