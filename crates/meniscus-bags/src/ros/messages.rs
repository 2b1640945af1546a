//! `sensor_msgs/Image` and `sensor_msgs/CameraInfo` of ROS 1 and ROS 2, and pixels as the surface is read from them.

use crate::cdr::Fields;
use meniscus::usb::uvc::Stream;
use std::fmt;

/// Metres in one unit of depth images that were recorded as floats: 0.1 mm reaches to 6.5 m.
pub(super) const FLOAT_UNIT_M: f32 = 1e-4;

/// Fault of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// It is shorter than what it holds.
    Short,
    /// Its rows are shorter than its pixels, or its pixels fewer than its size.
    Rows,
    /// Its encoding is not read.
    Encoding(String),
    /// It has another size than its camera.
    Size([u32; 2], [u32; 2]),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => f.write_str("a message is shorter than what it holds"),
            Self::Rows => f.write_str("an image has fewer bytes than its size needs"),
            Self::Encoding(name) => {
                write!(f, "an image has the encoding '{}', which is not read", name.escape_default())
            }
            Self::Size([w, h], [width, height]) => {
                write!(f, "an image has {w} x {h} pixels instead of {width} x {height}")
            }
        }
    }
}

/// `sensor_msgs/Image`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageMessage<'b> {
    /// Time of its header, us.
    pub(super) stamp_us: u64,
    /// Pixels in a row, rows.
    pub(super) size: (u32, u32),
    /// Encoding.
    pub(super) encoding: &'b str,
    big_endian: bool,
    step: u32,
    data: &'b [u8],
}

/// Kind of an image by its encoding: what it can be used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pixel {
    /// Depth in integers.
    Depth16,
    /// Depth in metres.
    DepthFloat,
    /// Brightness.
    Grey,
    /// Colour: places of red, green and blue among so many bytes.
    Colour([usize; 3], usize),
}

impl Pixel {
    /// Returns the kind of `encoding`; none where it is not read. The names are those of `sensor_msgs/image_encodings.hpp`.
    pub(super) fn of(encoding: &str) -> Option<Self> {
        match encoding {
            "16UC1" | "mono16" => Some(Self::Depth16),
            "32FC1" => Some(Self::DepthFloat),
            "mono8" | "8UC1" => Some(Self::Grey),
            "rgb8" => Some(Self::Colour([0, 1, 2], 3)),
            "bgr8" => Some(Self::Colour([2, 1, 0], 3)),
            "rgba8" => Some(Self::Colour([0, 1, 2], 4)),
            "bgra8" => Some(Self::Colour([2, 1, 0], 4)),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Depth16 => 2,
            Self::DepthFloat => 4,
            Self::Grey => 1,
            Self::Colour(_, bytes) => bytes,
        }
    }
}

/// Returns the fields of a message.
fn fields(data: &[u8], aligned: bool) -> Result<Fields<'_>, Fault> {
    if aligned { Fields::cdr(data).ok_or(Fault::Short) } else { Ok(Fields::packed(data)) }
}

/// Reads `std_msgs/Header`; returns its time, us.
fn stamp_us(fields: &mut Fields<'_>, aligned: bool) -> Option<u64> {
    // ROS 1 counts before the time.
    if !aligned {
        fields.u32()?;
    }
    let (seconds, nanos) = (fields.u32()?, fields.u32()?);
    fields.run()?;
    Some(u64::from(seconds) * 1_000_000 + u64::from(nanos) / 1000)
}

impl<'b> ImageMessage<'b> {
    /// Reads a message.
    pub(super) fn read(data: &'b [u8], aligned: bool) -> Result<Self, Fault> {
        let mut fields = fields(data, aligned)?;
        let mut read = || {
            let stamp_us = stamp_us(&mut fields, aligned)?;
            let (height, width) = (fields.u32()?, fields.u32()?);
            let (encoding, big_endian, step) = (fields.text()?, fields.u8()?, fields.u32()?);
            let data = fields.run()?;
            Some(Self { stamp_us, size: (width, height), encoding, big_endian: big_endian != 0, step, data })
        };
        read().ok_or(Fault::Short)
    }

    /// Returns the pixels as depth (Z16, little-endian) or as brightness (Y8), of the `size` that must be.
    pub(super) fn pixels(&self, stream: Stream, size: (u32, u32)) -> Result<Vec<u8>, Fault> {
        if self.size != size {
            return Err(Fault::Size([self.size.0, self.size.1], [size.0, size.1]));
        }
        let unread = || Fault::Encoding(self.encoding.chars().take(40).collect());
        let pixel = Pixel::of(self.encoding).ok_or_else(unread)?;
        let depth = matches!(pixel, Pixel::Depth16 | Pixel::DepthFloat);
        if depth != (stream == Stream::Depth) {
            return Err(unread());
        }
        let (width, height) = (size.0 as usize, size.1 as usize);
        let row = width * pixel.bytes();
        let step = self.step as usize;
        // The last row may lack its padding.
        let needed = step.checked_mul(height.saturating_sub(1)).and_then(|before| before.checked_add(row));
        if step < row || needed.is_none_or(|needed| self.data.len() < needed) {
            return Err(Fault::Rows);
        }
        let rows = (0..height).map(|y| &self.data[y * step..y * step + row]);
        Ok(rows.flat_map(|row| self.row(row, pixel)).collect())
    }

    /// Converts a row.
    fn row(&self, row: &[u8], pixel: Pixel) -> Vec<u8> {
        match pixel {
            Pixel::Grey => row.to_vec(),
            Pixel::Depth16 if self.big_endian => {
                row.as_chunks::<2>().0.iter().flat_map(|[high, low]| [*low, *high]).collect()
            }
            Pixel::Depth16 => row.to_vec(),
            Pixel::DepthFloat => {
                let metres = |bytes: &[u8; 4]| match self.big_endian {
                    true => f32::from_be_bytes(*bytes),
                    false => f32::from_le_bytes(*bytes),
                };
                // Beyond the range, as NaN and infinity, is nothing seen.
                let units = |bytes: &[u8; 4]| {
                    let units = (metres(bytes) / FLOAT_UNIT_M).round();
                    if (0.0..=f32::from(u16::MAX)).contains(&units) { units as u16 } else { 0 }
                };
                row.as_chunks::<4>().0.iter().flat_map(|bytes| units(bytes).to_le_bytes()).collect()
            }
            Pixel::Colour([red, green, blue], bytes) => {
                // Luma of ITU-R BT.601, in 1/256.
                let luma = |p: &[u8]| {
                    (77 * u32::from(p[red]) + 150 * u32::from(p[green]) + 29 * u32::from(p[blue]) + 128) >> 8
                };
                row.chunks_exact(bytes).map(|pixel| luma(pixel) as u8).collect()
            }
        }
    }
}

/// `sensor_msgs/CameraInfo`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Info {
    /// Pixels in a row, rows.
    pub(super) size: (u32, u32),
    /// Coefficients of distortion.
    pub(super) distortion: Vec<f64>,
    /// Intrinsic matrix, row by row.
    pub(super) k: [f64; 9],
    /// Projection of the rectified image, row by row.
    pub(super) p: [f64; 12],
}

/// Most coefficients of distortion.
const COEFFICIENTS: u32 = 64;

impl Info {
    /// Reads a message.
    pub(super) fn read(data: &[u8], aligned: bool) -> Result<Self, Fault> {
        let mut fields = fields(data, aligned)?;
        let mut read = || {
            stamp_us(&mut fields, aligned)?;
            let (height, width) = (fields.u32()?, fields.u32()?);
            let _model = fields.run()?;
            let count = Some(fields.u32()?).filter(|count| *count <= COEFFICIENTS)?;
            let distortion = (0..count).map(|_| fields.f64()).collect::<Option<Vec<_>>>()?;
            let mut row =
                |out: &mut [f64]| out.iter_mut().try_for_each(|value| fields.f64().map(|read| *value = read));
            let (mut k, mut r, mut p) = ([0.0; 9], [0.0; 9], [0.0; 12]);
            row(&mut k)?;
            row(&mut r)?;
            row(&mut p)?;
            Some(Self { size: (width, height), distortion, k, p })
        };
        read().ok_or(Fault::Short)
    }
}
