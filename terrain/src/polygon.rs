//! Floors given as polygons with holes, in metres: GeoJSON, or plain `{"polygon": {"exterior": …, "holes": …}}`.
//!
//! ```text
//!   +--------+      ........     a square is free when it lies wholly inside: the parity of the
//!   |  +--+  |      ..####..     crossings to its left says whether its middle does, and no
//!   |  +--+  |      ..####..     edge may pass through it
//!   +--------+      ........
//! ```

use crate::{
    GridMap, MapError, Point,
    rings::{check_area, check_rings, rings},
};
use geo::{BoundingRect, Coord, CoordsIter, LineString, LinesIter, MultiPolygon, Polygon, Validation};
use geojson::{GeoJson, GeometryValue};
use serde::Deserialize;

/// The most corners that all rings may have together: testing them is not linear.
pub const CORNERS_MAX: usize = 20_000;
/// The farthest from the origin that a corner may lie, metres.
const FARTHEST_M: f64 = 1e6;
/// The share of a square by which an edge must enter it to block it: an edge along a border blocks neither side.
const GRAZE: f64 = 1e-6;

/// Free ground as polygons with holes, in metres; every ring was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygons(MultiPolygon<f64>);

type Ring = Vec<[f64; 2]>;

#[derive(Deserialize)]
struct PlainPolygon {
    exterior: Ring,
    #[serde(default)]
    holes: Vec<Ring>,
}

#[derive(Deserialize)]
struct PlainFile {
    polygon: PlainPolygon,
}

impl Polygons {
    /// Reads GeoJSON (a polygon or multipolygon, also as features) or the plain form. Coordinates are metres in
    /// the `map` frame, not degrees.
    ///
    /// # Errors
    ///
    /// [`MapError::Format`] with the line, or with the ring that is wrong.
    pub fn parse(bytes: &[u8]) -> Result<Self, MapError> {
        let refused =
            |error: serde_json::Error| MapError::Format { line: error.line(), what: error.to_string() };
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(refused)?;
        let polygons = if value.get("polygon").is_some() {
            vec![plain(serde_json::from_value::<PlainFile>(value).map_err(refused)?.polygon)]
        } else if value.get("exterior").is_some() {
            vec![plain(serde_json::from_value(value).map_err(refused)?)]
        } else {
            of_geojson(GeoJson::from_reader(bytes).map_err(refused)?)?
        };
        Self::new(MultiPolygon::new(polygons))
    }

    /// Takes polygons whose rings are sound: finite, at least three corners, no crossing, holes inside.
    ///
    /// # Errors
    ///
    /// [`MapError::Rings`], naming ring and corner, or [`MapError::Format`], saying what is wrong.
    pub fn new(polygons: MultiPolygon<f64>) -> Result<Self, MapError> {
        if polygons.0.is_empty() {
            return Err(format_error("there is no polygon in it"));
        }
        let corners = polygons.coords_count();
        if corners > CORNERS_MAX {
            return Err(format_error(format!(
                "{corners} corners; at most {CORNERS_MAX} are taken: simplify it"
            )));
        }
        // Also refuses NaN.
        let near = |number: f64| number.abs() <= FARTHEST_M;
        if let Some(corner) = polygons.coords_iter().find(|corner| !(near(corner.x) && near(corner.y))) {
            let what = format!(
                "corner ({}, {}) is not within {FARTHEST_M} m: metres are expected",
                corner.x, corner.y
            );
            return Err(format_error(what));
        }
        polygons.check_validation().map_err(|error| unsound(&polygons, &error.to_string()))?;
        for (polygon, of_polygon) in polygons.iter().enumerate() {
            let checked = rings(of_polygon).try_for_each(|(ring, line)| check_area(ring, line));
            checked.map_err(|source| MapError::Rings { polygon, source })?;
        }
        Ok(Self(polygons))
    }

    /// The polygons themselves.
    pub fn geometry(&self) -> &MultiPolygon<f64> {
        &self.0
    }

    /// Lays the polygons out in squares of side `square_m`; a square is free when it lies wholly inside.
    ///
    /// # Errors
    ///
    /// [`MapError`], when there are too many squares, or none is free.
    pub fn rasterise(&self, square_m: f64) -> Result<GridMap, MapError> {
        if !(square_m.is_finite() && square_m > 0.0) {
            let expected = "the side of a square in metres, a finite number above 0";
            return Err(MapError::Value { key: "resolution", value: square_m.to_string(), expected });
        }
        let bounds = self.0.bounding_rect().ok_or(MapError::NothingFree)?;
        let count = |length: f64| ((length / square_m) - GRAZE).ceil().max(1.0) as u64;
        let (columns, rows) = (count(bounds.width()), count(bounds.height()));
        GridMap::check_size(columns, rows)?;
        let mut squares = Squares::new(columns as usize, rows as usize);
        for edge in self.0.lines_iter() {
            let scaled = |corner: Coord<f64>| Coord {
                x: (corner.x - bounds.min().x) / square_m,
                y: (corner.y - bounds.min().y) / square_m,
            };
            squares.add_edge(scaled(edge.start), scaled(edge.end));
        }
        let free = squares.free();
        if !free.contains(&true) {
            return Err(MapError::NothingFree);
        }
        GridMap::new(columns as u32, rows as u32, square_m, Point::new(bounds.min().x, bounds.min().y), free)
    }
}

/// Squares of side 1 while edges are drawn into them.
struct Squares {
    columns: usize,
    rows: usize,
    parity_changes: Vec<bool>,
    touched: Vec<bool>,
}

impl Squares {
    fn new(columns: usize, rows: usize) -> Self {
        let none = vec![false; columns * rows];
        Self { columns, rows, parity_changes: none.clone(), touched: none }
    }

    fn add_edge(&mut self, from: Coord<f64>, to: Coord<f64>) {
        let (low, high) = if from.y <= to.y { (from, to) } else { (to, from) };
        let last = self.rows - 1;
        for row in (low.y.floor() as usize).min(last)..=(high.y.floor() as usize).min(last) {
            let middle = row as f64 + 0.5;
            if low.y <= middle && middle < high.y {
                // The first square whose middle lies right of the edge.
                let column = (x_at(low, high, middle) - 0.5).ceil().max(0.0) as usize;
                if column < self.columns {
                    self.parity_changes[row * self.columns + column] ^= true;
                }
            }
            self.touch(low, high, row);
        }
    }

    fn touch(&mut self, low: Coord<f64>, high: Coord<f64>, row: usize) {
        let (bottom, top) = (row as f64 + GRAZE, (row + 1) as f64 - GRAZE);
        if high.y <= bottom || low.y >= top {
            return;
        }
        let (a, b) = (x_at(low, high, low.y.max(bottom)), x_at(low, high, high.y.min(top)));
        let (a, b) = if high.y - low.y < GRAZE { (low.x, high.x) } else { (a, b) };
        let (left, right) = (a.min(b) + GRAZE, a.max(b) - GRAZE);
        let column = |x: f64| (x.max(0.0).floor() as usize).min(self.columns - 1);
        let vertical_on_border = right < left && left.floor() > right.floor();
        if !vertical_on_border {
            let start = row * self.columns;
            self.touched[start + column(left.min(right))..=start + column(left.max(right))].fill(true);
        }
    }

    fn free(&self) -> Vec<bool> {
        let mut free = Vec::with_capacity(self.touched.len());
        for (changes, touched) in
            self.parity_changes.chunks(self.columns).zip(self.touched.chunks(self.columns))
        {
            let mut inside = false;
            for (change, touched) in changes.iter().zip(touched) {
                inside ^= change;
                free.push(inside && !touched);
            }
        }
        free
    }
}

fn x_at(low: Coord<f64>, high: Coord<f64>, y: f64) -> f64 {
    if high.y - low.y < GRAZE {
        return low.x;
    }
    low.x + (high.x - low.x) * ((y - low.y) / (high.y - low.y)).clamp(0.0, 1.0)
}

fn plain(polygon: PlainPolygon) -> Polygon<f64> {
    let ring = |corners: Ring| LineString::from(corners);
    Polygon::new(ring(polygon.exterior), polygon.holes.into_iter().map(ring).collect())
}

fn of_geojson(file: GeoJson) -> Result<Vec<Polygon<f64>>, MapError> {
    let refused = |error: geojson::Error| format_error(format!("a geometry is broken: {error}"));
    let geometries = match file {
        GeoJson::Geometry(geometry) => vec![geometry],
        GeoJson::Feature(feature) => feature.geometry.into_iter().collect(),
        GeoJson::FeatureCollection(all) => {
            all.features.into_iter().filter_map(|feature| feature.geometry).collect()
        }
    };
    let mut polygons = Vec::new();
    for geometry in geometries {
        match &geometry.value {
            GeometryValue::Polygon { .. } => polygons.push(Polygon::try_from(geometry).map_err(refused)?),
            GeometryValue::MultiPolygon { .. } => {
                polygons.extend(MultiPolygon::try_from(geometry).map_err(refused)?);
            }
            other => {
                let what =
                    format!("a {} is in it; only polygons and multipolygons are taken", other.type_name());
                return Err(format_error(what));
            }
        }
    }
    Ok(polygons)
}

/// Names the ring and the corner at fault, which the validation does not.
fn unsound(polygons: &MultiPolygon<f64>, otherwise: &str) -> MapError {
    let found = polygons.iter().enumerate().find_map(|(polygon, rings)| {
        check_rings(rings).err().map(|source| MapError::Rings { polygon, source })
    });
    found.unwrap_or_else(|| format_error(format!("the rings are not sound: {otherwise}")))
}

fn format_error(what: impl Into<String>) -> MapError {
    MapError::Format { line: 0, what: what.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::Path;

    fn drawing(json: &str, square_m: f64) -> String {
        let map = Polygons::parse(json.as_bytes()).unwrap().rasterise(square_m).unwrap();
        let row = |y| (0..map.columns()).map(|x| if map.is_free(x.into(), y) { '.' } else { '#' }).collect();
        (0..i64::from(map.rows())).rev().map(row).collect::<Vec<String>>().join("\n")
    }

    const SQUARE_WITH_HOLE: &str = r#"{"polygon": {"exterior": [[0,0],[4,0],[4,3],[0,3]],
        "holes": [[[1,1],[3,1],[3,2],[1,2]]]}}"#;

    #[test]
    fn edges_along_borders_block_neither_side() {
        assert_eq!(drawing(SQUARE_WITH_HOLE, 1.0), "....\n.##.\n....");
    }

    #[test]
    fn a_square_that_an_edge_passes_through_is_blocked() {
        assert_eq!(drawing(r#"{"exterior": [[0,0],[3,0],[0,3]]}"#, 1.0), "###\n.##\n..#");
    }

    #[test]
    fn geojson_is_read_as_features_too() {
        let json = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {},
            "geometry": {"type": "Polygon", "coordinates": [[[0,0],[2,0],[2,1],[0,1],[0,0]]]}}]}"#;
        assert_eq!(drawing(json, 1.0), "..");
    }

    #[test]
    fn unsound_rings_are_refused() {
        for (json, said) in [
            (
                r#"{"exterior": [[0,0],[2,2],[2,0],[0,2]]}"#,
                "the exterior ring meets itself: its edge from corner 0 and the one from corner 2",
            ),
            (r#"{"exterior": [[0,0],[1,0]]}"#, "the exterior ring"),
            (r#"{"exterior": [[0,0],[4,0],[8,0]]}"#, "the exterior ring"),
            (
                r#"{"exterior": [[0,0],[4,0],[4,3]], "holes": [[[8,8],[9,8],[9,9]]]}"#,
                "corner 0 of hole 0 is not inside the exterior ring",
            ),
            (
                r#"{"exterior": [[0,0],[4,0],[4,4],[0,4]], "holes": [[[0,1],[1,1],[1,2],[0,2]]]}"#,
                "hole 0 touches the exterior ring at its edge from corner",
            ),
        ] {
            let error = Polygons::parse(json.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(said), "{json}: {error}");
        }
        for json in [
            r#"{"exterior": [[0,0],[1e300,0],[4,3]]}"#,
            r#"{"type": "Point", "coordinates": [0, 0]}"#,
            r#"{"exterior": "#,
            "{}",
        ] {
            assert!(matches!(Polygons::parse(json.as_bytes()), Err(MapError::Format { .. })), "{json}");
        }
    }

    #[test]
    fn too_many_squares_are_refused_before_they_are_made() {
        let polygons = Polygons::parse(SQUARE_WITH_HOLE.as_bytes()).unwrap();
        assert!(matches!(polygons.rasterise(1e-6), Err(MapError::TooLarge { .. })));
    }

    #[test]
    fn polygons_of_the_papers_keep_their_area() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances/mcfs");
        let Ok(bytes) = std::fs::read(folder.join("office.json")) else {
            println!("skipped: ../shared/instances is not there");
            return;
        };
        let map = Polygons::parse(&bytes).unwrap().rasterise(0.02).unwrap();
        let area_m2 = map.free_area_m2();
        assert!((101.0..=105.703_135).contains(&area_m2), "{area_m2}");
    }

    proptest! {
        #[test]
        fn no_ring_makes_the_reader_panic(
            corners in prop::collection::vec([-9_i32..9, -9..9], 0..9),
            square_m in prop::sample::select(vec![0.3, 1.0, f64::NAN, 0.0]),
        ) {
            let json = format!("{{\"exterior\": {corners:?}}}");
            let _ = Polygons::parse(json.as_bytes()).and_then(|polygons| polygons.rasterise(square_m));
        }
    }
}
