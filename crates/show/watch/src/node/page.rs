//! Execution of the pages' requests, and their answers.

use std::any::TypeId;
use std::time::{Duration, Instant};

use planesman_msgs::Service;
use planesman_msgs::planesman_msgs::action::{
    Manoeuvre, ManoeuvreFeedback, ManoeuvreGoal, ManoeuvreResult,
};
use planesman_msgs::planesman_msgs::srv::{Fit, FitRequest, Step, StepRequest};
use planesman_msgs::rcl_interfaces::msg::Parameter;
use planesman_msgs::rcl_interfaces::srv::{
    DescribeParameters, DescribeParametersRequest, GetParameters, GetParametersRequest,
    ListParameters, ListParametersRequest, SetParametersAtomically, SetParametersAtomicallyRequest,
};
use planesman_msgs::rosbag2_interfaces::srv::{
    Pause, PauseRequest, Resume, ResumeRequest, SplitBagfile, SplitBagfileRequest,
};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use planesman_node::{Client, GoalId, GoalStatus, Qos, Runtime, choices_in, message_of, value_of};
use serde_json::{Value, json};
use tokio::sync::oneshot;

use super::{Event, ManoeuvreClient, TopicRequest, Watch, namespace};
use crate::board::locked;
use crate::command::{Command, Goal, done, parameter_of, refused, text_of};
use crate::feeds::Feed;
use crate::{Error, charts, units};

/// Timeout of a service call, and of finding a subscriber of a setpoint.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);
/// Timeout of a manoeuvre's result.
const MANOEUVRE_TIMEOUT: Duration = Duration::from_secs(24 * 60 * 60);

/// A parameter with its description for the page.
pub(super) struct Described {
    pub(super) parameter: Parameter,
    told: Value,
}

type Reply = oneshot::Sender<Value>;

impl Watch {
    /// Executes a request.
    pub(super) fn execute(&mut self, rt: &Runtime<Event>, command: Command, reply: Reply) {
        match command {
            Command::Keep { channels } => {
                let told = |channel: &String| match self.want(channel) {
                    Ok(()) => Value::Null,
                    Err(reason) => json!(reason.to_string()),
                };
                let reasons: Vec<_> = channels.iter().map(told).collect();
                answer(reply, json!({"ok": true, "refused": reasons}));
            }
            Command::Fields { topic } => self.fields(rt, &topic, reply),
            Command::Parameters { node } => self.parameters(rt, &node, reply),
            Command::Set {
                node,
                name,
                kind,
                text,
                unit,
            } => match parameter_of(kind, &text, &unit) {
                Err(reason) => answer(reply, refused(reason)),
                Ok(value) => {
                    let value = message_of(Some(&value));
                    self.set(rt, &node, Parameter { name, value }, unit, reply);
                }
            },
            Command::Trigger { service } => {
                self.call::<Trigger>(rt, &service, TriggerRequest::default(), reply, |it| {
                    told(it.success, it.message)
                });
            }
            Command::SetBool { service, data } => {
                self.call::<SetBool>(rt, &service, SetBoolRequest { data }, reply, |it| {
                    told(it.success, it.message)
                });
            }
            Command::Step { service, ticks } => {
                self.call::<Step>(rt, &service, StepRequest { ticks }, reply, |it| {
                    told(it.success, it.message)
                });
            }
            Command::Fit { service, name } => {
                let models = self.models;
                self.call::<Fit>(rt, &service, FitRequest { name }, reply, move |it| {
                    match it.success {
                        true => json!({"ok": true, "model": models.model(&it.model),
                            "message": format!("fit {:.2} % of {} samples", it.model.fit, it.model.samples)}),
                        false => refused(it.message),
                    }
                });
            }
            Command::Recorder { service } => self.recorder(rt, &service, reply),
            Command::Bag { node } => {
                let file = self.nodes.value(&format!("{node}: bag"), "file");
                let told = match file {
                    Some(file) => json!({"ok": true, "file": file}),
                    None => refused(format!("{node} reports no bag")),
                };
                answer(reply, told);
            }
            Command::Publish { topic, text } => self.publish(rt, &topic, &text, reply),
            Command::Manoeuvre { action, goal } => self.send_manoeuvre(rt, action, goal, reply),
            Command::Cancel { action } => self.cancel(rt, &action, reply),
        }
    }

    fn parameters(&mut self, rt: &Runtime<Event>, node: &str, reply: Reply) {
        match self.ask_parameters(rt, node) {
            Err(reason) => answer(reply, refused(reason)),
            Ok(asking) => answer_when(rt, reply, async move {
                match asking.await {
                    Err(reason) => refused(reason),
                    Ok(all) => {
                        let all: Vec<_> = all.into_iter().map(|it| it.told).collect();
                        json!({"ok": true, "parameters": all})
                    }
                }
            }),
        }
    }

    /// Sets a parameter from a value in `unit`.
    fn set(
        &mut self,
        rt: &Runtime<Event>,
        node: &str,
        parameter: Parameter,
        unit: String,
        reply: Reply,
    ) {
        let parameters = vec![parameter];
        let request = SetParametersAtomicallyRequest { parameters };
        let service = format!("{node}/set_parameters_atomically");
        // What a node says is in SI.
        let is_shown_so = units::symbol(&unit) == unit;
        self.call::<SetParametersAtomically>(rt, &service, request, reply, move |it| {
            let mut reason = it.result.reason;
            if !(is_shown_so || reason.is_empty()) {
                reason += &format!(" (in {unit})");
            }
            told(it.result.successful, reason)
        });
    }

    fn recorder(&mut self, rt: &Runtime<Event>, service: &str, reply: Reply) {
        match service.rsplit('/').next().unwrap_or_default() {
            "pause" => self.call::<Pause>(rt, service, PauseRequest::default(), reply, |_| {
                done("recording is paused")
            }),
            "resume" => self.call::<Resume>(rt, service, ResumeRequest::default(), reply, |_| {
                done("recording continues")
            }),
            "split_bagfile" => {
                let request = SplitBagfileRequest::default();
                self.call::<SplitBagfile>(rt, service, request, reply, |_| {
                    done("recording continues in the next file of the bag")
                });
            }
            _ => answer(
                reply,
                refused("a recorder provides only the services pause, resume and split_bagfile"),
            ),
        }
    }

    fn fields(&mut self, rt: &Runtime<Event>, topic: &str, reply: Reply) {
        if let Some(TopicRequest::Open(index)) = self.topics.get(topic) {
            let fields = self.feeds[*index].fields();
            return answer(reply, json!({"ok": true, "fields": fields}));
        }
        let Some(found) = rt
            .published_topics()
            .into_iter()
            .find(|it| it.name == topic)
        else {
            return answer(reply, refused(format!("nobody publishes {topic}")));
        };
        let finding = self.definitions.find(rt, &found);
        answer_when(rt, reply, async move {
            let fields = finding
                .await
                .map_err(Error::from)
                .and_then(|definition| Feed::new(&found.name, &found.type_name, &definition))
                .map(|feed| feed.fields());
            match fields {
                Ok(fields) => json!({"ok": true, "fields": fields}),
                Err(reason) => refused(reason),
            }
        });
    }

    fn publish(&mut self, rt: &Runtime<Event>, topic: &str, text: &str, reply: Reply) {
        let name = topic[namespace(topic).len()..].trim_start_matches('/');
        let quantity = name.strip_suffix("_setpoint").and_then(|name| {
            let mut all = charts::SETPOINTS.iter();
            all.find(|(it, _)| *it == name)
        });
        let Some((name, si)) = quantity else {
            return answer(reply, refused(format!("{topic} is not a setpoint")));
        };
        let value = match units::parse(text, si) {
            Ok(value) => value,
            Err(reason) => return answer(reply, refused(format!("{name}: {reason}"))),
        };
        let publisher = match self.setpoints.get(topic) {
            Some(publisher) => publisher.clone(),
            None => match rt.publisher::<Float64>(topic, Qos::reliable(10)) {
                Ok(publisher) => {
                    self.setpoints.retain(|_, it| it.readers() > 0);
                    self.setpoints.insert(topic.to_owned(), publisher.clone());
                    publisher
                }
                Err(error) => return answer(reply, refused(error)),
            },
        };
        answer_when(rt, reply, async move {
            let since = Instant::now();
            while publisher.readers() == 0 && since.elapsed() < ANSWER_TIMEOUT {
                smol::Timer::after(Duration::from_millis(20)).await;
            }
            match publisher.readers() {
                0 => refused(format!("nobody reads {}", publisher.topic())),
                _ if publisher.publish(&Float64 { data: value }) => done("sent"),
                _ => refused("the setpoint could not be sent"),
            }
        });
    }

    fn send_manoeuvre(&mut self, rt: &Runtime<Event>, action: String, goal: Goal, reply: Reply) {
        let goal = match goal_of(goal) {
            Ok(goal) => goal,
            Err(reason) => return answer(reply, refused(reason)),
        };
        if !self.manoeuvres.contains_key(&action) {
            let served = format!("{action}/_action/send_goal");
            if !rt.services(&served).contains(&served) {
                return answer(reply, refused(format!("no node serves {action}")));
            }
            let name = action.clone();
            let opened = rt.action_client::<Manoeuvre>(&action, move |id, feedback| {
                Event::Feedback(name.clone(), id, feedback)
            });
            match opened {
                Ok(client) => {
                    let running = ManoeuvreClient { client, goal: None };
                    self.manoeuvres.insert(action.clone(), running);
                }
                Err(error) => return answer(reply, refused(error)),
            }
        }
        let Some(running) = self.manoeuvres.get(&action) else {
            return;
        };
        let client = running.client.clone();
        rt.when_done(async move {
            let (told, event) = match client.send(goal, ANSWER_TIMEOUT).await {
                Ok(Some(id)) => (done("accepted"), Event::Accepted(action, id)),
                Ok(None) => (
                    refused("the controller rejected the manoeuvre"),
                    Event::Parameters,
                ),
                Err(reason) => (refused(reason), Event::Parameters),
            };
            answer(reply, told);
            event
        });
    }

    pub(super) fn accepted(&mut self, rt: &Runtime<Event>, action: String, id: GoalId) {
        let Some(running) = self.manoeuvres.get_mut(&action) else {
            return;
        };
        running.goal = Some(id);
        let client = running.client.clone();
        let section = format!("manoeuvre:{action}");
        locked(&self.board).put(&section, json!({"state": "running"}));
        rt.when_done(async move {
            let outcome = client.result(id, MANOEUVRE_TIMEOUT).await;
            Event::Ended(action, id, outcome)
        });
    }

    pub(super) fn feedback(&mut self, action: &str, id: GoalId, feedback: &ManoeuvreFeedback) {
        if self.manoeuvres.get(action).and_then(|it| it.goal) == Some(id) {
            let told = json!({
                "state": "running",
                "elapsed": feedback.elapsed,
                "dive_planes": feedback.dive_planes,
            });
            locked(&self.board).put(&format!("manoeuvre:{action}"), told);
        }
    }

    pub(super) fn ended(
        &mut self,
        action: &str,
        id: GoalId,
        outcome: Result<(GoalStatus, ManoeuvreResult), planesman_node::Error>,
    ) {
        let Some(running) = self.manoeuvres.get_mut(action) else {
            return;
        };
        if running.goal != Some(id) {
            return; // A newer one has taken its place.
        }
        running.goal = None;
        let (state, message) = match outcome {
            Ok((GoalStatus::Succeeded, result)) => ("completed", result.message),
            Ok((GoalStatus::Canceled, result)) => ("cancelled", result.message),
            Ok((_, result)) => ("aborted", result.message),
            Err(reason) => ("lost", reason.to_string()),
        };
        let told = json!({"state": state, "message": message});
        locked(&self.board).put(&format!("manoeuvre:{action}"), told);
    }

    fn cancel(&mut self, rt: &Runtime<Event>, action: &str, reply: Reply) {
        let running = self.manoeuvres.get(action);
        let Some((client, id)) = running.and_then(|it| Some((it.client.clone(), it.goal?))) else {
            return answer(
                reply,
                refused("no manoeuvre that this page started is running"),
            );
        };
        answer_when(rt, reply, async move {
            match client.cancel(id, ANSWER_TIMEOUT).await {
                Ok(true) => done("cancelling"),
                Ok(false) => refused("the controller refused to cancel the manoeuvre"),
                Err(error) => refused(error),
            }
        });
    }

    /// The client of a service that a node currently offers.
    fn client<S: Service + 'static>(
        &mut self,
        rt: &Runtime<Event>,
        service: &str,
    ) -> Result<Client<S>, Error> {
        let key = (TypeId::of::<S>(), service.to_owned());
        if let Some(client) = self.clients.get(&key).and_then(|it| it.downcast_ref()) {
            return Ok(Client::clone(client));
        }
        if !rt.services(service).iter().any(|it| it == service) {
            return Err(Error::NotServed(service.to_owned()));
        }
        let client: Client<S> = rt.client(service)?;
        self.clients.insert(key, Box::new(client.clone()));
        Ok(client)
    }

    /// Calls a service and answers the page with `show` of the response.
    fn call<S: Service + 'static>(
        &mut self,
        rt: &Runtime<Event>,
        service: &str,
        request: S::Request,
        reply: Reply,
        show: impl FnOnce(S::Response) -> Value + 'static,
    ) {
        match self.client::<S>(rt, service) {
            Err(reason) => answer(reply, refused(reason)),
            Ok(client) => answer_when(rt, reply, async move {
                match client.call(request, ANSWER_TIMEOUT).await {
                    Ok(response) => show(response),
                    Err(error) => refused(error),
                }
            }),
        }
    }

    /// Requests a node's parameters with their descriptions.
    pub(super) fn ask_parameters(
        &mut self,
        rt: &Runtime<Event>,
        node: &str,
    ) -> Result<impl Future<Output = Result<Vec<Described>, Error>> + use<>, Error> {
        let service = |name: &str| format!("{node}/{name}");
        let list = self.client::<ListParameters>(rt, &service("list_parameters"))?;
        let get = self.client::<GetParameters>(rt, &service("get_parameters"))?;
        let describe = self.client::<DescribeParameters>(rt, &service("describe_parameters"))?;
        Ok(async move {
            let listed = list
                .call(ListParametersRequest::default(), ANSWER_TIMEOUT)
                .await;
            let names = listed?.result.names;
            let request = GetParametersRequest {
                names: names.clone(),
            };
            let values = get.call(request, ANSWER_TIMEOUT).await?.values;
            let request = DescribeParametersRequest {
                names: names.clone(),
            };
            let described = describe.call(request, ANSWER_TIMEOUT).await?;
            if values.len() != names.len() || described.descriptors.len() != names.len() {
                return Err(Error::Parameters);
            }
            let all = names.into_iter().zip(values).zip(described.descriptors);
            let one = all.map(|((name, value), descriptor)| {
                let (description, si) = units::described(&descriptor.description);
                let floats = descriptor.floating_point_range.first();
                let range = floats.map(|it| [it.from_value, it.to_value]);
                let range = range.map(|it| it.map(|end| units::on_page(end, si)));
                let integers = descriptor.integer_range.first();
                let range = range.or(integers.map(|it| [it.from_value as f64, it.to_value as f64]));
                let text = value_of(value.clone()).map(|it| text_of(&it, si));
                let told = json!({
                    "name": name,
                    "kind": value.r#type,
                    "text": text,
                    "description": description,
                    "unit": units::symbol(si),
                    "si": si,
                    "constraints": descriptor.additional_constraints,
                    "choices": choices_in(&descriptor.additional_constraints),
                    "read_only": descriptor.read_only,
                    "range": range,
                });
                Described {
                    parameter: Parameter { name, value },
                    told,
                }
            });
            Ok(one.collect())
        })
    }
}

/// The goal of a page's request. A chirp ends at four times its first frequency.
fn goal_of(goal: Goal) -> Result<ManoeuvreGoal, Error> {
    let quantity = |name: &'static str, text: &str, si: &str| {
        units::parse(text, si).map_err(|reason| Error::Quantity(name, Box::new(reason)))
    };
    let period = quantity("period", &goal.period, "s")?;
    Ok(ManoeuvreGoal {
        name: goal.name,
        amplitude: quantity("amplitude", &goal.amplitude, "rad")?,
        period,
        period_end: period / 4.0,
        duration: quantity("duration", &goal.duration, "s")?,
        seed: goal.seed,
    })
}

/// Sends an answer; a closed page needs no answer.
fn answer(reply: Reply, told: Value) {
    let _ = reply.send(told);
}

/// Sends the answer once it is known.
fn answer_when(rt: &Runtime<Event>, reply: Reply, told: impl Future<Output = Value> + 'static) {
    rt.when_done(async move {
        answer(reply, told.await);
        Event::Parameters
    });
}

fn told(success: bool, message: String) -> Value {
    match success {
        true => done(message),
        false => refused(message),
    }
}
