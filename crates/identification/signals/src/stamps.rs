//! The clocks of a bag: whether the stamps of its messages are usable, and how they differ from the recorder's.

use crate::request::Clock;
use planesman_text::setting;

/// Number of messages of a topic whose delay from stamp to reception is examined.
const DELAYS: usize = 10_000;

/// Lags between stamp and reception from this value on are reported, s.
const LAG: f64 = 1e-3;

/// No message takes this long to reach the recorder, s; a larger delay means that the clocks differ.
const OTHER_CLOCK: f64 = 60.0;

/// A stamp this long after its reception comes from another clock, or belongs to a prediction, s.
const AHEAD: f64 = 0.1;

/// Stamps below this are relative to a start, ns: a hundred days.
const CALENDAR: i64 = 8_640_000_000_000_000;

/// Number of messages needed to judge stamps.
const FEW: u64 = 20;

/// The stamps of a topic, in the order of its messages.
#[derive(Clone, Debug)]
pub struct Stamps {
    pub(crate) topic: String,
    messages: u64,
    last: Option<i64>,
    /// Number of stamps equal to the previous stamp, and of unfilled stamps.
    repeats: u64,
    unfilled: u64,
    /// The newest, ns.
    newest: i64,
    /// Delays from a message's stamp to its reception by the recorder, ns.
    delays: Vec<i64>,
}

impl Stamps {
    /// The stamps of a topic before its first message.
    #[must_use]
    pub fn of(topic: &str) -> Self {
        Self {
            topic: topic.to_owned(),
            messages: 0,
            last: None,
            repeats: 0,
            unfilled: 0,
            newest: 0,
            delays: Vec::new(),
        }
    }

    /// The stamps of the same topic, again before its first message, but with the stamps already known up to this one.
    pub(crate) fn anew(&self) -> Self {
        Self {
            newest: self.newest,
            ..Self::of(&self.topic)
        }
    }

    /// Takes a message's own stamp, if it has one. Returns whether that stamp is filled. A zero may be the beginning of simulated time. A zero stamp
    /// counts as unfilled after another zero, and if other stamps are calendar dates.
    pub fn take(&mut self, own: Option<i64>, log_time: i64) -> bool {
        let stamp = own.unwrap_or(log_time);
        self.messages += 1;
        self.newest = self.newest.max(stamp);
        let is_repeat = self.last == Some(stamp);
        let is_filled = own != Some(0) || !(is_repeat || self.newest > CALENDAR);
        self.repeats += u64::from(is_repeat);
        self.last = Some(stamp);
        self.unfilled += u64::from(!is_filled);
        if let Some(own) = own
            && own != 0
            && self.delays.len() < DELAYS
        {
            self.delays.push(log_time.saturating_sub(own));
        }
        is_filled
    }

    pub(crate) fn messages(&self) -> u64 {
        self.messages
    }

    /// The median time from a message's stamp to its reception, s; `None` if its stamps are not usable.
    fn latency(&mut self) -> Option<f64> {
        if self.unfit().is_some() {
            return None;
        }
        let middle = self.delays.len().checked_sub(1)? / 2;
        let (_, median, _) = self.delays.select_nth_unstable(middle);
        Some(*median as f64 * 1e-9)
    }

    /// The reason why the topic's stamps do not show when its messages were sent.
    #[must_use]
    pub fn unfit(&self) -> Option<String> {
        let all = |count: u64| self.messages >= FEW && count >= self.messages / 10 * 9;
        let topic = &self.topic;
        if all(self.unfilled) {
            return Some(format!("the headers of {topic} contain no stamp (stamp 0)"));
        }
        all(self.repeats).then(|| {
            format!(
                "the stamps of {topic} do not advance: {} of {} equal the previous stamp",
                self.repeats, self.messages
            )
        })
    }

    /// A note on messages that are repeated, or without a stamp.
    #[must_use]
    pub fn note(&self, clock: Clock) -> Option<String> {
        let messages = self.messages;
        let half = messages / 2;
        if messages >= FEW && self.repeats.abs_diff(half) <= messages / 20 {
            return Some(format!(
                "{} of {messages} messages have the same stamp as the previous message: they were recorded twice, or come from two publishers",
                self.repeats
            ));
        }
        (clock == Clock::Header && self.unfilled > 0).then(|| {
            format!(
                "{} of {messages} messages have no stamp (0) and are left out; {} uses the recorder's time",
                self.unfilled,
                setting("stamp", "log")
            )
        })
    }
}

/// The reason why the stamps of these topics are not usable.
pub(crate) fn unusable_stamps_reason(topics: &[Stamps]) -> Option<String> {
    topics.iter().find_map(Stamps::unfit)
}

/// The reason why the stamps of these topics cannot be compared.
pub(crate) fn unfit(topics: &mut [Stamps]) -> Option<String> {
    if let Some(reason) = unusable_stamps_reason(topics) {
        return Some(reason);
    }
    let latencies = latencies(topics);
    let (least, most) = range(&latencies)?;
    let is_ahead = least < -AHEAD && most - least > AHEAD;
    (most - least > OTHER_CLOCK || is_ahead).then(|| {
        format!(
            "the header stamps come from several clocks: median offset to the receive time {}",
            listed(&latencies)
        )
    })
}

/// The median latency of each topic that has one, s.
pub(crate) fn latencies(topics: &mut [Stamps]) -> Vec<(String, f64)> {
    let each = topics.iter_mut();
    each.filter_map(|it| Some((it.topic.clone(), it.latency()?)))
        .collect()
}

fn range(latencies: &[(String, f64)]) -> Option<(f64, f64)> {
    let each = latencies.iter().map(|it| (it.1, it.1));
    each.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn listed(latencies: &[(String, f64)]) -> String {
    let each = latencies
        .iter()
        .map(|(topic, latency)| match latency.abs() > OTHER_CLOCK {
            true => format!("{topic} {latency:.1} s"),
            false => format!("{topic} {:.1} ms", latency * 1e3),
        });
    each.collect::<Vec<_>>().join(", ")
}

/// The delay from the stamps of the topics' messages to their reception, and its effect on a model; `None` if all delays are equal, or their
/// clocks cannot be compared.
pub(crate) fn lag(latencies: &[(String, f64)], clock: Clock) -> Option<String> {
    let (least, most) = range(latencies)?;
    let spread = most - least;
    // All by the same other clock, as in a bag of a bag that was played.
    let is_other = most > OTHER_CLOCK || least < -LAG;
    let (difference, meaning) = match clock {
        Clock::Header => (
            spread,
            "apart; with the header stamps, this difference does not count as a delay of the system",
        ),
        Clock::Log if is_other => (
            spread,
            "apart; with the recorder's stamps, this difference counts as a delay of the system",
        ),
        Clock::Log => (
            most,
            "of this count as a delay of the system, because the recorder's stamps are used",
        ),
    };
    if difference <= LAG {
        return None;
    }
    let each = listed(latencies);
    let log = setting("stamp", "log");
    if difference > OTHER_CLOCK || (least < -LAG && clock == Clock::Log) {
        let remedy = match clock {
            Clock::Header => format!("; {log} uses the recorder's time for all signals"),
            Clock::Log => String::new(),
        };
        return Some(format!(
            "messages were received after their own stamps (median): {each}: the clocks differ, so these times show no delay{remedy}"
        ));
    }
    let ahead = match least < -LAG {
        true => format!(
            "; stamps later than their reception come from a clock that is ahead ({log} uses the recorder's time for all signals)"
        ),
        false => String::new(),
    };
    Some(format!(
        "messages were received after their own stamps (median): {each}; {:.1} ms {meaning}{ahead}",
        difference * 1e3
    ))
}
