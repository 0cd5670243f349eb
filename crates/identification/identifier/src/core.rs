//! The identifier: messages in, estimates out, for one or several pairs of signals.
//!
//! Samples are processed in the order of their stamps ([`planesman_signals::Aligner`]), so the estimates depend on the messages and not on
//! when they arrived: replaying a bag gives bit for bit the estimates published live from the same messages.

use planesman_decode::{Types, schema};
use planesman_identification::Model;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::{Field, Message};

use crate::error::Error;
use crate::pair::{self, Change, DueEstimate, Pair, Scheduled};
use crate::parameters::{Config, IdentifierParameters};
use crate::reader::{Sample, TopicReader};

/// Identifies a model for each pair of signals.
#[derive(Clone, Debug)]
pub struct Identifier {
    /// The first pair belongs to the parameters `input` and `output`.
    pairs: Vec<Pair>,
    /// Readers for messages in memory, with their topic and type.
    readers: Vec<(String, &'static str, TopicReader)>,
}

/// The result of processing a message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The message's stamp; `None` if it could not be read.
    pub stamp: Option<Time>,
    /// The estimates due for publication.
    pub estimates: Vec<ModelEstimate>,
    /// Sentences that name signals without a finite number or list.
    pub refused: Vec<String>,
}

impl Identifier {
    /// An identifier before its first message.
    ///
    /// # Errors
    /// If a parameter is rejected, or an entry of `pairs` is malformed.
    pub fn new(parameters: &IdentifierParameters) -> Result<Self, Error> {
        let pairs = pair::described(parameters)?
            .into_iter()
            .map(|(name, own)| Pair::new(name, &own));
        Ok(Self {
            pairs: pairs.collect::<Result<_, _>>()?,
            readers: Vec::new(),
        })
    }

    /// Applies changed parameters, all or none. A change restarts the estimate only if the parameter's description says so.
    ///
    /// # Errors
    /// Like [`Identifier::new`]; then the present parameters stay.
    pub fn set_parameters(&mut self, parameters: &IdentifierParameters) -> Result<(), Error> {
        let new = Self::new(parameters)?;
        let mut changed = self.clone();
        for (pair, new) in changed.pairs.iter_mut().zip(&new.pairs) {
            pair.set_config(new.config().clone())?;
        }
        *self = changed;
        Ok(())
    }

    /// The pairs; the first is the pair of the parameters `input` and `output`.
    #[must_use]
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// The pair with that name; the first, if the name is empty.
    #[must_use]
    pub fn pair(&self, name: &str) -> Option<&Pair> {
        match name {
            "" => self.pairs.first(),
            name => self.pairs.iter().find(|pair| pair.name() == name),
        }
    }

    /// The current parameters of the first pair.
    #[must_use]
    pub fn config(&self) -> &Config {
        self.first().config()
    }

    fn first(&self) -> &Pair {
        // `described` always gives one.
        &self.pairs[0]
    }

    /// Whether messages on `topic` contain a signal of one of the pairs.
    #[must_use]
    pub fn concerns(&self, topic: &str) -> bool {
        self.pairs.iter().any(|pair| pair.config().is_on(topic))
    }

    /// A reader of messages of a type on `topic`, for every pair.
    ///
    /// # Errors
    /// Like [`TopicReader::new`].
    pub fn reader(&self, topic: &str, types: &Types) -> Result<TopicReader, Error> {
        TopicReader::new(self.pairs.iter().map(Pair::config), topic, types)
    }

    /// Processes a payload; `sent` is used as its stamp if it has no stamp of its own.
    pub fn on_payload(&mut self, reader: &mut TopicReader, sent: &Time, payload: &[u8]) -> Outcome {
        let (stamp, due, refused) = learnt(&mut self.pairs, reader.read(payload), sent);
        Outcome {
            stamp,
            estimates: pair::made(&due),
            refused,
        }
    }

    /// Processes a message in memory; `stamp` is used if the message has no stamp of its own. A message on another topic is ignored. Returns the
    /// estimates due for publication.
    ///
    /// # Errors
    /// With the signal's name, if the message has no finite number or list for it; then nothing is learnt.
    pub fn on<M: Message + Field>(
        &mut self,
        topic: &str,
        stamp: Time,
        message: &M,
    ) -> Result<Vec<ModelEstimate>, Error> {
        Ok(pair::made(&self.learn(topic, stamp, message)?))
    }

    /// Processes a message as [`Identifier::on`] does, without building the estimates.
    ///
    /// # Errors
    /// Like [`Identifier::on`].
    pub fn learn<M: Message + Field>(
        &mut self,
        topic: &str,
        stamp: Time,
        message: &M,
    ) -> Result<Vec<DueEstimate>, Error> {
        if !self.concerns(topic) {
            return Ok(Vec::new());
        }
        let is_known = |(of, type_name, _): &(String, &str, TopicReader)| {
            of == topic && *type_name == M::TYPE_NAME
        };
        let place = match self.readers.iter().position(is_known) {
            Some(known) => known,
            None => {
                let types = schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION)?;
                let reader = self.reader(topic, &types)?;
                self.readers.push((topic.to_owned(), M::TYPE_NAME, reader));
                self.readers.len() - 1
            }
        };
        let samples = self.readers[place].2.pick(message);
        let (_, due, refused) = learnt(&mut self.pairs, samples, &stamp);
        match refused.into_iter().next() {
            None => Ok(due),
            Some(reason) => Err(Error::Message(reason)),
        }
    }

    /// Ends the data: delayed samples are processed. Returns the estimates due.
    pub fn finish(&mut self) -> Vec<ModelEstimate> {
        self.pairs.iter_mut().flat_map(Pair::finish).collect()
    }

    /// Changes the learnt state of every pair, between two samples. Returns estimates that show the change.
    pub fn change(&mut self, change: Change) -> Vec<ModelEstimate> {
        let pairs = self.pairs.iter_mut();
        pairs.filter_map(|pair| pair.change(change)).collect()
    }

    /// Schedules a change of the pair with that name, to reproduce an earlier one.
    pub fn schedule(&mut self, name: &str, scheduled: Scheduled) {
        if let Some(pair) = self.pairs.iter_mut().find(|pair| pair.name() == name) {
            pair.schedule(scheduled);
        }
    }

    /// The first pair's latest output for which all data of its lockstep tick has come ([`Pair::answered`]).
    #[must_use]
    pub fn answered(&self) -> Option<Time> {
        self.first().answered()
    }

    /// The first pair's current estimate, with this stamp.
    #[must_use]
    pub fn estimate(&self, stamp: Time) -> ModelEstimate {
        self.first().estimate(stamp)
    }

    /// The first pair's current model.
    #[must_use]
    pub fn model(&self) -> Model {
        self.first().model()
    }
}

/// Processes a message's samples for the pairs concerned; returns its stamp, the estimates due, and refusals ([`Outcome`]).
fn learnt(
    pairs: &mut [Pair],
    samples: impl Iterator<Item = (usize, Result<Sample, Error>)>,
    sent: &Time,
) -> (Option<Time>, Vec<DueEstimate>, Vec<String>) {
    let (mut last, mut due, mut refused) = (None, Vec::new(), Vec::new());
    for (place, read) in samples {
        let pair = &mut pairs[place];
        match read {
            Ok(sample) => {
                let stamp = sample.stamp.clone().unwrap_or_else(|| sent.clone());
                last = Some(stamp.clone());
                due.extend(pair.take(stamp, &sample));
            }
            Err(reason) => {
                pair.refuse();
                refused.push(reason.to_string());
            }
        }
    }
    (last, due, refused)
}
