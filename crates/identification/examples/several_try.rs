use planesman_identification::several::*;
use planesman_identification::*;
fn main() {
    // csv: time,u..; args: file inputs outputs
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    let col = |n: &str| {
        let i = head.iter().position(|h| *h == n).unwrap();
        rows.iter().map(|r| r[i]).collect::<Vec<f64>>()
    };
    let t = col("time");
    let ins: Vec<&str> = args[2].split(',').collect();
    let outs: Vec<&str> = args[3].split(',').collect();
    let record = Record::of_run(
        (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64,
        ins.iter().map(|n| (*n, col(n))).collect(),
        outs.iter().map(|n| (*n, col(n))).collect(),
    )
    .unwrap();
    let start = std::time::Instant::now();
    for o in 0..outs.len() {
        match analyse(&record, o, &Options::default()) {
            Ok(a) => println!("{}", a.text()),
            Err(e) => println!("{e}"),
        }
    }
    eprintln!("{:?}", start.elapsed());
}
