//! Arrays without copies: numpy arrays on memory that a Python object of this crate holds.
#![allow(unsafe_code, reason = "the one place where numpy borrows memory of Rust")]

use numpy::ndarray::{ArrayView, Dimension};
use numpy::{Element, PyArray, PyArrayMethods};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;

/// Returns `view` of the content of `owner` as a read-only numpy array that keeps `owner` alive.
pub(crate) fn view<'py, C, T, D>(
    owner: &Bound<'py, C>,
    view: impl for<'a> FnOnce(&'a C) -> PyResult<ArrayView<'a, T, D>>,
) -> PyResult<Bound<'py, PyArray<T, D>>>
where
    C: PyClass<Frozen = True> + Sync,
    T: Element,
    D: Dimension,
{
    let view = view(owner.get())?;
    // SAFETY: `view` borrows from the content of `owner` for any lifetime that the content may be borrowed for, so it
    // points into memory that lives as long as the content (or for ever). `owner` is frozen: nobody gets `&mut` to the
    // content, so that memory is neither freed nor reallocated before the object is, and the array holds a reference to
    // the object. Interior mutability could break this; the classes here only have `OnceLock`, which is written once,
    // before a view on it can exist. The array is made read-only before Python sees it.
    let array = unsafe { PyArray::borrow_from_array(&view, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}
