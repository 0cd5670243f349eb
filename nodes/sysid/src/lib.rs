//! Recursive identification: a discrete transfer function between any two signals, found
//! while they arrive, live from topics or from a bag in the same way.
//!
//! ```text
//! messages -> reader -> align -> learner (an estimator) -> readout -> ModelEstimate
//! ```
//! - [`signal`]: `TOPIC:FIELD`, one number of one message.
//! - [`source`], [`bag_source`], [`csv_source`]: samples of any signals out of a bag or a table.
//! - [`timing`]: rate, jitter, gaps and duplicates of stamps.
//! - [`resample`]: samples put on a uniform grid.
//! - [`command`]: `sysid topics` ([`topics_command`]), `sysid fit` ([`fit_command`]), `sysid replay` ([`replay`]).
//! - [`message_types`], [`reader`]: the same signals out of messages that arrive.
//! - [`align`]: inputs and outputs in the order of their stamps.
//! - [`record`]: inputs and outputs on one uniform grid, from wherever they come.
//! - [`regression`]: the equation-error model, row by row.
//! - [`rls`]: recursive least squares in square-root information form.
//! - [`batch`]: least squares over a whole record.
//! - [`structure`]: what is unknown, what is known beforehand, and the records to find it from.
//! - [`estimators`]: least squares, ARMAX, output error, instrumental variables, recursions, the vehicle's own
//!   equations, a Kalman filter, two stages in a closed loop: behind one trait.
//! - [`uncertainty`]: standard errors carried to poles, zeros, gains, frequency responses.
//! - [`validation`]: residual tests, order search, what a record cannot tell.
//! - [`taken`]: a record from signals named on the command line.
//! - [`analysis`]: all of these on one record, with a verdict in plain words;
//!   [`fit_command`] prints it.
//! - [`conversion`]: from the sampled model to the continuous one, and to the pitch equation.
//! - [`procedure`]: the thesis' own steps.
//! - [`synthetic`]: five runs in place of the thesis' lost records.
//! - [`montecarlo`]: what every estimator makes of those runs, over many noises;
//!   [`montecarlo_command`] prints it.
//! - [`model`]: poles, steady gain, response.
//! - [`fit`]: how well a model explains a record.
//! - [`live_grid`]: signals that are live and have stamps of their own, put on one grid.
//! - [`learner`]: samples in, an estimate and its validity out, by any recursive estimator.
//! - [`readout`]: the transfer function of what was learnt, and its covariance.
//! - [`book`]: the thesis' identified models, gone through again.
//! - [`parameters`]: every tunable, its default and unit.
//! - [`pair`]: one pair of signals, from its messages to its estimates.
//! - [`watch`]: estimates live in the terminal, with [`sparkline`].
//! - [`core`]: messages in, estimates out, of all pairs.
//!
//! The procedure is that of Brunner, *Experimental Verification of AUV Performance* (NPS
//! thesis, March 1988), ch. V, on whole histories instead of assumed zero ones.

pub mod align;
pub mod analysis;
pub mod bag_source;
pub mod batch;
pub mod book;
pub mod command;
pub mod conversion;
pub mod core;
pub mod csv_source;
pub mod estimators;
pub mod fit;
pub mod fit_command;
pub mod learner;
pub mod live_grid;
pub mod message_types;
pub mod model;
pub mod montecarlo;
pub mod montecarlo_command;
pub mod node;
pub mod pair;
pub mod parameters;
pub mod procedure;
pub mod reader;
pub mod readout;
pub mod record;
pub mod regression;
pub mod replay;
pub mod resample;
pub mod rls;
pub mod signal;
pub mod source;
pub mod sparkline;
pub mod structure;
pub mod synthetic;
pub mod taken;
pub mod timing;
pub mod topics_command;
pub mod uncertainty;
pub mod validation;
pub mod watch;
