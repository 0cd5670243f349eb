//! G. M. Brunner, *Experimental Verification of AUV Performance*, Naval Postgraduate School, March 1988:
//! its programs, numbers, procedure and figures, computed again.
//!
//! Nothing of the product depends on this crate; only `planesman reproduce` and the report's own commands do.

pub mod identification;
