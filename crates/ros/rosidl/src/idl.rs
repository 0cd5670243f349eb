//! The `ros2idl` schema text: OMG IDL as rosidl makes it of definitions, and as people write it for ROS.
//!
//! rosbag2 stores the file of a type and those of all it refers to, each headed by a line of 80
//! `=` and one `IDL: package/msg/Type`. Read is the subset that ROS has a form for (rosidl_parser's grammar, after
//! OMG IDL 4.2, section 7.4): modules, structs, typedefs, enums (32-bit numbers in CDR), constants where a bound
//! stands; annotations and comments are passed over. What ROS knows no form for (unions, maps, inheritance, lists
//! of lists) is refused by name. An array of several dimensions is one array, the last index fastest.

use std::collections::{BTreeMap, BTreeSet};

use crate::definition::{
    Arity, EMPTY_MESSAGE_FIELD, Element, Field, FieldType, Message, Primitive, TypeName, is_name,
};
use crate::error::{Error, MAX_DEPTH, Rule};
use crate::library::Library;

/// Reads a `ros2idl` schema text that defines `type_name` and all it refers to.
///
/// The result has passed [`Library::check`].
///
/// # Errors
/// The line of the text and the rule it breaks.
pub fn parse_idl_schema(type_name: &str, text: &str) -> Result<Library, Error> {
    let file = format!("schema of {type_name}");
    let root = TypeName::parse(type_name)
        .ok_or_else(|| Rule::BadName(type_name.to_owned()).at(&file, 0))?;
    let mut parser = Parser {
        tokens: tokens(text, &file)?,
        next: 0,
        file: &file,
        scope: Vec::new(),
        declared: BTreeMap::new(),
    };
    parser.specification()?;
    let declared = parser.declared;
    let mut library = Library::new();
    for (name, declaration) in &declared {
        if let Declared::Struct(members) = &declaration.what {
            let name = type_of(name).map_err(|rule| rule.at(&file, declaration.line))?;
            let mut names = BTreeSet::new();
            if let Some(twice) = members.iter().find(|member| !names.insert(&member.name)) {
                return Err(Rule::Duplicate(twice.name.clone()).at(&file, twice.line));
            }
            let fields = members
                .iter()
                .map(|member| member.field(&declared, &declaration.scope, &file))
                .collect::<Result<_, _>>()?;
            library.add_message(message(name, fields, &file))?;
        }
    }
    library.expect_message(&root)?;
    library.check()?;
    Ok(library)
}

fn message(name: TypeName, mut fields: Vec<Field>, file: &str) -> Message {
    if fields.is_empty() {
        fields.push(Field {
            name: EMPTY_MESSAGE_FIELD.to_owned(),
            field_type: FieldType {
                element: Element::Primitive(Primitive::Uint8),
                arity: Arity::One,
            },
            default: None,
            comment: Vec::new(),
            line: 0,
        });
    }
    Message {
        name,
        comment: Vec::new(),
        constants: Vec::new(),
        fields,
        text: String::new(),
        file: file.to_owned(),
    }
}

/// `pkg::msg::Type` as ROS names it.
fn type_of(scoped: &str) -> Result<TypeName, Rule> {
    TypeName::parse(&scoped.replace("::", "/")).ok_or_else(|| Rule::BadName(scoped.to_owned()))
}

/// A token, a number, a text in quotes (its quotes only), or a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Token<'t> {
    text: &'t str,
    line: usize,
}

fn tokens<'t>(text: &'t str, file: &str) -> Result<Vec<Token<'t>>, Error> {
    let mut tokens = Vec::new();
    let mut line = 1;
    let mut rest = text;
    let mut at_line_start = true;
    while let Some(first) = rest.chars().next() {
        // Preprocessor lines, and the heads of rosbag2's sections.
        let is_head = at_line_start
            && (first == '#' || rest.starts_with("=====") || rest.starts_with("IDL:"));
        let length = if is_head || rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if first == '"' || first == '\'' {
            quoted(rest, first)
                .ok_or_else(|| Rule::NotIdl("a quote without end".to_owned()).at(file, line))?
        } else if first.is_whitespace() {
            first.len_utf8()
        } else if first.is_ascii_alphanumeric() || first == '_' {
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            rest.find(|c: char| !is_word(c)).unwrap_or(rest.len())
        } else if rest.starts_with("::") {
            2
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(length);
        let is_space =
            first.is_whitespace() || is_head || token.starts_with("//") || token.starts_with("/*");
        if !is_space {
            tokens.push(Token { text: token, line });
        }
        at_line_start = first == '\n' || (at_line_start && first.is_whitespace());
        line += token.matches('\n').count();
        rest = after;
    }
    Ok(tokens)
}

/// The length of the text in quotes that `text` begins with, the quotes counted.
fn quoted(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if c == quote && !escaped {
            return Some(at + 1);
        }
        escaped = c == '\\' && !escaped;
    }
    None
}

/// A name that a specification gives a meaning to.
struct Declaration {
    what: Declared,
    /// The modules it stands in.
    scope: Vec<String>,
    line: usize,
}

enum Declared {
    Struct(Vec<Member>),
    Typedef(Member),
    Enum,
    Constant(u32),
}

/// By full name, `pkg::msg::Type`.
type Declarations = BTreeMap<String, Declaration>;

/// A field, or the name of a typedef, as it is written.
struct Member {
    name: String,
    base: Base,
    /// Of a sequence: its bound, `None` for none.
    sequence: Option<Option<Bound>>,
    /// The dimensions of an array.
    array: Vec<Bound>,
    line: usize,
}

#[derive(Clone)]
enum Base {
    Known(Primitive),
    String { wide: bool, bound: Option<Bound> },
    Named(String),
}

/// A number, or a constant's name.
#[derive(Clone)]
enum Bound {
    Number(u32),
    Named(String),
}

struct Parser<'t> {
    tokens: Vec<Token<'t>>,
    next: usize,
    file: &'t str,
    scope: Vec<String>,
    declared: Declarations,
}

impl<'t> Parser<'t> {
    fn specification(&mut self) -> Result<(), Error> {
        while let Some(token) = self.take() {
            match token {
                ";" => {}
                "@" => self.annotation()?,
                "module" => {
                    let name = self.name()?;
                    self.expect("{")?;
                    if self.scope.len() == MAX_DEPTH {
                        return Err(Rule::TooDeep.at(self.file, self.line()));
                    }
                    self.scope.push(name);
                }
                "}" if self.scope.pop().is_some() => {}
                "struct" => self.structure()?,
                "typedef" => {
                    for member in self.members()? {
                        let name = member.name.clone();
                        self.declare(name, Declared::Typedef(member))?;
                    }
                }
                "enum" => self.enumeration()?,
                "const" => self.constant()?,
                other => return Err(self.refuse(other)),
            }
        }
        if self.scope.is_empty() {
            Ok(())
        } else {
            Err(self.refuse("the end of the text"))
        }
    }

    fn structure(&mut self) -> Result<(), Error> {
        let name = self.name()?;
        self.expect("{")?;
        let mut members = Vec::new();
        loop {
            match self.peek() {
                Some("}") => break,
                Some("@") => {
                    self.take();
                    self.annotation()?;
                }
                _ => members.append(&mut self.members()?),
            }
        }
        self.expect("}")?;
        self.declare(name, Declared::Struct(members))
    }

    fn enumeration(&mut self) -> Result<(), Error> {
        let name = self.name()?;
        self.expect("{")?;
        while self.peek().is_some_and(|token| token != "}") {
            self.take();
        }
        self.expect("}")?;
        self.declare(name, Declared::Enum)
    }

    /// A constant; only whole positive ones can be bounds, others are passed over.
    fn constant(&mut self) -> Result<(), Error> {
        let mut tokens = Vec::new();
        while let Some(token) = self.take().filter(|token| *token != ";") {
            tokens.push(token);
        }
        if let [.., name, "=", value] = tokens[..]
            && let Ok(value) = value.parse()
        {
            self.declare(name.to_owned(), Declared::Constant(value))?;
        }
        Ok(())
    }

    /// Passes what follows an `@`.
    fn annotation(&mut self) -> Result<(), Error> {
        self.name()?;
        if self.peek() != Some("(") {
            return Ok(());
        }
        let mut open = 0_usize;
        while let Some(token) = self.take() {
            match token {
                "(" => open += 1,
                ")" if open == 1 => return Ok(()),
                ")" => open -= 1,
                _ => {}
            }
        }
        Err(self.refuse("the end of the text"))
    }

    /// `type name, name[3];`
    fn members(&mut self) -> Result<Vec<Member>, Error> {
        let (base, sequence) = self.any_type()?;
        let line = self.line();
        let mut members = Vec::new();
        loop {
            let name = self.name()?;
            let mut array = Vec::new();
            while self.peek() == Some("[") {
                self.take();
                array.push(self.bound()?);
                self.expect("]")?;
            }
            members.push(Member {
                name,
                base: base.clone(),
                sequence: sequence.clone(),
                array,
                line,
            });
            match self.take() {
                Some(",") => {}
                Some(";") => return Ok(members),
                other => return Err(self.refuse(other.unwrap_or("the end of the text"))),
            }
        }
    }

    fn any_type(&mut self) -> Result<(Base, Option<Option<Bound>>), Error> {
        if self.peek() != Some("sequence") {
            return Ok((self.base()?, None));
        }
        self.take();
        self.expect("<")?;
        let base = self.base()?;
        let bound = match self.peek() {
            Some(",") => {
                self.take();
                Some(self.bound()?)
            }
            _ => None,
        };
        self.expect(">")?;
        Ok((base, Some(bound)))
    }

    fn base(&mut self) -> Result<Base, Error> {
        let token = self.take().unwrap_or("the end of the text");
        let mut then = |next: &str| {
            let is_next = self.peek() == Some(next);
            if is_next {
                self.take();
            }
            is_next
        };
        Ok(Base::Known(match token {
            "boolean" => Primitive::Bool,
            "octet" => Primitive::Byte,
            "char" => Primitive::Char,
            "int8" => Primitive::Int8,
            "uint8" => Primitive::Uint8,
            "short" | "int16" => Primitive::Int16,
            "uint16" => Primitive::Uint16,
            "int32" => Primitive::Int32,
            "uint32" => Primitive::Uint32,
            "int64" => Primitive::Int64,
            "uint64" => Primitive::Uint64,
            "float" => Primitive::Float32,
            "double" => Primitive::Float64,
            // `double` after `long` is of 16 bytes, which ROS has no form for.
            "long" if then("double") => return Err(self.refuse("long double")),
            "long" if then("long") => Primitive::Int64,
            "long" => Primitive::Int32,
            "unsigned" if then("short") => Primitive::Uint16,
            "unsigned" if then("long") => {
                if self.peek() == Some("long") {
                    self.take();
                    Primitive::Uint64
                } else {
                    Primitive::Uint32
                }
            }
            "string" | "wstring" => {
                let mut bound = None;
                if self.peek() == Some("<") {
                    self.take();
                    bound = Some(self.bound()?);
                    self.expect(">")?;
                }
                let wide = token == "wstring";
                return Ok(Base::String { wide, bound });
            }
            "sequence" | "map" | "union" | "struct" | "enum" | "wchar" | "any" | "fixed" => {
                return Err(self.refuse(token));
            }
            _ => {
                self.next -= 1;
                return Ok(Base::Named(self.scoped_name()?));
            }
        }))
    }

    /// `a::b::C`, without a leading `::`.
    fn scoped_name(&mut self) -> Result<String, Error> {
        if self.peek() == Some("::") {
            self.take();
        }
        let mut name = self.name()?;
        while self.peek() == Some("::") {
            self.take();
            name.push_str("::");
            name.push_str(&self.name()?);
        }
        Ok(name)
    }

    fn bound(&mut self) -> Result<Bound, Error> {
        let token = self.peek().unwrap_or("the end of the text");
        if token.starts_with(|c: char| c.is_ascii_digit()) {
            self.take();
            return match token.parse() {
                Ok(bound) if bound > 0 => Ok(Bound::Number(bound)),
                _ => Err(Rule::BadBound(token.to_owned()).at(self.file, self.line())),
            };
        }
        Ok(Bound::Named(self.scoped_name()?))
    }

    fn declare(&mut self, name: String, what: Declared) -> Result<(), Error> {
        let line = self.line();
        let full = within(&self.scope, &name);
        let declaration = Declaration {
            what,
            scope: self.scope.clone(),
            line,
        };
        // A file that two others include comes twice.
        self.declared.entry(full).or_insert(declaration);
        Ok(())
    }

    fn name(&mut self) -> Result<String, Error> {
        let token = self.take().unwrap_or("the end of the text");
        // A leading underscore keeps a token of the language from being one.
        let name = token.strip_prefix('_').unwrap_or(token);
        if is_name(name) {
            Ok(name.to_owned())
        } else {
            Err(self.refuse(token))
        }
    }

    fn expect(&mut self, wanted: &str) -> Result<(), Error> {
        match self.take() {
            Some(token) if token == wanted => Ok(()),
            other => Err(self.refuse(other.unwrap_or("the end of the text"))),
        }
    }

    fn peek(&self) -> Option<&'t str> {
        self.tokens.get(self.next).map(|token| token.text)
    }

    fn take(&mut self) -> Option<&'t str> {
        let token = self.peek();
        self.next += 1;
        token
    }

    /// The line of the token taken last.
    fn line(&self) -> usize {
        let last = self.next.saturating_sub(1);
        let token = self.tokens.get(last).or(self.tokens.last());
        token.map_or(0, |token| token.line)
    }

    fn refuse(&self, token: &str) -> Error {
        Rule::NotIdl(token.to_owned()).at(self.file, self.line())
    }
}

fn within(scope: &[String], name: &str) -> String {
    let mut full = scope.join("::");
    if !full.is_empty() {
        full.push_str("::");
    }
    full.push_str(name);
    full
}

/// The meaning of `name` in `scope`: that of the innermost module that defines it.
fn find<'d>(
    declared: &'d Declarations,
    scope: &[String],
    name: &str,
) -> Option<(String, &'d Declaration)> {
    (0..=scope.len()).rev().find_map(|depth| {
        let full = within(&scope[..depth], name);
        declared.get(&full).map(|found| (full, found))
    })
}

impl Bound {
    fn resolve(&self, declared: &Declarations, scope: &[String]) -> Result<u32, Rule> {
        match self {
            Self::Number(number) => Ok(*number),
            Self::Named(name) => match find(declared, scope, name).map(|(_, it)| &it.what) {
                Some(Declared::Constant(bound)) if *bound > 0 => Ok(*bound),
                _ => Err(Rule::BadBound(name.clone())),
            },
        }
    }
}

impl Member {
    fn field(&self, declared: &Declarations, scope: &[String], file: &str) -> Result<Field, Error> {
        let field_type = self
            .resolve(declared, scope, 0)
            .map_err(|rule| rule.at(file, self.line))?;
        Ok(Field {
            name: self.name.clone(),
            field_type,
            default: None,
            comment: Vec::new(),
            line: self.line,
        })
    }

    fn resolve(
        &self,
        declared: &Declarations,
        scope: &[String],
        depth: usize,
    ) -> Result<FieldType, Rule> {
        if depth > MAX_DEPTH {
            return Err(Rule::TooDeep);
        }
        let base = match &self.base {
            Base::Known(primitive) => one(Element::Primitive(*primitive)),
            Base::String { wide, bound } => {
                let bound = bound.as_ref().map(|it| it.resolve(declared, scope));
                one(Element::String {
                    wide: *wide,
                    bound: bound.transpose()?,
                })
            }
            Base::Named(name) => match find(declared, scope, name) {
                Some((full, found)) => match &found.what {
                    Declared::Struct(_) => one(Element::Message(type_of(&full)?)),
                    Declared::Enum => one(Element::Primitive(Primitive::Uint32)),
                    Declared::Typedef(member) => {
                        member.resolve(declared, &found.scope, depth + 1)?
                    }
                    Declared::Constant(_) => return Err(Rule::BadType(name.clone())),
                },
                None => return Err(Rule::Unknown(name.replace("::", "/"))),
            },
        };
        let mut arity = match &self.sequence {
            None => Arity::One,
            Some(None) => Arity::Sequence,
            Some(Some(bound)) => Arity::BoundedSequence(bound.resolve(declared, scope)?),
        };
        let list_of_lists = || Rule::NotIdl(format!("{}, a list of lists", self.name));
        if !self.array.is_empty() {
            if arity != Arity::One {
                return Err(list_of_lists());
            }
            let mut size = 1_u32;
            for bound in &self.array {
                size = size
                    .checked_mul(bound.resolve(declared, scope)?)
                    .ok_or_else(|| Rule::BadBound(self.name.clone()))?;
            }
            arity = Arity::Array(size);
        }
        match (base.arity, arity) {
            (_, Arity::One) => Ok(base),
            (Arity::One, arity) => Ok(FieldType { arity, ..base }),
            _ => Err(list_of_lists()),
        }
    }
}

fn one(element: Element) -> FieldType {
    FieldType {
        element,
        arity: Arity::One,
    }
}
