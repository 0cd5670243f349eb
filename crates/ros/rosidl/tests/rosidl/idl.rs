//! IDL as rosidl and rosbag2 write it is read as the `.msg` files it was made of are.

use planesman_rosidl::{Library, parse_idl_schema, parse_schema};

/// The fields of every message, without comments and lines.
fn fields(library: &Library) -> Vec<(String, Vec<(String, String)>)> {
    library
        .messages()
        .map(|message| {
            let fields = &message.fields;
            let fields = fields
                .iter()
                .map(|it| (it.name.clone(), it.field_type.to_string()));
            (message.name.to_string(), fields.collect())
        })
        .collect()
}

fn separator() -> String {
    "=".repeat(80)
}

/// A section as rosbag2 writes it, with a text as `rosidl_adapter` writes it.
fn section(package: &str, name: &str, body: &str) -> String {
    format!(
        "{}\nIDL: {package}/msg/{name}\n\
         // generated from rosidl_adapter/resource/msg.idl.em\n\
         // with input from {package}/msg/{name}.msg\n\n\
         #include \"builtin_interfaces/msg/Time.idl\"\n\n\
         module {package} {{\n  module msg {{\n{body}\n  }};\n}};\n\n",
        separator()
    )
}

#[test]
fn what_rosidl_makes_of_a_definition_is_the_definition() {
    let msg = format!(
        "a/Header header\n\
         float64[9] covariance\n\
         float32[] ranges\n\
         uint8[<=3] few\n\
         a/Header[2] pair\n\
         a/Header[] many\n\
         string name\n\
         string<=10 short\n\
         wstring wide\n\
         string<=5[<=4] texts\n\
         bool flag\nbyte raw\nchar c\nint8 i8\nuint8 u8\nint16 i16\nuint16 u16\n\
         int32 i32\nuint32 u32\nint64 i64\nuint64 u64\nfloat32 f\nfloat64 d\n\
         {0}\nMSG: a/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
         {0}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
         ",
        separator()
    );
    let idl = section(
        "a",
        "Reading",
        r#"    typedef double double__9[9];
    typedef a::msg::Header a__msg__Header[2];
    module Reading_Constants {
      @verbatim (language="comment", text=
        "How many; (see \"struct\" { below" "\n" "and so on")
      const uint8 LIMIT = 3;
      const string GREETING = "hello } ;";
      const double NEGATIVE = -1.5;
    };
    @verbatim (language="comment", text=
      "A reading.")
    struct Reading {
      @unit (value="m")
      a::msg::Header header;

      double__9 covariance;
      sequence<float> ranges;
      sequence<uint8, 3> few;
      a__msg__Header pair;
      sequence<a::msg::Header> many;
      @default (value="it's")
      string name;
      string<10> short;
      wstring wide;
      sequence<string<5>, 4> texts;
      boolean flag;
      octet raw;
      @key char c;
      int8 i8;
      uint8 u8;
      int16 i16;
      uint16 u16;
      int32 i32;
      uint32 u32;
      int64 i64;
      uint64 u64;
      float f;
      double d;
    };"#,
    ) + &section(
        "a",
        "Header",
        "    struct Header {\n      builtin_interfaces::msg::Time stamp;\n      string frame_id;\n    };",
    ) + &section(
        "builtin_interfaces",
        "Time",
        "    struct Time {\n      int32 sec;\n      uint32 nanosec;\n    };",
    );
    let from_msg = parse_schema("a/msg/Reading", &msg).unwrap();
    let from_idl = parse_idl_schema("a/msg/Reading", &idl).unwrap();
    assert_eq!(fields(&from_idl), fields(&from_msg));
}

#[test]
fn idl_written_by_hand_is_read_too() {
    let idl = "module a { module msg {\n\
        enum Mode { OFF, ON };\n\
        const unsigned long SIZE = 3;\n\
        typedef sequence<double> Curve; /* a\n course */\n\
        struct Point { double x, y; };\n\
        struct Empty { };\n\
        struct A { Mode mode; Point p[2][3]; Curve curve; msg::Point q; ::a::msg::Point r; long long n[SIZE];\n\
          unsigned long long u; unsigned short s; short _struct; string<SIZE> t; Empty e; };\n\
        }; };";
    let msg = format!(
        "uint32 mode\nPoint[6] p\nfloat64[] curve\nPoint q\nPoint r\nint64[3] n\nuint64 u\n\
         uint16 s\nint16 struct\nstring<=3 t\nEmpty e\n{0}\nMSG: a/Point\nfloat64 x\nfloat64 y\n\
         {0}\nMSG: a/Empty\n",
        separator()
    );
    assert_eq!(
        fields(&parse_idl_schema("a/msg/A", idl).unwrap()),
        fields(&parse_schema("a/msg/A", &msg).unwrap())
    );
}

#[test]
fn what_is_no_such_idl_is_refused_with_its_line() {
    let within =
        |body: &str| format!("module a {{ module msg {{\nstruct A {{\n{body}\n}};\n}}; }};");
    for (text, line, reason) in [
        (String::new(), 0, "a/msg/A is not defined"),
        (within("double x"), 4, "`}`"),
        (within("Missing x;"), 3, "Missing is not defined"),
        (within("sequence<sequence<double>> x;"), 3, "`sequence`"),
        (within("long double x;"), 3, "`long double`"),
        (within("map<string, long> x;"), 3, "`map`"),
        (within("sequence<double> x[3];"), 3, "a list of lists"),
        (within("double x[0];"), 3, "not a bound"),
        (within("double x[4294967295][2];"), 3, "not a bound"),
        (within("double x[N];"), 3, "not a bound"),
        (within("A self;"), 0, "contains itself"),
        (within("double x[2];\ndouble x;"), 4, "`x` is defined twice"),
        (within("\"x"), 3, "a quote without end"),
        ("module a {".repeat(100), 1, "more than 64 deep"),
        (
            "module a { module msg { typedef x x; struct A { x y; }; }; };".to_owned(),
            1,
            "64 deep",
        ),
        ("union U switch (long) {};".to_owned(), 1, "`union`"),
        (
            "module a { @verbatim (text=".to_owned(),
            1,
            "the end of the text",
        ),
    ] {
        let refusal = parse_idl_schema("a/msg/A", &text).unwrap_err();
        assert!(refusal.to_string().contains(reason), "{refusal}");
        assert_eq!(refusal.line, line, "{refusal}");
    }
}
