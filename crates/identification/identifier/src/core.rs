//! The identifier: messages in, estimates out, of one or several pairs of signals.
//!
//! Samples are taken in the order of their stamps ([`planesman_signals::Aligner`]), so what is estimated
//! depends on the messages and not on when they arrived: a bag replayed gives, bit for bit,
//! what was published live from the same messages.

use planesman_decode::{Types, schema};
use planesman_identification::Model;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::{Field, Message};

use crate::error::Error;
use crate::pair::{self, Change, DueEstimate, Pair, Scheduled};
use crate::parameters::{Config, IdentifierParameters};
use crate::reader::{Sample, TopicReader};

/// Identifies a model between each of some pairs of signals.
#[derive(Clone, Debug)]
pub struct Identifier {
    /// The first is that of the parameters `input` and `output`.
    pairs: Vec<Pair>,
    /// How messages at hand are read, with their topic and type.
    readers: Vec<(String, &'static str, TopicReader)>,
}

/// The outcome of a message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The stamp it was taken at; `None` when nothing could be read.
    pub stamp: Option<Time>,
    /// The estimates due for publication.
    pub estimates: Vec<ModelEstimate>,
    /// Sentences naming the signals that it does not hold as finite numbers or lists of such.
    pub refused: Vec<String>,
}

impl Identifier {
    /// An identifier before its first message.
    ///
    /// # Errors
    /// When a parameter is rejected, or an entry of `pairs` is not written as it should be.
    pub fn new(parameters: &IdentifierParameters) -> Result<Self, Error> {
        let pairs = pair::described(parameters)?
            .into_iter()
            .map(|(name, own)| Pair::new(name, &own));
        Ok(Self {
            pairs: pairs.collect::<Result<_, _>>()?,
            readers: Vec::new(),
        })
    }

    /// Takes changed parameters, whole or not at all. What a parameter's description does not say to begin
    /// the estimate anew changes in place.
    ///
    /// # Errors
    /// As [`Identifier::new`]; the present parameters then stay.
    pub fn set_parameters(&mut self, parameters: &IdentifierParameters) -> Result<(), Error> {
        let new = Self::new(parameters)?;
        let mut changed = self.clone();
        for (pair, new) in changed.pairs.iter_mut().zip(&new.pairs) {
            pair.set_config(new.config().clone())?;
        }
        *self = changed;
        Ok(())
    }

    /// The pairs, that of the parameters `input` and `output` first.
    #[must_use]
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// The pair of that name; the first, if the name is empty.
    #[must_use]
    pub fn pair(&self, name: &str) -> Option<&Pair> {
        match name {
            "" => self.pairs.first(),
            name => self.pairs.iter().find(|pair| pair.name() == name),
        }
    }

    /// The parameters in force for the first pair.
    #[must_use]
    pub fn config(&self) -> &Config {
        self.first().config()
    }

    fn first(&self) -> &Pair {
        // `described` always gives one.
        &self.pairs[0]
    }

    /// Whether messages on `topic` bear one of the signals.
    #[must_use]
    pub fn concerns(&self, topic: &str) -> bool {
        self.pairs.iter().any(|pair| pair.config().is_on(topic))
    }

    /// A reader of messages of a type on `topic`, for every pair.
    ///
    /// # Errors
    /// As [`TopicReader::new`].
    pub fn reader(&self, topic: &str, types: &Types) -> Result<TopicReader, Error> {
        TopicReader::new(self.pairs.iter().map(Pair::config), topic, types)
    }

    /// Takes a payload; its stamp is `sent` where it has none of its own.
    pub fn on_payload(&mut self, reader: &mut TopicReader, sent: &Time, payload: &[u8]) -> Outcome {
        let (stamp, due, refused) = learnt(&mut self.pairs, reader.read(payload), sent);
        Outcome {
            stamp,
            estimates: pair::made(&due),
            refused,
        }
    }

    /// Takes a message that is at hand, whose stamp is `stamp` where it has none of its own; one on another
    /// topic is passed over. Returns the estimates due for publication.
    ///
    /// # Errors
    /// With the signal's name, when the message does not hold it as a finite number or
    /// list of such; nothing is learnt of it then.
    pub fn on<M: Message + Field>(
        &mut self,
        topic: &str,
        stamp: Time,
        message: &M,
    ) -> Result<Vec<ModelEstimate>, Error> {
        Ok(pair::made(&self.learn(topic, stamp, message)?))
    }

    /// As [`Identifier::on`], the estimates not made yet.
    ///
    /// # Errors
    /// As [`Identifier::on`].
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

    /// Says that nothing more will come, at the end of a record: what was held back for an
    /// earlier message is learnt. Returns the estimates due.
    pub fn finish(&mut self) -> Vec<ModelEstimate> {
        self.pairs.iter_mut().flat_map(Pair::finish).collect()
    }

    /// Changes what every pair has learnt, between two samples. Returns the estimates that say so.
    pub fn change(&mut self, change: Change) -> Vec<ModelEstimate> {
        let pairs = self.pairs.iter_mut();
        pairs.filter_map(|pair| pair.change(change)).collect()
    }

    /// Changes what the pair of that name has learnt when its time has come, as it was changed before.
    pub fn schedule(&mut self, name: &str, scheduled: Scheduled) {
        if let Some(pair) = self.pairs.iter_mut().find(|pair| pair.name() == name) {
            pair.schedule(scheduled);
        }
    }

    /// The first pair's latest output with which all that a lockstep tick brings has come
    /// ([`Pair::answered`]).
    #[must_use]
    pub fn answered(&self) -> Option<Time> {
        self.first().answered()
    }

    /// The first pair's estimate as it stands, stamped so.
    #[must_use]
    pub fn estimate(&self, stamp: Time) -> ModelEstimate {
        self.first().estimate(stamp)
    }

    /// The first pair's model as it stands.
    #[must_use]
    pub fn model(&self) -> Model {
        self.first().model()
    }
}

/// Of a message's samples for the pairs concerned: its stamp, the estimates due, and what is refused ([`Outcome`]).
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
