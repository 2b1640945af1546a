//! The camera's image with the measured points and the estimated surface on it.

use super::{CameraImage, Panel, Picture};
use crate::wrapped::wrapped;
use meniscus_report::plot::{FONT, GREEN, ORANGE, PictureError};
use plotters::prelude::*;

impl Picture<'_> {
    pub(super) fn draw_camera(&self, panel: &Panel<'_>) -> Result<(), PictureError> {
        let letter = self.letter(18);
        let mut panel = panel.clone();
        for line in
            wrapped("measured orange, estimated green", (2 * panel.dim_in_pixel().0 / letter) as usize)
        {
            panel = panel.titled(&line, (FONT, letter))?;
        }
        self.camera.draw(&panel)
    }
}

impl CameraImage<'_> {
    /// Draws the image with its points and its line into the middle of `panel`.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn draw(&self, panel: &Panel<'_>) -> Result<(), PictureError> {
        let (left, top, width, height) = self.crop;
        let (across, down) = panel.dim_in_pixel();
        let zoom = (f64::from(across) / width as f64).min(f64::from(down) / height as f64);
        let aside = [f64::from(across) - zoom * width as f64, f64::from(down) - zoom * height as f64]
            .map(|a| 0.5 * a);
        let place = |u: f64, v: f64| {
            let x = aside[0] + (u + 0.5 - left as f64) * zoom;
            let y = aside[1] + (v + 0.5 - top as f64) * zoom;
            (x.round() as i32, y.round() as i32)
        };
        for row in top..top + height {
            for column in left..left + width {
                let grey = self.infrared.get(row * self.size.0 + column).copied().unwrap_or(0);
                let (u, v) = (column as f64, row as f64);
                let box_ = [place(u - 0.5, v - 0.5), place(u + 0.5, v + 0.5)];
                panel.draw(&Rectangle::new(box_, RGBColor(grey, grey, grey).filled()))?;
            }
        }
        let pixel = |&(u, v): &(f32, f32)| place(f64::from(u), f64::from(v));
        for point in &self.measured {
            panel.draw(&Circle::new(pixel(point), 5, ORANGE.filled()))?;
        }
        let line: Vec<_> = self.estimated.iter().map(pixel).collect();
        panel.draw(&PathElement::new(line, GREEN.stroke_width(2)))?;
        Ok(())
    }
}
