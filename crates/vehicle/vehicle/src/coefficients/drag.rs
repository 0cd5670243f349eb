//! Friction and pressure drag (Brunner 1988, Tables 5 and 6, pp. 58-59, after Hoerner).
//!
//! ```text
//! Cf = 1.33 / Re^(1/2)  laminar      Cfb = Cf S_fb / A_b   forebody, on the base area
//! Cf = 0.043 / Re^(1/6) turbulent    Cdb = 0.029 / Cfb^(1/2)   base
//! ```

/// Reynolds number of a plate of `length` \[m\] at `speed` \[m/s\] in water of `viscosity` \[m^2/s\].
#[must_use]
pub fn reynolds(speed: f64, length: f64, viscosity: f64) -> f64 {
    speed * length / viscosity
}

/// `Cf` of a laminar boundary layer.
#[must_use]
pub fn laminar_friction(re: f64) -> f64 {
    1.33 / re.sqrt()
}

/// `Cf` of a turbulent boundary layer.
#[must_use]
pub fn turbulent_friction(re: f64) -> f64 {
    0.043 / libm::pow(re, 1.0 / 6.0)
}

/// `Cfb`: friction `cf` of the forebody's wetted area, referred to the base area.
#[must_use]
pub fn forebody(cf: f64, forebody_area: f64, base_area: f64) -> f64 {
    cf * forebody_area / base_area
}

/// `Cdb`: drag of the base after a forebody with `cfb`.
#[must_use]
pub fn base(cfb: f64) -> f64 {
    0.029 / cfb.sqrt()
}

/// Drag \[N\] for the coefficient `c` and the area `area` \[m^2\].
#[must_use]
pub fn drag(rho: f64, c: f64, area: f64, speed: f64) -> f64 {
    0.5 * rho * c * area * speed * speed
}
