//! Arrays as NumPy's `.npy`, format 1.0 (NumPy Enhancement Proposal 1): what `numpy.load` reads.

use super::ImageError;
use std::path::Path;

/// What every file begins with: magic, and the version of the format.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// The array begins at a multiple of this.
const ALIGNED: usize = 64;

/// Writes `values`, row-major from the top left, as an array of shape (rows, columns) of 32-bit floats.
///
/// # Errors
/// When they are not as many as that takes, or the file cannot be written.
pub fn write_npy(path: &Path, columns: u32, values: &[f32]) -> Result<(), ImageError> {
    let width = columns.max(1) as usize;
    if !values.len().is_multiple_of(width) {
        let reason = format!("{} values are no rows of {columns}", values.len());
        return Err(ImageError::Unsupported { path: path.into(), reason });
    }
    let mut bytes = header(values.len() / width, width);
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    std::fs::write(path, bytes).map_err(|source| ImageError::Write { path: path.into(), source })
}

/// All that stands before the values.
fn header(rows: usize, columns: usize) -> Vec<u8> {
    let mut said = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // Two bytes say how long it is; spaces and a line break fill it up.
    let whole = (MAGIC.len() + 2 + said.len() + 1).next_multiple_of(ALIGNED);
    let length = whole - MAGIC.len() - 2;
    said.push_str(&" ".repeat(length - said.len() - 1));
    said.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(said.bytes());
    bytes
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// `numpy.save` of a (2, 3) array of float32 (NumPy 2.1) has this header.
    #[test]
    fn a_file_is_that_of_numpy() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.npy");
        write_npy(&path, 3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.5]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let said = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(std::str::from_utf8(&bytes[10..128]).unwrap(), format!("{said:<117}\n"));
        assert_eq!((bytes.len(), &bytes[148..]), (152, &5.5f32.to_le_bytes()[..]));
        assert!(write_npy(&path, 4, &[0.0; 6]).is_err());
    }

    /// The values begin aligned, however large the numbers of the shape.
    #[test]
    fn headers_are_aligned() {
        for size in [1, 99, 12_345, 1_000_000_000] {
            let bytes = header(size, size);
            assert!(bytes.len().is_multiple_of(ALIGNED) && bytes.ends_with(b"\n"));
            assert_eq!(usize::from(u16::from_le_bytes([bytes[8], bytes[9]])) + 10, bytes.len());
        }
    }
}
