//! `--outline`: the image in which the outline is traced, and whether the liquid is clear.

use meniscus_usb::camera::OutlineImage;

/// Image of the outline and kind of liquid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Outline {
    /// An opaque liquid in the left infrared image.
    #[default]
    Infrared,
    /// An opaque liquid in the colour image.
    Colour,
    /// A clear liquid in the left infrared image, before a bright card.
    Clear,
}

impl Outline {
    /// The image.
    pub(crate) fn image(self) -> OutlineImage {
        match self {
            Self::Infrared | Self::Clear => OutlineImage::Infrared,
            Self::Colour => OutlineImage::Colour,
        }
    }
}

impl std::fmt::Display for Outline {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Clear => f.write_str("clear"),
            Self::Infrared | Self::Colour => self.image().fmt(f),
        }
    }
}

impl std::str::FromStr for Outline {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "clear" => Ok(Self::Clear),
            image => match image.parse() {
                Ok(OutlineImage::Infrared) => Ok(Self::Infrared),
                Ok(OutlineImage::Colour) => Ok(Self::Colour),
                Err(_) => Err("there are infrared, colour and clear"),
            },
        }
    }
}
