//! Lines over a polygon, as SVG.

use geo::{BoundingRect, LineString, Polygon};
use std::fmt::Write as _;
use terrain::Point;

/// Pixels along the longer side.
const SIDE_PX: f64 = 640.0;

/// The polygon, and each line as wide as a third of the tool in a colour of its own; starts as dots.
pub(super) fn svg(ground: &Polygon<f64>, paths: &[Vec<Point>], tool_width_m: f64) -> String {
    let bounds = ground.bounding_rect().expect("a checked polygon has corners");
    let scale = SIDE_PX / bounds.width().max(bounds.height());
    let (width, height) = (bounds.width() * scale + 2.0, bounds.height() * scale + 2.0);
    let place = |x: f64, y: f64| {
        format!("{:.1},{:.1}", (x - bounds.min().x) * scale + 1.0, (bounds.max().y - y) * scale + 1.0)
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    let ring = |ring: &LineString<f64>| {
        let corners: Vec<String> = ring.coords().map(|corner| place(corner.x, corner.y)).collect();
        format!("M{}Z", corners.join(" "))
    };
    let rings: String = std::iter::once(ground.exterior()).chain(ground.interiors()).map(ring).collect();
    let _ = writeln!(svg, "<path d=\"{rings}\" fill=\"#eee\" fill-rule=\"evenodd\" stroke=\"#222\"/>");
    for (robot, path) in paths.iter().enumerate() {
        let points: Vec<String> = path.iter().map(|point| place(point.x, point.y)).collect();
        let colour = format!("hsl({},75%,42%)", robot * 360 / paths.len());
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{:.2}\"/>",
            points.join(" "),
            tool_width_m * scale / 3.0
        );
        if let Some(start) = path.first() {
            let at = place(start.x, start.y);
            let (x, y) = at.split_once(',').expect("written just now");
            let _ =
                writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"4\" fill=\"{colour}\" stroke=\"#222\"/>");
        }
    }
    svg.push_str("</svg>\n");
    svg
}
