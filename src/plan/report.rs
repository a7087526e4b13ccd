//! A plan as it is printed: the JSON object of `docs/plan-format.md`, and a table for people.

use super::task::Task;
use planner::{Route, VerifiedPlan, area_bound_s, lower_bound_s, planners::keeps_to_lattice};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use terrain::Point;

/// The format of this object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Format {
    /// The first.
    #[serde(rename = "oxplow-plan/1")]
    V1,
}

/// A plan and its figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanReport {
    /// Version of this object's format.
    pub format: Format,
    /// The planner that made the plan.
    pub planner: String,
    /// Time until the last robot is done, seconds.
    pub makespan_s: f64,
    /// Time spent planning and checking, seconds.
    pub planning_s: f64,
    /// No plan along the lattice can be done sooner, seconds; for planners that leave it, no plan at all.
    pub lower_bound_s: f64,
    /// Area that the tool sweeps from where the robots get to, square metres.
    pub coverable_m2: f64,
    /// Area that the tool would sweep, but no moves of the lattice lead there (a door is too narrow), square metres.
    pub out_of_reach_m2: f64,
    /// Free ground that the tool touches from no cell's centre, square metres.
    pub untouchable_m2: f64,
    /// Area swept, as a share of the area to be swept.
    pub coverage_ratio: f64,
    /// Cells entered again, as a share of cells entered.
    pub overlap_ratio: f64,
    /// Turns in place of all robots.
    pub turns: u32,
    /// One entry per robot.
    pub robots: Vec<RobotReport>,
}

/// What one robot is to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotReport {
    /// Its id.
    pub id: String,
    /// Where its path begins: x and y in metres, heading in radians (null: free).
    pub start: (f64, f64, Option<f64>),
    /// Time it needs, seconds.
    pub cost_s: f64,
    /// Way it drives, metres.
    pub length_m: f64,
    /// Its turns in place.
    pub turns: u32,
    /// Its path, metres: straight lines between these places.
    pub path: Vec<[f64; 2]>,
}

impl PlanReport {
    /// Puts a plan and its figures together.
    pub fn new(task: &Task, plan: &VerifiedPlan, planning_s: f64) -> Self {
        let figures = plan.figures();
        let robots = task.robots.iter().enumerate().map(|(number, robot)| {
            let center = task.floor.lattice().center(robot.start.cell);
            RobotReport {
                id: robot.id.clone(),
                start: (center.x, center.y, robot.start.heading_rad),
                cost_s: figures.cost_s[number],
                length_m: figures.length_m[number],
                turns: figures.turns[number],
                path: corners(&plan.routes()[number]),
            }
        });
        let instance = task.instance();
        let coverable_m2 = task.floor.coverable_from_m2(&instance.visit);
        let bound_s = if keeps_to_lattice(plan.planner()) {
            lower_bound_s(&instance)
        } else {
            area_bound_s(&instance, coverable_m2)
        };
        Self {
            format: Format::V1,
            planner: plan.planner().to_owned(),
            makespan_s: figures.makespan_s,
            planning_s,
            lower_bound_s: bound_s,
            coverable_m2,
            out_of_reach_m2: (task.floor.coverable_m2() - coverable_m2).max(0.0),
            untouchable_m2: task.floor.untouchable_m2(),
            coverage_ratio: figures.coverage_ratio,
            overlap_ratio: figures.overlap_ratio,
            turns: figures.turns.iter().sum(),
            robots: robots.collect(),
        }
    }
}

/// The places of a route at which it changes its direction, and its ends.
fn corners(route: &Route) -> Vec<[f64; 2]> {
    let mut kept: Vec<Point> = Vec::new();
    for &point in &route.points {
        if kept.last().is_some_and(|last| (point - last).norm() < 1e-9) {
            continue;
        }
        if let [.., before, last] = kept[..]
            && goes_straight(before, last, point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept.iter().map(|point| [point.x, point.y]).collect()
}

fn goes_straight(from: Point, via: Point, to: Point) -> bool {
    let (first, second) = ((via - from).normalize(), (to - via).normalize());
    first.perp(&second).abs() < 1e-9 && first.dot(&second) > 0.0
}

impl fmt::Display for PlanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "planner      {}", self.planner)?;
        let which = if keeps_to_lattice(&self.planner) { "no plan along the lattice" } else { "no plan" };
        writeln!(f, "makespan     {:.1} s ({which} can beat {:.1} s)", self.makespan_s, self.lower_bound_s)?;
        writeln!(f, "planned in   {:.3} s", self.planning_s)?;
        writeln!(f, "coverable    {:.1} m²", self.coverable_m2)?;
        if self.out_of_reach_m2 > 0.0 {
            writeln!(f, "out of reach {:.1} m² behind ways too narrow for the body", self.out_of_reach_m2)?;
        }
        writeln!(
            f,
            "untouchable  {:.1} m² of free ground that the tool touches from no cell",
            self.untouchable_m2
        )?;
        writeln!(f, "coverage     {:.2} % of what the tool can reach", 100.0 * self.coverage_ratio)?;
        writeln!(f, "overlap      {:.2} %", 100.0 * self.overlap_ratio)?;
        writeln!(f, "turns        {}", self.turns)?;
        writeln!(f)?;
        write!(f, "{:<8} {:>16} {:>10} {:>10} {:>6}", "robot", "start", "time s", "way m", "turns")?;
        for robot in &self.robots {
            let start = format!("{:.2}, {:.2}", robot.start.0, robot.start.1);
            write!(f, "\n{:<8} {start:>16} {:>10.1}", robot.id, robot.cost_s)?;
            write!(f, " {:>10.1} {:>6}", robot.length_m, robot.turns)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doc(name: &str) -> std::path::PathBuf {
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name)
    }

    #[test]
    fn the_example_of_the_document_is_read() {
        let text = std::fs::read_to_string(doc("plan-format.md")).unwrap();
        let example = text.split("```json").nth(1).unwrap().split("```").next().unwrap();
        let report: PlanReport = serde_json::from_str(example).unwrap();
        assert_eq!(report.robots[0].path.len(), 3);
    }

    #[test]
    fn the_schema_of_the_documents_is_that_of_the_types() {
        let schema = serde_json::to_string_pretty(&schemars::schema_for!(PlanReport)).unwrap() + "\n";
        if std::env::var_os("OXPLOW_WRITE_SCHEMA").is_some() {
            std::fs::write(doc("plan.schema.json"), &schema).unwrap();
        }
        assert_eq!(std::fs::read_to_string(doc("plan.schema.json")).unwrap(), schema);
    }

    #[test]
    fn a_path_keeps_its_corners_and_its_way_back() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 0.0)];
        let route = Route::new(points.map(|(x, y)| Point::new(x, y)).to_vec());
        assert_eq!(corners(&route), [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 0.0]]);
    }
}
