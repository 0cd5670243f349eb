//! Figs. 45 to 56: the thesis' fits and the inputs they were made to (Brunner 1988, pp. 99-113), on
//! synthetic records: those of the thesis are lost.

use anyhow::{Result, anyhow};
use sysid::procedure::{self, Comparison, Detrend};
use sysid::synthetic::Run;

use super::figures::Figure;
use crate::plot::{Plot, Series, Style};

/// Every figure, in the thesis' order.
///
/// # Errors
/// When a fit cannot be made.
pub fn figures() -> Result<Vec<Figure>> {
    Ok(vec![
        rate(
            "Fig. 45, run 7/3: pitch rate (synthetic)",
            "1.2 ft/s, four short pulses.",
            Run::SevenThree,
        )?,
        planes("Fig. 46, run 7/3: dive plane command", Run::SevenThree),
        rate(
            "Fig. 47, run 7/5: pitch rate (synthetic)",
            "1.2 ft/s, a square wave; the record is made to begin at zero, not detrended.",
            Run::SevenFive,
        )?,
        planes("Fig. 48, run 7/5: dive plane command", Run::SevenFive),
        rate(
            "Fig. 49, run 8/1: pitch rate (synthetic)",
            "2.1 ft/s; the thesis calls this fit excellent.",
            Run::EightOne,
        )?,
        depth(
            "Fig. 50, run 8/1: depth from pitch rate (synthetic)",
            Run::EightOne,
            [2, 4],
        )?,
        planes("Fig. 51, run 8/1: dive plane command", Run::EightOne),
        rate(
            "Fig. 52, run 9/1: pitch rate (synthetic)",
            "1.8 ft/s, two pulses.",
            Run::NineOne,
        )?,
        depth(
            "Fig. 53, run 9/1: depth from pitch rate (synthetic)",
            Run::NineOne,
            [2, 3],
        )?,
        planes("Fig. 54, run 9/1: dive plane command", Run::NineOne),
        rate(
            "Fig. 55, run 9/2: pitch rate (synthetic)",
            "1.8 ft/s, rapid sinusoid; a good fit here says only that gain and phase at 1.25 Hz match.",
            Run::NineTwo,
        )?,
        planes("Fig. 56, run 9/2: dive plane command", Run::NineTwo),
    ])
}

fn by_sample(values: &[f64]) -> Vec<(f64, f64)> {
    values
        .iter()
        .enumerate()
        .map(|(k, v)| (k as f64, *v))
        .collect()
}

fn drawn(
    title: &'static str,
    note: String,
    y: &'static str,
    series: Vec<Series<'static>>,
) -> Figure {
    Figure {
        note: note.into(),
        plot: Plot {
            title,
            x: "sampling periods of 0.05 s",
            y,
            y_down: false,
            x_shows: &[],
            series,
        },
    }
}

fn planes(title: &'static str, run: Run) -> Figure {
    let series = vec![Series {
        name: "planes",
        points: by_sample(&run.planes()),
        style: Style::Line,
    }];
    drawn(
        title,
        "0.2 V is 20 degrees.".to_owned(),
        "command [V]",
        series,
    )
}

fn rate(title: &'static str, note: &str, run: Run) -> Result<Figure> {
    let (actual, found) = procedure::identify(
        &run.planes(),
        &procedure::pitch_rate(run),
        Detrend::of(run),
        &[2, 3],
    )
    .map_err(|reason| anyhow!(reason))?;
    let note = format!("{note} {}", said(&found));
    Ok(drawn(
        title,
        note,
        "gyro [V]",
        curves(
            &actual,
            &found,
            ["1: actual", "2: second order", "3: third order"],
        ),
    ))
}

fn depth(title: &'static str, run: Run, orders: [usize; 2]) -> Result<Figure> {
    let (actual, found) = procedure::identify(
        &procedure::pitch_rate(run),
        &procedure::depth(run),
        Detrend::Nothing,
        &orders,
    )
    .map_err(|reason| anyhow!(reason))?;
    let names = [
        "1: actual",
        "2: second order",
        if orders[1] == 4 {
            "3: fourth order"
        } else {
            "3: third order"
        },
    ];
    Ok(drawn(
        title,
        said(&found),
        "depth cell [V]",
        curves(&actual, &found, names),
    ))
}

fn curves(actual: &[f64], found: &[Comparison], names: [&'static str; 3]) -> Vec<Series<'static>> {
    let [first, rest @ ..] = names;
    let mut series = vec![Series {
        name: first,
        points: by_sample(actual),
        style: Style::Line,
    }];
    // A model that runs away is drawn as far as the picture goes.
    let most = 3.0 * actual.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    series.extend(found.iter().zip(rest).map(|(it, name)| {
        Series {
            name,
            points: by_sample(&it.simulated)
                .into_iter()
                .filter(|(_, v)| v.abs() <= most)
                .collect(),
            style: Style::Line,
        }
    }));
    series
}

/// Fits and roots, in a sentence.
fn said(found: &[Comparison]) -> String {
    let each: Vec<String> = found
        .iter()
        .map(|it| {
            let fit = it
                .fit
                .map_or("no fit".to_owned(), |fit| format!("{fit:.0} %"));
            let roots: Vec<String> = it
                .model
                .poles()
                .unwrap_or_default()
                .iter()
                .filter(|z| z.im >= 0.0)
                .map(|z| {
                    if z.im == 0.0 {
                        format!("{:.4}", z.re)
                    } else {
                        format!("{:.4} ± {:.4}j", z.re, z.im)
                    }
                })
                .collect();
            format!(
                "order {}: {fit}, roots {}",
                it.model.a.len(),
                roots.join(", ")
            )
        })
        .collect();
    format!("{}.", each.join("; "))
}

#[cfg(test)]
mod tests {
    #[test]
    fn all_twelve_figures_can_be_drawn() {
        let figures = super::figures().expect("fitted");
        assert_eq!(figures.len(), 12);
        for figure in figures {
            assert!(figure.plot.svg().is_ok(), "{}", figure.plot.title);
        }
    }
}
