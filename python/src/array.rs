//! Images as arrays of numpy.

use numpy::{PyArray1, PyArray2, PyArrayMethods as _};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::Path;
use tirtouch::camera::Frame;

/// Values of an image, row after row, as an array of shape (height, width).
///
/// # Errors
/// When Python has no memory left.
pub fn array_of<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    [width, height]: [u32; 2],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_vec(py, values).reshape([height as usize, width as usize])
}

/// The same, not to be written to.
///
/// # Errors
/// As [`array_of`].
pub fn image_of<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    size: [u32; 2],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let array = array_of(py, values, size)?;
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// Grey levels as uint8 for a camera of 8 bits, else as uint16.
///
/// # Errors
/// As [`image_of`].
pub fn frame_of(py: Python<'_>, frame: &Frame) -> PyResult<Py<PyAny>> {
    let Frame { width, height, bit_depth, grey } = frame;
    Ok(match bit_depth {
        ..=8 => {
            // A level of 8 bits is below 256.
            let levels = grey.iter().map(|&level| level.min(255) as u8).collect();
            image_of(py, levels, [*width, *height])?.into_any().unbind()
        }
        _ => image_of(py, grey.clone(), [*width, *height])?.into_any().unbind(),
    })
}

/// # Errors
/// `ValueError` for the name of a file that is no picture.
pub fn picture(path: &Path) -> PyResult<()> {
    match path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!("{}: must end in .png", path.display()))),
    }
}
