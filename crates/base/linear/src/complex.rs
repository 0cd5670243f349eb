//! Functions of complex numbers whose bits are the same on every machine.

use nalgebra::{Complex, ComplexField};

/// Functions of a complex number that num-complex has only with a C library, by nalgebra on `libm`. Nalgebra's own trait is not imported for them: it
/// also has `powi`, by logarithm and exponential, and would put it before num-complex' exact products.
pub trait ComplexFunctions: Sized {
    /// `|z|`
    #[must_use]
    fn modulus(self) -> f64;
    /// The angle, -pi to pi \[rad\].
    #[must_use]
    fn argument(self) -> f64;
    /// `e^z`
    #[must_use]
    fn exp(self) -> Self;
    /// The logarithm with an imaginary part from -pi to pi.
    #[must_use]
    fn ln(self) -> Self;
    /// The square root with a real part that is not negative.
    #[must_use]
    fn sqrt(self) -> Self;
}

impl ComplexFunctions for Complex<f64> {
    fn modulus(self) -> f64 {
        ComplexField::modulus(self)
    }

    fn argument(self) -> f64 {
        ComplexField::argument(self)
    }

    fn exp(self) -> Self {
        ComplexField::exp(self)
    }

    fn ln(self) -> Self {
        ComplexField::ln(self)
    }

    fn sqrt(self) -> Self {
        ComplexField::sqrt(self)
    }
}

/// `radius e^(j angle)`, the angle in rad.
#[must_use]
pub fn polar(radius: f64, angle: f64) -> Complex<f64> {
    let (sin, cos) = libm::sincos(angle);
    Complex::new(radius * cos, radius * sin)
}
