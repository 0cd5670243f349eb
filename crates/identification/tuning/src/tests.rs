//! The whole way from a model file to gains, beside peers: scipy's Monte Carlo and brute force.

use planesman_model_file::{Judgement, ModelFile, Parameter, Process};

use crate::{Kind, Limits, Method, PlantResponse, TuneError, TuneOptions, tune};

const TICK: f64 = 0.1;

/// A process model of this form; deviations and covariance of its parameters.
fn process(
    form: &str,
    named: &[(&str, f64, f64)],
    correlation: &[(usize, usize, f64)],
) -> ModelFile {
    let parameter = |(name, value, deviation): &(&str, f64, f64)| Parameter {
        name: (*name).to_owned(),
        unit: String::new(),
        value: *value,
        deviation: *deviation,
    };
    let count = named.len();
    let mut covariance = vec![vec![0.0; count]; count];
    for i in 0..count {
        covariance[i][i] = named[i].2.powi(2);
    }
    for (i, j, r) in correlation {
        covariance[*i][*j] = r * named[*i].2 * named[*j].2;
        covariance[*j][*i] = covariance[*i][*j];
    }
    ModelFile {
        method: "process".to_owned(),
        process: Some(Process {
            form: form.to_owned(),
            equation: "of the test".to_owned(),
            parameters: named.iter().map(parameter).collect(),
            covariance,
        }),
        ..ModelFile::exact("u", "y", TICK, vec![0.1], vec![1.0, -0.9])
    }
}

/// 2 e^(-s) / (4 s + 1), the deviations as large as so many times 0.1, 0.3 s and 0.08 s.
fn lag(times: f64) -> ModelFile {
    process(
        "1",
        &[
            ("K", 2.0, 0.1 * times),
            ("T1", 4.0, 0.3 * times),
            ("theta", 1.0, 0.08 * times),
        ],
        &[(0, 1, 0.5), (1, 2, -0.3)],
    )
}

fn near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() < within,
        "{found} instead of {expected}"
    );
}

/// scipy and numpy: 4000 draws of the same distribution (seed 7), margins by brentq on the exact zero-order hold; kp 1, ki 0.25.
/// The model: 59.896 deg, 9.4175 dB, Ms 1.6423. 5, 50 and 95 %: 55.24, 59.98, 64.40 deg; 7.908, 9.472, 11.099 dB; Ms 1.496, 1.638,
/// 1.831. Shares of the variance by correlation: K 0.266, T1 0.001, theta 0.718.
#[test]
fn margins_over_the_uncertainty_are_those_of_scipys_monte_carlo() {
    // SIMC of this model with tau_c 0.95: kp = 4 / (2 (0.95 + 1.05)) = 1, Ti = 4.
    let options = TuneOptions {
        closed_loop_time: Some(0.95),
        draws: 4000,
        ..TuneOptions::default()
    };
    let found = tune(&lag(1.0), &options).unwrap();
    assert_eq!(found.method, Method::Simc);
    near(found.controller.kp, 1.0, 1e-9);
    near(found.controller.ki, 0.25, 1e-9);
    assert!(!found.keeps_limits());
    let [phase, gain, peak] = [
        found.robustness.phase(),
        found.robustness.gain(),
        found.robustness.sensitivity(),
    ];
    near(phase.model, 59.8960, 1e-3);
    near(gain.model, 9.41752, 1e-3);
    near(peak.model, 1.64233, 1e-4);
    for (spread, quantiles, within) in [
        (phase, [55.24, 59.98, 64.40], 0.3),
        (gain, [7.908, 9.472, 11.099], 0.12),
        (peak, [1.496, 1.638, 1.831], 0.015),
    ] {
        for (share, expected) in [0.05, 0.5, 0.95].into_iter().zip(quantiles) {
            near(spread.quantile(share), expected, within);
        }
    }
    let share = |name: &str| {
        found
            .causes
            .iter()
            .find(|it| it.name == name)
            .unwrap()
            .share
    };
    near(share("K"), 0.266, 0.04);
    near(share("T1"), 0.001, 0.02);
    near(share("theta"), 0.718, 0.04);
    assert_eq!(found.causes[0].name, "theta");
    near(found.causes[0].margin_deviation.to_degrees(), 2.80, 0.1);
}

#[test]
fn the_default_keeps_its_limits_in_95_percent_of_the_plants_and_is_slower_the_less_is_known() {
    let pace = |times: f64| {
        let found = tune(
            &lag(times),
            &TuneOptions {
                draws: 300,
                ..TuneOptions::default()
            },
        )
        .unwrap();
        assert!(found.keeps_limits());
        let worst = found.robustness.sensitivity().quantile(0.95);
        assert!(
            worst <= 1.6 && worst > 1.57,
            "as fast as they allow: {worst}"
        );
        found.pace.unwrap().1
    };
    let (little, much) = (pace(1.0), pace(2.0));
    assert!(little > 1.05 && much > 1.2 * little, "{little} {much}");
}

#[test]
fn every_method_keeps_the_limits_on_a_lag() {
    for method in Method::ALL {
        for controller in Kind::ALL {
            let options = TuneOptions {
                method: Some(method),
                controller: Some(controller),
                draws: 60,
                ..TuneOptions::default()
            };
            let model = match controller {
                Kind::Pi => lag(1.0),
                Kind::Pid => process(
                    "2",
                    &[
                        ("K", -2.0, 0.1),
                        ("T1", 4.0, 0.3),
                        ("T2", 2.0, 0.2),
                        ("theta", 0.5, 0.05),
                    ],
                    &[],
                ),
            };
            let found = tune(&model, &options).unwrap();
            assert!(found.keeps_limits(), "{method:?} {controller:?}");
            assert_eq!(found.controller.kd != 0.0, controller == Kind::Pid);
            assert_eq!(found.robustness.unstable(), 0.0);
            assert!(
                found.steps.settling.model.is_finite(),
                "{method:?} {controller:?}"
            );
        }
    }
}

#[test]
fn integrators_and_unstable_lags_are_tuned() {
    let level = process("i", &[("K", 0.05, 0.002), ("theta", 2.0, 0.1)], &[]);
    let found = tune(
        &level,
        &TuneOptions {
            draws: 100,
            ..TuneOptions::default()
        },
    )
    .unwrap();
    assert_eq!(found.method, Method::Simc);
    assert!(found.keeps_limits());
    // 1 / (s - 0.2), held for 0.05 s: z = exp(0.01), b = (exp(0.01) - 1) / 0.2.
    let pole = libm::exp(0.01_f64);
    let mut unstable = ModelFile::exact("u", "y", 0.05, vec![(pole - 1.0) / 0.2], vec![1.0, -pole]);
    let found = tune(&unstable, &TuneOptions::default()).unwrap();
    assert_eq!(found.method, Method::Optimise);
    assert!(found.keeps_limits() && found.robustness.draws.is_empty());
    assert!(found.why.unwrap().contains("unstable pole"));
    // With 3 s of dead time no controller has a sensitivity peak below exp(0.2 3.025) = 1.83.
    unstable = ModelFile::exact(
        "u",
        "y",
        0.05,
        [vec![0.0; 60], unstable.num].concat(),
        [unstable.den, vec![0.0; 60]].concat(),
    );
    let refusal = tune(&unstable, &TuneOptions::default()).unwrap_err();
    assert!(
        matches!(refusal, TuneError::TooLate { least, .. } if (least - libm::exp(0.2_f64 * 3.025)).abs() < 1e-6),
        "{refusal}"
    );
    assert!(refusal.to_string().contains("ms 2"));
}

#[test]
fn what_cannot_be_tuned_is_refused_with_what_to_do() {
    let tuned = |file: &ModelFile, anyway: bool| {
        let options = TuneOptions {
            draws: 60,
            anyway,
            ..TuneOptions::default()
        };
        tune(file, &options)
    };
    let refused = |file: &ModelFile| tuned(file, false).unwrap_err().to_string();
    let mut doubted = lag(1.0);
    doubted.verdict = vec!["verdict: not usable for simulation. Next: look".to_owned()];
    let refusal = refused(&doubted);
    assert!(
        refusal.contains("not usable for simulation") && refusal.contains("anyway"),
        "{refusal}"
    );
    // By what the file says as data, whatever its sentences.
    let mut judged = lag(1.0);
    judged.verdict = vec!["verdict: good. Next: fly".to_owned()];
    for (standing, code, said) in [
        ("not_usable", "closed_loop", "the data seems closed-loop"),
        ("not_usable", "of_tomorrow", "does not know"),
    ] {
        judged.judgement = Some(Judgement {
            standing: standing.to_owned(),
            code: code.to_owned(),
            findings: Vec::new(),
        });
        let refusal = refused(&judged);
        assert!(refusal.contains(said), "{refusal}");
    }
    let anyway = tuned(&doubted, true).unwrap();
    assert!(anyway.notes.iter().any(|it| it.contains("not usable")));
    let without = ModelFile {
        method: "output_error".to_owned(),
        ..ModelFile::exact("u", "y", 0.1, vec![0.1], vec![1.0, -0.9])
    };
    assert!(refused(&without).contains("no covariance"));
    assert!(tuned(&without, true).unwrap().keeps_limits());
    let vague = process(
        "1",
        &[("K", 2.0, 1.5), ("T1", 4.0, 0.3), ("theta", 1.0, 0.1)],
        &[],
    );
    let refusal = refused(&vague);
    assert!(
        refusal.contains("sign is uncertain") && refusal.contains("2.0 ± 2.9"),
        "{refusal}"
    );
    let direct = ModelFile::exact("u", "y", 0.1, vec![0.1, 0.0], vec![1.0, -0.9]);
    assert!(refused(&direct).contains("computing_delay 0.1"));
    let within = TuneOptions {
        computing_delay: 0.04,
        anyway: true,
        ..TuneOptions::default()
    };
    let refusal = tune(&direct, &within).unwrap_err();
    assert!(matches!(refusal, TuneError::Feedthrough(_)), "{refusal}");
    // 1 / (s - 0.2) behind 2 s: the bound exp(0.2 2.025) = 1.5 is below 1.6, and no PI controller comes near it.
    let pole = libm::exp(0.01_f64);
    let num = [vec![0.0; 40], vec![(pole - 1.0) / 0.2]].concat();
    let den = [vec![1.0, -pole], vec![0.0; 40]].concat();
    let late = ModelFile::exact("u", "y", 0.05, num, den);
    let refusal = refused(&late);
    assert!(
        refusal.contains("95 % of the plants")
            && refusal.contains("ms 3.2 phase_margin 23 gain_margin 3.0"),
        "{refusal}"
    );
}

/// scipy: IAE after a unit step of the load, simulated by the difference equation, over 60 values of Ti with the gain at which
/// Ms is 1.6 (brentq on 4000 frequencies): 3.3333 with kp 0.8313, Ti 2.748 s.
#[test]
fn the_optimum_is_that_of_brute_force_in_scipy() {
    let exact = process(
        "1",
        &[("K", 2.0, 0.0), ("T1", 4.0, 0.0), ("theta", 1.0, 0.0)],
        &[],
    );
    let options = TuneOptions {
        method: Some(Method::Optimise),
        controller: Some(Kind::Pi),
        phase_margin: 10.0,
        gain_margin: 2.0,
        anyway: true,
        ..TuneOptions::default()
    };
    let found = tune(&exact, &options).unwrap();
    let peer = [3.3333, 0.8313, 2.748];
    near(found.steps.load_error.model, peer[0], 0.02 * peer[0]);
    near(found.controller.kp, peer[1], 0.05 * peer[1]);
    near(found.controller.ti(), peer[2], 0.08 * peer[2]);
    near(found.robustness.model.sensitivity, 1.6, 0.01);
}

#[test]
fn another_period_and_a_computing_delay_are_those_of_the_held_model() {
    // The sampled model of 2 e^(-s) / (4 s + 1) at 0.1 s, controlled every 0.25 s: the same as the process model there.
    let plant = crate::Plant::held(
        &planesman_linear::TransferFunction::new(vec![2.0], vec![4.0, 1.0]).unwrap(),
        1.0,
        TICK,
    )
    .unwrap();
    let num = [vec![0.0; plant.delay - 1], plant.b.clone()].concat();
    let den = [vec![1.0], plant.a.clone(), vec![0.0; plant.delay - 1]].concat();
    let sampled = ModelFile::exact("u", "y", TICK, num, den);
    let options = TuneOptions {
        method: Some(Method::Simc),
        period: Some(0.25),
        computing_delay: 0.07,
        anyway: true,
        ..TuneOptions::default()
    };
    let exact = process(
        "1",
        &[("K", 2.0, 0.0), ("T1", 4.0, 0.0), ("theta", 1.0, 0.0)],
        &[],
    );
    let [one, other] = [sampled, exact].map(|it| tune(&it, &options).unwrap());
    near(one.controller.kp, other.controller.kp, 1e-6);
    near(
        one.robustness.model.phase,
        other.robustness.model.phase,
        1e-6,
    );
    let limits: Limits = options.limits();
    assert!(limits.are_kept(&PlantResponse::new(one.seen.plant.clone()).margins(&one.controller)));
}

/// A model of straight lines between samples has the factor (1 + 1/z)/2, which a held input does not see: 0.2 / (z - 0.9) is the plant.
#[test]
fn a_model_of_lines_is_tuned_for_a_held_input() {
    let of = |num: Vec<f64>, den: Vec<f64>| {
        let mut file = ModelFile::exact("u", "y", TICK, num, den);
        "output_error".clone_into(&mut file.method);
        file.covariance[0][0] = 1e-6;
        file
    };
    let lines = of(vec![0.1, 0.1], vec![1.0, -0.9, 0.0]);
    let held = of(vec![0.2, 0.0], vec![1.0, -0.9, 0.0]);
    let options = TuneOptions {
        draws: 60,
        ..TuneOptions::default()
    };
    let [lines, held] = [lines, held].map(|it| tune(&it, &options).unwrap());
    assert_eq!(lines.seen.plant, held.seen.plant);
    near(lines.controller.kp, held.controller.kp, 1e-9);
}

/// As `sysid fit` writes them: difference equations, whose second coefficient is a little off, so that a fast zero is left in s.
#[test]
fn poles_of_oscillating_and_unstable_models_are_placed() {
    use planesman_linear::TransferFunction;
    for den in [vec![1.0, 0.2, 1.0], vec![1.0, 0.5, -0.3], vec![5.0, -1.0]] {
        let transfer = TransferFunction::new(vec![1.0], den.clone()).unwrap();
        let mut plant = crate::Plant::held(&transfer, 0.0, 0.05).unwrap();
        if let [_, second] = &mut plant.b[..] {
            *second *= 0.97;
        }
        let num = [vec![0.0; plant.delay], plant.b].concat();
        let file = ModelFile::exact("u", "y", 0.05, num, [vec![1.0], plant.a].concat());
        let options = TuneOptions {
            method: Some(Method::Placement),
            ..TuneOptions::default()
        };
        let found = tune(&file, &options).unwrap();
        assert!(
            found.keeps_limits() && found.steps.settling.model.is_finite(),
            "{den:?}"
        );
        assert_eq!(found.controller.kd != 0.0, den.len() == 3, "{den:?}");
        assert!(found.reduced.is_none(), "{den:?}: of the model itself");
    }
}

/// e^(-0.05 s)/((4 s + 1)(0.8 s + 1)) at 20 Hz as it was identified: with a sample of delay too many, which a zero of 51 ms makes up for.
#[test]
fn a_zero_that_makes_up_for_delay_is_taken_from_the_dead_time() {
    let num = vec![0.0, 0.0, 0.001_149_107_27, -3.979_735_74e-4];
    let den = vec![1.0, -1.927_094_78, 0.927_846_017, 0.0, 0.0];
    let found = tune(
        &ModelFile::exact("u", "y", 0.05, num, den),
        &TuneOptions::default(),
    );
    let reduced = found.unwrap().reduced.unwrap();
    // Half a sample of the hold beside the plant's own dead time.
    near(reduced.delay, 0.075, 2e-3);
    near(reduced.first(), 4.0, 0.02);
    near(reduced.second(), 0.8, 0.01);
}
