//! The node: learns from two topics while they arrive, publishes what it has learnt.

use std::process::ExitCode;

use anyhow::{Result, anyhow};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, TickAnswer};
use planesman_msgs::planesman_msgs::srv::{Fit, FitResponse};
use planesman_msgs::std_msgs::msg::Header;
use planesman_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use planesman_node::{Flow, Level, NodeSpec, Publisher, Qos, RawSample, Responder, Runtime, args};
use planesman_parameters::Values;

use crate::core::Identifier;
use crate::reader::Reader;
use crate::{message_types, parameters};

enum Event {
    /// From the topic of that reader.
    Sample(usize, RawSample),
    Reset(Responder<Trigger>),
    Fit(Responder<Fit>),
    Parameters(Values),
}

/// Runs the node with its command-line arguments until it is told to stop.
#[must_use]
pub fn main(args: Vec<String>) -> ExitCode {
    planesman_node::exit_code("sysid", || run(args))
}

fn run(args: Vec<String>) -> Result<()> {
    let rt = Runtime::start(
        NodeSpec {
            name: "sysid",
            namespace: "/auv",
            declarations: parameters::declarations(),
            validate: |values| Identifier::new(values).map(drop),
            on_parameters: Event::Parameters,
        },
        args::only(args)?,
    )?;
    let values = rt.values();
    let mut node = Node {
        identifier: Identifier::new(&values).map_err(|e| anyhow!(e))?,
        model: rt.publisher("model", Qos::reliable(100))?,
        answer: values
            .bool("answer")
            .then(|| rt.publisher("tick_answer", Qos::reliable(100)))
            .transpose()?,
        answered: None,
        readers: Vec::new(),
    };
    let config = node.identifier.config();
    let mut signals = vec![
        (config.input.topic().to_owned(), values.string("input_type")),
        (
            config.output.topic().to_owned(),
            values.string("output_type"),
        ),
    ];
    signals.dedup_by(|a, b| a.0 == b.0);
    let mut readers = Vec::new();
    for (place, (topic, type_name)) in signals.into_iter().enumerate() {
        let found = message_types::find(type_name).map_err(|e| anyhow!(e))?;
        let reader = Reader::new(config, &topic, &found.types).map_err(|e| anyhow!(e))?;
        readers.extend(reader);
        rt.subscribe_raw(
            &topic,
            type_name,
            Some(&found.hash),
            Qos::record(),
            move |sample| Event::Sample(place, sample),
        )?;
    }
    node.readers = readers;
    rt.serve::<Trigger>("~/reset", |_, responder| Event::Reset(responder))?;
    rt.serve::<Fit>("~/fit", |_, responder| Event::Fit(responder))?;
    rt.run(|rt, event| node.on(rt, event))
}

struct Node {
    identifier: Identifier,
    model: Publisher<ModelEstimate>,
    answer: Option<Publisher<TickAnswer>>,
    /// The latest stamp answered.
    answered: Option<Time>,
    /// One for each topic that is listened to.
    readers: Vec<Reader>,
}

impl Node {
    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Sample(reader, sample) => {
                if let Err(reason) = self.learn(rt, reader, &sample) {
                    log::warn!("{}: {reason}", sample.topic);
                }
            }
            Event::Reset(responder) => {
                self.identifier.reset();
                log::info!("everything learnt is forgotten");
                responder.answer(TriggerResponse {
                    success: true,
                    message: String::new(),
                });
            }
            Event::Fit(responder) => {
                let model = self.identifier.estimate(rt.now());
                responder.answer(FitResponse {
                    success: model.valid,
                    message: model.reason.clone(),
                    model,
                });
            }
            Event::Parameters(values) => {
                self.identifier
                    .set_values(&values)
                    .map_err(|e| anyhow!(e))?;
                log::info!("parameters changed");
            }
        }
        Ok(Flow::Continue)
    }

    fn learn(
        &mut self,
        rt: &Runtime<Event>,
        reader: usize,
        sample: &RawSample,
    ) -> Result<(), String> {
        let reader = self.readers.get_mut(reader);
        let said = reader.ok_or("nobody listens to it")?.read(&sample.bytes)?;
        let stamp = said
            .stamp
            .clone()
            .unwrap_or_else(|| sample.received.clone());
        for estimate in self.identifier.on_sample(stamp.clone(), &said) {
            rt.set_status(
                "model",
                if estimate.valid {
                    Level::Ok
                } else {
                    Level::Warn
                },
                if estimate.valid {
                    "valid"
                } else {
                    &estimate.reason
                },
                &[("rows", estimate.samples.to_string())],
            );
            self.model.publish(&estimate);
        }
        self.answer(rt, &sample.topic, stamp);
        Ok(())
    }

    /// Answers for the latest tick learnt, once, and again when its output comes again: then
    /// somebody has missed the answer.
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
