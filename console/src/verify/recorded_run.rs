//! What was run, from the head of the log: the floor, and the sizes of body and tool.

use crate::LogError;
use std::collections::BTreeMap;
use terrain::{Floor, GridMap, Point};

/// What was to be covered, by whom.
#[derive(Debug)]
pub(crate) struct RecordedRun {
    pub(crate) mission_id: String,
    pub(crate) map: GridMap,
    /// The floor for a tool that is smaller by the tolerance of the coverage: what is demanded.
    pub(crate) floor: Floor,
    /// What only the rim of the whole tool could reach, and is not demanded.
    pub(crate) rim_m2: f64,
    pub(crate) body_radius_m: f64,
    pub(crate) tool_width_m: f64,
}

/// Gathers the parts of the head as they come.
#[derive(Debug, Default)]
pub(crate) struct RunHead {
    facts: BTreeMap<String, String>,
    floor_pgm: Option<Vec<u8>>,
}

impl RunHead {
    pub(crate) fn take_metadata(&mut self, name: &str, facts: &BTreeMap<&str, &str>) {
        if name == "fleet.run" {
            self.facts = facts.iter().map(|(&key, &value)| (key.to_owned(), value.to_owned())).collect();
        }
    }

    pub(crate) fn take_attachment(&mut self, name: &str, data: &[u8]) {
        if name == "floor.pgm" {
            self.floor_pgm = Some(data.to_vec());
        }
    }

    /// Lays the floor out again from what was gathered.
    pub(crate) fn lay_out(&self) -> Result<RecordedRun, LogError> {
        let foreign = |what: &str| LogError::Foreign(format!("{what} before its first message"));
        let picture = self.floor_pgm.as_deref().ok_or_else(|| foreign("no attachment floor.pgm"))?;
        let origin = Point::new(self.number("map_origin_x_m")?, self.number("map_origin_y_m")?);
        let map = map_from_pgm(picture, self.number("map_resolution_m")?, origin)?;
        let body_radius_m = self.number("body_radius_m")?;
        let tool_width_m = self.number("tool_width_m")?;
        let tolerance_m = self.number("coverage_tolerance_m")?;
        let cell_m = self.number("cell_m")?;
        // Logs of before there was such a margin do not tell it.
        let margin_m =
            if self.facts.contains_key("wall_margin_m") { self.number("wall_margin_m")? } else { 0.0 };
        let floor_for = |tool_width_m: f64| {
            Floor::new(&map, cell_m, body_radius_m + margin_m, tool_width_m)
                .map_err(|error| LogError::Foreign(error.to_string()))
        };
        let floor = floor_for(tool_width_m - 2.0 * tolerance_m)?;
        let rim_m2 = floor_for(tool_width_m)?.coverable_m2() - floor.coverable_m2();
        let mission_id = self.facts.get("mission_id").cloned().unwrap_or_default();
        Ok(RecordedRun { mission_id, map, floor, rim_m2, body_radius_m, tool_width_m })
    }

    fn number(&self, key: &str) -> Result<f64, LogError> {
        let text = self.facts.get(key).ok_or_else(|| LogError::Foreign(format!("no {key} in fleet.run")))?;
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| LogError::Foreign(format!("{key} = {text} in fleet.run is not a number")))
    }
}

/// Reads the map as the recorder wrote it: binary PGM, 0 blocked, first row on top.
fn map_from_pgm(picture: &[u8], resolution_m: f64, origin: Point) -> Result<GridMap, LogError> {
    let broken = |what: String| LogError::Damaged(format!("floor.pgm: {what}"));
    let mut parts = picture.splitn(4, |&byte| byte == b'\n');
    let mut line = || parts.next().and_then(|part| std::str::from_utf8(part).ok()).unwrap_or_default();
    let (kind, size, depth) = (line(), line(), line());
    let sizes: Option<Vec<u32>> = size.split(' ').map(|number| number.parse().ok()).collect();
    let (Some([columns, rows]), "P5", "255") = (sizes.as_deref(), kind, depth) else {
        return Err(broken(format!("unexpected head `{kind}` `{size}` `{depth}`")));
    };
    GridMap::check_size((*columns).into(), (*rows).into()).map_err(|error| broken(error.to_string()))?;
    let squares = parts.next().unwrap_or_default();
    if squares.len() != *columns as usize * *rows as usize {
        return Err(broken(format!("{} squares, {columns} x {rows} expected", squares.len())));
    }
    let free = squares.chunks(*columns as usize).rev().flatten().map(|&square| square != 0).collect();
    GridMap::new(*columns, *rows, resolution_m, origin, free).map_err(|error| broken(error.to_string()))
}
