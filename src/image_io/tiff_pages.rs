//! What the directories of a TIFF say, for what its decoder passes over in silence: further pages, and the kind of
//! sample.
//!
//! TIFF 6.0, section 2: a header of byte order, 42 and the place of the first directory; a directory is a count of
//! entries of 12 bytes and the place of the next. BigTIFF has 43, places of 8 bytes and entries of 20.

/// Tag `SampleFormat`; its value 3 is floating point.
const SAMPLE_FORMAT: u64 = 339;
const FLOATING_POINT: u64 = 3;
/// Type `SHORT`, the one that `SampleFormat` has.
const SHORT: u64 = 3;
/// Directories followed: a loop among them ends here.
const MOST_PAGES: usize = 10_000;

/// What was found; of a damaged file, as far as it can be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TiffPages {
    /// Directories, which are pages.
    pub count: usize,
    /// Whether the samples of the first are floating point.
    pub floating_point: bool,
}

/// Bytes of a TIFF with what its header says of them.
struct Layout<'b> {
    bytes: &'b [u8],
    big_endian: bool,
    /// Bytes of a place, of a count of entries, of an entry.
    sizes: [usize; 3],
}

impl Layout<'_> {
    /// The whole number of `size` bytes at `place`.
    fn number(&self, place: u64, size: usize) -> Option<u64> {
        let start = usize::try_from(place).ok()?;
        let bytes = self.bytes.get(start..start.checked_add(size)?)?;
        let fold = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
        Some(if self.big_endian { bytes.iter().fold(0, fold) } else { bytes.iter().rev().fold(0, fold) })
    }

    /// Whether the directory at `place` says that its samples are floating point, and the place of the next (0: none).
    fn directory(&self, place: u64) -> Option<(bool, u64)> {
        let [place_size, count_size, entry_size] = self.sizes;
        let entries = self.number(place, count_size)?;
        let first = place.checked_add(count_size as u64)?;
        let end = first.checked_add(entries.checked_mul(entry_size as u64)?)?;
        let next = self.number(end, place_size)?;
        // The value of an entry is its last part, in as many bytes as a place has; three samples may stand elsewhere.
        let is_float = |index: u64| {
            let entry = first + index * entry_size as u64;
            let wanted = self.number(entry, 2)? == SAMPLE_FORMAT && self.number(entry + 2, 2)? == SHORT;
            let value = entry + (entry_size - place_size) as u64;
            let count = self.number(entry + 4, place_size)?;
            let inside = count.checked_mul(2)? <= place_size as u64;
            let value = if inside { value } else { self.number(value, place_size)? };
            Some(wanted && self.number(value, 2)? == FLOATING_POINT)
        };
        Some(((0..entries).any(|index| is_float(index) == Some(true)), next))
    }
}

/// Follows the directories of a TIFF.
pub(super) fn tiff_pages(bytes: &[u8]) -> TiffPages {
    let mut found = TiffPages::default();
    let big_endian = bytes.starts_with(b"MM");
    let mut layout = Layout { bytes, big_endian, sizes: [4, 2, 12] };
    let header = match layout.number(2, 2) {
        Some(43) => {
            layout.sizes = [8, 8, 20];
            layout.number(8, 8)
        }
        _ => layout.number(4, 4),
    };
    let mut next = header.unwrap_or(0);
    while next != 0 && found.count < MOST_PAGES {
        let Some((floating_point, following)) = layout.directory(next) else { break };
        found.floating_point |= found.count == 0 && floating_point;
        found.count += 1;
        next = following;
    }
    found
}
