//! Are the rings of a polygon sound? Says which ring and which corner is wrong.

use geo::{Area, Contains, Intersects, Line, LineString, LinesIter, Polygon};
use std::fmt;
use thiserror::Error;

/// Area below which a ring counts as having none, square metres.
const NO_AREA_M2: f64 = 1e-12;

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

/// Why rings do not bound ground.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum RingError {
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
}

/// Every ring of a polygon with its name.
pub fn rings(polygon: &Polygon<f64>) -> impl Iterator<Item = (RingName, &LineString<f64>)> {
    let holes = polygon.interiors().iter().enumerate();
    std::iter::once((RingName::Exterior, polygon.exterior()))
        .chain(holes.map(|(number, ring)| (RingName::Hole(number), ring)))
}

/// Refuses a polygon whose rings cross, touch, enclose nothing, or lie in one another in the wrong way. Every pair of
/// edges is looked at.
///
/// # Errors
///
/// [`RingError`], naming the first ring and corner that is wrong.
pub fn check_rings(polygon: &Polygon<f64>) -> Result<(), RingError> {
    rings(polygon).try_for_each(|(ring, line)| check_ring(ring, line))?;
    check_holes(polygon)
}

fn check_holes(polygon: &Polygon<f64>) -> Result<(), RingError> {
    let outline = Polygon::new(polygon.exterior().clone(), Vec::new());
    let rings: Vec<_> = rings(polygon).collect();
    for (number, &(ring, line)) in rings.iter().enumerate() {
        for &(other, before) in &rings[..number] {
            if let Some(vertex) = line.lines().position(|edge| edge.intersects(before)) {
                return Err(RingError::RingsTouch { ring, other, vertex });
            }
        }
    }
    for (hole, line) in polygon.interiors().iter().enumerate() {
        if let Some(vertex) = line.0.iter().position(|corner| !outline.contains(corner)) {
            return Err(RingError::HoleOutside { hole, vertex });
        }
        let is_within = |other: &LineString<f64>| {
            !std::ptr::eq(other, line) && Polygon::new(other.clone(), Vec::new()).contains(&line.0[0])
        };
        if let Some(within) = polygon.interiors().iter().position(is_within) {
            return Err(RingError::HoleInHole { hole, within });
        }
    }
    Ok(())
}

fn check_ring(ring: RingName, line: &LineString<f64>) -> Result<(), RingError> {
    if let Some(vertex) = line.0.iter().position(|corner| !(corner.x.is_finite() && corner.y.is_finite())) {
        return Err(RingError::NotFinite { ring, vertex });
    }
    if let Some((vertex, other)) = first_meeting(line) {
        return Err(RingError::MeetsItself { ring, vertex, other });
    }
    check_area(ring, line)
}

/// Refuses a ring that encloses nothing: the one fault that the quick test of `geo` lets pass.
pub(crate) fn check_area(ring: RingName, line: &LineString<f64>) -> Result<(), RingError> {
    let area_m2 = Polygon::new(line.clone(), Vec::new()).unsigned_area();
    if area_m2 < NO_AREA_M2 { Err(RingError::NoArea { ring }) } else { Ok(()) }
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
