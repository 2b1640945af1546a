//! Silence of the camera.

/// Reaction of the worker to a camera that sends nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Silence {
    /// A turn without a frame is taken for every interval: the estimate goes on at 60 Hz.
    #[default]
    Bridge,
    /// The next frame is waited for: for a simulated camera that waits for the worker, too.
    WaitOut,
}
