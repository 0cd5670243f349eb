//! The node: writes messages of the domain to the board, and executes the pages' requests.

mod page;

use std::any::{Any, TypeId};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::time::{Duration, Instant};

use planesman_msgs::diagnostic_msgs::msg::DiagnosticArray;
use planesman_msgs::planesman_msgs::action::{Manoeuvre, ManoeuvreFeedback, ManoeuvreResult};
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, VehicleState};
use planesman_msgs::rcl_interfaces::msg::{Log, ParameterEvent};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::{Message, cdr};
use planesman_node::{
    ActionClient, Definition, DefinitionError, Definitions, Flow, GoalId, GoalStatus,
    PublishedTopic, Publisher, Qos, RawSample, Runtime, value_of,
};
use serde_json::{Value, json};

use crate::Error;
use crate::board::{LogLine, SharedBoard, locked};
use crate::charts::{self, ERRORS, WARNINGS};
use crate::command::Request;
use crate::feeds::Feed;
use crate::models::{ModelFunctions, Vehicle};
use crate::nodes::{Nodes, bounded, rounded};

/// Interval of looking for requested topics.
const POLL_INTERVAL: Duration = Duration::from_millis(250);
/// Number of polls after which nodes and topics are counted.
const POLLS_PER_COUNT: u64 = 4;
/// Maximum number of topics and services shown, and of channels kept: a hostile peer can create any number of topics.
const MAX_TOPICS: usize = 1000;
const MAX_CHANNELS: usize = 1000;
/// Maximum number of vehicles whose channels are kept, and of simultaneous requests for their parameters.
const MAX_VEHICLES: usize = 32;
/// Largest name of a channel, and of a node with changed parameters, bytes.
const MAX_NAME_BYTES: usize = 512;

/// An event of the node.
pub(crate) enum Event {
    /// A sample of the feed with this index.
    Sample(usize, RawSample),
    Log(RawSample),
    Diagnostics(DiagnosticArray),
    ParameterEvent(ParameterEvent),
    Poll,
    Found(PublishedTopic, Result<Definition, DefinitionError>),
    Request(Request),
    /// The server has stopped.
    Closed,
    /// The vehicle of the `plant_sim` with this name.
    Vehicle(String, Result<Vehicle, Error>),
    /// Feedback of the action with this name.
    Feedback(String, GoalId, ManoeuvreFeedback),
    Accepted(String, GoalId),
    Ended(
        String,
        GoalId,
        Result<(GoalStatus, ManoeuvreResult), planesman_node::Error>,
    ),
    Parameters,
}

/// State of a requested topic.
enum TopicRequest {
    /// The topic has no publisher yet.
    Missing,
    /// The definition of the topic's type has been requested.
    Defining,
    /// The feed with this index reads the topic.
    Open(usize),
    Refused(String),
}

/// The node's state.
pub(crate) struct Watch {
    board: SharedBoard,
    requests: smol::channel::Receiver<Request>,
    models: ModelFunctions,
    definitions: Definitions,
    feeds: Vec<Feed>,
    topics: BTreeMap<String, TopicRequest>,
    /// Requested fields by topic.
    channels: BTreeMap<String, BTreeSet<String>>,
    /// Latest stamp in each namespace, s.
    times: BTreeMap<String, f64>,
    nodes: Nodes,
    polls: u64,
    /// Number of messages of each feed at the last count, and the time of that count.
    counted: (Instant, Vec<u64>),
    /// Clients by type and name.
    clients: HashMap<(TypeId, String), Box<dyn Any>>,
    setpoints: BTreeMap<String, Publisher<Float64>>,
    manoeuvres: BTreeMap<String, ManoeuvreClient>,
    /// Number of parameter changes of each node.
    changes: BTreeMap<String, u64>,
    /// Number of vehicles with a pending request for parameters.
    asked: usize,
}

/// The manoeuvre of a page.
struct ManoeuvreClient {
    client: ActionClient<Manoeuvre>,
    goal: Option<GoalId>,
}

impl Watch {
    pub(crate) fn new(
        rt: &Runtime<Event>,
        board: SharedBoard,
        requests: smol::channel::Receiver<Request>,
        models: ModelFunctions,
    ) -> Result<Self, planesman_node::Error> {
        let log = planesman_msgs::type_info(Log::TYPE_NAME).map(|it| it.type_hash);
        // Raw, for the time at which a line was sent: its stamp may be of the machine or of a simulation.
        let qos = Qos::latched(1000);
        rt.subscribe_raw("/rosout", Log::TYPE_NAME, log, qos, Event::Log)?;
        rt.subscribe("/diagnostics", Qos::reliable(1000), Event::Diagnostics)?;
        rt.subscribe(
            "/parameter_events",
            Qos::reliable(1000),
            Event::ParameterEvent,
        )?;
        drop(rt.every(POLL_INTERVAL, || Event::Poll));
        let watch = Self {
            board,
            requests,
            models,
            definitions: Definitions::from_environment(),
            feeds: Vec::new(),
            topics: BTreeMap::new(),
            channels: BTreeMap::new(),
            times: BTreeMap::new(),
            nodes: Nodes::default(),
            polls: 0,
            counted: (Instant::now(), Vec::new()),
            clients: HashMap::new(),
            setpoints: BTreeMap::new(),
            manoeuvres: BTreeMap::new(),
            changes: BTreeMap::new(),
            asked: 0,
        };
        watch.listen(rt);
        Ok(watch)
    }

    /// Waits for the next request, and turns it into an event.
    fn listen(&self, rt: &Runtime<Event>) {
        let requests = self.requests.clone();
        rt.when_done(async move { requests.recv().await.map_or(Event::Closed, Event::Request) });
    }

    pub(crate) fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Flow {
        match event {
            Event::Sample(index, sample) => self.take(index, &sample),
            Event::Log(log) => self.log(&log),
            Event::Diagnostics(array) => {
                let own = format!("{}: ", rt.full_name());
                if array.status.iter().all(|it| !it.name.starts_with(&own)) {
                    self.nodes.heard(&array, Instant::now());
                }
            }
            Event::ParameterEvent(event) => self.parameters_changed(rt, &event.node),
            Event::Poll => self.poll(rt),
            Event::Found(topic, found) => self.open(rt, &topic, found),
            Event::Request(Request { command, reply }) => {
                self.execute(rt, command, reply);
                self.listen(rt);
            }
            Event::Closed => return Flow::Stop,
            Event::Vehicle(node, vehicle) => self.vehicle(&node, vehicle),
            Event::Feedback(action, id, feedback) => self.feedback(&action, id, &feedback),
            Event::Accepted(action, id) => self.accepted(rt, action, id),
            Event::Ended(action, id, outcome) => self.ended(&action, id, outcome),
            Event::Parameters => {}
        }
        Flow::Continue
    }

    /// Handles a message of a feed.
    fn take(&mut self, index: usize, sample: &RawSample) {
        let Some(feed) = self.feeds.get_mut(index) else {
            return;
        };
        let stamp = match feed.read(sample) {
            Ok(stamp) => stamp,
            Err(_) => return, // Told with the topic.
        };
        let namespace = namespace(&feed.topic).to_owned();
        let known = self.times.get(&namespace).copied();
        let time = match stamp {
            // A message that was never stamped has 0.
            Some(stamp) if stamp != 0.0 || known.is_none_or(|known| known < 1.0) => {
                self.times.insert(namespace.clone(), stamp);
                stamp
            }
            _ => self.time_in(&namespace, sample),
        };
        let feed = &self.feeds[index];
        let mut board = locked(&self.board);
        if feed.type_name == VehicleState::TYPE_NAME
            && let Ok(state) = cdr::from_bytes::<VehicleState>(&sample.bytes)
            && state.planes_source == VehicleState::PLANES_RESET
        {
            board.begin_anew(time, |channel| self::namespace(channel) == namespace);
        }
        for (channel, value) in feed.numbers() {
            board.push(channel, time, value);
        }
        if feed.type_name == ModelEstimate::TYPE_NAME
            && let Ok(model) = cdr::from_bytes::<ModelEstimate>(&sample.bytes)
        {
            self.models.tell(&mut board, &feed.topic, time, &model);
        }
    }

    /// Time of a message without a stamp: the vehicle's time, or else the time of arrival, s.
    fn time_in(&self, namespace: &str, sample: &RawSample) -> f64 {
        let mut place = namespace;
        loop {
            if let Some(time) = self.times.get(place) {
                return *time;
            }
            match place.rsplit_once('/') {
                Some((outer, _)) => place = outer,
                None => return sample.received.nanos() as f64 * 1e-9,
            }
        }
    }

    fn log(&mut self, sample: &RawSample) {
        let Ok(log) = cdr::from_bytes::<Log>(&sample.bytes) else {
            return;
        };
        let sent = sample.published.as_ref().unwrap_or(&sample.received);
        locked(&self.board).log(LogLine {
            time: sent.nanos() as f64 * 1e-9,
            level: log.level,
            node: bounded(&log.name).to_owned(),
            text: bounded(&log.msg).to_owned(),
        });
    }

    fn parameters_changed(&mut self, rt: &Runtime<Event>, node: &str) {
        let is_new = !self.changes.contains_key(node);
        if !is_new || (self.changes.len() < MAX_TOPICS && node.len() <= MAX_NAME_BYTES) {
            *self.changes.entry(node.to_owned()).or_default() += 1;
            locked(&self.board).put("parameters", json!(self.changes));
        }
        self.ask_vehicle(rt, node);
    }

    /// Looks for requested topics, and every second counts nodes and topics.
    fn poll(&mut self, rt: &Runtime<Event>) {
        let published = rt.published_topics();
        self.want_vehicles(&published);
        for topic in &published {
            if matches!(self.topics.get(&topic.name), Some(TopicRequest::Missing)) {
                self.topics
                    .insert(topic.name.clone(), TopicRequest::Defining);
                let (finding, topic) = (self.definitions.find(rt, topic), topic.clone());
                rt.when_done(async move { Event::Found(topic, finding.await) });
            }
        }
        if self.polls.is_multiple_of(POLLS_PER_COUNT) {
            self.count(rt, &published);
        }
        self.polls += 1;
    }

    /// Requests the default channels of each vehicle.
    fn want_vehicles(&mut self, published: &[PublishedTopic]) {
        for topic in published {
            let namespace = namespace(&topic.name);
            let name = topic.name[namespace.len()..].trim_start_matches('/');
            let is_ours = charts::TOPICS.contains(&(name, topic.type_name.as_str()));
            let vehicles = || {
                let open = self.topics.keys().filter(|it| it.ends_with("/state"));
                open.count()
            };
            if !is_ours || self.topics.contains_key(&topic.name) || vehicles() >= MAX_VEHICLES {
                continue;
            }
            for channel in charts::channels() {
                if channel.split_once(':').is_some_and(|(it, _)| it == name) {
                    let _ = self.want(&format!("{namespace}/{channel}"));
                }
            }
        }
    }

    /// Requests a channel: its topic is read once it exists.
    fn want(&mut self, channel: &str) -> Result<(), Error> {
        let (topic, field) = channel.split_once(':').ok_or(Error::Channel)?;
        if channel.len() > MAX_NAME_BYTES {
            return Err(Error::ChannelName(MAX_NAME_BYTES));
        }
        let fields = self.channels.get(topic);
        if fields.is_some_and(|it| it.contains(field)) {
            return Ok(());
        }
        match self.topics.get(topic) {
            Some(TopicRequest::Refused(reason)) => return Err(Error::Refused(reason.clone())),
            Some(TopicRequest::Open(index)) => self.attach(*index, channel, field)?,
            Some(TopicRequest::Missing | TopicRequest::Defining) | None => {}
        }
        let count = |channels: &BTreeMap<String, BTreeSet<String>>| {
            channels.values().map(BTreeSet::len).sum::<usize>()
        };
        if count(&self.channels) >= MAX_CHANNELS {
            self.forget_unread();
        }
        if count(&self.channels) >= MAX_CHANNELS {
            return Err(Error::Channels(MAX_CHANNELS));
        }
        let fields = self.channels.entry(topic.to_owned()).or_default();
        fields.insert(field.to_owned());
        let state = self.topics.entry(topic.to_owned());
        state.or_insert(TopicRequest::Missing);
        Ok(())
    }

    /// Drops channels that are not read: channels without a publisher, and refused channels.
    fn forget_unread(&mut self) {
        let mut board = locked(&self.board);
        self.channels.retain(|topic, fields| {
            fields.retain(|field| board.refusal(&format!("{topic}:{field}")).is_none());
            let state = self.topics.get(topic);
            matches!(state, Some(TopicRequest::Open(_) | TopicRequest::Defining))
                && !fields.is_empty()
        });
        let channels = &self.channels;
        self.topics.retain(|topic, state| {
            matches!(state, TopicRequest::Open(_) | TopicRequest::Defining)
                || channels.contains_key(topic)
        });
        board.forget_empty();
    }

    /// Adds a field of an open topic to a channel.
    fn attach(&mut self, index: usize, channel: &str, field: &str) -> Result<(), Error> {
        if field.starts_with('~') {
            return Ok(()); // Computed.
        }
        self.feeds[index].add(channel, field)
    }

    /// Subscribes to a topic whose type definition has arrived.
    fn open(
        &mut self,
        rt: &Runtime<Event>,
        topic: &PublishedTopic,
        found: Result<Definition, DefinitionError>,
    ) {
        let (name, index) = (&topic.name, self.feeds.len());
        let opened = found.map_err(Error::from).and_then(|definition| {
            let feed = Feed::new(name, &topic.type_name, &definition)?;
            let hash = (!definition.type_hash.is_empty()).then_some(definition.type_hash);
            let event = move |sample| Event::Sample(index, sample);
            // Best effort: a page that is slow does not hold up the loop.
            rt.subscribe_raw(
                name,
                &topic.type_name,
                hash.as_deref(),
                Qos::record(),
                event,
            )?;
            Ok(feed)
        });
        let fields = self.channels.get(name).cloned().unwrap_or_default();
        match opened {
            Ok(feed) => {
                self.feeds.push(feed);
                self.topics.insert(name.clone(), TopicRequest::Open(index));
                for field in &fields {
                    let channel = format!("{name}:{field}");
                    let refusal = self.attach(index, &channel, field).err();
                    locked(&self.board).channel(&channel).refusal =
                        refusal.map(|it| it.to_string());
                }
            }
            Err(reason) => {
                let reason = reason.to_string();
                let mut board = locked(&self.board);
                for field in &fields {
                    board.channel(&format!("{name}:{field}")).refusal = Some(reason.clone());
                }
                self.topics
                    .insert(name.clone(), TopicRequest::Refused(reason));
            }
        }
    }

    /// Counts nodes, topics, services and messages for the page.
    fn count(&mut self, rt: &Runtime<Event>, published: &[PublishedTopic]) {
        let now = Instant::now();
        let services = rt.services("");
        let own = rt.full_name();
        let names: Vec<String> = services
            .iter()
            .filter_map(|it| Some(it.strip_suffix("/get_parameters")?.to_owned()))
            .filter(|it| *it != own)
            .collect();
        for node in self.nodes.discovered(&names, now) {
            self.ask_vehicle(rt, &node);
        }
        for (action, running) in &mut self.manoeuvres {
            if running.goal.is_some() && !running.client.is_served() {
                running.goal = None;
                let lost = json!({"state": "lost", "message": "the controller no longer exists"});
                locked(&self.board).put(&format!("manoeuvre:{action}"), lost);
            }
        }
        let topics = self.told_topics(published, now);
        let vehicles = vehicles(published);
        let mut board = locked(&self.board);
        for namespace in vehicles.iter().take(MAX_VEHICLES) {
            if let Some(time) = self.times.get(*namespace) {
                let levels = self.nodes.levels(namespace, now);
                for (channel, level) in [WARNINGS, ERRORS].iter().zip(levels) {
                    board.push(&format!("{namespace}/{channel}"), *time, level as f64);
                }
            }
        }
        board.put("vehicles", json!(vehicles));
        board.put("topics", topics);
        board.put("nodes", self.nodes.told(now));
        board.put("diagnostics", self.nodes.told_statuses(now));
        let known = services.iter().filter(|name| is_command(name));
        board.put(
            "services",
            known.take(MAX_TOPICS).map(|it| bounded(it)).collect(),
        );
    }

    fn told_topics(&mut self, published: &[PublishedTopic], now: Instant) -> Value {
        let seconds = now.duration_since(self.counted.0).as_secs_f64();
        let received: Vec<u64> = self.feeds.iter().map(|feed| feed.received).collect();
        let rates = self.nodes.topic_rates();
        let topic = |topic: &PublishedTopic| {
            let read = match self.topics.get(&topic.name) {
                Some(TopicRequest::Open(index)) => Some(*index),
                _ => None,
            };
            let counted = read.map(|index| {
                let before = self.counted.1.get(index).copied().unwrap_or(0);
                (received[index] - before) as f64 / seconds
            });
            let feed = read.and_then(|index| self.feeds.get(index));
            json!({
                "name": bounded(&topic.name),
                "type": bounded(&topic.type_name),
                "publishers": topic.offers.len(),
                "rate": counted.or_else(|| rates.get(topic.name.as_str()).copied()).map(rounded),
                "lost": feed.map(|feed| feed.losses.missing()),
                "trouble": feed.and_then(|feed| feed.trouble.as_deref()),
            })
        };
        let told = published.iter().take(MAX_TOPICS).map(topic).collect();
        self.counted = (now, received);
        told
    }

    /// Requests a vehicle's parameters, from which its true poles are computed.
    fn ask_vehicle(&mut self, rt: &Runtime<Event>, node: &str) {
        if !node.ends_with("/plant_sim") || self.asked >= MAX_VEHICLES {
            return;
        }
        let Ok(asking) = self.ask_parameters(rt, node) else {
            return;
        };
        self.asked += 1;
        let (node, models) = (node.to_owned(), self.models);
        rt.when_done(async move {
            let vehicle = match asking.await {
                Err(reason) => Err(reason),
                Ok(all) => {
                    let values = all.into_iter().map(|it| it.parameter);
                    let values = values.filter_map(|it| Some((it.name, value_of(it.value)?)));
                    let values: Vec<_> = values.collect();
                    // On a thread of its own: its file may lie on a disk that does not answer.
                    smol::unblock(move || (models.vehicle)(&values))
                        .await
                        .map_err(Error::from)
                }
            };
            Event::Vehicle(node, vehicle)
        });
    }

    fn vehicle(&mut self, node: &str, vehicle: Result<Vehicle, Error>) {
        self.asked -= 1;
        let told = match vehicle {
            Ok(vehicle) => json!(vehicle),
            Err(reason) => json!({"reason": reason.to_string()}),
        };
        let place = namespace(node);
        locked(&self.board).put(&format!("vehicle:{place}"), told);
    }
}

/// The namespace of a name: `/auv` for `/auv/state`, empty for `/state`.
fn namespace(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(namespace, _)| namespace)
}

/// The namespaces that contain topics of a loop; namespaces of vehicles come first.
fn vehicles(published: &[PublishedTopic]) -> Vec<&str> {
    let is_ours = |topic: &&PublishedTopic| {
        let name = topic.name.rsplit('/').next().unwrap_or_default();
        charts::TOPICS.contains(&(name, topic.type_name.as_str()))
    };
    let is_shown = |topic: &&PublishedTopic| !topic.name.contains("/_");
    let ours: BTreeSet<&str> = published
        .iter()
        .filter(is_ours)
        .map(|it| namespace(&it.name))
        .collect();
    let others: BTreeSet<&str> = published
        .iter()
        .filter(is_shown)
        .map(|it| namespace(&it.name))
        .filter(|it| !it.is_empty() && !ours.contains(it))
        .collect();
    ours.into_iter().chain(others).take(MAX_TOPICS).collect()
}

/// Whether the page has a button for the service.
fn is_command(service: &str) -> bool {
    [
        "/pause",
        "/step",
        "/reset",
        "/fit",
        "/freeze",
        "/reset_fault",
        "/resume",
        "/split_bagfile",
        "/manoeuvre/_action/send_goal",
    ]
    .iter()
    .any(|ending| service.ends_with(ending))
}
