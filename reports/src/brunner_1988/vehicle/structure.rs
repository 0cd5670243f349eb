//! Thickness and bending of the hull's flat plates and beams (Brunner 1988, pp. 50-52).

/// Thickness \[m\] of a plate `length` \[m\] long under `pressure` \[Pa\] with the stress `stress` \[Pa\]: from `S = k w L^2 / t^2`.
#[must_use]
pub(super) fn plate_thickness(k: f64, pressure: f64, length: f64, stress: f64) -> f64 {
    length * (k * pressure / stress).sqrt()
}

/// Deflection \[m\] at the centre of a plate `breadth` \[m\] wide with clamped sides: `k1 w b^4 / (E t^3)`.
#[must_use]
pub(super) fn plate_deflection(
    k1: f64,
    pressure: f64,
    breadth: f64,
    modulus: f64,
    thickness: f64,
) -> f64 {
    k1 * pressure * breadth.powi(4) / (modulus * thickness.powi(3))
}

/// Width \[m\] of a beam of `height` \[m\] with clamped ends that deflects by `deflection` \[m\] under `load` \[N\], distributed over its `length` \[m\]:
/// from `y = w L^3 / (384 E I)` with `I = b h^3 / 12`.
#[must_use]
pub(super) fn beam_width(
    load: f64,
    length: f64,
    modulus: f64,
    height: f64,
    deflection: f64,
) -> f64 {
    let second_moment = load * length.powi(3) / (384.0 * modulus * deflection);
    12.0 * second_moment / height.powi(3)
}
