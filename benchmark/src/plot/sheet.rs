//! The paper a plot is drawn on: SVG by hand, in pixels.

use super::{axis::Axis, colour};
use std::fmt::Write as _;

/// Height of the frame in which marks stand.
pub(super) const FRAME_HEIGHT_PX: f64 = 240.0;
const ABOVE_PX: f64 = 64.0;
const BELOW_PX: f64 = 48.0;
const LEFT_PX: f64 = 64.0;
const RIGHT_PX: f64 = 16.0;
const LEGEND_ROW_PX: f64 = 20.0;
const LEGEND_PX: f64 = 200.0;

/// A drawing that grows.
pub(super) struct Sheet {
    body: String,
    right_px: f64,
}

/// Where a piece of text hangs.
#[derive(Debug, Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A box with a scale on its left.
pub(super) struct Frame {
    pub(super) left_px: f64,
    pub(super) axis: Axis,
}

impl Frame {
    /// Height of a value in the sheet.
    pub(super) fn y_px(&self, value: f64) -> f64 {
        ABOVE_PX + FRAME_HEIGHT_PX * (1.0 - self.axis.share(value))
    }

    /// Where text below the frame stands.
    pub(super) fn below_px(row: u32) -> f64 {
        ABOVE_PX + FRAME_HEIGHT_PX + 16.0 * f64::from(row + 1)
    }
}

impl Sheet {
    pub(super) fn new() -> Self {
        Self { body: String::new(), right_px: 0.0 }
    }

    /// A frame right of all others, with the lines of its scale.
    pub(super) fn frame(&mut self, title: &str, width_px: f64, axis: Axis) -> Frame {
        let frame = Frame { left_px: self.right_px + LEFT_PX, axis };
        for (value, word) in axis.marks() {
            let y = frame.y_px(value);
            self.line([(frame.left_px, y), (frame.left_px + width_px, y)].into_iter(), "#ddd", 1.0);
            self.text((frame.left_px - 6.0, y + 4.0), Anchor::End, 11, &word);
        }
        self.text((frame.left_px + width_px / 2.0, ABOVE_PX - 12.0), Anchor::Middle, 13, title);
        self.right_px = frame.left_px + width_px + RIGHT_PX;
        frame
    }

    pub(super) fn bar(&mut self, corner: (f64, f64), size: (f64, f64), series: usize, title: &str) {
        let ((x, y), (width, height)) = (corner, size);
        self.add(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{}\"><title>{}</title></rect>",
            colour(series),
            escape(title)
        ));
    }

    pub(super) fn line(&mut self, points: impl Iterator<Item = (f64, f64)>, stroke: &str, width_px: f64) {
        let mut path = String::new();
        for (x, y) in points {
            let _ = write!(path, "{x:.1},{y:.1} ");
        }
        self.add(&format!(
            "<polyline fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width_px}\" points=\"{}\"/>",
            path.trim_end()
        ));
    }

    pub(super) fn text(&mut self, place: (f64, f64), anchor: Anchor, size_px: u32, text: &str) {
        let (x, y) = place;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.add(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size_px}\">{}</text>",
            escape(text)
        ));
    }

    fn add(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// The whole file, with a title above and the names of the series on the right.
    pub(super) fn finish(mut self, title: &str, series: &[String]) -> String {
        let left = self.right_px + 16.0;
        for (number, name) in series.iter().enumerate() {
            let y = ABOVE_PX + number as f64 * LEGEND_ROW_PX;
            self.bar((left, y), (12.0, 12.0), number, name);
            self.text((left + 18.0, y + 11.0), Anchor::Start, 13, name);
        }
        self.text((16.0, 26.0), Anchor::Start, 17, title);
        let width = left + LEGEND_PX;
        let legend = ABOVE_PX + series.len() as f64 * LEGEND_ROW_PX;
        let height = (ABOVE_PX + FRAME_HEIGHT_PX + BELOW_PX).max(legend);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
             height=\"{height:.0}\" font-family=\"sans-serif\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fbfbf9\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// A text in which nothing is markup.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
