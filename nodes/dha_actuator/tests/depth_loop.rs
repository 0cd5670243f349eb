//! probe
#![allow(clippy::unwrap_used)]
use dha_actuator::{actuator_file::load, dha::{Dha, Demand}};

fn run(leak: f64, m_theta: f64) {
    let set = load("auv").unwrap();
    let mut dha = Dha::new(&set);
    let (mut th, mut q, mut z) = (0.0f64, 0.0f64, 0.0f64);
    let ts = 50_000_000i64;
    let zc = 3.0;
    let (mut lo, mut hi, mut plo, mut phi, mut sum, mut n, mut p0, mut p60) = (1e9f64,-1e9f64,1e9f64,-1e9f64,0.0,0.0,0,0);
    let mut t95 = 0.0;
    let mut zmax: f64 = 0.0;
    let deriv = |th: f64, q: f64, d: f64| (q, (0.14*d - 0.06*q - m_theta*th.sin())/0.6, th.sin());
    for k in 0..10_000i64 {
        let t = k*ts;
        let thc = (0.25*(zc - z) - 0.6*th.sin()).clamp(-45f64.to_radians(), 45f64.to_radians());
        let dc = (0.7*(thc-th) - 2.0*q).clamp(-30f64.to_radians(), 30f64.to_radians());
        if k == 5000 { p0 = dha.pulses(); }
        if k == 1200 { p60 = dha.pulses(); }
        let mut a0 = dha.plane_angle(&dha.reading(t));
        for j in 1..=50 {
            let tt = t + j*1_000_000;
            dha.advance_to(tt, Demand{leakage_scale: leak, ..Demand::angle(dc)});
            let a1 = dha.plane_angle(&dha.reading(tt));
            let d = 0.5*(a0+a1); a0=a1;
            let h=0.001;
            let k1=deriv(th,q,d); let k2=deriv(th+h*k1.0,q+h*k1.1,d);
            th+=h*0.5*(k1.0+k2.0); q+=h*0.5*(k1.1+k2.1); z+=h*0.5*(k1.2+k2.2);
            let tm = tt as f64/1e9;
            if (z-zc).abs() > 0.05*zc { t95 = tm; }
            zmax = zmax.max(z);
            if k >= 5000 { let e=(z-zc)*12.0; lo=lo.min(e); hi=hi.max(e); sum+=e; n+=1.0; plo=plo.min(a1); phi=phi.max(a1);}
        }
    }
    println!("leak {leak} Mth {m_theta}: pp {:.5} mean {:.6} plane {:.4} pulses/s {:.4} os {:.4}% t95 {:.3} npul60 {}", hi-lo, sum/n, (phi-plo).to_degrees(), (dha.pulses()-p0) as f64/250.0, (zmax/zc-1.0)*100.0, t95, p60);
}
#[test]
fn probe() {
    let t = std::time::Instant::now();
    run(0.0, 0.0); run(1.0, 0.0); run(0.0, 0.163); run(1.0, 0.163);
    println!("{:?}", t.elapsed());
}
