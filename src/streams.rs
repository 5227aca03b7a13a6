//! Which random numbers an image draws.
//!
//! A user gives one seed. The tracer and the camera's sensor each take the seed of a stream, and images whose noise
//! must not be the same take streams of their own: a frame and its baseline, the loads of a press, the scenes of a
//! study, the rungs of a ladder and their reference. A stream's seed is a hash (SHA-256, its first 32 bits) of the
//! user's seed and of all that says which image it is, each part with its length before it, so that no two images give
//! the same text. Nothing is added to a seed: then the numbers of one run would be those of its neighbour.
//!
//! Of k images two share a stream by chance in k^2 / 2^33 of all cases: 1e-4 for a thousand.
//!
//! Common random numbers, where they are asked for, are the user's seed itself, for every image: what two images differ
//! by is then what their scenes differ by, and little noise (Law, *Simulation Modeling and Analysis*, chapter 11).
//! Their noise no longer averages out.

use sha2::{Digest, Sha256};

/// Apart from any other use of this hash.
const DOMAIN: &str = "tirtouch stream 1";

/// Whether images share their random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sharing {
    /// Each image draws its own.
    #[default]
    Own,
    /// All images of a seed draw the same.
    Common,
}

impl Sharing {
    /// Name, as in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Common => "common",
        }
    }
}

/// What an image is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The image that is asked for.
    Image,
    /// The same without inclusions, asked for by itself.
    WithoutInclusions,
    /// The frame without inclusions that a run subtracts.
    Baseline,
    /// What the rungs of a ladder are compared with.
    Reference,
    /// A run of every rung of a ladder: rungs share its numbers, so that what they differ by is their settings.
    Rung(u32),
    /// What is only timed.
    Timing,
}

impl Role {
    fn text(self) -> String {
        match self {
            Self::Image => "image".into(),
            Self::WithoutInclusions => "without inclusions".into(),
            Self::Baseline => "baseline".into(),
            Self::Reference => "reference".into(),
            Self::Rung(run) => format!("rung {run}"),
            Self::Timing => "timing".into(),
        }
    }
}

/// What tells an image from all others of a seed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Streams {
    /// The user's seed.
    pub seed: u32,
    /// Whether images share their random numbers.
    pub sharing: Sharing,
    /// What tells the scene: the SHA-256 of its file, or of the image that is exposed.
    pub scene: String,
    /// What the image is for.
    pub role: Role,
    /// Which load of its press, from 0.
    pub load: usize,
}

impl Streams {
    /// The streams of the first load of a scene, each image with its own.
    #[must_use]
    pub fn new(seed: u32, scene: impl Into<String>, role: Role) -> Self {
        Self { seed, sharing: Sharing::Own, scene: scene.into(), role, load: 0 }
    }

    /// The streams of an image of which nothing is known but its pixels.
    #[must_use]
    pub fn of_image(seed: u32, pixels: &[f32]) -> Self {
        let mut hash = Sha256::new();
        pixels.iter().for_each(|pixel| hash.update(pixel.to_le_bytes()));
        let scene: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Self::new(seed, scene, Role::Image)
    }

    /// Seed of the tracer.
    #[must_use]
    pub fn light(&self) -> u32 {
        self.of("light")
    }

    /// Seed of the sensor's noise.
    #[must_use]
    pub fn sensor(&self) -> u32 {
        self.of("sensor")
    }

    fn of(&self, what: &str) -> u32 {
        if self.sharing == Sharing::Common {
            return self.seed;
        }
        let parts = [DOMAIN, what, &self.seed.to_string(), &self.scene, &self.role.text(), &self.load.to_string()];
        let mut hash = Sha256::new();
        for part in parts {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
        hash.finalize().iter().take(4).fold(0, |seed, byte| seed << 8 | u32::from(*byte))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Every image of some seeds, scenes, roles and loads.
    fn images(sharing: Sharing) -> Vec<Streams> {
        let roles = [
            Role::Image,
            Role::WithoutInclusions,
            Role::Baseline,
            Role::Reference,
            Role::Rung(0),
            Role::Rung(1),
            Role::Timing,
        ];
        let mut images = Vec::new();
        for seed in [0, 1, 2, 12, u32::MAX] {
            for scene in ["", "a", "ab", "b"] {
                for role in roles {
                    for load in [0, 1, 2, 21] {
                        images.push(Streams { sharing, load, ..Streams::new(seed, scene, role) });
                    }
                }
            }
        }
        images
    }

    /// 1,120 streams meet by chance in 1.5e-4 of all hashes; this one is fixed.
    #[test]
    fn no_two_images_draw_the_same_stream_and_each_repeats_its_own() {
        let mut seen = HashMap::new();
        for image in images(Sharing::Own) {
            assert_eq!((image.light(), image.sensor()), (image.clone().light(), image.clone().sensor()));
            for stream in [image.light(), image.sensor()] {
                if let Some(other) = seen.insert(stream, image.clone()) {
                    panic!("{other:?} and {image:?} share {stream}");
                }
            }
        }
    }

    #[test]
    fn common_random_numbers_are_those_of_the_seed() {
        for image in images(Sharing::Common) {
            assert_eq!((image.light(), image.sensor()), (image.seed, image.seed));
        }
    }

    /// Parts that run into one another would make seed 1 of load 12 that of seed 11, load 2.
    #[test]
    fn neighbouring_seeds_and_loads_differ_in_half_of_their_bits() {
        let stream = |seed, load| Streams { load, ..Streams::new(seed, "scene", Role::Image) }.light();
        let (mut changed, mut pairs) = (0, 0);
        for seed in 0..64 {
            for load in 0..4 {
                changed += (stream(seed, load) ^ stream(seed + 1, load)).count_ones();
                changed += (stream(seed, load) ^ stream(seed, load + 1)).count_ones();
                pairs += 2;
            }
        }
        // 512 pairs of 32 bits: a standard deviation of 0.125 about 16, taken six times.
        let mean = f64::from(changed) / f64::from(pairs);
        assert!((mean - 16.0).abs() < 0.75, "{mean}");
    }
}
