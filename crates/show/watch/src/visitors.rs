//! Limits of connections, per address and in total. If the limit is reached, a new connection replaces an old one.
//!
//! Connections without the token are closed first, then connections without an event stream; within these, the oldest connection of the address with
//! the most connections.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::oneshot;

/// Maximum number of connections per address and in total.
#[derive(Clone, Copy)]
struct Places {
    each: usize,
    all: usize,
}

/// All connections.
const CONNECTIONS: Places = Places { each: 64, all: 256 };
/// Event streams, one per open page. A browser opens at most six per address.
const STREAMS: Places = Places { each: 16, all: 32 };

/// State of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// The visitor has not sent the token yet.
    Unknown,
    Known,
    Stream,
}

struct Entry {
    address: IpAddr,
    stage: Stage,
    /// Dropping this sender closes the connection.
    _close: oneshot::Sender<()>,
}

#[derive(Default)]
struct Table {
    /// Connections by number, in order of arrival.
    entries: BTreeMap<u64, Entry>,
    last: u64,
}

impl Table {
    /// Makes room for one more connection from this address among the connections that have reached `stage`.
    fn make_room(&mut self, address: IpAddr, stage: Stage, places: Places) {
        let mut counts: BTreeMap<IpAddr, usize> = BTreeMap::new();
        for entry in self.entries.values().filter(|it| it.stage >= stage) {
            *counts.entry(entry.address).or_default() += 1;
        }
        let own_are_full = counts.get(&address).is_some_and(|it| *it >= places.each);
        if !own_are_full && counts.values().sum::<usize>() < places.all {
            return;
        }
        let candidates = self
            .entries
            .iter()
            .filter(|(_, it)| it.stage >= stage && (!own_are_full || it.address == address));
        let goes = candidates.min_by_key(|(id, it)| (it.stage, Reverse(counts[&it.address]), **id));
        if let Some(id) = goes.map(|(id, _)| *id) {
            self.entries.remove(&id);
        }
    }
}

/// All connections of a server.
#[derive(Clone, Default)]
pub(crate) struct Visitors(Arc<Mutex<Table>>);

/// One connection; each of its requests carries it along.
#[derive(Clone)]
pub(crate) struct Visitor {
    id: u64,
    visitors: Visitors,
}

impl Visitors {
    fn table(&self) -> MutexGuard<'_, Table> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection; it must be closed when the receiver is ready.
    pub(crate) fn enter(&self, address: IpAddr) -> (Visitor, oneshot::Receiver<()>) {
        let mut table = self.table();
        table.make_room(address, Stage::Unknown, CONNECTIONS);
        table.last += 1;
        let id = table.last;
        let (close, closed) = oneshot::channel();
        let entry = Entry {
            address,
            stage: Stage::Unknown,
            _close: close,
        };
        table.entries.insert(id, entry);
        let visitors = self.clone();
        (Visitor { id, visitors }, closed)
    }
}

impl Visitor {
    /// The token has been shown.
    pub(crate) fn is_known(&self) {
        let mut table = self.visitors.table();
        if let Some(entry) = table.entries.get_mut(&self.id) {
            entry.stage = entry.stage.max(Stage::Known);
        }
    }

    /// An event stream begins, for which another one may have to end.
    pub(crate) fn begins_stream(&self) {
        let mut table = self.visitors.table();
        if let Some(address) = table.entries.get(&self.id).map(|it| it.address) {
            table.make_room(address, Stage::Stream, STREAMS);
        }
        if let Some(entry) = table.entries.get_mut(&self.id) {
            entry.stage = Stage::Stream;
        }
    }

    /// The connection has ended.
    pub(crate) fn leave(&self) {
        self.visitors.table().entries.remove(&self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(last: u8) -> IpAddr {
        [192, 0, 2, last].into()
    }

    /// Whether the connection is to be closed.
    fn is_closed(closed: &mut oneshot::Receiver<()>) -> bool {
        !matches!(closed.try_recv(), Err(oneshot::error::TryRecvError::Empty))
    }

    #[test]
    fn silent_connections_give_way_to_those_that_come_after_them_and_never_a_known_one() {
        let visitors = Visitors::default();
        let (page, mut page_closed) = visitors.enter(address(1));
        page.is_known();
        let mut silent: Vec<_> = (0..990).map(|_| visitors.enter(address(1)).1).collect();
        let open = silent
            .iter_mut()
            .filter_map(|it| (!is_closed(it)).then_some(()));
        assert_eq!(open.count(), CONNECTIONS.each - 1);
        assert!(!is_closed(&mut page_closed));
        // However many addresses there are.
        let mut others: Vec<_> = (0..=255)
            .flat_map(|last| [address(last), address(last)])
            .map(|it| visitors.enter(it).1)
            .collect();
        let open = others
            .iter_mut()
            .filter_map(|it| (!is_closed(it)).then_some(()));
        assert!(open.count() < CONNECTIONS.all && !is_closed(&mut page_closed));
        page.leave();
        assert!(visitors.table().entries.len() < CONNECTIONS.all);
    }

    #[test]
    fn of_too_many_streams_the_oldest_of_the_address_that_has_most_ends() {
        let visitors = Visitors::default();
        let stream = |last| {
            let (visitor, closed) = visitors.enter(address(last));
            visitor.is_known();
            visitor.begins_stream();
            closed
        };
        let mut first = stream(1);
        let mut of_one: Vec<_> = (0..STREAMS.each + 3).map(|_| stream(2)).collect();
        let closed: Vec<bool> = of_one.iter_mut().map(is_closed).collect();
        assert_eq!(closed.iter().filter(|it| **it).count(), 3);
        assert!(closed[..3].iter().all(|it| *it), "the oldest");
        // 17 are open: with those of 16 other addresses it is the hog's that end, one for each.
        let mut others: Vec<_> = (3..19).map(stream).collect();
        let closed = of_one.iter_mut().map(is_closed).filter(|it| *it);
        assert_eq!(closed.count(), 3 + 1);
        assert!(!is_closed(&mut first) && !others.iter_mut().any(is_closed));
    }
}
