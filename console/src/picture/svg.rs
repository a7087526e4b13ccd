//! SVG by hand: metres in, pixels out, y turned over.

use std::fmt::Write;
use terrain::Point;

const FLOOR_PX: f64 = 1000.0;
const MARGIN_PX: f64 = 20.0;
const TITLE_PX: f64 = 50.0;
const LEGEND_PX: f64 = 170.0;
const LEGEND_ROW_PX: f64 = 22.0;

/// A drawing of the floor that grows.
pub(super) struct Canvas {
    low: Point,
    high: Point,
    px_per_m: f64,
    body: String,
}

impl Canvas {
    /// A drawing of the box between two corners, metres.
    pub(super) fn new(low: Point, high: Point) -> Self {
        let size = high - low;
        Self { low, high, px_per_m: FLOOR_PX / size.x.max(size.y), body: String::new() }
    }

    fn px(&self, point: Point) -> (f64, f64) {
        (
            MARGIN_PX + (point.x - self.low.x) * self.px_per_m,
            TITLE_PX + (self.high.y - point.y) * self.px_per_m,
        )
    }

    /// Boxes of one colour, given by their corners.
    pub(super) fn boxes(
        &mut self,
        boxes: impl Iterator<Item = (Point, Point)>,
        fill: &str,
        opacity: f64,
        title: &str,
    ) {
        let mut path = String::new();
        for (low, high) in boxes {
            let ((x0, y0), (x1, y1)) = (self.px(low), self.px(high));
            let _ = write!(path, "M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}z");
        }
        if !path.is_empty() {
            let title = title_of(title);
            self.add(&format!(
                "<path shape-rendering=\"crispEdges\" fill=\"{fill}\" fill-opacity=\"{opacity}\" d=\"{path}\">\
                 {title}</path>"
            ));
        }
    }

    /// A line through points.
    pub(super) fn line(&mut self, points: impl Iterator<Item = Point>, stroke: &str, width_m: f64) {
        let mut path = String::new();
        for point in points {
            let (x, y) = self.px(point);
            let _ = write!(path, "{x:.1},{y:.1} ");
        }
        let width = (width_m * self.px_per_m).max(1.0);
        self.add(&format!(
            "<polyline fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width:.1}\" stroke-linejoin=\"round\" \
             points=\"{}\"/>",
            path.trim_end()
        ));
    }

    /// A disc with a dark rim.
    pub(super) fn disc(&mut self, centre: Point, radius_m: f64, fill: &str, title: &str) {
        let (x, y) = self.px(centre);
        let radius = (radius_m * self.px_per_m).max(3.0);
        let title = title_of(title);
        self.add(&format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" stroke=\"#222\">{title}</circle>"
        ));
    }

    /// A small text beside a place.
    pub(super) fn label(&mut self, place: Point, text: &str) {
        let (x, y) = self.px(place);
        let (x, y, text) = (x + 6.0, y - 6.0, escape(text));
        for halo in [" stroke=\"#fff\" stroke-width=\"3\"", ""] {
            self.add(&format!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"12\"{halo}>{text}</text>"));
        }
    }

    fn add(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// The whole file, with a title above and a legend (colour, escaped text) on the right.
    pub(super) fn finish(mut self, title: &str, figure: &str, legend: &[(String, String)]) -> String {
        let size = (self.high - self.low) * self.px_per_m;
        let left = MARGIN_PX + size.x + MARGIN_PX;
        for (row, (fill, text)) in legend.iter().enumerate() {
            let y = TITLE_PX + row as f64 * LEGEND_ROW_PX;
            self.add(&format!(
                "<rect x=\"{left:.0}\" y=\"{y:.0}\" width=\"14\" height=\"14\" fill=\"{fill}\"/>\
                 <text x=\"{:.0}\" y=\"{:.0}\" font-size=\"13\">{text}</text>",
                left + 20.0,
                y + 12.0
            ));
        }
        let width = left + LEGEND_PX;
        let rows = TITLE_PX + legend.len() as f64 * LEGEND_ROW_PX;
        let height = (TITLE_PX + size.y).max(rows) + MARGIN_PX;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fbfbf9\"/>\n\
             <text x=\"{MARGIN_PX}\" y=\"32\" font-size=\"20\">{}</text>\n\
             <text x=\"{left:.0}\" y=\"32\" font-size=\"16\" font-weight=\"bold\">{}</text>\n{}</svg>\n",
            escape(title),
            escape(figure),
            self.body
        )
    }
}

fn title_of(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<title>{}</title>", escape(text)) }
}

/// A text in which nothing is markup.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            character if character.is_control() => escaped.push(' '),
            character => escaped.push(character),
        }
    }
    escaped
}
