//! The node: identifies models from live topics and publishes the estimates.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Result, anyhow, bail};
use planesman_decode::message_types;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, TickAnswer};
use planesman_msgs::planesman_msgs::srv::{Fit, FitRequest, FitResponse};
use planesman_msgs::std_msgs::msg::Header;
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolResponse, Trigger, TriggerResponse};
use planesman_node::{Flow, Level, NodeSpec, Publisher, Qos, RawSample, Responder, Runtime, args};
use planesman_parameters::Choice as _;

use planesman_identifier::parameters::{Config, Reliability};
use planesman_identifier::{
    Account, Change, Identifier, IdentifierParameters, Pair, TopicReader, pair,
};

/// Interval of the check for silent topics.
const POLL_INTERVAL: Duration = Duration::from_millis(500);

/// Time without any message after which it is reported, s.
const SILENCE: f64 = 2.0;

enum Event {
    /// A sample for the reader with this index.
    Sample(usize, RawSample),
    Reset(Responder<Trigger>),
    Freeze(bool, Responder<SetBool>),
    Fit(FitRequest, Responder<Fit>),
    Poll,
    Parameters(Box<IdentifierParameters>),
}

/// Runs the node with its command-line arguments until it is asked to stop.
#[must_use]
pub fn main(args: Vec<OsString>) -> ExitCode {
    planesman_node::exit_code("sysid", || run(args))
}

fn run(args: Vec<OsString>) -> Result<()> {
    let (rt, parameters) = Runtime::start(
        NodeSpec {
            name: "sysid",
            namespace: "/auv",
            validate: |parameters| Ok(Identifier::new(parameters).map(drop)?),
            on_parameters: |parameters| Event::Parameters(Box::new(parameters)),
        },
        args::only(args)?,
    )?;
    let mut node = Node {
        identifier: Identifier::new(&parameters)?,
        model: rt.loop_publisher("model")?,
        answer: parameters
            .answer
            .then(|| rt.loop_publisher("tick_answer"))
            .transpose()?,
        answered: None,
        last_message: rt.now(),
        topics: Vec::new(),
        told_lack: RefCell::default(),
    };
    for (place, (topic, listened)) in topics(&parameters)?.into_iter().enumerate() {
        let message_type = message_types::find(&listened.type_name)?;
        let reader = node.identifier.reader(&topic, &message_type.types);
        node.topics.push(Topic {
            name: topic.clone(),
            reader: reader?,
            trouble: None,
        });
        let qos = match listened.reliable {
            true => Qos::record_reliable(),
            false => Qos::record(),
        };
        // Of the loop's own topics one is of one node; on others many may publish.
        let is_of_the_loop = listened.type_name.starts_with("planesman_msgs/");
        rt.subscribe_raw(
            &topic,
            &listened.type_name,
            Some(&message_type.hash),
            match is_of_the_loop {
                true => qos.of_one_publisher(),
                false => qos,
            },
            move |sample| Event::Sample(place, sample),
        )?;
    }
    rt.serve::<Trigger>("~/reset", |_, responder| Event::Reset(responder))?;
    rt.serve::<SetBool>("~/freeze", |request, responder| {
        Event::Freeze(request.data, responder)
    })?;
    rt.serve::<Fit>("~/fit", Event::Fit)?;
    let _looks = rt.every(POLL_INTERVAL, || Event::Poll);
    rt.run(|rt, event| node.on(rt, event))
}

/// Subscription of a topic.
#[derive(Debug, PartialEq, Eq)]
struct Listened {
    type_name: String,
    /// Whether the subscription is reliable: lost messages are sent again, and only reliable publishers match.
    reliable: bool,
}

/// The topics of all pairs, with their subscriptions.
fn topics(parameters: &IdentifierParameters) -> Result<BTreeMap<String, Listened>> {
    let mut topics: BTreeMap<String, Listened> = BTreeMap::new();
    for (name, own) in pair::described(parameters).map_err(|e| anyhow!(e))? {
        let config = Config::new(&own).map_err(|e| anyhow!(e))?;
        let reliable = match own.reliability {
            Reliability::Auto => own.answer,
            Reliability::Reliable => true,
            Reliability::BestEffort => false,
        };
        for (signal, parameter, type_name) in [
            (&config.input, "input_type", &own.input_type),
            (&config.output, "output_type", &own.output_type),
        ] {
            let known = topics
                .entry(signal.topic().to_owned())
                .or_insert_with(|| Listened {
                    type_name: type_name.clone(),
                    reliable,
                });
            known.reliable |= reliable;
            if known.type_name != *type_name {
                bail!(
                    "pair '{name}': parameter '{parameter}' is {}, but another signal of the topic '{}' has the type {}; a topic has one type",
                    type_name,
                    signal.topic(),
                    known.type_name
                );
            }
        }
    }
    Ok(topics)
}

struct Node {
    identifier: Identifier,
    model: Publisher<ModelEstimate>,
    answer: Option<Publisher<TickAnswer>>,
    /// Stamp of the latest answer.
    answered: Option<Time>,
    /// Time of the last message.
    last_message: Time,
    topics: Vec<Topic>,
    /// The last logged sentence about a missing topic.
    told_lack: RefCell<Option<String>>,
}

/// A subscribed topic.
struct Topic {
    name: String,
    reader: TopicReader,
    /// The last complaint about a message, logged once.
    trouble: Option<String>,
}

impl Node {
    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Sample(topic, sample) => {
                self.learn(rt, topic, &sample);
                return Ok(Flow::Continue);
            }
            Event::Reset(responder) => {
                let changed = self.identifier.change(Change::Reset);
                self.publish(&changed);
                log::info!("estimate reset");
                responder.answer(TriggerResponse {
                    success: true,
                    message: String::new(),
                });
            }
            Event::Freeze(frozen, responder) => {
                let changed = self.identifier.change(Change::Freeze(frozen));
                self.publish(&changed);
                let message = match (frozen, changed.is_empty()) {
                    (true, false) => "estimate frozen",
                    (true, true) => "already frozen",
                    (false, false) => "estimation resumed",
                    (false, true) => "already estimating",
                };
                log::info!("{message}");
                responder.answer(SetBoolResponse {
                    success: true,
                    message: message.to_owned(),
                });
            }
            Event::Fit(request, responder) => responder.answer(self.fit(rt, &request.name)),
            Event::Poll => {}
            Event::Parameters(parameters) => match self.identifier.set_parameters(&parameters) {
                Ok(()) => log::info!("parameters changed"),
                Err(reason) => log::error!("{reason}; the previous parameters stay in force"),
            },
        }
        self.report(rt);
        Ok(Flow::Continue)
    }

    fn publish(&mut self, estimates: &[ModelEstimate]) {
        for estimate in estimates {
            self.model.publish(estimate);
        }
    }

    fn fit(&self, rt: &Runtime<Event>, name: &str) -> FitResponse {
        match self.identifier.pair(name) {
            Some(pair) => {
                let model = pair.estimate(rt.now());
                FitResponse {
                    success: model.valid,
                    message: model.reason.clone(),
                    model,
                }
            }
            None => {
                let names: Vec<&str> = self.identifier.pairs().iter().map(Pair::name).collect();
                FitResponse {
                    success: false,
                    message: format!("unknown signal pair '{name}'; known: {}", names.join(", ")),
                    model: ModelEstimate::default(),
                }
            }
        }
    }

    fn learn(&mut self, rt: &Runtime<Event>, place: usize, sample: &RawSample) {
        self.last_message = rt.now();
        let pairs = self.identifier.pairs().iter();
        let before: Vec<Account> = pairs.map(Pair::account).collect();
        let Some(topic) = self.topics.get_mut(place) else {
            return;
        };
        let sent = sample.published.as_ref().unwrap_or(&sample.received);
        let outcome = self
            .identifier
            .on_payload(&mut topic.reader, sent, &sample.bytes);
        let trouble = outcome.refused.into_iter().next();
        if trouble.is_some() && trouble != topic.trouble {
            let reason = trouble.as_deref().unwrap_or_default();
            log::warn!(
                "{}: {reason}. Further such messages are only counted",
                sample.topic
            );
        }
        topic.trouble = trouble.or(topic.trouble.take());
        for (pair, before) in self.identifier.pairs().iter().zip(before) {
            if let Some(jump) = pair.jump().filter(|_| pair.account().jumps != before.jumps) {
                log::warn!("{}: {jump}", pair.name());
            }
            if pair.account().restarts != before.restarts {
                log::warn!(
                    "{}: the stamps went back in time: {}",
                    pair.name(),
                    if pair.frozen() {
                        "the model is frozen and is kept"
                    } else {
                        "the estimate starts again"
                    }
                );
            }
        }
        self.publish(&outcome.estimates);
        if let Some(stamp) = outcome.stamp {
            self.answer(rt, &sample.topic, stamp);
        }
    }

    /// If the node is a member of lockstep: the topic without a publisher that each tick waits for, as a sentence.
    fn lack(&self, rt: &Runtime<Event>) -> Option<String> {
        let is_unpublished = |topic: &&Topic| {
            rt.publishing_nodes(&topic.name)
                .is_ok_and(|it| it.is_empty())
        };
        let mut topics = self.topics.iter().filter(|_| self.answer.is_some());
        let topic = &topics.find(is_unpublished)?.name;
        Some(format!(
            "each tick waits for {topic}, but no node publishes it. Set input and output, or remove sysid from lockstep.members"
        ))
    }

    /// Publishes the status of each pair.
    fn report(&self, rt: &Runtime<Event>) {
        let silence = (rt.now().nanos() - self.last_message.nanos()) as f64 * 1e-9;
        let lack = self.lack(rt);
        if lack != self.told_lack.replace(lack.clone()) {
            lack.iter().for_each(|it| log::warn!("{it}"));
        }
        for pair in self.identifier.pairs() {
            let config = pair.config();
            let estimate = pair.estimate(Time::default());
            let all_silent = silence > SILENCE.max(20.0 * config.sample_time);
            let (level, message) = if let Some(lack) = &lack {
                (Level::Warn, lack.clone())
            } else if all_silent {
                let (input, output) = (&config.input, &config.output);
                (
                    Level::Warn,
                    format!("no messages of {input} and {output} for {silence:.1} s"),
                )
            } else if let Some(trouble) = pair.trouble() {
                (Level::Warn, trouble)
            } else if !estimate.valid {
                (Level::Warn, estimate.reason)
            } else {
                (Level::Ok, "valid".to_owned())
            };
            let message = if pair.frozen() {
                format!("frozen; {message}")
            } else {
                message
            };
            let name = match pair.name() {
                pair::FIRST => pair::FIRST.to_owned(),
                name => format!("{} {name}", pair::FIRST),
            };
            let account = pair.account();
            rt.set_status(
                &name,
                level,
                &message,
                &[
                    ("estimator", config.estimator.name().to_owned()),
                    ("rows", estimate.samples.to_string()),
                    ("frozen", pair.frozen().to_string()),
                    ("jumps", account.jumps.to_string()),
                    (
                        "last_jump",
                        pair.jump()
                            .map_or_else(|| "none".to_owned(), |it| it.to_string()),
                    ),
                    ("gaps", account.gaps.to_string()),
                    ("restarts", account.restarts.to_string()),
                    ("left_out", account.left_out.to_string()),
                    ("refused", account.refused.to_string()),
                ],
            );
        }
    }

    /// Answers the latest complete tick, once, and again if its output is received again, since somebody then missed the answer.
    fn answer(&mut self, rt: &Runtime<Event>, topic: &str, stamp: Time) {
        let (Some(answer), Some(learnt)) = (&self.answer, self.identifier.answered()) else {
            return;
        };
        let again = learnt == stamp && self.identifier.config().output.is_on(topic);
        if again || self.answered.as_ref() != Some(&learnt) {
            let full = rt.full_name();
            answer.publish(&TickAnswer {
                header: Header {
                    stamp: learnt.clone(),
                    frame_id: String::new(),
                },
                member: full.rsplit('/').next().unwrap_or(&full).to_owned(),
            });
            self.answered = Some(learnt);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Parameters as _;

    fn reliable(changes: &[(&str, planesman_parameters::Value)]) -> Vec<(String, bool)> {
        let parameters = IdentifierParameters::default()
            .with(changes)
            .expect("declared");
        let topics = topics(&parameters).expect("good pairs").into_iter();
        topics
            .map(|(topic, listened)| (topic, listened.reliable))
            .collect()
    }

    fn is(topics: &[(&str, bool)]) -> Vec<(String, bool)> {
        topics
            .iter()
            .map(|(topic, reliable)| ((*topic).to_owned(), *reliable))
            .collect()
    }

    #[test]
    fn a_member_of_lockstep_asks_again_for_what_is_lost_and_anybody_else_hears_everybody() {
        assert_eq!(
            reliable(&[]),
            is(&[("plane_motion", false), ("state", false)])
        );
        let member = ("answer", true.into());
        assert_eq!(
            reliable(std::slice::from_ref(&member)),
            is(&[("plane_motion", true), ("state", true)])
        );
        let foreign = "gyro: plane_motion:dive_planes -> /gyro:data output_type=std_msgs/msg/Float64 reliability=best_effort";
        assert_eq!(
            reliable(&[member, ("pairs", [foreign].as_slice().into())]),
            is(&[("/gyro", false), ("plane_motion", true), ("state", true)])
        );
        let reliably = ("reliability", "reliable".into());
        assert_eq!(
            reliable(&[reliably]),
            is(&[("plane_motion", true), ("state", true)])
        );
    }
}
