//! Writes a weight blob, the mirror image of what [`meniscus::blob`] checks and reads.
//!
//! ```text
//! 0   magic "MENISCUS"
//! 8   format version, u32
//! 12  length of the header, u32
//! 16  length of the blob, u32
//! 20  CRC-32 (IEEE 802.3) of bytes 24 to the end, u32
//! 24  header and extension, postcard; behind them the elements, if any tensor is not f32 or effects are named; then these
//! ..  tensors, packed in panels, each at a multiple of 64, zeros between; all little-endian
//! ```

use meniscus::blob::{ALIGNMENT, CRC, Header, MAGIC, MAX_SECTIONS, PREFIX_LEN, Section, Tensor, VERSION};
use meniscus::latent::nn::{Element, bf16_index, bf16_of, packed_index, packed_len, section_len};

/// One tensor to write.
#[derive(Clone, Debug)]
pub struct Part {
    /// Which.
    pub tensor: Tensor,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Row-major numbers; packing is done here.
    pub values: Vec<f32>,
}

/// Why no blob was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExportError {
    /// The tensor's numbers are not as many as its rows times its columns.
    Shape(Tensor),
    /// The tensor holds a number that is not finite: the training diverged, lower its rate.
    NotFinite(Tensor),
    /// More tensors than a header lists, or a header longer than its buffer.
    Header,
    /// The blob would be longer than a u32 says.
    Length,
}

impl std::fmt::Display for ExportError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Shape(tensor) => write!(f, "{tensor:?} has not rows times columns numbers"),
            Self::NotFinite(tensor) => {
                write!(f, "{tensor:?} holds a number that is not finite: the training diverged")
            }
            Self::Header => write!(f, "the header does not hold that many tensors"),
            Self::Length => write!(f, "the blob would be longer than 4 GiB"),
        }
    }
}

impl std::error::Error for ExportError {}

/// The bytes of a blob; `header.sections` is filled in here.
///
/// # Errors
/// [`ExportError`], when a tensor is malformed or does not fit.
pub fn blob(header: Header, parts: &[Part]) -> Result<Vec<u8>, ExportError> {
    stored(header, parts, |_| Element::F32)
}

/// The same with every tensor stored as `element` says; what may not be coarser than f32 stays f32.
///
/// # Errors
/// [`ExportError`], when a tensor is malformed or does not fit.
pub fn stored(
    mut header: Header,
    parts: &[Part],
    element: impl Fn(Tensor) -> Element,
) -> Result<Vec<u8>, ExportError> {
    let element = |tensor: Tensor| if tensor.may_be_coarse() { element(tensor) } else { Element::F32 };
    for part in parts {
        if part.values.len() != part.rows * part.columns {
            return Err(ExportError::Shape(part.tensor));
        }
        if !part.values.iter().all(|v| v.is_finite()) {
            return Err(ExportError::NotFinite(part.tensor));
        }
    }
    // Offsets are written with as many bytes as they need, so the length of the header depends on
    // itself; it only grows from one round to the next, and by less each time.
    let mut head = Vec::new();
    loop {
        let length = place(&mut header, parts, &element, head.len())?;
        let next = encode(&header)?;
        if next.len() == head.len() {
            // Not the head of the round before: its offsets may lie a boundary short.
            return Ok(assemble(&next, &header, parts, length));
        }
        head = next;
    }
}

/// Fills in the sections behind a header of `head` bytes; returns the length of the blob.
fn place(
    header: &mut Header,
    parts: &[Part],
    element: &impl Fn(Tensor) -> Element,
    head: usize,
) -> Result<usize, ExportError> {
    let mut end = PREFIX_LEN + head;
    header.sections.clear();
    for part in parts {
        let offset = end.next_multiple_of(ALIGNMENT);
        let element = element(part.tensor);
        end = offset + section_len(element, part.rows, part.columns).ok_or(ExportError::Length)?;
        let short = |n: usize| u32::try_from(n).map_err(|_| ExportError::Length);
        let (rows, columns) = (short(part.rows)?, short(part.columns)?);
        let section = Section { tensor: part.tensor, rows, columns, offset: short(offset)?, element };
        header.sections.push(section).map_err(|_| ExportError::Header)?;
    }
    u32::try_from(end).map_err(|_| ExportError::Length)?;
    Ok(end)
}

fn encode(header: &Header) -> Result<Vec<u8>, ExportError> {
    let mut buffer = vec![0; 8192];
    let extended = (header, header.extension());
    let used = postcard::to_slice(&extended, &mut buffer).map_err(|_| ExportError::Header)?.len();
    buffer.truncate(used);
    if header.embedded.is_some() || header.sections.iter().any(|section| section.element != Element::F32) {
        let elements: heapless::Vec<Element, MAX_SECTIONS> =
            header.sections.iter().map(|section| section.element).collect();
        let mut list = [0; 2 * MAX_SECTIONS];
        buffer.extend_from_slice(postcard::to_slice(&elements, &mut list).map_err(|_| ExportError::Header)?);
    }
    if let Some(named) = &header.embedded {
        let mut list = [0; 512];
        buffer.extend_from_slice(postcard::to_slice(named, &mut list).map_err(|_| ExportError::Header)?);
    }
    Ok(buffer)
}

fn assemble(head: &[u8], header: &Header, parts: &[Part], length: usize) -> Vec<u8> {
    let mut bytes = vec![0; length];
    bytes[PREFIX_LEN..PREFIX_LEN + head.len()].copy_from_slice(head);
    for (part, section) in parts.iter().zip(&header.sections) {
        let length = section_len(section.element, part.rows, part.columns).unwrap_or(0);
        let offset = section.offset as usize;
        pack(part, section.element, &mut bytes[offset..offset + length]);
    }
    let crc = CRC.checksum(&bytes[PREFIX_LEN..]);
    bytes[..8].copy_from_slice(&MAGIC);
    for (k, number) in [VERSION, head.len() as u32, length as u32, crc].into_iter().enumerate() {
        bytes[8 + 4 * k..12 + 4 * k].copy_from_slice(&number.to_le_bytes());
    }
    bytes
}

/// Packs a tensor into the bytes of its section.
pub fn pack(part: &Part, element: Element, out: &mut [u8]) {
    let columns = part.columns;
    let entries = || part.values.iter().enumerate().map(|(k, value)| (k / columns, k % columns, *value));
    match element {
        Element::F32 => {
            for (i, j, value) in entries() {
                let at = 4 * packed_index(i, j, columns);
                out[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
        }
        Element::Bf16 => {
            for (i, j, value) in entries() {
                let at = 2 * bf16_index(i, j, columns);
                out[at..at + 2].copy_from_slice(&bf16_of(value).to_le_bytes());
            }
        }
        Element::I8 => {
            let behind_scales = 4 * packed_len(part.rows, 1).unwrap_or(0);
            for (i, row) in part.values.chunks(columns).enumerate() {
                let scale = row.iter().fold(0.0_f32, |most, w| most.max(w.abs())) / 127.0;
                out[4 * i..4 * i + 4].copy_from_slice(&scale.to_le_bytes());
                for (j, value) in row.iter().enumerate() {
                    let k = if scale > 0.0 { (value / scale).round() as i8 } else { 0 };
                    out[behind_scales + packed_index(i, j, columns)] = k.to_le_bytes()[0];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::{Extension, FilterConfig, KnownGroups, Variant};

    fn header() -> Header {
        Header {
            liquid: "water".try_into().expect("short"),
            provenance: "test".try_into().expect("short"),
            particles: 2134,
            dt_s: 1.0 / 60.0,
            radius_m: 0.035,
            fill_m: 0.07,
            rim_m: 0.11,
            height_scale_m: 0.01,
            acceleration_scale: 2.0,
            energy_scale_j: 0.01,
            validation_slosh_rel: 0.1,
            sections: heapless::Vec::new(),
            embedded: None,
            model_version: 7,
            stated_known: KnownGroups::ALL,
            filter: FilterConfig::REFERENCE,
            variant: Variant::Full,
        }
    }

    fn part(tensor: Tensor, rows: usize, columns: usize) -> Part {
        Part { tensor, rows, columns, values: (0..rows * columns).map(|k| k as f32 - 3.5).collect() }
    }

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn layout_is_as_specified() {
        let parts =
            [part(Tensor::Gain, 13, 13), part(Tensor::HeadBias, 13, 1), part(Tensor::GroupRest(5), 21, 1)];
        let bytes = blob(header(), &parts).expect("a blob");
        assert_eq!(&bytes[..8], b"MENISCUS");
        assert_eq!(word(&bytes, 8), VERSION);
        assert_eq!(word(&bytes, 16) as usize, bytes.len());
        assert_eq!(word(&bytes, 20), CRC.checksum(&bytes[24..]));
        let head = &bytes[24..24 + word(&bytes, 12) as usize];
        let ((read, extension), rest): ((Header, Extension), _) =
            postcard::take_from_bytes(head).expect("a header");
        assert_eq!(extension, Extension { model_version: 7, ..Extension::default() });
        assert!(rest.is_empty(), "the header is as long as it says");
        assert_eq!(read.sections.len(), parts.len());
        let mut end = 24 + head.len();
        for (section, part) in read.sections.iter().zip(&parts) {
            let offset = section.offset as usize;
            assert_eq!(offset % 64, 0);
            assert!(bytes[end..offset].iter().all(|&b| b == 0), "zeros between");
            for (k, value) in part.values.iter().enumerate() {
                let at = packed_index(k / part.columns, k % part.columns, part.columns);
                assert_eq!(f32::from_bits(word(&bytes, offset + 4 * at)), *value);
            }
            end = offset + 4 * packed_len(part.rows, part.columns).expect("small");
        }
        assert_eq!(end, bytes.len());
    }

    /// Offsets are counted from a header whose length depends on them; every length of it has to come out right.
    #[test]
    fn a_header_of_any_length_says_where_its_tensors_lie() {
        for length in 0..130 {
            let mut header = header();
            header.provenance = core::iter::repeat_n('x', length).collect();
            let parts: Vec<Part> = (0..12).map(|k| part(Tensor::GruHiddenBias(k), 78, 1)).collect();
            let bytes = blob(header, &parts).expect("a blob");
            let (read, _): (Header, _) =
                postcard::take_from_bytes(&bytes[24..24 + word(&bytes, 12) as usize]).expect("a header");
            for section in &read.sections {
                let at = section.offset as usize;
                assert_eq!(f32::from_bits(word(&bytes, at)), -3.5, "{length} characters, {section:?}");
            }
        }
    }

    #[test]
    fn malformed_tensors_are_refused() {
        let mut short = part(Tensor::Gain, 13, 13);
        short.values.pop();
        assert_eq!(blob(header(), &[short]), Err(ExportError::Shape(Tensor::Gain)));
        let mut wild = part(Tensor::Port, 13, 1);
        wild.values[4] = f32::NAN;
        assert_eq!(blob(header(), &[wild]), Err(ExportError::NotFinite(Tensor::Port)));
    }
}
