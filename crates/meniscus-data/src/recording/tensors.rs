//! Typed tensors of a safetensors file, written and read with their shapes checked.

use half::f16;
use meniscus_platform::files::{Links, open_regular, read_regular};
use safetensors::tensor::{Dtype, Metadata, SafeTensors, TensorView};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::Path;

/// Key of the text in a header.
const TEXT: &str = "__metadata__";

/// Longest header, bytes: a recording has thirty tensors, and the motions and notes that it was made with.
const HEADER_LONGEST: u64 = 1 << 20;

/// Longest file, bytes: 160 s of full states.
const LONGEST: u64 = 1 << 30;

/// Reads the file at `path`, after a look at the length of its header: JSON takes many times its length in memory.
pub(crate) fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut length = [0; 8];
    // A shorter file is refused by its parser, which says so.
    let whole = open_regular(path, Links::Followed)?.read_exact(&mut length).is_ok();
    let length = u64::from_le_bytes(length);
    if whole && length > HEADER_LONGEST {
        let what = format!("not a recording: its header would have {length} bytes");
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, what));
    }
    read_regular(path, LONGEST, Links::Followed)
}

/// A tensor on its way to a file.
pub(super) struct Tensor {
    pub(super) name: String,
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
    pub(super) bytes: Vec<u8>,
}

impl Tensor {
    pub(super) fn f64(name: &str, shape: &[usize], values: impl Iterator<Item = f64>) -> Self {
        let bytes = values.flat_map(f64::to_le_bytes).collect();
        Self { name: name.into(), dtype: Dtype::F64, shape: shape.to_vec(), bytes }
    }

    pub(super) fn u64(name: &str, shape: &[usize], values: impl Iterator<Item = u64>) -> Self {
        let bytes = values.flat_map(u64::to_le_bytes).collect();
        Self { name: name.into(), dtype: Dtype::U64, shape: shape.to_vec(), bytes }
    }

    pub(super) fn i64(name: &str, shape: &[usize], values: impl Iterator<Item = i64>) -> Self {
        let bytes = values.flat_map(i64::to_le_bytes).collect();
        Self { name: name.into(), dtype: Dtype::I64, shape: shape.to_vec(), bytes }
    }

    pub(super) fn u8(name: &str, shape: &[usize], values: impl Iterator<Item = u8>) -> Self {
        Self { name: name.into(), dtype: Dtype::U8, shape: shape.to_vec(), bytes: values.collect() }
    }

    pub(super) fn f32(name: &str, shape: &[usize], values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        Self { name: name.into(), dtype: Dtype::F32, shape: shape.to_vec(), bytes }
    }

    pub(super) fn f16(name: &str, shape: &[usize], values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
        Self { name: name.into(), dtype: Dtype::F16, shape: shape.to_vec(), bytes }
    }

    /// Values between -1 and 1 in steps of 1/127.
    pub(super) fn i8(name: &str, shape: &[usize], values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|v| ((127.0 * v).round() as i8).to_le_bytes()).collect();
        Self { name: name.into(), dtype: Dtype::I8, shape: shape.to_vec(), bytes }
    }
}

/// Returns the bytes of a file with these tensors and this text: the same ones whenever these are the same.
pub(super) fn serialize(tensors: &[Tensor], text: HashMap<String, String>) -> Result<Vec<u8>, String> {
    let mut views = Vec::with_capacity(tensors.len());
    for t in tensors {
        let view = TensorView::new(t.dtype, t.shape.clone(), &t.bytes);
        views.push((t.name.as_str(), view.map_err(|e| format!("{}: {e}", t.name))?));
    }
    in_order(safetensors::serialize(views, Some(text)).map_err(|e| format!("{e}"))?)
}

/// Puts the header of a file into alphabetical order; the library writes the text in that of a hash map, which changes from run to run.
fn in_order(mut file: Vec<u8>) -> Result<Vec<u8>, String> {
    let length = file.first_chunk().map_or(0, |length| u64::from_le_bytes(*length)) as usize;
    let header = file.get_mut(8..8 + length).ok_or("its header is cut")?;
    let mut all: BTreeMap<String, Value> = serde_json::from_slice(header).map_err(|e| format!("{e}"))?;
    let text = all.remove(TEXT).unwrap_or_default();
    let text: BTreeMap<String, String> = serde_json::from_value(text).map_err(|e| format!("{e}"))?;
    all.insert(TEXT.into(), json!(text));
    let ordered = serde_json::to_vec(&all).map_err(|e| format!("{e}"))?;
    if ordered.len() > length {
        return Err("its header grows when it is put into order".into());
    }
    header.fill(b' ');
    header[..ordered.len()].copy_from_slice(&ordered);
    Ok(file)
}

/// Text of a file beside its tensors.
pub(super) struct FileText(Metadata);

impl FileText {
    /// Reads the text of the file in `bytes`.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, String> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| format!("{e}"))?;
        Ok(Self(header))
    }

    /// Returns the value of `key`.
    pub(super) fn get(&self, key: &str) -> Result<&str, String> {
        let text = self.0.metadata().as_ref().ok_or("it has no metadata")?;
        Ok(text.get(key).ok_or_else(|| format!("its metadata lack '{key}'"))?)
    }
}

/// The bytes of tensor `name` after its type and shape are checked; without a shape: one axis.
pub(super) fn typed<'a>(
    file: &SafeTensors<'a>,
    name: &str,
    dtype: Dtype,
    shape: Option<&[usize]>,
) -> Result<&'a [u8], String> {
    let view = file.tensor(name).map_err(|_| format!("it has no tensor '{name}'"))?;
    let fits = shape.map_or(view.shape().len() == 1, |s| s == view.shape());
    if view.dtype() != dtype || !fits {
        return Err(format!(
            "'{name}' is {:?} {:?}, expected {dtype:?} {shape:?}",
            view.dtype(),
            view.shape()
        ));
    }
    Ok(view.data())
}

/// Length of the first axis of tensor `name`, 0 where there is none.
pub(crate) fn rows(file: &SafeTensors<'_>, name: &str) -> usize {
    file.tensor(name).ok().and_then(|view| view.shape().first().copied()).unwrap_or(0)
}

pub(super) fn f16s(file: &SafeTensors<'_>, name: &str, shape: &[usize]) -> Result<Vec<f32>, String> {
    let bytes = typed(file, name, Dtype::F16, Some(shape))?;
    Ok(bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect())
}

pub(crate) fn f32s(file: &SafeTensors<'_>, name: &str, shape: Option<&[usize]>) -> Result<Vec<f32>, String> {
    let bytes = typed(file, name, Dtype::F32, shape)?;
    Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

pub(super) fn u64s(file: &SafeTensors<'_>, name: &str, shape: Option<&[usize]>) -> Result<Vec<u64>, String> {
    let bytes = typed(file, name, Dtype::U64, shape)?;
    Ok(bytes.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b)).collect())
}

pub(super) fn i64s(file: &SafeTensors<'_>, name: &str, shape: Option<&[usize]>) -> Result<Vec<i64>, String> {
    let bytes = typed(file, name, Dtype::I64, shape)?;
    Ok(bytes.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b)).collect())
}

pub(super) fn f64s(file: &SafeTensors<'_>, name: &str, shape: Option<&[usize]>) -> Result<Vec<f64>, String> {
    let bytes = typed(file, name, Dtype::F64, shape)?;
    let number = |b: &[u8]| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
    Ok(bytes.chunks_exact(8).map(number).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_tensors_and_text_are_the_same_bytes() {
        let file = || {
            let text = ["b", "a", "d", "c", "e"].map(|key| (key.to_owned(), format!("of {key}")));
            let tensors = ["y", "x"].map(|name| Tensor::f32(name, &[2], &[1.0, 2.0]));
            serialize(&tensors, HashMap::from(text)).expect("a file")
        };
        let first = file();
        // Every hash map has an order of its own.
        assert!((0..20).all(|_| file() == first));
        let text = FileText::read(&first).expect("text");
        assert_eq!(text.get("d"), Ok("of d"));
        let tensors = SafeTensors::deserialize(&first).expect("tensors");
        assert_eq!(tensors.tensor("x").expect("x").shape(), [2]);
    }
}
