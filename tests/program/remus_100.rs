//! Another vehicle in the whole loop: the scenario `remus_100`, composed in one process.
use planesman_flight::compose::{Loop, Tick};
use planesman_flight::model_summary::{ModelSummary, identified};
use planesman_flight::scenario::Scenario;
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_vehicle::{linearised, vehicle_file};

/// The scenario's flight with a test signal of that amplitude.
fn flown(amplitude: &str) -> Vec<Tick> {
    let change = format!("depth_controller.identification.amplitude={amplitude}");
    let scenario = Scenario::load_with("remus_100", &[change]).unwrap();
    Loop::new(&scenario)
        .unwrap()
        .map(|tick| tick.unwrap())
        .collect()
}

fn last_model(ticks: &[Tick]) -> ModelSummary {
    let mut models = ticks.iter().rev().flat_map(|t| t.models.iter().rev());
    identified(models.find(|model| model.valid).unwrap())
}

/// The pair that the vehicle about level flight has, 0.392 + 0.389i, from the vehicle file.
fn true_pair() -> Complex<f64> {
    let model = linearised::true_model(&vehicle_file::remus_100(), 1.54, 0.05).unwrap();
    let pair = model.continuous_poles.iter().find(|p| p.im > 0.0);
    *pair.unwrap()
}

#[test]
fn the_remus_100_goes_down_to_five_metres_stays_there_and_its_unstable_pair_is_identified() {
    let ticks = flown("0.0001");
    let depths: Vec<f64> = ticks.iter().map(|t| t.observation.state.depth).collect();
    let arrived = depths.iter().position(|depth| *depth > 4.9).unwrap();
    assert!(arrived < 400, "within 20 s: {arrived}");
    for depth in &depths[600..] {
        assert!((depth - 5.0).abs() < 0.05, "{depth}");
    }

    let truth = true_pair();
    assert!(truth.re > 0.0, "it diverges without its controller");
    let error = (last_model(&ticks).dominant().unwrap() - truth).modulus() / truth.modulus();
    assert!(error < 0.02, "{error}");
}

#[test]
fn moved_by_two_degrees_its_square_law_damping_hides_the_linear_model() {
    let ticks = flown("0.0349");
    // 188 N m s^2/rad^2 at the turns it makes now, as the secant of a Gaussian turn, is more than
    // the 3 N m s/rad of the linear model.
    let turns: Vec<f64> = ticks[800..]
        .iter()
        .map(|t| t.observation.state.pitch_rate)
        .collect();
    let square = turns.iter().map(|q| q * q).sum::<f64>() / turns.len() as f64;
    let secant = 188.0 * (8.0 / std::f64::consts::PI * square).sqrt();
    assert!(secant > 3.08, "{secant}");
    let found = last_model(&ticks).dominant().unwrap();
    let truth = true_pair();
    assert!((found - truth).modulus() > 0.5 * truth.modulus(), "{found}");
}
