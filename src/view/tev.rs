//! Images sent to tev, or to another viewer that listens as it does.
//!
//! tev's protocol over TCP: packets that begin with their length in bytes, itself included, and their kind. Numbers are
//! little-endian, texts end with a zero byte. An image is created once with its channels, and updated with interleaved
//! floats (tev's `UpdateImageV3`; <https://github.com/Tom94/tev>, `src/Ipc.cpp`).

use crate::film::Film;
use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;
use thiserror::Error;

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;
const CHANNELS: [&str; 2] = ["radiance", "error"];
/// Time to connect, and for a packet to go out: on one machine, or in one house, both take far less.
const PATIENCE: Duration = Duration::from_secs(3);

/// No viewer, or one that went away.
#[derive(Debug, Error)]
#[error("{address}: no viewer takes images there: {cause}")]
pub struct TevError {
    /// Where it was looked for.
    pub address: String,
    /// What the system says.
    pub cause: std::io::Error,
}

/// A viewer that is connected.
#[derive(Debug)]
pub struct Tev {
    stream: TcpStream,
    /// Name of the image there.
    name: String,
    /// Size of the image that is there.
    size: Option<[u32; 2]>,
}

impl Tev {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// An address that is none, or nobody who listens there.
    pub fn connect(address: &str, name: &str) -> Result<Self, TevError> {
        let wrong = |cause| TevError { address: address.to_owned(), cause };
        let mut last = std::io::Error::other("it must be HOST:PORT, as in localhost:14158");
        for place in address.to_socket_addrs().map_err(wrong)? {
            match TcpStream::connect_timeout(&place, PATIENCE) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE)).map_err(wrong)?;
                    return Ok(Self { stream, name: name.replace('\0', " "), size: None });
                }
                Err(error) => last = error,
            }
        }
        Err(wrong(last))
    }

    /// Shows a radiance image with the standard errors of its pixels, made of their `variances`.
    ///
    /// # Errors
    /// When the viewer has gone away.
    pub fn show(&mut self, film: &Film, variances: &[f32]) -> std::io::Result<()> {
        let size = [film.width, film.height];
        let mut packets = Vec::new();
        if self.size != Some(size) {
            packets.extend(packet(CREATE_IMAGE, |bytes| {
                text(bytes, &self.name);
                numbers(bytes, &size);
                channels(bytes);
            }));
        }
        packets.extend(packet(UPDATE_IMAGE, |bytes| {
            text(bytes, &self.name);
            channels(bytes);
            numbers(bytes, &[0, 0, film.width, film.height]);
            let count = CHANNELS.len() as u64;
            (0..count).for_each(|channel| bytes.extend(channel.to_le_bytes()));
            CHANNELS.iter().for_each(|_| bytes.extend(count.to_le_bytes()));
            for (mean, variance) in film.mean.iter().zip(variances) {
                bytes.extend(mean.to_le_bytes());
                bytes.extend(variance.sqrt().to_le_bytes());
            }
        }));
        self.stream.write_all(&packets)?;
        self.size = Some(size);
        Ok(())
    }
}

/// A packet of a kind; it does not take the viewer's attention.
fn packet(kind: u8, write: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = vec![0, 0, 0, 0, kind, 0];
    write(&mut bytes);
    // An image of the most pixels that a scene can have takes less than 2^32 bytes.
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend(text.as_bytes());
    bytes.push(0);
}

fn numbers(bytes: &mut Vec<u8>, numbers: &[u32]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn channels(bytes: &mut Vec<u8>) {
    numbers(bytes, &[CHANNELS.len() as u32]);
    CHANNELS.iter().for_each(|name| text(bytes, name));
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    /// The numbers and texts of a packet, read as tev's `IStream` does.
    struct Reader<'a>(&'a [u8]);

    impl Reader<'_> {
        fn bytes<const N: usize>(&mut self) -> [u8; N] {
            let (head, rest) = self.0.split_at(N);
            self.0 = rest;
            head.try_into().unwrap()
        }

        fn int(&mut self) -> i32 {
            i32::from_le_bytes(self.bytes())
        }

        fn text(&mut self) -> String {
            let end = self.0.iter().position(|byte| *byte == 0).unwrap();
            let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
            self.0 = &self.0[end + 1..];
            text
        }
    }

    #[test]
    fn a_viewer_is_sent_the_image_once_and_then_its_pixels() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut tev = Tev::connect(&listener.local_addr().unwrap().to_string(), "a scene").unwrap();
        let film = Film { width: 2, height: 1, mean: vec![1.0, 2.0], ..Film::default() };
        tev.show(&film, &[4.0, 9.0]).unwrap();
        tev.show(&film, &[16.0, 0.0]).unwrap();
        drop(tev);
        let mut sent = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut sent).unwrap();

        let mut rest = sent.as_slice();
        let mut packets = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
            packets.push(&rest[4..length]);
            rest = &rest[length..];
        }
        let [create, first, second] = packets[..] else { panic!("{} packets", packets.len()) };
        let mut create = Reader(create);
        assert_eq!(create.bytes(), [4, 0]);
        assert_eq!((create.text().as_str(), create.int(), create.int(), create.int()), ("a scene", 2, 1, 2));
        assert_eq!([create.text(), create.text()], ["radiance", "error"]);
        assert!(create.0.is_empty());
        for (packet, pixels) in [(first, [1.0f32, 2.0, 2.0, 3.0]), (second, [1.0, 4.0, 2.0, 0.0])] {
            let mut update = Reader(packet);
            assert_eq!(update.bytes(), [6, 0]);
            assert_eq!((update.text().as_str(), update.int()), ("a scene", 2));
            assert_eq!([update.text(), update.text()], ["radiance", "error"]);
            assert_eq!([update.int(), update.int(), update.int(), update.int()], [0, 0, 2, 1]);
            let offsets_and_strides: Vec<i64> = (0..4).map(|_| i64::from_le_bytes(update.bytes())).collect();
            assert_eq!(offsets_and_strides, [0, 1, 2, 2]);
            let sent: Vec<f32> = (0..4).map(|_| f32::from_le_bytes(update.bytes())).collect();
            assert_eq!(sent, pixels);
            assert!(update.0.is_empty());
        }
    }

    #[test]
    fn nobody_there_is_one_line() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        drop(listener);
        assert!(Tev::connect(&address, "a").unwrap_err().to_string().contains("no viewer"));
        assert!(Tev::connect("no port", "a").is_err());
    }
}
