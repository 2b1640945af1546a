//! Pairs of images as they come, and the mean of some of them: a portrait of a glass that stands still.

use meniscus::surface::{
    Config, ExtractionError, ExtractionState, Intrinsics, Optics, OutlineAssembler, Region, SurfaceProfile,
    extract, extract_outline,
};
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Pairer, Stream};
use std::collections::VecDeque;
use std::time::Instant;

/// The camera's frame interval, microseconds.
const INTERVAL_US: u32 = 16_667;

/// Two images of one exposure, or the outline's alone.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Z16, little-endian; `None` of a camera without depth.
    pub depth: Option<Vec<u8>>,
    /// Y8, in which the outline is traced.
    pub outline: Vec<u8>,
    /// Stamp of the depth image, or of the outline's alone.
    pub stamp: Stamp,
}

impl Pair {
    /// Takes the images through the extractor.
    pub(super) fn extract(
        &self,
        config: &Config,
        state: &mut ExtractionState,
    ) -> Result<SurfaceProfile, ExtractionError> {
        let (stamp, (width, height)) = (self.stamp, config.image_size());
        let outline = OutlineFrame { bytes: &self.outline, width, height, stamp };
        match &self.depth {
            Some(depth) => extract(config, state, DepthFrame { bytes: depth, width, height, stamp }, outline),
            None => extract_outline(config, state, outline),
        }
    }
}

/// The newest pairs, and how many came.
#[derive(Debug)]
pub struct Recent {
    pairs: VecDeque<Pair>,
    room: usize,
    total: u64,
    first: Option<Instant>,
    last: Option<Instant>,
}

impl Recent {
    /// Room for the newest `room` pairs.
    #[must_use]
    pub fn with_room(room: usize) -> Self {
        Self { pairs: VecDeque::with_capacity(room), room, total: 0, first: None, last: None }
    }

    /// Takes a pair; the oldest makes room for it.
    pub fn push(&mut self, pair: Pair) {
        if self.pairs.len() == self.room {
            self.pairs.pop_front();
        }
        self.pairs.push_back(pair);
        let now = Instant::now();
        self.first.get_or_insert(now);
        self.last = Some(now);
        self.total += 1;
    }

    /// Pairs since the start.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Pairs a second; 0 before the second one.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        let time = self.first.zip(self.last).map(|(first, last)| (last - first).as_secs_f64());
        time.filter(|time| *time > 0.0).map_or(0.0, |time| self.total.saturating_sub(1) as f64 / time)
    }

    /// The newest pairs, at most `count`, oldest first.
    #[must_use]
    pub fn newest(&self, count: usize) -> Vec<Pair> {
        self.pairs.iter().skip(self.pairs.len().saturating_sub(count)).cloned().collect()
    }
}

/// Payloads to pairs.
#[derive(Debug)]
pub struct Gather<'b> {
    /// Depth images and their pairing, where the camera has them.
    depth: Option<(Assembler<'b>, Pairer)>,
    outline: OutlineAssembler<'b>,
    size: (usize, usize),
    clock: DeviceClock,
}

impl<'b> Gather<'b> {
    /// Assembles images of `size`; depth into a buffer of one (two bytes a pixel), or of two where `outline` keeps two as well.
    #[must_use]
    pub fn new(size: (usize, usize), depth: &'b mut [u8], outline: OutlineAssembler<'b>) -> Self {
        let two = depth.len() >= 4 * size.0 * size.1;
        let depth = if two { Assembler::keeping_two(depth) } else { Assembler::new(depth) };
        let pairer = Pairer::new(INTERVAL_US, depth.kept().min(outline.kept()));
        Self { depth: Some((depth, pairer)), ..Self::of_outline(size, outline) }
    }

    /// Gathers the outline's images of `size` of a camera without depth.
    #[must_use]
    pub fn of_outline(size: (usize, usize), outline: OutlineAssembler<'b>) -> Self {
        Self { depth: None, outline, size, clock: DeviceClock::default() }
    }

    /// Takes a payload; a pair if it completes one.
    pub fn take(&mut self, stream: Stream, payload: &[u8]) -> Option<Pair> {
        let Self { depth, outline, size, clock } = self;
        let stamp = match (stream, &mut *depth) {
            (Stream::Depth, None) => return None,
            (Stream::Depth, Some((depth, _))) => match depth.push(payload, clock) {
                AssemblyOutcome::Frame(frame) => frame.stamp,
                AssemblyOutcome::Partial | AssemblyOutcome::Lost(_) => return None,
            },
            (Stream::Outline, _) => outline.push(payload, Region::whole(*size), clock)?,
        };
        let Some((depth, pairer)) = depth else {
            return Some(Pair { depth: None, outline: outline.pixels().to_vec(), stamp });
        };
        let pair = pairer.offer(stream, stamp)?;
        let (depth, outline) = (depth.pixels_of(pair.depth)?, outline.pixels_of(pair.outline)?);
        Some(Pair { depth: Some(depth.to_vec()), outline: outline.to_vec(), stamp: pair.depth })
    }
}

/// The mean of some pairs.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Mean grey level of each pixel.
    pub grey: Vec<f32>,
    /// Mean depth of each pixel where there was one, metres; 0 where more than half of the pairs had none.
    pub depth_m: Vec<f32>,
}

impl Portrait {
    /// The mean of `pairs` of a camera of these optics; pairs of another size are left out. `None` where no pair is
    /// left.
    ///
    /// Where the outline has a lens of its own the depth is that of its pixels: every depth pixel as a point of the
    /// room, put where that lens sees it, the nearest where two meet.
    #[must_use]
    pub fn of(pairs: &[Pair], optics: &Optics) -> Option<Self> {
        let (width, height) = (optics.intrinsics.width, optics.intrinsics.height);
        let pixels = width * height;
        let fits = |pair: &&Pair| {
            pair.outline.len() == pixels && pair.depth.as_ref().is_none_or(|depth| depth.len() == 2 * pixels)
        };
        let (mut grey, mut depth) = (vec![0.0_f32; pixels], vec![(0_u32, 0_u32); pixels]);
        let mut count = 0_u32;
        for pair in pairs.iter().filter(fits) {
            count += 1;
            grey.iter_mut().zip(&pair.outline).for_each(|(sum, pixel)| *sum += f32::from(*pixel));
            for ((sum, seen), raw) in
                depth.iter_mut().zip(pair.depth.as_deref().unwrap_or_default().as_chunks().0)
            {
                let raw = u16::from_le_bytes(*raw);
                *sum += u32::from(raw);
                *seen += u32::from(raw > 0);
            }
        }
        if count == 0 {
            return None;
        }
        grey.iter_mut().for_each(|sum| *sum /= count as f32);
        let mean = |(sum, seen): (u32, u32)| {
            if 2 * seen > count { optics.depth_unit_m * sum as f32 / seen as f32 } else { 0.0 }
        };
        let depth_m: Vec<f32> = depth.into_iter().map(mean).collect();
        let depth_m = if optics.depth_lens_m == [0.0; 3] { depth_m } else { aligned(&depth_m, optics) };
        Some(Self { width, height, grey, depth_m })
    }

    /// Grey level of a pixel; 0 outside.
    pub(super) fn grey(&self, column: usize, row: usize) -> f32 {
        let inside = column < self.width && row < self.height;
        if inside { self.grey.get(row * self.width + column).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// Depth of a pixel, metres; `None` in a hole and outside.
    pub(super) fn depth_m(&self, column: usize, row: usize) -> Option<f32> {
        let inside = column < self.width && row < self.height;
        let depth_m = self.depth_m.get(row * self.width + column).copied();
        depth_m.filter(|depth_m| inside && *depth_m > 0.0)
    }
}

/// Depths as the lens of the outline has them. A pixel there that no depth pixel falls on, because the two grids do
/// not match, takes its left neighbour's.
fn aligned(depth_m: &[f32], optics: &Optics) -> Vec<f32> {
    let Intrinsics { width, height, fx, fy, ppx, ppy } = optics.intrinsics;
    let [right, down, forward] = optics.depth_lens_m;
    let mut out = vec![0.0_f32; depth_m.len()];
    for (at, &z) in depth_m.iter().enumerate().filter(|(_, z)| **z > 0.0) {
        let (u, v) = ((at % width) as f32, (at / width) as f32);
        let far = z + forward;
        let u = ppx + (z * (u - ppx) + fx * right) / far;
        let v = ppy + (z * (v - ppy) + fy * down) / far;
        let (u, v) = (u.round(), v.round());
        if u >= 0.0 && v >= 0.0 && (u as usize) < width && (v as usize) < height {
            let to = &mut out[v as usize * width + u as usize];
            if *to == 0.0 || far < *to {
                *to = far;
            }
        }
    }
    for row in out.chunks_exact_mut(width) {
        for u in (1..width).rev() {
            if row[u] == 0.0 {
                row[u] = row[u - 1];
            }
        }
    }
    out
}
