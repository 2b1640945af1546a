//! Measures of the glass on the command line.

use meniscus_service::setup::MeasuredGlass;

/// The rim of a glass of which nobody says it, above the fill, mm.
const RIM_MM: f64 = 40.0;

/// Measures of a glass as somebody took them.
#[derive(clap::Args)]
pub(super) struct GlassArguments {
    /// Inner radius of the glass, mm, 10 to 60 [default: 35].
    #[arg(long, value_name = "MM", required_if_eq("yes", "true"), help_heading = "Glass")]
    radius_mm: Option<f64>,
    /// Height of the liquid at rest above the inner bottom, mm, 15 to 200 [default: 70].
    #[arg(long, value_name = "MM", required_if_eq("yes", "true"), help_heading = "Glass")]
    fill_mm: Option<f64>,
    /// Height of the rim above the inner bottom, mm, 20 to 300 [default: 40 above the fill].
    #[arg(long, value_name = "MM", help_heading = "Glass")]
    rim_mm: Option<f64>,
    /// Thickness of the wall at the height of the liquid, mm, 0 to 6 [default: as the silhouette shows].
    ///
    /// Of a wall of more than 1 mm. The silhouette is then that of the outer wall, and what is behind it is refracted.
    #[arg(long, value_name = "MM", help_heading = "Glass")]
    wall_mm: Option<f64>,
    /// Thickness of the base, mm, 0 to 30 [default: thin].
    ///
    /// A thick base may show the colour of the liquid above it.
    #[arg(long, value_name = "MM", help_heading = "Glass")]
    base_mm: Option<f64>,
}

impl GlassArguments {
    /// The measures, and those of the shipped model's glass where one is left out.
    pub(super) fn said(&self) -> MeasuredGlass {
        let fill_mm = self.fill_mm.unwrap_or(70.0);
        MeasuredGlass {
            radius_mm: self.radius_mm.unwrap_or(35.0),
            fill_mm,
            rim_mm: self.rim_mm.unwrap_or(fill_mm + RIM_MM),
            wall_mm: self.wall_mm,
            base_mm: self.base_mm,
        }
    }
}
