//! G. M. Brunner, *Experimental Verification of AUV Performance*, Naval Postgraduate School, March 1988: programs, numbers, procedure and figures,
//! recomputed.
//!
//! - [`programs`]: programs T2 to T5, as printed; [`program_figures`]: Figures B1 to B10; [`calibration_figures`]: calibration curves.
//! - [`predicted`]: the predicted transfer functions, as printed and corrected.
//! - [`plane_forces`]: the report's estimate of the planes' size; [`track`]: a recorded manoeuvre.
//! - [`vehicle`]: the vehicle's numbers, recomputed.
//! - [`controllers`]: ch. II and program T6.
//! - [`identification`]: the procedure of ch. V, its numbers and figures.
//! - [`REPORT`]: numbers and figures.

pub mod calibration_figures;
pub mod controllers;
pub mod identification;
pub mod plane_forces;
pub mod predicted;
pub mod program_figures;
pub mod programs;
mod report;
pub mod track;
pub mod vehicle;

pub use report::REPORT;
