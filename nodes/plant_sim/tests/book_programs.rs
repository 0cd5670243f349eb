//! Programs T2 to T5 of Brunner 1988: every recomputed number has its twin here.

mod book;

#[test]
fn every_number_of_the_programs_comes_out_again() {
    let families = [
        "A1",
        "C1",
        "C2",
        "T2",
        "T3",
        "T4",
        "T5",
        "T2dim",
        "T2dim_sin",
        "T2dim_inch",
        "T2dim_inch23",
        "T3dim",
        "T3dim_sin",
        "T4dim",
        "T5dim_sin",
    ];
    book::holds(&families, &plant_sim::book::programs::recomputed());
}
