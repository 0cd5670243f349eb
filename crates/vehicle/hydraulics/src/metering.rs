//! The flow into the ram, Q_p(t): calibrated volumes, drift and leakage (Figures 2-7, 2-8).
//!
//! ```text
//! Q_p = sum_i sigma_i V_c/T_f [t_i + T_D + T_v <= t < t_i + T_D + T_v + T_f] + d(t) q_L + q_LC
//! ```
//!
//! sigma_i is +1, 0 or -1: the volume moved for the command of cycle i. V_c and T_f belong to the large or the small volume. d(t) = +-1 is the sign
//! valve's polarity, which follows a command after T_D + T_v. T_v + T_f may exceed T: then the flows of consecutive commands overlap into the next
//! cycle. Within a cycle the flow is constant between a few edges; [`Metering::begin_cycle`] lists the pieces. Drift is assumed to flow also during
//! the calibrated volumes; the report does not state this (effect at most 1 %).

use crate::actuator_set::{ActuatorSet, MOST_CYCLES_IN_FLIGHT};
use crate::condition::{Condition, Leakages};
use crate::valves::Stroke;

/// A stretch of a cycle with constant flow; times in s from the cycle's begin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Piece {
    /// End of the piece.
    pub until: f64,
    /// Net flow into the ram, m^3/s.
    pub flow: f64,
    /// d, the drift polarity: +1 or -1.
    pub polarity: i8,
}

/// Flows of a piece by their paths, m^3/s, not negative except for drift and constant leakage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flows {
    /// Flows through the large and the small volume's valve: from the supply into the ram, and from the ram to the return.
    pub metered: [[f64; 2]; 2],
    /// d q_L, drift past the calibrating piston.
    pub drift: f64,
    /// Whether the sign valve connects the piston to the supply; otherwise to the return.
    pub from_supply: bool,
    /// q_LC.
    pub constant_leakage: f64,
}

impl Flows {
    /// No flow.
    pub(crate) const NONE: Self = Self {
        metered: [[0.0; 2]; 2],
        drift: 0.0,
        from_supply: true,
        constant_leakage: 0.0,
    };
}

/// Largest number of pieces in a cycle: begin and end of both flows and the change of drift, for every command that extends into it.
const MOST_PIECES: usize = 5 * MOST_CYCLES_IN_FLIGHT + 1;

/// A calibrating cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cylinder {
    /// m^3
    volume: f64,
    /// s
    flow_time: f64,
}

/// A volume that flows at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flow {
    /// Signed, m^3.
    volume: f64,
    /// After T_D + T_v, s.
    late: f64,
    /// s
    lasts: f64,
}

impl Flow {
    /// Volume that has flowed until `time` s after T_D + T_v.
    fn delivered(&self, time: f64) -> f64 {
        self.volume * ((time - self.late) / self.lasts).clamp(0.0, 1.0)
    }
}

/// Flow due to the switching of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Delivery {
    flows: [Flow; 2],
    polarity: i8,
}

/// Metering of one actuator: commands on their way, and the pieces of the present cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metering {
    cycle: f64,
    delay: f64,
    large: Cylinder,
    small: Cylinder,
    leakages: Leakages,
    /// Additional time of the slow latch beyond T_v, s.
    slow_latch: f64,
    /// Volume relative to that of a healthy actuator.
    volume_left: f64,
    /// Number of cycles over which one command extends.
    reach: usize,
    /// Flows of the present and the past cycles, latest first.
    deliveries: [Delivery; MOST_CYCLES_IN_FLIGHT],
    /// Polarity before all of these.
    settled_polarity: i8,
    /// Calibrated volume that has completely arrived, m^3.
    settled_volume: f64,
    pieces: [Piece; MOST_PIECES],
    piece_count: usize,
}

impl Metering {
    /// Returns the metering without a volume on its way, the sign valve at `polarity`.
    #[must_use]
    pub(crate) fn new(set: &ActuatorSet, polarity: i8) -> Self {
        let large = Cylinder {
            volume: set.volume,
            flow_time: set.flow_time,
        };
        let nothing = Flow {
            volume: 0.0,
            late: 0.0,
            lasts: set.flow_time,
        };
        Self {
            cycle: set.cycle(),
            delay: set.delay(),
            large,
            small: set.small.map_or(
                Cylinder {
                    volume: 0.0,
                    ..large
                },
                |small| Cylinder {
                    volume: small.volume,
                    flow_time: small.flow_time,
                },
            ),
            leakages: Leakages {
                rate_gain: set.rate_gain,
                error_rate: set.error_rate,
            },
            slow_latch: 0.0,
            volume_left: 1.0,
            reach: set.commands_in_flight() + 1,
            deliveries: [Delivery {
                flows: [nothing; 2],
                polarity,
            }; MOST_CYCLES_IN_FLIGHT],
            settled_polarity: polarity,
            settled_volume: 0.0,
            pieces: [Piece::default(); MOST_PIECES],
            piece_count: 0,
        }
    }

    /// Changes the condition, and with it the leakages, from the next cycle on.
    ///
    /// The slow latch's time is limited so that its volume arrives within [`MOST_CYCLES_IN_FLIGHT`].
    pub(crate) fn set_condition(&mut self, condition: &Condition, leakages: Leakages) {
        let longest = self.cycle * MOST_CYCLES_IN_FLIGHT as f64 - self.delay;
        let slack = longest - 2.0 * self.large.flow_time;
        self.slow_latch = condition.slow_latch.min(slack.max(0.0));
        self.volume_left = 1.0 - condition.short_volume;
        self.leakages = leakages;
        if self.slow_latch > 0.0 {
            // Nothing is on its way in the cycles added: what had arrived is no longer listed.
            let last = self.delay + self.slow_latch + 2.0 * self.large.flow_time;
            let cycles = (last / self.cycle).ceil() as usize;
            self.reach = self.reach.max(cycles.min(MOST_CYCLES_IN_FLIGHT));
        }
    }

    /// Starts the next cycle with the stroke of the valves at its begin.
    pub(crate) fn begin_cycle(&mut self, stroke: Stroke) {
        let arrived = &mut self.deliveries[self.reach - 1];
        self.settled_polarity = arrived.polarity;
        for flow in &mut arrived.flows {
            self.settled_volume += flow.volume;
            flow.volume = 0.0;
        }
        self.deliveries.rotate_right(1);
        self.deliveries[0] = Delivery {
            flows: [
                self.large_flow(stroke),
                self.flow(self.small, stroke.small, 0.0),
            ],
            polarity: stroke.polarity,
        };
        self.list_pieces();
    }

    /// Flow of `quanta` volumes of a cylinder, delayed by `late` s.
    fn flow(&self, cylinder: Cylinder, quanta: i8, late: f64) -> Flow {
        Flow {
            volume: f64::from(quanta) * (cylinder.volume * self.volume_left),
            late,
            lasts: cylinder.flow_time,
        }
    }

    /// Flow of the large volume's stroke. If the actuating valve should switch together with the direction valve but is late, the piston
    /// first starts the volume of the direction valve alone and then returns. Both strokes displace oil in the new direction.
    fn large_flow(&self, stroke: Stroke) -> Flow {
        let late = if stroke.down { self.slow_latch } else { 0.0 };
        if stroke.large != 0 || late == 0.0 {
            return self.flow(self.large, stroke.large, late);
        }
        let whole = self.flow(self.large, stroke.polarity, 0.0);
        let strokes = 2.0 * (late / whole.lasts).min(1.0);
        Flow {
            volume: whole.volume * strokes,
            late: 0.0,
            lasts: whole.lasts * strokes,
        }
    }

    /// Pieces of the present cycle, in order; the last one ends with the cycle.
    #[must_use]
    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces[..self.piece_count]
    }

    /// Calibrated volume delivered up to `time` in the present cycle, m^3.
    #[must_use]
    pub(crate) fn delivered(&self, time: f64) -> f64 {
        let on_their_way: f64 = (0..self.reach)
            .map(|age| {
                let flowed = time - self.flow_begin(age);
                let [large, small] = &self.deliveries[age].flows;
                large.delivered(flowed) + small.delivered(flowed)
            })
            .sum();
        self.settled_volume + on_their_way
    }

    /// Begin of the flow commanded `age` cycles ago, from the present cycle's begin.
    fn flow_begin(&self, age: usize) -> f64 {
        self.delay - age as f64 * self.cycle
    }

    fn list_pieces(&mut self) {
        // Where anything changes within the cycle.
        let mut edges = [f64::INFINITY; MOST_PIECES];
        let mut count = 0;
        let mut add = |edge: f64| {
            if edge > 0.0 && edge < self.cycle {
                edges[count] = edge;
                count += 1;
            }
        };
        let mut polarity = self.settled_polarity;
        for age in (0..self.reach).rev() {
            let delivery = self.deliveries[age];
            let begin = self.flow_begin(age);
            if delivery.polarity != polarity {
                add(begin);
            }
            for flow in delivery.flows.iter().filter(|flow| flow.volume != 0.0) {
                add(begin + flow.late);
                add(begin + flow.late + flow.lasts);
            }
            polarity = delivery.polarity;
        }
        edges[count] = self.cycle;
        edges[..=count].sort_unstable_by(f64::total_cmp);
        self.piece_count = 0;
        let mut from = 0.0;
        for until in edges.into_iter().take(count + 1) {
            if until > from {
                self.pieces[self.piece_count] = self.piece(from, until);
                self.piece_count += 1;
                from = until;
            }
        }
    }

    /// Flow over a stretch without any change.
    fn piece(&self, from: f64, until: f64) -> Piece {
        let mut metered = 0.0;
        let polarity = self.flowing(from, until, |_, flow| metered += flow);
        Piece {
            until,
            flow: metered
                + (f64::from(polarity) * self.leakages.rate_gain + self.leakages.error_rate),
            polarity,
        }
    }

    /// Splits the flow into its paths, for a piece of the present cycle that begins at `from`.
    pub(crate) fn flows(&self, from: f64, piece: &Piece) -> Flows {
        let mut metered = [[0.0; 2]; 2];
        self.flowing(from, piece.until, |valve, flow| {
            metered[valve][usize::from(flow < 0.0)] += flow.abs();
        });
        Flows {
            metered,
            drift: f64::from(piece.polarity) * self.leakages.rate_gain,
            from_supply: piece.polarity > 0,
            constant_leakage: self.leakages.error_rate,
        }
    }

    /// Calls `tell` with each calibrated flow over a stretch without changes, m^3/s, and its valve: 0 for the large volume, 1 for the small one.
    /// Returns the drift polarity.
    fn flowing(&self, from: f64, until: f64, mut tell: impl FnMut(usize, f64)) -> i8 {
        let middle = 0.5 * (from + until);
        let mut polarity = self.settled_polarity;
        for age in (0..self.reach).rev() {
            let begin = self.flow_begin(age);
            if begin <= middle {
                let delivery = &self.deliveries[age];
                polarity = delivery.polarity;
                let flows = delivery.flows.iter().enumerate();
                for (valve, flow) in flows.filter(|(_, flow)| flow.volume != 0.0) {
                    let flowed = middle - (begin + flow.late);
                    if (0.0..flow.lasts).contains(&flowed) {
                        tell(valve, flow.volume / flow.lasts);
                    }
                }
            }
        }
        polarity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;

    fn volumes(large: i8) -> Stroke {
        Stroke {
            large,
            ..Stroke::none(1)
        }
    }

    /// Calibrated volume that flows within each cycle, in quanta.
    fn delivered(metering: &mut Metering, quanta: &[i8]) -> Vec<f64> {
        quanta
            .iter()
            .map(|q| {
                metering.begin_cycle(volumes(*q));
                let mut from = 0.0;
                metering
                    .pieces()
                    .iter()
                    .map(|piece| {
                        let volume = piece.flow * (piece.until - from);
                        from = piece.until;
                        volume / metering.large.volume
                    })
                    .sum()
            })
            .collect()
    }

    fn tight(name: &str) -> ActuatorSet {
        let mut set = load(name).expect("built in");
        (set.rate_gain, set.error_rate) = (0.0, 0.0);
        set
    }

    #[test]
    fn two_thirds_of_a_polaris_quantum_flow_in_its_own_cycle() {
        let set = tight("table_4_1");
        let flows = delivered(&mut Metering::new(&set, 1), &[1, 0, 0]);
        // Delta V_1 = 0.10064 in^3, Delta V_2 = 0.05136 in^3 of 0.152 in^3.
        assert!((flows[0] - 0.100_642_424_242 / 0.152).abs() < 1e-9);
        assert!((flows[1] - 0.051_357_575_757 / 0.152).abs() < 1e-9);
        assert_eq!(flows[2], 0.0);
    }

    #[test]
    fn consecutive_flows_overlap_and_nothing_is_lost() {
        let set = tight("table_4_1");
        let mut metering = Metering::new(&set, 1);
        let flows = delivered(&mut metering, &[1, 1, -1, 1, 0, 0]);
        assert!((flows.iter().sum::<f64>() - 2.0).abs() < 1e-12);
        assert!((metering.delivered(0.0) / set.volume - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_delay_of_several_cycles_only_shifts_the_flow() {
        let mut set = tight("table_4_1");
        let prompt = delivered(&mut Metering::new(&set, 1), &[1, 1, 0, -1, 0, 0, 0, 0]);
        set.extra_delay = 3.0 * set.cycle();
        let late = delivered(&mut Metering::new(&set, 1), &[1, 1, 0, -1, 0, 0, 0, 0]);
        for n in 3..8 {
            assert!((late[n] - prompt[n - 3]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_small_volume_flows_for_its_own_time() {
        let mut set = tight("auv_two_speed");
        if let Some(small) = &mut set.small {
            small.flow_time = 0.5 * set.flow_time;
        }
        let small = set.small.expect("a two-speed actuator");
        let mut metering = Metering::new(&set, 1);
        metering.begin_cycle(Stroke {
            small: -1,
            ..Stroke::none(-1)
        });
        let [before, during, after] = metering.pieces() else {
            panic!("a flow that begins and ends");
        };
        assert_eq!((before.flow, after.flow), (0.0, 0.0));
        assert_eq!(during.flow, -small.volume / small.flow_time);
        assert_eq!(during.until, set.delay() + small.flow_time);
        assert!((metering.delivered(set.cycle()) / small.volume + 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_drift_turns_with_the_sign_valve_after_t_v() {
        let set = load("table_4_1").expect("built in");
        let mut metering = Metering::new(&set, 1);
        metering.begin_cycle(Stroke::none(-1));
        let [before, after] = metering.pieces() else {
            panic!("one edge, the sign valve's");
        };
        assert_eq!(before.until, set.valve_time);
        assert_eq!(before.flow, set.rate_gain + set.error_rate);
        assert_eq!(after.flow, -set.rate_gain + set.error_rate);
    }
}
