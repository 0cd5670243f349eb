//! Identification of Brunner 1988, ch. V, on synthetic records: text of the six steps of p. 94 f. with their results, compared with Tables 8 and 9.

use std::fmt::Write as _;

use planesman_identification::{IdentificationError, Model};
use planesman_linear::{ComplexFunctions as _, TransferFunction, pair_text};

use super::book::table_9;
use super::procedure::{Comparison, Detrend, Identification, Orders, Prepared};
use super::synthetic::{BIAS, NOISE, Run, SAMPLE_TIME};
use crate::brunner_1988::predicted::{PitchAlone, scaled, table_8};

/// Smallest increase of the fit, percentage points, for which a higher order is preferred. The report's "very little difference" (p. 95) is below
/// it in each of its excellent fits.
const WORTH_ANOTHER_ORDER: f64 = 5.0;

/// Input and output of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    /// Plane command to pitch rate.
    PitchRate,
    /// Pitch rate to depth.
    Depth,
    /// Plane command to depth.
    DepthOfPlanes,
}

/// The report's fits, in the order of its figures.
pub(super) const FITTED: [(Run, Relation); 8] = [
    (Run::SevenThree, Relation::PitchRate),
    (Run::SevenFive, Relation::PitchRate),
    (Run::EightOne, Relation::PitchRate),
    (Run::EightOne, Relation::Depth),
    (Run::NineOne, Relation::PitchRate),
    (Run::NineOne, Relation::Depth),
    (Run::NineOne, Relation::DepthOfPlanes),
    (Run::NineTwo, Relation::PitchRate),
];

impl Relation {
    /// Names of input and output.
    fn signals(self) -> [&'static str; 2] {
        match self {
            Self::PitchRate => ["plane command", "gyro"],
            Self::Depth => ["gyro", "depth cell"],
            Self::DepthOfPlanes => ["plane command", "depth cell"],
        }
    }

    /// Name of its models in Table 9, before the order.
    fn in_table_9(self) -> &'static str {
        match self {
            Self::PitchRate => "qd",
            Self::Depth => "zq",
            Self::DepthOfPlanes => "zd",
        }
    }

    /// Fits of a run.
    ///
    /// # Errors
    /// A fit fails.
    pub(super) fn identify(self, run: Run) -> Result<Identification, IdentificationError> {
        match self {
            Self::PitchRate => Identification::pitch_rate(run),
            // Figure 53 shows the third order, Table 9 the fourth.
            Self::Depth if run == Run::NineOne => {
                Identification::depth(run, &[2, 3, 4].map(Orders::of))
            }
            Self::Depth => Identification::depth(run, &[2, 4].map(Orders::of)),
            Self::DepthOfPlanes => Identification::depth_of_planes(run),
        }
    }

    /// Predictions of Table 8 at a speed \[ft/s\], volts over volts with the polarity of the records, by name; empty for depth over planes.
    ///
    /// # Errors
    /// None for a finite speed.
    pub(super) fn predicted(
        self,
        speed: f64,
    ) -> Result<Vec<(&'static str, Model)>, IdentificationError> {
        let models = match self {
            Self::PitchRate => vec![
                (
                    "predicted, second order (1 ft/s)",
                    // Its sign is that of the records already: Table 8 drops the minus of Ky.
                    table_8::pitch_rate_second_order(PitchAlone::TABLE_8.restoring)?,
                ),
                (
                    "predicted, third order",
                    scaled(
                        table_8::pitch_rate_third_order()?,
                        -table_8::pitch_rate_gain() * speed,
                    ),
                ),
            ],
            Self::Depth => vec![
                (
                    "predicted, second order",
                    TransferFunction::new(
                        [0.0, 1.0, 1.0]
                            .map(|b| b * table_8::depth_second_order() * speed)
                            .to_vec(),
                        vec![1.0, -2.0, 1.0],
                    )?,
                ),
                (
                    "predicted, fourth order",
                    scaled(
                        table_8::depth_as_printed(speed)?,
                        table_8::depth_gain() / speed,
                    ),
                ),
            ],
            Self::DepthOfPlanes => Vec::new(),
        };
        Ok(models
            .into_iter()
            .map(|(name, g)| (name, model(&g)))
            .collect())
    }
}

/// A sampled transfer function whose denominator begins with 1 and whose numerator begins with 0.
fn model(g: &TransferFunction) -> Model {
    Model {
        sample_time: SAMPLE_TIME,
        a: g.den[1..].to_vec(),
        feedthrough: 0.0,
        b: g.num[g.num.len() - (g.den.len() - 1)..].to_vec(),
        c: Vec::new(),
        bias: 0.0,
    }
}

/// Text of all fits with their six steps.
///
/// # Errors
/// A fit fails.
pub fn procedure_text() -> Result<String, IdentificationError> {
    let mut text = format!(
        "Identification, p. 94 f., step by step. The records are lost; these data are SYNTHETIC,\nwith {:.0} mV of noise (assumed) and {:.0} mV of gyro bias. Table 9 is used with the two misprints of run 9/1 corrected (E19).\n",
        1e3 * NOISE,
        1e3 * BIAS
    );
    for (run, relation) in FITTED {
        text.push('\n');
        text.push_str(&of_run(run, relation)?);
    }
    Ok(text)
}

fn of_run(run: Run, relation: Relation) -> Result<String, IdentificationError> {
    let identified = relation.identify(run)?;
    let [input, output] = relation.signals();
    let mut text = format!(
        "Run {}, {output} to {input}, {} ft/s\n",
        run.name(),
        run.speed()
    );
    let mut step = |name: &str, said: String| {
        // Writing to a String does not fail.
        let _ = writeln!(text, "  {name:<12}{said}");
    };
    let loaded = |signal: &Prepared| {
        let as_loaded: Vec<f64> = signal
            .values
            .iter()
            .map(|v| v + signal.subtracted)
            .collect();
        range(&as_loaded)
    };
    step(
        "1) load",
        format!(
            "{} samples, {SAMPLE_TIME} s apart; {input} {}, {output} {}",
            identified.output.values.len(),
            loaded(&identified.input),
            loaded(&identified.output),
        ),
    );
    step(
        "2) detrend",
        format!(
            "{input}: {}; {output}: {}",
            subtracted(&identified.input),
            subtracted(&identified.output)
        ),
    );
    let orders: Vec<String> = identified
        .models
        .iter()
        .map(|(orders, _)| format!("{} over {}", orders.numerator, orders.denominator))
        .collect();
    step(
        "3) orders",
        format!("numerator over denominator: {}", orders.join(", ")),
    );
    for (orders, found) in &identified.models {
        step("4) RLS", described(&found.model));
        let name = format!("{}{}", relation.in_table_9(), orders.denominator);
        if let Some(printed) = table_9(run.name(), &name) {
            step("   Table 9", described(&printed));
        }
    }
    for (orders, found) in &identified.models {
        step(
            "5) simulate",
            format!(
                "order {} from rest: {}",
                orders.denominator,
                range(&found.simulated)
            ),
        );
    }
    for (orders, found) in &identified.models {
        step(
            "6) compare",
            format!("order {}: {}", orders.denominator, nearness(found)),
        );
    }
    for (name, model) in relation.predicted(run.speed())? {
        step(
            "",
            format!("{name}: {}", nearness(&identified.compare(model))),
        );
    }
    if let Some(conclusion) = conclusion(&identified.models) {
        step("", conclusion);
    }
    Ok(text)
}

/// Description of the subtracted trend.
fn subtracted(signal: &Prepared) -> String {
    // Zero has no sign.
    let level = signal.subtracted + 0.0;
    match signal.detrend {
        Detrend::Nothing => "unchanged".to_owned(),
        Detrend::Mean => format!("mean of {level:.4} V subtracted"),
        Detrend::Beginning => format!("shifted to begin at zero, {level:.4} V subtracted"),
    }
}

fn range(values: &[f64]) -> String {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{least:.3} to {most:.3} V")
}

/// Fit and error of a comparison, as a text.
pub(super) fn nearness(comparison: &Comparison) -> String {
    match comparison.fit {
        Some(fit) => format!("fit {fit:.1} %, rms error {:.4} V", comparison.rms),
        None => "runs away".to_owned(),
    }
}

/// Sentence on the preferred order.
fn conclusion(found: &[(Orders, Comparison)]) -> Option<String> {
    let [(lower, first), .., (higher, last)] = found else {
        return None;
    };
    let more = last.fit? - first.fit?;
    Some(if more < WORTH_ANOTHER_ORDER {
        format!(
            "order {} improves the fit by only {more:.1} points: order {} is sufficient",
            higher.denominator, lower.denominator
        )
    } else {
        format!(
            "order {} improves the fit by {more:.1} points: it is needed",
            higher.denominator
        )
    })
}

/// A model with its roots and its steady-state gain, as a text.
fn described(model: &Model) -> String {
    let stable = model
        .poles()
        .is_ok_and(|poles| poles.iter().all(|z| z.modulus() < 1.0));
    let gain = match model.steady_state_gain() {
        Some(gain) if stable => format!("steady-state gain {gain:.3} V/V"),
        _ => "unstable, no steady-state gain".to_owned(),
    };
    format!(
        "({}) / ({})\n{:14}roots {}; {gain}",
        polynomial(&model.b),
        polynomial(&[&[1.0], model.a.as_slice()].concat()),
        "",
        roots(model)
    )
}

/// Roots of a model's characteristic equation; of a complex pair, the root with positive imaginary part.
pub(super) fn roots(model: &Model) -> String {
    let roots: Vec<String> = model
        .poles()
        .unwrap_or_default()
        .into_iter()
        .filter(|z| z.im >= 0.0)
        .map(|z| pair_text(z, 4))
        .collect();
    roots.join(", ")
}

/// Text of a polynomial, such as `0.0602 z + 0.0875`, highest power first.
fn polynomial(coefficients: &[f64]) -> String {
    let degree = coefficients.len().saturating_sub(1);
    let mut text = String::new();
    for (i, c) in coefficients.iter().enumerate() {
        if *c == 0.0 {
            continue;
        }
        let sign = match (*c < 0.0, text.is_empty()) {
            (true, true) => "-",
            (false, true) => "",
            (true, false) => " - ",
            (false, false) => " + ",
        };
        let power = match degree - i {
            0 => String::new(),
            1 => "z".to_owned(),
            n => format!("z^{n}"),
        };
        let size = match (c.abs(), power.is_empty()) {
            (1.0, false) => String::new(),
            (size, true) => format!("{size:.4}"),
            (size, false) => format!("{size:.4} "),
        };
        text.push_str(&format!("{sign}{size}{power}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_written_as_the_report_does() {
        assert_eq!(
            polynomial(&[1.0, -0.4565, -0.395]),
            "z^2 - 0.4565 z - 0.3950"
        );
        assert_eq!(polynomial(&[0.0, 0.0602, 0.0875]), "0.0602 z + 0.0875");
        assert_eq!(polynomial(&[-0.076, 0.0, 1.0]), "-0.0760 z^2 + 1.0000");
    }

    #[test]
    fn every_step_of_every_run_is_reported_with_its_numbers() {
        let text = procedure_text().expect("identified");
        assert_eq!(text.matches("\nRun ").count(), FITTED.len());
        for step in [
            "1) load",
            "2) detrend",
            "3) orders",
            "4) RLS",
            "5) simulate",
            "6) compare",
        ] {
            assert!(
                text.matches(step).count() >= FITTED.len(),
                "{step} in\n{text}"
            );
        }
        assert!(text.contains("SYNTHETIC"));
        // Table 9, run 8/1, second order (p. 98).
        assert!(
            text.contains("(0.0602 z + 0.0875) / (z^2 - 0.4565 z - 0.3950)"),
            "{text}"
        );
        assert!(
            text.contains("roots 0.8969, -0.4404; steady-state gain 0.995 V/V"),
            "{text}"
        );
        // All of its models have a fit beside them.
        assert_eq!(text.matches("   Table 9").count(), 15, "{text}");
    }

    #[test]
    fn the_predictions_have_the_roots_that_table_8_prints() {
        for (relation, i, printed) in [
            (Relation::PitchRate, 0, vec![(0.9849, 0.0), (0.9562, 0.0)]),
            (
                Relation::PitchRate,
                1,
                vec![(0.9593, 0.0141), (0.9593, -0.0141), (0.8888, 0.0)],
            ),
            (
                Relation::Depth,
                1,
                vec![(1.0, 0.0), (1.0, 0.0), (0.9769, 0.0), (0.8529, 0.0)],
            ),
        ] {
            let (name, model) = &relation.predicted(1.2).expect("a model")[i];
            let roots = model.poles().expect("roots");
            assert_eq!(roots.len(), printed.len());
            for (root, (re, im)) in roots.iter().zip(printed) {
                let off = libm::hypot(root.re - re, root.im - im);
                assert!(off < 3e-4, "{name}: {root} is not {re}, {im}");
            }
        }
    }
}
