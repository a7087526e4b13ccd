//! Map files: which reader by which extension, and the limits that hold before anything is allocated.
//!
//! ```text
//!   .map              MovingAI text               metres per character are given beside it
//!   .yaml .yml        ROS map_server + its image  resolution and origin in the file
//!   .json .geojson    polygons with holes         laid out in squares of `square_m`
//! ```

use crate::{GridMap, MapError, parse_movingai, polygon::Polygons, ros_map};
use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};
use thiserror::Error;

/// The largest file that is read, bytes.
pub const FILE_BYTES_MAX: u64 = 64 << 20;

/// Why a map file could not be read.
#[derive(Debug, Error)]
pub enum MapFileError {
    /// It is not there, or may not be read.
    #[error("{}: {cause}; check the path", path.display())]
    Read {
        /// What was looked for.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// It is larger than we take.
    #[error("{}: larger than {} MiB, which is the most that is read", path.display(), FILE_BYTES_MAX >> 20)]
    TooLong {
        /// The file.
        path: PathBuf,
    },
    /// Its extension names no format we know.
    #[error("{}: the name must end with .map, .yaml, .yml, .json or .geojson", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// Its content is not a map.
    #[error("{}: {cause}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: MapError,
    },
}

/// What map files do not say themselves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFile {
    /// Metres per character of a `.map`.
    pub metres_per_character: f64,
    /// Side of the squares into which polygons are laid out, metres.
    pub square_m: f64,
}

impl MapFile {
    /// Reads a map, in the format that its extension names.
    ///
    /// # Errors
    ///
    /// [`MapFileError`], naming the file and what is wrong with it.
    pub fn load(&self, path: impl AsRef<Path>) -> Result<GridMap, MapFileError> {
        let path = path.as_ref();
        let refused = |cause| MapFileError::Content { path: path.to_owned(), cause };
        let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or("").to_ascii_lowercase();
        match kind.as_str() {
            "map" => parse_movingai(&text(read(path)?).map_err(refused)?, self.metres_per_character)
                .map_err(refused),
            "yaml" | "yml" => load_ros_map(path),
            "json" | "geojson" => Polygons::parse(&read(path)?)
                .and_then(|polygons| polygons.rasterise(self.square_m))
                .map_err(refused),
            _ => Err(MapFileError::UnknownKind { path: path.to_owned() }),
        }
    }
}

fn load_ros_map(path: &Path) -> Result<GridMap, MapFileError> {
    let refused = |cause| MapFileError::Content { path: path.to_owned(), cause };
    let header = text(read(path)?).and_then(|text| ros_map::parse_header(&text)).map_err(refused)?;
    let image_path = header.image_below(path.parent().unwrap_or(Path::new("."))).map_err(refused)?;
    let image = read(&image_path)?;
    header.grid(&image).map_err(|cause| MapFileError::Content { path: image_path, cause })
}

fn read(path: &Path) -> Result<Vec<u8>, MapFileError> {
    let failed = |cause| MapFileError::Read { path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    File::open(path).map_err(failed)?.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > FILE_BYTES_MAX {
        return Err(MapFileError::TooLong { path: path.to_owned() });
    }
    Ok(bytes)
}

fn text(bytes: Vec<u8>) -> Result<String, MapError> {
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.split(|&byte| byte == b'\n').skip(1).count();
        MapError::Format { line, what: "not UTF-8 text".to_owned() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HOW: MapFile = MapFile { metres_per_character: 0.5, square_m: 0.5 };

    fn load(name: &str, bytes: &[u8]) -> Result<GridMap, MapFileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        HOW.load(path)
    }

    #[test]
    fn a_missing_file_and_an_unknown_kind_are_named() {
        assert!(HOW.load("no/such.map").unwrap_err().to_string().contains("no/such.map"));
        assert!(matches!(load("floor.txt", b""), Err(MapFileError::UnknownKind { .. })));
    }

    #[test]
    fn text_that_is_none_is_named_by_its_line() {
        let error = load("floor.map", b"type octile\n\xff").unwrap_err().to_string();
        assert!(error.contains("line 2"), "{error}");
    }

    #[test]
    fn a_ros_map_is_read_with_its_image() {
        let folder = tempfile::tempdir().unwrap();
        let yaml = "image: floor.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";
        std::fs::write(folder.path().join("floor.yaml"), yaml).unwrap();
        std::fs::write(folder.path().join("floor.pgm"), b"P5\n2 2\n255\n\xfe\x00\xcd\xfe").unwrap();
        let map = HOW.load(folder.path().join("floor.yaml")).unwrap();
        assert_eq!(map.origin(), crate::Point::new(-1.0, 2.0));
        let free = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| map.is_free(x, y));
        assert_eq!(free, [false, true, true, false], "unknown (205) counts as blocked");
    }

    #[test]
    fn a_ros_map_without_its_image_is_named_by_the_image() {
        let yaml = b"image: nowhere.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n";
        let said = load("floor.yaml", yaml).unwrap_err().to_string();
        assert!(said.contains("nowhere.pgm") && said.contains("check the path"), "{said}");
    }

    #[test]
    fn a_ros_map_may_begin_anywhere() {
        let folder = tempfile::tempdir().unwrap();
        let yaml = "image: floor.png\nresolution: 0.05\norigin: [-12.5, 3.25, 0.0]\n";
        std::fs::write(folder.path().join("floor.yaml"), yaml).unwrap();
        let mut image = image::GrayImage::from_pixel(40, 20, image::Luma([254]));
        image.put_pixel(0, 19, image::Luma([0]));
        image.save(folder.path().join("floor.png")).unwrap();
        let map = HOW.load(folder.path().join("floor.yaml")).unwrap();
        assert!((map.corner() - crate::Point::new(-10.5, 4.25)).norm() < 1e-9);
        assert!(!map.point_is_free(crate::Point::new(-12.475, 3.275)), "the lower left pixel");
        assert!(map.point_is_free(crate::Point::new(-12.475, 4.225)));
    }

    proptest! {
        #[test]
        fn no_bytes_make_a_reader_panic(
            bytes in prop::collection::vec(any::<u8>(), 0..300),
            kind in prop::sample::select(vec!["a.map", "a.yaml", "a.json", "a.geojson"]),
        ) {
            let _ = load(kind, &bytes);
        }
    }
}
