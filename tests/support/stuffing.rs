//! Published records as they lie between two zero bytes of a stream, back to their own bytes.

/// Takes out the stuffing of Cheshire and Baker: a code byte says how far the next zero is.
pub(crate) fn unstuffed(stuffed: &[u8]) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), stuffed);
    while let Some((code, behind)) = rest.split_first().filter(|(code, _)| **code > 0) {
        let length = usize::from(*code) - 1;
        out.extend(&behind[..length]);
        rest = &behind[length..];
        if *code < 255 && rest.first().is_some_and(|next| *next != 0) {
            out.push(0);
        }
    }
    out
}
