//! Plots as SVG: bars with deviations side by side, and lines.
//!
//! ```text
//!   BarPlot  ─┐                                    panels side by side, one scale each
//!             ├─▶ Sheet: marks, axes, legend ──▶ String
//!   LinePlot ─┘
//! ```

mod axis;
mod bars;
mod lines;
mod sheet;

pub use bars::{Bar, BarPanel, BarPlot};
pub use lines::LinePlot;

/// Colours of the series, in their order; people who see few colours can tell them apart.
const COLOURS: [&str; 8] =
    ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8c8c00", "#444444"];

fn colour(series: usize) -> &'static str {
    COLOURS[series % COLOURS.len()]
}
