//! Analytic images of an upright cylinder before a bright room: exact geometry in double precision, no noise.
#![allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]

extern crate std;

use super::{Config, Settings};
use crate::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use std::ops::Range;
use std::vec;
use std::vec::Vec;

/// Grey of the liquid and of the room.
pub(super) const TONES: (u8, u8) = (40, 180);

/// Depth of the room behind the glass, m.
pub(super) const ROOM_M: f64 = 0.9;

/// A glass and the camera before it.
#[derive(Clone, Copy)]
pub(super) struct Scene {
    pub(super) settings: Settings,
    /// Axis of the glass, right and away of where the settings have it, m.
    pub(super) axis_m: f64,
    pub(super) farther_m: f64,
    /// Radius of the cylinder that is seen, m.
    pub(super) radius_m: f64,
    /// Height of the surface on the wall at a distance x to the right of the axis, m.
    pub(super) surface: fn(f64) -> f64,
}

/// Point of the cylinder on a ray: depth along the optical axis, distance to the right of the axis, height, m.
#[derive(Clone, Copy)]
pub(super) struct Hit {
    pub(super) depth_m: f64,
    pub(super) x_m: f64,
    pub(super) z_m: f64,
}

impl Scene {
    pub(super) fn of(settings: Settings) -> Self {
        Self {
            settings,
            axis_m: 0.0,
            farther_m: 0.0,
            radius_m: f64::from(settings.radius_m),
            surface: |_| 0.07,
        }
    }

    pub(super) fn config(&self) -> Config {
        Config::new(self.settings).expect("sound")
    }

    /// Directions of the camera: right, down and forward, in the room's right, away and up.
    fn axes(&self) -> [[f64; 3]; 3] {
        let (sin, cos) = f64::from(self.settings.camera_pitch_rad).sin_cos();
        [[1.0, 0.0, 0.0], [0.0, sin, -cos], [0.0, cos, sin]]
    }

    /// Place of the lens that stands `apart` from the outline's: right, down and forward along its axes.
    fn lens(&self, apart: [f32; 3]) -> [f64; 3] {
        let mut place =
            [0.0, -f64::from(self.settings.camera_distance_m), f64::from(self.settings.camera_height_m)];
        for (axis, along) in self.axes().into_iter().zip(apart) {
            for (place, axis) in place.iter_mut().zip(axis) {
                *place += f64::from(along) * axis;
            }
        }
        place
    }

    /// The wall that faces the lens `apart` at a position of its image; none beside the glass.
    pub(super) fn hit(&self, apart: [f32; 3], column: f64, row: f64) -> Option<Hit> {
        let lens = &self.settings.intrinsics;
        let across = (column - f64::from(lens.ppx)) / f64::from(lens.fx);
        let down = (row - f64::from(lens.ppy)) / f64::from(lens.fy);
        let [right, below, forward] = self.axes();
        let ray: [f64; 3] = std::array::from_fn(|k| across * right[k] + down * below[k] + forward[k]);
        let [x, y, z] = self.lens(apart);
        let (x, y) = (x - self.axis_m, y - self.farther_m);
        let (a, b) = (ray[0] * ray[0] + ray[1] * ray[1], x * ray[0] + y * ray[1]);
        let discriminant = b * b - a * (x * x + y * y - self.radius_m * self.radius_m);
        let depth_m = (discriminant > 0.0).then(|| (-b - discriminant.sqrt()) / a)?;
        Some(Hit { depth_m, x_m: x + depth_m * ray[0], z_m: z + depth_m * ray[2] })
    }

    /// Position in the image of the lens `apart` of a point of the wall at height `z_m` in the outline's column; by bisection.
    pub(super) fn row_of(&self, column: usize, z_m: f64) -> Option<f64> {
        let (mut above, mut below) = (0.0, self.settings.intrinsics.height as f64);
        for _ in 0..60 {
            let middle = 0.5 * (above + below);
            let higher = self.hit([0.0; 3], column as f64, middle)?.z_m > z_m;
            *(if higher { &mut above } else { &mut below }) = middle;
        }
        Some(above)
    }

    /// Whether the liquid is seen at a position of the outline's image.
    fn wet(&self, column: f64, row: f64) -> bool {
        let hit = self.hit([0.0; 3], column, row);
        hit.is_some_and(|hit| (0.0..(self.surface)(hit.x_m)).contains(&hit.z_m))
    }

    /// The pair of images.
    pub(super) fn images(&self) -> Images {
        let lens = self.settings.intrinsics;
        let mut images = Images {
            depth: vec![0; 2 * lens.width * lens.height],
            outline: vec![TONES.1; lens.width * lens.height],
            size: (lens.width, lens.height),
            unit_m: f64::from(self.settings.depth_unit_m),
        };
        images.fill(0..lens.width, 0..lens.height, |_, _| ROOM_M);
        for row in 0..lens.height {
            for column in self.columns() {
                let hit = self.hit(self.settings.depth_lens_m, column as f64, row as f64);
                if let Some(liquid) = hit.filter(|hit| (0.0..(self.surface)(hit.x_m)).contains(&hit.z_m)) {
                    images.set(column, row, liquid.depth_m);
                }
                images.outline[row * lens.width + column] = self.grey(column as f64, row as f64);
            }
        }
        images
    }

    /// Columns that may show the glass.
    fn columns(&self) -> Range<usize> {
        let lens = &self.settings.intrinsics;
        let distance_m = f64::from(self.settings.camera_distance_m);
        let middle = f64::from(lens.ppx) + f64::from(lens.fx) * self.axis_m / distance_m;
        (middle - 80.0).max(0.0) as usize..((middle + 80.0) as usize).min(lens.width)
    }

    /// Mean grey of a pixel, over 4 by 4 places in it where its corners differ.
    fn grey(&self, column: f64, row: f64) -> u8 {
        let wet = |x: i32, y: i32| self.wet(column + f64::from(x) / 8.0, row + f64::from(y) / 8.0);
        let (liquid, room) = (f64::from(TONES.0), f64::from(TONES.1));
        let corners = [(-4, -4), (4, -4), (-4, 4), (4, 4)].map(|(x, y)| wet(x, y));
        if corners == [corners[0]; 4] {
            return if corners[0] { TONES.0 } else { TONES.1 };
        }
        let count = (0..16).filter(|k| wet(2 * (k % 4) - 3, 2 * (k / 4) - 3)).count();
        (room + (liquid - room) * count as f64 / 16.0) as u8
    }
}

/// A pair of images, in which single pixels may be replaced.
#[derive(Clone)]
pub(super) struct Images {
    pub(super) depth: Vec<u8>,
    pub(super) outline: Vec<u8>,
    size: (usize, usize),
    unit_m: f64,
}

impl Images {
    /// Sets the depth of a pixel; zero is a hole.
    pub(super) fn set(&mut self, column: usize, row: usize, depth_m: f64) {
        let at = 2 * (row * self.size.0 + column);
        let raw = (depth_m / self.unit_m).round();
        assert!((0.0..65_536.0).contains(&raw));
        self.depth[at..at + 2].copy_from_slice(&(raw as u16).to_le_bytes());
    }

    /// Replaces the depths of a rectangle by what `of` makes of column and row.
    pub(super) fn fill(
        &mut self,
        columns: Range<usize>,
        rows: Range<usize>,
        of: impl Fn(usize, usize) -> f64,
    ) {
        for row in rows {
            columns.clone().for_each(|column| self.set(column, row, of(column, row)));
        }
    }

    pub(super) fn lent(&self, sequence: u32) -> (DepthFrame<'_>, OutlineFrame<'_>) {
        let (width, height) = self.size;
        let stamp = Stamp { sequence, ..Stamp::default() };
        (
            DepthFrame { bytes: &self.depth, width, height, stamp },
            OutlineFrame { bytes: &self.outline, width, height, stamp },
        )
    }
}
