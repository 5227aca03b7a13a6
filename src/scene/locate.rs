//! From key paths to lines of the file.

use toml::de::{DeTable, DeValue};

/// The line (from 1) of the byte at `offset`.
pub(super) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
}

/// The line of a key such as `stack.layer[1].n`, or of the innermost table on the way to it that the file has.
pub(super) fn line_of(text: &str, document: &DeTable<'_>, key: &str) -> usize {
    line_at(text, offset_of(document, key))
}

fn offset_of(document: &DeTable<'_>, key: &str) -> usize {
    let mut table = document;
    let mut offset = 0;
    for segment in key.split('.') {
        let mut parts = segment.split('[');
        let name = parts.next().unwrap_or_default();
        let Some((found, value)) = table.iter().find(|(k, _)| k.get_ref() == name) else {
            return offset;
        };
        offset = found.span().start;
        let mut value = value.get_ref();
        for index in parts {
            let index = index.trim_end_matches(']').parse().unwrap_or(usize::MAX);
            let Some(item) = value.as_array().and_then(|array| array.get(index)) else {
                return offset;
            };
            offset = item.span().start;
            value = item.get_ref();
        }
        match value {
            DeValue::Table(inner) => table = inner,
            _ => return offset,
        }
    }
    offset
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const TEXT: &str = "name = 'a'\n[stack]\nfootprint_mm = [\n  1.0,\n  2.0,\n]\n[[stack.layer]]\nn = 1\n[[stack.layer]]\nn = 2\n\
                        x = { kind = 'y' }\n";

    #[test]
    fn a_key_path_is_found_on_its_line() {
        let document = DeTable::parse(TEXT).unwrap();
        for (key, line) in [
            ("name", 1),
            ("stack", 2),
            ("stack.footprint_mm", 3),
            ("stack.footprint_mm[1]", 5),
            ("stack.layer[0].n", 8),
            ("stack.layer[1].n", 10),
            ("stack.layer[1].x.kind", 11),
        ] {
            assert_eq!(line_of(TEXT, document.get_ref(), key), line, "{key}");
        }
    }

    #[test]
    fn a_missing_key_has_the_line_of_its_table() {
        let document = DeTable::parse(TEXT).unwrap();
        for (key, line) in [
            ("camera", 1),
            ("stack.walls.kind", 2),
            ("stack.layer[1].thickness_mm", 9),
            ("stack.layer[1].x.rms_nm", 11),
            ("stack.layer[7].n", 7),
        ] {
            assert_eq!(line_of(TEXT, document.get_ref(), key), line, "{key}");
        }
    }
}
