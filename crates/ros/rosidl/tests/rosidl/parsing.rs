//! Definitions that the parser accepts, and those that it rejects, with their messages.

use planesman_rosidl::definition::{Arity, Element, Primitive, Value};
use planesman_rosidl::{
    Rule, parse_action, parse_idl_schema, parse_message, parse_schema, parse_service,
};

const EVERYTHING: &str = r#"# A message with everything.
#
#   y = a + b

# A comment that stands alone.

# The first constant.
uint8 FIRST=1
int64 HEX = -0x10    # behind
string GREETING = "it's # not a comment"  # but this is
float64 TINY=1e-3
bool ON = True

std_msgs/Header header
Other other   # same package,
              # on two lines
string<=10 short "abc"
string<=10[<=5] names
uint8[16] id
int32[] numbers [1, 2, 3]
bool[<=2] flags [true, 0]
byte opaque
char letter 65
wstring wide
float32 plain -1.5
type/msg/Qualified type
"#;

#[test]
fn every_construct_of_the_language_is_read() {
    let message = parse_message("my_package", "Everything", EVERYTHING).unwrap();

    assert_eq!(message.name.to_string(), "my_package/msg/Everything");
    assert_eq!(
        message.comment,
        ["A message with everything.", "", "  y = a + b"]
    );
    assert_eq!(message.text, EVERYTHING);

    let constants: Vec<_> = message
        .constants
        .iter()
        .map(|it| (it.name.as_str(), it.value.clone()))
        .collect();
    assert_eq!(
        constants,
        [
            ("FIRST", Value::Integer(1)),
            ("HEX", Value::Integer(-16)),
            ("GREETING", Value::String("it's # not a comment".to_owned())),
            ("TINY", Value::Float(1e-3)),
            ("ON", Value::Bool(true)),
        ]
    );
    assert_eq!(message.constants[0].comment, ["The first constant."]);
    assert_eq!(message.constants[1].comment, ["behind"]);
    assert_eq!(message.constants[2].comment, ["but this is"]);

    let fields: Vec<_> = message
        .fields
        .iter()
        .map(|field| {
            (
                field.name.as_str(),
                field.field_type.to_string(),
                field.default.clone(),
            )
        })
        .collect();
    let list = |values: &[i128]| Value::List(values.iter().copied().map(Value::Integer).collect());
    let field = |name, field_type: &str, default| (name, field_type.to_owned(), default);
    assert_eq!(
        fields,
        [
            field("header", "std_msgs/Header", None),
            field("other", "my_package/Other", None),
            field("short", "string<=10", Some(Value::String("abc".to_owned()))),
            field("names", "string<=10[<=5]", None),
            field("id", "uint8[16]", None),
            field("numbers", "int32[]", Some(list(&[1, 2, 3]))),
            field(
                "flags",
                "bool[<=2]",
                Some(Value::List(vec![Value::Bool(true), Value::Bool(false)]))
            ),
            field("opaque", "byte", None),
            field("letter", "char", Some(Value::Integer(65))),
            field("wide", "wstring", None),
            field("plain", "float32", Some(Value::Float(-1.5))),
            field("type", "type/Qualified", None),
        ]
    );
    assert_eq!(message.fields[1].comment, ["same package,", "on two lines"]);
}

#[test]
fn an_empty_message_has_one_octet() {
    let message = parse_message("p", "Nothing", "# Nothing.\n").unwrap();
    assert_eq!(message.fields.len(), 1);
    assert_eq!(
        message.fields[0].name,
        "structure_needs_at_least_one_member"
    );
    assert_eq!(
        message.fields[0].field_type.element,
        Element::Primitive(Primitive::Uint8)
    );
    assert_eq!(message.fields[0].field_type.arity, Arity::One);
}

#[test]
fn services_and_actions_are_split_at_their_separators() {
    let service = parse_service("p", "Add", "# Adds.\nint64 a\nint64 b\n---\nint64 sum\n").unwrap();
    assert_eq!(service.request.name.to_string(), "p/srv/Add_Request");
    assert_eq!(service.request.comment, ["Adds."]);
    assert_eq!(service.response.fields[0].name, "sum");

    let action = parse_action("p", "Go", "float64 to\r\n---\r\n---\r\nfloat64 at\r\n").unwrap();
    assert_eq!(action.goal.fields[0].name, "to");
    assert_eq!(
        action.result.fields[0].name,
        "structure_needs_at_least_one_member"
    );
    assert_eq!(action.feedback.name.to_string(), "p/action/Go_Feedback");
}

#[test]
fn a_refusal_names_the_file_the_line_and_the_rule() {
    let error = parse_message("p", "M", "float64 x\n\nfloat65 4ever\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "p/msg/M:3: `4ever` is not a name; letters, digits and underscores, starting with a letter, are expected"
    );
    let error = parse_service("p", "S", "int8 a\n---\nint8 b 200\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "p/srv/S:3: `200` is not a value of type int8"
    );
}

#[test]
fn what_breaks_a_rule_is_refused_by_that_rule() {
    let refusal = |line: &str| parse_message("p", "M", line).unwrap_err().rule;
    let text = str::to_owned;
    let value = |value: &str, expected: &str| Rule::BadValue {
        value: text(value),
        expected: text(expected),
    };

    assert_eq!(refusal("float64"), Rule::NotADeclaration(text("float64")));
    assert_eq!(
        refusal("float64 # x"),
        Rule::NotADeclaration(text("float64 # x"))
    );
    assert_eq!(refusal("a/b/c/d x"), Rule::BadType(text("a/b/c/d")));
    assert_eq!(refusal("int8<=3 x"), Rule::BadType(text("int8<=3")));
    assert_eq!(refusal("int8[0] x"), Rule::BadBound(text("0")));
    assert_eq!(
        refusal("int8[99999999999] x"),
        Rule::BadBound(text("99999999999"))
    );
    assert_eq!(refusal("string<=-1 x"), Rule::BadBound(text("-1")));
    assert_eq!(refusal("uint8 X=256"), value("256", "uint8"));
    assert_eq!(refusal("uint8 X="), value("", "uint8"));
    assert_eq!(refusal("uint8 X=+-1"), value("+-1", "uint8"));
    assert_eq!(refusal("bool x maybe"), value("maybe", "bool"));
    assert_eq!(refusal("int8[2] x [1]"), value("[1]", "int8[2]"));
    assert_eq!(refusal("string<=2 x abc"), value("abc", "string<=2"));
    assert_eq!(refusal("int8[] X=1"), Rule::BadConstantType(text("int8[]")));
    assert_eq!(refusal("Other X=1"), Rule::BadConstantType(text("p/Other")));
    assert_eq!(refusal("Other x 1"), Rule::NoDefault(text("p/Other")));
    assert_eq!(refusal("int8 x\nint8 x"), Rule::Duplicate(text("x")));
    assert_eq!(
        parse_action("p", "A", "int8 x\n---\n").unwrap_err().rule,
        Rule::Separators {
            found: 1,
            expected: 2
        }
    );
    assert_eq!(
        parse_message("../p", "M", "").unwrap_err().rule,
        Rule::BadName(text("../p"))
    );
}

#[test]
fn a_schema_is_read_with_all_its_sections() {
    let separator = "=".repeat(80);
    let text = format!(
        "A a\nB[] b\n\n{separator}\nMSG: q/B\nfloat64 x\n{separator}\nMSG: p/msg/A\nq/B b\n"
    );
    let library = parse_schema("p/msg/Root", &text).unwrap_err();
    assert_eq!(
        library.to_string(),
        "schema of p/msg/Root:2: p/msg/B is not defined"
    );

    let library = parse_schema("p/msg/Root", &text.replace("B[] b", "q/B[] b")).unwrap();
    let names: Vec<_> = library
        .messages()
        .map(|message| message.name.to_string())
        .collect();
    assert_eq!(names, ["p/msg/A", "p/msg/Root", "q/msg/B"]);
}

#[test]
fn a_schema_that_bites_its_tail_or_goes_too_deep_is_refused() {
    let separator = "=".repeat(80);
    let own_tail = parse_schema("p/msg/A", "A[] a\n").unwrap_err();
    assert_eq!(own_tail.rule, Rule::Recursive("p/msg/A".to_owned()));

    let ring = format!("B b\n{separator}\nMSG: p/B\nA[] a\n");
    let ring = parse_schema("p/msg/A", &ring).unwrap_err();
    assert!(matches!(ring.rule, Rule::Recursive(_)));

    // T0 holds T1, which holds T2, and so on: ten thousand deep, and in both orders of name.
    for name in [
        |i: usize| format!("T{i:05}"),
        |i: usize| format!("T{:05}", 20_000 - i),
    ] {
        let mut text = format!("{} x\n", name(1));
        for i in 1..10_000 {
            text.push_str(&format!(
                "{separator}\nMSG: p/{}\n{} x\n",
                name(i),
                name(i + 1)
            ));
        }
        text.push_str(&format!("{separator}\nMSG: p/{}\nint8 x\n", name(10_000)));
        let error = parse_schema(&format!("p/msg/{}", name(0)), &text).unwrap_err();
        assert_eq!(error.rule, Rule::TooDeep);
    }
}

#[test]
fn a_schema_made_to_hurt_is_refused_or_has_a_hash() {
    let parsed = |text: &str| parse_schema("a/msg/A", text);
    let msg = planesman_testing::hostile::schemas();
    for (case, text) in msg.into_iter().chain(planesman_testing::hostile::lists()) {
        if let Ok(library) = parsed(&text) {
            let root = library.messages().find(|it| it.name.name == "A").unwrap();
            assert!(library.type_hash(&root.name).is_ok(), "{case}");
        }
    }
    for (case, text) in planesman_testing::hostile::idl() {
        assert!(parse_idl_schema("a/msg/A", &text).is_err(), "{case}");
    }
}

#[test]
fn a_wide_schema_whose_paths_multiply_is_read_once() {
    // Every Ti holds two T(i+1): 2^40 paths, forty definitions.
    let separator = "=".repeat(80);
    let mut text = "T1 a\nT1 b\n".to_owned();
    for i in 1..40 {
        text.push_str(&format!(
            "{separator}\nMSG: p/T{i}\nT{next} a\nT{next} b\n",
            next = i + 1
        ));
    }
    text.push_str(&format!("{separator}\nMSG: p/T40\nint8 x\n"));
    let library = parse_schema("p/msg/T0", &text).unwrap();
    assert_eq!(library.messages().count(), 41);
    let root = &library.messages().next().unwrap().name;
    assert!(library.type_hash(root).unwrap().starts_with("RIHS01_"));
    assert_eq!(library.schema(root).unwrap().matches("MSG: ").count(), 40);
}

#[test]
fn no_text_makes_the_parser_panic() {
    // Every prefix, and the text with each byte replaced by each of the characters that mean something.
    let separator = "=".repeat(80);
    let text = format!("{EVERYTHING}---\n{separator}\nMSG: std_msgs/Header\nuint32 seq\n");
    let parse = |text: &str| {
        let _ = parse_message("p", "M", text);
        let _ = parse_service("p", "M", text);
        let _ = parse_action("p", "M", text);
        let _ = parse_schema("p/msg/M", text);
    };
    for (end, _) in text.char_indices() {
        parse(&text[..end]);
    }
    for (at, old) in text.char_indices() {
        for new in [
            "#", "=", "[", "]", "<", "\"", "'", "\\", "\n", " ", "-", "0", "\u{e9}", "",
        ] {
            parse(&format!(
                "{}{new}{}",
                &text[..at],
                &text[at + old.len_utf8()..]
            ));
        }
    }
}
