//! The ROS 2 messages that are written, as CDR has them: fields in order.

use cdr_encoding::to_vec;
use serde::Serialize;

use crate::se3::Pose;

/// Begins the definition of a type that another one has in it.
macro_rules! definition {
    ($name:literal) => {
        concat!("================================================================================\nMSG: ", $name, "\n")
    };
}

macro_rules! header {
    () => {
        concat!(
            definition!("std_msgs/Header"),
            "builtin_interfaces/Time stamp\nstring frame_id\n",
            definition!("builtin_interfaces/Time"),
            "int32 sec\nuint32 nanosec\n"
        )
    };
}

macro_rules! vector {
    () => {
        concat!(definition!("geometry_msgs/Vector3"), "float64 x\nfloat64 y\nfloat64 z\n")
    };
}

macro_rules! quaternion {
    () => {
        concat!(definition!("geometry_msgs/Quaternion"), "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n")
    };
}

/// A message that viewers know.
pub(super) trait Message: Serialize + Sized {
    /// Its type.
    const NAME: &'static str;
    /// Its definition, and those of the types in it.
    const DEFINITION: &'static str;

    /// Little-endian CDR, with the four bytes that say so.
    fn to_cdr(&self) -> cdr_encoding::Result<Vec<u8>> {
        Ok([&[0, 1, 0, 0][..], &to_vec::<_, byteorder::LittleEndian>(self)?].concat())
    }
}

#[derive(Clone, Serialize)]
pub(super) struct Header {
    sec: i32,
    nanosec: u32,
    frame_id: String,
}

impl Header {
    pub(super) fn new(time: u64, frame_id: &str) -> Header {
        let (sec, nanosec) = ((time / 1_000_000_000) as i32, (time % 1_000_000_000) as u32);
        Header { sec, nanosec, frame_id: frame_id.to_owned() }
    }
}

#[derive(Serialize)]
pub(super) struct JointState {
    pub(super) header: Header,
    pub(super) name: Vec<String>,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) effort: Vec<f64>,
}

impl Message for JointState {
    const NAME: &'static str = "sensor_msgs/msg/JointState";
    const DEFINITION: &'static str = concat!(
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        header!()
    );
}

#[derive(Serialize)]
pub(super) struct TransformStamped {
    header: Header,
    child_frame_id: String,
    translation: [f64; 3],
    rotation: [f64; 4],
}

impl TransformStamped {
    /// The pose of frame `child` in frame `parent`.
    pub(super) fn new(time: u64, parent: &str, child: &str, parent_from_child: &Pose) -> TransformStamped {
        let (translation, rotation) = numbers(parent_from_child);
        TransformStamped { header: Header::new(time, parent), child_frame_id: child.to_owned(), translation, rotation }
    }
}

#[derive(Serialize)]
pub(super) struct TfMessage {
    pub(super) transforms: Vec<TransformStamped>,
}

impl Message for TfMessage {
    const NAME: &'static str = "tf2_msgs/msg/TFMessage";
    const DEFINITION: &'static str = concat!(
        "geometry_msgs/TransformStamped[] transforms\n",
        definition!("geometry_msgs/TransformStamped"),
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        definition!("geometry_msgs/Transform"),
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        vector!(),
        quaternion!(),
        header!()
    );
}

#[derive(Serialize)]
struct PointField {
    name: String,
    offset: u32,
    datatype: u8,
    count: u32,
}

#[derive(Serialize)]
pub(super) struct PointCloud2 {
    header: Header,
    height: u32,
    width: u32,
    fields: Vec<PointField>,
    is_bigendian: bool,
    point_step: u32,
    row_step: u32,
    data: Vec<u8>,
    is_dense: bool,
}

impl PointCloud2 {
    /// Points `x, y, z` (m).
    pub(super) fn new(header: Header, points: &[[f32; 3]]) -> PointCloud2 {
        const FLOAT32: u8 = 7;
        let field =
            |(name, offset): (&str, u32)| PointField { name: name.to_owned(), offset, datatype: FLOAT32, count: 1 };
        let width = points.len() as u32;
        PointCloud2 {
            header,
            height: 1,
            width,
            fields: [("x", 0), ("y", 4), ("z", 8)].map(field).into(),
            is_bigendian: false,
            point_step: 12,
            row_step: 12 * width,
            data: points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect(),
            is_dense: true,
        }
    }
}

impl Message for PointCloud2 {
    const NAME: &'static str = "sensor_msgs/msg/PointCloud2";
    const DEFINITION: &'static str = concat!(
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n",
        "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        definition!("sensor_msgs/PointField"),
        "string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
        header!()
    );
}

/// How a marker is drawn.
#[derive(Clone, Copy)]
pub(super) enum Drawn {
    /// As a ball of this diameter (m).
    Ball(f64),
    /// As lines of this width (m) between each two points.
    Lines(f64),
}

#[derive(Serialize)]
pub(super) struct Marker {
    header: Header,
    ns: String,
    id: i32,
    kind: i32,
    action: i32,
    position: [f64; 3],
    orientation: [f64; 4],
    scale: [f64; 3],
    color: [f32; 4],
    lifetime: (i32, u32),
    frame_locked: bool,
    points: Vec<[f64; 3]>,
    colors: Vec<[f32; 4]>,
    text: String,
    mesh_resource: String,
    mesh_use_embedded_materials: bool,
}

impl Marker {
    /// Something in the frame of `header`, with which it moves.
    pub(super) fn new(header: Header, ns: &str, drawn: Drawn, points: Vec<[f64; 3]>, color: [f32; 4]) -> Marker {
        let (kind, scale) = match drawn {
            Drawn::Ball(diameter) => (2, [diameter; 3]),
            Drawn::Lines(width) => (5, [width, 0.0, 0.0]),
        };
        Marker {
            header,
            ns: ns.to_owned(),
            id: 0,
            kind,
            action: 0,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            scale,
            color,
            lifetime: (0, 0),
            frame_locked: true,
            points,
            colors: Vec::new(),
            text: String::new(),
            mesh_resource: String::new(),
            mesh_use_embedded_materials: false,
        }
    }
}

#[derive(Serialize)]
pub(super) struct MarkerArray {
    pub(super) markers: Vec<Marker>,
}

impl Message for MarkerArray {
    const NAME: &'static str = "visualization_msgs/msg/MarkerArray";
    const DEFINITION: &'static str = concat!(
        "visualization_msgs/Marker[] markers\n",
        definition!("visualization_msgs/Marker"),
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\n",
        "std_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n",
        "std_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\nbool mesh_use_embedded_materials\n",
        definition!("geometry_msgs/Pose"),
        "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        definition!("geometry_msgs/Point"),
        "float64 x\nfloat64 y\nfloat64 z\n",
        definition!("std_msgs/ColorRGBA"),
        "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
        definition!("builtin_interfaces/Duration"),
        "int32 sec\nuint32 nanosec\n",
        vector!(),
        quaternion!(),
        header!()
    );
}

fn numbers(pose: &Pose) -> ([f64; 3], [f64; 4]) {
    let (place, turn) = (&pose.translation, pose.rotation.coords);
    ([place.x, place.y, place.z], [turn.x, turn.y, turn.z, turn.w])
}
