//! Reads the identifier's signals from the payloads of one topic, by the schema of its messages.

use planesman_decode::{Decoder, Name, NameKind, Types, Values};
use planesman_identification::Input;
use planesman_msgs::Field;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_signals::Signal;

use crate::error::Error;
use crate::parameters::Config;

/// The numbers of a message that the identifier uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// The message's stamp; `None` for a type without a stamp.
    pub stamp: Option<Time>,
    /// The input over the interval that begins at the stamp.
    pub input: Option<Input>,
    /// The output at the stamp.
    pub output: Option<f64>,
    /// Whether the input before the output is invalid.
    pub breaks: bool,
}

/// Reads the messages of one topic.
#[derive(Clone, Debug)]
pub struct Reader {
    decoder: Decoder,
    values: Values,
    /// The signals on the topic, each with its index among the decoder's paths.
    input: Option<(Signal, usize)>,
    output: Option<(Signal, usize)>,
    break_on: Option<(Signal, usize)>,
    /// The index of the stamp's seconds; nanoseconds follow.
    stamp: Option<usize>,
    /// The owners of input and output.
    owners: [Owner; 2],
}

/// Number of consecutive messages with another owner after which it counts as renamed.
const RENAMED: u32 = 20;

/// Maximum number of characters of names in an error.
const LISTED: usize = 60;

/// The frame, joint or motor that a signal describes.
#[derive(Clone, Debug, Default)]
struct Owner {
    /// The names of the messages and elements on the path to the signal.
    names: Option<Vec<String>>,
    /// Number of consecutive messages with another owner.
    others: u32,
}

impl Owner {
    /// Checks that a message has the same owner as those before.
    ///
    /// # Errors
    /// With both names, if it has another one and has not been renamed for long.
    fn check<'a>(
        &mut self,
        signal: &Signal,
        names: impl Iterator<Item = (usize, &'a Name)>,
    ) -> Result<(), Error> {
        // Numbers and lengths of lists tell elements apart, not owners.
        let names = names.filter(|it| it.1.kind == NameKind::Named);
        let names: Vec<&str> = names.map(|it| it.1.text.as_str()).collect();
        let is_same = |known: &Vec<String>| *known == names;
        let known = match &self.names {
            Some(known) if !is_same(known) && self.others < RENAMED => known,
            Some(known) if is_same(known) => {
                self.others = 0;
                return Ok(());
            }
            _ => {
                self.others = 0;
                self.names = Some(names.into_iter().map(str::to_owned).collect());
                return Ok(());
            }
        };
        self.others += 1;
        let listed = |names: Vec<&str>| {
            let names = names.join(", ");
            let shown: String = names.chars().take(LISTED).collect();
            format!("'{}'", shown.escape_debug())
        };
        Err(Error::Message(format!(
            "{signal}: this message describes {}, but earlier messages describe {}. Add the wanted name to the signal",
            listed(names),
            listed(known.iter().map(String::as_str).collect())
        )))
    }
}

impl Reader {
    /// The reader of messages of a type on `topic`; `None` for a topic with neither input nor output.
    ///
    /// # Errors
    /// With the signal's name, if messages of the type have no such number.
    pub fn new(config: &Config, topic: &str, types: &Types) -> Result<Option<Self>, Error> {
        let mut paths = Vec::new();
        let mut place = |signal: &Signal| {
            signal.is_on(topic).then(|| {
                paths.push(signal.path().clone());
                (signal.clone(), paths.len() - 1)
            })
        };
        let input = place(&config.input);
        let output = place(&config.output);
        if input.is_none() && output.is_none() {
            return Ok(None);
        }
        let break_on = match (&config.break_on, &output) {
            (Some(signal), Some(_)) => place(signal),
            _ => None,
        };
        for path in &paths {
            if let Some(names) = types.names_of(path) {
                return Err(Error::List {
                    topic: topic.to_owned(),
                    path: path.to_string(),
                    names: names.to_string(),
                });
            }
        }
        let stamp = types.stamp().map(|stamp| {
            paths.extend(["sec", "nanosec"].map(|name| stamp.field(name)));
            paths.len() - 2
        });
        Ok(Some(Self {
            decoder: Decoder::compile_with_identities(types, &paths)
                .map_err(|reason| Error::NoSignal(topic.to_owned(), Box::new(reason)))?,
            values: Values::default(),
            input,
            output,
            break_on,
            stamp,
            owners: Default::default(),
        }))
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// With the signal's name, if the payload has no finite number or list for it, or has that of another frame, joint or motor.
    pub fn read(&mut self, payload: &[u8]) -> Result<Sample, Error> {
        self.decoder.read(payload, &mut self.values)?;
        let signals = [&self.input, &self.output].into_iter();
        for (signal, owner) in signals.zip(&mut self.owners) {
            if let Some((signal, place)) = signal
                && !self.values.list(*place).is_empty()
            {
                owner.check(signal, self.decoder.identity(*place, &self.values))?;
            }
        }
        self.sample()
    }

    /// Reads a message in memory of the type.
    ///
    /// # Errors
    /// Like [`Reader::read`].
    pub fn pick(&mut self, message: &dyn Field) -> Result<Sample, Error> {
        self.decoder.pick(message, &mut self.values);
        self.sample()
    }

    /// The sample from the values read last.
    fn sample(&self) -> Result<Sample, Error> {
        let values = &self.values;
        let breaks = match &self.break_on {
            Some((signal, place)) => signal.output(values.list(*place))? != 0.0,
            None => false,
        };
        // A message without the element of a name that was there before is of something else.
        let [of_input, of_output] = &self.owners;
        let is_there = |(signal, place): &(Signal, usize), owner: &Owner| {
            let is_named = signal.path().named().next().is_some();
            !(is_named && owner.names.is_some() && values.list(*place).is_empty())
        };
        let input = self.input.as_ref().filter(|it| is_there(it, of_input));
        let output = self.output.as_ref().filter(|it| is_there(it, of_output));
        Ok(Sample {
            stamp: self.stamp.and_then(|place| {
                Some(Time {
                    sec: values.number(place)? as i32,
                    nanosec: values.number(place + 1)? as u32,
                })
            }),
            input: input
                .map(|(signal, place)| signal.input(values.list(*place)))
                .transpose()?,
            output: output
                .map(|(signal, place)| signal.output(values.list(*place)))
                .transpose()?,
            breaks,
        })
    }
}

/// Reads the messages of one topic for every pair with a signal in them.
#[derive(Clone, Debug)]
pub struct TopicReader {
    /// Each with the index of its pair.
    readers: Vec<(usize, Reader)>,
}

impl TopicReader {
    /// The reader of messages of a type on `topic` for pairs with these configurations.
    ///
    /// # Errors
    /// Like [`Reader::new`].
    pub fn new<'a>(
        configs: impl Iterator<Item = &'a Config>,
        topic: &str,
        types: &Types,
    ) -> Result<Self, Error> {
        let mut readers = Vec::new();
        for (place, config) in configs.enumerate() {
            let reader = Reader::new(config, topic, types)?;
            readers.extend(reader.map(|reader| (place, reader)));
        }
        Ok(Self { readers })
    }

    /// The sample in a payload for each pair concerned, by its index; or an error of [`Reader::read`].
    pub fn read<'a>(
        &'a mut self,
        payload: &'a [u8],
    ) -> impl Iterator<Item = (usize, Result<Sample, Error>)> + 'a {
        let readers = self.readers.iter_mut();
        readers.map(|(place, reader)| (*place, reader.read(payload)))
    }

    /// Like [`TopicReader::read`], for a message in memory.
    pub fn pick<'a>(
        &'a mut self,
        message: &'a dyn Field,
    ) -> impl Iterator<Item = (usize, Result<Sample, Error>)> + 'a {
        let readers = self.readers.iter_mut();
        readers.map(|(place, reader)| (*place, reader.pick(message)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_of_another_frame_is_refused_whatever_signs_its_name_has() {
        let signal: Signal = "joints:position".parse().unwrap();
        let name = |text: &str, kind| Name {
            text: text.to_owned(),
            kind,
        };
        for [first, other] in [["left arm", "right arm"], ["arm=a", "arm=b"]] {
            let mut owner = Owner::default();
            let mut check = |text, kind| {
                let name = name(text, kind);
                owner.check(&signal, std::iter::once((0, &name)))
            };
            check(first, NameKind::Named).unwrap();
            let refusal = check(other, NameKind::Named).unwrap_err().to_string();
            assert!(refusal.contains(&format!(
                "describes '{other}', but earlier messages describe '{first}'"
            )));
        }
        let mut owner = Owner::default();
        for text in ["2 numbers", "3 numbers"] {
            let name = name(text, NameKind::Counted);
            let names = std::iter::once((0, &name));
            owner.check(&signal, names).unwrap();
        }
    }
}
