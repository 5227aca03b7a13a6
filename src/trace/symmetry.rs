//! Mirror images and turns about the camera's axis under which a model's light is the same.
//!
//! A sensor whose LEDs, footprint and press are alike on all sides sends the same light to a point of the touched face
//! and to its mirror images. So a photon stands for as many as there are such images, and the map is the mean over
//! them: of the eight motions of a square a phantom on the axis of the paper's sensor has all, and takes an eighth of
//! the photons for the same noise of a pixel (docs/decisions/symmetry.md).
//!
//! The noise of a place and of its images is then one. Figures, intervals and comparisons take noise from replicates,
//! which know; camera paths, whose noise is that of single pixels, are sent for each pixel.

use super::leds::Led;
use super::model::{Deformation, Heights, Model, Spare};

/// Differences of heights, mm, and of shares that f32 rounds away in a stack of some mm: up to these two sides are
/// alike.
const ALIKE: f64 = 1e-6;

/// A motion of the plane about the axis: x and y change places, then signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Motion {
    swaps: bool,
    flips: [bool; 2],
}

/// The motions under which a model's light is the same, the one that moves nothing among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symmetry(Vec<Motion>);

impl Motion {
    const NONE: Self = Self { swaps: false, flips: [false; 2] };

    fn all() -> impl Iterator<Item = Self> {
        (0..8).map(|k| Self { swaps: k & 4 != 0, flips: [k & 1 != 0, k & 2 != 0] })
    }

    fn of<T: Copy + std::ops::Neg<Output = T>>(self, [x, y]: [T; 2]) -> [T; 2] {
        let [x, y] = if self.swaps { [y, x] } else { [x, y] };
        [if self.flips[0] { -x } else { x }, if self.flips[1] { -y } else { y }]
    }

    /// Where a cell of a grid comes to lie, and the grid's size then.
    fn cell(self, [column, row]: [usize; 2], size: [usize; 2]) -> [usize; 2] {
        let ([column, row], [columns, rows]) = match self.swaps {
            true => ([row, column], [size[1], size[0]]),
            false => ([column, row], size),
        };
        [if self.flips[0] { columns - 1 - column } else { column }, if self.flips[1] { rows - 1 - row } else { row }]
    }

    /// Whether it leaves the values of a grid about the axis where they are.
    fn keeps(self, grid: &[f64], size: [usize; 2]) -> bool {
        let [columns, rows] = size;
        (!self.swaps || columns == rows)
            && (0..columns * rows).all(|k| {
                let [column, row] = self.cell([k % columns, k / columns], size);
                (grid[row * columns + column] - grid[k]).abs() <= ALIKE
            })
    }

    fn keeps_point(self, point: [f64; 2]) -> bool {
        self.of(point).iter().zip(point).all(|(moved, at)| (moved - at).abs() <= ALIKE)
    }

    fn keeps_shape(self, shape: &Deformation<f64>) -> bool {
        match shape {
            Deformation::Plane => true,
            Deformation::Cap(cap) => self.keeps_point(cap.center),
            Deformation::Field(field) => {
                self.keeps_point(field.center)
                    && match &field.heights {
                        Heights::Profile { .. } => true,
                        Heights::Grid { size, per_mm, control } => {
                            (!self.swaps || per_mm[0] == per_mm[1])
                                && control.iter().all(|control| self.keeps(control, size.map(|points| points + 2)))
                        }
                    }
            }
            Deformation::Mesh(_) => self == Self::NONE,
        }
    }

    /// Where an LED comes to lie: the outward axis of its wall, and its place along that.
    fn led(self, led: &Led<f64>) -> ([f64; 2], f64) {
        let outward = if led.wall.is_multiple_of(2) { 1.0 } else { -1.0 };
        let [out, along] = match led.wall < 2 {
            true => [[outward, 0.0], [0.0, led.along]],
            false => [[0.0, outward], [led.along, 0.0]],
        };
        (self.of(out), self.of(along).iter().sum())
    }

    /// Whether it brings as many LEDs to each place as lie there, of the same kind.
    fn keeps_leds(self, leds: &[Led<f64>]) -> bool {
        let numbers = |led: &Led<f64>| [led.height, led.radius, led.gap, led.radiance, led.exponent, led.cos_cutoff];
        let close = |(a, b): (f64, f64)| (a - b).abs() <= 1e-12 * a.abs();
        let as_many = |led: &Led<f64>| {
            let alike = |motion: Self| {
                let (wall, along) = motion.led(led);
                let here = |other: &&Led<f64>| {
                    let place = Self::NONE.led(other);
                    wall == place.0
                        && (along - place.1).abs() <= ALIKE
                        && led.air == other.air
                        && numbers(led).into_iter().zip(numbers(other)).all(close)
                };
                leds.iter().filter(here).count()
            };
            alike(self) == alike(Self::NONE)
        };
        // The azimuth of a table runs one way about its LED.
        self == Self::NONE || leds.iter().all(|led| led.table.is_none() && as_many(led))
    }
}

impl Symmetry {
    /// That of a model.
    pub fn of(model: &Model<f64>) -> Self {
        if model.spare.contains(&Spare::MirrorImages) {
            return Self(vec![Motion::NONE]);
        }
        let square = model.half_size[0] == model.half_size[1] && model.map_size[0] == model.map_size[1];
        let keeps = |motion: &Motion| {
            (!motion.swaps || square)
                && motion.keeps_leds(&model.leds)
                && motion.keeps_shape(&model.shape)
                && model.tissue.as_ref().is_none_or(|tissue| {
                    motion.keeps_point(tissue.center) && motion.keeps(&tissue.grid, tissue.grid_size)
                })
        };
        Self(Motion::all().filter(keeps).collect())
    }

    /// All motions of a square.
    #[cfg(test)]
    pub(super) fn all() -> Self {
        Self(Motion::all().collect())
    }

    /// How many images a photon stands for.
    pub fn images(&self) -> usize {
        self.0.len()
    }

    /// The part of a grid about the axis that mirrors along its axes leave.
    pub fn fold(&self, size: [usize; 2]) -> Fold {
        let mirrors = [[true, false], [false, true]].map(|flips| Motion { swaps: false, flips });
        // A texel that a mirror cuts would count half.
        let mirrors = [0, 1].map(|axis| self.0.contains(&mirrors[axis]) && size[axis].is_multiple_of(2));
        Fold { size, mirrors }
    }

    /// The mean over all images of what lies on a grid, in its part.
    pub fn average(&self, grid: &[f64], fold: &Fold) -> Vec<f64> {
        let share = 1.0 / self.images() as f64;
        let mean = |place: [usize; 2]| {
            let image = |motion: &Motion| {
                let [column, row] = motion.cell(place, fold.size);
                grid[row * fold.size[0] + column]
            };
            share * self.0.iter().map(image).sum::<f64>()
        };
        fold.places().map(mean).collect()
    }
}

/// A grid of which the half before each mirror is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fold {
    size: [usize; 2],
    /// Along which axes there is one.
    pub mirrors: [bool; 2],
}

impl Fold {
    /// Columns and rows of the part.
    pub fn part_size(&self) -> [usize; 2] {
        [0, 1].map(|axis| if self.mirrors[axis] { self.size[axis] / 2 } else { self.size[axis] })
    }

    fn places(&self) -> impl Iterator<Item = [usize; 2]> {
        let [columns, rows] = self.part_size();
        (0..columns * rows).map(move |k| [k % columns, k / columns])
    }

    /// The part of a grid that is its own mirror image.
    pub fn part(&self, whole: &[f64]) -> Vec<f64> {
        self.places().map(|[column, row]| whole[row * self.size[0] + column]).collect()
    }

    /// The grid of a part.
    pub fn whole(&self, part: &[f64]) -> Vec<f64> {
        let [columns, rows] = self.part_size();
        let place = |k: usize, axis: usize, held: usize| if k < held { k } else { self.size[axis] - 1 - k };
        let row = |y: usize| {
            let row = &part[place(y, 1, rows) * columns..][..columns];
            (0..self.size[0]).map(move |x| row[place(x, 0, columns)])
        };
        (0..self.size[1]).flat_map(row).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::compare::compare;
    use crate::film::{BlockAccumulator, Film};
    use crate::scene::{LoadedScene, preset};
    use crate::trace::backend::CpuTracer;
    use crate::trace::batch::{Batch, Work};
    use crate::trace::exitance::{Smoothing, TouchedFace};
    use crate::trace::{Backend, Method};

    fn scene(name: &str) -> LoadedScene {
        let mut loaded = preset(name).unwrap();
        loaded.scene.camera.pixel_pitch_um *= 348.0 / 30.0;
        loaded.scene.camera.pixels = [30, 23];
        loaded.scene.render.map_texel_mm = 0.5;
        loaded
    }

    fn model(loaded: &LoadedScene) -> Model<f64> {
        let shape = crate::surface::surface(loaded).unwrap();
        Model::new(loaded, &shape, crate::surface::contact_map(loaded).unwrap()).unwrap()
    }

    fn symmetry(change: impl Fn(&mut Model<f64>)) -> Symmetry {
        let mut model = model(&scene("contact-disc"));
        change(&mut model);
        Symmetry::of(&model)
    }

    #[test]
    fn what_differs_from_side_to_side_takes_its_mirror_images_away() {
        let images = |change: fn(&mut Model<f64>)| symmetry(change).images();
        assert_eq!(images(|_| ()), 8);
        // LEDs stand on +x, -x, +y and -y.
        assert_eq!(images(|m| m.leds[0].radiance *= 1.1), 2);
        assert_eq!(images(|m| m.leds[2].height += 0.1), 2);
        assert_eq!(images(|m| m.leds.truncate(2)), 4);
        assert_eq!(images(|m| m.leds.truncate(3)), 2);
        assert_eq!(images(|m| m.leds.push(m.leds[0])), 2);
        assert_eq!(images(|m| m.leds[3].table = Some(0)), 1);
        assert_eq!(images(|m| m.tissue.as_mut().unwrap().center = [1.0, 0.0]), 2);
        assert_eq!(images(|m| m.tissue.as_mut().unwrap().center = [1.0, 1.0]), 2);
        assert_eq!(images(|m| m.tissue.as_mut().unwrap().center = [1.0, 0.5]), 1);
        assert_eq!(images(|m| m.half_size[0] += 1.0), 4);
        // Each LED beside the middle of its wall, the same way round: turns are left, mirrors are not.
        let aside = |m: &mut Model<f64>| m.leds.iter_mut().zip([1.0, -1.0, -1.0, 1.0]).for_each(|(l, at)| l.along = at);
        assert_eq!(images(aside), 4);
        assert_eq!(images(|m| m.spare.push(Spare::MirrorImages)), 1);
    }

    #[test]
    fn grids_are_as_alike_as_f32_tells() {
        let with_grid = |off: f64| {
            symmetry(|m| {
                let tissue = m.tissue.as_mut().unwrap();
                (tissue.grid_size, tissue.grid) = ([4, 4], vec![0.5; 16]);
                tissue.grid[1] += off;
            })
        };
        assert_eq!((with_grid(1e-9).images(), with_grid(1e-4).images()), (8, 1));
    }

    #[test]
    fn means_are_the_same_in_all_mirror_images_and_lose_nothing() {
        let mut some = vec![Symmetry(vec![Motion::NONE]), Symmetry::all()];
        for (swaps, flips) in [(false, [true, false]), (false, [false, true]), (false, [true; 2]), (true, [false; 2])] {
            some.push(Symmetry(vec![Motion::NONE, Motion { swaps, flips }]));
        }
        for symmetry in some {
            for size in [[6, 6], [5, 5]] {
                let grid: Vec<f64> = (0..size[0] * size[1]).map(|k| ((k * k) % 97) as f64).collect();
                let fold = symmetry.fold(size);
                let part = symmetry.average(&grid, &fold);
                let mean = fold.whole(&part);
                assert_eq!(fold.part(&mean), part);
                assert_eq!(part.len() < mean.len(), symmetry.images() > 1 && fold.mirrors != [false; 2]);
                assert!(symmetry.0.iter().all(|motion| motion.keeps(&mean, size)));
                assert!((mean.iter().sum::<f64>() - grid.iter().sum::<f64>()).abs() < 1e-9);
            }
        }
    }

    /// An image of 16 replicates, and the variance of their maps; with all mirror images, whether or not they are there.
    fn film(model: &Model<f64>, seed: u32, all: bool) -> (Film, f64) {
        let mut backend = Backend::Cpu32(Box::new(CpuTracer::new(model.cast())));
        let mut batch = Batch::new(model, &mut backend, Method::Map, seed);
        let face = TouchedFace::new(model);
        let face = if all { face.with_all_images(model.map_size) } else { face };
        let work = Work { spp: 64, photons: 1 << 14 };
        let maps: Vec<_> = (0..16).map(|k| batch.contact_light(k, work, &face, &mut |_| true).unwrap()).collect();
        let raw = face.texels(&maps, Smoothing::default());
        let over = |cell: usize, of: fn(f64) -> f64| raw.iter().map(|texels| of(texels[cell][0])).sum::<f64>() / 16.0;
        let noise = (0..raw[0].len()).map(|cell| over(cell, |v| v * v) - over(cell, |v| v).powi(2)).sum();
        let mut sum = BlockAccumulator::new(model.camera.size[0], model.camera.size[1]);
        for (k, texels) in (0..).zip(face.texels(&maps, face.choose(&maps))) {
            sum.add(&batch.mapped(k, work, &texels, &mut |_| true).unwrap()).unwrap();
        }
        (sum.finish(), noise)
    }

    #[test]
    fn images_are_those_without_symmetry_and_false_symmetry_is_seen() {
        for name in ["contact-disc", "absorbing"] {
            let mut whole = model(&scene(name));
            // All light by photons, of each place.
            whole.spare.extend([Spare::MirrorImages, Spare::Direct]);
            let agree = |a: &Film, b: &Film| compare(a, b, 1e-4).unwrap();
            let ((mirrored, less), (image, noise)) = (film(&whole, 1, true), film(&whole, 2, false));
            assert!(agree(&mirrored, &image).passed, "{name}: {:?}", agree(&mirrored, &image));
            assert!((0.1..0.16).contains(&(less / noise)), "{name}: {less} of {noise}");
            let mut lop_sided = whole;
            // Less than a fourth of the photons from the first of four.
            lop_sided.leds[0].cumulative = 0.15;
            let ((false_image, _), (image, _)) = (film(&lop_sided, 3, true), film(&lop_sided, 4, false));
            assert!(!agree(&false_image, &image).passed, "{name}");
        }
    }
}
