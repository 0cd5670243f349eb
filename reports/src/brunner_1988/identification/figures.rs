//! Figs. 45 to 56: fits to the runs, and their inputs (Brunner 1988, pp. 99-113). The report's records are lost, so synthetic records are used. The
//! x axis is the number of sampling periods (p. 97), the y axis is in volts.
//!
//! The contents of the figures are known from the text: curve 1 is the record, 2 and 3 are fits, and curve 4 of Fig. 53 is the depth predicted from
//! the plane command. The text mentions a second-order prediction only for Fig. 45; here the prediction of Table 8 is drawn with every fit.

use planesman_identification::IdentificationError;
use planesman_show::plot::{Plot, Style};

use super::procedure::{Comparison, Detrend, Identification};
use super::procedure_text::{Relation, nearness, roots};
use super::synthetic::Run;

/// A diverging model is drawn up to this multiple of the record's largest value.
const RUNS_AWAY: f64 = 3.0;

/// All figures, in the report's order.
///
/// # Errors
/// A fit fails.
pub fn figures() -> Result<Vec<Plot<'static>>, IdentificationError> {
    use Run::{EightOne, NineOne, NineTwo, SevenFive, SevenThree};
    Ok(vec![
        rate(45, SevenThree, "Four short pulses.")?,
        planes(46, SevenThree, "UD: detrended."),
        rate(47, SevenFive, "A square wave.")?,
        planes(48, SevenFive, "Y4: shifted to begin at zero."),
        rate(49, EightOne, "The report calls this fit excellent.")?,
        depth(50, EightOne)?,
        planes(51, EightOne, "Y4."),
        rate(52, NineOne, "Two pulses.")?,
        depth(53, NineOne)?,
        planes(54, NineOne, "Y4 with its offset removed."),
        rate(
            55,
            NineTwo,
            "A fast sinusoid: a good fit only shows that gain and phase match at 1.25 Hz.",
        )?,
        planes(56, NineTwo, "The input of Fig. 55."),
    ])
}

fn figure(number: u8, run: Run, what: &str, y: &'static str) -> Plot<'static> {
    let title = format!(
        "Fig. {number}, run {} at {} ft/s: {what}",
        run.name(),
        run.speed()
    );
    Plot::new(title, ["sampling periods of 0.05 s", y])
}

fn by_sample(values: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    values.iter().enumerate().map(|(k, v)| (k as f64, *v))
}

/// The plane command after step 2 of the procedure.
fn planes(number: u8, run: Run, note: &str) -> Plot<'static> {
    let command = Detrend::of_planes(run).apply(run.planes());
    figure(number, run, "dive plane command (synthetic)", "command [V]")
        .note(format!("{note} 0.2 V is 20 degrees."))
        .line("planes", by_sample(&command.values))
}

fn rate(number: u8, run: Run, note: &str) -> Result<Plot<'static>, IdentificationError> {
    let plot = figure(number, run, "pitch rate (synthetic)", "gyro [V]");
    let identified = Relation::PitchRate.identify(run)?;
    Drawing::of(plot, &identified).predictions(Relation::PitchRate, run, note)
}

/// Depth fitted to pitch rate, in Fig. 53 also to the plane command.
fn depth(number: u8, run: Run) -> Result<Plot<'static>, IdentificationError> {
    let plot = figure(number, run, "depth (synthetic)", "depth cell [V]");
    let mut identified = Relation::Depth.identify(run)?;
    identified.models.truncate(2);
    let mut drawing = Drawing::of(plot, &identified);
    if run == Run::NineOne {
        let of_planes = Relation::DepthOfPlanes.identify(run)?;
        let (_, found) = &of_planes.models[0];
        drawing.curve(
            "4: fourth order, from the plane command".to_owned(),
            found,
            Style::Line,
        );
    }
    drawing.predictions(
        Relation::Depth,
        run,
        "The synthetic depth is computed from the pitch rate by Table 8's second-order model. The error of this prediction is the gyro bias left by detrending, integrated twice.",
    )
}

/// A figure under construction, with its note.
struct Drawing<'i> {
    identified: &'i Identification,
    plot: Plot<'static>,
    said: Vec<String>,
}

impl<'i> Drawing<'i> {
    /// The record and its fits: curves 1, 2 and 3.
    fn of(plot: Plot<'static>, identified: &'i Identification) -> Self {
        let plot = plot.line("1: actual", by_sample(&identified.output.values));
        let mut drawing = Self {
            identified,
            plot,
            said: Vec::new(),
        };
        for ((orders, found), number) in identified.models.iter().zip(2..) {
            let order = ["", "first", "second", "third", "fourth"][orders.denominator];
            drawing.curve(format!("{number}: {order} order"), found, Style::Line);
            if let Some(said) = drawing.said.last_mut() {
                said.push_str(&format!(", roots {}", roots(&found.model)));
            }
        }
        drawing
    }

    fn curve(&mut self, name: String, found: &Comparison, style: Style) {
        self.said.push(format!("{name}: {}", nearness(found)));
        let record = self.identified.output.values.iter();
        let most = RUNS_AWAY * record.fold(0.0_f64, |most, v| most.max(v.abs()));
        let within: Vec<_> = by_sample(&found.simulated)
            .take_while(|(_, v)| v.abs() <= most)
            .collect();
        let plot = std::mem::replace(&mut self.plot, Plot::new("", ["", ""]));
        self.plot = plot.with(style, name, within);
    }

    /// Adds the predictions of Table 8.
    fn predictions(
        mut self,
        relation: Relation,
        run: Run,
        note: &str,
    ) -> Result<Plot<'static>, IdentificationError> {
        for (name, model) in relation.predicted(run.speed())? {
            let predicted = self.identified.compare(model);
            self.curve(name.to_owned(), &predicted, Style::Dashed);
        }
        Ok(self.plot.note(format!("{note} {}.", self.said.join("; "))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(number: usize) -> Plot<'static> {
        figures().expect("fitted").swap_remove(number - 45)
    }

    #[test]
    fn all_twelve_figures_can_be_drawn_and_say_that_they_are_synthetic() {
        let figures = figures().expect("fitted");
        assert_eq!(figures.len(), 12);
        for (figure, number) in figures.into_iter().zip(45..) {
            assert!(figure.data().is_ok(), "{}", figure.title);
            assert!(figure.title.starts_with(&format!("Fig. {number}, ")));
            assert!(figure.title.ends_with("(synthetic)"));
        }
    }

    #[test]
    fn the_curves_are_those_of_the_text() {
        let names = |number| -> Vec<String> {
            drawn(number)
                .series
                .into_iter()
                .map(|s| s.name.into_owned())
                .collect()
        };
        // P. 99 f.: record, two fits, and the prediction of second order.
        assert_eq!(
            names(45)[..4],
            [
                "1: actual",
                "2: second order",
                "3: third order",
                "predicted, second order (1 ft/s)"
            ]
        );
        // P. 100: second and fourth order.
        assert_eq!(
            names(50)[..3],
            ["1: actual", "2: second order", "3: fourth order"]
        );
        // P. 101: second and third order, and depth from the plane command.
        assert_eq!(
            names(53)[..4],
            [
                "1: actual",
                "2: second order",
                "3: third order",
                "4: fourth order, from the plane command"
            ]
        );
    }
}
