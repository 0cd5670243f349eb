//! The report with all its numbers and figures.

use crate::book::{Book, BookError, Chapter, Names, Recomputed, Report, ReportError};

use crate::brunner_1988::{
    calibration_figures, controllers, identification, program_figures, vehicle,
};

/// Description of the report.
pub const REPORT: Report = Report {
    name: "Brunner 1988",
    citation: "G. M. Brunner, Experimental Verification of AUV Performance, Naval Postgraduate School, March 1988.",
    book,
    names: || Names::parse(include_str!("../../data/brunner_1988/names.json")),
    recomputed,
    procedure: Some(|| identification::procedure_text().map_err(ReportError::computed)),
    figures,
};

fn book() -> Result<Book, BookError> {
    Book::of_shares([
        vehicle::book()?,
        controllers::book()?,
        identification::book()?,
    ])
}

fn recomputed() -> Recomputed {
    let named = |(id, value): (&str, f64)| (id.to_owned(), value);
    let vehicle = vehicle::recomputed().into_iter().map(named);
    let identification = identification::recomputed().into_iter().map(named);
    vehicle
        .chain(controllers::recomputed())
        .chain(identification)
        .collect()
}

fn figures() -> Result<Vec<Chapter>, ReportError> {
    Ok(vec![
        Chapter {
            title: "Figures B1 to B10",
            note: "These figures are missing in the copy of the report. They are recomputed by programs T2 to T5, including the programs' errors.",
            figures: program_figures::figures(),
        },
        Chapter {
            title: "Root loci",
            note: "",
            figures: controllers::root_loci::figures().map_err(ReportError::computed)?,
        },
        Chapter {
            title: "Time responses of the depth loop",
            note: "",
            figures: controllers::time_responses::figures()?,
        },
        Chapter {
            title: "Calibrations: Figures 29 to 36, 38, 40 to 43",
            note: "The measured points are missing in the copy; the lines printed in the figures are drawn. Fig. 37, vessel speed over command voltage, has no printed line and is omitted.",
            figures: calibration_figures::figures(),
        },
        Chapter {
            title: "Identification: Figures 45 to 56",
            note: "The thesis' records are lost. These records are SYNTHETIC: third-order plants of Table 8's structure in consistent units, inputs shaped as described on pp. 99-101, 5 mV of noise (assumed) and the thesis' 25 mV of gyro bias. The procedure is that of p. 94 f., as printed. Dashed curves are the predictions of Table 8, also as printed (E2). The text mentions them only for Fig. 45, and says on p. 114 that the predictions of higher order were poorer than hoped.",
            figures: identification::figures().map_err(ReportError::computed)?,
        },
    ])
}
