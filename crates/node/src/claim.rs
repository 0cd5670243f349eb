//! A claim to an exclusive role in a domain: the launcher of a loop, the vehicle.
//!
//! A node publishes its claim in its diagnostics, once a second and when a new participant appears, and reads the
//! claims of others. Of two claims to one role the one at the later stage has priority (asked for, held, in use),
//! then the older. Both sides apply the same rule, and a stage only ever rises, so exactly one continues; a node that
//! finds a claim with priority over its own must end, and names the other.

use std::{
    cell::RefCell,
    cmp::Reverse,
    collections::BTreeMap,
    rc::Rc,
    time::{Duration, Instant},
};

use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};

use crate::{
    clock,
    diagnostics::{self, Level},
    shared::Shared,
};

/// Lifetime of a claim after its last message: a few periods of the diagnostics.
const LIFE: Duration = Duration::from_millis(2500);

/// The stage of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Asked for; another node may hold it.
    Asked,
    /// Held; no other node was found.
    Held,
    /// The claimed role is in use.
    Used,
}

impl Stage {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Asked, "asked"),
        (Self::Held, "held"),
        (Self::Used, "used"),
    ];

    fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    fn named(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find_map(|(stage, known)| (known == name).then_some(stage))
    }
}

/// One side of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Party {
    stage: Stage,
    /// When it was first claimed, ns since 1970.
    since: i64,
    /// The claimer's own, for the rare case of two at one instant.
    id: String,
    /// `process 4711 on host`.
    who: String,
}

impl Party {
    /// Whether this goes before `other`.
    fn precedes(&self, other: &Self) -> bool {
        let rank = |party: &Self| (Reverse(party.stage), party.since, party.id.clone());
        rank(self) < rank(other)
    }

    fn to_values(&self) -> [(&'static str, String); 4] {
        [
            ("stage", self.stage.name().to_owned()),
            ("since", self.since.to_string()),
            ("id", self.id.clone()),
            ("who", self.who.clone()),
        ]
    }

    fn from_status(status: &DiagnosticStatus) -> Option<Self> {
        let value = |key: &str| {
            let found = status.values.iter().find(|pair| pair.key == key);
            found.map(|pair| pair.value.clone())
        };
        Some(Self {
            stage: Stage::named(&value("stage")?)?,
            since: value("since")?.parse().ok()?,
            id: value("id")?,
            who: value("who")?,
        })
    }
}

/// All parties that claim the same role.
#[derive(Debug)]
struct Book {
    own: Party,
    others: BTreeMap<String, (Party, Instant)>,
}

/// Largest number of other claims.
const MOST: usize = 100;

impl Book {
    fn observe(&mut self, party: Party, now: Instant) {
        self.others
            .retain(|_, (_, seen)| now.duration_since(*seen) < LIFE);
        if party.id != self.own.id && self.others.len() < MOST {
            self.others.insert(party.id.clone(), (party, now));
        }
    }

    /// The others whose claims are alive.
    fn living(&self, now: Instant) -> impl Iterator<Item = &Party> {
        let living = self.others.values();
        let living = living.filter(move |(_, seen)| now.duration_since(*seen) < LIFE);
        living.map(|(party, _)| party)
    }

    /// The claim with priority over ours.
    fn holder(&self, now: Instant) -> Option<&Party> {
        self.living(now).find(|other| other.precedes(&self.own))
    }
}

/// Whether the status of that name, `NODE: NAME`, is a claim's.
#[must_use]
pub fn is_status(name: &str) -> bool {
    let name = name.split_once(": ").map_or(name, |(_, it)| it);
    name.starts_with(PREFIX)
}

/// How the status of a claim begins; its subject follows.
const PREFIX: &str = "claim to ";

/// A node's claim. Dropping it leaves it standing until the node ends.
#[derive(Clone)]
pub struct Claim {
    shared: Rc<Shared>,
    subject: Rc<str>,
    book: Rc<RefCell<Book>>,
}

impl Claim {
    pub(crate) fn new(shared: &Rc<Shared>, subject: &str) -> Self {
        let since = clock::wall().nanos();
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let process = std::process::id();
        let claim = Self {
            shared: Rc::clone(shared),
            subject: subject.into(),
            book: Rc::new(RefCell::new(Book {
                own: Party {
                    stage: Stage::Asked,
                    since,
                    id: shared.identity(),
                    who: format!("process {process} on {}", host.trim()),
                },
                others: BTreeMap::new(),
            })),
        };
        claim.tell();
        claim
    }

    /// Reads the claims in a diagnostics message.
    pub(crate) fn observe(&self, array: &DiagnosticArray) {
        let name = self.status_name();
        for status in &array.status {
            if let Some((_, rest)) = status.name.split_once(": ")
                && rest == name
                && let Some(party) = Party::from_status(status)
            {
                self.book.borrow_mut().observe(party, Instant::now());
            }
        }
    }

    /// The claim has come further; it never goes back.
    pub fn rise_to(&self, stage: Stage) {
        let own = self.book.borrow().own.stage;
        if stage > own {
            self.book.borrow_mut().own.stage = stage;
            self.tell();
        }
    }

    /// The party with priority over us: `process 4711 on host`.
    #[must_use]
    pub fn holder(&self) -> Option<String> {
        let book = self.book.borrow();
        book.holder(Instant::now()).map(|party| party.who.clone())
    }

    /// Whoever else claims it.
    #[must_use]
    pub fn rival(&self) -> Option<String> {
        let book = self.book.borrow();
        let mut living = book.living(Instant::now());
        living.next().map(|party| party.who.clone())
    }

    fn status_name(&self) -> String {
        format!("{PREFIX}{}", self.subject)
    }

    fn tell(&self) {
        let own = self.book.borrow().own.clone();
        let (name, values) = (self.status_name(), own.to_values());
        let node = self.shared.names.full();
        let status = diagnostics::status(&node, &name, Level::Ok, own.stage.name(), &values);
        self.shared.statuses.borrow_mut().insert(name, status);
        self.shared.announce_news();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn party(stage: Stage, since: i64, id: &str) -> Party {
        Party {
            stage,
            since,
            id: id.to_owned(),
            who: format!("process {id} on here"),
        }
    }

    fn book(own: Party) -> Book {
        Book {
            own,
            others: BTreeMap::new(),
        }
    }

    #[test]
    fn of_two_claims_exactly_one_goes_before_the_other() {
        let all: Vec<Party> = [Stage::Asked, Stage::Held, Stage::Used]
            .into_iter()
            .flat_map(|stage| [1, 2].map(|since| ["a", "b"].map(|id| party(stage, since, id))))
            .flatten()
            .collect();
        for one in &all {
            for other in all.iter().filter(|other| *other != one) {
                assert_ne!(
                    one.precedes(other),
                    other.precedes(one),
                    "{one:?} {other:?}"
                );
            }
        }
        assert!(party(Stage::Held, 2, "b").precedes(&party(Stage::Asked, 1, "a")));
        assert!(party(Stage::Held, 1, "b").precedes(&party(Stage::Held, 2, "a")));
    }

    #[test]
    fn who_was_heard_of_lately_and_goes_before_us_holds_it() {
        let now = Instant::now();
        let mut book = book(party(Stage::Asked, 2, "us"));
        assert_eq!(book.holder(now), None);
        book.observe(party(Stage::Used, 1, "us"), now);
        assert_eq!(book.holder(now), None, "our own claim");
        book.observe(party(Stage::Asked, 3, "later"), now);
        assert_eq!(book.holder(now), None);
        assert_eq!(book.living(now).count(), 1);
        book.observe(party(Stage::Asked, 1, "earlier"), now);
        assert_eq!(
            book.holder(now).map(|p| p.who.as_str()),
            Some("process earlier on here")
        );
        assert_eq!(book.holder(now + LIFE), None, "silent since");
        book.own.stage = Stage::Held;
        assert_eq!(book.holder(now), None);
    }

    #[test]
    fn a_claim_reads_back_as_it_was_told() {
        let own = party(Stage::Held, 1_700_000_000_000_000_000, "a");
        let status =
            diagnostics::status("/auv/planesman", "claim", Level::Ok, "", &own.to_values());
        assert_eq!(Party::from_status(&status), Some(own));
        assert_eq!(Party::from_status(&DiagnosticStatus::default()), None);
    }
}
