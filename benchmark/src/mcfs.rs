//! The polygon instances of the MCFS paper: loaded, planned, evaluated.

pub mod evaluator;
pub mod polygon_instances;
