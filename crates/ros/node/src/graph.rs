//! What the node tells of itself on `ros_discovery_info`: its name and its endpoints. ROS tools list nodes by it.
//!
//! It is told whenever an endpoint is new, and anew whenever a reader has lost this participant and found it again, as
//! after a pause that was longer than the lease: Fast DDS takes no sample twice that it has had before, though the node
//! is no longer in its lists.

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

/// Least time between two repetitions: anybody can make a reader's acknowledgements up.
const REPETITION_PERIOD: Duration = Duration::from_millis(50);

/// Readers remembered; then all are met anew.
const MAX_READERS: usize = 1000;

pub(crate) struct Graph {
    context: Context,
    writer: Publisher<ParticipantEntitiesInfo>,
    /// Those that have been matched.
    readers: RefCell<HashSet<GUID>>,
    repeated: Cell<Option<Instant>>,
}

impl Graph {
    /// Makes the context's own writer, which cannot be asked to repeat what it has told, silent. To be called before there
    /// is a context.
    pub(crate) fn replace_writer_of_context(participant: &DomainParticipant) {
        participant.withhold_next_writer(TOPIC_NAME);
    }

    /// # Errors
    /// When the middleware refuses.
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

    /// Tells what there is now.
    pub(crate) fn tell(&self) {
        let info = self.context.participant_entities_info();
        if let Err(error) = self.writer.publish(info) {
            log::warn!("tools may not list this node: {error}");
        }
    }

    /// Tells it anew where a reader matches again.
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
