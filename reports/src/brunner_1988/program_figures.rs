//! Figures B1 to B10, missing in the copy: output of programs T2 to T5 (Brunner 1988, App. B; described on pp. 38-41).
//!
//! For each program: depth and pitch; heave velocity if the vehicle heaves; pitch rate and acceleration. Axes are those of the report: feet for
//! depth, and units of `L / U` for time, which the report calls seconds (erratum E2).

use planesman_show::plot::Plot;

use crate::brunner_1988::programs::{FEET_PER_LENGTH, Program, STEP, T2, T3, T4, T5};

/// Duration of the programs \[L/U\].
const DURATION: f64 = 20.0;
/// Number of steps per plotted point.
const STRIDE: usize = 10;

/// Figures B1 to B10. B1, B4 and B8 are two plots each, since depth and pitch have no common axis.
#[must_use]
pub fn figures() -> Vec<Plot<'static>> {
    let [t2, t3, t4, t5] = [&T2, &T3, &T4, &T5].map(Run::of);
    vec![
        t2.depth("Fig. B1 (depth), program T2: all derivatives").note("Planes at 30 degrees until 10 L/U. The final depth is 2.60 ft (printed 2.61)."),
        t2.pitch("Fig. B1 (pitch), program T2").note("The pitch stays at -4.2 degrees because the restoring moment is twelve times too large (E1)."),
        t2.heave("Fig. B2, program T2: heave velocity").note("Positive down: the heave velocity increases the depth."),
        t2.rates("Fig. B3, program T2: pitch rate and acceleration").note("The initial acceleration is K2 delta / A2."),
        t3.depth("Fig. B4 (depth), program T3: no heave").note("The final depth is 1.77 ft, 32 % less than with heave."),
        t3.pitch("Fig. B4 (pitch), program T3").note("Printed as about -4.4 degrees."),
        t3.rates("Fig. B5, program T3: pitch rate and acceleration").note("As in Fig. B3."),
        t4.pitch("Fig. B6, program T4: no restoring moment").note("Planes at 30 degrees for 1 L/U; the vehicle stays at -27.6 degrees (printed -27.5)."),
        t4.rates("Fig. B7, program T4: pitch rate and acceleration").note("The rate is more than twice that of Fig. B3; the initial acceleration is the same (E21)."),
        t5.depth("Fig. B8 (depth), program T5: a tenth of the pitch damping").note("The final depth is unchanged."),
        t5.pitch("Fig. B8 (pitch), program T5").note("The pitch oscillates with a damping ratio of 0.03."),
        t5.heave("Fig. B9, program T5: heave velocity").note("The heave velocity oscillates with the pitch."),
        t5.rates("Fig. B10, program T5: pitch rate and acceleration").note("Both oscillate with the pitch."),
    ]
}

/// Output of a program at every plotted point.
struct Run {
    points: Vec<Point>,
}

struct Point {
    time: f64,
    depth: f64,
    pitch: f64,
    pitch_rate: f64,
    acceleration: f64,
    heave: f64,
}

impl Run {
    fn of(program: &Program) -> Self {
        let track = program.run(DURATION);
        let steps = (DURATION / STEP) as usize;
        let points = (1..steps)
            .step_by(STRIDE)
            .map(|k| {
                let time = k as f64 * STEP;
                let (before, now, after) =
                    (track.at(time - STEP), track.at(time), track.at(time + STEP));
                let (sin, cos) = libm::sincos(now.pitch);
                let depth_rate = (after.depth - before.depth) / (2.0 * STEP);
                Point {
                    time,
                    depth: now.depth * FEET_PER_LENGTH,
                    pitch: now.pitch.to_degrees(),
                    pitch_rate: now.pitch_rate,
                    acceleration: (after.pitch_rate - before.pitch_rate) / (2.0 * STEP),
                    // The programs' z' = WG cos(theta) - UG sin(theta), read the other way.
                    heave: (depth_rate + (1.0 + program.zg * now.pitch_rate) * sin) / cos,
                }
            })
            .collect();
        Self { points }
    }

    fn points(&self, value: impl Fn(&Point) -> f64) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().map(move |p| (p.time, value(p)))
    }

    fn depth(&self, title: &'static str) -> Plot<'static> {
        let depth = self.points(|p| p.depth);
        over_time(title, "depth [ft]").y_down().line("depth", depth)
    }

    fn pitch(&self, title: &'static str) -> Plot<'static> {
        over_time(title, "pitch [deg], bow up").line("pitch", self.points(|p| p.pitch))
    }

    fn heave(&self, title: &'static str) -> Plot<'static> {
        over_time(title, "w [U], down").line("heave velocity", self.points(|p| p.heave))
    }

    fn rates(&self, title: &'static str) -> Plot<'static> {
        over_time(title, "bow up")
            .line("pitch rate [U/L]", self.points(|p| p.pitch_rate))
            .line(
                "pitch acceleration [(U/L)^2]",
                self.points(|p| p.acceleration),
            )
    }
}

fn over_time(title: &'static str, y: &'static str) -> Plot<'static> {
    Plot::new(title, ["time [L/U]", y]).from_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brunner 1988, p. 38 f.: about four seconds to steady conditions, where program T2's
    /// heave equation balances: B1 w = K1 delta.
    #[test]
    fn heave_settles_where_its_equation_balances() {
        let run = Run::of(&T2);
        let held = run.points.iter().rfind(|p| p.time < 10.0).expect("drawn");
        let balance = T2.k1 * crate::brunner_1988::programs::PLANE_ANGLE / T2.b1;
        assert!(
            (held.heave - balance).abs() < 1e-4,
            "{} is not {balance}",
            held.heave
        );
    }

    #[test]
    fn every_figure_can_be_drawn() {
        for figure in figures() {
            assert!(figure.data().is_ok(), "{}", figure.title);
        }
    }
}
