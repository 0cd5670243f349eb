//! G. W. Scott, *Digital Hydraulic Actuator Study, Phase III Final Report*, IBM 66-L03-005, November 1966:
//! its bench, numbers and figures, computed again.
//!
//! Nothing of the product depends on this crate; only `planesman reproduce` and the report's own commands do.
