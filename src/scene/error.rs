//! What is wrong with a scene, on one line: file, line, key, and what would be right.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A scene that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", self.place())]
pub struct SceneError {
    /// Class of the error: `io`, `too_large`, `not_utf8`, `syntax`, `unknown_key`, `missing_key`, `wrong_type`,
    /// `invalid_value`, `missing_file` or `unknown_preset`.
    pub kind: &'static str,
    /// The scene file.
    pub file: PathBuf,
    /// Line in that file, from 1; a missing key has the line of its table.
    pub line: Option<usize>,
    /// Path of the key, as in `stack.layer[1].thickness_mm`.
    pub key: Option<String>,
    /// What is wrong and what would be right.
    pub message: String,
    /// The other mistakes of the file, each without others.
    pub others: Box<[SceneError]>,
}

impl SceneError {
    /// An error about the file as a whole.
    pub(super) fn of_file(kind: &'static str, file: &Path, message: impl AsRef<str>) -> Self {
        let message = one_line(message.as_ref());
        Self { kind, file: file.to_path_buf(), line: None, key: None, message, others: Box::default() }
    }

    /// The same error at a place.
    pub(super) fn at(mut self, line: Option<usize>, key: Option<&str>) -> Self {
        self.line = line;
        self.key = key.map(one_line);
        self
    }

    /// The first of several mistakes, with the others; none where there are none.
    pub(super) fn first_of(mistakes: Vec<Self>) -> Option<Self> {
        let mut mistakes = mistakes.into_iter();
        let first = mistakes.next()?;
        Some(Self { others: mistakes.collect(), ..first })
    }

    fn place(&self) -> String {
        let mut place = one_line(&self.file.to_string_lossy());
        if let Some(line) = self.line {
            // Writing to a String cannot fail.
            let _ = write!(place, ":{line}");
        }
        place.push_str(": ");
        if let Some(key) = &self.key {
            place.push_str(key);
            place.push_str(": ");
        }
        place
    }
}

/// Control characters from a user's file would break the promise of one line (and could drive a terminal).
fn one_line(text: &str) -> String {
    text.chars()
        .flat_map(|c| {
            let escaped = c.is_control().then(|| c.escape_default());
            let plain = if c.is_control() { None } else { Some(c) };
            escaped.into_iter().flatten().chain(plain)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_that_names_file_line_and_key() {
        let error =
            SceneError::of_file("invalid_value", Path::new("scene.toml"), "must be positive, is -2; for example 2.0")
                .at(Some(12), Some("stack.layer[1].thickness_mm"));
        assert_eq!(
            error.to_string(),
            "scene.toml:12: stack.layer[1].thickness_mm: must be positive, is -2; for example 2.0"
        );
    }

    #[test]
    fn control_characters_are_escaped() {
        let error = SceneError::of_file("syntax", Path::new("a\nb.toml"), "bad \u{1b}[31m\nred").at(None, Some("k\r"));
        assert_eq!(error.to_string(), "a\\nb.toml: k\\r: bad \\u{1b}[31m\\nred");
    }
}
