//! Parser of `.msg`, `.srv` and `.action` texts.
//!
//! The grammar is described on the ROS 2 page "About ROS 2 interfaces", and matches rosidl. Comments are kept: the block at the top describes the
//! message; a comment after a declaration, indented below it, or directly above it describes that declaration. Other comment blocks, separated by a
//! blank line, are not assigned.

use std::collections::BTreeSet;

use crate::definition::{
    Action, Arity, Constant, EMPTY_MESSAGE_FIELD, Element, Field, FieldType, Kind, Message,
    Primitive, Service, TypeName, Value, is_name,
};
use crate::error::{Error, Rule};

/// Parses the text of a `.msg` file.
///
/// # Errors
/// The line and the violated rule.
pub fn parse_message(package: &str, name: &str, text: &str) -> Result<Message, Error> {
    let name = checked_name(package, Kind::Msg, name)?;
    let file = name.to_string();
    parse_part(name, text, &file, 0)
}

/// Parses the text of a `.srv` file: request, `---`, response.
///
/// # Errors
/// The line and the violated rule.
pub fn parse_service(package: &str, name: &str, text: &str) -> Result<Service, Error> {
    let name = checked_name(package, Kind::Srv, name)?;
    let file = name.to_string();
    let [request, response] = split_parts(text, &file)?;
    Ok(Service {
        request: parse_part(name.derived("Request"), &request.text, &file, request.line)?,
        response: parse_part(
            name.derived("Response"),
            &response.text,
            &file,
            response.line,
        )?,
        name,
    })
}

/// Parses the text of an `.action` file: goal, `---`, result, `---`, feedback.
///
/// # Errors
/// The line and the violated rule.
pub fn parse_action(package: &str, name: &str, text: &str) -> Result<Action, Error> {
    let name = checked_name(package, Kind::Action, name)?;
    let file = name.to_string();
    let [goal, result, feedback] = split_parts(text, &file)?;
    Ok(Action {
        goal: parse_part(name.derived("Goal"), &goal.text, &file, goal.line)?,
        result: parse_part(name.derived("Result"), &result.text, &file, result.line)?,
        feedback: parse_part(
            name.derived("Feedback"),
            &feedback.text,
            &file,
            feedback.line,
        )?,
        name,
    })
}

fn checked_name(package: &str, kind: Kind, name: &str) -> Result<TypeName, Error> {
    for part in [package, name] {
        if !is_name(part) {
            let file = format!("{package}/{}/{name}", kind.as_str());
            return Err(Rule::BadName(part.to_owned()).at(&file, 0));
        }
    }
    Ok(TypeName::new(package, kind, name))
}

/// A section of a service or action text, and the number of lines before it.
struct Part {
    text: String,
    line: usize,
}

fn split_parts<const N: usize>(text: &str, file: &str) -> Result<[Part; N], Error> {
    let mut parts = vec![Part {
        text: String::new(),
        line: 0,
    }];
    for (index, line) in text.lines().enumerate() {
        if line.trim_end() == "---" {
            parts.push(Part {
                text: String::new(),
                line: index + 1,
            });
        } else if let Some(part) = parts.last_mut() {
            part.text.push_str(line);
            part.text.push('\n');
        }
    }
    let found = parts.len() - 1;
    parts.try_into().map_err(|_| {
        Rule::Separators {
            found,
            expected: N - 1,
        }
        .at(file, 0)
    })
}

/// Parses the message `name`; `file` and `lines_before` are for error messages.
pub(crate) fn parse_part(
    name: TypeName,
    text: &str,
    file: &str,
    lines_before: usize,
) -> Result<Message, Error> {
    let mut message = Message {
        name,
        comment: Vec::new(),
        constants: Vec::new(),
        fields: Vec::new(),
        text: text.to_owned(),
        file: file.to_owned(),
    };
    let mut names = Names::default();
    let mut at_top = true;
    // Comment lines that describe the declaration below them, if one follows at once.
    let mut above: Vec<String> = Vec::new();
    // Which declaration an indented comment line goes on describing: the one just read.
    let mut last: Option<Kept> = None;

    for (index, line) in text.lines().enumerate() {
        let line_number = lines_before + index + 1;
        let trimmed = line.trim();
        if trimmed.is_empty() {
            above.clear();
            last = None;
            at_top = at_top && message.comment.is_empty();
        } else if let Some(comment) = trimmed.strip_prefix('#') {
            let comment = comment_text(comment);
            match last {
                Some(kept) if line.starts_with([' ', '\t']) => {
                    kept.comment_in(&mut message).push(comment);
                }
                _ if at_top => message.comment.push(comment),
                _ => above.push(comment),
            }
        } else {
            at_top = false;
            let comment = std::mem::take(&mut above);
            let kept = declaration(&message.name.package, trimmed, comment, line_number)
                .and_then(|declared| names.keep(declared, &mut message))
                .map_err(|rule| rule.at(file, line_number))?;
            last = Some(kept);
        }
    }
    if message.fields.is_empty() {
        message.fields.push(Field {
            name: EMPTY_MESSAGE_FIELD.to_owned(),
            field_type: FieldType {
                element: Element::Primitive(Primitive::Uint8),
                arity: Arity::One,
            },
            default: None,
            comment: vec!["Always 0: this byte represents an empty message.".to_owned()],
            line: 0,
        });
    }
    Ok(message)
}

/// A declaration on a line.
enum Declared {
    Constant(Constant),
    Field(Field),
}

/// The list to whose end a declaration was added.
#[derive(Clone, Copy)]
enum Kept {
    Constant,
    Field,
}

impl Kept {
    fn comment_in(self, message: &mut Message) -> &mut Vec<String> {
        let comment = match self {
            Self::Constant => message.constants.last_mut().map(|it| &mut it.comment),
            Self::Field => message.fields.last_mut().map(|it| &mut it.comment),
        };
        comment.unwrap_or(&mut message.comment)
    }
}

/// The names used so far.
#[derive(Default)]
struct Names {
    constants: BTreeSet<String>,
    fields: BTreeSet<String>,
}

impl Names {
    /// Adds a declaration to the message, unless its name exists.
    fn keep(&mut self, declared: Declared, message: &mut Message) -> Result<Kept, Rule> {
        let (taken, name) = match &declared {
            Declared::Constant(constant) => (&mut self.constants, &constant.name),
            Declared::Field(field) => (&mut self.fields, &field.name),
        };
        if !taken.insert(name.clone()) {
            return Err(Rule::Duplicate(name.clone()));
        }
        Ok(match declared {
            Declared::Constant(constant) => {
                message.constants.push(constant);
                Kept::Constant
            }
            Declared::Field(field) => {
                message.fields.push(field);
                Kept::Field
            }
        })
    }
}

/// Text of a comment line, without the one space that usually follows `#`.
fn comment_text(after_hash: &str) -> String {
    after_hash
        .strip_prefix(' ')
        .unwrap_or(after_hash)
        .trim_end()
        .to_owned()
}

/// Parses the line of a field or constant in a definition of `package`.
fn declaration(
    package: &str,
    line: &str,
    mut comment: Vec<String>,
    line_number: usize,
) -> Result<Declared, Rule> {
    let not_a_declaration = || Rule::NotADeclaration(line.to_owned());
    let (type_text, rest) = line
        .split_once(char::is_whitespace)
        .ok_or_else(not_a_declaration)?;
    let field_type = parse_type(type_text, package)?;
    let rest = rest.trim_start();
    let name_end = rest
        .find(|c: char| c.is_whitespace() || c == '=' || c == '#')
        .unwrap_or(rest.len());
    let (name, rest) = rest.split_at(name_end);
    if name.is_empty() {
        return Err(not_a_declaration());
    }
    if !is_name(name) {
        return Err(Rule::BadName(name.to_owned()));
    }
    let name = name.to_owned();

    let rest = rest.trim_start();
    let is_constant = rest.starts_with('=');
    let (value, trailing) = split_comment(rest.strip_prefix('=').unwrap_or(rest).trim_start());
    comment.extend(trailing.map(comment_text));

    if is_constant {
        if field_type.arity != Arity::One || matches!(field_type.element, Element::Message(_)) {
            return Err(Rule::BadConstantType(field_type.to_string()));
        }
        Ok(Declared::Constant(Constant {
            name,
            value: parse_value(&field_type, value)?,
            element: field_type.element,
            comment,
        }))
    } else {
        let default = match value {
            "" => None,
            value => Some(parse_value(&field_type, value)?),
        };
        Ok(Declared::Field(Field {
            name,
            field_type,
            default,
            comment,
            line: line_number,
        }))
    }
}

/// Splits a value from the comment after the value. A `#` in a quoted value is text.
fn split_comment(text: &str) -> (&str, Option<&str>) {
    let quoted = match text.chars().next() {
        Some(quote @ ('"' | '\'')) => closing_quote(text, quote).unwrap_or(0),
        _ => 0,
    };
    match text[quoted..].find('#') {
        Some(at) => {
            let (value, comment) = text.split_at(quoted + at);
            (value.trim_end(), Some(&comment[1..]))
        }
        None => (text.trim_end(), None),
    }
}

/// Byte index after the closing quote of the quoted text at the beginning of `text`.
fn closing_quote(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (index, c) in text.char_indices().skip(1) {
        if c == quote && !escaped {
            return Some(index + c.len_utf8());
        }
        escaped = c == '\\' && !escaped;
    }
    None
}

fn parse_type(text: &str, package: &str) -> Result<FieldType, Rule> {
    let (element, arity) = match text.strip_suffix(']') {
        None => (text, Arity::One),
        Some(text) => {
            let (element, size) = text
                .rsplit_once('[')
                .ok_or_else(|| Rule::BadType(text.to_owned()))?;
            let arity = match (size, size.strip_prefix("<=")) {
                ("", _) => Arity::Sequence,
                (_, Some(bound)) => Arity::BoundedSequence(parse_bound(bound)?),
                (size, None) => Arity::Array(parse_bound(size)?),
            };
            (element, arity)
        }
    };
    Ok(FieldType {
        element: parse_element(element, package)?,
        arity,
    })
}

fn parse_element(text: &str, package: &str) -> Result<Element, Rule> {
    if let Some(primitive) = Primitive::parse(text) {
        return Ok(Element::Primitive(primitive));
    }
    let (base, bound) = match text.split_once("<=") {
        Some((base, bound)) => (base, Some(parse_bound(bound)?)),
        None => (text, None),
    };
    match base {
        "string" => Ok(Element::String { wide: false, bound }),
        "wstring" => Ok(Element::String { wide: true, bound }),
        _ if bound.is_some() => Err(Rule::BadType(text.to_owned())),
        _ if is_name(base) => Ok(Element::Message(TypeName::new(package, Kind::Msg, base))),
        _ => TypeName::parse(base)
            .map(Element::Message)
            .ok_or_else(|| Rule::BadType(text.to_owned())),
    }
}

fn parse_bound(text: &str) -> Result<u32, Rule> {
    match text.parse() {
        Ok(bound) if bound > 0 => Ok(bound),
        _ => Err(Rule::BadBound(text.to_owned())),
    }
}

fn parse_value(field_type: &FieldType, text: &str) -> Result<Value, Rule> {
    let bad = || Rule::BadValue {
        value: text.to_owned(),
        expected: field_type.to_string(),
    };
    if field_type.arity == Arity::One {
        return parse_single(&field_type.element, text)?.ok_or_else(bad);
    }
    let inner = text
        .strip_prefix('[')
        .and_then(|text| text.strip_suffix(']'))
        .ok_or_else(bad)?;
    let mut values = Vec::new();
    for item in split_list(inner) {
        values.push(parse_single(&field_type.element, item)?.ok_or_else(bad)?);
    }
    let fits = match field_type.arity {
        Arity::One | Arity::Sequence => true,
        Arity::Array(size) => values.len() == size as usize,
        Arity::BoundedSequence(bound) => values.len() <= bound as usize,
    };
    fits.then_some(Value::List(values)).ok_or_else(bad)
}

/// Items of a list, split at commas outside quotes.
fn split_list(text: &str) -> Vec<&str> {
    let mut items = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let quoted = match rest.chars().next() {
            Some(quote @ ('"' | '\'')) => closing_quote(rest, quote).unwrap_or(0),
            _ => 0,
        };
        match rest[quoted..].find(',') {
            Some(at) => {
                let (item, behind) = rest.split_at(quoted + at);
                items.push(item.trim());
                rest = behind[1..].trim_start();
            }
            None => {
                items.push(rest);
                break;
            }
        }
    }
    items
}

/// Parses a single value; `None` if the text is not a value of this type.
fn parse_single(element: &Element, text: &str) -> Result<Option<Value>, Rule> {
    let primitive = match element {
        Element::Message(_) => return Err(Rule::NoDefault(element.to_string())),
        Element::String { bound, .. } => {
            let value = unquote(text);
            let fits = bound.is_none_or(|bound| value.chars().count() <= bound as usize);
            return Ok(fits.then_some(Value::String(value)));
        }
        Element::Primitive(primitive) => *primitive,
    };
    Ok(match primitive {
        Primitive::Bool => match text.to_ascii_lowercase().as_str() {
            "true" | "1" => Some(Value::Bool(true)),
            "false" | "0" => Some(Value::Bool(false)),
            _ => None,
        },
        Primitive::Float32 | Primitive::Float64 => text.parse().ok().map(Value::Float),
        _ => parse_integer(text)
            .filter(|value| {
                primitive
                    .integer_range()
                    .is_some_and(|(least, greatest)| (least..=greatest).contains(value))
            })
            .map(Value::Integer),
    })
}

/// Parses an integer: decimal, or with the prefix `0x`, `0o` or `0b`, and an optional sign.
fn parse_integer(text: &str) -> Option<i128> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let (radix, digits) = match digits.get(..2) {
        Some("0x" | "0X") => (16, &digits[2..]),
        Some("0o" | "0O") => (8, &digits[2..]),
        Some("0b" | "0B") => (2, &digits[2..]),
        _ => (10, digits),
    };
    if !digits.starts_with(|c: char| c.is_ascii_hexdigit()) {
        return None;
    }
    let value = i128::from_str_radix(digits, radix).ok()?;
    Some(if negative { -value } else { value })
}

/// A string value without its quotes, if it has quotes; a backslash escapes a quote or backslash.
fn unquote(text: &str) -> String {
    let quote = match text.chars().next() {
        Some(quote @ ('"' | '\'')) if closing_quote(text, quote) == Some(text.len()) => quote,
        _ => return text.to_owned(),
    };
    let mut value = String::new();
    let mut escaped = false;
    for c in text[1..text.len() - 1].chars() {
        match c {
            '\\' if !escaped => escaped = true,
            _ => {
                if escaped && c != quote && c != '\\' {
                    value.push('\\');
                }
                value.push(c);
                escaped = false;
            }
        }
    }
    value
}
