//! Eq. (7), Table 8 and the models put right: every recomputed number has its twin here.

mod book;

#[test]
fn every_number_of_the_transfer_functions_comes_out_again() {
    let families = ["Cf1", "Cf2", "eq7", "Tab8", "P2", "P3", "Pz"];
    book::holds(
        &families,
        &plant_sim::book::transfer_functions::recomputed(),
    );
}
