//! Generates Rust code for the definitions in a library.
//!
//! The text must be included at the root of a crate that depends on `serde` and `serde_big_array` and contains these items: the traits
//! `Message`, `Field`, `Service` and `Action`, the trait `finite::Finite` with the function `finite::field`, and the struct `TypeInfo` with a
//! `const fn of::<M: Message>()`. The text ends with `REGISTRY`, a static slice of the `TypeInfo` of all messages, sorted by name.
//!
//! `package/kind/Name` becomes `crate::package::kind::Name`; derived types lose their underscore (`Fit_Request` becomes `FitRequest`). Names of
//! the standard library are written in full, since a message may be called `String`. Bounds of strings and sequences are dropped in the Rust
//! types.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::definition::{
    Action, Arity, Constant, Element, Field, FieldType, Kind, Message, Primitive, Service,
    TypeName, Value,
};
use crate::error::{Error, Rule};
use crate::library::Library;

/// Largest array for which `serde` and `Default` are implemented.
const LONGEST_PLAIN_ARRAY: u32 = 32;

/// Generates the modules of all definitions in the library.
///
/// # Errors
/// Errors of [`Library::check`], and [`Rule::NoRust`] for `wstring` fields.
pub fn generate(library: &Library) -> Result<String, Error> {
    library.check()?;
    let mut modules: BTreeMap<(&str, Kind), String> = BTreeMap::new();
    let mut registry = String::new();

    for message in library.messages() {
        if !is_struct(library, &message.name) {
            continue;
        }
        let module = modules
            .entry((&message.name.package, message.name.kind))
            .or_default();
        module.push_str(&structure(library, message)?);
        if message.name.kind == Kind::Msg {
            let path = path(&message.name);
            let _ = writeln!(registry, "    TypeInfo::of::<{path}>(),");
        }
    }
    for it in library.services() {
        let module = modules.entry((&it.name.package, it.name.kind));
        module.or_default().push_str(&service(library, it)?);
    }
    for it in library.actions() {
        let module = modules.entry((&it.name.package, it.name.kind));
        module.or_default().push_str(&action(library, it)?);
    }

    let mut text = String::new();
    let mut packages: BTreeMap<&str, Vec<(Kind, String)>> = BTreeMap::new();
    for ((package, kind), module) in modules {
        packages.entry(package).or_default().push((kind, module));
    }
    for (package, modules) in packages {
        let _ = writeln!(
            text,
            "/// The package `{package}`.\npub mod {} {{",
            identifier(package)
        );
        for (kind, module) in modules {
            let kind = kind.as_str();
            let _ = writeln!(
                text,
                "/// From the `.{kind}` files of `{package}`.\npub mod {kind} {{"
            );
            let _ = writeln!(text, "{module}}}");
        }
        text.push_str("}\n\n");
    }
    let _ = writeln!(text, "static REGISTRY: &[TypeInfo] = &[\n{registry}];");
    Ok(text)
}

/// Service events, and the placeholders for hashing services and actions, need no Rust struct.
fn is_struct(library: &Library, name: &TypeName) -> bool {
    let stands_in = library
        .services()
        .any(|it| it.name == *name || it.name.derived("Event") == *name)
        || library.actions().any(|it| it.name == *name);
    !stands_in
}

fn service(library: &Library, service: &Service) -> Result<String, Error> {
    let own = format!("ROS service `{}`.", service.name);
    Ok(format!(
        r#"
{doc}#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct {rust};

impl crate::Service for {rust} {{
    type Request = {request};
    type Response = {response};
    const TYPE_NAME: &'static str = "{name}";
    const TYPE_HASH: &'static str = "{hash}";
}}
"#,
        doc = doc(&service.request.comment, &own),
        name = service.name,
        rust = rust_name(&service.name),
        request = path(&service.request.name),
        response = path(&service.response.name),
        hash = library.type_hash(&service.name)?,
    ))
}

fn action(library: &Library, action: &Action) -> Result<String, Error> {
    let own = format!("ROS action `{}`.", action.name);
    Ok(format!(
        r#"
{doc}#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct {rust};

impl crate::Action for {rust} {{
    type Goal = {goal};
    type Result = {result};
    type Feedback = {feedback};
    type SendGoal = {send_goal};
    type GetResult = {get_result};
    type FeedbackMessage = {feedback_message};
    const TYPE_NAME: &'static str = "{name}";
    const TYPE_HASH: &'static str = "{hash}";
}}
"#,
        doc = doc(&action.goal.comment, &own),
        name = action.name,
        rust = rust_name(&action.name),
        goal = path(&action.goal.name),
        result = path(&action.result.name),
        feedback = path(&action.feedback.name),
        send_goal = path(&action.name.derived("SendGoal")),
        get_result = path(&action.name.derived("GetResult")),
        feedback_message = path(&action.name.derived("FeedbackMessage")),
        hash = library.type_hash(&action.name)?,
    ))
}

fn structure(library: &Library, message: &Message) -> Result<String, Error> {
    let name = rust_name(&message.name);
    let mut text = String::new();

    text.push_str(&doc(
        &message.comment,
        &format!("ROS type `{}`.", message.name),
    ));

    let plain_default = message.fields.iter().all(|field| {
        let long =
            matches!(field.field_type.arity, Arity::Array(size) if size > LONGEST_PLAIN_ARRAY);
        !long && field.default.as_ref().is_none_or(is_zero)
    });
    let default = if plain_default { "Default, " } else { "" };
    let _ = writeln!(
        text,
        "#[derive(Clone, Debug, {default}PartialEq, serde::Serialize, serde::Deserialize)]"
    );
    let _ = writeln!(text, "pub struct {name} {{");
    for field in &message.fields {
        let doc = match field.comment.is_empty() {
            true => vec![format!("`{}`", field.field_type)],
            false => field.comment.clone(),
        };
        push_doc(&mut text, &doc, "    ");
        if matches!(field.field_type.arity, Arity::Array(size) if size > LONGEST_PLAIN_ARRAY) {
            text.push_str("    #[serde(with = \"serde_big_array::BigArray\")]\n");
        }
        let rust_field = identifier(&field.name);
        if rust_field.trim_start_matches("r#") != field.name {
            let _ = writeln!(text, "    #[serde(rename = \"{}\")]", field.name);
        }
        let rust_type = rust_type(message, field)?;
        let _ = writeln!(text, "    pub {rust_field}: {rust_type},");
    }
    text.push_str("}\n\n");
    if !plain_default {
        text += &own_default(&name, &message.fields);
    }
    if !message.constants.is_empty() {
        text += &constants(&name, &message.constants);
    }
    text += &traits(library, message)?;
    Ok(text)
}

/// Implementation of `Default` with the message's own default values.
fn own_default(name: &str, fields: &[Field]) -> String {
    let mut text = format!(
        "impl ::std::default::Default for {name} {{\n    fn default() -> Self {{\n        Self {{\n"
    );
    for field in fields {
        let value = default_value(field);
        let _ = writeln!(text, "            {}: {value},", identifier(&field.name));
    }
    text + "        }\n    }\n}\n\n"
}

fn constants(name: &str, constants: &[Constant]) -> String {
    let mut text = format!("impl {name} {{\n");
    for constant in constants {
        push_doc(&mut text, &constant_doc(constant), "    ");
        let _ = writeln!(
            text,
            "    pub const {}: {} = {};",
            identifier(&constant.name),
            match &constant.element {
                Element::Primitive(primitive) => rust_primitive(*primitive),
                _ => "&'static str",
            },
            literal(&constant.element, &constant.value, false),
        );
    }
    text + "}\n\n"
}

/// Implementations of the message traits.
fn traits(library: &Library, message: &Message) -> Result<String, Error> {
    let each = |text: &dyn Fn(&str, String) -> String, is_in: &dyn Fn(&Field) -> bool| {
        let fields = message.fields.iter().filter(|field| is_in(field));
        let texts = fields.map(|field| text(&field.name, identifier(&field.name)));
        texts.collect::<String>()
    };
    let check = |name: &str, field: String| {
        format!("\n            .or_else(|| crate::finite::field(\"{name}\", &self.{field}))")
    };
    let is_named = |name: &str, field: String| {
        format!("\n            \"{name}\" => ::std::option::Option::Some(&self.{field}),")
    };
    Ok(format!(
        r#"impl crate::Message for {name} {{
    const TYPE_NAME: &'static str = "{ros}";
    const DDS_TYPE_NAME: &'static str = "{dds}";
    const DEFINITION: &'static str = {schema:?};
    const TYPE_HASH: &'static str = "{hash}";

    fn first_non_finite(&self) -> ::std::option::Option<::std::string::String> {{
        ::std::option::Option::None{checks}
    }}
}}

impl crate::finite::Finite for {name} {{
    fn first_non_finite_path(&self) -> ::std::option::Option<::std::string::String> {{
        crate::Message::first_non_finite(self)
    }}
}}

impl crate::Field for {name} {{
    fn field(&self, name: &str) -> ::std::option::Option<&dyn crate::Field> {{
        match name {{{fields}
            _ => ::std::option::Option::None,
        }}
    }}
}}

"#,
        ros = message.name,
        dds = message.name.dds(),
        schema = library.schema(&message.name)?,
        hash = library.type_hash(&message.name)?,
        name = rust_name(&message.name),
        checks = each(&check, &|field| holds_floats(
            library,
            &field.field_type.element
        )),
        fields = each(&is_named, &|_| true),
    ))
}

/// Whether an element is or contains a floating-point number. The library has been checked, so recursion ends.
fn holds_floats(library: &Library, element: &Element) -> bool {
    match element {
        Element::Primitive(primitive) => {
            matches!(primitive, Primitive::Float32 | Primitive::Float64)
        }
        Element::String { .. } => false,
        Element::Message(name) => library.message(name).is_some_and(|message| {
            message
                .fields
                .iter()
                .any(|field| holds_floats(library, &field.field_type.element))
        }),
    }
}

fn rust_name(name: &TypeName) -> String {
    name.name.replace('_', "")
}

fn path(name: &TypeName) -> String {
    format!(
        "crate::{}::{}::{}",
        identifier(&name.package),
        name.kind.as_str(),
        rust_name(name)
    )
}

fn rust_type(message: &Message, field: &Field) -> Result<String, Error> {
    let FieldType { element, arity } = &field.field_type;
    let element = match element {
        Element::Primitive(primitive) => rust_primitive(*primitive).to_owned(),
        Element::String { wide: false, .. } => "::std::string::String".to_owned(),
        Element::String { wide: true, .. } => {
            return Err(Rule::NoRust(element.to_string()).at(&message.file, field.line));
        }
        Element::Message(name) => path(name),
    };
    Ok(match arity {
        Arity::One => element,
        Arity::Array(size) => format!("[{element}; {size}]"),
        Arity::Sequence | Arity::BoundedSequence(_) => format!("::std::vec::Vec<{element}>"),
    })
}

fn rust_primitive(primitive: Primitive) -> &'static str {
    match primitive {
        Primitive::Bool => "bool",
        Primitive::Byte | Primitive::Char | Primitive::Uint8 => "u8",
        Primitive::Int8 => "i8",
        Primitive::Int16 => "i16",
        Primitive::Uint16 => "u16",
        Primitive::Int32 => "i32",
        Primitive::Uint32 => "u32",
        Primitive::Int64 => "i64",
        Primitive::Uint64 => "u64",
        Primitive::Float32 => "f32",
        Primitive::Float64 => "f64",
    }
}

fn default_value(field: &Field) -> String {
    let FieldType { element, arity } = &field.field_type;
    match (&field.default, arity) {
        (Some(Value::List(values)), arity) => {
            let values: Vec<String> = values
                .iter()
                .map(|value| literal(element, value, true))
                .collect();
            let list = values.join(", ");
            match arity {
                Arity::Array(_) => format!("[{list}]"),
                _ => format!("::std::vec![{list}]"),
            }
        }
        (Some(value), _) => literal(element, value, true),
        (None, Arity::Array(_)) => {
            "::std::array::from_fn(|_| ::std::default::Default::default())".to_owned()
        }
        (None, _) => "::std::default::Default::default()".to_owned(),
    }
}

/// Whether a default equals the type's zero. A list never does: a sequence's default may be longer.
fn is_zero(value: &Value) -> bool {
    match value {
        Value::Bool(value) => !value,
        Value::Integer(value) => *value == 0,
        Value::Float(value) => *value == 0.0 && value.is_sign_positive(),
        Value::String(value) => value.is_empty(),
        Value::List(_) => false,
    }
}

/// A value as a Rust expression; strings as `String` if `owned`.
fn literal(element: &Element, value: &Value, owned: bool) -> String {
    let float = match element {
        Element::Primitive(primitive) => rust_primitive(*primitive),
        _ => "",
    };
    match value {
        Value::Bool(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) if value.is_nan() => format!("{float}::NAN"),
        Value::Float(value) if *value == f64::INFINITY => format!("{float}::INFINITY"),
        Value::Float(value) if *value == f64::NEG_INFINITY => format!("{float}::NEG_INFINITY"),
        Value::Float(value) => format!("{value:?}"),
        Value::String(value) if owned => format!("{value:?}.to_owned()"),
        Value::String(value) => format!("{value:?}"),
        // Constants are never lists, and the items of a list are not lists.
        Value::List(_) => String::new(),
    }
}

fn constant_doc(constant: &Constant) -> Vec<String> {
    match constant.comment.is_empty() {
        true => vec![format!("`{}`", constant.element)],
        false => constant.comment.clone(),
    }
}

/// A ROS name as a Rust identifier: keywords become raw identifiers, or get an underscore if that is impossible.
fn identifier(name: &str) -> String {
    match name {
        "self" | "super" | "crate" | "Self" => format!("{name}_"),
        "as" | "async" | "await" | "break" | "const" | "continue" | "dyn" | "else" | "enum"
        | "extern" | "false" | "fn" | "for" | "if" | "impl" | "in" | "let" | "loop" | "match"
        | "mod" | "move" | "mut" | "pub" | "ref" | "return" | "static" | "struct" | "trait"
        | "true" | "type" | "unsafe" | "use" | "where" | "while" | "abstract" | "become"
        | "box" | "do" | "final" | "gen" | "macro" | "override" | "priv" | "try" | "typeof"
        | "unsized" | "virtual" | "yield" => format!("r#{name}"),
        _ => name.to_owned(),
    }
}

/// Doc comment of an item: its own comment, then a generated line.
fn doc(comment: &[String], own: &str) -> String {
    let end = comment
        .iter()
        .rposition(|line| !line.is_empty())
        .map_or(0, |last| last + 1);
    let mut lines = comment[..end].to_vec();
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines.push(own.to_owned());
    let mut text = String::new();
    push_doc(&mut text, &lines, "");
    text
}

/// Comment lines as rustdoc. Indented blocks (equations, tables) become text blocks; Markdown and HTML syntax is escaped.
fn push_doc(text: &mut String, lines: &[String], indent: &str) {
    let mut push = |line: &str| {
        let _ = writeln!(text, "{}", format!("{indent}/// {line}").trim_end());
    };
    let mut in_block = false;
    for line in lines {
        let indented = line.starts_with("  ") || line.starts_with('\t');
        if indented != in_block {
            push(if indented { "```text" } else { "```" });
            in_block = indented;
        }
        if indented {
            push(line);
        } else {
            push(&escape_markdown(line));
        }
    }
    if in_block {
        push("```");
    }
}

fn escape_markdown(line: &str) -> String {
    let mut escaped = String::new();
    let mut in_code = false;
    for c in line.chars() {
        if c == '`' {
            in_code = !in_code;
        } else if !in_code && matches!(c, '[' | ']' | '<' | '>' | '*' | '_' | '\\' | '|') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}
