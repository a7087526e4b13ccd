//! Smooth coverage of polygons by many robots (MCFS): the types that all its parts share.
//!
//! ```text
//!   PolygonInstance ──▶ tracks ──▶ one closed tour ──▶ k closed tours ──▶ Plan (one closed line per robot)
//! ```

mod polygon_instance;

pub use polygon_instance::{PolygonError, PolygonInstance, RingName};
