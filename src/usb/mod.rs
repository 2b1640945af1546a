//! USB side of the camera: UVC payload bytes and the D400's tables, up to whole frames.

pub mod d4xx;
pub mod frame;
pub mod lens;
pub mod uvc;
