//! Root loci of Figs. 5 to 10, 13, 14, 17, 20 and 21 (Brunner 1988, ch. II).

use std::borrow::Cow;

use planesman_linear::{Complex, Error, polynomial};

use planesman_show::plot::{Plot, Series, Style};

use super::axis::{DampedInertia, Gains};
use super::depth::DepthDesign;
use super::{heading, pitch, roll};

/// `B` \[ft lbf s\] with rate feedback gains of 2 and 4.71 (p. 19).
const DAMPING: [f64; 2] = [0.34, pitch::MORE_DAMPING];

/// The varied quantity of a locus, with its last value: \[s\] or \[ft/s\].
#[derive(Clone, Copy)]
enum Varied {
    DerivativeGain(f64),
    Speed(f64),
}

/// A locus of the depth loop: figure number, `Kpz`, fixed value of `Kdz` or `U` \[ft/s\], varied quantity, index into [`DAMPING`], and a note.
type DepthLocus = (u8, f64, f64, Varied, usize, &'static str);

const DEPTH_LOCI: [DepthLocus; 9] = {
    use Varied::{DerivativeGain, Speed};
    [
        (5, 1.0, 0.5, DerivativeGain(100.0), 0, ""),
        (
            6,
            1.0,
            1.0,
            DerivativeGain(100.0),
            0,
            "Stable only for Kdz above 0.765.",
        ),
        (7, 0.5, 0.5, DerivativeGain(100.0), 0, ""),
        (8, 0.5, 1.0, DerivativeGain(100.0), 0, ""),
        (
            9,
            0.25,
            1.0,
            DerivativeGain(100.0),
            0,
            "For Kdz = 0.5 the damping ratio is 0.39.",
        ),
        (10, 0.25, 0.5, Speed(20.0), 0, ""),
        (
            13,
            0.25,
            0.0,
            Speed(10.0),
            0,
            "Unstable above 2.27 ft/s (E4).",
        ),
        (14, 0.25, 1.0, DerivativeGain(100.0), 1, ""),
        (17, 0.25, 0.0, Speed(10.0), 1, "Unstable above 4.8 ft/s."),
    ]
};

/// Characteristic polynomial of the depth loop, highest power first.
fn depth_loop(kpz: f64, kdz: f64, u: f64, b: f64) -> Vec<f64> {
    let design = DepthDesign {
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

/// All root loci of the report.
///
/// # Errors
/// [`Error`] if roots of a polynomial cannot be found.
pub fn figures() -> Result<Vec<Plot<'static>>, Error> {
    let mut figures = DEPTH_LOCI
        .into_iter()
        .map(depth_locus)
        .collect::<Result<Vec<_>, _>>()?;
    let of_rate_gain = |axis: DampedInertia, p: f64| {
        locus(20.0, |rate| axis.characteristic(Gains { p, rate }).to_vec())
    };

    let roll = DampedInertia {
        restoring: roll::RESTORING,
        ..roll::AXIS
    };
    figures.push(
        figure(
            "Fig. 20: roll, Kpx = 10, M_e = 0.1, Kdx from 0 to 20",
            "Kdx",
            of_rate_gain(roll, roll::GAINS.p)?,
        )
        .note("The actual restoring moment of the vehicle is 0.163 ft lbf/rad (E17)."),
    );
    figures.push(figure(
        "Fig. 21: heading, Kpy = 1, Kdy from 0 to 20",
        "Kdy",
        of_rate_gain(heading::AXIS, heading::GAINS.p)?,
    ));
    Ok(figures)
}

fn depth_locus((number, kpz, fixed, varied, b, note): DepthLocus) -> Result<Plot<'static>, Error> {
    let (name, what, locus) = match varied {
        Varied::DerivativeGain(last) => (
            "Kdz",
            format!("U = {fixed}, Kdz from 0 to {last}"),
            locus(last, |kdz| depth_loop(kpz, kdz, fixed, DAMPING[b]))?,
        ),
        Varied::Speed(last) => (
            "U [ft/s]",
            format!("Kdz = {fixed}, U from 0 to {last}"),
            locus(last, |u| depth_loop(kpz, fixed, u, DAMPING[b]))?,
        ),
    };
    let damping = ["", ", B = 0.72"][b];
    Ok(figure(
        format!("Fig. {number}: Kpz = {kpz}, {what}{damping}"),
        name,
        locus,
    )
    .note(note))
}

/// A root locus from 0 to `last`: first poles, last poles, and each pole with its value.
struct Locus {
    first: Poles,
    between: Poles,
    last: Poles,
}

/// Poles with the value of the varied quantity.
type Poles = Vec<(Complex<f64>, f64)>;

fn locus(last: f64, polynomial: impl Fn(f64) -> Vec<f64>) -> Result<Locus, Error> {
    const POINTS: i32 = 600;
    let at = |value: f64| -> Result<Poles, Error> {
        let poles = polynomial::roots(&polynomial(value))?;
        Ok(poles.into_iter().map(|pole| (pole, value)).collect())
    };
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

fn figure(
    title: impl Into<Cow<'static, str>>,
    varied: &'static str,
    locus: Locus,
) -> Plot<'static> {
    let series = |style, name: &'static str, poles: Poles| Series {
        at: Some((varied.into(), poles.iter().map(|it| it.1).collect())),
        ..Series::new(style, name, poles.into_iter().map(|(p, _)| (p.re, p.im)))
    };
    Plot::new(title, ["real part [rad/s]", "imaginary part [rad/s]"])
        .from_zero()
        .one_scale()
        .with_all([
            series(Style::Dots, "locus", locus.between),
            series(Style::Crosses, "at zero", locus.first),
            series(Style::Circles, "at the end", locus.last),
        ])
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
            assert!(figure.data().is_ok(), "{}", figure.title);
        }
    }
}
