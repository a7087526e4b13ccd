//! The plan as an SVG: the floor, one coloured line per robot, a dot where it starts.

use super::{report::PlanReport, task::Task};
use std::fmt::Write;
use terrain::CellClass;

const COLOURS: [&str; 8] =
    ["#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd", "#8c564b", "#e377c2", "#17becf"];

/// Draws a plan; y is up, so everything stands in a mirrored group.
pub fn draw(task: &Task, report: &PlanReport) -> String {
    let lattice = task.floor.lattice();
    let (width, height) =
        (f64::from(lattice.columns) * lattice.cell_m, f64::from(lattice.rows) * lattice.cell_m);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.3} {height:.3}\" width=\"1000\">\n\
         <rect width=\"{width:.3}\" height=\"{height:.3}\" fill=\"#ffffff\"/>\n\
         <g transform=\"translate({:.3} {:.3}) scale(1 -1)\">\n",
        -lattice.origin.x,
        height + lattice.origin.y,
    );
    draw_ground(task, &mut svg);
    draw_routes(task, report, &mut svg);
    svg.push_str("</g>\n</svg>\n");
    svg
}

fn draw_ground(task: &Task, svg: &mut String) {
    let lattice = task.floor.lattice();
    for y in 0..lattice.rows as usize {
        let class = |x: usize| task.floor.class(y * lattice.columns as usize + x);
        let mut x = 0;
        while x < lattice.columns as usize {
            let from = x;
            while x < lattice.columns as usize && class(x) == class(from) {
                x += 1;
            }
            if let Some(colour) = colour_of(class(from)) {
                let (left, bottom) = (
                    lattice.origin.x + from as f64 * lattice.cell_m,
                    lattice.origin.y + y as f64 * lattice.cell_m,
                );
                let (width, height) = ((x - from) as f64 * lattice.cell_m, lattice.cell_m);
                let place = format!("x=\"{left:.3}\" y=\"{bottom:.3}\"");
                let _ = writeln!(
                    svg,
                    "<rect {place} width=\"{width:.3}\" height=\"{height:.3}\" fill=\"{colour}\"/>"
                );
            }
        }
    }
}

fn colour_of(class: CellClass) -> Option<&'static str> {
    match class {
        CellClass::Coverable => None,
        CellClass::TooNarrow => Some("#d9d9d9"),
        CellClass::Obstacle => Some("#444444"),
    }
}

fn draw_routes(task: &Task, report: &PlanReport, svg: &mut String) {
    let line = 0.15 * task.floor.lattice().cell_m;
    for (robot, colour) in report.robots.iter().zip(COLOURS.iter().cycle()) {
        let points: Vec<String> = robot.path.iter().map(|[x, y]| format!("{x:.3},{y:.3}")).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{line:.4}\"/>",
            points.join(" ")
        );
        let (x, y, _) = robot.start;
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{:.4}\" fill=\"{colour}\"><title>{}</title></circle>",
            2.0 * line,
            robot.id
        );
    }
}
