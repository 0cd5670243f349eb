//! The recorder's parameters: where to, how compressed, how often flushed, which topics.
//!
//! All are set at start-up: a bag is written one way from its first message to its last.

use std::time::Duration;

use planesman_bag::{Compression, WriterOptions};
use planesman_parameters::{Declaration, Value, Values};

use crate::loop_topics;

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "output",
            "",
            "The bag's folder, which must not exist; empty for bags/planesman_ and the time.",
        )
        .read_only(),
        Declaration::new(
            "topics",
            Value::StringArray(Vec::new()),
            "The topics to record, by their names in the loop ('state', '/tf'); empty for all.",
        )
        .read_only(),
        Declaration::new(
            "compression",
            "zstd",
            "How the bag's chunks are compressed: none, or zstd at its default level.",
        )
        .choices(&["none", "zstd"])
        .read_only(),
        Declaration::new(
            "chunk_size",
            768 * 1024_i64,
            "Size of a chunk before compression at which it is written to the file; rosbag2's default.",
        )
        .unit("B")
        .range(1024.0, 64.0 * 1024.0 * 1024.0)
        .read_only(),
        Declaration::new(
            "flush_interval",
            1.0,
            "Longest time a message waits in memory: what a killed recorder may lose.",
        )
        .unit("s")
        .range(0.0, 3600.0)
        .read_only(),
        Declaration::new(
            "reliable_sensors",
            false,
            "Listen to the sensors' topics reliably, so that none of their messages is lost; plant_sim must offer it (its reliable_sensors). Always as a member of lockstep.",
        )
        .read_only(),
        Declaration::new(
            "answer",
            false,
            "Whether each tick is answered once its state is recorded, as a member of lockstep.",
        )
        .read_only(),
    ]
}

/// How the bag is written, by these values.
///
/// # Errors
/// When the values contradict each other or name a topic that is not of the loop.
pub fn writer_options(values: &Values) -> Result<WriterOptions, String> {
    loop_topics::selected(values.strings("topics")).map_err(|unknown| unknown.to_string())?;
    let chunk_size = values.integer("chunk_size");
    Ok(WriterOptions {
        compression: values.string("compression").parse::<Compression>()?,
        chunk_size: u64::try_from(chunk_size).map_err(|_| format!("chunk_size {chunk_size}"))?,
        flush_interval: Some(
            Duration::try_from_secs_f64(values.double("flush_interval"))
                .map_err(|error| format!("flush_interval: {error}"))?,
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(name: &str, value: Value) -> Result<WriterOptions, String> {
        Values::defaults(declarations())
            .with([(name.to_owned(), value)])
            .map_err(|refusal| refusal.to_string())
            .and_then(|values| writer_options(&values))
    }

    #[test]
    fn the_defaults_are_the_bags_own() {
        let options = writer_options(&Values::defaults(declarations())).expect("valid");
        let defaults = WriterOptions::default();
        assert_eq!(options.compression, defaults.compression);
        assert_eq!(options.chunk_size, defaults.chunk_size);
        assert_eq!(options.flush_interval, defaults.flush_interval);
    }

    #[test]
    fn values_reach_the_writer() {
        let none = with("compression", "none".into()).expect("valid");
        assert_eq!(none.compression, Compression::None);
        let small = with("chunk_size", Value::Integer(4096)).expect("valid");
        assert_eq!(small.chunk_size, 4096);
        let fast = with("flush_interval", 0.25.into()).expect("valid");
        assert_eq!(fast.flush_interval, Some(Duration::from_millis(250)));
    }

    #[test]
    fn bad_values_are_refused_by_name_and_rule() {
        for (name, value, rule) in [
            ("compression", Value::from("gzip"), "none, zstd"),
            ("chunk_size", Value::Integer(-1), "[1024, 67108864] B"),
            ("flush_interval", Value::Double(f64::NAN), "finite"),
            ("flush_interval", Value::Double(-1.0), "[0, 3600] s"),
            (
                "topics",
                Value::StringArray(vec!["stat".to_owned()]),
                "'stat'",
            ),
        ] {
            let refusal = with(name, value).expect_err("refused");
            assert!(refusal.contains(rule), "{name}: {refusal}");
        }
    }
}
