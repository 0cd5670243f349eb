//! The two reports that the suite brings back: their numbers, what these come to, and their figures.

use anyhow::{Result, anyhow};
use brunner_1988::identification;
use planesman_book::Book;

use super::{actuator_figures, root_loci, shares, time_responses};
use planesman_plot::Plot;

/// A report.
#[derive(Clone, Copy)]
pub struct Report {
    /// Author and year.
    pub name: &'static str,
    /// Author, title, publisher, date.
    pub citation: &'static str,
    /// Its numbers and errata.
    pub book: fn() -> Result<Book>,
    /// What its numbers come to: name and value, in the entry's unit.
    pub recomputed: fn() -> Vec<(String, f64)>,
    /// What it did beyond numbers, done again and told in words; `None` for nothing.
    pub account: Option<fn() -> Result<String>>,
    /// Its lost figures.
    pub figures: fn() -> Result<Vec<Chapter>>,
}

/// Figures that belong together.
pub struct Chapter {
    /// The heading.
    pub title: &'static str,
    /// What holds for all of them.
    pub note: &'static str,
    /// The figures.
    pub figures: Vec<Plot<'static>>,
}

/// Both of them.
pub const REPORTS: [Report; 2] = [
    Report {
        name: "Brunner 1988",
        citation: "G. M. Brunner, Experimental Verification of AUV Performance, Naval Postgraduate School, March 1988.",
        book: shares::book,
        recomputed: || {
            let owned = |(id, value): (&str, f64)| (id.to_owned(), value);
            shares::recomputed().into_iter().map(owned).collect()
        },
        account: Some(identification::account),
        figures: brunner_1988,
    },
    Report {
        name: "IBM 1966",
        citation: "G. W. Scott, Digital Hydraulic Actuator Study, Phase III Final Report, IBM 66-L03-005, November 1966.",
        book: || Ok(dha_actuator::book::ibm_1966()?),
        recomputed: dha_actuator::book::recomputed,
        account: None,
        figures: ibm_1966,
    },
];

fn brunner_1988() -> Result<Vec<Chapter>> {
    Ok(vec![
        Chapter {
            title: "Figures B1 to B10",
            note: "The copy of the report has lost them. These are what programs T2 to T5 put out, with the errors they had.",
            figures: brunner_1988::program_figures::figures(),
        },
        Chapter {
            title: "Root loci",
            note: "",
            figures: root_loci::figures()?,
        },
        Chapter {
            title: "Time responses of the depth loop",
            note: "",
            figures: time_responses::figures().map_err(|reason| anyhow!(reason))?,
        },
        Chapter {
            title: "Identification: Figures 45 to 56",
            note: "The thesis' records are lost. These are SYNTHETIC: third-order plants of Table 8's structure in consistent units, inputs shaped as pp. 99-101 describe them, 5 mV of noise (assumed) and the thesis' 25 mV of gyro bias. The procedure is that of p. 94 f., as printed; beside its fits, dashed, what Table 8 predicts, as printed too (E2). The text says so of Fig. 45 alone, and on p. 114 that the predictions of higher order were poorer than hoped.",
            figures: identification::figures()?,
        },
    ])
}

fn ibm_1966() -> Result<Vec<Chapter>> {
    Ok(vec![
        Chapter {
            title: "Section III: mathematical model and hardware",
            note: "The copy of the report has lost its records. These are flights of the surrogate missile PS-2 with the actuator of Table 3-1; the report's own missile is lost, and so is the hardware's behaviour. Figures 3-3 and 3-4 are block diagrams: the loop closed on the hardware or on the model, with the other flown along under the same commands; and the equations of the ram with its load.",
            figures: actuator_figures::section_3()?,
        },
        Chapter {
            title: "Section IV: digital and analog flight control",
            note: "Flights of the surrogate missile PS-2 with the actuator of Table 4-1.",
            figures: actuator_figures::section_4()?,
        },
        Chapter {
            title: "Section V: linear model",
            note: "Of the surrogate missile PS-2.",
            figures: actuator_figures::section_5()?,
        },
    ])
}
