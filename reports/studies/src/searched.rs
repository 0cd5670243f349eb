//! What the search for the 1966 report's assumptions found, as text.

use std::fmt::Write as _;

use ibm_1966::RateSignal;
use ibm_1966::search::{Point, Score, missiles};
use planesman_units::DEGREE;

use crate::orbit::range;

/// How many of the best are listed.
const LISTED: usize = 6;
/// And of the best of some.
const FEWER: usize = 3;
/// A limit cycle is the reported one within this factor.
const NEAR: f64 = 1.3;

/// What was tried, the best, and the verdict; a list for each set of assumptions, of the missiles that give Table 4-2's first row.
#[must_use]
pub fn found(by_assumptions: &[Vec<Point>]) -> String {
    let points: Vec<&Point> = by_assumptions.iter().flatten().collect();
    let mut both: Vec<(&Point, [Score; 2])> = points
        .iter()
        .filter_map(|point| Some((*point, point.scores?)))
        .collect();
    both.sort_by_key(|(_, [hardware, flight])| {
        std::cmp::Reverse((hardware.near + flight.near, hardware.exact + flight.exact))
    });
    let whole = points.iter().filter(|p| p.gives_both_tables()).count();
    let cycles = points
        .iter()
        .filter(|p| p.cycles_missed_by() < NEAR)
        .count();
    let undelayed = |point: &Point| point.assumptions.delay == 0.0;
    let alike = |point: &Point| !point.assumptions.laboratory;
    let all_three = both.iter().filter(|(p, _)| p.cycles_missed_by() < NEAR);
    let mut text = format!(
        "{} sets of assumptions with {} missiles each. Within one test step:\n\
         {:>6} give the first row of Table 4-2\n\
         {:>6} give the first row of Table 3-2 too; of these {} without a transport delay, {} with delay and friction alike in both tables\n\
         {whole:>6} give all 42 numbers of both tables (D1)\n\
         {cycles:>6} give the limit cycles (D2): psi pp 0.03 deg with leakage and 0.067 without, at 6 to 11 pulses/s, within a factor of {NEAR}; of these {} the first row of Table 3-2\n",
        by_assumptions.len(),
        missiles().len(),
        points.len(),
        both.len(),
        both.iter().filter(|(p, _)| undelayed(p)).count(),
        both.iter().filter(|(p, _)| alike(p)).count(),
        all_three.count(),
    );
    text += "\nThe best, by what lies within one test step (the same): Table 3-2, Table 4-2\n";
    list(&mut text, both.iter().take(LISTED));
    text += "with delay and friction alike in both tables:\n";
    list(&mut text, both.iter().filter(|(p, _)| alike(p)).take(FEWER));
    text += "without a transport delay:\n";
    list(
        &mut text,
        both.iter().filter(|(p, _)| undelayed(p)).take(FEWER),
    );
    text += "\nLimit cycles of all that give the first row of Table 4-2:\n";
    for (what, range) in [
        (
            "psi pp with leakage, deg",
            range(points.iter().map(|p| p.cycles[0].yaw / DEGREE)),
        ),
        (
            "psi pp without, deg",
            range(points.iter().map(|p| p.cycles[1].yaw / DEGREE)),
        ),
        (
            "pulses/s with leakage",
            range(points.iter().map(|p| p.cycles[0].pulses)),
        ),
        (
            "pulses/s without",
            range(points.iter().map(|p| p.cycles[1].pulses)),
        ),
    ] {
        let _ = writeln!(text, "  {what:<26} {:.4} to {:.4}", range.0, range.1);
    }
    text += "\n";
    text += match whole {
        0 => "D1: none gives both tables.\n",
        _ => "D1: the first ones above give both tables.\n",
    };
    text += match cycles {
        0 => {
            "D2: none gives the reported limit cycles. The nearest, and by which factor it misses them:\n"
        }
        _ => "D2: the limit cycles come out at these points, the nearest first:\n",
    };
    let mut nearest: Vec<&&Point> = points.iter().collect();
    nearest.sort_by(|a, b| a.cycles_missed_by().total_cmp(&b.cycles_missed_by()));
    for point in nearest.into_iter().take(LISTED) {
        let [leaking, tight] = &point.cycles;
        let _ = writeln!(
            text,
            "  {:.2}: {:.4} and {:.4} deg, {:.1} and {:.1} pulses/s; {}",
            point.cycles_missed_by(),
            leaking.yaw / DEGREE,
            tight.yaw / DEGREE,
            leaking.pulses,
            tight.pulses,
            described(point)
        );
    }
    text
}

fn list<'a>(text: &mut String, points: impl Iterator<Item = &'a (&'a Point, [Score; 2])>) {
    for (point, [hardware, flight]) in points {
        let cell = |score: &Score, of: usize| format!("{}/{of} ({})", score.near, score.exact);
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{:>11} {:>11}  {}",
            cell(hardware, 18),
            cell(flight, 24),
            described(point)
        );
    }
}

fn described(point: &Point) -> String {
    let (a, m) = (&point.assumptions, &point.missile);
    let rate = match a.rate {
        RateSignal::Gyro => "gyro",
        RateSignal::Difference => "difference",
    };
    let mirrored = if a.mirrored { ", mirrored" } else { "" };
    let laboratory = match a.laboratory {
        true => " in the laboratory alone",
        false => "",
    };
    format!(
        "T_D {:.0} ms and friction {:.2}{laboratory}, stepping {:.2}, psi' by {rate}, ram {} quantum{mirrored}; K_a {}, K_r {:.2} s, mu_delta {}",
        1e3 * a.delay,
        a.friction,
        a.stepping,
        a.ram,
        m.attitude_gain,
        m.rate_gain,
        m.nozzle_moment
    )
}
