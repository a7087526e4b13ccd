//! The maps of ROS `map_server`: a YAML header and a grey image, first row on top.
//!
//! A pixel's occupancy is p = (255 − grey) / 255, or grey / 255 with `negate`. Free is p below `free_thresh`; all
//! else is blocked, unknown ground included: what nobody has seen cannot be promised to be drivable.

use crate::{GridMap, MapError, Point};
use image::{DynamicImage, ImageReader, Limits};
use serde::Deserialize;
use std::{
    io::Cursor,
    path::{Component, Path, PathBuf},
};

/// The header.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Header {
    image: PathBuf,
    resolution: f64,
    origin: Vec<f64>,
    #[serde(default = "default_occupied")]
    occupied_thresh: f64,
    #[serde(default = "default_free")]
    free_thresh: f64,
    #[serde(default)]
    negate: Flag,
    #[serde(default)]
    mode: Mode,
}

/// `negate` is written as 0 and 1 as well as false and true.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Flag {
    Word(bool),
    Number(u8),
}

impl Default for Flag {
    fn default() -> Self {
        Self::Number(0)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

fn default_occupied() -> f64 {
    0.65
}

fn default_free() -> f64 {
    0.196
}

/// Reads the YAML header.
pub(crate) fn parse_header(text: &str) -> Result<Header, MapError> {
    let header: Header = serde_saphyr::from_str(text).map_err(|error| MapError::Format {
        line: 0,
        what: format!("not a map_server header: {}", error.to_string().lines().next().unwrap_or_default()),
    })?;
    header.check()?;
    Ok(header)
}

impl Header {
    fn check(&self) -> Result<(), MapError> {
        let refused = |key, value: String, expected| Err(MapError::Value { key, value, expected });
        if !(self.origin.len() == 3 && self.origin.iter().all(|number| number.is_finite())) {
            return refused("origin", format!("{:?}", self.origin), "[x, y, yaw]: three finite numbers");
        }
        if self.origin[2] != 0.0 {
            let expected = "yaw 0: turn the image, not the map frame";
            return refused("origin", format!("{:?}", self.origin), expected);
        }
        if !(self.resolution.is_finite() && self.resolution > 0.0) {
            let expected = "metres per pixel, a finite number above 0";
            return refused("resolution", self.resolution.to_string(), expected);
        }
        let (free, occupied) = (self.free_thresh, self.occupied_thresh);
        if !(0.0..=1.0).contains(&free) || !(0.0..=1.0).contains(&occupied) || free > occupied {
            let expected = "0 <= free_thresh <= occupied_thresh <= 1";
            return refused("free_thresh", format!("{free} (occupied_thresh {occupied})"), expected);
        }
        match self.negate {
            Flag::Number(2..) => refused("negate", format!("{:?}", self.negate), "0 or 1"),
            _ => Ok(()),
        }
    }

    /// Where the image lies: in the header's folder or below it, links resolved.
    pub(crate) fn image_below(&self, folder: &Path) -> Result<PathBuf, MapError> {
        let refused = || MapError::Value {
            key: "image",
            value: self.image.display().to_string(),
            expected: "a file in the folder of the YAML file, or below it",
        };
        let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        if !self.image.components().all(plain) {
            return Err(refused());
        }
        let path = folder.join(&self.image);
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        match (folder.canonicalize(), path.canonicalize()) {
            (Ok(folder), Ok(real)) if !real.starts_with(&folder) => Err(refused()),
            _ => Ok(path),
        }
    }

    /// The map from the image's bytes; its size is checked before its pixels are decoded.
    pub(crate) fn grid(&self, bytes: &[u8]) -> Result<GridMap, MapError> {
        let (columns, rows) = reader(bytes)?.into_dimensions().map_err(|error| not_an_image(&error))?;
        GridMap::check_size(u64::from(columns), u64::from(rows))?;
        let mut reader = reader(bytes)?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(16 * crate::grid_map::SQUARES_MAX);
        reader.limits(limits);
        let image = reader.decode().map_err(|error| not_an_image(&error))?;
        let opaque = opaque(&image);
        let grey = image.into_luma8();
        let is_free = |x, y| opaque(x, y) && self.is_free(grey.get_pixel(x, y)[0]);
        let free: Vec<bool> = (0..rows)
            .rev()
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .map(|(x, y)| is_free(x, y))
            .collect();
        if !free.contains(&true) {
            return Err(MapError::NothingFree);
        }
        GridMap::new(columns, rows, self.resolution, Point::new(self.origin[0], self.origin[1]), free)
    }

    fn is_free(&self, grey: u8) -> bool {
        let negate = matches!(self.negate, Flag::Word(true) | Flag::Number(1));
        match self.mode {
            // The values are occupancies themselves: 0 free to 100 occupied, above unknown.
            Mode::Raw => grey <= 100 && f64::from(grey) / 100.0 < self.free_thresh,
            Mode::Trinary | Mode::Scale => {
                let dark = if negate { grey } else { 255 - grey };
                f64::from(dark) / 255.0 < self.free_thresh
            }
        }
    }
}

/// Whether pixels are there at all: in `scale` and `trinary` maps, see-through ones are unknown.
fn opaque(image: &DynamicImage) -> impl Fn(u32, u32) -> bool + use<> {
    let alpha = image.color().has_alpha().then(|| image.to_luma_alpha8());
    move |x, y| alpha.as_ref().is_none_or(|alpha| alpha.get_pixel(x, y)[1] == u8::MAX)
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, MapError> {
    ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| MapError::Format { line: 0, what: error.to_string() })
}

fn not_an_image(error: &image::ImageError) -> MapError {
    MapError::Format { line: 0, what: format!("not a PGM or PNG image: {error}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn header(more: &str) -> Result<Header, MapError> {
        parse_header(&format!("image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n{more}"))
    }

    #[test]
    fn negate_turns_black_into_free() {
        assert!(header("negate: 0").unwrap().is_free(254));
        assert!(header("negate: 1").unwrap().is_free(1));
        assert!(!header("negate: 1").unwrap().is_free(254));
    }

    #[test]
    fn a_raw_map_holds_occupancies() {
        let raw = header("mode: raw").unwrap();
        assert_eq!([0, 19, 20, 100, 255].map(|grey| raw.is_free(grey)), [true, true, false, false, false]);
    }

    #[test]
    fn an_image_outside_the_folder_is_refused() {
        for image in ["../a.pgm", "/etc/a.pgm", "b/../../a.pgm"] {
            let text = format!("image: {image}\nresolution: 0.1\norigin: [0, 0, 0]\n");
            assert!(parse_header(&text).unwrap().image_below(Path::new(".")).is_err(), "{image}");
        }
    }

    #[test]
    fn a_turned_map_and_thresholds_out_of_order_are_refused_by_key() {
        let turned = parse_header("image: a.pgm\nresolution: 0.1\norigin: [0, 0, 1.57]\n").unwrap_err();
        assert!(turned.to_string().starts_with("`origin`"), "{turned}");
        let crossed = header("free_thresh: 0.7").unwrap_err();
        assert!(crossed.to_string().starts_with("`free_thresh`"), "{crossed}");
    }

    #[test]
    fn a_resolution_that_is_none_is_refused_by_key() {
        for resolution in ["0", "-0.05", ".nan", ".inf"] {
            let text = format!("image: a.pgm\nresolution: {resolution}\norigin: [0, 0, 0]\n");
            let said = parse_header(&text).unwrap_err().to_string();
            assert!(said.starts_with("`resolution`") && said.contains("above 0"), "{said}");
        }
    }

    /// 205 is unknown at the usual 0.196, and free at the 0.25 that some maps come with.
    #[test]
    fn thresholds_are_compared_as_map_server_does() {
        assert!(!header("free_thresh: 0.196").unwrap().is_free(205));
        assert!(header("free_thresh: 0.25").unwrap().is_free(205));
    }

    #[test]
    fn a_huge_image_is_refused_before_it_is_decoded() {
        let error = header("").unwrap().grid(b"P5\n100000 100000\n255\n").unwrap_err();
        assert_eq!(error, MapError::TooLarge { columns: 100_000, rows: 100_000 });
    }

    proptest! {
        #[test]
        fn no_image_makes_the_reader_panic(
            start in prop::sample::select(vec![&b"P5\n3 3\n255\n"[..], b"P2\n2 2\n9\n", b"\x89PNG\r\n\x1a\n", b""]),
            rest in prop::collection::vec(any::<u8>(), 0..60),
        ) {
            let _ = header("").unwrap().grid(&[start, &rest].concat());
        }
    }
}
