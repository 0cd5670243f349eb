use planesman_circuit::*;
use std::sync::Arc;
fn main() {
    let mut c = file::parse(file::BUILT_IN[0].1).unwrap();
    c.valves.scatter = 0.0;
    let a: Vec<String> = std::env::args().collect();
    let acc: f64 = a[1].parse().unwrap();
    if let Some(l) = a.get(2) { c.control.law = Law::ALL.iter().find(|x| x.0 == l).unwrap().1; }
    let c = Arc::new(c);
    let point = |time, position| Point { time, position, force: 500.0 };
    let cycle = LoadCycle::new(vec![point(0.0, -0.1), point(1.0, 0.1), point(1.5, 0.1), point(2.5, -0.1), point(3.0, -0.1)]).unwrap();
    let t = std::time::Instant::now();
    let print = a.len() > 3;
    let f = run(&c, &cycle, acc, 1, |t, r| if print { println!("{t} {} {} {} {}", r[0], r[1], r[2], r[3]) });
    eprintln!("{:?} {:#?}", t.elapsed(), f);
    eprintln!("residual {:e}", f.ledger.residual() / f.ledger.turnover());
}
