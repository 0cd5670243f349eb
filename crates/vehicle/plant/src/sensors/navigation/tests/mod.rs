//! The instruments beside what they measure, in numbers of other origin: closed forms, and PROJ for places on the earth.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{geodesy::Geodetic, *};
use planesman_vehicle::{AxisState, Body, State};

const TICK: i64 = 50_000_000;

fn memory() -> Memory {
    Memory::new(1988)
}

/// A body at these angles \[rad\] and this depth \[m\] in a current, at 1 m/s through the water.
fn at([roll, pitch, yaw]: [f64; 3], depth: f64, current: [f64; 3]) -> Odometry {
    let turned = |angle| AxisState { angle, rate: 0.0 };
    let plane = State {
        depth,
        pitch,
        ..State::default()
    };
    let body = Body {
        roll: turned(roll),
        yaw: turned(yaw),
        ..Body::upright(plane, 1.0)
    };
    Odometry::new(&body, current)
}

/// Mean and standard deviation.
fn statistics(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|it| (it - mean).powi(2)).sum::<f64>();
    (mean, (square / (count - 1.0)).sqrt())
}

/// That values have a mean and a standard deviation, within five deviations of such statistics.
fn assert_normal(values: &[f64], mean: f64, deviation: f64) {
    let count = values.len() as f64;
    let (found_mean, found) = statistics(values);
    let error = 5.0 * deviation / count.sqrt();
    assert!((found_mean - mean).abs() < error, "{found_mean} {mean}");
    let error = 5.0 * deviation / (2.0 * count).sqrt();
    assert!((found - deviation).abs() < error, "{found} {deviation}");
}

#[test]
fn a_measurement_falls_on_the_first_tick_at_or_after_each_multiple_of_its_period() {
    let due = |rate: f64| -> Vec<i64> {
        let ticks = (0..60).filter(|k| is_due(rate, k * TICK, TICK));
        ticks.collect()
    };
    assert_eq!(due(2.0), [0, 10, 20, 30, 40, 50]);
    assert_eq!(due(0.5), [0, 40]);
    // Thirds of a second are ticks 6.7, 13.3, 20.
    assert_eq!(due(3.0)[..5], [0, 7, 14, 20, 27]);
    assert_eq!(due(20.0).len(), 60);
    assert_eq!(due(1000.0).len(), 60);
    assert_eq!(due(0.0), [0; 0]);
}

const DVL: Dvl = Dvl {
    rate: 5.0,
    noise: 0.01,
    water_noise: 0.04,
    scale: 0.0,
    altitude_noise: 0.02,
    range: 50.0,
    dropout: 0.0,
};

#[test]
fn the_noise_of_the_beams_is_that_of_the_velocity_by_their_geometry() {
    let mut memory = memory();
    let moving = at([0.1, -0.2, 2.0], 10.0, [0.3, -0.1, 0.0]);
    let readings: Vec<_> = (0..20_000)
        .map(|_| (DVL.read(&moving, Some(30.0), &mut memory.dvl)).expect("no dropouts"))
        .collect();
    // Beams at 30 degrees: 1/(sqrt 2 sin 30) and 1/(2 cos 30).
    for (axis, share) in [
        (0, 2.0_f64.sqrt()),
        (1, 2.0_f64.sqrt()),
        (2, 1.0 / 3.0_f64.sqrt()),
    ] {
        let values: Vec<f64> = readings.iter().map(|it| it.velocity[axis]).collect();
        assert_normal(&values, moving.velocity[axis], 0.01 * share);
        assert!((readings[0].deviation[axis] - 0.01 * share).abs() < 1e-15);
    }
    let altitudes: Vec<f64> = readings
        .iter()
        .map(|it| match it.lock {
            Lock::Bottom { altitude } => altitude,
            Lock::Water => panic!("20 m above the bottom"),
        })
        .collect();
    let along_the_axis = 20.0 / (libm::cos(0.1) * libm::cos(0.2));
    assert_normal(&altitudes, along_the_axis, 0.02);
}

#[test]
fn bottom_lock_ends_where_a_beam_no_longer_reaches_the_bottom() {
    let locked = |odometry: &Odometry, bottom: f64| {
        let reading = DVL.read(odometry, Some(bottom), &mut memory().dvl);
        matches!(reading.expect("no dropout").lock, Lock::Bottom { .. })
    };
    let level = at([0.0; 3], 0.0, [0.0; 3]);
    // 50 m cos 30.
    assert!(locked(&level, 43.30) && !locked(&level, 43.31));
    // Bow up by 20 degrees the forward beams' downward share is cos 30 cos 20 - sin 30 sin 20 / sqrt 2.
    let pitched = at([0.0, 20_f64.to_radians(), 1.0], 0.0, [0.0; 3]);
    assert!(locked(&pitched, 34.64) && !locked(&pitched, 34.65));
    let on_its_side = at([1.2, 0.0, 0.0], 0.0, [0.0; 3]);
    assert!(!locked(&on_its_side, 1.0), "two beams look upwards");
    let nothing_below = DVL.read(&level, None, &mut memory().dvl);
    assert_eq!(nothing_below.map(|it| it.lock), Some(Lock::Water));
}

#[test]
fn bottom_lock_is_over_ground_and_water_lock_through_the_water() {
    let exact = Dvl {
        noise: 0.0,
        water_noise: 0.0,
        scale: 0.01,
        ..DVL
    };
    // Heading to starboard of x, with a current along x: from the port side.
    let drifting = at([0.0, 0.0, FRAC_PI_2], 1.0, [0.5, 0.0, 0.0]);
    let velocity = |bottom| {
        let reading = exact.read(&drifting, bottom, &mut memory().dvl);
        reading.expect("no dropout").velocity
    };
    for (found, expected) in [
        (velocity(Some(10.0)), [1.01, 0.505, 0.0]),
        (velocity(None), [1.01, 0.0, 0.0]),
    ] {
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}

#[test]
fn dropouts_have_their_probability_and_are_the_same_in_each_run() {
    let dropping = Dvl {
        dropout: 0.3,
        ..DVL
    };
    let run = || {
        let mut memory = memory();
        let level = at([0.0; 3], 1.0, [0.0; 3]);
        let once = |_| dropping.read(&level, None, &mut memory.dvl).is_none();
        (0..10_000).map(once).collect::<Vec<bool>>()
    };
    let lost = run().into_iter().filter(|it| *it).count() as f64;
    // Binomial: 3000 and 45.8.
    assert!((lost - 3000.0).abs() < 5.0 * 45.8, "{lost}");
    assert_eq!(run(), run());
}

#[test]
fn a_level_compass_points_to_magnetic_north_from_any_initial_heading() {
    let (declination, inclination) = (0.22_f64, 1.06_f64);
    let field = EarthField {
        strength: 50e-6,
        declination,
        inclination,
    };
    for initial in [0.0, FRAC_PI_2, 4.0] {
        for yaw in [0.0, 1.0, -2.5] {
            let felt = at([0.0, 0.0, yaw], 1.0, [0.0; 3]).to_body(field.in_odom(initial));
            let magnetic_heading = libm::atan2(felt[1], felt[0]);
            let error = (magnetic_heading - (initial + yaw - declination)) / (2.0 * PI);
            assert!((error - error.round()).abs() < 1e-12, "{initial} {yaw}");
            assert!((felt[2] + 50e-6 * libm::sin(inclination)).abs() < 1e-18);
            let strength = libm::sqrt(felt.iter().map(|it| it * it).sum());
            assert!((strength / 50e-6 - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn the_magnetometer_adds_hard_iron_and_noise() {
    let magnetometer = Magnetometer {
        rate: 1.0,
        noise: 2e-7,
        hard_iron: HardIron {
            x: 1e-6,
            y: -2e-6,
            z: 3e-6,
        },
    };
    let mut memory = memory();
    let readings: Vec<_> = (0..5000)
        .map(|_| magnetometer.read([2e-5, 0.0, -4e-5], &mut memory.magnetometer))
        .collect();
    for (axis, mean) in [2.1e-5, -2e-6, -3.7e-5].into_iter().enumerate() {
        let values: Vec<f64> = readings.iter().map(|it| it[axis]).collect();
        assert_normal(&values, mean, 2e-7);
    }
}

/// Places by PROJ 9 (through earth-centred axes, EPSG 4978 to 4979): origin, east-north-up, latitude, longitude, altitude.
const PLACES: [([f64; 2], [f64; 3], [f64; 3]); 4] = [
    (
        [36.7, -122.0],
        [1000.0, 2000.0, 0.1],
        [36.718022005140, -121.988806716394, 0.492851615883],
    ),
    (
        [-33.9, 179.999],
        [500.0, -800.0, -30.0],
        [-33.907212278696, -179.995593699239, -29.930070091970],
    ),
    (
        [69.6, 18.9],
        [-12_000.0, 7000.0, 5.0],
        [69.662475732666, 18.590748469392, 20.088325422257],
    ),
    (
        [0.0, 0.0],
        [100.0, -100.0, 0.0],
        [-0.000904369477, 0.000898315284, 0.001573137008],
    ),
];

#[test]
fn places_are_those_of_proj() {
    for ([latitude, longitude], place, [north, east, up]) in PLACES {
        let origin = Origin {
            latitude,
            longitude,
            heading: 0.0,
        };
        let found = origin.geodetic(place);
        // 1e-11 degrees are a micrometre.
        assert!((found.latitude - north).abs() < 1e-11, "{found:?} {north}");
        assert!((found.longitude - east).abs() < 1e-11, "{found:?} {east}");
        assert!((found.altitude - up).abs() < 1e-6, "{found:?} {up}");
    }
}

#[test]
fn ahead_is_the_azimuth_of_the_initial_heading() {
    for (heading, expected) in [
        (0.0, [2.0, 1.0, -3.0]),
        (FRAC_PI_2, [1.0, -2.0, -3.0]),
        (PI, [-2.0, -1.0, -3.0]),
    ] {
        let origin = Origin {
            heading,
            ..Origin::default()
        };
        // One metre ahead, two to starboard, three down.
        let found = origin.east_north_up([1.0, -2.0, -3.0]);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{heading}");
        }
    }
}

#[test]
fn there_is_a_fix_while_the_antenna_is_out_of_the_water() {
    let gps = Gps {
        rate: 1.0,
        antenna: 0.1,
        ..Gps::default()
    };
    let fixed = |attitude, depth| {
        let odometry = at(attitude, depth, [0.0; 3]);
        let reading = gps.read(&odometry, &Origin::default(), &mut memory().gps);
        reading.is_some()
    };
    assert!(fixed([0.0; 3], 0.0) && fixed([0.0; 3], 0.0999));
    assert!(!fixed([0.0; 3], 0.1001) && !fixed([0.0; 3], 10.0));
    // 0.1 m cos 60.
    assert!(fixed([PI / 3.0, 0.0, 0.0], 0.0499) && !fixed([PI / 3.0, 0.0, 0.0], 0.0501));
}

#[test]
fn fixes_scatter_by_the_deviations_about_the_biased_place() {
    let gps = Gps {
        rate: 1.0,
        noise: 1.0,
        vertical_noise: 2.0,
        bias: 3.0,
        antenna: 0.0,
    };
    let mut memory = memory();
    let surfaced = at([0.0; 3], 0.0, [0.0; 3]);
    let origin = Origin {
        latitude: 0.0,
        longitude: 0.0,
        heading: 0.0,
    };
    let fixes: Vec<_> = (0..5000)
        .filter_map(|_| gps.read(&surfaced, &origin, &mut memory.gps))
        .collect();
    assert_eq!(fixes.len(), 5000);
    // A degree on the equator: along it a pi / 180, across it that times 1 - e^2.
    let along = 6_378_137.0 * PI / 180.0;
    let across = along * (1.0 - 0.006_694_38);
    let of = |it: fn(&Geodetic) -> f64, scale: f64| -> Vec<f64> {
        fixes.iter().map(|fix| it(fix) * scale).collect()
    };
    assert_normal(&of(|it| it.longitude, along), 3.0, 1.0);
    assert_normal(&of(|it| it.latitude, across), 3.0, 1.0);
    assert_normal(&of(|it| it.altitude, 1.0), 0.0, 2.0);
}

const USBL: Usbl = Usbl {
    rate: 1.0,
    noise: 0.3,
    relative_noise: 0.01,
    bias: 0.5,
    delay: 0.0,
    dropout: 0.0,
    outlier: 0.0,
    outlier_size: 20.0,
};

#[test]
fn the_acoustic_position_scatters_by_its_slant_range() {
    let mut memory = memory();
    let position = [30.0, -40.0, -120.0];
    let readings: Vec<_> = (0..5000)
        .map(|_| {
            USBL.read(position, 0, true, &mut memory.usbl)
                .expect("at once")
        })
        .collect();
    // 130 m away: sqrt(0.3^2 + 1.3^2).
    let deviation = 1.78_f64.sqrt();
    for (axis, place) in position.into_iter().enumerate() {
        let values: Vec<f64> = readings.iter().map(|it| it.position[axis]).collect();
        assert_normal(&values, place + 0.5, deviation);
    }
    assert!((readings[0].deviation - deviation).abs() < 1e-14);
}

#[test]
fn an_acoustic_position_comes_late_and_is_of_its_own_time() {
    let late = Usbl {
        noise: 0.0,
        relative_noise: 0.0,
        bias: 0.0,
        delay: 1.23,
        ..USBL
    };
    let mut memory = memory();
    let mut arrived = Vec::new();
    for k in 0..100 {
        let (time, due) = (k * TICK, k % 20 == 0);
        let position = [k as f64, 0.0, 0.0];
        if let Some(it) = late.read(position, time, due, &mut memory.usbl) {
            arrived.push((k, it.position[0], it.age));
        }
    }
    // 1.23 s are 24.6 ticks: 25.
    let age = 25 * TICK;
    assert_eq!(arrived[..2], [(25, 0.0, age), (45, 20.0, age)]);
    assert_eq!(arrived.len(), 4);
}

#[test]
fn lost_positions_and_outliers_have_their_probabilities() {
    let bad = Usbl {
        noise: 0.1,
        relative_noise: 0.0,
        bias: 0.0,
        dropout: 0.1,
        outlier: 0.2,
        ..USBL
    };
    let mut memory = memory();
    let readings: Vec<_> = (0..10_000)
        .filter_map(|_| bad.read([0.0; 3], 0, true, &mut memory.usbl))
        .collect();
    let came = readings.len() as f64;
    assert!((came - 9000.0).abs() < 5.0 * 30.0, "{came}");
    // Of an outlier all three axes are rarely within half a metre.
    let far = |it: &&UsblReading| it.position.iter().any(|x| x.abs() > 0.6);
    let outliers: Vec<_> = readings.iter().filter(far).collect();
    let count = outliers.len() as f64;
    assert!(
        (count - 0.2 * came).abs() < 5.0 * (0.16 * came).sqrt(),
        "{count}"
    );
    let values: Vec<f64> = outliers.iter().map(|it| it.position[0]).collect();
    assert_normal(&values, 0.0, libm::hypot(20.0, 0.1));
}

/// Roll, pitch and yaw as ROS has them, of a quaternion (x, y, z, w).
fn ros_angles([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    [
        libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        libm::asin(2.0 * (w * y - z * x)),
        libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    ]
}

#[test]
fn the_attitude_reference_counts_from_east_with_its_errors() {
    let reference = AttitudeReference {
        enabled: true,
        noise: 0.002,
        heading_noise: 0.01,
        heading_bias: 0.05,
    };
    let exact = AttitudeReference {
        enabled: true,
        noise: 0.0,
        heading_noise: 0.0,
        heading_bias: 0.0,
    };
    let mut memory = memory();
    let [roll, pitch, yaw] = [0.2, -0.3, 0.4];
    let orientation = at([roll, pitch, yaw], 1.0, [0.0; 3]).orientation;
    // On an initial heading to the north, ROS' yaw is a quarter turn less the turn to starboard; its pitch is bow down.
    let found = ros_angles(exact.read(orientation, 0.0, &mut memory.attitude));
    for (found, expected) in found.into_iter().zip([roll, -pitch, FRAC_PI_2 - yaw]) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
    let level = at([0.0; 3], 1.0, [0.0; 3]).orientation;
    let readings: Vec<_> = (0..5000)
        .map(|_| ros_angles(reference.read(level, FRAC_PI_2, &mut memory.attitude)))
        .collect();
    for (axis, mean, deviation) in [(0, 0.0, 0.002), (1, 0.0, 0.002), (2, -0.05, 0.01)] {
        let values: Vec<f64> = readings.iter().map(|it| it[axis]).collect();
        assert_normal(&values, mean, deviation);
    }
}

#[test]
fn one_instrument_switched_on_changes_no_reading_of_another() {
    let both = Navigation {
        dvl: DVL,
        usbl: USBL,
        ..Navigation::default()
    };
    let alone = Navigation {
        usbl: USBL,
        ..Navigation::default()
    };
    let run = |navigation: &Navigation| {
        let mut memory = memory();
        let level = at([0.0; 3], 1.0, [0.0; 3]);
        let read = |k: i64| navigation.read(&level, None, [k * TICK, TICK], &mut memory);
        (0..100).map(read).collect::<Vec<_>>()
    };
    let (both, alone) = (run(&both), run(&alone));
    assert!(both.iter().zip(&alone).all(|(a, b)| a.usbl == b.usbl));
    assert_eq!(both.iter().filter(|it| it.dvl.is_some()).count(), 25);
    assert!(alone.iter().all(|it| it.dvl.is_none()));
}
