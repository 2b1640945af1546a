//! Exceptions: each carries the program's own sentence.

use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::fmt::Display;
use std::path::Path;

create_exception!(
    meniscus_liquid,
    MeniscusError,
    PyValueError,
    "A file, a value or a combination of them that was refused; the text says which, and what to do."
);

create_exception!(
    meniscus_liquid,
    SimulationError,
    MeniscusError,
    "A simulation that started and could not go on."
);

/// Returns the exception for input that was refused.
pub(crate) fn refused(why: impl Display) -> PyErr {
    MeniscusError::new_err(why.to_string())
}

/// Returns the exception for a file that the system refuses.
pub(crate) fn system(why: impl Display) -> PyErr {
    PyOSError::new_err(why.to_string())
}

/// Refuses an output file before the work: one that exists, unless `overwrite`, or one that cannot be written.
pub(crate) fn check_output(path: &Path, overwrite: bool) -> PyResult<()> {
    if !overwrite && path.exists() {
        return Err(refused(format!(
            "{} exists already: choose another name, or replace it with overwrite=True",
            path.display()
        )));
    }
    meniscus_platform::files::check_writable(path).map_err(system)
}

/// Refuses `value` outside of `range`; `name` is the argument's.
pub(crate) fn check_range<T: PartialOrd + Display>(
    name: &str,
    value: &T,
    range: std::ops::RangeInclusive<T>,
) -> PyResult<()> {
    if range.contains(value) {
        return Ok(());
    }
    Err(refused(format!("{name} = {value} is out of range: {} to {}", range.start(), range.end())))
}

impl From<crate::interrupt::Stopped> for PyErr {
    fn from(_: crate::interrupt::Stopped) -> Self {
        pyo3::exceptions::PyKeyboardInterrupt::new_err(())
    }
}
