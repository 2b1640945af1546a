//! The messages of an MCAP recording, in protobuf, with their descriptors: Foxglove's `RawImage` and
//! `CameraCalibration`. A file carries the descriptors, so any reader of MCAP can take it apart.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, Timestamp};

/// Names of the schemas.
pub(super) const RAW_IMAGE: &str = "foxglove.RawImage";
pub(super) const CAMERA_CALIBRATION: &str = "foxglove.CameraCalibration";

/// An image.
#[derive(Clone, PartialEq, Message)]
pub(super) struct RawImage {
    #[prost(message, optional, tag = "1")]
    pub(super) timestamp: Option<Timestamp>,
    #[prost(fixed32, tag = "2")]
    pub(super) width: u32,
    #[prost(fixed32, tag = "3")]
    pub(super) height: u32,
    #[prost(string, tag = "4")]
    pub(super) encoding: String,
    #[prost(fixed32, tag = "5")]
    pub(super) step: u32,
    #[prost(bytes = "vec", tag = "6")]
    pub(super) data: Vec<u8>,
    #[prost(string, tag = "7")]
    pub(super) frame_id: String,
}

/// A pinhole camera.
#[derive(Clone, PartialEq, Message)]
pub(super) struct CameraCalibration {
    #[prost(message, optional, tag = "1")]
    pub(super) timestamp: Option<Timestamp>,
    #[prost(fixed32, tag = "2")]
    pub(super) width: u32,
    #[prost(fixed32, tag = "3")]
    pub(super) height: u32,
    #[prost(string, tag = "4")]
    pub(super) distortion_model: String,
    #[prost(double, repeated, tag = "5")]
    pub(super) d: Vec<f64>,
    #[prost(double, repeated, tag = "6")]
    pub(super) k: Vec<f64>,
    #[prost(double, repeated, tag = "7")]
    pub(super) r: Vec<f64>,
    #[prost(double, repeated, tag = "8")]
    pub(super) p: Vec<f64>,
    #[prost(string, tag = "9")]
    pub(super) frame_id: String,
}

/// A time of the device, as protobuf writes times.
pub(super) fn timestamp(us: u64) -> Timestamp {
    Timestamp { seconds: (us / 1_000_000) as i64, nanos: (us % 1_000_000) as i32 * 1000 }
}

/// The descriptors of both messages, encoded.
pub(super) fn descriptors() -> Vec<u8> {
    let stamp = Field { name: "timestamp", number: 1, kind: Type::Message };
    let size = [
        Field { name: "width", number: 2, kind: Type::Fixed32 },
        Field { name: "height", number: 3, kind: Type::Fixed32 },
    ];
    let image = [
        Field { name: "encoding", number: 4, kind: Type::String },
        Field { name: "step", number: 5, kind: Type::Fixed32 },
        Field { name: "data", number: 6, kind: Type::Bytes },
        Field { name: "frame_id", number: 7, kind: Type::String },
    ];
    let camera = [
        Field { name: "distortion_model", number: 4, kind: Type::String },
        Field { name: "D", number: 5, kind: Type::Double },
        Field { name: "K", number: 6, kind: Type::Double },
        Field { name: "R", number: 7, kind: Type::Double },
        Field { name: "P", number: 8, kind: Type::Double },
        Field { name: "frame_id", number: 9, kind: Type::String },
    ];
    let message = |name: &str, own: &[Field]| DescriptorProto {
        name: Some(name.into()),
        field: std::iter::once(&stamp).chain(&size).chain(own).map(|field| described(*field)).collect(),
        ..DescriptorProto::default()
    };
    let own = FileDescriptorProto {
        name: Some("meniscus.proto".into()),
        package: Some("foxglove".into()),
        dependency: vec!["google/protobuf/timestamp.proto".into()],
        message_type: vec![message("RawImage", &image), message("CameraCalibration", &camera)],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    };
    let time = FileDescriptorProto {
        name: Some("google/protobuf/timestamp.proto".into()),
        package: Some("google.protobuf".into()),
        message_type: vec![DescriptorProto {
            name: Some("Timestamp".into()),
            field: vec![
                described(Field { name: "seconds", number: 1, kind: Type::Int64 }),
                described(Field { name: "nanos", number: 2, kind: Type::Int32 }),
            ],
            ..DescriptorProto::default()
        }],
        syntax: Some("proto3".into()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![time, own] }.encode_to_vec()
}

/// A field of a message.
#[derive(Clone, Copy)]
struct Field {
    name: &'static str,
    number: i32,
    kind: Type,
}

/// Returns the descriptor of a field: the only messages are times, the only lists are of doubles.
fn described(field: Field) -> FieldDescriptorProto {
    let Field { name, number, kind } = field;
    let label = if kind == Type::Double { Label::Repeated } else { Label::Optional };
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(label.into()),
        r#type: Some(kind.into()),
        type_name: (kind == Type::Message).then(|| ".google.protobuf.Timestamp".into()),
        ..FieldDescriptorProto::default()
    }
}
