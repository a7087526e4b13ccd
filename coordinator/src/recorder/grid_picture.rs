//! Pictures made of squares: the same colours as `foxglove.Grid` for Foxglove, and as `nav_msgs/msg/OccupancyGrid`
//! for viewers that draw only that.

use super::palette::Rgba;
use super::viewer::{MAP_FRAME, pose_at};
use foxglove::Schema;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{Grid, PackedElementField, Timestamp, Vector2};
use terrain::Point;

/// Where a picture's squares lie: row by row from the bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GridFrame {
    pub(super) origin: Point,
    pub(super) square_m: f64,
    pub(super) columns: u32,
    pub(super) rows: u32,
}

/// The squares as colours.
pub(super) fn coloured(stamp: Timestamp, frame: GridFrame, squares: impl Iterator<Item = Rgba>) -> Grid {
    let field = |(offset, name): (u32, &str)| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: NumericType::Uint8 as i32,
    };
    Grid {
        timestamp: Some(stamp),
        frame_id: MAP_FRAME.to_owned(),
        pose: Some(pose_at(frame.origin.x, frame.origin.y, 0.0)),
        column_count: frame.columns,
        cell_size: Some(Vector2 { x: frame.square_m, y: frame.square_m }),
        row_stride: frame.columns * 4,
        cell_stride: 4,
        fields: (0..).zip(["red", "green", "blue", "alpha"]).map(field).collect(),
        data: squares.flatten().collect::<Vec<u8>>().into(),
    }
}

/// The squares as numbers from 0 to 100, -1 for unknown: a `nav_msgs/msg/OccupancyGrid` in CDR.
pub(super) fn occupancy(stamp: Timestamp, frame: GridFrame, squares: impl Iterator<Item = i8>) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.time(stamp);
    cdr.string(MAP_FRAME);
    cdr.time(stamp);
    cdr.f32(frame.square_m as f32);
    cdr.u32(frame.columns);
    cdr.u32(frame.rows);
    for number in [frame.origin.x, frame.origin.y, 0.0, 0.0, 0.0, 0.0, 1.0] {
        cdr.f64(number);
    }
    cdr.u32(frame.columns * frame.rows);
    cdr.bytes.extend(squares.map(i8::cast_unsigned));
    cdr.bytes
}

/// Little-endian CDR as ROS 2 writes it: each number at a multiple of its size, counted behind the 4-byte head.
struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    fn new() -> Self {
        Self { bytes: vec![0, 1, 0, 0] }
    }

    fn body_len(&self) -> usize {
        self.bytes.len() - 4
    }

    fn align(&mut self, size: usize) {
        let padded = self.body_len().next_multiple_of(size) + 4;
        self.bytes.resize(padded, 0);
    }

    fn time(&mut self, time: Timestamp) {
        self.u32(time.sec());
        self.u32(time.nsec());
    }

    fn u32(&mut self, number: u32) {
        self.align(4);
        self.bytes.extend(number.to_le_bytes());
    }

    fn f32(&mut self, number: f32) {
        self.align(4);
        self.bytes.extend(number.to_le_bytes());
    }

    fn f64(&mut self, number: f64) {
        self.align(8);
        self.bytes.extend(number.to_le_bytes());
    }

    fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.bytes());
        self.bytes.push(0);
    }
}

/// The schema of [`occupancy`], each message it is made of behind a line of `=`.
pub(super) fn occupancy_schema() -> Schema {
    let parts = [
        ("", "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data"),
        ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
        ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
        (
            "nav_msgs/MapMetaData",
            "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n\
             geometry_msgs/Pose origin",
        ),
        ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"),
        ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
        ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ];
    let rule = "=".repeat(80);
    let part = |(name, fields): &(&str, &str)| match *name {
        "" => format!("{fields}\n"),
        name => format!("{rule}\nMSG: {name}\n{fields}\n"),
    };
    let text: String = parts.iter().map(part).collect();
    Schema::new("nav_msgs/msg/OccupancyGrid", "ros2msg", text.into_bytes())
}
