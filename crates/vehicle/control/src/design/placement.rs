//! Gains that place the poles of the depth loop.
//!
//! Three poles, a real one `-p` and a pair of natural frequency `wn` and damping ratio `zeta`, determine three gains; the fourth, `Kpy`, is
//! chosen. With `k = K/J`, `b = B/J`, `m = Me/J`, comparing
//!
//! ```text
//! s^3 + (b + Kr k) s^2 + (Kpy k + m + Kdz Kpy k U) s + Kpz Kpy k U
//!   = (s + p) (s^2 + 2 zeta wn s + wn^2)
//! ```
//! coefficients gives `Kr`, `Kdz` and `Kpz` (the loop of Brunner, NPS thesis, 1988, pp. 11 to 20).

use crate::gains::{LoopGains, PitchModel};
/// The wanted poles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poles {
    /// `p`, 1/s.
    pub real: f64,
    /// `wn`, rad/s.
    pub frequency: f64,
    /// `zeta`.
    pub damping_ratio: f64,
}

/// The gains that place these poles for a vehicle with this pitch model at a speed (m/s) and a given `Kpy`. A gain may be negative: then
/// feedback of the intended sign cannot place the poles.
#[must_use]
pub fn gains(model: &PitchModel, speed: f64, poles: &Poles, pitch_p: f64) -> LoopGains {
    let Poles {
        real,
        frequency,
        damping_ratio,
    } = *poles;
    let stiffness = pitch_p * model.plane;
    let squared = frequency * frequency;
    let pair = 2.0 * damping_ratio * frequency;
    LoopGains {
        depth_p: real * squared / (stiffness * speed),
        depth_d: (squared + pair * real - stiffness - model.restoring) / (stiffness * speed),
        pitch_p,
        pitch_rate: (real + pair - model.damping) / model.plane,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::dive_loop::{DiveLoop, DivePlant, Memory, Path};
    use planesman_linear::ComplexFunctions as _;

    #[test]
    fn the_poles_come_out_where_they_were_wanted() {
        let model = PitchModel {
            plane: 0.47,
            damping: 1.2,
            restoring: 0.27,
        };
        let wanted = Poles {
            real: 0.4,
            frequency: 1.1,
            damping_ratio: 0.8,
        };
        let dive = DiveLoop {
            plant: DivePlant::of_pitch(&model, 0.5).unwrap(),
            gains: gains(&model, 0.5, &wanted, 2.0),
            memory: Memory::default(),
            path: Path::default(),
        };
        let poles = dive.closed_loop().unwrap().poles().unwrap();
        assert!((poles[0].re + 0.4).abs() < 1e-9, "{poles:?}");
        assert!((poles[1].modulus() - 1.1).abs() < 1e-9);
        assert!((poles[1].re + 0.8 * 1.1).abs() < 1e-9);
    }
}
