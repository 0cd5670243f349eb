//! Sizes of an actuator.
