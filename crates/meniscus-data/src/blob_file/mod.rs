//! Weight blobs as files: tensors to bytes, bytes to tensors, and the same blob in fewer bytes.

pub mod factors;
pub mod quantize;
pub mod read;
pub mod write;
