//! The flow into the ram, Q_p(t): calibrated volumes on their way, drift and leakage
//! (Figures 2-7, 2-8).
//!
//! ```text
//! Q_p = sum_i sigma_i V_c/T_f [t_i + T_D + T_v <= t < t_i + T_D + T_v + T_f] + d(t) q_L + q_LC
//! ```
//!
//! sigma_i is +1, 0 or -1: what the valves moved for the command of cycle i; d(t) = +-1 is the
//! sign valve's polarity, which follows a command after T_D + T_v. T_v + T_f may exceed T: then
//! the flows of consecutive commands overlap into the next cycle. Within a cycle the flow is
//! constant between a few edges; [`Metering::begin_cycle`] lists the pieces. Drift is taken to
//! flow beside the calibrated volumes too, which the report leaves open (effect at most 1 %).

use crate::actuator_set::{ActuatorSet, MOST_CYCLES_IN_FLIGHT};
use crate::valves::Stroke;

/// A stretch of a cycle with constant flow; times in s from the cycle's begin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Where it ends.
    pub until: f64,
    /// Net flow into the ram, m^3/s.
    pub flow: f64,
    /// d, the drift polarity in force: +1 or -1.
    pub polarity: i8,
}

/// The most pieces a cycle can have: begin and end of every flow that reaches into it.
const MOST_PIECES: usize = 2 * MOST_CYCLES_IN_FLIGHT + 1;

/// The metering of one actuator: commands on their way, and the pieces of the present cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metering {
    cycle: f64,
    delay: f64,
    flow_time: f64,
    volume: f64,
    rate_gain: f64,
    error_rate: f64,
    /// Cycles over which one command reaches.
    reach: usize,
    /// What the valves did in the present and the past cycles, latest first.
    strokes: [Stroke; MOST_CYCLES_IN_FLIGHT],
    /// Polarity before all of those.
    settled_polarity: i8,
    /// Quanta of commands that have wholly arrived.
    settled_quanta: i64,
    pieces: [Piece; MOST_PIECES],
    piece_count: usize,
}

impl Metering {
    /// No volume on its way; the sign valve at `polarity`.
    #[must_use]
    pub fn new(set: &ActuatorSet, polarity: i8) -> Self {
        Self {
            cycle: set.cycle(),
            delay: set.delay(),
            flow_time: set.flow_time,
            volume: set.volume,
            rate_gain: set.rate_gain,
            error_rate: set.error_rate,
            reach: set.commands_in_flight() + 1,
            strokes: [Stroke {
                quanta: 0,
                polarity,
            }; MOST_CYCLES_IN_FLIGHT],
            settled_polarity: polarity,
            settled_quanta: 0,
            pieces: [Piece::default(); MOST_PIECES],
            piece_count: 0,
        }
    }

    /// Changes the leakages, m^3/s, from the next cycle on.
    pub fn set_leakage(&mut self, rate_gain: f64, error_rate: f64) {
        self.rate_gain = rate_gain;
        self.error_rate = error_rate;
    }

    /// Starts the next cycle with what the valves did at its begin.
    pub fn begin_cycle(&mut self, stroke: Stroke) {
        let arrived = self.strokes[self.reach - 1];
        self.settled_quanta += i64::from(arrived.quanta);
        self.settled_polarity = arrived.polarity;
        self.strokes.rotate_right(1);
        self.strokes[0] = stroke;
        self.list_pieces();
    }

    /// The pieces of the present cycle, in order; the last ends with the cycle.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces[..self.piece_count]
    }

    /// Calibrated volume delivered up to `time` into the present cycle, in quanta.
    #[must_use]
    pub fn quanta_delivered(&self, time: f64) -> f64 {
        let on_their_way: f64 = (0..self.reach)
            .map(|age| {
                let share = (time - self.flow_begin(age)) / self.flow_time;
                f64::from(self.strokes[age].quanta) * share.clamp(0.0, 1.0)
            })
            .sum();
        self.settled_quanta as f64 + on_their_way
    }

    /// When the flow commanded `age` cycles ago begins, from the present cycle's begin.
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
            let stroke = self.strokes[age];
            let begin = self.flow_begin(age);
            if stroke.quanta != 0 {
                add(begin);
                add(begin + self.flow_time);
            } else if stroke.polarity != polarity {
                add(begin);
            }
            polarity = stroke.polarity;
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

    /// The flow over a stretch within which nothing changes.
    fn piece(&self, from: f64, until: f64) -> Piece {
        let middle = 0.5 * (from + until);
        let mut quanta = 0;
        let mut polarity = self.settled_polarity;
        for age in (0..self.reach).rev() {
            let begin = self.flow_begin(age);
            if begin <= middle {
                polarity = self.strokes[age].polarity;
                if middle < begin + self.flow_time {
                    quanta += i32::from(self.strokes[age].quanta);
                }
            }
        }
        Piece {
            until,
            flow: f64::from(quanta) * (self.volume / self.flow_time)
                + (f64::from(polarity) * self.rate_gain + self.error_rate),
            polarity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;

    fn volumes(quanta: i8) -> Stroke {
        Stroke {
            quanta,
            polarity: 1,
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
                        volume / metering.volume
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
        assert_eq!(metering.quanta_delivered(0.0), 2.0);
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
    fn the_drift_turns_with_the_sign_valve_after_t_v() {
        let set = load("table_4_1").expect("built in");
        let mut metering = Metering::new(&set, 1);
        metering.begin_cycle(Stroke {
            quanta: 0,
            polarity: -1,
        });
        let [before, after] = metering.pieces() else {
            panic!("one edge, the sign valve's");
        };
        assert_eq!(before.until, set.valve_time);
        assert_eq!(before.flow, set.rate_gain + set.error_rate);
        assert_eq!(after.flow, -set.rate_gain + set.error_rate);
    }
}
