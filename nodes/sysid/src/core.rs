//! The identifier: messages in, estimates out.
//!
//! Samples are taken in the order of their stamps ([`crate::align`]), so what is estimated
//! depends on the messages and not on when they arrived: a bag replayed gives, bit for bit,
//! what was published live from the same messages.
//!
//! An output whose message says that the input before it is not to be trusted (`break_on`: the planes
//! were held, the actuator had not answered) is not learnt from.
//!
//! A gap in the stamps begins the history anew and keeps the estimate; time going back begins
//! everything anew.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use planesman_decode::schema;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::{Message, cdr};
use planesman_parameters::Values;

use crate::align::{Aligner, Offer, WINDOW};
use crate::learner::Learner;
use crate::model::Model;
use crate::parameters::Config;
use crate::reader::{Reader, Sample};

/// Identifies a model between two signals.
#[derive(Clone, Debug)]
pub struct Identifier {
    config: Config,
    aligner: Aligner,
    learner: Learner,
    /// The first sample's stamp, ns.
    began: Option<i64>,
    /// Stamps of outputs not yet learnt whose input is not to be trusted, ns.
    broken: BTreeSet<i64>,
    /// How messages at hand are read, by topic and type.
    readers: BTreeMap<(String, &'static str), Option<Reader>>,
}

impl Identifier {
    /// An identifier before its first message.
    ///
    /// # Errors
    /// As [`Config::from_values`].
    pub fn new(values: &Values) -> Result<Self, String> {
        let config = Config::from_values(values)?;
        Ok(Self {
            aligner: Aligner::new(period(&config)),
            learner: Learner::new(&config)?,
            began: None,
            broken: BTreeSet::new(),
            readers: BTreeMap::new(),
            config,
        })
    }

    /// Takes changed parameters, whole or not at all. Forgetting and the counts of rows
    /// change in place; any other change begins the estimate anew.
    ///
    /// # Errors
    /// As [`Config::from_values`]; the present parameters then stay.
    pub fn set_values(&mut self, values: &Values) -> Result<(), String> {
        let new = Config::from_values(values)?;
        let in_place = Config {
            forgetting: new.forgetting,
            publish_every: new.publish_every,
            min_samples: new.min_samples,
            ..self.config.clone()
        };
        if in_place == new {
            self.learner.set_forgetting(new.forgetting)?;
            self.config = new;
        } else {
            *self = Self::new(values)?;
        }
        Ok(())
    }

    /// The parameters in force.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Whether messages on `topic` bear one of the signals.
    #[must_use]
    pub fn concerns(&self, topic: &str) -> bool {
        self.config.input.is_on(topic) || self.config.output.is_on(topic)
    }

    /// Takes what a message on one of the signals' topics says, with its stamp; returns the estimates due for
    /// publication. Repeats change nothing.
    pub fn on_sample(&mut self, stamp: Time, sample: &Sample) -> Vec<ModelEstimate> {
        let stamp = stamp.nanos();
        if let Some(output) = sample.output
            && self.aligner.offer_output(stamp, output) == Offer::WentBack
        {
            self.learner.reset();
            self.began = None;
            self.broken.clear();
        }
        if sample.breaks {
            self.broken.insert(stamp);
            if self.broken.len() > 2 * WINDOW as usize {
                self.broken.pop_first();
            }
        }
        if let Some(input) = sample.input {
            self.aligner.offer_input(stamp, input);
        }
        self.learn()
    }

    /// Takes a message that is at hand, as [`Identifier::on_sample`] does; one on another topic is passed over.
    ///
    /// # Errors
    /// A sentence naming the signal, when the message does not hold it as a finite number or
    /// list of such; nothing changes then.
    pub fn on<M: Message>(
        &mut self,
        topic: &str,
        stamp: Time,
        message: &M,
    ) -> Result<Vec<ModelEstimate>, String> {
        if !self.concerns(topic) {
            return Ok(Vec::new());
        }
        let key = (topic.to_owned(), M::TYPE_NAME);
        let reader = match self.readers.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let types = schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION)
                    .map_err(|error| error.to_string())?;
                new.insert(Reader::new(&self.config, topic, &types)?)
            }
        };
        let Some(reader) = reader else {
            return Ok(Vec::new());
        };
        let sample = reader.read(&cdr::to_bytes(message))?;
        Ok(self.on_sample(stamp, &sample))
    }

    /// Says that nothing more will come, at the end of a record: what was held back for an
    /// earlier message is learnt. Returns the estimates due.
    pub fn finish(&mut self) -> Vec<ModelEstimate> {
        self.aligner.finish();
        self.learn()
    }

    /// Forgets everything but the parameters.
    pub fn reset(&mut self) {
        self.aligner = Aligner::new(period(&self.config));
        self.learner.reset();
        self.began = None;
        self.broken.clear();
    }

    /// The latest output's stamp with which all that a lockstep tick brings has come: the
    /// input over the interval before it, unless the output that began that interval was never seen.
    #[must_use]
    pub fn answered(&self) -> Option<Time> {
        self.aligner.answered().map(Time::from_nanos)
    }

    /// The estimate as it stands, stamped so.
    #[must_use]
    pub fn estimate(&self, stamp: Time) -> ModelEstimate {
        let Config { input, output, .. } = &self.config;
        let mut estimate = self.learner.estimate(&self.config);
        estimate.header.stamp = stamp;
        estimate.input = input.to_string();
        estimate.output = output.to_string();
        estimate
    }

    /// The model as it stands.
    #[must_use]
    pub fn model(&self) -> Model {
        self.learner.model(&self.config)
    }

    fn learn(&mut self) -> Vec<ModelEstimate> {
        let mut due = Vec::new();
        while let Some(sample) = self.aligner.take() {
            let began = *self.began.get_or_insert(sample.stamp);
            if sample.stamp - began < self.config.start || self.broken.remove(&sample.stamp) {
                self.learner.begin(sample.output);
                continue;
            }
            let rows = self.learner.rows();
            self.learner.take(sample);
            let learnt = self.learner.rows() > rows;
            if learnt
                && self
                    .learner
                    .rows()
                    .is_multiple_of(self.config.publish_every)
            {
                let estimate = self.estimate(Time::from_nanos(sample.stamp));
                // Nothing that is not finite passes the node's edge.
                if estimate.first_non_finite().is_none() {
                    due.push(estimate);
                }
            }
        }
        due
    }
}

fn period(config: &Config) -> i64 {
    (config.sample_time * 1e9).round() as i64
}
