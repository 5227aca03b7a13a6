//! The word that lets a page in.

use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Bytes of a token: 128 bits are not guessed.
const BYTES: usize = 16;

/// A secret that a request must carry.
#[derive(Debug, Clone)]
pub struct Token {
    text: String,
    hash: [u8; 32],
}

impl Token {
    /// A new one, of the system's random numbers.
    ///
    /// # Errors
    /// When the system has none.
    pub fn draw() -> Result<Self, std::io::Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(|error| std::io::Error::other(error.to_string()))?;
        let mut text = String::with_capacity(2 * BYTES);
        for byte in bytes {
            // Writing into a text cannot fail.
            let _ = write!(text, "{byte:02x}");
        }
        let hash = Sha256::digest(text.as_bytes()).into();
        Ok(Self { text, hash })
    }

    /// Its letters.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether a request's token is this one. Hashes are compared, so that the time taken tells nothing of it.
    pub fn is(&self, given: &str) -> bool {
        let given: [u8; 32] = Sha256::digest(given.as_bytes()).into();
        given == self.hash
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn no_two_tokens_are_alike_and_each_knows_itself() {
        let (one, other) = (Token::draw().unwrap(), Token::draw().unwrap());
        assert!(one.is(one.text()) && !one.is(other.text()) && !one.is(""));
        assert_eq!(one.text().len(), 2 * BYTES);
    }
}
