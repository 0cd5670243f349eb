//! The study's bench: the actuator in a simulated flight control (IBM 66-L03-005, Sections II to IV).
//!
//! - [`missile`]: the yaw plant, a surrogate of the lost one.
//! - [`autopilot`]: the digital autopilot.
//! - [`case`]: missile, actuator, autopilot and pulse logic as they are put to the test.
//! - [`digital_loop`]: a case in flight.
//! - [`analog_loop`]: the analog flight control it is compared with.
//! - [`pulse_train`]: the hydraulics alone under given pulses.
//! - [`procedure`]: the step test, the gain margin, the limit cycle.
//! - [`tables`]: what the rows of Tables 3-2 and 4-2 change.

pub mod analog_loop;
pub mod autopilot;
pub mod case;
pub mod digital_loop;
pub mod missile;
pub mod procedure;
pub mod pulse_train;
pub mod tables;
