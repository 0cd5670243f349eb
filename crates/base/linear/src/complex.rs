//! Functions of complex numbers with identical bits on every machine.

use nalgebra::{Complex, ComplexField};

/// Functions that num-complex provides only with a C library, computed with nalgebra and `libm`. Nalgebra's own trait is not imported instead: it
/// also has `powi`, by logarithm and exponential, which would hide num-complex's exact one.
pub trait ComplexFunctions: Sized {
    /// `|z|`
    #[must_use]
    fn modulus(self) -> f64;
    /// Argument, -pi to pi \[rad\].
    #[must_use]
    fn argument(self) -> f64;
    /// `e^z`
    #[must_use]
    fn exp(self) -> Self;
    /// Principal logarithm, with an imaginary part from -pi to pi.
    #[must_use]
    fn ln(self) -> Self;
    /// Principal square root, with a real part of at least 0.
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

/// `radius e^(j angle)`; `angle` in rad.
#[must_use]
pub fn polar(radius: f64, angle: f64) -> Complex<f64> {
    let (sin, cos) = libm::sincos(angle);
    Complex::new(radius * cos, radius * sin)
}
