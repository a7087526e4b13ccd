//! What is to be planned: read from a scenario, or put together from options.

use super::MapArgs;
use ::sim::{RobotEntry, Scenario};
use anyhow::{Context, Error, Result, anyhow, bail};
use planner::{Instance, Mode, PlanError, Start};
use std::{path::Path, str::FromStr, sync::Arc};
use terrain::{Floor, GridMap, MapFile, MotionModel, Point};

/// A floor, robots on it, and how they are to cover it.
#[derive(Debug)]
pub struct Task {
    pub floor: Arc<Floor>,
    pub robots: Vec<Robot>,
    pub motion: MotionModel,
    pub mode: Mode,
    pub planner: String,
}

/// One robot.
#[derive(Debug)]
pub struct Robot {
    pub id: String,
    pub start: Start,
}

/// A start as it is given: metres, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    position: Point,
    heading_rad: Option<f64>,
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || "expected X,Y or X,Y,THETA: finite numbers, metres and radians".to_owned();
        let numbers: Vec<f64> = text
            .split(',')
            .map(|word| word.trim().parse::<f64>().ok().filter(|number| number.is_finite()))
            .collect::<Option<_>>()
            .ok_or_else(refused)?;
        match numbers[..] {
            [x, y] => Ok(Self { position: Point::new(x, y), heading_rad: None }),
            [x, y, theta] => Ok(Self { position: Point::new(x, y), heading_rad: Some(theta) }),
            _ => Err(refused()),
        }
    }
}

impl Task {
    /// The floor and robots of a scenario, as its mission would be planned at the start.
    ///
    /// # Errors
    ///
    /// When the scenario is refused, or a robot starts where it cannot stand.
    pub fn of_scenario(path: &Path) -> Result<Self> {
        let scenario = Scenario::load(path)?;
        let file = &scenario.file;
        let robot = |entry: &RobotEntry| {
            let place = Place {
                position: Point::new(entry.x_m, entry.y_m),
                heading_rad: Some(entry.theta_deg.to_radians()),
            };
            let start = start_at(&scenario.map, &scenario.floor, place)
                .with_context(|| format!("{}: robot `{}`", path.display(), entry.id))?;
            Ok(Robot { id: entry.id.clone(), start })
        };
        Ok(Self {
            robots: file.robots.iter().map(robot).collect::<Result<_>>()?,
            floor: Arc::clone(&scenario.floor),
            motion: file.robot.motion(),
            mode: if file.mission.return_to_start { Mode::CoverAndReturn } else { Mode::Cover },
            planner: file.mission.planner.clone(),
        })
    }

    /// A floor and robots from options.
    ///
    /// # Errors
    ///
    /// When the map cannot be read, the robot fits nowhere, or a start is not on free ground.
    pub fn on_map(args: &MapArgs) -> Result<Self> {
        let path = args.map.as_deref().context("--map FILE is missing")?;
        let tool_width_m = args.tool_width_m.context("--tool-width-m D is missing")?;
        let cell_m = args.cell_m.map_or_else(|| default_cell_m(tool_width_m), Ok)?;
        let body_radius_m = args.body_radius_m.unwrap_or(0.35 * cell_m);
        let map =
            MapFile { metres_per_character: args.metres_per_char, square_m: cell_m / 8.0 }.load(path)?;
        let floor = Floor::new(&map, cell_m, body_radius_m, tool_width_m).with_context(|| {
            format!(
                "{}: a tool of {tool_width_m} m with a body of radius {body_radius_m:.3} m does not fit; give a \
                 narrower --tool-width-m, or a smaller --cell-m or --body-radius-m",
                path.display()
            )
        })?;
        if !floor.tool_fits(&map, tool_width_m) {
            bail!(
                "{}: a tool of {tool_width_m} m is wider than every passage; give a narrower --tool-width-m",
                path.display()
            );
        }
        let robot = |(number, place): (usize, &Place)| {
            let start = start_at(&map, &floor, *place).with_context(|| {
                format!("--start {},{} (robot {})", place.position.x, place.position.y, number + 1)
            })?;
            Ok(Robot { id: format!("r{}", number + 1), start })
        };
        Ok(Self {
            robots: args.start.iter().enumerate().map(robot).collect::<Result<_>>()?,
            floor: Arc::new(floor),
            motion: motion(args),
            mode: Mode::Cover,
            planner: "tmstc-star".to_owned(),
        })
    }

    /// All of the floor that the robots can reach.
    pub fn instance(&self) -> Instance<'_> {
        let starts = self.robots.iter().map(|robot| robot.start).collect();
        Instance::whole_floor(&self.floor, starts, self.motion, self.mode)
    }

    /// A planner's refusal, in the words of the command line.
    pub fn explain(&self, error: PlanError) -> Error {
        match error {
            PlanError::UnknownPlanner(_) => anyhow!("--planner: {error}"),
            _ => Error::new(error).context(format!("no plan by `{}`", self.planner)),
        }
    }
}

fn motion(args: &MapArgs) -> MotionModel {
    MotionModel {
        speed_m_per_s: args.speed_m_per_s,
        acceleration_m_per_s2: args.acceleration_m_per_s2,
        angular_speed_rad_per_s: args.turn_rad_per_s,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    }
}

/// The largest cell that a disc of the tool's diameter covers from its centre, in whole millimetres.
fn default_cell_m(tool_width_m: f64) -> Result<f64> {
    let cell_m = (tool_width_m / std::f64::consts::SQRT_2 * 1000.0 + 1e-9).floor() / 1000.0;
    if cell_m <= 0.0 {
        bail!("--tool-width-m {tool_width_m} is below 1.5 mm: give a wider tool, or --cell-m");
    }
    Ok(cell_m)
}

fn start_at(map: &GridMap, floor: &Floor, place: Place) -> Result<Start> {
    let (x, y) = (place.position.x, place.position.y);
    if !map.point_is_free(place.position) {
        let (low, high) = (map.origin(), map.corner());
        bail!(
            "({x}, {y}) is in a wall or off the map, which reaches from ({:.2}, {:.2}) to ({:.2}, {:.2}); choose a \
             free place",
            low.x,
            low.y,
            high.x,
            high.y
        );
    }
    let own = floor.lattice().cell_at(place.position).filter(|&cell| floor.cell_is_drivable(cell));
    let cell = own.or_else(|| floor.nearest_drivable(map, place.position)).with_context(|| {
        let radius_m = floor.body_radius_m();
        format!(
            "a body of radius {radius_m:.3} m cannot stand near ({x}, {y}); choose a place farther from walls"
        )
    })?;
    Ok(Start { heading_rad: place.heading_rad, ..Start::at(cell) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_two_or_three_finite_numbers() {
        let place: Place = "1.5, -2,0.5".parse().unwrap();
        assert_eq!(place, Place { position: Point::new(1.5, -2.0), heading_rad: Some(0.5) });
        for text in ["NaN,1", "1", "1,inf", "", "1,2,3,4", "a,b"] {
            assert!(text.parse::<Place>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_tool_covers_a_default_cell_from_its_centre() {
        let cell_m = default_cell_m(0.75).unwrap();
        assert!(cell_m * std::f64::consts::SQRT_2 <= 0.75 && cell_m > 0.529);
        assert!(default_cell_m(0.0001).is_err());
    }

    #[test]
    fn a_start_in_a_wall_is_refused() {
        let map = GridMap::from_drawing("...#\n...#", 0.5).unwrap();
        let floor = Floor::new(&map, 0.5, 0.2, 0.75).unwrap();
        let place = Place { position: Point::new(1.75, 0.25), heading_rad: None };
        assert!(start_at(&map, &floor, place).unwrap_err().to_string().contains("in a wall"));
    }
}
