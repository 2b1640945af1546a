//! Font and colours of every picture. The font comes with the program; the colours are distinguishable to the
//! colour-blind.

use plotters::chart::{ChartContext, SeriesLabelPosition};
use plotters::coord::CoordTranslate;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{DrawingBackend, WHITE};
use plotters::style::{FontStyle, RGBColor, register_font};
use std::sync::Once;

/// Why a picture could not be drawn or written.
#[derive(Debug)]
pub struct PictureError(pub String);

impl std::fmt::Display for PictureError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the picture cannot be drawn: {}", self.0)
    }
}

impl std::error::Error for PictureError {}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PictureError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self(error.to_string())
    }
}

/// Family name under which the font is registered.
pub const FONT: &str = "sans-serif";

/// Family name of the font whose letters are equally wide.
pub const MONOSPACE: &str = "monospace";

/// Colours of lines, after Okabe and Ito (2008).
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
/// Orange of the same set.
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Bluish green of the same set.
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
/// Reddish purple of the same set.
pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
/// Vermilion of Okabe and Ito.
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
/// Sky blue of the same set.
pub const SKY: RGBColor = RGBColor(86, 180, 233);
/// Grey for what is only there to compare with.
pub const GREY: RGBColor = RGBColor(130, 130, 130);

/// Draws the names of a chart's series in a box at `position`.
///
/// # Errors
/// What the backend says.
pub fn legend<'a, DB: DrawingBackend + 'a, CT: CoordTranslate>(
    chart: &mut ChartContext<'a, DB, CT>,
    position: SeriesLabelPosition,
) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    chart
        .configure_series_labels()
        .label_font((FONT, 14))
        .position(position)
        .background_style(WHITE)
        .border_style(GREY)
        .draw()
}

/// Makes the fonts known to plotters, once.
pub fn prepare_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for style in [FontStyle::Normal, FontStyle::Bold] {
            // It can only refuse bytes that are no font.
            let _known = register_font(FONT, style, dejavu::sans::regular());
            let _known = register_font(MONOSPACE, style, dejavu::sans_mono::regular());
        }
    });
}
