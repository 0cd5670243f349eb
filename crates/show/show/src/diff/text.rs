//! Text of a comparison: the first difference, then a table of topics.

use std::fmt::Write as _;

use planesman_console::Table;
use planesman_text::{number, option, shown};

use crate::diff::comparison::{Comparison, First, TopicResult, What};

impl Comparison {
    /// One sentence: either that the recordings are equal, or the first difference.
    #[must_use]
    pub fn headline(&self) -> String {
        let compared = self.topics.iter().filter(|it| it.left_out.is_empty());
        let (topics, messages) =
            compared.fold((0, 0), |sum: (u64, u64), it| (sum.0 + 1, sum.1 + it.equal));
        match &self.first {
            Some(first) => first.sentence(if self.is_table { "value" } else { "message" }),
            None if self.is_table => format!("equal: {messages} values in {topics} columns"),
            None => format!("equal: {messages} messages on {topics} topics"),
        }
    }

    /// Further notes, one per line.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = self.notes.clone();
        let of = |of: fn(&TopicResult) -> bool| {
            let names = self.topics.iter().filter(|it| of(it));
            let names: Vec<&str> = names.map(|it| it.name.as_str()).collect();
            names.join(", ")
        };
        let wall = of(|it| it.left_out == "wall time");
        if !wall.is_empty() {
            remarks.push(format!(
                "not compared because they contain wall-clock time: {wall} ({} compares them)",
                option("all")
            ));
        }
        let repeated: u64 = self.topics.iter().map(|it| it.repeated).sum();
        if repeated > 0 {
            remarks.push(format!(
                "{repeated} messages occur twice in a recording, with the same bytes; this does not count as a difference"
            ));
        }
        let reordered: u64 = self.topics.iter().map(|it| it.reordered).sum();
        if reordered > 0 {
            remarks.push(format!("{reordered} messages have a different order among messages of the same or the next stamps; this does not count as a difference"));
        }
        let within: u64 = self.topics.iter().map(|it| it.within).sum();
        if within > 0 {
            remarks.push(format!(
                "{within} of the equal messages differ, but only within tolerances or in ignored fields"
            ));
        }
        for topic in &self.topics {
            if topic.different > 0 && !topic.not_decoded.is_empty() {
                remarks.push(format!(
                    "{}: compared as bytes: {}",
                    topic.name, topic.not_decoded
                ));
            }
            let [only_a, only_b] = topic.alone;
            if only_a > 0 && only_b > 0 && topic.equal + topic.different == 0 {
                remarks.push(format!(
                    "{}: no message of A has the same stamp as a message of B; if the recordings use different clocks, add {}",
                    topic.name,
                    option("by_index")
                ));
            }
        }
        remarks
    }

    /// The topics, with the differing topics first.
    #[must_use]
    pub fn table(&self) -> Table {
        self.columns(|_| true)
    }

    /// The table without empty columns.
    #[must_use]
    pub fn short_table(&self) -> Table {
        self.columns(|values| values.iter().any(|it| !matches!(it.as_str(), "" | "0")))
    }

    fn columns(&self, is_shown: impl Fn(&[String]) -> bool) -> Table {
        let mut topics: Vec<&TopicResult> = self.topics.iter().collect();
        topics.sort_by_key(|it| it.is_equal());
        let column = |of: &dyn Fn(&TopicResult) -> String| -> Vec<String> {
            topics.iter().map(|it| of(it)).collect()
        };
        let compared = |it: &TopicResult, count: u64| match it.left_out {
            "" => count.to_string(),
            _ => String::new(),
        };
        let largest = |it: &TopicResult| Some(it.worst()?.1.largest.clone()?.difference.abs());
        let mut all = vec![
            (
                if self.is_table { "column" } else { "topic" },
                column(&|it| it.name.clone()),
            ),
            ("in A", column(&|it| it.messages[0].to_string())),
            ("in B", column(&|it| it.messages[1].to_string())),
            (
                "equal",
                column(&|it| match it.left_out {
                    "" => it.equal.to_string(),
                    why => why.to_owned(),
                }),
            ),
            ("different", column(&|it| compared(it, it.different))),
            ("only A", column(&|it| compared(it, it.alone[0]))),
            ("only B", column(&|it| compared(it, it.alone[1]))),
            (
                "largest difference",
                column(&|it| largest(it).map_or_else(String::new, number)),
            ),
        ];
        if !self.is_table {
            let field = |it: &TopicResult| match it.worst() {
                Some((name, field)) => {
                    (field.largest.as_ref()).map_or_else(|| name.to_owned(), |it| it.place.clone())
                }
                None => String::new(),
            };
            all.push(("field", column(&field)));
        }
        let counts = 4;
        let mut place = 0;
        all.retain(|(_, values)| {
            place += 1;
            place <= counts || is_shown(values)
        });
        let mut table = Table::of(all.iter().map(|it| it.0));
        for row in 0..topics.len() {
            table.row(all.iter().map(|it| it.1[row].clone()));
        }
        table
    }
}

impl First {
    fn sentence(&self, kind: &str) -> String {
        let Self {
            topic,
            number: count,
            equal_before,
            ..
        } = self;
        let mut text = format!("first difference: {}", shown(topic));
        if let What::Field(field, _) = &self.what
            && !field.is_empty()
        {
            let _ = write!(text, " field {}", shown(field));
        }
        let _ = match self.stamp {
            Some(stamp) => write!(text, " at stamp {} ({kind} {count})", seconds(stamp)),
            None => write!(text, ", {kind} {count}"),
        };
        text += ": ";
        text += &match &self.what {
            What::Field(_, [a, b]) => {
                let mut told = format!("{} in A, {} in B", shown(a), shown(b));
                if let (Some(in_a), Some(in_b)) = (a.number(), b.number()) {
                    let _ = write!(told, ", {} apart", number((in_b - in_a).abs()));
                }
                match a.ulps(b) {
                    Some(1) => told += " (1 ulp)",
                    Some(ulps @ 2..1_000_000) => told += &format!(" ({ulps} ulps)"),
                    _ => {}
                }
                told
            }
            What::Bytes(reason) => {
                format!(
                    "the bytes differ; the message cannot be decoded: {}",
                    shown(reason)
                )
            }
            What::Alone(0) => "only A has it".to_owned(),
            What::Alone(_) => "only B has it".to_owned(),
        };
        let before = match (*equal_before, count - 1) {
            (0, 0) => format!("no {kind} comes before this one"),
            (1, 1) => format!("the {kind} before this one is equal"),
            (equal, before) if equal == before => {
                format!("the {equal} {kind}s before this one are equal")
            }
            (equal, _) => format!("{equal} {kind}s before this one are equal"),
        };
        text + "; " + &before
    }
}

/// A stamp as `seconds.nanoseconds`.
fn seconds(stamp: i64) -> String {
    let sign = if stamp < 0 { "-" } else { "" };
    let stamp = stamp.unsigned_abs();
    format!(
        "{sign}{}.{:09}",
        stamp / 1_000_000_000,
        stamp % 1_000_000_000
    )
}
