use planner::*;
use std::path::Path;
use terrain::*;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    f[11].parse::<f64>().unwrap() / 100.0
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let coverage_min: f64 = args[2].parse().unwrap();
    let stations: usize = args[3].parse().unwrap();
    let dir = Path::new("../shared/instances/indoor");
    for name in args[1].split(',') {
        let text = std::fs::read_to_string(dir.join(format!("{name}.stations.json"))).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        let r = &json["robot"];
        let f = |k: &str| r[k].as_f64().unwrap();
        let map = MapFile { metres_per_character: 0.05, square_m: 0.05 }
            .load(dir.join(format!("{name}.yaml")))
            .unwrap();
        let w = f("tool_width_m");
        let floor = Floor::new(&map, w / 2.0, f("radius_m"), w).unwrap();
        for s in 0..stations {
            let st = &json["stations"][s];
            let p = Point::new(st["x_m"].as_f64().unwrap(), st["y_m"].as_f64().unwrap());
            let cell = floor.nearest_drivable(&map, p).expect("cell");
            let start = Start::at(cell);
            let motion = MotionModel {
                speed_m_per_s: f("speed_mps"),
                acceleration_m_per_s2: f64::INFINITY,
                angular_speed_rad_per_s: f("turn_rate_rad_s"),
                angular_acceleration_rad_per_s2: f64::INFINITY,
                brakes: true,
            };
            let mut inst = Instance::whole_floor(&floor, vec![start], motion, Mode::CoverAndReturn);
            inst.coverage_min = coverage_min;
            for planner in args[4].split(',') {
                let t = cpu();
                let o = PlanOptions { planner: planner.to_owned(), ..PlanOptions::default() };
                match plan(&inst, &o) {
                    Ok(p) => {
                        let g = p.figures();
                        println!(
                            "{name} s{s} {planner:22} len {:.0} (lb {:.0}) turns {} cov {:.4} overlap {:.3} time {:.0} cpu {:.2}",
                            g.length_m[0],
                            json["area_over_tool_width_m"].as_f64().unwrap(),
                            g.turns[0],
                            g.coverage_ratio,
                            g.overlap_ratio,
                            g.makespan_s,
                            cpu() - t
                        );
                        if let Some(file) = args.get(5) {
                            use std::fmt::Write;
                            let mut svg = String::new();
                            let h = floor.lattice().rows as f64 * w / 2.0;
                            let wd = floor.lattice().columns as f64 * w / 2.0;
                            let k = 30.0;
                            write!(svg,"<svg xmlns='http://www.w3.org/2000/svg' width='{}' height='{}'><rect width='100%' height='100%' fill='white'/>",wd*k,h*k).unwrap();
                            let o = floor.lattice().origin;
                            let res = map.resolution_m();
                            let (cx, cy) = ((wd / res) as i64, (h / res) as i64);
                            for y in 0..cy {
                                for x in 0..cx {
                                    if !map.is_free(x, y) {
                                        write!(
                                            svg,
                                            "<rect x='{}' y='{}' width='{}' height='{}' fill='#888'/>",
                                            x as f64 * res * k,
                                            (h - (y + 1) as f64 * res) * k,
                                            res * k,
                                            res * k
                                        )
                                        .unwrap();
                                    }
                                }
                            }
                            write!(svg, "<polyline fill='none' stroke='#05c' stroke-width='2' points='")
                                .unwrap();
                            for q in &p.routes()[0].points {
                                write!(svg, "{:.1},{:.1} ", (q.x - o.x) * k, (h - (q.y - o.y)) * k).unwrap();
                            }
                            write!(svg, "'/></svg>").unwrap();
                            std::fs::write(file, svg).unwrap();
                        }
                    }
                    Err(e) => println!("{name} s{s} {planner}: {e}"),
                }
            }
        }
    }
}
