//! Volume, displaced weight and prismatic coefficient (Brunner 1988, pp. 45, 52).

/// Volume \[m^3\] of a box.
#[must_use]
pub fn box_volume(length: f64, breadth: f64, depth: f64) -> f64 {
    length * breadth * depth
}

/// Volume \[m^3\] of a wedge that tapers over `length` to an edge `breadth` wide.
#[must_use]
pub fn wedge_volume(length: f64, breadth: f64, depth: f64) -> f64 {
    0.5 * length * breadth * depth
}

/// Displaced weight \[N\] of `volume` \[m^3\] in water of `specific_weight` \[N/m^3\].
#[must_use]
pub fn displaced_weight(volume: f64, specific_weight: f64) -> f64 {
    volume * specific_weight
}

/// Volume \[m^3\] that displaces `weight` \[N\].
#[must_use]
pub fn volume_of_weight(weight: f64, specific_weight: f64) -> f64 {
    weight / specific_weight
}

/// `C_p`, the volume relative to a prism with the hull's largest section.
#[must_use]
pub fn prismatic_coefficient(volume: f64, section: f64, length: f64) -> f64 {
    volume / (section * length)
}
