//! 3-D view of a flight: the track, and the vehicle with its fins and thrusters as lines, which the reader can turn.

use maud::{Markup, PreEscaped, html};
use planesman_flight::flight::{Points, TimeHistories};
use planesman_flight::scenario::Scenario;
use planesman_plant::{Outline, PlantParameters};
use serde_json::json;

/// The script that draws the view.
pub(crate) const SCRIPT: &str = include_str!("space_view.js");

/// The style of the view.
pub(crate) const STYLE: &str = "
.space canvas { width: 100%; max-width: 60rem; aspect-ratio: 8 / 5; background: var(--surface); touch-action: none; cursor: grab; }
.space .controls { display: flex; gap: .8rem; align-items: center; max-width: 60rem; margin: .3rem 0; }
.space input { flex: 1; accent-color: var(--accent); }
.space output { font-variant-numeric: tabular-nums; }
";

/// Number of instants of the view.
const INSTANTS: u32 = 400;

/// The value at a time: the value of the last point before this time; 0 without points.
pub(crate) fn held(points: &Points, t: f64) -> f64 {
    let behind = points.partition_point(|p| p.0 <= t);
    let at = points.get(behind.saturating_sub(1));
    at.map_or(0.0, |p| p.1)
}

/// The vehicle's pose at evenly spaced instants: time \[s\]; along, to starboard, down \[m\]; roll, pitch, yaw \[rad\].
pub(crate) fn instants(drawn: &TimeHistories) -> Vec<[f64; 7]> {
    let (Some(first), Some(last)) = (drawn.depth.first(), drawn.depth.last()) else {
        return Vec::new();
    };
    let at = |k: u32| {
        let t = first.0 + (last.0 - first.0) * f64::from(k) / f64::from(INSTANTS);
        let [x, y] = [&drawn.place[0], &drawn.place[1]].map(|it| held(it, t));
        let [z, roll, pitch, yaw] =
            [&drawn.depth, &drawn.roll, &drawn.pitch, &drawn.yaw].map(|it| held(it, t));
        [t, x, y, z, roll, pitch, yaw]
    };
    (0..=INSTANTS).map(at).collect()
}

/// Whether the vehicle left its vertical plane.
pub(crate) fn leaves_the_plane(drawn: &TimeHistories) -> bool {
    [&drawn.roll, &drawn.yaw, &drawn.place[1]]
        .iter()
        .any(|points| points.iter().any(|(_, value)| value.abs() > 1e-9))
}

/// The view, for a flight that leaves the vertical plane; nothing if the scenario's vehicle cannot be loaded.
pub(crate) fn view(name: Option<&str>, drawn: &TimeHistories, scenario: &Scenario) -> Markup {
    let parameters = scenario.parameters_of::<PlantParameters>("plant_sim");
    let outline = parameters.ok().and_then(|it| Outline::load(&it).ok());
    let (Some(outline), true) = (outline, leaves_the_plane(drawn)) else {
        return html! {};
    };
    let round = |x: f64| (1e4 * x).round() / 1e4;
    let rows: Vec<_> = instants(drawn).iter().map(|row| row.map(round)).collect();
    let data = json!({ "instants": rows, "lines": outline.lines });
    html! {
        figure.space {
            h2 { "In space" @if let Some(name) = name { ": " (name) } }
            canvas width="960" height="600" role="img" aria-label="Space view of the vehicle and its track; drag to turn the view" {}
            div.controls {
                button type="button" { "Closer" }
                input type="range" min="0" max=(INSTANTS) value=(INSTANTS) aria-label="time";
                output {}
            }
            p { "Drag to turn the view. North is the direction of the initial heading; the horizontal frame is at the deepest point." }
            script type="application/json" { (PreEscaped(data.to_string())) }
        }
    }
}
