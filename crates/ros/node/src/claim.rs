//! Claim to an exclusive role in a domain, such as the launcher of a loop or the vehicle.
//!
//! A node publishes its claim in its diagnostics, once a second and when a new participant appears, and reads the claims of others. A claim
//! counts only while its participant has the endpoint of the role: for the vehicle a writer of its state. Of two claims to one role, the claim at the
//! later stage has priority (requested, held, in use), then the claim with the lower identity; clocks are not used. Both sides apply the same rule, and
//! a stage never goes back. A node that finds a claim with priority over its own must end, and names the other. **A role in use is never given up**:
//! two loops that meet in flight both continue, and both report it.

use std::{
    cell::RefCell,
    cmp::Reverse,
    collections::BTreeMap,
    rc::Rc,
    time::{Duration, Instant},
};

use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use rustdds::RTPSEntity as _;

use crate::{
    diagnostics::{self, Level},
    discovered::{self, ParticipantId},
    shared::Shared,
};

/// Lifetime of a claim after its last message: a few periods of the diagnostics, s.
const CLAIM_LIFETIME: Duration = Duration::from_millis(2500);

/// The stage of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Requested; another node may hold the role.
    Asked,
    /// Held; no other claim was found.
    Held,
    /// The role is in use.
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

/// One party of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Party {
    stage: Stage,
    /// Participant that sent the claim.
    id: ParticipantId,
    /// Name, such as `process 4711 on host`.
    who: String,
}

impl Party {
    /// Whether this claim has priority over `other`.
    fn precedes(&self, other: &Self) -> bool {
        let rank = |party: &Self| (Reverse(party.stage), party.id);
        rank(self) < rank(other)
    }

    fn to_values(&self) -> [(&'static str, String); 2] {
        [
            ("stage", self.stage.name().to_owned()),
            ("who", self.who.clone()),
        ]
    }

    fn from_status(status: &DiagnosticStatus, id: ParticipantId) -> Option<Self> {
        let value = |key: &str| {
            let found = status.values.iter().find(|pair| pair.key == key);
            found.map(|pair| pair.value.clone())
        };
        Some(Self {
            stage: Stage::named(&value("stage")?)?,
            id,
            who: value("who")?,
        })
    }
}

/// All claims to the same role.
#[derive(Debug)]
struct Book {
    own: Party,
    others: BTreeMap<ParticipantId, (Party, Instant)>,
}

/// Maximum number of other claims.
const MAX_CLAIMS: usize = 100;

impl Book {
    fn observe(&mut self, party: Party, now: Instant) {
        self.others
            .retain(|_, (_, seen)| now.duration_since(*seen) < CLAIM_LIFETIME);
        if party.id != self.own.id && self.others.len() < MAX_CLAIMS {
            self.others.insert(party.id, (party, now));
        }
    }

    /// The other claims that are alive.
    fn living(&self, now: Instant) -> impl Iterator<Item = &Party> {
        let living = self.others.values();
        let living = living.filter(move |(_, seen)| now.duration_since(*seen) < CLAIM_LIFETIME);
        living.map(|(party, _)| party)
    }

    /// The claim with priority over this node's claim, among claims that are `evident`; `None` if this node's role is in use.
    fn holder(&self, now: Instant, evident: impl Fn(&Party) -> bool) -> Option<&Party> {
        self.living(now)
            .filter(|_| self.own.stage < Stage::Used)
            .find(|other| other.precedes(&self.own) && evident(other))
    }
}

/// Whether the status with this name, `NODE: NAME`, is a claim.
#[must_use]
pub fn is_status(name: &str) -> bool {
    let name = name.split_once(": ").map_or(name, |(_, it)| it);
    name.starts_with(PREFIX)
}

/// Beginning of a claim's status name; the subject follows.
const PREFIX: &str = "claim to ";

/// A node's claim. The claim stays in force until the node ends, even if this value is dropped.
#[derive(Clone)]
pub struct Claim {
    shared: Rc<Shared>,
    subject: Rc<str>,
    /// DDS topic on which the holder of the role has a writer.
    evidence: Rc<str>,
    book: Rc<RefCell<Book>>,
}

impl Claim {
    pub(crate) fn new(shared: &Rc<Shared>, subject: &str, evidence: &str) -> Self {
        let participant = shared.participant();
        let id = participant.and_then(|it| discovered::prefix(it.guid()));
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let process = std::process::id();
        let claim = Self {
            shared: Rc::clone(shared),
            subject: subject.into(),
            evidence: evidence.into(),
            book: Rc::new(RefCell::new(Book {
                own: Party {
                    stage: Stage::Asked,
                    id: id.unwrap_or_default(),
                    who: format!("process {process} on {}", host.trim()),
                },
                others: BTreeMap::new(),
            })),
        };
        claim.tell();
        claim
    }

    /// Reads the claims in a participant's diagnostics.
    pub(crate) fn observe(&self, array: &DiagnosticArray, sender: ParticipantId) {
        let name = self.status_name();
        for status in &array.status {
            if let Some((_, rest)) = status.name.split_once(": ")
                && rest == name
                && let Some(party) = Party::from_status(status, sender)
            {
                self.book.borrow_mut().observe(party, Instant::now());
            }
        }
    }

    /// Advances the stage of the claim; it never goes back.
    pub fn advance_to(&self, stage: Stage) {
        let own = self.book.borrow().own.stage;
        if stage > own {
            self.book.borrow_mut().own.stage = stage;
            self.tell();
        }
    }

    /// The party with priority over this node, such as `process 4711 on host`.
    #[must_use]
    pub fn holder(&self) -> Option<String> {
        let book = self.book.borrow();
        let holder = book.holder(Instant::now(), |party| self.is_evident(party));
        holder.map(|party| party.who.clone())
    }

    /// Any other party that claims the role.
    #[must_use]
    pub fn rival(&self) -> Option<String> {
        let book = self.book.borrow();
        let mut living = book.living(Instant::now());
        let rival = living.find(|party| self.is_evident(party));
        rival.map(|party| party.who.clone())
    }

    /// Whether the party has the endpoint of the role.
    fn is_evident(&self, party: &Party) -> bool {
        let participant = self.shared.participant();
        participant.is_some_and(|it| discovered::writes(&it, &self.evidence, party.id))
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
        self.shared.request_diagnostics();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn party(stage: Stage, id: u8) -> Party {
        Party {
            stage,
            id: [id; 12],
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
            .flat_map(|stage| [1, 2].map(|id| party(stage, id)))
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
        assert!(party(Stage::Held, 2).precedes(&party(Stage::Asked, 1)));
        assert!(party(Stage::Held, 1).precedes(&party(Stage::Held, 2)));
    }

    #[test]
    fn who_was_heard_of_lately_and_goes_before_us_holds_it() {
        let now = Instant::now();
        let all = |_: &Party| true;
        let mut book = book(party(Stage::Asked, 2));
        assert_eq!(book.holder(now, all), None);
        book.observe(party(Stage::Used, 2), now);
        assert_eq!(book.holder(now, all), None, "our own claim");
        book.observe(party(Stage::Asked, 3), now);
        assert_eq!(book.holder(now, all), None);
        assert_eq!(book.living(now).count(), 1);
        book.observe(party(Stage::Asked, 1), now);
        let holder = book.holder(now, all).map(|it| it.who.as_str());
        assert_eq!(holder, Some("process 1 on here"));
        assert_eq!(book.holder(now, |_| false), None, "no endpoint");
        assert_eq!(book.holder(now + CLAIM_LIFETIME, all), None, "silent since");
        book.own.stage = Stage::Held;
        assert_eq!(book.holder(now, all), None);
        book.observe(party(Stage::Used, 1), now);
        assert!(book.holder(now, all).is_some());
        book.own.stage = Stage::Used;
        assert_eq!(book.holder(now, all), None, "a role in use");
    }

    #[test]
    fn a_claim_reads_back_as_it_was_told() {
        let own = party(Stage::Held, 7);
        let status =
            diagnostics::status("/auv/planesman", "claim", Level::Ok, "", &own.to_values());
        assert_eq!(Party::from_status(&status, own.id), Some(own));
        assert_eq!(
            Party::from_status(&DiagnosticStatus::default(), [0; 12]),
            None
        );
    }
}
