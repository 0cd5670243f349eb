//! The 1966 missile's limit cycle as [`crate::orbit`] sees it: watched from 20 to 80 s after psi_0 = -1/2 degree (Section IV.B).

use ibm_1966::{Case, Gains, Start, Yaw, YawPlant};
use planesman_hydraulics::{Command, Volume};
use planesman_units::DEGREE;

use crate::orbit::{Actuation, Body, Decision, Lags, SCALE, State};
use crate::watched::Watched;

/// From and to, s.
const WATCHED: (f64, f64) = (20.0, 80.0);

/// Missile and autopilot, continuous between the samples.
#[derive(Clone, Copy, Debug)]
pub struct Steered {
    plant: YawPlant,
    gains: Gains,
    /// T, s.
    cycle: f64,
    yaw: Yaw,
    /// Of the integral compensation, rad.
    share: f64,
}

impl Steered {
    /// The share's change in a second, rad.
    fn drive(&self) -> f64 {
        let g = &self.gains;
        -g.overall * g.attitude * g.yaw * g.compensation / self.cycle * self.yaw.angle
    }
}

impl Body for Steered {
    fn advance(&mut self, angles: [f64; 3], h: f64) {
        self.share += self.drive() * h;
        self.yaw = self.plant.step(self.yaw, angles, h);
    }

    fn asked(&self) -> f64 {
        let g = &self.gains;
        let attitude = g.attitude * g.yaw * self.yaw.angle + g.rate * self.yaw.rate;
        self.share - g.overall * attitude
    }

    fn output(&self) -> f64 {
        self.yaw.angle
    }

    fn coordinates(&self) -> Vec<f64> {
        let yaw = &self.yaw;
        [yaw.angle, yaw.rate, yaw.sideslip, self.share]
            .map(|x| x / SCALE)
            .to_vec()
    }

    fn displace(&mut self, by: &[f64]) {
        self.yaw.angle += by[0] * SCALE;
        self.yaw.rate += by[1] * SCALE;
        self.yaw.sideslip += by[2] * SCALE;
        self.share += by[3] * SCALE;
    }
}

/// The loop's actuator and logic.
#[must_use]
pub fn actuation(case: &Case) -> Actuation {
    Actuation {
        set: case.surrogate.fitted(case.set.clone()),
        logic: case.options,
        position_loop: false,
        // The autopilot samples as the valves do.
        lags: Lags {
            asked: 0.5,
            measured: 0.5,
        },
    }
}

/// The limit cycle, watched.
#[must_use]
pub fn watched(case: &Case) -> Watched<Steered> {
    /// [`DigitalLoop`](ibm_1966::DigitalLoop)'s samples in a cycle.
    const SAMPLES: f64 = 12.0;
    let mut flight = case.fly(Start {
        yaw: -0.5 * DEGREE,
        ram: 0.0,
    });
    let mut watched = Watched::new(case.set.cycle() / SAMPLES, WATCHED.0);
    let mut body = Steered {
        plant: case.plant,
        gains: case.gains,
        cycle: case.set.cycle(),
        yaw: flight.yaw(),
        share: 0.0,
    };
    let mut sign = 1;
    let mut recent = Vec::new();
    while flight.time() < WATCHED.1 {
        body.yaw = flight.yaw();
        body.share += body.drive() * body.cycle;
        let time = flight.time();
        let watches = time >= WATCHED.0;
        recent.insert(
            0,
            State {
                body,
                hydraulics: *flight.hydraulics(),
                sign,
                time,
            },
        );
        recent.truncate(8);
        let quanta = flight.cycle(0.0, |now| {
            if watches {
                watched.outputs.push(now.yaw.angle);
                watched.angles.push(now.nozzle);
            }
        });
        if quanta == 0 {
            continue;
        }
        sign = quanta;
        if watches {
            watched.decisions.push(Decision {
                time,
                command: Command {
                    volume: Volume::Large,
                    sign,
                },
                booked: body.asked() - flight.error(),
            });
            watched.before.push(recent[recent.len().min(7) - 1]);
        }
    }
    watched
}
