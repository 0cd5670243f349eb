//! The energy ledger.

mod common;

use common::{Bench, Dice, actuator};
use planesman_hydraulics::Condition;

#[test]
fn closes() {
    for name in ["auv", "auv_two_speed", "table_3_1", "table_4_1"] {
        let mut dice = Dice::new(3);
        let commands: Vec<i8> = (0..60).map(|_| dice.one_of(&[1, 1, 0, -1])).collect();
        let mut bench = Bench::worn(actuator(name, true, true), Condition::SOUND, 1, &commands);
        for i in 1..=10 {
            let e = bench.energy(f64::from(i) * 0.1);
            println!("{name} {i} {:e} {e:?}", e.closure().unwrap());
        }
    }
}
