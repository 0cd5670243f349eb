//! Values derived from Tables 3-1 and 4-1 of IBM 66-L03-005, by algebra and by simulation: the
//! numbers the report prints, and those it implies.

use crate::common::{Bench, CUBIC_INCH, actuator};
use planesman_hydraulics::ActuatorSet;
use planesman_testing::near;
use planesman_units::{DEGREE, INCH, POUND_FORCE as POUND, PSI};

fn hardware() -> ActuatorSet {
    actuator("table_3_1", true, true)
}

fn polaris() -> ActuatorSet {
    actuator("table_4_1", true, true)
}

fn auv() -> ActuatorSet {
    actuator("auv", true, true)
}

#[track_caller]
#[test]
fn the_quantum_is_the_printed_1_09_degrees_on_polaris_and_less_on_the_hardware() {
    near(hardware().ram_quantum() / INCH, 0.152_917_505_030, 1e-9);
    near(hardware().plane_quantum() / DEGREE, 1.078_341_864_8, 1e-6);
    near(polaris().ram_quantum() / INCH, 0.152, 1e-12);
    near(polaris().plane_quantum() / DEGREE, 1.09, 2e-3);
    near(auv().plane_quantum() / DEGREE, 0.5, 1e-9);
}

#[test]
fn the_quantizer_threshold_is_half_of_a_quantum_and_its_hysteresis() {
    for set in [hardware(), polaris()] {
        let hysteresis = set.quantum / 4.0;
        near(
            set.threshold / DEGREE,
            (set.quantum + hysteresis) / 2.0 / DEGREE,
            3e-4,
        );
        near(set.threshold / DEGREE, 0.681, 1e-12);
    }
    let set = auv();
    near(
        set.threshold,
        (set.quantum + set.quantum / 4.0) / 2.0,
        1e-15,
    );
}

#[test]
fn the_load_on_its_oil_column_rings_near_50_hz() {
    near(hardware().natural_frequency(), 324.232_987_834, 1e-6);
    near(polaris().natural_frequency(), 299.774_690_167, 1e-6);
    near(auv().natural_frequency(), 500.0, 1e-6);
    near(hardware().damping_ratio(), 0.0740, 5e-5);
    near(polaris().damping_ratio(), 0.0676, 5e-5);
    near(auv().damping_ratio(), 1.0, 1e-9);
    near(hardware().leakage_damping(), 0.004_121_246_70, 1e-8);
    near(polaris().leakage_damping(), 0.004_457_494_83, 1e-8);
    near(
        hardware().column_stiffness() / (POUND / INCH),
        26_281.757_6,
        1e-6,
    );
}

#[test]
fn polaris_slews_a_little_faster_than_its_clamped_force_can_follow() {
    near(polaris().slew_rate() / INCH, 12.54, 1e-9);
    let (plus, minus) = polaris().force_limits();
    near(plus / INCH, 12.5, 1e-9);
    near(minus / INCH, -12.5, 1e-9);
    near(
        auv().slew_rate() / auv().load.moment_arm / DEGREE,
        40.0,
        1e-9,
    );
}

#[test]
fn the_hardwares_force_limits_explain_why_c_18_hurts_the_negative_step_only() {
    near(
        hardware().slew_rate() / hardware().load.moment_arm / DEGREE,
        88.963_203_85,
        1e-6,
    );
    for (viscous, plus, minus) in [
        (6.0, 26.126_666_666, -95.706_666_666),
        (12.0, 13.063_333_333, -47.853_333_333),
        (18.0, 8.708_888_888, -31.902_222_222),
    ] {
        let mut set = hardware();
        set.load.viscous = viscous * POUND / INCH;
        near(set.force_limits().0 / INCH, plus, 1e-6);
        near(set.force_limits().1 / INCH, minus, 1e-6);
    }
}

#[test]
fn the_area_ratio_of_polaris_puts_the_resting_pressure_midway() {
    near(hardware().resting_pressure() / PSI, 1_339.622_641_5, 1e-6);
    near(polaris().resting_pressure() / PSI, 1_129.973_474_8, 1e-6);
    let middle = |set: &ActuatorSet| 0.5 * (set.oil.supply + set.oil.return_pressure) / PSI;
    near(middle(&polaris()), 1130.0, 1e-9);
    // The auxiliary pistons hold 1130 +- 750 psi: that gives the printed +540/-960.
    let above = hardware().resting_pressure() / PSI - middle(&hardware());
    near(hardware().oil.clamp_positive / PSI, 750.0 - above, 0.5);
    near(hardware().oil.clamp_negative / PSI, 750.0 + above, 0.5);
    near(auv().resting_pressure() / PSI, middle(&auv()), 1e-9);
}

#[test]
fn the_leakages_in_degrees_a_second_at_the_nozzle() {
    near(hardware().drift_rate() / DEGREE, 0.759_095_918, 1e-6);
    near(polaris().drift_rate() / DEGREE, 0.766_331_051, 1e-6);
    let constant = polaris().error_rate / (polaris().area * polaris().load.moment_arm);
    near(constant / DEGREE, -0.043, 5e-4);
    let k = polaris().pressure_leakage() * PSI / CUBIC_INCH;
    near(k, 1.004_694_835_680_751e-4, 1e-12);
    let decay = hardware().pressure_leakage() * hardware().oil.stiffness;
    near(decay, 2.672_488_262_9, 1e-9);
}

#[test]
fn the_ram_rests_within_the_stiction_band() {
    near(hardware().stiction_band() / INCH, 0.014_458_698_15, 1e-9);
    near(polaris().stiction_band() / INCH, 0.022_556_390_98, 1e-9);
    near(
        auv().stiction_band() / auv().load.moment_arm / DEGREE,
        0.115,
        5e-4,
    );
}

#[test]
fn drift_against_friction_creeps_steadily_after_it_breaks_away() {
    for (name, sign, creep, breaks_away) in [
        ("table_3_1", 1, 0.052_341_707_5, 0.206_682),
        ("table_3_1", -1, -0.085_500_441_3, 0.139_390),
        ("table_4_1", 1, 0.040_669_277_6, 0.339_924),
        ("table_4_1", -1, -0.052_654_827_4, 0.285_287),
        ("auv", 1, 0.002_468_528_6, 0.374_392),
        ("auv", -1, -0.002_817_026_8, 0.331_053),
    ] {
        let set = actuator(name, true, true);
        near(set.creep(f64::from(sign)) / INCH, creep, 1e-6);
        let mut bench = Bench::settled(set, sign, &[]);
        assert_eq!(bench.at(breaks_away - 1e-6).velocity, 0.0, "{name} {sign}");
        assert!(
            bench.at(breaks_away + 1e-4).velocity != 0.0,
            "{name} {sign}"
        );
        near(bench.at(4.0).velocity, creep, 1e-6);
    }
}
