//! Numbers and texts one after the other, as ROS writes them: packed (ROS 1) or aligned to their size (ROS 2,
//! CDR little-endian behind four bytes).

/// Bytes yet to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'b> {
    bytes: &'b [u8],
    at: usize,
    aligned: bool,
}

impl<'b> Fields<'b> {
    /// Packed.
    pub(super) fn packed(bytes: &'b [u8]) -> Self {
        Self { bytes, at: 0, aligned: false }
    }

    /// Aligned, behind the encapsulation header; `None` unless that says little-endian CDR.
    pub(super) fn cdr(bytes: &'b [u8]) -> Option<Self> {
        let (header, body) = bytes.split_first_chunk::<4>()?;
        (header[1] == 1).then_some(Self { bytes: body, at: 0, aligned: true })
    }

    fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        if self.aligned {
            self.at = self.at.next_multiple_of(N);
        }
        self.take(N)?.first_chunk().copied()
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.number::<1>().map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(super) fn f32(&mut self) -> Option<f32> {
        self.number().map(f32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    /// A length and as many bytes.
    pub(super) fn run(&mut self) -> Option<&'b [u8]> {
        let length = self.u32()?;
        self.take(length as usize)
    }

    /// A text, without the zero that CDR ends it with.
    pub(super) fn text(&mut self) -> Option<&'b str> {
        let bytes = self.run()?;
        std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes)).ok()
    }
}
