//! Samples put on a grid are what the method says, and nothing is invented across a gap.
#![allow(clippy::unwrap_used)]

use planesman_signals::{
    GridError, GridSample, LiveGrid, MAX_NUMBERS, Method, Options, Resampled, Resampler,
};

const SECOND: i64 = 1_000_000_000;
const START: i64 = 1_700_000_000 * SECOND + 123_456_789;

/// Stamps in seconds from [`START`], and values.
type Samples = Vec<(f64, f64)>;

fn resampled(u: &[(f64, f64)], y: &[(f64, f64)], options: Options) -> Result<Resampled, GridError> {
    let mut resampler = Resampler::new(&["u".to_owned()], &["y".to_owned()], options);
    let mut samples: Vec<_> = u.iter().map(|it| (0, *it)).collect();
    samples.extend(y.iter().map(|it| (1, *it)));
    samples.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    for (signal, (seconds, value)) in samples {
        let stamp = START + (seconds * 1e9).round() as i64;
        assert!(resampler.take(signal, stamp, Some(value)));
    }
    resampler.finish()
}

fn at_rate(rate: f64) -> Options {
    Options {
        rate: Some(rate),
        ..Options::default()
    }
}

fn line(count: usize, period: f64) -> Samples {
    (0..count)
        .map(|k| (k as f64 * period, 3.0 * k as f64 * period - 1.0))
        .collect()
}

#[test]
fn data_on_a_grid_is_taken_as_it_is() {
    for period in [0.05, 0.01, 1.0 / 30.0, 0.033, 1.0 / 128.0, 2.5] {
        let y: Samples = (0..3000)
            .map(|k| (k as f64 * period, libm::sin(k as f64)))
            .collect();
        let u: Samples = y.iter().map(|(t, y)| (*t, libm::cos(*y))).collect();
        let record = resampled(&u, &y, Options::default()).unwrap().record;
        assert!(
            (record.sample_time - period).abs() < 1e-9,
            "{period}: {}",
            record.sample_time
        );
        let [segment] = &record.segments[..] else {
            panic!("{period}: {} segments", record.segments.len())
        };
        assert_eq!((segment.start, segment.len()), (START, 3000));
        for (k, ((_, y), (_, u))) in y.iter().zip(&u).enumerate() {
            // Stamps are whole nanoseconds; the grid is not always.
            assert!((segment.outputs[0][k] - y).abs() < 1e-6, "{period}");
            assert!((segment.inputs[0][k] - u).abs() < 1e-6, "{period}");
        }
    }
}

#[test]
fn between_samples_an_output_is_on_the_straight_line() {
    let y: Samples = line(1000, 0.007)
        .into_iter()
        .map(|(t, v)| (t + 0.0013, v))
        .collect();
    let record = resampled(&line(400, 0.05), &y, at_rate(20.0))
        .unwrap()
        .record;
    let segment = &record.segments[0];
    for (k, value) in segment.outputs[0].iter().enumerate() {
        let expected = 3.0 * k as f64 * 0.05 - 1.0;
        assert!((value - expected).abs() < 1e-9, "{k}: {value} {expected}");
    }
}

#[test]
fn an_input_is_its_mean_over_the_interval_held_from_sample_to_sample() {
    // 0 until 0.03 s, 1 until 0.07 s, 3 until 0.20 s, ...
    let u = [
        (0.0, 0.0),
        (0.03, 1.0),
        (0.07, 3.0),
        (0.2, -1.0),
        (0.21, 5.0),
    ];
    let y = line(6, 0.05);
    let options = Options {
        max_gap: Some(0.2),
        ..at_rate(20.0)
    };
    let means = |method| {
        let options = Options {
            input_method: method,
            ..options.clone()
        };
        resampled(&u, &y, options).unwrap().record.segments[0].inputs[0].clone()
    };
    let expected = [0.4, 2.2, 3.0, 3.0, 3.8];
    let mean = means(Method::Mean);
    assert_eq!(mean.len(), expected.len());
    for (mean, expected) in mean.iter().zip(expected) {
        assert!((mean - expected).abs() < 1e-12, "{mean} {expected}");
    }
    assert_eq!(means(Method::Hold), [0.0, 1.0, 3.0, 3.0, -1.0]);
}

#[test]
fn live_and_offline_give_the_same_numbers_to_the_last_bit() {
    // An output at 87 Hz with jitter, an input that is sent when it changes.
    let wobble = |k: usize| libm::sin(k as f64 * 12.9898) * 43758.547 % 1.0;
    let y: Samples = (0..2000)
        .map(|k| ((k as f64 + 0.3 * wobble(k)) / 87.0, wobble(k + 7)))
        .collect();
    let mut u = vec![(-0.2, 1.7)];
    while u[u.len() - 1].0 < 22.0 {
        let k = u.len();
        u.push((u[k - 1].0 + 0.02 + 0.4 * wobble(k).abs(), wobble(3 * k)));
    }
    let offline = resampled(&u, &y, at_rate(20.0)).unwrap().record;
    let [segment] = &offline.segments[..] else {
        panic!("{} segments", offline.segments.len())
    };
    let mut live = LiveGrid::new(SECOND / 20, SECOND);
    let mut all: Vec<_> = u.iter().map(|it| (true, *it)).collect();
    all.extend(y.iter().map(|it| (false, *it)));
    all.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let mut given = Vec::new();
    for (is_input, (seconds, value)) in all {
        let stamp = START + (seconds * 1e9).round() as i64;
        given.extend(match is_input {
            true => live.input(stamp, value),
            false => live.output(stamp, value, false),
        });
    }
    given.push(live.finish());
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for given in given.into_iter().flatten() {
        let (stamp, list, value) = match given {
            GridSample::Output(stamp, value) => (stamp, &mut outputs, value),
            GridSample::Input(stamp, input) => (stamp, &mut inputs, input.mean),
        };
        if stamp >= segment.start {
            assert_eq!(stamp, segment.start + list.len() as i64 * (SECOND / 20));
            list.push(value);
        }
    }
    let count = inputs.len().min(segment.len());
    assert!(count > 400, "{count}");
    assert_eq!(inputs[..count], segment.inputs[0][..count]);
    assert_eq!(outputs[..count], segment.outputs[0][..count]);
}

#[test]
fn the_mean_about_an_instant_is_of_the_samples_nearest_to_it() {
    let y: Samples = (0..1000)
        .map(|k| (f64::from(k) * 0.001, f64::from(k)))
        .collect();
    let options = Options {
        output_method: Method::Centred,
        ..at_rate(10.0)
    };
    let record = resampled(&line(100, 0.01), &y, options).unwrap().record;
    let found = &record.segments[0].outputs[0];
    // Samples 50 to 149 about 0.1 s.
    assert!(
        (found[1] - 99.5).abs() < 1e-9 && (found[5] - 499.5).abs() < 1e-9,
        "{found:?}"
    );
}

#[test]
fn a_pause_parts_the_record_and_nothing_is_invented_in_it() {
    let whole = line(2000, 0.01);
    let y: Samples = whole
        .iter()
        .copied()
        .filter(|(t, _)| *t < 5.0 || *t > 8.004)
        .collect();
    let Resampled {
        record, outputs, ..
    } = resampled(&whole, &y, at_rate(20.0)).unwrap();
    let spans: Vec<_> = record
        .segments
        .iter()
        .map(|it| ((it.start - START) as f64 * 1e-9, it.len()))
        .collect();
    // To 4.99 s, and again from 8.01 s.
    assert_eq!(spans, [(0.0, 100), (8.05, 239)]);
    assert_eq!(outputs[0].timing.gaps, 1);
    assert!(outputs[0].timing.longest > 3.0);
    let bridged = Options {
        max_gap: Some(4.0),
        ..at_rate(20.0)
    };
    assert_eq!(
        resampled(&whole, &y, bridged)
            .unwrap()
            .record
            .segments
            .len(),
        1
    );
}

#[test]
fn a_setpoint_that_is_sent_when_it_changes_is_known_until_it_changes() {
    // A depth setpoint now and then, a depth at 20 Hz that pauses once.
    let u = [(-3.0, 1.0), (12.51, 2.0), (12.53, 4.0), (40.0, -1.0)];
    let y: Samples = line(2000, 0.05)
        .into_iter()
        .filter(|(t, _)| *t < 60.0 || *t > 61.0)
        .collect();
    let held = |at: f64| match at {
        at if at < 12.5 => 1.0,
        at if at < 40.0 => 4.0,
        _ => -1.0,
    };
    let method = |input_method, max_gap| Options {
        input_method,
        max_gap,
        ..Options::default()
    };
    for which in [Method::Mean, Method::Hold] {
        let Resampled {
            record,
            inputs,
            outputs,
        } = resampled(&u, &y, method(which, None)).unwrap();
        let spans: Vec<_> = record
            .segments
            .iter()
            .map(|it| ((it.start - START) / 1_000_000, it.len()))
            .collect();
        // Only the depth's pause parts the record; the last setpoint acts to its end.
        assert_eq!(spans, [(0, 1200), (61_050, 779)], "{which}");
        for segment in &record.segments {
            for (k, value) in segment.inputs[0].iter().enumerate() {
                let at = (segment.start - START) as f64 * 1e-9 + 0.05 * k as f64;
                let changes = (at - 12.5).abs() < 0.01;
                let expected = match (changes, which) {
                    (false, _) => held(at),
                    // 1 for 10 ms, 2 for 20 ms, 4 for 20 ms.
                    (true, Method::Mean) => 2.6,
                    (true, _) => 1.0,
                };
                assert!((value - expected).abs() < 1e-12, "{which} {at}: {value}");
            }
        }
        assert!((inputs[0].held - 60.0).abs() < 0.1, "{:?}", inputs[0]);
        assert_eq!(outputs[0].held, 0.0);
        // One that is asked for makes gaps of pauses.
        let parted = resampled(&u, &y, method(which, Some(16.0))).unwrap();
        assert_eq!(parted.record.segments[0].len(), 251, "{which}");
    }
    // Between samples on a straight line nothing is known behind the last.
    let line = resampled(&u, &y, method(Method::Linear, None)).unwrap();
    assert_eq!(line.record.samples(), 801);
    // A single setpoint will do.
    let once = resampled(&u[..1], &y, Options::default()).unwrap();
    assert_eq!(once.record.samples(), 1979);
}

#[test]
fn a_measured_motion_is_averaged_on_straight_lines_between_its_samples() {
    // A parabola sampled at 100 Hz and at the grid's own 20 Hz; the output's instants lie between the samples.
    for period in [0.01, 0.05] {
        let motion = |t: f64| t * t;
        let u: Samples = (0..=400)
            .map(|k| k as f64 * period)
            .map(|t| (t, motion(t)))
            .collect();
        let y: Samples = line(60, 0.05)
            .iter()
            .map(|(t, v)| (t + 0.013, *v))
            .collect();
        let options = Options {
            input_method: Method::Foh,
            ..at_rate(20.0)
        };
        let record = resampled(&u, &y, options).unwrap().record;
        let segment = &record.segments[0];
        assert!(segment.len() >= 58, "{}", segment.len());
        for (k, value) in segment.inputs[0].iter().enumerate() {
            let at = (segment.start - START) as f64 * 1e-9 + 0.05 * k as f64;
            // Simpson's rule is exact; a chord lies above a parabola by at most a quarter of the period squared.
            let mean = (motion(at) + 4.0 * motion(at + 0.025) + motion(at + 0.05)) / 6.0;
            assert!(
                (0.0..period * period / 4.0 + 1e-9).contains(&(value - mean + 1e-9)),
                "{at}: {value} {mean}"
            );
        }
    }
}

#[test]
fn a_hold_for_ever_takes_no_memory_and_makes_no_endless_record() {
    let y = line(100, 0.05);
    // Stamps far beyond the outputs.
    let u = [(0.0, 1.0), (2.0, 2.0), (4e9, 3.0)];
    let record = resampled(&u, &y, Options::default()).unwrap().record;
    assert_eq!(record.samples(), 100);
    let ends = [(0.0, 1.0), (1e9, 1.0)];
    let options = Options {
        output_method: Method::Hold,
        max_gap: Some(1e9),
        ..at_rate(1e6)
    };
    let refusal = resampled(&ends, &ends, options).unwrap_err().to_string();
    assert!(refusal.contains(&MAX_NUMBERS.to_string()), "{refusal}");
}

#[test]
fn a_window_is_counted_from_the_first_output() {
    let options = Options {
        window: 2.0..=3.0,
        ..at_rate(20.0)
    };
    let y: Samples = line(2000, 0.01)
        .into_iter()
        .map(|(t, v)| (t + 0.5, v))
        .collect();
    let record = resampled(&line(3000, 0.01), &y, options).unwrap().record;
    assert_eq!(
        (record.segments[0].start, record.samples()),
        (START + SECOND / 2 + 2 * SECOND, 21)
    );
}

#[test]
fn order_is_restored_and_what_cannot_be_used_is_counted() {
    let u = line(500, 0.05);
    let expected = resampled(&u, &u, at_rate(20.0)).unwrap();
    let mut resampler = Resampler::new(&["u".to_owned()], &["y".to_owned()], at_rate(20.0));
    let stamp = |seconds: f64| START + (seconds * 1e9).round() as i64;
    let mut shuffled = u.clone();
    shuffled.chunks_mut(50).for_each(|block| block.reverse());
    for (t, v) in &shuffled {
        resampler.take(0, stamp(*t), Some(*v));
    }
    for (k, (t, v)) in shuffled.iter().enumerate() {
        resampler.take(1, stamp(*t), Some(*v));
        match k {
            10 => drop(resampler.take(1, stamp(*t), Some(*v))),
            20 => drop(resampler.take(1, stamp(*t), Some(f64::NAN))),
            30 => drop(resampler.take(1, stamp(*t), Some(1e31))),
            40 => drop(resampler.take(1, stamp(*t), None)),
            50 => drop(resampler.take(1, i64::MAX, Some(0.0))),
            300 => drop(resampler.take(1, stamp(0.0) - 1, Some(0.0))),
            _ => {}
        }
    }
    let Resampled {
        record, outputs, ..
    } = resampler.finish().unwrap();
    assert!(record.segments == expected.record.segments);
    let timing = &outputs[0].timing;
    assert_eq!(
        (
            timing.duplicates,
            timing.not_finite,
            timing.absent,
            timing.late
        ),
        (1, 2, 1, 2)
    );
}

#[test]
fn what_gives_no_record_is_refused_with_the_reason() {
    let y = line(100, 0.05);
    let later: Samples = y.iter().map(|(t, v)| (t + 1000.0, *v)).collect();
    let refusal = resampled(&later, &y, Options::default())
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("at no time") && refusal.contains("u from"),
        "{refusal}"
    );
    let refusal = resampled(&[], &y, Options::default())
        .unwrap_err()
        .to_string();
    assert!(refusal.contains("u: the signal has no sample"), "{refusal}");
    // A record that would not fit stops growing, whatever the stamps.
    let ends = [(0.0, 1.0), (1e9, 1.0)];
    let options = Options {
        max_gap: Some(1e9),
        ..at_rate(1e6)
    };
    let refusal = resampled(&ends, &ends, options).unwrap_err().to_string();
    assert!(refusal.contains(&MAX_NUMBERS.to_string()), "{refusal}");
}

#[test]
fn stamps_as_far_from_each_other_as_are_taken_end_in_a_record_or_a_refusal() {
    const FAR: i64 = (1 << 62) - 1;
    let stamps = [-FAR, -FAR + 3, -FAR / 2, 0, 7, FAR / 2, FAR - 3, FAR];
    for rate in [None, Some(3.0), Some(1e-9), Some(0.3e-9)] {
        for method in [
            Method::Mean,
            Method::Hold,
            Method::Foh,
            Method::Linear,
            Method::Centred,
        ] {
            let options = Options {
                rate,
                input_method: method,
                output_method: method,
                ..Options::default()
            };
            let mut resampler = Resampler::new(&["u".to_owned()], &["y".to_owned()], options);
            for stamp in stamps {
                for signal in [0, 1] {
                    resampler.take(signal, stamp + signal as i64, Some(stamp as f64));
                }
            }
            drop(resampler.finish());
        }
    }
}
