//! Prefix and header of a blob, from bytes to checked values.

use super::{
    EmbeddedEffects, Extension, Header, KnownGroups, LoadError, MAGIC, MAX_SECTIONS, OLDEST_VERSION, VERSION,
};
use crate::latent::nn::Element;
use heapless::Vec;
use serde::Deserialize;

/// Bytes before the postcard header: magic, version, header length, total length, CRC-32.
pub const PREFIX_LEN: usize = 24;

/// Checksum of a blob: CRC-32 of IEEE 802.3, over everything behind the prefix.
pub const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// First format version with an [`Extension`].
const EXTENDED_SINCE: u32 = 4;

/// Returns the header of `blob`, after every check that needs no tensor.
pub(super) fn read_header(blob: &[u8]) -> Result<Header, LoadError> {
    let prefix = check_prefix(blob)?;
    let bytes = prefix.body.get(..prefix.header_len).ok_or(LoadError::Header)?;
    let (mut header, rest) = take::<Header>(bytes)?;
    let rest = if prefix.version >= EXTENDED_SINCE {
        read_extension(&mut header, rest)?
    } else {
        header.stated_known = known_before_extensions(&header);
        rest
    };
    read_lists(&mut header, rest)?;
    check_values(&header)?;
    Ok(header)
}

/// Prefix of a blob whose length and checksum are right.
struct Prefix<'b> {
    version: u32,
    header_len: usize,
    /// Everything behind the prefix.
    body: &'b [u8],
}

/// Checks magic, version, length and checksum.
fn check_prefix(blob: &[u8]) -> Result<Prefix<'_>, LoadError> {
    let short = LoadError::Truncated { have: blob.len(), need: PREFIX_LEN };
    let magic = blob.first_chunk::<8>().ok_or(short)?;
    if *magic != MAGIC {
        return Err(LoadError::NotABlob);
    }
    let version = word(blob, 8).ok_or(short)?;
    if !(OLDEST_VERSION..=VERSION).contains(&version) {
        return Err(LoadError::Version { found: version });
    }
    let header_len = word(blob, 12).ok_or(short)? as usize;
    let total = word(blob, 16).ok_or(short)? as usize;
    let stated = word(blob, 20).ok_or(short)?;
    if blob.len() < total {
        return Err(LoadError::Truncated { have: blob.len(), need: total });
    }
    if blob.len() > total {
        return Err(LoadError::Trailing { extra: blob.len() - total });
    }
    let body = blob.get(PREFIX_LEN..).ok_or(short)?;
    let computed = CRC.checksum(body);
    if computed != stated {
        return Err(LoadError::Checksum { stated, computed });
    }
    Ok(Prefix { version, header_len, body })
}

/// The little-endian number at `offset`.
fn word(blob: &[u8], offset: usize) -> Option<u32> {
    let bytes = blob.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes))
}

/// Takes one postcard record off the front of `bytes`.
fn take<'b, T: Deserialize<'b>>(bytes: &'b [u8]) -> Result<(T, &'b [u8]), LoadError> {
    postcard::take_from_bytes(bytes).map_err(|_| LoadError::Header)
}

/// Returns the field groups of a blob that does not state them: a correction before format version 4 may have been one to
/// any liquid.
fn known_before_extensions(header: &Header) -> KnownGroups {
    if header.corrected() { KnownGroups::KINEMATICS } else { KnownGroups::ALL }
}

/// Reads what format version 4 put behind the header; returns the bytes behind it.
fn read_extension<'b>(header: &mut Header, bytes: &'b [u8]) -> Result<&'b [u8], LoadError> {
    let (extension, rest) = take::<Extension>(bytes)?;
    header.model_version = extension.model_version;
    header.stated_known = extension.known;
    header.filter = extension.filter;
    Ok(rest)
}

/// Reads the optional lists: the elements, one a section, and behind them the embedded effects. Without elements all
/// tensors are f32. The length in the prefix is outside of the checksum, so the lists have to end where the header does.
fn read_lists(header: &mut Header, bytes: &[u8]) -> Result<(), LoadError> {
    if bytes.is_empty() {
        return Ok(());
    }
    let (elements, rest) = take::<Vec<Element, MAX_SECTIONS>>(bytes)?;
    if !rest.is_empty() {
        let (embedded, []) = take::<EmbeddedEffects>(rest)? else { return Err(LoadError::Header) };
        header.embedded = Some(embedded);
    }
    if elements.len() != header.sections.len() {
        return Err(LoadError::Header);
    }
    for (section, element) in header.sections.iter_mut().zip(&elements) {
        section.element = *element;
    }
    Ok(())
}

/// Refuses texts that a terminal would carry out, and numbers that no glass, filter or model can have.
fn check_values(header: &Header) -> Result<(), LoadError> {
    for (field, text) in [("liquid", header.liquid.as_str()), ("provenance", header.provenance.as_str())] {
        if text.chars().any(char::is_control) {
            return Err(LoadError::HeaderText { field });
        }
    }
    let positive = [
        ("particles", f64::from(header.particles)),
        ("dt_s", header.dt_s),
        ("radius_m", header.radius_m),
        ("fill_m", header.fill_m),
        ("rim_m", header.rim_m),
        ("height_scale_m", f64::from(header.height_scale_m)),
        ("acceleration_scale", f64::from(header.acceleration_scale)),
        ("energy_scale_j", header.energy_scale_j),
    ];
    for (field, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(LoadError::HeaderValue { field, value });
        }
    }
    if header.rim_m < header.fill_m {
        return Err(LoadError::HeaderValue { field: "rim_m (below the fill)", value: header.rim_m });
    }
    header.stated_known.check()?;
    header.filter.check()
}
