//! Two historical reports and recorded validations, recomputed. The program `planesman-reports` prints the results.
//!
//! - [`book`]: printed numbers of a report, with sources, errata and verdicts.
//! - [`brunner_1988`], [`ibm_1966`], [`hopsan`]: the thesis, the actuator study and Hopsan's recorded validations.
//! - [`studies`]: the actuator in the loops of both reports: bench tables, frequency responses, limit cycles.

pub mod book;
pub mod brunner_1988;
pub mod hopsan;
pub mod ibm_1966;
pub mod studies;
