//! `sensor_msgs/PointCloud2` with numbers of four bytes.

use super::{Header, Octets};
use serde::Serialize;

/// Number of `FLOAT32` in `sensor_msgs/PointField`.
const FLOAT32: u8 = 7;

/// `sensor_msgs/PointField`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PointField {
    /// Name of the number.
    pub name: String,
    /// Its place in a point, bytes.
    pub offset: u32,
    /// Its type.
    pub datatype: u8,
    /// Numbers of the field.
    pub count: u32,
}

/// `sensor_msgs/PointCloud2`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointCloud2 {
    /// Instant and frame.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Points of a row.
    pub width: u32,
    /// Numbers of a point.
    pub fields: Vec<PointField>,
    /// Whether the numbers are big-endian.
    pub is_bigendian: bool,
    /// Bytes of a point.
    pub point_step: u32,
    /// Bytes of a row.
    pub row_step: u32,
    /// The points.
    pub data: Octets,
    /// Whether every number is one.
    pub is_dense: bool,
}

impl PointCloud2 {
    /// Returns a cloud of one row whose points have the numbers `names`; `data` has them point after point, little-endian.
    #[must_use]
    pub fn of(header: Header, names: &[&str], data: Vec<u8>, is_dense: bool) -> Self {
        let field = |(place, name): (u32, &&str)| PointField {
            name: (*name).to_owned(),
            offset: 4 * place,
            datatype: FLOAT32,
            count: 1,
        };
        let fields: Vec<PointField> = (0..).zip(names).map(field).collect();
        let point_step = 4 * fields.len() as u32;
        let row_step = u32::try_from(data.len()).unwrap_or(u32::MAX);
        Self {
            header,
            height: 1,
            width: row_step.checked_div(point_step).unwrap_or(0),
            fields,
            is_bigendian: false,
            point_step,
            row_step,
            data: Octets(data),
            is_dense,
        }
    }
}
