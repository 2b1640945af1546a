//! Containers as files, opened for reading.

use super::BagError;
use meniscus_platform::files::{Links, open_regular};
use std::fs::File;
use std::path::Path;

/// Opens the regular file at `path`.
///
/// # Errors
/// [`BagError::Io`].
pub(crate) fn opened(path: &Path) -> Result<File, BagError> {
    let file = open_regular(path, Links::Followed);
    file.map_err(|cause| BagError::Io { path: path.into(), doing: "open", cause })
}
