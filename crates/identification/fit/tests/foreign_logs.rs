//! Logs as other tools write them: each is made here of one known plant, and is read right or refused with the way out.

#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use planesman_bag::{BagWriter, Topic, TopicKind, WriterOptions};
use planesman_fit::{DataOptions, FitOptions, FitResult, SignalOptions, Survey, fit, survey};

/// Samples of a log.
const COUNT: usize = 600;

/// A valve and the temperature behind it: y_(k+1) = 0.9 y_k + 0.05 u_k, with noise that no seed changes.
fn plant() -> Vec<(usize, f64, f64)> {
    let mut y = 10.0;
    let row = |k: usize| {
        let u = if (k / 20) % 3 == 1 || (k / 35) % 2 == 1 {
            60.0
        } else {
            20.0
        };
        let noise = 0.05 * libm::sin(7.0 * (k * k) as f64);
        let row = (k, u, y + noise);
        y = 0.9 * y + 0.05 * u;
        row
    };
    (0..COUNT).map(row).collect()
}

fn rows(line: impl Fn(usize, f64, f64) -> String) -> String {
    plant()
        .into_iter()
        .map(|(k, u, y)| line(k, u, y) + "\n")
        .collect()
}

/// A time of day, so many ms behind 06:00.
fn clock(ms: usize) -> String {
    format!(
        "{:02}:{:02}:{:02}.{:03}",
        6 + ms / 3_600_000,
        ms / 60_000 % 60,
        ms / 1000 % 60,
        ms % 1000
    )
}

fn date(ms: usize) -> String {
    format!("2026-04-01T{}Z", clock(ms))
}

struct Log(tempfile::TempDir, &'static str);

impl Log {
    fn new(name: &'static str, text: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), text).unwrap();
        Self(folder, name)
    }

    fn data(&self) -> DataOptions {
        DataOptions::files([self.0.path().join(self.1)])
    }

    fn survey(&self) -> Survey {
        let mut survey = survey(&self.data(), None, &()).unwrap();
        survey.suggest(&self.data()).unwrap();
        survey
    }

    fn fit(&self, input: &str, output: &str) -> Result<FitResult, String> {
        let options = FitOptions {
            signals: SignalOptions {
                data: self.data(),
                input: input.to_owned(),
                output: output.to_owned(),
                ..SignalOptions::default()
            },
            ..FitOptions::default()
        };
        fit(&options, &()).map_err(|error| error.to_string())
    }

    /// Checks that the plant is found, with samples so many s apart.
    #[track_caller]
    fn is_the_plant(&self, input: &str, output: &str, step: f64) {
        let found = self.fit(input, output).unwrap();
        let record = &found.prepared.resampled.record;
        assert!(
            (record.sample_time / step - 1.0).abs() < 1e-6,
            "{}: {} s",
            self.1,
            record.sample_time
        );
        let gain = found.analysis.model().steady_state_gain().unwrap();
        assert!((gain - 0.5).abs() < 0.01, "{}: gain {gain}", self.1);
        let poles = found
            .analysis
            .model()
            .poles()
            .unwrap()
            .into_iter()
            .map(|it| it.re);
        let slowest = poles.fold(f64::NEG_INFINITY, f64::max);
        assert!((slowest - 0.9).abs() < 0.005, "{}: pole {slowest}", self.1);
    }

    #[track_caller]
    fn is_refused(&self, words: &[&str]) {
        let refusal = survey(&self.data(), None, &()).unwrap_err().to_string();
        for words in words {
            assert!(refusal.contains(words), "'{words}' is not in: {refusal}");
        }
    }
}

#[test]
fn a_row_of_units_stands_below_names_whatever_its_words() {
    let plain = |k: usize, u: f64, y: f64| format!("{},{u},{y:.3}", date(1000 * k));
    for (name, head) in [
        ("erddap.csv", "time,valve,temp\nUTC,inches,rad\n"),
        (
            "bom.csv",
            "\u{feff}\"time\",\"valve\",\"temp\"\r\n\"UTC\",\"1/8 turns\",\"degree_C\"\r\n",
        ),
        (
            "logger.dat",
            "\"TOA5\",\"CR1000\"\ntime,valve,temp\n\"TS\",\"Deg C\",\"Deg C\"\n,\"Smp\",\"Avg\"\n",
        ),
        ("titled.csv", "Rig,Run,Operator\ntime,valve,temp\n"),
    ] {
        Log::new(name, head.to_owned() + &rows(plain)).is_the_plant("valve", "temp", 1.0);
    }
    Log::new(
        "letters.csv",
        "Versuch,Stand,Prüfer\nZeit,u,y\n".to_owned() + &rows(plain),
    )
    .is_the_plant("u", "y", 1.0);
    // With words that no list has, and a decimal comma.
    let comma = |k: usize, u: f64, y: f64| format!("{k};{u};{y:.3}").replace('.', ",");
    let log = Log::new(
        "words.csv",
        "Zeit;Ventil;Temperatur\nSekunden;Prozent;Grad\n".to_owned() + &rows(comma),
    );
    log.is_the_plant("Ventil", "Temperatur", 1.0);
}

#[test]
fn a_blackbox_counts_microseconds_beside_its_loops() {
    let head = "\"Product\",\"Blackbox\"\n\"looptime\",\"125\"\n\"loopIteration\",\"time\",\"setpoint[0]\",\"gyroADC[0]\"\n";
    let line = |k: usize, u: f64, y: f64| format!("{},{},{u},{y:.3}", 4 * k, 41_234_567 + 500 * k);
    let log = Log::new("blackbox.csv", head.to_owned() + &rows(line));
    log.is_the_plant("setpoint[0]", "gyroADC[0]", 0.0005);
    // Loops are no time.
    let line = |k: usize, u: f64, y: f64| format!("{},{u},{y:.3}", 64 + 4 * k);
    let log = Log::new("loops.csv", "loopIteration,u,y\n".to_owned() + &rows(line));
    let refusal = log.fit("u", "y").unwrap_err();
    assert!(
        refusal.contains("the first column, 'loopIteration', counts the rows"),
        "{refusal}"
    );
    // A unit in doubt is named with those that give a usual rate.
    let line = |k: usize, u: f64, y: f64| format!("{},{u},{y:.3}", 41_234_567 + 500 * k);
    let log = Log::new("uptime.csv", "time,u,y\n".to_owned() + &rows(line));
    let clock = log.survey().topics[0].clock.join("; ");
    assert!(
        clock.contains("in us, by their size, the rate is 2000 Hz, in ms 2 Hz"),
        "{clock}"
    );
}

#[test]
fn a_row_for_each_state_is_a_signal_by_the_entity() {
    let valve = rows(|k, u, _| format!("sensor.valve,{u},{}", date(1000 * k)));
    let temp = rows(|k, _, y| format!("sensor.temp,{y:.3},{}", date(1000 * k)));
    let text = "entity_id,state,last_changed\nsun.sun,above_horizon,2026-04-01T06:00:00.000Z\n"
        .to_owned()
        + &valve
        + "sensor.temp,unavailable,\n"
        + &temp;
    let log = Log::new("history.csv", text);
    log.is_the_plant("sensor.valve", "sensor.temp", 1.0);
    let of = |name: &str| {
        log.survey()
            .topics
            .into_iter()
            .find(|it| it.fields[0].path == name)
            .unwrap()
    };
    assert!((of("sensor.temp").rate - 1.0).abs() < 1e-9);
    // InfluxDB's annotated tables, one behind the other.
    let head = "#group,false,false,true,true,false,false\n#datatype,string,long,dateTime:RFC3339,double,string,string\n\
                #default,_result,,,,,\n,result,table,_time,_value,_field,_measurement\n";
    let series = |name: &str, of: fn(f64, f64) -> f64| {
        head.to_owned()
            + &rows(|k, u, y| format!(",,0,{},{:.3},{name},tank", date(1000 * k), of(u, y)))
            + "\n"
    };
    let log = Log::new(
        "influx.csv",
        series("valve", |u, _| u) + &series("temp", |_, y| y),
    );
    log.is_the_plant("valve", "temp", 1.0);
    assert_eq!(log.survey().topics.len(), 2);
}

#[test]
fn cells_have_units_and_one_unit_a_column() {
    let line = |k: usize, u: f64, y: f64| format!("2026-04-01 {},{u}%,{y:.3} °C", clock(1000 * k));
    let log = Log::new(
        "grafana.csv",
        "\"Time\",\"valve\",\"temp\"\n".to_owned() + &rows(line),
    );
    log.is_the_plant("valve", "temp", 1.0);
    let line = |k: usize, u: f64, y: f64| {
        format!("{};{u} %;{y:.3} °C", 1_775_023_200_000 + 1000 * k).replace('.', ",")
    };
    let log = Log::new(
        "comma.csv",
        "sep=;\n\"Time\";\"valve\";\"temp\"\n".to_owned() + &rows(line),
    );
    log.is_the_plant("valve", "temp", 1.0);
    for scaled in [
        |y: f64| format!("{:.3} kV", y / 1000.0),
        |y: f64| format!("{y:.3}"),
    ] {
        let cell = |y: f64| {
            if y > 20.0 {
                scaled(y)
            } else {
                format!("{y:.3} V")
            }
        };
        let log = Log::new(
            "scaled.csv",
            "t,u,y\n".to_owned() + &rows(|k, u, y| format!("{k},{u},{}", cell(y))),
        );
        log.is_refused(&["'y'", "several units", "the unit 'V'"]);
    }
}

#[test]
fn a_sketch_prints_stamps_and_names() {
    for (name, text, input, output) in [
        (
            "a.txt",
            rows(|k, u, y| format!("{} -> {k},{u},{y:.3}", clock(50 * k))),
            "c3",
            "c4",
        ),
        (
            "tabs.txt",
            rows(|k, u, y| format!("{} -> {u}\t{y:.3}\r", clock(50 * k))),
            "c2",
            "c3",
        ),
        (
            "blanks.log",
            rows(|k, u, y| format!("{} -> {u} {y:.3}", clock(50 * k))),
            "c2",
            "c3",
        ),
        (
            "both.txt",
            rows(|k, u, y| format!("{} -> pwm:{u}, speed:{y:.3}", clock(50 * k))),
            "pwm",
            "speed",
        ),
        (
            "signs.txt",
            rows(|k, u, y| format!("ms={} pwm={u} speed={y:.3}", 50 * k)).replace("ms=", "t_ms="),
            "pwm",
            "speed",
        ),
        (
            "order.txt",
            rows(|k, u, y| {
                if k % 2 == 0 {
                    format!("millis:{},pwm:{u},speed:{y:.3}", 50 * k)
                } else {
                    format!("speed:{y:.3},millis:{},pwm:{u}", 50 * k)
                }
            }),
            "pwm",
            "speed",
        ),
    ] {
        Log::new(name, "Motor test v1\nready\n".to_owned() + &text)
            .is_the_plant(input, output, 0.05);
    }
    let log = Log::new("plot.txt", rows(|_, u, y| format!("pwm:{u},speed:{y:.3}")));
    let proposed = log.survey().suggestion.unwrap();
    assert!(
        proposed.contains("-i pwm -o speed --sample-time SECONDS"),
        "{proposed}"
    );
}

/// A part of a LabVIEW measurement: its heading, of that time and interval, and its rows.
fn part(rows: std::ops::Range<usize>, time: &str, step: &str) -> String {
    let mut text = format!(
        "Channels\t2\t\nSamples\t{0}\t{0}\nDate\t2026/02/19\t2026/02/19\nTime\t{time}\t{time}\nX_Dimension\tTime\tTime\n\
         X0\t0,0E+0\t0,0E+0\nDelta_X\t{step}\t{step}\n***End_of_Header***\t\t\nX_Value\tvalve (V)\ttemp\tComment\n",
        rows.len()
    );
    for (_, u, y) in &plant()[rows] {
        writeln!(
            text,
            "\t{}\t{}",
            format!("{u:.3}").replace('.', ","),
            format!("{y:.3}").replace('.', ",")
        )
        .unwrap();
    }
    text
}

#[test]
fn a_labview_measurement_has_its_interval_in_each_heading() {
    let head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\nX_Columns\tNo\nDate\t2026/02/19\n\
                Time\t09:51:39,19\n***End_of_Header***\t\n\t\n";
    let one = head.to_owned() + &part(0..COUNT, "09:51:40,5", "3,906250E-5");
    let log = Log::new("one.lvm", &one);
    log.is_the_plant("valve", "temp", 3.90625e-5);
    assert!(
        log.survey().topics[0]
            .stamps
            .contains("the Delta_X in its heading")
    );
    let several = head.to_owned()
        + &part(0..300, "09:51:40,5", "5,0E-3")
        + "\n"
        + &part(300..COUNT, "09:51:50,5", "5,0E-3");
    let log = Log::new("several.lvm", several);
    log.is_the_plant("valve", "temp", 0.005);
    let found = log.fit("valve", "temp").unwrap().prepared.resampled.record;
    let starts: Vec<i64> = found.segments.iter().map(|it| it.start).collect();
    assert_eq!(starts, [0, 10_000_000_000]);
}

#[test]
fn what_is_not_read_is_refused_with_what_converts_it() {
    let cases: [(&str, &[u8], &str); 20] = [
        ("a.wpilog", b"WPILOG\x00\x01", "AdvantageScope"),
        ("a.tdms", b"TDSm\x0e\0\0\0", "nptdms.TdmsFile"),
        ("a.mf4", b"MDF     4.10    ", "asammdf.MDF"),
        ("ending.dat", b"MDF     3.30    ", "asammdf.MDF"),
        ("a.rrd", b"RRF2\0\0", "rerun"),
        ("a.nc", b"CDF\x01", "xarray.open_dataset"),
        ("four.nc", b"\x89HDF\r\n\x1a\n", "xarray.open_dataset"),
        ("a.h5", b"\x89HDF\r\n\x1a\n", "h5py"),
        ("a.mat", b"MATLAB 5.0 MAT-file", "scipy.io.loadmat"),
        ("new.mat", b"MATLAB 7.3 MAT-file", "h5py"),
        ("a.blf", b"LOGG\x90\0\0\0", "cantools"),
        ("a.trc", b";$FILEVERSION=2.1\n", "cantools"),
        ("a.asc", b"date Sat Nov 28 09:00:00.000 am 2026\nbase hex  timestamps absolute\n 0.0 1  64  Rx   d 2 10 11\n", "can.LogReader"),
        ("candump.log", b"(1436509052.249713) vcan0 044#2A366C2BBA\n", "can.LogReader"),
        ("a.bbl", b"H Product:Blackbox flight data recorder\n", "blackbox_decode"),
        ("a.json", b"{}", "json_normalize"),
        ("a.bag", b"#ROSBAG V2.0\n", "rosbags-convert"),
        ("a.csv.gz", b"\x1f\x8b\x08", "gunzip"),
        ("echo.yaml", b"header:\n  frame_id: base\ndata: 19.9\n---\ndata: 20\n---\n", "ros2 topic echo --csv"),
        ("a.xyz", b"what?", "a table is a .csv"),
    ];
    for (name, bytes, words) in cases {
        Log::new(name, bytes).is_refused(&[name, words]);
    }
}

#[test]
fn signals_that_take_turns_in_a_table_have_each_their_rate() {
    let text = "timestamp,u,y,z,w\n".to_owned()
        + &rows(|k, u, y| {
            let t = 100.0 + 0.02 * k as f64;
            format!(
                "{t:.6},{u},,,\n{:.6},,{y:.3},,\n{:.6},,,{k},",
                t + 2e-4,
                t + 4e-4
            )
        });
    let log = Log::new("sparse.csv", text);
    log.is_the_plant("u", "y", 0.02);
    let topics = log.survey().topics;
    assert_eq!(topics.len(), 3);
    for topic in topics {
        assert!(
            (topic.rate - 50.0).abs() < 1e-6 && topic.bursts < 0.01 && topic.change.is_none(),
            "{topic:?}"
        );
    }
}

/// Stamps as `%.5g` writes them.
fn five_digits(t: f64) -> String {
    if t < 1000.0 {
        format!("{t:.2}")
    } else {
        format!("{t:.1}")
    }
}

#[test]
fn digits_that_are_lost_on_the_way_part_nothing() {
    for first in [990.0, 997.0] {
        let line = |k: usize, u: f64, y: f64| {
            format!("{},{u},{y:.3}", five_digits(first + 0.02 * k as f64))
        };
        let log = Log::new("digits.csv", "t,u,y\n".to_owned() + &rows(line));
        log.is_the_plant("u", "y", 0.02);
        let topic = &log.survey().topics[0];
        assert!(
            (topic.rate - 50.0).abs() < 1e-6 && topic.bursts < 0.05,
            "{topic:?}"
        );
        assert!(topic.change.is_some());
    }
}

#[test]
fn the_interval_is_the_measured_one_where_stamps_lie_on_its_grid() {
    for (rate, found) in [
        (29.97, 29.97),
        (59.94, 59.94),
        (30.0, 30.0),
        (100.000_01, 100.0),
    ] {
        let line = |k: usize, u: f64, y: f64| format!("{:.7},{u},{y:.3}", k as f64 / rate);
        let log = Log::new("camera.csv", "t,u,y\n".to_owned() + &rows(line));
        log.is_the_plant("u", "y", 1.0 / found);
    }
}

/// A bag of numbers: topic, value, time of reception.
fn bag(path: &Path, messages: &[(&str, f64, i64)]) {
    std::fs::remove_file(path).unwrap();
    let mut writer = BagWriter::create_file(path, WriterOptions::default()).unwrap();
    let mut known: Vec<(&str, planesman_bag::TopicId)> = Vec::new();
    for (name, value, time) in messages {
        let id = known.iter().find(|it| it.0 == *name).map(|it| it.1);
        let id = id.unwrap_or_else(|| {
            let kind = TopicKind {
                type_name: "std_msgs/msg/Float64".to_owned(),
                definition: "float64 data\n".to_owned(),
                definition_encoding: "ros2msg".to_owned(),
                message_encoding: "cdr".to_owned(),
                type_hash: String::new(),
                offered_qos: Vec::new(),
            };
            let topic = Topic {
                name: (*name).to_owned(),
                kind: Arc::new(kind),
            };
            let id = writer.add_topic(&topic).unwrap();
            known.push((name, id));
            id
        });
        let payload = [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat();
        writer.write_raw(id, &payload, *time, 0).unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn messages_that_are_not_in_order_are_read_by_their_log_time() {
    let messages = |k: usize, u: f64, y: f64| {
        let time = 1_700_000_000_000_000_000 + 20_000_000 * k as i64;
        [("/u", u, time), ("/y", y, time)]
    };
    let all: Vec<_> = plant()
        .into_iter()
        .flat_map(|(k, u, y)| messages(k, u, y))
        .collect();
    let shuffled = (0..all.len()).map(|k| all[k * 7919 % all.len()]);
    let halves = all[COUNT..].iter().chain(&all[..COUNT]).copied();
    let backwards = all.iter().rev().copied();
    for messages in [
        shuffled.collect::<Vec<_>>(),
        halves.collect(),
        backwards.collect(),
    ] {
        let log = Log::new("log.mcap", "");
        bag(&log.0.path().join("log.mcap"), &messages);
        log.is_the_plant("u:data", "y:data", 0.02);
        let found = log.fit("u:data", "y:data").unwrap();
        assert_eq!(found.prepared.resampled.record.segments.len(), 1);
        let topics = log.survey().topics;
        assert!(
            topics
                .iter()
                .all(|it| it.timing.late == 0 && it.clock.is_empty()),
            "{topics:?}"
        );
    }
}

#[test]
fn a_loop_is_proposed_with_its_own_pair_and_reference() {
    // Two loops of which each has its plant, with a controller and noise at its input.
    let mut all = Vec::new();
    for (name, seed, period) in [("heading", 3_u64, 20), ("speed", 11, 30)] {
        let (mut y, mut held) = (0.0, 0.0);
        let mut state = seed;
        for k in 0..4 * COUNT {
            let r = if ((k / period) * 2_654_435_761 / 1000) % 2 == 0 {
                1.0
            } else {
                -0.5
            };
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let noise = (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5;
            let measured = y + 0.02 * noise;
            held += 0.02 * (r - measured);
            let u = 0.8 * (r - measured) + held;
            let time = 20_000_000 * k as i64;
            let signals = [("u", u), ("y", measured), ("r", r), ("e", r - measured)];
            all.extend(signals.map(|(part, value)| (format!("{part}_{name}"), value, time)));
            y = 0.95 * y + 0.1 * u;
        }
    }
    all.sort_by_key(|it| it.2);
    let messages: Vec<_> = all.iter().map(|it| (it.0.as_str(), it.1, it.2)).collect();
    let log = Log::new("loop.mcap", "");
    bag(&log.0.path().join("loop.mcap"), &messages);
    let proposed = log.survey().suggestion.unwrap();
    let is_of = |name: &str| {
        proposed.contains(&format!(
            "-i u_{name}:data -o y_{name}:data --reference r_{name}:data"
        ))
    };
    assert!(is_of("heading") || is_of("speed"), "{proposed}");
    assert!(!proposed.contains("e_"), "{proposed}");
}
