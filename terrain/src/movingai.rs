//! The text format of the MovingAI benchmarks: `type octile`, `height`, `width`, `map`, then one character a
//! square, first line on top. The format has no scale: metres per character are given beside it.

use crate::{GridMap, MapError, Point};

/// Reads a MovingAI map. `.`, `G` and `S` are free; `@`, `O`, `T` and `W` are blocked. The lower left corner
/// of the drawing becomes the origin of the `map` frame.
///
/// # Errors
///
/// [`MapError::Format`] with the line, [`MapError::TooLarge`], [`MapError::NothingFree`].
pub fn parse_movingai(text: &str, metres_per_character: f64) -> Result<GridMap, MapError> {
    let mut lines = text.lines().enumerate().map(|(at, line)| (at + 1, line.trim_end()));
    let (mut height, mut width) = (None, None);
    for (line, content) in lines.by_ref() {
        let mut words = content.split_whitespace();
        match (words.next(), words.next()) {
            (Some("type"), Some(_)) | (None, _) => {}
            (Some("height"), Some(value)) => height = Some(size(line, value)?),
            (Some("width"), Some(value)) => width = Some(size(line, value)?),
            (Some("map"), None) => break,
            _ => {
                return Err(format_error(line, format!("`{content}` is not a header line of a .map file")));
            }
        }
    }
    let missing = |key| format_error(0, format!("no `{key} N` line before `map`"));
    let (height, width) = (height.ok_or_else(|| missing("height"))?, width.ok_or_else(|| missing("width"))?);
    GridMap::check_size(u64::from(width), u64::from(height))?;
    let mut free = vec![false; width as usize * height as usize];
    for row in 0..height {
        let (line, content) =
            lines.next().ok_or_else(|| format_error(0, format!("{height} rows expected, {row} found")))?;
        if content.chars().count() != width as usize {
            let found = content.chars().count();
            return Err(format_error(line, format!("{width} characters expected, {found} found")));
        }
        let start = (height - 1 - row) as usize * width as usize;
        for (x, character) in content.chars().enumerate() {
            free[start + x] = square(line, character)?;
        }
    }
    if !free.contains(&true) {
        return Err(MapError::NothingFree);
    }
    GridMap::new(width, height, metres_per_character, Point::origin(), free)
}

fn size(line: usize, value: &str) -> Result<u32, MapError> {
    value.parse().map_err(|_| format_error(line, format!("`{value}` is not a number of squares")))
}

fn square(line: usize, character: char) -> Result<bool, MapError> {
    match character {
        '.' | 'G' | 'S' => Ok(true),
        '@' | 'O' | 'T' | 'W' => Ok(false),
        other => Err(format_error(line, format!("`{other}` is none of . G S @ O T W"))),
    }
}

fn format_error(line: usize, what: String) -> MapError {
    MapError::Format { line, what }
}
