//! Why a folder of images cannot be played.

use std::path::PathBuf;

/// Fault of a folder of images.
#[derive(Debug)]
pub enum PicturesError {
    /// The folder or a file of it cannot be read.
    Read(PathBuf, std::io::Error),
    /// It has fewer than two images.
    NoImages(PathBuf),
    /// Neither a table nor the names have times.
    NoTimes {
        /// The folder.
        folder: PathBuf,
        /// One of its images.
        example: String,
    },
    /// More than one table.
    Tables(PathBuf),
    /// A row of the table is no time.
    Row {
        /// The table.
        table: PathBuf,
        /// Its line.
        line: usize,
        /// The row.
        shown: String,
    },
    /// A row names a file that is not there.
    NoFile {
        /// The table.
        table: PathBuf,
        /// Its line.
        line: usize,
    },
    /// Not as many times as images.
    Fewer {
        /// The table.
        table: PathBuf,
        /// Times.
        times: usize,
        /// Images.
        images: usize,
    },
    /// A time does not come after the one before.
    NotRising {
        /// The image.
        file: PathBuf,
        /// Its time, s.
        time_s: f64,
        /// Time of the image before, s.
        before_s: f64,
    },
    /// A file is no image that can be read.
    Image(PathBuf, String),
    /// An image has another size than the first.
    Size(PathBuf),
}

impl std::fmt::Display for PicturesError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Read(path, error) => write!(f, "cannot read {}: {error}", path.display()),
            Self::NoImages(folder) => {
                write!(
                    f,
                    "{} holds no two images (.png, .jpg): give the folder that has them",
                    folder.display()
                )
            }
            Self::NoTimes { folder, example } => write!(
                f,
                "the images in {} have no times: put a table times.csv beside them, a line 'file,seconds' for each, or give \
                 them names with their time, as 12.345678.png; {example} has the number of a frame at the most",
                folder.display()
            ),
            Self::Tables(folder) => {
                write!(
                    f,
                    "{} has more than one .csv file: leave the one with the times of the images",
                    folder.display()
                )
            }
            Self::Row { table, line, shown } => write!(
                f,
                "{}, line {line}: '{shown}' is no time (seconds, not negative), alone or beside the name of an image",
                table.display()
            ),
            Self::NoFile { table, line } => {
                write!(
                    f,
                    "{}, line {line}: its image is not in the folder: take the line out",
                    table.display()
                )
            }
            Self::Fewer { table, times, images } => write!(
                f,
                "{} has {times} times for {images} images: give each image a line, or take images away",
                table.display()
            ),
            Self::NotRising { file, time_s, before_s } => write!(
                f,
                "{} is of {time_s} s, and the image before it of {before_s} s: times must rise from image to image",
                file.display()
            ),
            Self::Image(path, why) => write!(f, "{} is no image that can be read: {why}", path.display()),
            Self::Size(path) => {
                write!(
                    f,
                    "{} has another size than the first image: they must be of one camera",
                    path.display()
                )
            }
        }
    }
}

impl std::error::Error for PicturesError {}
