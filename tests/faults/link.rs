//! A model of a link that damages frames, in each direction separately, without a clock or a network.

use std::fmt;
use std::time::Duration;

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// How long a frame is held back that others are to overtake.
const HELD_BACK: Duration = Duration::from_millis(10);

/// The state of a link. The default is a good one.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(crate) struct Link {
    /// The share of frames that are lost.
    pub(crate) loss: f64,
    /// How long a frame is on its way, s.
    pub(crate) delay: f64,
    /// By how much that differs from frame to frame, s either way; frames then overtake each other.
    pub(crate) jitter: f64,
    /// The share of frames that are held back for a while.
    pub(crate) reorder: f64,
    /// The share of frames that arrive twice.
    pub(crate) duplicate: f64,
    /// Nothing arrives at the far end.
    pub(crate) cut_to_far: bool,
    /// Nothing arrives at the near end.
    pub(crate) cut_to_near: bool,
}

impl Link {
    /// A link that lets nothing pass.
    pub(crate) const CUT: Self = Self {
        cut_to_far: true,
        cut_to_near: true,
        ..Self::GOOD
    };
    /// A link that lets everything pass at once.
    pub(crate) const GOOD: Self = Self {
        loss: 0.0,
        delay: 0.0,
        jitter: 0.0,
        reorder: 0.0,
        duplicate: 0.0,
        cut_to_far: false,
        cut_to_near: false,
    };
}

/// The end that a frame goes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum To {
    Far,
    Near,
}

/// The fate of the frames.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Counts {
    /// Frames that came to the link.
    pub(crate) sent: u64,
    /// Frames that it kept.
    pub(crate) lost: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} frames", self.lost, self.sent)
    }
}

/// One direction of a link. What happens to its n-th frame follows from the seed, n and the link's state then.
pub(crate) struct Wire {
    to: To,
    chance: Pcg64,
    pub(crate) counts: Counts,
}

impl Wire {
    pub(crate) fn new(to: To, seed: u64) -> Self {
        let own = 2 * seed + u64::from(to == To::Near);
        Self {
            to,
            chance: Pcg64::seed_from_u64(own),
            counts: Counts::default(),
        }
    }

    /// After how long each copy of the next frame arrives; none if it is lost.
    pub(crate) fn pass(&mut self, link: &Link) -> Vec<Duration> {
        // Always as many draws, so that one frame's fate leaves the others' alone.
        let mut draw = || self.chance.random::<f64>();
        let lost = draw() < link.loss;
        let late = draw() < link.reorder;
        let twice = draw() < link.duplicate;
        let delays = [draw(), draw()].map(|share| {
            let delay = link.delay + link.jitter * (2.0 * share - 1.0);
            let held = if late { HELD_BACK } else { Duration::ZERO };
            Duration::from_secs_f64(delay.max(0.0)) + held
        });
        let cut = match self.to {
            To::Far => link.cut_to_far,
            To::Near => link.cut_to_near,
        };
        let copies = match (cut || lost, twice) {
            (true, _) => 0,
            (false, false) => 1,
            (false, true) => 2,
        };
        self.counts.sent += 1;
        self.counts.lost += u64::from(copies == 0);
        delays[..copies].to_vec()
    }
}

/// The specification of the model.
pub(crate) mod claims {
    use super::*;

    const FRAMES: usize = 10_000;

    fn passed(link: Link, seed: u64) -> Vec<Vec<Duration>> {
        let mut wire = Wire::new(To::Far, seed);
        (0..FRAMES).map(|_| wire.pass(&link)).collect()
    }

    /// The share of frames of which `is` holds.
    fn share(frames: &[Vec<Duration>], is: impl Fn(&[Duration]) -> bool) -> f64 {
        frames.iter().filter(|copies| is(copies)).count() as f64 / frames.len() as f64
    }

    pub(crate) fn a_good_link_passes_each_frame_once_and_at_once() {
        assert!(
            passed(Link::GOOD, 1)
                .iter()
                .all(|copies| *copies == [Duration::ZERO])
        );
    }

    pub(crate) fn the_same_seed_loses_the_same_frames_and_another_others() {
        let link = Link {
            loss: 0.2,
            duplicate: 0.1,
            jitter: 0.02,
            delay: 0.05,
            ..Link::GOOD
        };
        assert_eq!(passed(link, 1), passed(link, 1));
        assert_ne!(passed(link, 1), passed(link, 2));
    }

    pub(crate) fn shares_and_delays_are_those_asked_for() {
        let link = Link {
            loss: 0.2,
            ..Link::GOOD
        };
        assert!((share(&passed(link, 1), |copies| copies.is_empty()) - 0.2).abs() < 0.02);
        let link = Link {
            duplicate: 0.1,
            ..Link::GOOD
        };
        assert!((share(&passed(link, 1), |copies| copies.len() == 2) - 0.1).abs() < 0.02);
        let link = Link {
            reorder: 0.25,
            ..Link::GOOD
        };
        assert!((share(&passed(link, 1), |copies| copies[0] == HELD_BACK) - 0.25).abs() < 0.02);
        let link = Link {
            delay: 0.05,
            jitter: 0.02,
            ..Link::GOOD
        };
        let delays: Vec<f64> = passed(link, 1)
            .iter()
            .map(|copies| copies[0].as_secs_f64())
            .collect();
        assert!(delays.iter().all(|delay| (0.03..=0.07).contains(delay)));
        let mean = delays.iter().sum::<f64>() / delays.len() as f64;
        assert!((mean - 0.05).abs() < 0.001, "{mean}");
    }

    pub(crate) fn a_one_way_cut_stops_one_way() {
        let link = Link {
            cut_to_far: true,
            ..Link::GOOD
        };
        assert_eq!(Wire::new(To::Far, 1).pass(&link).len(), 0);
        assert_eq!(Wire::new(To::Near, 1).pass(&link).len(), 1);
        let mut wire = Wire::new(To::Near, 1);
        assert!(wire.pass(&Link::CUT).is_empty());
        assert_eq!(wire.counts, Counts { sent: 1, lost: 1 });
    }
}
