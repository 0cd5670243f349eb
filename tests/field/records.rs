//! What a record has in it: integrators, and inputs with a mean.

use std::fs;

use planesman_testing::near;

use crate::answer::{Answer, fit, planesman};
use crate::plant::{GAIN, POLE, STEP, noise, prbs, second_order, table};

/// The rows of a log of `1/(2s + 1)` behind a delay of so many samples, from rest; the first input is 1, before it was 0.
fn delayed(delay: usize, seed: u64, samples: usize) -> Vec<(String, f64, f64)> {
    let mut u = prbs(seed, samples);
    u[..10].fill(1.0);
    let decay = libm::exp(-STEP / 2.0_f64);
    let mut x = 0.0;
    let row = |(k, e): (usize, f64)| {
        let y = x + 0.005 * e;
        let before = k.checked_sub(delay).map_or(0.0, |k| u[k]);
        x = decay * x + (1.0 - decay) * before;
        (format!("{:.2}", k as f64 * STEP), u[k], y)
    };
    noise(seed + 50, samples)
        .into_iter()
        .enumerate()
        .map(row)
        .collect()
}

/// Checks that the model is the one of [`delayed`], and nothing beside it.
#[track_caller]
fn is_first_order_behind(delay: usize, answer: &Answer) {
    answer.says("verdict: good");
    let poles = answer.json.pointer("/model/continuous_poles").unwrap();
    let denominator = answer.json.pointer("/model/den").unwrap();
    assert_eq!(
        poles.as_array().map(Vec::len),
        Some(1),
        "{}",
        answer.brief()
    );
    assert_eq!(
        denominator.as_array().map(Vec::len),
        Some(delay + 1),
        "{}",
        answer.brief()
    );
    near(answer.number("model/continuous_poles/0/re"), -0.5, 0.002);
    near(answer.number("model/steady_state_gain/0"), 1.0, 0.005);
}

#[test]
fn the_input_before_a_window_a_gap_or_the_file_acts_behind_the_delay() {
    let folder = tempfile::tempdir().unwrap();
    let written = |rows: Vec<(String, f64, f64)>| {
        fs::write(
            folder.path().join("log.csv"),
            table("t,u,y", rows.into_iter()),
        )
        .unwrap();
    };
    let arguments = ["log.csv", "-i", "u", "-o", "y"];
    written(delayed(10, 3, 3000));
    is_first_order_behind(11, &fit(folder.path(), &arguments));
    // The input switches at 7.00 s, or is what it was for long.
    for window in ["7..90", "33..120"] {
        let within = [&arguments[..], &["--window", window]].concat();
        is_first_order_behind(11, &fit(folder.path(), &within));
    }
    // The output is missing for a while, the input is not.
    let mut text = String::from("t,u,y\n");
    for (k, (t, u, y)) in delayed(10, 4, 3000).into_iter().enumerate() {
        let is_missing = (700..760).contains(&k) || (1800..1880).contains(&k);
        let y = if is_missing {
            String::new()
        } else {
            y.to_string()
        };
        text += &format!("{t},{u},{y}\n");
    }
    fs::write(folder.path().join("log.csv"), text).unwrap();
    is_first_order_behind(11, &fit(folder.path(), &arguments));
}

#[test]
fn an_integrator_behind_an_input_with_a_mean_is_good_and_its_gain_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (mean, seed) in [(0.0, 1), (2.0, 2), (-5.0, 3)] {
        // 0.5/(s (s + 1)).
        let u: Vec<f64> = prbs(seed, 4000).iter().map(|u| u + mean).collect();
        let y = second_order([0.5, 1.0, 0.0], STEP, &u);
        let y: Vec<f64> = y
            .iter()
            .zip(noise(9, 4000))
            .map(|(y, e)| y + 0.02 * e)
            .collect();
        let rows = (0..4000).map(|k| (format!("{:.2}", k as f64 * STEP), u[k], y[k]));
        fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
        let answer = fit(folder.path(), &["log.csv", "-i", "u", "-o", "y"]);
        answer.says("verdict: good");
        near(answer.number("integrator_gain/0"), 0.5, 0.002);
        near(answer.number("model/continuous_poles/0/re"), -1.0, 0.01);
    }
}

/// A motor's position, as in most position loops: the friction of its gear, or an offset of its amplifier, is a constant at its input.
#[test]
fn a_constant_at_an_integrators_input_leaves_its_gain_and_nobody_is_told_to_detrend() {
    let folder = tempfile::tempdir().unwrap();
    for bias in [0.0, 0.1, 0.3, -0.3] {
        // 8/(s (0.12 s + 1)), moved by 1.5 V to either side; the constant is not recorded.
        let u: Vec<f64> = prbs(4, 1500).iter().map(|u| 1.5 * u).collect();
        let driven: Vec<f64> = u.iter().map(|u| u + bias).collect();
        let y = second_order([8.0 / 0.12, 1.0 / 0.12, 0.0], STEP, &driven);
        let noise = noise(9, 1500);
        let rows = (0..1500).map(|k| {
            let y = y[k] + 0.01 * noise[k];
            (format!("{:.2}", k as f64 * STEP), u[k], y)
        });
        fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
        let answer = fit(folder.path(), &["log.csv", "-i", "u", "-o", "y"]);
        answer.says("verdict: good");
        near(answer.number("integrator_gain/0"), 8.0, 0.05);
        assert!(!answer.text.contains("detrend"), "{bias}: {}", answer.text);
    }
}

#[test]
fn a_delay_of_many_samples_is_found_or_given_and_is_no_order_of_ten() {
    let folder = tempfile::tempdir().unwrap();
    let write = |delay| {
        let rows = delayed(delay, 6, 2500).into_iter();
        fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
    };
    let arguments = ["log.csv", "-i", "u", "-o", "y"];
    // 3 s at 20 Hz.
    write(60);
    let within = [&arguments[..], &["--window", "20..120"]].concat();
    is_first_order_behind(61, &fit(folder.path(), &within));
    let given = [&arguments[..], &["--delay", "61"]].concat();
    is_first_order_behind(61, &fit(folder.path(), &given));
    // Up to nearly a quarter of the record, whose first blocks nothing is known to drive.
    for delay in [300, 600] {
        write(delay);
        let name = format!("{delay}.yaml");
        let model = [&arguments[..], &["--model", &name]].concat();
        is_first_order_behind(delay + 1, &fit(folder.path(), &model));
    }
    // The model file holds the delay, and is read again.
    let compared = planesman(
        folder.path(),
        &["sysid", "compare", "600.yaml", "log.csv", "--format", "csv"],
    );
    let fit_of = |line: &str| line.rsplit(',').nth(1)?.parse::<f64>().ok();
    let mut lines = compared.text.lines();
    let simulated = lines
        .find(|it| it.contains("simulated fit"))
        .and_then(fit_of);
    assert!(simulated.is_some_and(|it| it > 90.0), "{}", compared.text);
    // Longer than a quarter of the record: no model rather than a false one.
    write(1200);
    let answer = fit(folder.path(), &arguments);
    assert!(
        !answer.said().contains("verdict: good"),
        "{}",
        answer.brief()
    );
}

/// A log of `3/(s^2 + 1.2 s + 4)` in which the input is `levels.0` for so many samples, and `levels.1` from then on.
fn step_log(samples: usize, step: usize, levels: (f64, f64)) -> String {
    let moved: Vec<f64> = (0..samples)
        .map(|k| if k < step { 0.0 } else { levels.1 - levels.0 })
        .collect();
    let y = second_order([3.0, 1.2, 4.0], STEP, &moved);
    let rows = y.into_iter().zip(noise(21, samples)).enumerate();
    let rows = rows.map(|(k, (y, e))| {
        let u = if k < step { levels.0 } else { levels.1 };
        (format!("{:.2}", k as f64 * STEP), u, y + 0.003 * e)
    });
    table("t,u,y", rows)
}

#[track_caller]
fn is_the_plant_from_rest(answer: &Answer) {
    answer.says("verdict: good");
    near(answer.number("model/continuous_poles/0/re"), POLE.0, 0.01);
    near(
        answer.number("model/continuous_poles/0/im").abs(),
        POLE.1,
        0.01,
    );
    near(answer.number("model/steady_state_gain/0"), GAIN, 0.005);
}

#[test]
fn a_step_in_the_first_rows_is_a_step_from_rest() {
    let folder = tempfile::tempdir().unwrap();
    let write = |step, levels| {
        fs::write(folder.path().join("log.csv"), step_log(400, step, levels)).unwrap()
    };
    let arguments = ["log.csv", "-i", "u", "-o", "y"];
    let at_rest = [&arguments[..], &["--at-rest"]].concat();
    write(1, (0.0, 2.0));
    is_the_plant_from_rest(
        fit(folder.path(), &arguments).says("is constant until the input steps"),
    );
    is_the_plant_from_rest(&fit(folder.path(), &at_rest));
    // From another level than 0.
    write(2, (1.0, 3.0));
    is_the_plant_from_rest(&fit(folder.path(), &arguments));
    // The input never moves: a step before the first row, or at it.
    write(0, (0.0, 2.0));
    fit(folder.path(), &arguments).refused(&["u is constant (2 in all 400 samples", "--at-rest"]);
    is_the_plant_from_rest(&fit(folder.path(), &at_rest));
    // Nothing but free motion.
    let rows = step_log(400, 0, (0.0, 2.0)).replace(",2,", ",0,");
    fs::write(folder.path().join("log.csv"), rows).unwrap();
    for arguments in [&arguments[..], &at_rest] {
        fit(folder.path(), arguments).refused(&["u is constant (0 in all", "free motion"]);
    }
}

#[test]
fn a_sensor_without_dynamics_is_a_static_gain_where_order_0_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (gain, offset, delay) = (-2.5e-6, 3e-4, 3);
    let write = |size: f64| {
        let u = prbs(8, 600);
        let rows = noise(31, 600).into_iter().enumerate().map(|(k, e)| {
            let y = offset + gain * u[k.saturating_sub(delay)] + size * e;
            (format!("{:.2}", k as f64 * STEP), u[k], y)
        });
        let mut text = String::from("t,u,y\n");
        for (time, u, y) in rows {
            text += &format!("{time},{u},{y:.17e}\n");
        }
        fs::write(folder.path().join("log.csv"), text).unwrap();
    };
    let arguments = ["log.csv", "-i", "u", "-o", "y", "--order", "0"];
    write(1e-7);
    for method in ["automatic", "output_error", "armax", "least_squares"] {
        let more = ["--method", method, "--delay", "3"];
        let more = if method == "automatic" {
            &more[..2]
        } else {
            &more
        };
        let answer = fit(folder.path(), &[&arguments[..], more].concat());
        answer.says("verdict: good");
        near(answer.number("model/steady_state_gain/0"), gain, 2e-8);
        near(answer.number("model/offset"), offset, 2e-8);
        // Of 600 samples of +-1.
        let deviation = answer.number("model/steady_state_gain/1");
        near(deviation / (1e-7 / 600.0_f64.sqrt()), 1.0, 0.15);
        let numerator = answer.json.pointer("/model/num").unwrap();
        assert_eq!(numerator.as_array().map(Vec::len), Some(3));
    }
    let others = fit(
        folder.path(),
        &[&arguments[..], &["--method", "n4sid"]].concat(),
    );
    others.refused(&["--order 0", "n4sid"]);
    // Nothing but the gain: refused as dynamics, with the way out, which is taken.
    let rows = (0..300).map(|k| {
        let u = f64::from(k % 17);
        (k.to_string(), u, 2.0 * u + 1.0)
    });
    fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
    fit(folder.path(), &arguments[..5]).refused(&["no dynamics", "--order 0"]);
    let exact = [&arguments[..], &["--model", "static.yaml"]].concat();
    let answer = fit(folder.path(), &exact);
    answer.says("verdict: good");
    near(answer.number("model/steady_state_gain/0"), 2.0, 1e-9);
    let compared = planesman(
        folder.path(),
        &["sysid", "compare", "static.yaml", "log.csv"],
    );
    assert_eq!(compared.status, Some(0), "{}", compared.text);
    assert!(compared.text.contains("100.00"), "{}", compared.text);
}

#[test]
fn a_dead_zone_is_named_and_two_files_have_two_offsets() {
    let folder = tempfile::tempdir().unwrap();
    let levels: Vec<f64> = noise(61, 100)
        .into_iter()
        .flat_map(|e| std::iter::repeat_n(e.clamp(-1.0, 1.0), 15))
        .collect();
    let dead = |u: &f64| u.signum() * (u.abs() - 0.3).max(0.0);
    let write = |name: &str, moved: &[f64], level: f64| {
        let y = second_order([3.0, 1.2, 4.0], STEP, moved);
        let rows = y.into_iter().zip(noise(62, 1500)).enumerate();
        let rows = rows.map(|(k, (y, e))| {
            (
                format!("{:.2}", k as f64 * STEP),
                levels[k],
                level + y + 0.005 * e,
            )
        });
        fs::write(folder.path().join(name), table("t,u,y", rows)).unwrap();
    };
    write("log.csv", &levels.iter().map(dead).collect::<Vec<_>>(), 0.0);
    let one = ["log.csv", "-i", "u", "-o", "y"];
    fit(folder.path(), &one)
        .says("(Hammerstein model): dead zone, lower -0.300")
        .says("verdict: good");
    fit(folder.path(), &[&one[..], &["--curve", "none"]].concat())
        .says("verdict: usable with care: not linear, or varying")
        .says("only beyond a dead zone");
    write("a.csv", &levels, 3.0);
    write("b.csv", &levels, 6.0);
    let both = [
        "sysid",
        "fit",
        "a.csv",
        "b.csv",
        "-i",
        "u",
        "-o",
        "y",
        "--method",
        "oe",
        "--order",
        "2",
        "--verbose",
    ];
    let text = planesman(folder.path(), &both).text;
    let offsets = text
        .lines()
        .find(|line| line.starts_with("offset"))
        .unwrap();
    let numbers: Vec<f64> = offsets
        .split_whitespace()
        .filter_map(|it| it.parse().ok())
        .collect();
    assert_eq!(numbers.len(), 2, "{offsets}");
    near(numbers[0], 3.0, 0.01);
    near(numbers[1], 6.0, 0.01);
}
