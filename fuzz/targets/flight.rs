//! The bag of a dive, whole or damaged: what the report and the replay make of it.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use planesman_flight::flight::Flight;
use planesman_flight::scenario::Scenario;
use planesman_flight::summary::Summary;
use planesman_fuzz::InMemory;
use planesman_show::pages::flights::{FlightReport, page};

static SCENARIO: LazyLock<Scenario> = LazyLock::new(|| Scenario::load("dive").expect("built in"));

fuzz_target!(|data: &[u8]| {
    let file = InMemory::file(data);
    let Ok(flight) = Flight::read(&file.path()) else {
        return;
    };
    // A bag without a state has nothing to tell; any other has a page.
    if let Ok(summary) = Summary::new(&flight, &SCENARIO) {
        let flown = FlightReport {
            name: "flight".to_owned(),
            flight,
            scenario: SCENARIO.clone(),
            summary,
            counts: Default::default(),
            is_counted: false,
        };
        assert!(page(&[flown]).ends_with("</html>"));
    }
});
