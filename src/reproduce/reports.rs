//! The two reports that the suite brings back: their numbers, what these come to, and their figures.

use anyhow::Result;
use brunner_1988::controllers;
use planesman_book::{Chapter, Report};

use super::{identification, run_figures, shares};

/// Both of them.
pub const REPORTS: [Report; 2] = [
    Report {
        name: "Brunner 1988",
        citation: "G. M. Brunner, Experimental Verification of AUV Performance, Naval Postgraduate School, March 1988.",
        book: shares::book,
        recomputed: shares::recomputed,
        account: Some(identification::account),
        figures: brunner_1988,
    },
    ibm_1966::REPORT,
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
            figures: controllers::root_loci::figures()?,
        },
        Chapter {
            title: "Time responses of the depth loop",
            note: "",
            figures: controllers::time_responses::figures()?,
        },
        Chapter {
            title: "Identification: Figures 45 to 56",
            note: "The thesis' records are lost. These are SYNTHETIC: third-order plants of Table 8's structure in consistent units, inputs shaped as pp. 99-101 describe them, 5 mV of noise (assumed) and the thesis' 25 mV of gyro bias. The procedure is that of p. 94 f., as printed; beside its fits, dashed, what Table 8 predicts, as printed too (E2). The text says so of Fig. 45 alone, and on p. 114 that the predictions of higher order were poorer than hoped.",
            figures: run_figures::figures()?,
        },
    ])
}
