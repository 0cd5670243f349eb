//! dha_actuator
