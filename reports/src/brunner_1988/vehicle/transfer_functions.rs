//! Eq. (7), Table 8, and the corrected models: P2 and P3 (pitch rate), Pz (depth).

use planesman_linear::{Complex, ComplexFunctions as _, Error, TransferFunction};

use planesman_units::FOOT;
use planesman_vehicle::vehicle_file::brunner;

use crate::brunner_1988::predicted::{
    self, CF1, CF2, D2_ANOMALY, DepthRate, PRINTED, PitchAlone, SAMPLING_TIME, table_8,
};

/// Names and values of entries.
type Entries = Vec<(&'static str, f64)>;

/// Values of the families Cf1, Cf2, eq7, Tab8, P2, P3 and Pz.
#[must_use]
pub(super) fn recomputed() -> Entries {
    let mut all = vec![("Cf1", CF1), ("Cf2", CF2)];
    // A model that cannot be formed gives no values, which the check of the book reports.
    for part in [
        equation_7(),
        table_8(),
        pitch_alone(),
        pitch_rate(),
        depth(),
    ] {
        all.extend(part.unwrap_or_default());
    }
    all
}

/// Coefficients, highest power first, paired with their names.
fn named<const N: usize>(names: [&'static str; N], values: &[f64]) -> Entries {
    names.into_iter().zip(values.iter().copied()).collect()
}

fn equation_7() -> Result<Entries, Error> {
    let mut all = named(["eq7.A", "eq7.B", "eq7.C", "eq7.D"], &PRINTED.denominator());
    all.extend(named(["eq7.E", "eq7.F"], &PRINTED.numerator()));
    all.extend(named(
        ["eq7.D1", "eq7.D2", "eq7.D3"],
        &PRINTED.depth_denominator(),
    ));

    macro_rules! numerator {
        ($suffix:literal, $depth_rate:expr) => {
            named(
                [
                    concat!("eq7.N1_", $suffix),
                    concat!("eq7.N2_", $suffix),
                    concat!("eq7.N3_", $suffix),
                    concat!("eq7.N4_", $suffix),
                ],
                &PRINTED.depth_numerator($depth_rate),
            )
        };
    }
    let as_printed = |feet_per_second| DepthRate::AsPrinted { feet_per_second };
    all.extend(numerator!("U1", as_printed(1.0)));
    all.extend(numerator!("U1.2", as_printed(1.2)));
    all.extend(numerator!("U1.8", as_printed(1.8)));
    all.extend(numerator!("U2.1", as_printed(2.1)));
    all.extend(numerator!("U1_signfix", DepthRate::Corrected));

    // The real pole first, then the pair, the lower one first.
    let mut poles = PRINTED.pitch_rate()?.poles()?;
    poles.sort_by(|p, q| p.re.total_cmp(&q.re).then(p.im.total_cmp(&q.im)));
    for (pole, names) in poles.iter().zip([
        ["eq7.pole0.re", "eq7.pole0.im"],
        ["eq7.pole1.re", "eq7.pole1.im"],
        ["eq7.pole2.re", "eq7.pole2.im"],
    ]) {
        all.extend(named(names, &[pole.re, pole.im]));
    }
    Ok(all)
}

fn table_8() -> Result<Entries, Error> {
    let q2 = table_8::pitch_rate_second_order(PitchAlone::TABLE_8.restoring)?;
    let q2_roots = q2.poles()?;
    let q2_me_as_written = table_8::pitch_rate_second_order(0.16)?.poles()?;
    let q3 = table_8::pitch_rate_third_order()?;
    let q3_roots = q3.poles()?;
    let real = |roots: &[Complex<f64>]| roots.iter().find(|r| r.im == 0.0).map(|r| r.re);
    let upper = |roots: &[Complex<f64>]| roots.iter().find(|r| r.im > 0.0).copied();

    let mut all = vec![
        ("Tab8.q2.b", q2.num[1]),
        ("Tab8.q2.a1", q2.den[1]),
        ("Tab8.q2.a2", q2.den[2]),
        ("Tab8.q2.r1", q2_roots[0].re),
        ("Tab8.q2.r2", q2_roots[1].re),
        ("Tab8.q2.r1_Me.16", q2_me_as_written[0].re),
        ("Tab8.q2.r2_Me.16", q2_me_as_written[1].re),
        ("Tab8.q3.gain", table_8::pitch_rate_gain()),
        ("Tab8.z2.b", table_8::depth_second_order()),
        ("Tab8.z4.gain", table_8::depth_gain()),
    ];
    all.extend(named(
        ["Tab8.q3.b1", "Tab8.q3.b2", "Tab8.q3.b3"],
        &q3.num[1..],
    ));
    all.extend(named(
        ["Tab8.q3.a1", "Tab8.q3.a2", "Tab8.q3.a3"],
        &q3.den[1..],
    ));
    all.extend(real(&q3_roots).map(|r| ("Tab8.q3.r_real", r)));
    if let Some(r) = upper(&q3_roots) {
        all.extend([("Tab8.q3.r_re", r.re), ("Tab8.q3.r_im", r.im)]);
    }

    macro_rules! fourth_order {
        ($speed:literal) => {{
            let printed = table_8::depth_as_printed($speed)?;
            let formula = table_8::depth_fourth_order($speed, 1.0)?;
            all.extend(named(
                [
                    concat!("Tab8.z4.U", $speed, ".b1"),
                    concat!("Tab8.z4.U", $speed, ".b2"),
                    concat!("Tab8.z4.U", $speed, ".b3"),
                    concat!("Tab8.z4.U", $speed, ".b4"),
                ],
                &printed.num[1..],
            ));
            all.extend(named(
                [
                    concat!("Tab8.z4.U", $speed, ".b1_formula"),
                    concat!("Tab8.z4.U", $speed, ".b2_formula"),
                    concat!("Tab8.z4.U", $speed, ".b3_formula"),
                    concat!("Tab8.z4.U", $speed, ".b4_formula"),
                ],
                &formula.num[1..],
            ));
        }};
    }
    fourth_order!(1.2);
    fourth_order!(1.8);
    fourth_order!(2.1);

    all.extend(named(
        ["Tab8.z4.a1", "Tab8.z4.a2", "Tab8.z4.a3", "Tab8.z4.a4"],
        &table_8::depth_as_printed(1.2)?.den[1..],
    ));
    all.extend(named(
        ["Tab8.z4.r1", "Tab8.z4.r2"],
        &sampled_depth_poles(D2_ANOMALY)?,
    ));
    all.extend(named(
        ["Tab8.z4.r1_formula", "Tab8.z4.r2_formula"],
        &sampled_depth_poles(1.0)?,
    ));
    Ok(all)
}

/// The two poles of (7b) other than its double integrator, in the z plane, the faster one first.
fn sampled_depth_poles(d2_factor: f64) -> Result<[f64; 2], Error> {
    let [d1, d2, d3] = PRINTED.depth_denominator();
    let quadratic = TransferFunction::new(vec![1.0], vec![d1, d2_factor * d2, d3])?;
    let poles = quadratic.poles()?;
    Ok([poles[1], poles[0]].map(|s| (s * SAMPLING_TIME).exp().re))
}

/// `NAME.b1` and following, `NAME.a1` and following: coefficients of a sampled transfer function after the leading 0 and 1.
macro_rules! coefficients {
    ($name:literal, $g:ident, $($i:literal)+) => {
        named([$(concat!($name, ".b", $i)),+], &$g.num[1..])
            .into_iter()
            .chain(named([$(concat!($name, ".a", $i)),+], &$g.den[1..]))
    };
}

fn pitch_alone() -> Result<Entries, Error> {
    let mut all = Vec::new();
    macro_rules! at {
        ($name:literal, $speed:expr) => {{
            let model = PitchAlone::at($speed);
            let g = model.volts()?.zero_order_hold(SAMPLING_TIME)?;
            all.extend(coefficients!($name, g, "1" "2"));
            all.push((concat!($name, ".gain_norest"), model.free_gain()));
            all.push((concat!($name, ".BJ"), model.free_decay()));
        }};
    }
    at!("P2.U1", 1.0);
    at!("P2.U1.2", 1.2);
    at!("P2.U1.8", 1.8);
    at!("P2.U2.1", 2.1);
    Ok(all)
}

fn pitch_rate() -> Result<Entries, Error> {
    let vehicle = predicted::with_the_rounded_restoring_moment(&brunner());
    let mut all = Vec::new();
    macro_rules! at {
        ($name:literal, $speed:expr) => {{
            let g = predicted::pitch_rate_in_volts(&vehicle, $speed * FOOT, SAMPLING_TIME)?;
            all.extend(coefficients!($name, g, "1" "2" "3"));
        }};
    }
    at!("P3.U1", 1.0);
    at!("P3.U1.2", 1.2);
    at!("P3.U1.8", 1.8);
    at!("P3.U2.1", 2.1);
    Ok(all)
}

fn depth() -> Result<Entries, Error> {
    let vehicle = predicted::with_the_rounded_restoring_moment(&brunner());
    let mut all = Vec::new();
    macro_rules! at {
        ($name:literal, $speed:expr) => {{
            let g = predicted::depth_in_volts(&vehicle, $speed * FOOT, SAMPLING_TIME)?;
            all.extend(coefficients!($name, g, "1" "2" "3" "4"));
        }};
    }
    at!("Pz.U1.2", 1.2);
    at!("Pz.U1.8", 1.8);
    at!("Pz.U2.1", 2.1);
    Ok(all)
}
