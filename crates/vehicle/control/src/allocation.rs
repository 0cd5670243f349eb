//! Distribution of one dive-plane angle to the bow and the stern planes.
//!
//! The report's planes moved together; "only forward or aft dive planes, or unequal coupling" are left to future designs (Brunner, NPS
//! thesis, 1988, p. 8). The planes with the larger share get the complete commanded angle, the others a part of this angle. So a limit on the angle
//! limits both pairs.

/// The planes used for diving.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum DivePlanes {
    /// Bow and stern planes by the same angle.
    Together,
    /// The bow planes alone.
    Bow,
    /// The stern planes alone.
    Stern,
    /// Bow and stern planes, in a given ratio.
    Ratio,
}

/// The share of the dive-plane angle of each pair of planes, in \[0, 1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Allocation {
    bow: f64,
    stern: f64,
}

/// The angles of both pairs of planes, as in a plane command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shared {
    /// Mean of bow and stern planes, rad, positive dive.
    pub mean: f64,
    /// Added to the bow planes and subtracted from the stern planes, rad.
    pub differential: f64,
}

impl Shared {
    /// The bow planes' angle, rad, positive dive.
    #[must_use]
    pub(crate) fn bow(&self) -> f64 {
        self.mean + self.differential
    }
}

impl Allocation {
    /// The allocation to `planes`; `ratio` is bow over stern, for [`DivePlanes::Ratio`].
    #[must_use]
    pub(crate) fn new(planes: DivePlanes, ratio: f64) -> Self {
        let (bow, stern) = match planes {
            DivePlanes::Together => (1.0, 1.0),
            DivePlanes::Bow => (1.0, 0.0),
            DivePlanes::Stern => (0.0, 1.0),
            DivePlanes::Ratio if ratio <= 1.0 => (ratio, 1.0),
            DivePlanes::Ratio => (1.0, 1.0 / ratio),
        };
        Self { bow, stern }
    }

    /// Distributes the angle `planes` (rad, positive dive).
    #[must_use]
    pub(crate) fn share(&self, planes: f64) -> Shared {
        Shared {
            mean: planes * (0.5 * (self.bow + self.stern)),
            differential: planes * (0.5 * (self.bow - self.stern)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_planes_that_do_most_get_the_angle_asked_for() {
        for (planes, ratio, bow, stern) in [
            (DivePlanes::Together, 7.0, 0.4, 0.4),
            (DivePlanes::Bow, 7.0, 0.4, 0.0),
            (DivePlanes::Stern, 7.0, 0.0, 0.4),
            (DivePlanes::Ratio, 0.5, 0.2, 0.4),
            (DivePlanes::Ratio, 2.0, 0.4, 0.2),
        ] {
            let shared = Allocation::new(planes, ratio).share(0.4);
            assert!((shared.bow() - bow).abs() < 1e-15, "{planes:?}");
            assert!((shared.mean - shared.differential - stern).abs() < 1e-15);
        }
    }
}
