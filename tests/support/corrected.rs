//! The shipped model as a correction from the free surface would leave it: with the same weights, and surface and positions known.

use meniscus::blob::{BEFORE, Header, KnownGroups};
use meniscus_data::blob_file::read::parts;
use meniscus_data::blob_file::write::blob;
use meniscus_platform::files::AlignedBytes;

/// Bytes of the model.
pub(crate) fn corrected() -> AlignedBytes {
    let (header, parts) = parts(&AlignedBytes::copy(meniscus_shipped::MODEL)).expect("the shipped model");
    let header = Header {
        liquid: "water from glycerine".try_into().expect("short"),
        provenance: format!("meniscus correct{BEFORE}meniscus train").as_str().try_into().expect("short"),
        stated_known: KnownGroups::KINEMATICS,
        ..header
    };
    AlignedBytes::copy(&blob(header, &parts).expect("a blob"))
}
