//! Deserializers for positive quantities of a file: `#[serde(with = "positive::length")]`.

use planesman_units::Rule::AboveZero;

planesman_units::readers! {
    angle: Angle, AboveZero;
    rate: Rate, AboveZero;
    length: Length, AboveZero;
    area: Area, AboveZero;
    volume: Volume, AboveZero;
    speed: Speed, AboveZero;
    acceleration: Acceleration, AboveZero;
    time: Time, AboveZero;
    mass: Mass, AboveZero;
    inertia: Inertia, AboveZero;
    density: Density, AboveZero;
    viscosity: Viscosity, AboveZero;
    force: Force, AboveZero;
    moment: Moment, AboveZero;
    rotary_damping: RotaryDamping, AboveZero;
    optional optional_force: Force, AboveZero;
    optional optional_length: Length, AboveZero;
}
