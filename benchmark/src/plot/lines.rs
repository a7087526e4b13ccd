//! Lines: one thing against another, a line per series.

use super::{
    axis::Axis,
    colour,
    sheet::{Anchor, Frame, Sheet},
};

const WIDTH_PX: f64 = 480.0;

/// Lines in one frame. Both scales begin at 0.
#[derive(Debug, Clone, PartialEq)]
pub struct LinePlot {
    /// Stands above.
    pub title: String,
    /// What lies along the lower side, with its unit.
    pub across: String,
    /// What goes up, with its unit.
    pub up: String,
    /// Name and points of each line.
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

impl LinePlot {
    /// Draws it.
    pub fn svg(&self) -> String {
        let points = || self.series.iter().flat_map(|(_, points)| points);
        let across = Axis::up_to(points().map(|point| point.0).fold(0.0, f64::max));
        let up = Axis::up_to(points().map(|point| point.1).fold(0.0, f64::max));
        let mut sheet = Sheet::new();
        let frame = sheet.frame(&self.up, WIDTH_PX, up);
        let x_px = |value: f64| frame.left_px + WIDTH_PX * across.share(value);
        for (value, word) in across.marks() {
            sheet.text((x_px(value), Frame::below_px(0)), Anchor::Middle, 11, &word);
        }
        let middle = frame.left_px + WIDTH_PX / 2.0;
        sheet.text((middle, Frame::below_px(1)), Anchor::Middle, 12, &self.across);
        for (number, (_, points)) in self.series.iter().enumerate() {
            sheet.line(points.iter().map(|&(x, y)| (x_px(x), frame.y_px(y))), colour(number), 2.0);
        }
        let names: Vec<String> = self.series.iter().map(|(name, _)| name.clone()).collect();
        sheet.finish(&self.title, &names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_its_points() {
        let plot = LinePlot {
            title: "Covered".to_owned(),
            across: "time, s".to_owned(),
            up: "share".to_owned(),
            series: vec![("10 people".to_owned(), vec![(0.0, 0.0), (50.0, 0.5), (100.0, 1.0)])],
        };
        assert!(plot.svg().contains("points=\"64.0,304.0 304.0,184.0 544.0,64.0\""), "{}", plot.svg());
    }
}
