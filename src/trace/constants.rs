//! Constants that the shaders and their twin share: typed once, here, and written into every kernel by [`wgsl`].

/// A constant as WGSL writes it.
trait Wgsl: Copy {
    fn declared(self, name: &str) -> String;
}

impl Wgsl for u32 {
    fn declared(self, name: &str) -> String {
        format!("const {name}: u32 = {self}u;\n")
    }
}

impl Wgsl for usize {
    fn declared(self, name: &str) -> String {
        format!("const {name}: u32 = {self}u;\n")
    }
}

impl Wgsl for f64 {
    /// The shortest decimal of the same f64: rounded to f32 once, as the twin's is.
    fn declared(self, name: &str) -> String {
        format!("const {name}: f32 = {self:?};\n")
    }
}

macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident: $kind:ty = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $kind = $value;)*

        fn own() -> Vec<String> {
            vec![$($name.declared(stringify!($name))),*]
        }
    };
}

shared! {
    /// Ledger units of one photon, or of a camera path's first weight.
    UNIT: f64 = 1_048_576.0;
    /// Further than anything, mm.
    FAR: f64 = 1e30;
    /// Mark of a path that inner faces, walls or tissue sent another way.
    STRAY: u32 = 1 << 31;

    /// Weight below which roulette is played for photons.
    LEAST_PHOTON: f64 = 0.1;
    /// Least weight of what enters tissue of a photon that is split there; those of less than twice that are not.
    ENTERED: f64 = 0.15;
    /// Share that is mirrored of those that are split, at least.
    MIRRORED: f64 = 0.5;
    /// For camera paths where nothing touches: they carry what outer faces mirror as a weight.
    LEAST_EYE: f64 = 0.01;
    /// For camera paths on their way to tissue.
    LEAST_EYE_TOUCHED: f64 = 0.003;
    /// Chance to go on at the least weight. Survivors weigh twice that: at the least itself rounding would decide
    /// whether they play again.
    KEEP_AT_LEAST: f64 = 0.5;
    /// Most chance to go on.
    MOST_KEPT: f64 = 0.95;
    /// Least share of the paths that go on as reflected where a map is read: what they see may be an LED, and nothing
    /// is lost by them.
    REFLECTED: f64 = 0.2;

    /// Factor of pcg3d.
    PCG_FACTOR: u32 = 1_664_525;
    /// Its summand.
    PCG_SUMMAND: u32 = 1_013_904_223;
    /// Bits by which the round of a path goes into the number of its launch, after those of its thread.
    ROUND_BITS: u32 = 14;
    /// What draws of a path are apart.
    DRAW_STEP: u32 = 0x9e37_79b9;
    /// Factor of a draw's first round.
    DRAW_FIRST: u32 = 0x21f0_aaad;
    /// Of its second.
    DRAW_SECOND: u32 = 0xd35a_2d97;
    /// First factor that scrambles a launch.
    SCRAMBLE_FIRST: u32 = 0x3d20_adea;
    /// The second.
    SCRAMBLE_SECOND: u32 = 0x0552_6c56;
    /// The last.
    SCRAMBLE_LAST: u32 = 0x53a2_2864;
    /// 2^-24: what the upper 24 bits of a word count.
    OF_24_BITS: f64 = 5.960_464_477_539_063e-8;

    /// Threads of a workgroup.
    WORKGROUP: u32 = 64;
    /// Most steps of the search for the way from a deposit to the pinhole.
    SPLAT_STEPS: u32 = 24;

    /// Cells of an intensity table along sin^2(theta) and along the azimuth.
    TABLE_EDGE: usize = 64;
    /// In place of a table's first entry.
    NO_TABLE: u32 = u32::MAX;

    /// Steps of the search on a height field that never pass the surface, before they are lengthened.
    SAFE_STEPS: f64 = 64.0;
    /// How far beyond the surface a longer step has passed it, mm: above rounding and the safe steps' own error.
    STEPPED_OVER: f64 = 1e-5;

    /// Words of a path's history; the first is the number of its events.
    EVENTS: u32 = 64;
    /// Events at face i: four codes from 4 i (total reflection, reflection, transmission). At wall k: two from here.
    EVENT_WALL: u32 = 256;
    /// True contact or gap, where a path meets tissue.
    EVENT_CONTACT: u32 = 512;
    /// Reflection or transmission where light leaves the tissue.
    EVENT_REENTRY: u32 = 514;
    /// The same where it enters.
    EVENT_TISSUE: u32 = 520;
    /// The LED k that a path starts from or meets.
    EVENT_LED: u32 = 600;
    /// How it ends: an [`End`].
    EVENT_END: u32 = 1000;
}

/// How a walk ends, or that it goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum End {
    /// Not ended.
    GoesOn = 0,
    /// At a black wall, or at a bonded LED in a mirror.
    Wall = 1,
    /// Left through a clear wall.
    Sides = 2,
    /// Left through the touched side.
    Top = 3,
    /// Left towards the camera.
    Bottom = 4,
    /// At tissue: the walk goes on after it.
    Touch = 5,
    /// Absorbed.
    Absorbed = 6,
    /// Russian roulette.
    Roulette = 7,
    /// The cap on interactions.
    Cap = 8,
    /// No surface was found: an error.
    Lost = 9,
    /// An aimed photon that can meet tissue no more.
    Astray = 10,
}

/// Slots of the flux ledger.
pub mod book {
    /// Sent out.
    pub const EMITTED: usize = 0;
    /// Absorbed.
    pub const ABSORBED: usize = 1;
    /// Left through the touched side.
    pub const TOP: usize = 2;
    /// Left towards the camera.
    pub const BOTTOM: usize = 3;
    /// Left through the walls.
    pub const SIDES: usize = 4;
    /// Entered the lens.
    pub const DETECTED: usize = 5;
    /// Cut off.
    pub const TERMINATED: usize = 6;
    /// Roulette.
    pub const ROULETTE: usize = 7;
    /// Lost paths.
    pub const LOST: usize = 8;
    /// Segments traced.
    pub const SEGMENTS: usize = 9;
    /// Number of slots.
    pub const SLOTS: usize = 10;
}

/// Roughness of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Finish {
    /// None.
    #[default]
    Smooth,
    /// Small: a mirror that loses a share to a lobe.
    Small,
    /// Microfacets.
    Microfacet,
}

/// All of them, with the numbers of [`End`], [`book`] and [`Finish`], as declarations.
pub fn wgsl() -> String {
    let ends = [
        ("GOES_ON", End::GoesOn),
        ("END_WALL", End::Wall),
        ("END_SIDES", End::Sides),
        ("END_TOP", End::Top),
        ("END_BOTTOM", End::Bottom),
        ("END_TOUCH", End::Touch),
        ("END_ABSORBED", End::Absorbed),
        ("END_ROULETTE", End::Roulette),
        ("END_CAP", End::Cap),
        ("END_LOST", End::Lost),
        ("END_ASTRAY", End::Astray),
    ];
    let slots = [
        ("BOOK_EMITTED", book::EMITTED),
        ("BOOK_ABSORBED", book::ABSORBED),
        ("BOOK_TOP", book::TOP),
        ("BOOK_BOTTOM", book::BOTTOM),
        ("BOOK_SIDES", book::SIDES),
        ("BOOK_DETECTED", book::DETECTED),
        ("BOOK_TERMINATED", book::TERMINATED),
        ("BOOK_ROULETTE", book::ROULETTE),
        ("BOOK_LOST", book::LOST),
        ("BOOK_SEGMENTS", book::SEGMENTS),
        ("BOOK_SLOTS", book::SLOTS),
    ];
    let finishes =
        [("SMOOTH", Finish::Smooth), ("ROUGH_SMALL", Finish::Small), ("ROUGH_MICROFACET", Finish::Microfacet)];
    let words = ends.map(|(name, end)| (name, end as u32)).into_iter();
    let words = words.chain(slots.map(|(name, slot)| (name, slot as u32)));
    let words = words.chain(finishes.map(|(name, finish)| (name, finish as u32)));
    own().into_iter().chain(words.map(|(name, word)| word.declared(name))).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Rounding twice (to a few digits, then to f32) could differ from the twin's once.
    #[test]
    fn the_shaders_read_the_same_numbers() {
        let text = wgsl();
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let value = |name: &str| {
            let (_, constant) = module.constants.iter().find(|(_, one)| one.name.as_deref() == Some(name)).unwrap();
            match module.global_expressions[constant.init] {
                naga::Expression::Literal(naga::Literal::F32(value)) => f64::from(value),
                naga::Expression::Literal(naga::Literal::U32(value)) => f64::from(value),
                ref other => panic!("{other:?}"),
            }
        };
        assert_eq!(module.constants.len(), text.lines().count());
        for (name, twin) in [("LEAST_EYE_TOUCHED", LEAST_EYE_TOUCHED), ("STEPPED_OVER", STEPPED_OVER), ("FAR", FAR)] {
            assert_eq!(value(name), f64::from(twin as f32), "{name}");
        }
        assert_eq!((value("END_ASTRAY"), value("BOOK_SLOTS")), (10.0, 10.0));
        assert_eq!(value("STRAY"), 2_147_483_648.0);
    }
}
