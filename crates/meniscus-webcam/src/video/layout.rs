//! Video4Linux's structures as the kernel lays them out.
//!
//! Source: the kernel's user interface, `linux/videodev2.h` and `linux/v4l2-controls.h`. Sizes and places at the end of this file are
//! those of that header on 64-bit systems.

/// Images of a camera.
pub(super) const CAPTURE: u32 = 1;
/// Buffers of the driver, mapped.
pub(super) const MMAP: u32 = 1;
pub(super) const CAN_CAPTURE: u32 = 0x0000_0001;
pub(super) const CAN_STREAM: u32 = 0x0400_0000;
/// `device_caps` are those of this device, `capabilities` those of all of the camera.
pub(super) const HAS_DEVICE_CAPS: u32 = 0x8000_0000;
pub(super) const BUFFER_DAMAGED: u32 = 0x0000_0040;
pub(super) const DISCRETE: u32 = 1;
/// Control: the rate may fall for a longer exposure.
pub(super) const EXPOSURE_AUTO_PRIORITY: u32 = 0x009a_0903;

macro_rules! plain {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default)]
        pub(super) struct $name { $(pub(super) $field: $type,)* }
    };
}

plain!(
    /// `v4l2_capability`.
    Capability {
        driver: [u8; 16],
        card: [u8; 32],
        bus_info: [u8; 32],
        version: u32,
        capabilities: u32,
        device_caps: u32,
        reserved: [u32; 3],
    }
);
plain!(
    /// `v4l2_fmtdesc`.
    FormatDescription {
        index: u32,
        kind: u32,
        flags: u32,
        description: [u8; 32],
        pixel_format: u32,
        mbus_code: u32,
        reserved: [u32; 3],
    }
);
plain!(
    /// `v4l2_frmsizeenum`: `size` is width and height where it is discrete, else their least, greatest and step.
    FrameSize {
        index: u32,
        pixel_format: u32,
        kind: u32,
        size: [u32; 6],
        reserved: [u32; 2],
    }
);
plain!(
    /// `v4l2_frmivalenum`: `interval` is one fraction where it is discrete, else least, greatest and step.
    FrameInterval {
        index: u32,
        pixel_format: u32,
        width: u32,
        height: u32,
        kind: u32,
        interval: [[u32; 2]; 3],
        reserved: [u32; 2],
    }
);
plain!(
    /// `v4l2_pix_format`.
    PixFormat {
        width: u32,
        height: u32,
        pixel_format: u32,
        field: u32,
        bytes_per_line: u32,
        size_image: u32,
        rest: [u32; 6],
    }
);
plain!(
    /// `v4l2_control`.
    Control {
        id: u32,
        value: i32,
    }
);
plain!(
    /// `v4l2_requestbuffers`.
    BufferRequest {
        count: u32,
        kind: u32,
        memory: u32,
        capabilities: u32,
        flags: u32,
    }
);
plain!(
    /// `v4l2_buffer`; `place` is its offset of 32 bits in a mapping.
    Buffer {
        index: u32,
        kind: u32,
        bytes_used: u32,
        flags: u32,
        field: u32,
        timestamp: [i64; 2],
        timecode: [u32; 4],
        sequence: u32,
        memory: u32,
        place: u64,
        length: u32,
        reserved: u32,
        request_fd: u32,
    }
);

/// `v4l2_format`: the images' format lies at the start of a union of 200 bytes that also holds pointers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Format {
    pub(super) kind: u32,
    align: [u64; 0],
    pub(super) pix: PixFormat,
    rest: [u32; 38],
}

impl Format {
    pub(super) fn of(pix: PixFormat) -> Self {
        Self { kind: CAPTURE, align: [], pix, rest: [0; 38] }
    }
}

/// `v4l2_streamparm`: capability, mode and interval lie at the start of a union of 200 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamParameters {
    kind: u32,
    capability: u32,
    mode: u32,
    pub(super) interval: [u32; 2],
    rest: [u32; 46],
}

impl StreamParameters {
    pub(super) fn of(interval: [u32; 2]) -> Self {
        Self { kind: CAPTURE, capability: 0, mode: 0, interval, rest: [0; 46] }
    }
}

/// Sizes of the structures on 64-bit systems; on others nothing here is compiled.
const _: () = {
    assert!(size_of::<usize>() == 8, "the structures are those of 64-bit systems");
    assert!(size_of::<Capability>() == 104 && size_of::<FormatDescription>() == 64);
    assert!(size_of::<FrameSize>() == 44 && size_of::<FrameInterval>() == 52);
    assert!(size_of::<PixFormat>() == 48 && size_of::<Format>() == 208);
    assert!(size_of::<StreamParameters>() == 204 && size_of::<Control>() == 8);
    assert!(size_of::<BufferRequest>() == 20 && size_of::<Buffer>() == 88);
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn fields_have_the_kernels_places() {
        assert_eq!(offset_of!(Format, pix), 8);
        assert_eq!(offset_of!(StreamParameters, interval), 12);
        assert_eq!([offset_of!(Buffer, timestamp), offset_of!(Buffer, sequence)], [24, 56]);
        assert_eq!([offset_of!(Buffer, place), offset_of!(Buffer, length)], [64, 72]);
    }
}
