//! The node's entry on `ros_discovery_info`, with the node's name and endpoints. ROS tools list nodes by these entries.
//!
//! The entry is published whenever an endpoint is added, and again when a reader has lost this participant and rediscovered it, for example
//! after a pause longer than the lease. Fast DDS ignores a repeated sample, although the node is no longer in its lists.

use std::{
    cell::{Cell, RefCell},
    collections::HashSet,
    time::{Duration, Instant},
};

use ros2_client::{
    Context, Node, Publisher,
    builtin_topics::ros_discovery::{QOS_PUB, TOPIC_NAME, TYPE_NAME},
    entities_info::ParticipantEntitiesInfo,
};
use rustdds::{DomainParticipant, DomainParticipantStatusEvent as Event, GUID, TopicKind};

use crate::error::{Error, Result};

/// Minimum time between two repetitions: anyone can fake a reader's acknowledgements.
const REPETITION_PERIOD: Duration = Duration::from_millis(50);

/// Maximum number of readers remembered; beyond this number all readers count as new.
const MAX_READERS: usize = 1000;

pub(crate) struct Graph {
    context: Context,
    writer: Publisher<ParticipantEntitiesInfo>,
    /// Readers that have been matched.
    readers: RefCell<HashSet<GUID>>,
    repeated: Cell<Option<Instant>>,
}

impl Graph {
    /// Replaces the context's own writer, which cannot repeat its samples. Must be called before a context exists.
    pub(crate) fn replace_writer_of_context(participant: &DomainParticipant) {
        participant.withhold_next_writer(TOPIC_NAME);
    }

    /// # Errors
    /// An error of the middleware.
    pub(crate) fn new(
        participant: &DomainParticipant,
        context: Context,
        node: &mut Node,
    ) -> Result<Self> {
        let topic = participant.create_topic(
            TOPIC_NAME.to_owned(),
            TYPE_NAME.to_owned(),
            &QOS_PUB,
            TopicKind::NoKey,
        );
        let topic = topic.map_err(Error::middleware)?;
        let writer = node.create_publisher(&topic, None);
        let graph = Self {
            context,
            writer: writer.map_err(Error::middleware)?,
            readers: RefCell::default(),
            repeated: Cell::default(),
        };
        graph.tell();
        Ok(graph)
    }

    /// Publishes the present entry.
    pub(crate) fn tell(&self) {
        let info = self.context.participant_entities_info();
        if let Err(error) = self.writer.publish(info) {
            log::warn!("ROS 2 tools may not list this node: {error}");
        }
    }

    /// Publishes the entry again when a reader matches again.
    pub(crate) fn on(&self, event: &Event) {
        if let Event::RemoteReaderMatched {
            local_writer,
            remote_reader,
        } = event
            && *local_writer == self.writer.guid()
        {
            let mut readers = self.readers.borrow_mut();
            if readers.len() >= MAX_READERS {
                readers.clear();
            }
            let is_new = readers.insert(*remote_reader);
            let repeated = self.repeated.get();
            if !is_new && repeated.is_none_or(|at| at.elapsed() > REPETITION_PERIOD) {
                self.repeated.set(Some(Instant::now()));
                self.tell();
            }
        }
    }
}
