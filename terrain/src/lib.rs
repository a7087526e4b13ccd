//! What is to be covered: maps, the lattice of cells over them, footprints, and the motion that sweeps them.
//!
//! Everything is said in one frame, `map`: metres, x right, y up, headings anticlockwise from x in radians.
//!
//! ```text
//!   map file ──▶ GridMap ──▶ Floor (for one body and one tool)
//!   .map, YAML+PGM,  free or      cells a robot may stand on, moves between them,
//!   GeoJSON          blocked      and what of each cell the tool can reach
//!                    squares               │
//!                                          ▼
//!                              SweptRaster: 64 samples a cell, set by the tool's disc
//! ```
//!
//! This crate knows nobody: no planner, no robot, no wire.

mod cell;
mod floor;
mod footprint;
mod grid_map;
mod lattice;
mod map_file;
mod motion;
mod movingai;
mod passages;
mod polygon;
mod rings;
mod ros_map;
mod segment;
mod stretch;

pub use cell::{Cell, Direction};
pub use floor::{CellClass, Floor, FloorError};
pub use footprint::{SAMPLES_PER_CELL, SweptRaster, for_each_swept, samples_swept_from};
pub use grid_map::{GridMap, MapError};
pub use lattice::Lattice;
pub use map_file::{FILE_BYTES_MAX, MapFile, MapFileError};
pub use motion::{MotionModel, angle_between};
pub use movingai::parse_movingai;
pub use passages::{Passage, Passages};
pub use polygon::{CORNERS_MAX, Polygons};
pub use rings::{RingError, RingName, check_rings, rings};
pub use segment::Segment;
pub use stretch::{CORNER_RAD, CUT_M, Speeds, Stretch};

/// A place in the `map` frame, metres.
pub type Point = nalgebra::Point2<f64>;
/// A difference of two places in the `map` frame, metres.
pub type Vector = nalgebra::Vector2<f64>;
/// A place and a heading: `map_from_robot`.
pub type Pose = nalgebra::Isometry2<f64>;
