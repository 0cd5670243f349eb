//! The files that say what is flown or fitted: a scenario, a vehicle, an actuator, equations.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_flight::scenario::Scenario;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = planesman_text::decoded(data) else {
        return;
    };
    if let Ok(scenario) = Scenario::parse(text) {
        let _ = scenario.ticks();
        scenario
            .parameter_file("/auv", &[], true)
            .expect("a scenario that was taken can be written");
    }
    let _ = planesman_vehicle::vehicle_file::parse("fuzz", text);
    if let Ok(file) = planesman_equations::text_of(text) {
        let _ = planesman_equations::Equations::new(file);
    }
    let _ = planesman_hydraulics::actuator_file::of_text("fuzz", text);
});
