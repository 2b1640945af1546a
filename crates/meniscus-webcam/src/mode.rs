//! Modes of a webcam.

/// Format of an image on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Luma and colour in turns, two bytes a pixel.
    Yuyv,
    /// One JPEG an image.
    Mjpg,
}

impl PixelFormat {
    /// Both, the one without a loss first.
    pub const ALL: [Self; 2] = [Self::Yuyv, Self::Mjpg];

    /// Returns its code of four letters.
    #[must_use]
    pub const fn code(self) -> [u8; 4] {
        match self {
            Self::Yuyv => *b"YUYV",
            Self::Mjpg => *b"MJPG",
        }
    }
}

impl std::fmt::Display for PixelFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Yuyv => "YUYV",
            Self::Mjpg => "MJPG",
        })
    }
}

/// Format, size and rate of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Format on the wire.
    pub format: PixelFormat,
    /// Pixels in a row, rows.
    pub size: [u16; 2],
    /// Time from frame to frame as a fraction of a second.
    pub interval: [u32; 2],
}

impl Mode {
    /// Frames a second.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        f64::from(self.interval[1]) / f64::from(self.interval[0].max(1))
    }
}

impl std::fmt::Display for Mode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.size;
        write!(f, "{width}x{height} {} at {:.0} Hz", self.format, self.rate_hz())
    }
}
