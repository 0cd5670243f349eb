//! The answers that wait to be sent: [`answers`](crate::answers) looks after them.

use std::{cell::RefCell, collections::VecDeque};

use ros2_client::error::WriteError;
use rustdds::GUID;

/// An attempt to send an answer, again if there was no room.
pub(crate) type Send = Box<dyn FnMut() -> Result<(), WriteError<()>>>;

/// One that waits.
pub(crate) struct Waiting {
    /// The service's name.
    pub(crate) service: String,
    pub(crate) client: GUID,
    /// Whether our writer is matched with the client's reader.
    pub(crate) matched: bool,
    pub(crate) looks: u32,
    pub(crate) send: Send,
}

/// All that wait, oldest first.
#[derive(Default)]
pub(crate) struct Answers {
    pub(crate) waiting: RefCell<VecDeque<Waiting>>,
}
