//! Monte Carlo.
use planesman_identification::several::*;
use planesman_identification::*;
fn telegraph(seed: u32, count: usize) -> Vec<f64> {
    let mut level = 1.0;
    let draws = noise(seed, count);
    (0..count)
        .map(|k| {
            if k % 5 == 0 && draws[k] > 0.0 {
                level = -level;
            }
            level
        })
        .collect()
}
fn main() {
    let runs: u32 = std::env::args().nth(1).unwrap().parse().unwrap();
    for (label, n, size, pole) in [
        ("white", 600usize, 0.2, 0.0),
        ("ar 0.8", 600, 0.1, 0.8),
        ("ar 0.9", 1000, 0.06, 0.9),
    ] {
        let mut cover = [[0usize; 4]; 2];
        let mut present = [0usize; 3];
        let mut right = 0;
        let mut count = 0;
        let mut secs = 0.0;
        let mut verdicts = std::collections::BTreeMap::new();
        for seed in 0..runs {
            let (u, v, w) = (
                telegraph(seed * 7 + 1, n + 50),
                telegraph(seed * 7 + 2, n + 50),
                telegraph(seed * 7 + 3, n + 50),
            );
            let a = filter(&[0.0, 0.0, 0.0, 0.2], &[1.0, -0.9], &u);
            let b = filter(&[0.0, -0.05, -0.005], &[1.0, -1.6, 0.71], &v);
            let e = filter(&[size], &[1.0, -pole], &noise(seed * 7 + 4, n + 50));
            let y: Vec<f64> = (50..n + 50).map(|k| a[k] + b[k] + e[k] + 3.0).collect();
            let cut = |x: &Vec<f64>| x[50..].to_vec();
            let record = Record::of_run(
                0.5,
                vec![("u", cut(&u)), ("v", cut(&v)), ("w", cut(&w))],
                vec![("y", y)],
            )
            .unwrap();
            let start = std::time::Instant::now();
            let Ok(found) = analyse(&record, 0, &Options::default()) else {
                println!("seed {seed} refused");
                continue;
            };
            secs += start.elapsed().as_secs_f64();
            count += 1;
            *verdicts.entry(format!("{:?}", found.verdict)).or_insert(0) += 1;
            for i in 0..3 {
                present[i] += usize::from(found.inputs[i].model.is_some());
            }
            let s: Vec<_> = found
                .structures()
                .iter()
                .map(|c| (c.input, c.order(), c.delay()))
                .collect();
            right += usize::from(s == [(0, 1, 3), (1, 2, 1)]);
            for (i, gain, slow, delay) in [(0usize, 2.0, 0.9, 3i64), (1, -0.5, 0.8, 1)] {
                let Some(m) = &found.inputs[i].model else {
                    continue;
                };
                let r = m.reading();
                if let Some(g) = r.steady_state_gain() {
                    cover[i][0] +=
                        usize::from((g.value.re - gain).abs() < SIGMAS_95 * g.real_deviation());
                }
                let p = r.slowest_first().unwrap();
                if let Some(p) = p.first() {
                    cover[i][1] +=
                        usize::from((p.value.re - slow).abs() < SIGMAS_95 * p.real_deviation());
                }
                if let Some(l) = m.lag {
                    cover[i][2] += usize::from(l.interval.0 <= delay && delay <= l.interval.1);
                }
                let step = r.uncertain_step_response(30);
                let truth: f64 = if i == 0 {
                    2.0 * (1.0 - 0.9f64.powi(20 - 2))
                } else {
                    filter(&[0.0, -0.05, -0.005], &[1.0, -1.6, 0.71], &vec![1.0; 30])[20]
                };
                cover[i][3] += usize::from((step[20].0 - truth).abs() < SIGMAS_95 * step[20].1);
            }
        }
        println!(
            "{label}: {count} runs, {:.3} s each, structure right {right}, present {present:?}",
            secs / f64::from(runs)
        );
        for i in 0..2 {
            let p = |k: usize| 100.0 * cover[i][k] as f64 / present[i] as f64;
            println!(
                "   channel {i}: gain {:.1} slow pole {:.1} delay {:.1} step {:.1} %",
                p(0),
                p(1),
                p(2),
                p(3)
            );
        }
        println!("   {verdicts:?}");
    }
}
