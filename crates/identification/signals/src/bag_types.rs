//! The type of a topic's messages: from the definition in the bag, else from the known definitions.

use planesman_bag::{BagReader, Order, Topic};
use planesman_decode::{Decoder, Types, json, message_types, schema};

use crate::error::{Result, SourceError};

/// The types that a topic's schema defines. If the bag has no definition, uses a built-in one or one installed below `AMENT_PREFIX_PATH`,
/// if the topic's first message matches it to the end.
///
/// # Errors
/// One line that names the topic, if its messages are not CDR, its schema cannot be read, or its type is not known.
pub fn types(bag: &BagReader, topic: &Topic) -> Result<Types> {
    let (name, kind) = (&topic.name, &topic.kind);
    let refuse = |reason: String| {
        let topic = name.clone();
        Err(SourceError::Topic { topic, reason })
    };
    if kind.message_encoding == "json" {
        let first = bag.messages_of(|it| it == topic, Order::File).flatten();
        let objects = first.take(OBJECTS).map(|it| it.payload);
        return json::types(objects).or_else(|reason| refuse(brief(reason.to_string())));
    }
    if kind.message_encoding != "cdr" {
        return refuse(format!(
            "the messages have the encoding '{}', but only cdr and json can be read. Next: {}",
            kind.message_encoding.escape_default(),
            remedy(bag, topic)
        ));
    }
    let is_written = ["ros2msg", "ros2idl"].contains(&kind.definition_encoding.as_str());
    let read = schema::read(&kind.type_name, &kind.definition_encoding, &kind.definition);
    if is_written && !kind.definition.trim().is_empty() {
        return read.or_else(|reason| refuse(brief(reason.to_string())));
    }
    if kind.type_name.is_empty() {
        return refuse(
            "the file has neither type nor definition for this topic, so its bytes cannot be read. Record it again, or write the channel's schema with the 'mcap' library"
                .to_owned(),
        );
    }
    let mut known = message_types::versions(&kind.type_name);
    // A message may have no field.
    let (empty, reason) = match read {
        Ok(types) => (Some(types), String::new()),
        Err(reason) => (None, reason.to_string()),
    };
    let first = bag.messages_of(|it| it == topic, Order::File).next();
    let payload = first.and_then(std::result::Result::ok).map(|it| it.payload);
    let are_there = !known.is_empty();
    known.extend(empty.filter(|_| payload.is_some()));
    let fits = |types: &Types| {
        let is_its = kind.type_hash.is_empty() || kind.type_hash == types.hash();
        is_its && (payload.as_ref()).is_none_or(|payload| Decoder::fits(types, payload))
    };
    if let Some(types) = known.into_iter().find(fits) {
        return Ok(types);
    }
    let type_name = &kind.type_name;
    let none = match (kind.definition_encoding.as_str(), &*kind.definition) {
        (_, "") | ("ros2msg" | "ros2idl", _) => {
            format!("the bag does not contain the definition of {type_name}")
        }
        _ => format!("{} (of {type_name})", brief(reason)),
    };
    refuse(match are_there {
        true => format!(
            "{none}, and its messages do not match the {type_name} in this program: they have another version; {RECIPE}"
        ),
        false => format!("{none}, and it is not a standard type; {RECIPE}"),
    })
}

/// JSON objects of a topic whose members are examined.
const OBJECTS: usize = 20;

/// Instructions for making a definition available that is not in the bag.
const RECIPE: &str = "source the workspace that defines it (its prefix in AMENT_PREFIX_PATH) and run this command again, or convert the bag in that workspace with 'ros2 bag convert' to mcap, which adds the definition";

/// Instructions that make messages with this encoding readable.
fn remedy(bag: &BagReader, topic: &Topic) -> String {
    let (file, name) = (bag.path().display(), &topic.name);
    match topic.kind.message_encoding.as_str() {
        "ros1" => format!(
            "'rosbags-convert --src {file} --dst NEW --dst-storage mcap' (of PyPI's rosbags) \
             converts the .bag file to a ROS 2 bag"
        ),
        "protobuf" => format!(
            "write a CSV file of it: python -c \"from mcap.reader import make_reader; from mcap_protobuf.decoder import DecoderFactory; print('t,x', \
             *(f'{{m.log_time/1e9}},{{d.FIELD}}' for _, _, m, d in make_reader(open('{file}', 'rb'), \
             decoder_factories=[DecoderFactory()]).iter_decoded_messages(['{name}'])), sep='\\n')\" > NEW.csv (PyPI's mcap-protobuf-support)"
        ),
        _ => "export it as a CSV file from PlotJuggler or Foxglove".to_owned(),
    }
}

/// Shortens a reason that quotes text from a file.
fn brief(reason: String) -> String {
    const LONGEST: usize = 300;
    match reason.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} ...", &reason[..end]),
        None => reason,
    }
}
