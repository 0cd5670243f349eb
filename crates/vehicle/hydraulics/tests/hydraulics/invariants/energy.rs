//! The energy ledger: beside scipy, beside closed forms, and closed in every valve cycle of random runs.

use crate::common::{
    Bench, CUBIC_INCH, Dice, SETS, actuator, random_bench, random_commands, random_condition,
};
use planesman_hydraulics::{ActuatorSet, Condition, Demand, Dha, Energy};
use planesman_units::{DEGREE, PSI};

const TO_AND_FRO: [i8; 16] = [1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1];

/// A run that scipy made too: what to call it, its actuator, commands and length, and scipy's energies.
type Peer = (
    &'static str,
    ActuatorSet,
    Condition,
    Vec<i8>,
    f64,
    [f64; 12],
);

/// The hybrid equations of Section II.B with the powers as further states, by scipy 1.17.1: solve_ivp, DOP853, rtol 1e-12, a terminal event at
/// each change of law, restarted at every flow edge. In J: supply, viscous, friction, throttling, leakage, compressed,
/// recovered, stored, returned, ideal proportional valve, stops, kinetic.
fn peers() -> Vec<Peer> {
    let worn = Condition {
        lost_supply: 0.1,
        air: 0.6,
        leakage_scale: 2.0,
        ..Condition::SOUND
    };
    let polaris = actuator("table_4_1", true, true);
    let stopped = ActuatorSet {
        stop: 3.1 * polaris.ram_quantum(),
        ..polaris.clone()
    };
    #[rustfmt::skip]
    let peers = vec![
        ("Polaris", polaris, Condition::SOUND, TO_AND_FRO.to_vec(), 0.3, [
            140.478993454, 16.2688081038, 84.7696052453, 36.3218956152, 2.95517475688, 9.5821815869, 9.41867185455,
            89.6085520186, 89.6085520186, 234.352608171, 0.0, 0.0,
        ]),
        ("worn hardware", actuator("table_3_1", true, true), worn, TO_AND_FRO.to_vec(), 0.3, [
            118.662397542, 17.2514882714, 52.5110552954, 47.3669445299, 4.15621417358, 18.100639074, 20.7239438024,
            88.4558041491, 88.4558041491, 213.516226337, 0.0, 0.0,
        ]),
        ("AUV", actuator("auv", true, true), Condition::SOUND, [1, 1, 0, -1, -1, -1, 0, 1].repeat(2), 0.25, [
            0.0214154180143, 0.0037684075626, 0.00247708003384, 0.0144812964608, 0.000203424678017, 0.014008450464,
            0.0135232418734, 0.0, 0.0, 0.0263938908078, 0.0, 6.8848820047e-10,
        ]),
        ("stopped", stopped, Condition::SOUND, [[1; 6].as_slice(), &[0; 6], &[-1; 4]].concat(), 0.25, [
            173.616188188, 7.29279834002, 43.6986588824, 118.474198148, 2.06435742843, 7.53352816303, 7.62498910053,
            112.827063658, 112.827063658, 129.318411223, 2.17763632736, 0.0,
        ]),
        ("no friction", actuator("table_4_1", true, false), Condition::SOUND, TO_AND_FRO.to_vec(), 0.3, [
            141.678014388, 37.3928840955, 0.0, 99.2062746228, 4.35199803531, 78.3738536621, 77.7244167591,
            31.4495564576, 31.4495564578, 410.776017543, 0.0, 0.0774207311174,
        ]),
    ];
    peers
}

#[test]
fn each_term_is_that_of_scipys_integration() {
    for (name, set, condition, commands, end, theirs) in peers() {
        let e = Bench::worn(set, condition, 1, &commands).energy(end);
        let ours = [
            e.supply,
            e.viscous,
            e.friction,
            e.throttling,
            e.leakage,
            e.compressed,
            e.recovered,
            e.stored,
            e.returned,
            e.proportional_valve,
            e.stops,
            e.kinetic,
        ];
        for (place, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
            let allowed = 1e-8 * theirs.abs() + 1e-10 * e.supply;
            assert!(
                (ours - theirs).abs() < allowed,
                "{name}, {place}: {ours} for {theirs}"
            );
        }
    }
}

#[test]
fn a_volume_takes_what_its_pressures_say() {
    // Table 4-1 without leakage and friction, in psi: P_h - P_L0 for a volume in, P_L0 - P_R for one out.
    let resting = 2130.0 / 1.885;
    for (sign, supply) in [(1, 2130.0 - resting), (-1, resting - 130.0)] {
        let set = actuator("table_4_1", false, false);
        let volume = 0.152 * CUBIC_INCH;
        let e = Bench::settled(set, sign, &[sign]).energy(10.0);
        let joule = volume * PSI;
        assert!((e.supply / joule - supply).abs() < 1e-6);
        assert!((e.load() + e.throttling - e.supply).abs() < 1e-9 * e.supply);
        assert_eq!((e.friction, e.leakage, e.stops), (0.0, 0.0, 0.0));
        assert!(e.compression().abs() < 1e-9 * e.supply && e.kinetic < 1e-9 * e.supply);
        assert_eq!(e.switching, 0.55, "one valve has switched");
    }
}

#[test]
fn the_ledger_closes_in_every_valve_cycle_and_in_all() {
    for seed in 0..160 {
        let (mut bench, _, _) = random_bench(seed);
        let (set, cycle) = (bench.set.clone(), bench.set.cycle());
        let volume_work = set.oil.supply * set.volume;
        let mut before = Energy::default();
        for n in 1..=60 {
            let now = bench.energy(f64::from(n) * cycle);
            let within = now - before;
            assert!(
                within.residual().abs() < 1e-11 * volume_work,
                "{seed}, cycle {n}: {:e} in {within:?}",
                within.residual() / volume_work
            );
            let grown = [
                within.viscous,
                within.friction,
                within.stops,
                within.compressed,
                within.recovered,
                within.stored,
                within.returned,
            ];
            assert!(
                grown.iter().all(|it| *it >= -1e-14 * volume_work),
                "{seed}, cycle {n}: {within:?}"
            );
            before = now;
        }
        let turned_over = before.supply.abs().max(before.throttling + before.friction);
        assert!(before.residual().abs() <= 1e-12 * turned_over, "{seed}");
    }
}

#[test]
fn it_closes_while_faults_come_and_go_and_the_motion_is_that_without_it() {
    for name in ["auv", "auv_two_speed", "table_3_1", "table_4_1"] {
        let mut dice = Dice::new(11);
        let set = actuator(name, true, true);
        let (mut with, mut without) = (Dha::new(&set).keeping_energy(), Dha::new(&set));
        for tick in 1..=80 {
            let demand = Demand {
                condition: random_condition(&mut dice),
                position_loop: dice.unit() < 0.7,
                ..Demand::angle((60.0 * dice.unit() - 30.0) * DEGREE)
            };
            with.advance_to(tick * 50_000_000, demand);
            without.advance_to(tick * 50_000_000, demand);
            let reading = with.reading(tick * 50_000_000);
            assert_eq!(reading, without.reading(tick * 50_000_000), "{name}");
            let energy = with.energy().expect("kept");
            assert!(
                energy.residual().abs()
                    < 1e-11 * energy.throttling.max(set.oil.supply * set.volume),
                "{name}, {tick}: {energy:?}"
            );
        }
        assert_eq!(without.energy(), None);
        assert!(with.energy().and_then(|it| it.closure()) < Some(1e-9));
    }
}

/// Constants a hundred times more or less: from a ram that swings hundreds of times in a cycle to one that creeps for minutes.
#[test]
fn it_closes_with_constants_of_any_size() {
    for seed in 0..150 {
        let mut dice = Dice::new(seed);
        let mut set = actuator(SETS[(seed % 3) as usize], true, dice.unit() < 0.8);
        for constant in [
            &mut set.load.mass,
            &mut set.load.viscous,
            &mut set.oil.stiffness,
            &mut set.rate_gain,
            &mut set.error_rate,
        ] {
            *constant *= libm::pow(100.0, 2.0 * dice.unit() - 1.0);
        }
        let commands = random_commands(&mut dice, 40);
        let cycle = set.cycle();
        let volume_work = set.oil.supply * set.volume;
        let mut bench = Bench::worn(set, random_condition(&mut dice), 1, &commands);
        for n in [1, 7, 20, 39, 60] {
            let energy = bench.energy(f64::from(n) * cycle);
            let scale = energy.throttling.max(volume_work) + energy.leakage.abs();
            let closure = energy.residual().abs() / scale;
            assert!(closure < 1e-9, "{seed}, cycle {n}: {closure:e} {energy:?}");
        }
    }
}
