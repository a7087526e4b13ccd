//! A polygon with holes to be covered by round tools from given starts.

use geo::{Area, Contains, Coord, Distance, Euclidean, Intersects, Line, LineString, LinesIter, Polygon};
use std::fmt;
use terrain::Point;
use thiserror::Error;

/// Area below which a ring counts as having none, square metres.
const NO_AREA_M2: f64 = 1e-12;

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

/// Which ring of a polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RingName {
    /// The outer one.
    Exterior,
    /// A hole, by its number from 0.
    Hole(usize),
}

impl fmt::Display for RingName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exterior => write!(f, "the exterior ring"),
            Self::Hole(number) => write!(f, "hole {number}"),
        }
    }
}

/// Why a polygon cannot be covered as it is given.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum PolygonError {
    /// A corner that is no number.
    #[error("corner {vertex} of {ring} is not finite: give metres")]
    NotFinite {
        /// Which ring.
        ring: RingName,
        /// Number of the corner.
        vertex: usize,
    },
    /// Fewer than three corners, or no area between them.
    #[error("{ring} encloses no area: give at least three corners that are not on one line")]
    NoArea {
        /// Which ring.
        ring: RingName,
    },
    /// A ring that crosses or touches itself.
    #[error(
        "{ring} meets itself: its edge from corner {vertex} and the one from corner {other}; part it there"
    )]
    MeetsItself {
        /// Which ring.
        ring: RingName,
        /// First corner of one edge.
        vertex: usize,
        /// First corner of the other.
        other: usize,
    },
    /// A hole that is not inside the exterior ring.
    #[error("corner {vertex} of hole {hole} is not inside the exterior ring: move or drop the hole")]
    HoleOutside {
        /// Number of the hole.
        hole: usize,
        /// Number of the corner.
        vertex: usize,
    },
    /// Two rings that touch or cross.
    #[error("{ring} touches {other} at its edge from corner {vertex}: join the two or move them apart")]
    RingsTouch {
        /// Which ring.
        ring: RingName,
        /// The other.
        other: RingName,
        /// First corner of the edge of the first.
        vertex: usize,
    },
    /// A hole within a hole.
    #[error("hole {hole} lies in hole {within}: drop the inner one")]
    HoleInHole {
        /// The inner hole.
        hole: usize,
        /// The outer hole.
        within: usize,
    },
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
        let holes = self.ground.interiors().iter().enumerate();
        std::iter::once((RingName::Exterior, self.ground.exterior()))
            .chain(holes.map(|(number, ring)| (RingName::Hole(number), ring)))
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
        for (ring, line) in self.rings() {
            check_ring(ring, line)?;
        }
        self.check_holes()?;
        if self.starts.is_empty() {
            return Err(PolygonError::NoRobots);
        }
        (0..self.starts.len()).try_for_each(|robot| self.check_start(robot))
    }

    fn check_holes(&self) -> Result<(), PolygonError> {
        let outline = Polygon::new(self.ground.exterior().clone(), Vec::new());
        let rings: Vec<_> = self.rings().collect();
        for (number, &(ring, line)) in rings.iter().enumerate() {
            for &(other, before) in &rings[..number] {
                if let Some(vertex) = line.lines().position(|edge| edge.intersects(before)) {
                    return Err(PolygonError::RingsTouch { ring, other, vertex });
                }
            }
        }
        for (hole, line) in self.ground.interiors().iter().enumerate() {
            if let Some(vertex) = line.0.iter().position(|corner| !outline.contains(corner)) {
                return Err(PolygonError::HoleOutside { hole, vertex });
            }
            let is_within = |other: &LineString<f64>| {
                !std::ptr::eq(other, line) && Polygon::new(other.clone(), Vec::new()).contains(&line.0[0])
            };
            if let Some(within) = self.ground.interiors().iter().position(is_within) {
                return Err(PolygonError::HoleInHole { hole, within });
            }
        }
        Ok(())
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

fn check_ring(ring: RingName, line: &LineString<f64>) -> Result<(), PolygonError> {
    if let Some(vertex) = line.0.iter().position(|corner| !(corner.x.is_finite() && corner.y.is_finite())) {
        return Err(PolygonError::NotFinite { ring, vertex });
    }
    if let Some((vertex, other)) = first_meeting(line) {
        return Err(PolygonError::MeetsItself { ring, vertex, other });
    }
    if Polygon::new(line.clone(), Vec::new()).unsigned_area() < NO_AREA_M2 {
        return Err(PolygonError::NoArea { ring });
    }
    Ok(())
}

/// Two edges of a ring that meet elsewhere than at the corner they share. Repeated corners are no fault.
fn first_meeting(line: &LineString<f64>) -> Option<(usize, usize)> {
    let edges: Vec<(usize, Line<f64>)> =
        line.lines_iter().enumerate().filter(|(_, edge)| edge.start != edge.end).collect();
    let last = edges.len().saturating_sub(1);
    for (number, (vertex, edge)) in edges.iter().enumerate() {
        for (later, (other, far)) in edges.iter().enumerate().skip(number + 1) {
            let meets = if later == number + 1 {
                folds_back(edge, far)
            } else if number == 0 && later == last {
                folds_back(far, edge)
            } else {
                edge.intersects(far)
            };
            if meets {
                return Some((*vertex, *other));
            }
        }
    }
    None
}

/// Whether the second of two edges that share a corner runs back along the first.
fn folds_back(first: &Line<f64>, second: &Line<f64>) -> bool {
    let (a, b) = (first.delta(), second.delta());
    let cross = a.x * b.y - a.y * b.x;
    cross.abs() <= 1e-12 * (a.x.hypot(a.y) * b.x.hypot(b.y)) && a.x * b.x + a.y * b.y < 0.0
}
