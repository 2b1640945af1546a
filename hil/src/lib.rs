//! The simulated USB depth camera. It shares no code with the reader that it tests.
