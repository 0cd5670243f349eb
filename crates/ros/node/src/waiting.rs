//! Queue of pending answers, handled by [`answers`](crate::answers).

use std::{cell::RefCell, collections::VecDeque};

use ros2_client::error::WriteError;
use rustdds::GUID;

/// Tries to send an answer; called again if there was no space.
pub(crate) type Send = Box<dyn FnMut() -> Result<(), WriteError<()>>>;

/// A pending answer.
pub(crate) struct Waiting {
    /// The service's name.
    pub(crate) service: String,
    pub(crate) client: GUID,
    /// Whether our writer is matched with the client's reader.
    pub(crate) matched: bool,
    pub(crate) looks: u32,
    pub(crate) send: Send,
}

/// All pending answers, oldest first.
#[derive(Default)]
pub(crate) struct Answers {
    pub(crate) waiting: RefCell<VecDeque<Waiting>>,
}
