//! The root loci of Figs. 5 to 10, 13, 14, 17, 20 and 21 (Brunner 1988, ch. II).
//!
//! The loops and their characteristic equations are the controller's [`design`].

use depth_controller::design::{
    self,
    axis::{DampedInertia, Gains},
    course, pitch, roll,
};
use planesman_linear::{Complex, Error, polynomial};

use crate::plot::{Plot, Series, Style};

use super::figures::Figure;

/// `B` \[ft lbf s\] with rate feedback of 2, and of 4.71 (p. 19).
const DAMPING: [f64; 2] = [0.34, pitch::MORE_DAMPING];

/// What a locus varies.
#[derive(Clone, Copy)]
enum Varied {
    DerivativeGain,
    Speed,
}

/// Characteristic polynomial of the depth loop, highest power first.
fn depth_loop(kpz: f64, kdz: f64, u: f64, b: f64) -> Vec<f64> {
    let design = design::depth::DepthDesign {
        axis: pitch::AXIS,
        pitch: Gains {
            rate: pitch::AXIS.rate_gain_for_damping(b),
            ..pitch::GAINS
        },
        speed: u,
        p: kpz,
        d: kdz,
    };
    design.characteristic().to_vec()
}

/// Every locus of the report.
///
/// # Errors
/// [`Error`] when a polynomial's roots are not found.
pub fn figures() -> Result<Vec<Figure>, Error> {
    use Varied::{DerivativeGain, Speed};
    let mut figures = Vec::new();
    for (title, note, varied, kpz, fixed, b, last) in [
        (
            "Fig. 5: Kpz = 1, U = 0.5, Kdz from 0 to 100",
            "",
            DerivativeGain,
            1.0,
            0.5,
            DAMPING[0],
            100.0,
        ),
        (
            "Fig. 6: Kpz = 1, U = 1, Kdz from 0 to 100",
            "Needs Kdz above 0.765 to be stable.",
            DerivativeGain,
            1.0,
            1.0,
            DAMPING[0],
            100.0,
        ),
        (
            "Fig. 7: Kpz = 0.5, U = 0.5, Kdz from 0 to 100",
            "",
            DerivativeGain,
            0.5,
            0.5,
            DAMPING[0],
            100.0,
        ),
        (
            "Fig. 8: Kpz = 0.5, U = 1, Kdz from 0 to 100",
            "",
            DerivativeGain,
            0.5,
            1.0,
            DAMPING[0],
            100.0,
        ),
        (
            "Fig. 9: Kpz = 0.25, U = 1, Kdz from 0 to 100",
            "Kdz = 0.5 has a damping ratio of 0.39.",
            DerivativeGain,
            0.25,
            1.0,
            DAMPING[0],
            100.0,
        ),
        (
            "Fig. 10: Kpz = 0.25, Kdz = 0.5, U from 0 to 20",
            "",
            Speed,
            0.25,
            0.5,
            DAMPING[0],
            20.0,
        ),
        (
            "Fig. 13: Kpz = 0.25, Kdz = 0, U from 0 to 10",
            "Unstable above 2.27 ft/s (E4).",
            Speed,
            0.25,
            0.0,
            DAMPING[0],
            10.0,
        ),
        (
            "Fig. 14: Kpz = 0.25, U = 1, Kdz from 0 to 100, B = 0.72",
            "",
            DerivativeGain,
            0.25,
            1.0,
            DAMPING[1],
            100.0,
        ),
        (
            "Fig. 17: Kpz = 0.25, Kdz = 0, U from 0 to 10, B = 0.72",
            "Unstable above 4.8 ft/s.",
            Speed,
            0.25,
            0.0,
            DAMPING[1],
            10.0,
        ),
    ] {
        let locus = locus(last, |v| match varied {
            DerivativeGain => depth_loop(kpz, v, fixed, b),
            Speed => depth_loop(kpz, fixed, v, b),
        })?;
        figures.push(figure(title, note, locus));
    }
    for (title, note, axis, p) in [
        (
            "Fig. 20: roll, Kpx = 10, M_e = 0.1, Kdx from 0 to 20",
            "The vehicle's own restoring moment is 0.163 ft lbf (E17).",
            DampedInertia {
                restoring: roll::RESTORING,
                ..roll::AXIS
            },
            roll::GAINS.p,
        ),
        (
            "Fig. 21: course, Kpy = 1, Kdy from 0 to 20",
            "",
            course::AXIS,
            course::GAINS.p,
        ),
    ] {
        let locus = locus(20.0, |rate| axis.characteristic(Gains { p, rate }).to_vec())?;
        figures.push(figure(title, note, locus));
    }
    Ok(figures)
}

/// Where the poles begin, go and end while a value runs from 0 to `last`.
struct Locus {
    first: Vec<Complex<f64>>,
    between: Vec<Complex<f64>>,
    last: Vec<Complex<f64>>,
}

fn locus(last: f64, polynomial: impl Fn(f64) -> Vec<f64>) -> Result<Locus, Error> {
    const POINTS: i32 = 1500;
    let at = |value: f64| polynomial::roots(&polynomial(value));
    let mut between = Vec::new();
    for i in 1..POINTS {
        // Dense where the value is small: that is where the poles move.
        between.extend(at(last * (f64::from(i) / f64::from(POINTS)).powi(3))?);
    }
    Ok(Locus {
        first: at(0.0)?,
        between,
        last: at(last)?,
    })
}

fn figure(title: &'static str, note: &'static str, locus: Locus) -> Figure {
    let points = |poles: Vec<Complex<f64>>| poles.iter().map(|p| (p.re, p.im)).collect();
    let series = |name, poles, style| Series {
        name,
        points: points(poles),
        style,
    };
    Figure {
        note: note.into(),
        plot: Plot {
            title,
            x: "real part [rad/s]",
            y: "imaginary part [rad/s]",
            y_down: false,
            x_shows: &[0.0],
            series: vec![
                series("locus", locus.between, Style::Dots),
                series("at zero", locus.first, Style::Crosses),
                series("at the end", locus.last, Style::Circles),
            ],
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rightmost(polynomial: &[f64]) -> f64 {
        polynomial::roots(polynomial)
            .expect("roots")
            .iter()
            .map(|p| p.re)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Routh: B k > J Kpz k U, so U < B / (J Kpz).
    #[test]
    fn the_depth_loop_without_derivative_gain_turns_unstable_at_two_and_a_quarter_feet_per_second()
    {
        assert!(rightmost(&depth_loop(0.25, 0.0, 2.26, DAMPING[0])) < 0.0);
        assert!(rightmost(&depth_loop(0.25, 0.0, 2.28, DAMPING[0])) > 0.0);
        assert!(rightmost(&depth_loop(0.25, 0.0, 4.79, DAMPING[1])) < 0.0);
        assert!(rightmost(&depth_loop(0.25, 0.0, 4.81, DAMPING[1])) > 0.0);
    }

    #[test]
    fn every_locus_can_be_drawn() {
        for figure in figures().expect("roots") {
            assert!(figure.plot.svg().is_ok(), "{}", figure.plot.title);
        }
    }
}
