//! A polygon with holes to be covered by round tools from given starts.

use geo::{Area, Contains, Coord, Distance, Euclidean, LineString, Polygon};
use terrain::{Point, RingError, RingName, check_rings, rings};
use thiserror::Error;

/// Ground to cover, the robots' disc, and where they stand. Each route begins and ends at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonInstance {
    /// The ground, metres in the map frame.
    pub ground: Polygon<f64>,
    /// Diameter of the tool's disc, metres.
    pub tool_width_m: f64,
    /// Radius of the body's disc, metres; never smaller than half the tool for the paper's instances.
    pub body_radius_m: f64,
    /// Where the robots stand.
    pub starts: Vec<Point>,
}

/// Why a polygon cannot be covered as it is given.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum PolygonError {
    /// Its rings bound no ground.
    #[error(transparent)]
    Rings(#[from] RingError),
    /// A width that is no number above 0.
    #[error("`{name}` is {value}: expected a finite number of metres above 0")]
    Width {
        /// Which width.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// Nobody to drive.
    #[error("there is no robot: give at least one start")]
    NoRobots,
    /// A start that is not on the ground.
    #[error("robot {robot} starts outside the polygon, beside {ring} near corner {vertex}")]
    StartOutside {
        /// Number of the robot.
        robot: usize,
        /// The nearest ring.
        ring: RingName,
        /// First corner of the nearest edge.
        vertex: usize,
    },
    /// A start so near to a wall that the robot does not fit.
    #[error(
        "robot {robot} starts {distance_m:.3} m from {ring} near corner {vertex}; it needs {least_m:.3} m"
    )]
    StartTooNear {
        /// Number of the robot.
        robot: usize,
        /// Its distance.
        distance_m: f64,
        /// What it needs.
        least_m: f64,
        /// The nearest ring.
        ring: RingName,
        /// First corner of the nearest edge.
        vertex: usize,
    },
    /// Nowhere wide enough.
    #[error("a disc of {width_m} m fits nowhere between the rings: take a narrower tool")]
    TooWide {
        /// Diameter of tool or body, whichever is larger.
        width_m: f64,
    },
}

impl PolygonInstance {
    /// How near a robot's middle may come to a wall, metres: neither body nor tool may leave the ground.
    pub fn clearance_m(&self) -> f64 {
        self.body_radius_m.max(self.tool_width_m / 2.0)
    }

    /// Area to be covered, square metres.
    pub fn area_m2(&self) -> f64 {
        self.ground.unsigned_area()
    }

    /// Every ring with its name.
    pub fn rings(&self) -> impl Iterator<Item = (RingName, &LineString<f64>)> {
        rings(&self.ground)
    }

    /// Refuses what cannot be covered as it is.
    ///
    /// # Errors
    ///
    /// [`PolygonError`], naming the first ring and corner, width or robot that is wrong.
    pub fn check(&self) -> Result<(), PolygonError> {
        for (name, value) in [("tool_width_m", self.tool_width_m), ("body_radius_m", self.body_radius_m)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PolygonError::Width { name, value });
            }
        }
        check_rings(&self.ground)?;
        if self.starts.is_empty() {
            return Err(PolygonError::NoRobots);
        }
        (0..self.starts.len()).try_for_each(|robot| self.check_start(robot))
    }

    fn check_start(&self, robot: usize) -> Result<(), PolygonError> {
        let start = Coord { x: self.starts[robot].x, y: self.starts[robot].y };
        let (ring, vertex, distance_m) = self.nearest_edge(start);
        if !self.ground.contains(&start) {
            return Err(PolygonError::StartOutside { robot, ring, vertex });
        }
        let least_m = self.clearance_m();
        if distance_m < least_m - 1e-6 {
            return Err(PolygonError::StartTooNear { robot, distance_m, least_m, ring, vertex });
        }
        Ok(())
    }

    /// The edge nearest to a place: its ring, its first corner, and how far it is.
    fn nearest_edge(&self, place: Coord<f64>) -> (RingName, usize, f64) {
        let place = geo::Point::from(place);
        self.rings()
            .flat_map(|(ring, line)| {
                line.lines()
                    .enumerate()
                    .map(move |(vertex, edge)| (ring, vertex, Euclidean.distance(&place, &edge)))
            })
            .min_by(|a, b| a.2.total_cmp(&b.2))
            .expect("a polygon has edges")
    }
}
