//! Data made to hurt, each kind for every layer that reads it: bags for the bag reader and the program, schemas for the parser,
//! the decoder and the program, tables for their reader and the program, YAML for its parser, the scenario and the bag's
//! metadata. The fuzz targets begin with those cases that are short.
//!
//! A case is its name and its content. No reader may panic, hang, or take memory by what a case claims to hold.

use std::io::Write as _;

use rand::{Rng, RngExt as _};

use crate::mcap::{MAGIC, beginning, channel, chunk, lying_record, message, record, schema, sized};

/// A case: its name and its content.
pub type Case<T> = (&'static str, T);

/// The bytes with a few changed, taken out, repeated, or cut off.
pub fn mutated(bytes: &[u8], random: &mut impl Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.random_range(1..5) {
        if bytes.is_empty() {
            break;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..8) {
            0 => bytes.truncate(at),
            1 => drop(bytes.remove(at)),
            2 => {
                let piece: Vec<u8> = bytes[at..].iter().copied().take(30).collect();
                bytes.splice(at..at, piece);
            }
            3 => bytes[at] = 0xff,
            4 => bytes[at] = 0,
            _ => bytes[at] = random.random(),
        }
    }
    bytes
}

/// Records that lie about their lengths or contents, to stand between [`beginning`] and [`end`](crate::mcap::end), or with nothing behind them.
pub fn records() -> Vec<Case<Vec<u8>>> {
    const MANY: usize = 32 << 20;
    let zeros = vec![0; MANY];
    let zstd = zstd::encode_all(&zeros[..], 1).unwrap();
    let lz4 = |bytes: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let few = lz4(&zeros[..2 << 20]);
    // Half a million messages of no bytes in one chunk.
    let mut tiny = [
        schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n"),
        channel(1, 1, "/cmd", "cdr"),
    ]
    .concat();
    let one = message(1, 7, &[]);
    tiny.extend(one.iter().copied().cycle().take(500_000 * one.len()));
    let packed = zstd::encode_all(&tiny[..], 1).unwrap();
    let big = |compression: &str, claimed: usize, packed: &[u8]| {
        chunk(compression, claimed as u64, packed.len() as u64, packed)
    };
    vec![
        ("record", lying_record(6, u64::MAX, b"abc")),
        (
            "record within the limit",
            lying_record(5, 100 << 20, b"abc"),
        ),
        ("attachment", lying_record(9, u64::MAX, b"abc")),
        (
            "attachment within the file's length",
            lying_record(9, 3, b"abc"),
        ),
        ("metadata", record(0x0C, &u32::MAX.to_le_bytes())),
        ("unknown record", lying_record(0x99, 1 << 40, b"abc")),
        ("no record", vec![0; 4096]),
        (
            "schema",
            record(3, &[&[1, 0][..], &u32::MAX.to_le_bytes()].concat()),
        ),
        (
            "channel",
            record(
                4,
                &[
                    &[1, 0, 0, 0][..],
                    &sized("/a"),
                    &sized("cdr"),
                    &u32::MAX.to_le_bytes(),
                ]
                .concat(),
            ),
        ),
        ("message without a head", record(5, &[1, 0, 7])),
        ("message of no channel", message(9, 0, &[0; 40])),
        ("channel of no schema", channel(1, 9, "/a", "cdr")),
        ("chunk that claims less", big("zstd", 100, &zstd)),
        ("chunk that claims more", big("zstd", MANY + 1, &zstd)),
        ("chunk that claims far more", big("zstd", usize::MAX, &zstd)),
        ("chunk of zeros", big("zstd", MANY, &zstd)),
        ("lz4 chunk that claims less", big("lz4", 100, &few)),
        ("lz4 chunk that claims more", big("lz4", MANY, &few)),
        ("lz4 chunk of zeros", big("lz4", 2 << 20, &few)),
        (
            "chunk of something else",
            big("zstd", 100, b"no frame at all"),
        ),
        (
            "chunk in a chunk",
            big("", one.len(), &chunk("", 9, 9, &[0; 9])),
        ),
        ("chunk of many messages", big("zstd", tiny.len(), &packed)),
        ("chunk of unknown packing", big("brotli", 9, &[0; 9])),
        ("attachment without a body", record(9, &[])),
        (
            "chunk that claims more than it has",
            chunk("", 100, 100, &[0; 9]),
        ),
        (
            "chunk whose packing acts on a terminal",
            chunk("br\u{7}", 9, 9, &[0; 9]),
        ),
        (
            "chunk whose record overruns it",
            chunk("", 9, 9, &[5, 255, 255, 255, 0, 0, 0, 0, 0]),
        ),
    ]
}

/// Whole files whose index lies: where the summary starts, or what it counts.
pub fn indexes() -> Vec<Case<Vec<u8>>> {
    let at = |start: u64| {
        let footer = record(0x02, &[&start.to_le_bytes()[..], &[0; 12]].concat());
        [&beginning(), &record(0x0F, &[0; 4]), &footer, MAGIC].concat()
    };
    let float = || schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data\n");
    let data = [
        beginning(),
        float(),
        channel(1, 1, "/cmd", "cdr"),
        message(1, 0, &[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        record(0x0F, &[0; 4]),
    ]
    .concat();
    // A summary of other topics and counts than there are.
    let counts = |name: &str, count: u64| {
        let mut statistics = count.to_le_bytes().to_vec();
        statistics.extend([0; 2 + 16 + 16]);
        statistics.extend(sized(
            [&1_u16.to_le_bytes()[..], &count.to_le_bytes()].concat(),
        ));
        let summary = [
            float(),
            channel(1, 1, name, "cdr"),
            record(0x0B, &statistics),
        ]
        .concat();
        let start = (data.len() as u64).to_le_bytes();
        let footer = record(0x02, &[&start[..], &[0; 12]].concat());
        [&data, &summary, &footer, MAGIC].concat()
    };
    vec![
        ("index at 1", at(1)),
        ("index at 8", at(8)),
        ("index at 30", at(30)),
        ("index at 40", at(40)),
        ("index beyond the file", at(1 << 40)),
        ("index beyond all", at(u64::MAX)),
        ("summary that is right", counts("/cmd", 1)),
        (
            "summary of more messages than can be",
            counts("/cmd", u64::MAX),
        ),
        ("summary of another topic", counts("/imu", 1)),
        (
            "summary of another topic without messages",
            counts("/imu", 0),
        ),
    ]
}

/// Texts of `.msg` files with the types that they contain, as bags hold them; of the type `a/msg/A`.
pub fn schemas() -> Vec<Case<String>> {
    let line = "=".repeat(80);
    let nested = |depth: usize, reference: &str| {
        let mut text = String::new();
        for level in 0..depth {
            if level > 0 {
                text += &format!("{line}\nMSG: a/L{level}\n");
            }
            text += &format!("L{}{reference} x\n", level + 1);
        }
        text + &format!("{line}\nMSG: a/L{depth}\nfloat64 x\n")
    };
    let many = |what: &str, count: usize| what.repeat(count);
    vec![
        ("recursive", "A a\nfloat64 x\n".to_owned()),
        ("recursive list", "A[] a\n".to_owned()),
        (
            "recursive in a ring",
            format!("B b\n{line}\nMSG: a/B\nA a\n"),
        ),
        ("deep", nested(60, "")),
        ("deeper than any", nested(9000, "")),
        ("deep lists", nested(60, "[]")),
        ("lists whose size overflows", nested(20, "[4294967295]")),
        (
            "a list of all numbers",
            "float64[4294967295] x\n".to_owned(),
        ),
        (
            "a list of more than all",
            "float64[99999999999999999999] x\n".to_owned(),
        ),
        ("a list of lists", "float64[3][3] x\n".to_owned()),
        (
            "a bound beyond all",
            "string<=99999999999999999999 x\n".to_owned(),
        ),
        (
            "a name of a megabyte",
            format!("float64 {}\n", many("x", 1 << 20)),
        ),
        (
            "a line of many brackets",
            format!("float64{} x\n", many("[", 1_000_000)),
        ),
        (
            "many fields",
            (0..60_000).map(|k| format!("float64 x{k}\n")).collect(),
        ),
        (
            "many empty types",
            (0..9000)
                .map(|k| format!("{line}\nMSG: a/T{k}\n"))
                .collect(),
        ),
        ("fields of one name", many("float64 x\n", 1000)),
        ("nothing", String::new()),
        ("no text", "\0\u{1}\u{7f}\n".to_owned()),
        ("more than is taken", many("# \n", 1_000_000)),
        ("a type that is not there", "b/B x\n".to_owned()),
        (
            "an odd default",
            "float64 x 1e999999\nint8 y 300\n".to_owned(),
        ),
        ("a bush of numbers", bush("", "float64")),
        ("a bush of texts", bush("", "string")),
        ("a bush of lists", bush("[]", "float64")),
        ("a bush of arrays of bytes", bush("[4294967295]", "uint8")),
        ("a bush of arrays of texts", bush("[4294967295]", "string")),
    ]
}

/// A type nested 60 deep, each level holding the next eight times: 8^59 leaves.
pub fn bush(reference: &str, leaf: &str) -> String {
    let mut text = String::new();
    for level in 0..60 {
        if level > 0 {
            text += &format!("{}\nMSG: a/L{level}\n", "=".repeat(80));
        }
        for field in 0..8 {
            if level < 59 {
                text += &format!("L{}{reference} f{field}\n", level + 1);
            } else {
                text += &format!("{leaf} f{field}\n");
            }
        }
    }
    text
}

/// Texts of `.idl` files, of the type `a/msg/A`.
pub fn idl() -> Vec<Case<String>> {
    let many = |what: &str, count: usize| what.repeat(count);
    vec![
        ("no idl", "float64 x\n".to_owned()),
        ("a million modules", many("module a { ", 90_000)),
        (
            "a million sequences",
            format!(
                "module a {{ module msg {{ struct A {{ {}double{} x; }}; }}; }};",
                many("sequence<", 90_000),
                many(">", 90_000)
            ),
        ),
        (
            "two fields of one name",
            "module a { module msg { struct A { double x[2]; double x; }; }; };".to_owned(),
        ),
        (
            "types of themselves",
            "module a { module msg { typedef B C; typedef C B; struct A { B x; }; }; };".to_owned(),
        ),
        (
            "a struct of itself",
            "module a { module msg { struct A { A x; }; }; };".to_owned(),
        ),
        (
            "arrays of arrays",
            format!(
                "module a {{ module msg {{ struct A {{ double x{}; }}; }}; }};",
                many("[65535]", 50_000)
            ),
        ),
        (
            "a comment without an end",
            "/* ".to_owned() + &many("*", 1_000_000),
        ),
        (
            "a text without an end",
            "module a { @verbatim(text=\"".to_owned(),
        ),
        ("many annotations", many("@a(", 200_000)),
        (
            "a size that is a sum",
            format!(
                "module a {{ module msg {{ struct A {{ double x[{}1]; }}; }}; }};",
                many("1+", 300_000)
            ),
        ),
    ]
}

/// Types with a list or a text whose length a payload claims.
pub fn lists() -> Vec<Case<String>> {
    let line = "=".repeat(80);
    let empties = format!("B[] b\nfloat64 x\n{line}\nMSG: a/B\n");
    let nested = format!(
        "B[] b\nfloat64 x\n{line}\nMSG: a/B\nC[] c\n{line}\nMSG: a/C\nstring[] s\nfloat64[] y\n"
    );
    vec![
        ("a list", "float64[] v\nfloat64 x\n".to_owned()),
        ("a text", "string s\nfloat64 x\n".to_owned()),
        ("a wide text", "wstring s\nfloat64 x\n".to_owned()),
        ("a list of texts", "string[] s\nfloat64 x\n".to_owned()),
        ("a list of nothing", empties),
        ("lists in lists", nested),
    ]
}

/// Payloads in CDR whose first number, taken for a length, is from right to beyond all.
pub fn payloads() -> Vec<Vec<u8>> {
    let payload = |numbers: &[u32]| {
        let mut bytes = vec![0, 1, 0, 0];
        numbers.iter().for_each(|it| bytes.extend(it.to_le_bytes()));
        bytes
    };
    let lengths = [
        0,
        1,
        2,
        3,
        255,
        1 << 28,
        1 << 29,
        u32::MAX / 8,
        u32::MAX / 2,
        u32::MAX,
    ];
    let mut payloads: Vec<Vec<u8>> = lengths
        .iter()
        .flat_map(|length| {
            [
                payload(&[*length]),
                payload(&[*length; 1000]),
                payload(&[*length, 1, 2, 3, 4, 5, 6, 7, 8]),
            ]
        })
        .collect();
    // A list that is as long as it says.
    payloads.push(payload(&[&[2_000_000][..], &vec![1; 4_000_004]].concat()));
    payloads.extend([vec![], vec![0, 1]]);
    payloads
}

/// Rows of a table with the columns `t`, `u` and `y`, as they should be.
pub fn rows(count: usize) -> String {
    (0..count)
        .map(|k| {
            let t = k as f64;
            format!("{},{},{}\n", t * 0.1, libm::sin(t), libm::cos(t))
        })
        .collect()
}

/// CSV tables.
pub fn tables() -> Vec<Case<Vec<u8>>> {
    vec![
        ("empty", Vec::new()),
        ("a header only", b"t,u,y\n".to_vec()),
        ("no header", rows(50).into_bytes()),
        ("a line without an end", vec![b'9'; 3 << 20]),
        ("a header without an end", vec![b','; 3 << 20]),
        ("many columns", [&b"t,u,y"[..], &b",x".repeat(400_000), b"\n1,2,3\n"].concat()),
        ("many columns with names", (0..100_000).map(|k| format!("c{k},")).collect::<String>().into_bytes()),
        ("names that colour, move and retitle", ["t,u,y,\u{1b}[31m,\u{1b}]0;x\u{7},\u{9b}2J,\r,\u{202e}\n", &rows(50)].concat().into_bytes()),
        ("zeros", vec![0; 4 << 20]),
        ("zeros in a row", ["t,u,y\n", &rows(50), "0,\0\0,\0\n", &rows(50)].concat().into_bytes()),
        ("no UTF-8", [b"t,u,y\n", rows(50).as_bytes(), &[0xff, 0xfe, b',', 0xc3, b',', b'1', b'\n']].concat()),
        ("names that are no UTF-8", [&[b't', b',', 0xff, b',', 0xc3, b'\n'], rows(50).as_bytes()].concat()),
        ("UTF-16", "t,u,y\n1,2,3\n".encode_utf16().flat_map(u16::to_le_bytes).collect()),
        ("a quote without an end", [b"t,u,y\n\"", &rows(100_000).into_bytes()[..]].concat()),
        ("quotes", b"\"".repeat(1_000_000)),
        ("returns", ["t,u,y\r\n", &rows(50).replace('\n', "\r")].concat().into_bytes()),
        ("blank lines", [&b"t,u,y\n"[..], &b"\n".repeat(1_000_000)].concat()),
        ("times beyond all", "t,u,y\n1e308,1,1\n-1e308,1,1\n9223372036,1,1\n-9223372036,2,2\n99999999999999999999,1,1\n".into()),
        ("times that are none", "t,u,y\nnan,1,1\ninf,1,1\n,1,1\n".into()),
        ("values beyond all", "t,u,y\n0,1e999,-1e999\n0.1,nan,inf\n0.2,1e308,1e308\n0.3,5e-324,0\n".into()),
        ("time that goes back", ["t,u,y\n", &rows(50), &rows(50)].concat().into_bytes()),
        ("cells of every kind", "time,u,y\n0,1,2\n0.1,,3\n0.2,x,4\n\"0.3\",nan,6\n1e0,2,7\n".into()),
        ("semicolons behind a mark", "\u{feff}\"t\";a;b\n0;1;2\n1;2;3\n2;3;4\n3;4;5\n".into()),
        ("a picture", [&b"\x89PNG\r\n\x1a\n"[..], &[7; 5000]].concat()),
    ]
}

/// YAML documents: no reader takes one of them.
pub fn yaml() -> Vec<Case<String>> {
    let many = |part: &str| part.repeat((1 << 20) / part.len() - 1);
    let ten = |of: &str| [of; 10].join(", ");
    let bomb = |levels: usize| {
        let mut text = format!("a0: &a0 [{}]\n", ten("x"));
        for k in 1..levels {
            text += &format!("a{k}: &a{k} [{}]\n", ten(&format!("*a{}", k - 1)));
        }
        text
    };
    let (list, uses) = ("1, ".repeat(50_000), "*a, ".repeat(50_000));
    let tags: String = (0..60_000)
        .map(|k| format!("%TAG !a{k}! b:{k}\n"))
        .collect();
    vec![
        ("deep mappings", many("{a: ")),
        ("deep mappings on lines", many("{a:\n ")),
        ("deep lists", many("[")),
        ("deep lists with values", many("[1, ")),
        ("deep keys", many("{? ")),
        ("deep items", many("- ")),
        ("deep questions", many("? ")),
        ("deep mappings with quoted braces", many("{\"}\": ")),
        (
            "a deep list behind a text on two lines",
            format!("a: \"two\nlines\"\nb: {}", "[".repeat(1000)),
        ),
        ("aliases of aliases", bomb(9)),
        ("aliases of aliases of aliases", bomb(30)),
        (
            "one alias many times",
            format!("a: &a [{list}]\nb: [{uses}]"),
        ),
        (
            "a long text many times",
            format!(
                "a: &a {}\nb: [{}]",
                "x".repeat(400_000),
                "*a, ".repeat(90_000)
            ),
        ),
        (
            "a long key many times",
            format!(
                "? &a {}\n: 0\nb: [{}]",
                "x".repeat(400_000),
                "{*a : 1}, ".repeat(40_000)
            ),
        ),
        (
            "a long tag many times",
            format!(
                "%TAG !a! tag:{}\n---\nb: [{}]",
                "x".repeat(400_000),
                "!a!b 1, ".repeat(50_000)
            ),
        ),
        ("an alias of itself", "a: &a [*a]".to_owned()),
        ("many tags", tags + "---\na: 1"),
        ("no YAML", "{[:\0".to_owned()),
        ("half a list", "half: [written".to_owned()),
        ("a tab", "a:\n\tb: 1\n".to_owned()),
    ]
}
