//! Hashes, schema texts and the types derived from services and actions.

use planesman_rosidl::{Library, TypeName, parse_action, parse_message, parse_service, rust};

/// The three standard messages that services and actions refer to.
fn library() -> Library {
    let mut library = Library::new();
    for (package, name, text) in [
        ("builtin_interfaces", "Time", "int32 sec\nuint32 nanosec\n"),
        ("unique_identifier_msgs", "UUID", "uint8[16] uuid\n"),
        (
            "service_msgs",
            "ServiceEventInfo",
            "uint8 event_type\nbuiltin_interfaces/Time stamp\nchar[16] client_gid\nint64 sequence_number\n",
        ),
    ] {
        library
            .add_message(parse_message(package, name, text).unwrap())
            .unwrap();
    }
    library
}

fn hash(library: &Library, name: &str) -> String {
    library.type_hash(&TypeName::parse(name).unwrap()).unwrap()
}

#[test]
fn the_hashed_text_is_that_of_rep_2016() {
    let library = library();
    let name = TypeName::parse("builtin_interfaces/msg/Time").unwrap();
    assert_eq!(
        library.type_description(&name).unwrap(),
        concat!(
            r#"{"type_description": {"type_name": "builtin_interfaces/msg/Time", "fields": ["#,
            r#"{"name": "sec", "type": {"type_id": 6, "capacity": 0, "string_capacity": 0, "nested_type_name": ""}}, "#,
            r#"{"name": "nanosec", "type": {"type_id": 7, "capacity": 0, "string_capacity": 0, "nested_type_name": ""}}"#,
            r#"]}, "referenced_type_descriptions": []}"#
        )
    );
}

#[test]
fn example_interfaces_add_two_ints_has_its_published_hash() {
    let mut library = library();
    let text = "int64 a\nint64 b\n---\nint64 sum\n";
    library
        .add_service(parse_service("example_interfaces", "AddTwoInts", text).unwrap())
        .unwrap();
    assert_eq!(
        hash(&library, "example_interfaces/srv/AddTwoInts"),
        "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
    );
}

#[test]
fn an_action_and_all_its_parts_have_the_hashes_that_rosidl_generates() {
    // An action found in the wild with the C code that rosidl made of it.
    let mut library = library();
    let text = "float32 v_x\nfloat32 w_z\nfloat32 drive_time\n---\nbool complete\n---\nfloat32 percent_complete\n";
    library
        .add_action(parse_action("action_interface", "Robot", text).unwrap())
        .unwrap();
    for (suffix, expected) in [
        (
            "",
            "a9ce30d15eac1be29293ca8cb9d93d8508c12d25c1c12ecd5b0324f8b3abe170",
        ),
        (
            "_Goal",
            "1d158c99d62fcbd045e273e790d3d02c4da243e72f5469d355801a1b3d0228f6",
        ),
        (
            "_Result",
            "539f3f1581d0cbbdbd2aef6a9002cb46415e0abd0e13c1c1d2cea5d8c38ff8ab",
        ),
        (
            "_Feedback",
            "665ba93aba0b2dbf62787affcd3c56d1469165918e8ded3c8f64eaa78a0331a2",
        ),
        (
            "_SendGoal",
            "a730a044ea9337e18872f217680af0970e25dd7768f78267e346f7198212de35",
        ),
        (
            "_SendGoal_Request",
            "a5c8d275bd328d61b8b578f62bf1f864a2c46654281880ab3e36e78092d5e5c7",
        ),
        (
            "_SendGoal_Response",
            "7ce89fffc375c30c9c14bab533a5c0ee08b98e48f640570ae8ce242e5770471b",
        ),
        (
            "_SendGoal_Event",
            "1b42804e2d86cc02efeefc3d5023e6145887aa6881d7b6d1aa489a6fde324935",
        ),
        (
            "_GetResult",
            "2d26d6e8299fafb4530a9a7f7901cec759fcffc9d766c858da47072300eda00d",
        ),
        (
            "_GetResult_Request",
            "585918498cbf06f0421e53f3df54962e3e3201fc584b11b5cb5e100858291805",
        ),
        (
            "_GetResult_Response",
            "e0387757e3ff274ee8a6aff2d1339ce986dc3c20537e180d57c40da38d673d13",
        ),
        (
            "_GetResult_Event",
            "6e0eef245e8a3847f003cfe7eee01c1cfab5508f6525d1019a7ec967de508f58",
        ),
        (
            "_FeedbackMessage",
            "50dfa96f0255adcc46c0e4517fa757f2090bff34b75b7a6055de4f4b1d994b8d",
        ),
    ] {
        assert_eq!(
            hash(&library, &format!("action_interface/action/Robot{suffix}")),
            format!("RIHS01_{expected}"),
            "Robot{suffix}"
        );
    }
}

#[test]
fn the_schema_text_is_what_rosbag2_writes() {
    let mut library = library();
    let header = "builtin_interfaces/Time stamp\nstring frame_id\n";
    library
        .add_message(parse_message("std_msgs", "Header", header).unwrap())
        .unwrap();
    let text = "std_msgs/Header header\nbuiltin_interfaces/Time[] more\n";
    library
        .add_message(parse_message("p", "M", text).unwrap())
        .unwrap();

    let separator = "=".repeat(80);
    let schema = library
        .schema(&TypeName::parse("p/msg/M").unwrap())
        .unwrap();
    // Depth first, references in order of name, each once.
    assert_eq!(
        schema,
        format!(
            "{text}\n{separator}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
             \n{separator}\nMSG: std_msgs/Header\n{header}"
        )
    );

    let read = planesman_rosidl::parse_schema("p/msg/M", &schema).unwrap();
    assert_eq!(hash(&read, "p/msg/M"), hash(&library, "p/msg/M"));
}

#[test]
fn names_follow_the_dds_mapping() {
    let name = TypeName::parse("std_msgs/Header").unwrap();
    assert_eq!(name.dds(), "std_msgs::msg::dds_::Header_");
    let request = TypeName::parse("std_srvs/srv/SetBool")
        .unwrap()
        .derived("Request");
    assert_eq!(request.dds(), "std_srvs::srv::dds_::SetBool_Request_");
    for bad in ["Header", "a/b/c", "a/msg/b/c", "a/msg/", "/a", "a/msg/b c"] {
        assert_eq!(TypeName::parse(bad), None, "{bad}");
    }
}

#[test]
fn keywords_defaults_and_long_arrays_become_rust() {
    let mut library = Library::new();
    let text = "# Bounds are \u{2265} [0] <T> *a*.\nuint8 type 3\nbool self\nfloat64[36] big\nint8[2] pair [1, -1]\n\
                string word \"a\\\"b\"\nuint8 CONST=7\n";
    library
        .add_message(parse_message("p", "M", text).unwrap())
        .unwrap();
    let source = rust::generate(&library).unwrap();
    for part in [
        "/// Bounds are \u{2265} \\[0\\] \\<T\\> \\*a\\*.",
        "pub r#type: u8,",
        "#[serde(rename = \"self\")]\n    pub self_: bool,",
        "#[serde(with = \"serde_big_array::BigArray\")]\n    pub big: [f64; 36],",
        "r#type: 3,",
        "pair: [1, -1],",
        "word: \"a\\\"b\".to_owned(),",
        "pub const CONST: u8 = 7;",
        "crate::finite::field(\"big\", &self.big)",
    ] {
        assert!(source.contains(part), "no {part:?} in:\n{source}");
    }
}

#[test]
fn definitions_that_rust_cannot_have_are_refused() {
    let mut library = Library::new();
    library
        .add_message(parse_message("p", "M", "wstring w\n").unwrap())
        .unwrap();
    let error = rust::generate(&library).unwrap_err();
    assert_eq!(
        error.to_string(),
        "p/msg/M:1: no Rust code can be generated for wstring"
    );

    let mut library = Library::new();
    library
        .add_message(parse_message("p", "M", "\nOther o\n").unwrap())
        .unwrap();
    let error = rust::generate(&library).unwrap_err();
    assert_eq!(error.to_string(), "p/msg/M:2: p/msg/Other is not defined");
    let again = library
        .add_message(parse_message("p", "M", "").unwrap())
        .unwrap_err();
    assert_eq!(again.to_string(), "p/msg/M: `p/msg/M` is defined twice");
}
