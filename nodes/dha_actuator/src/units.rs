//! The units of the reports, inches and pounds, in SI.

pub use planesman_units::{DEGREE, INCH, POUND_FORCE as POUND, PSI};
