//! USB Video Class 1.5: payload bytes to whole frames, or a counted loss.
