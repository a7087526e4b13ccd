//! wip
#![allow(dead_code)]
mod directions;
mod fragments;
mod line_sweep;
mod merging;
mod msa;
mod raster;
