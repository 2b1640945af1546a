//! Cameras that are not there: recordings rendered as depth images, a simulated camera on a simulated USB bus, and the study that measures the surface against them.

pub mod camera;
pub mod camera_study;
pub mod looped_recording;
pub mod observe_recording;
pub mod render;
pub mod tag_page;
pub mod usb;
