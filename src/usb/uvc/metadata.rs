//! Metadata blocks behind the standard header: walked by their own sizes, never by fixed offsets.
//!
//! A block is `id: u32, size: u32, body`, and `size` counts those eight bytes too.
//! Source: Microsoft's UVC metadata extension.

use super::bytes::u32_at;

/// Bytes of id and size.
const BLOCK_HEADER: usize = 8;

/// One metadata block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block<'a> {
    /// Kind of the block.
    pub id: u32,
    /// Its bytes behind id and size.
    pub body: &'a [u8],
}

/// Walk over the blocks; it ends at the first block whose size is impossible.
#[derive(Clone, Debug)]
pub struct Blocks<'a> {
    rest: &'a [u8],
}

impl<'a> Blocks<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Block<'a>;

    fn next(&mut self) -> Option<Block<'a>> {
        let rest = core::mem::take(&mut self.rest);
        let id = u32_at(rest, 0)?;
        let size = usize::try_from(u32_at(rest, 4)?).ok()?;
        // A size below the block's own header would never move on; one beyond the end has no body.
        let body = rest.get(BLOCK_HEADER..size)?;
        self.rest = rest.get(size..)?;
        Some(Block { id, body })
    }
}
