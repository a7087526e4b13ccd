use planner::isograph::*;
use terrain::Point;
fn load(n: &str) -> (Vec<Vec<Point>>, serde_json::Value) {
    let t = std::fs::read_to_string(format!("/work/wt/shared/instances/mcfs/{n}.json")).unwrap();
    let v: serde_json::Value = serde_json::from_str(&t).unwrap();
    let ring = |r: &serde_json::Value| -> Vec<Point> { r.as_array().unwrap().iter().map(|p| Point::new(p[0].as_f64().unwrap(), p[1].as_f64().unwrap())).collect() };
    let mut rings = vec![ring(&v["polygon"]["exterior"])];
    rings.extend(v["polygon"]["holes"].as_array().unwrap().iter().map(ring));
    (rings, v)
}
fn stats(p: &[Point]) -> (f64, f64, f64) {
    let n = p.len();
    let mut len = 0.0; let mut turn = 0.0; let mut maxt: f64 = 0.0;
    for i in 0..n {
        let (a, b, c) = (p[(i + n - 1) % n], p[i], p[(i + 1) % n]);
        len += (c - b).norm();
        let (u, v) = (b - a, c - b);
        let t = u.perp(&v).atan2(u.dot(&v)).abs();
        turn += t; maxt = maxt.max(t);
    }
    (len, turn / len, maxt.to_degrees())
}
fn main() {
    for n in ["I", "C", "A", "P", "S", "double_torus", "office"] {
        let (rings, _) = load(n);
        for s in [Selector::Random, Selector::Cfs, Selector::Mcs] {
            let p = single(&rings, 0.1, s, 1);
            let (l, t, m) = stats(&p);
            println!("{n} {s:?}: points {} length {l:.2} turning {t:.3} max {m:.0}", p.len());
        }
    }
}
