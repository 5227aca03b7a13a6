//! Images of the points, kept as a data set: in `train/` and `test/`, with a table of their labels beside them.

use super::{Format, Images, Kept, KeptLoad, Record, State, Sweep};
use crate::image_io::{write_npy, write_png_grey};
use crate::mechanics::mesh::{InclusionShape, Star};
use crate::output::{OutputError, Records};
use crate::pipeline::{Shot, view_of};
use crate::scene::Invalid;
use crate::surface::pressed::pressure_at;
use std::collections::BTreeMap;

/// Columns of a data set's labels beside what varies.
pub(super) const LABELS: &[&str] = &[
    "file_name",
    "baseline_file_name",
    "mask_file_name",
    "pressure_npy",
    "split",
    "seed",
    "true_size_mm",
    "true_depth_mm",
    "true_youngs_kpa",
    "true_phantom_youngs_kpa",
    "mm_per_pixel",
    "light_stream",
    "sensor_stream",
];

/// What labels say of a load; of a press without steps the first three.
const OF_LOAD: [&str; 6] = ["load", "press_depth_mm", "force_n", "slide_x_mm", "slide_y_mm", "hold_s"];

impl Sweep {
    /// Columns of a data set's labels that say of an image's load what it is.
    pub fn of_load(&self) -> &'static [&'static str] {
        let has_steps = self.base.scene.press.as_ref().is_some_and(|press| !press.step.is_empty());
        if has_steps { &OF_LOAD } else { &OF_LOAD[..3] }
    }
}

impl Images {
    fn ending(self) -> &'static str {
        match self.format {
            Format::Png => "png",
            Format::Exr => "exr",
            Format::Npy => "npy",
        }
    }

    /// Name of a point's image without inclusions.
    pub fn baseline_file(&self, row: usize) -> String {
        format!("{row:07}_baseline.{}", self.ending())
    }

    /// Name of the mask of one of a point's images: that of the point, but where the phantom slides from load to load.
    pub fn mask_file(record: &Record, image: &Kept) -> String {
        let slide = |kept: &Kept| kept.load.map(|load| load.slide_mm);
        match record.images.iter().all(|one| slide(one) == slide(image)) {
            true => format!("{:07}_mask.png", record.row),
            false => format!("{}_mask.png", stem(&image.file)),
        }
    }

    /// Name of the contact pressures of an image.
    pub fn pressure_file(image: &str) -> String {
        format!("{}_pressure.npy", stem(image))
    }

    /// All files of a point that has images, from the sweep's folder.
    pub(super) fn files<'a>(&'a self, record: &'a Record) -> impl Iterator<Item = String> + 'a {
        let of_image = |kept: &'a Kept| {
            let pressure = self.pressures.then(|| Self::pressure_file(&kept.file));
            [Some(kept.file.clone()), pressure, self.masks.then(|| Self::mask_file(record, kept))]
        };
        let baseline = (self.baseline && !record.images.is_empty()).then(|| self.baseline_file(record.row));
        let split = self.split(record.row);
        record.images.iter().flat_map(of_image).chain([baseline]).flatten().map(move |file| format!("{split}/{file}"))
    }

    /// Keeps an image, with its contact pressures where they are asked for.
    pub(super) fn keep(
        &self,
        records: &Records,
        row: usize,
        shot: &Shot,
        load: Option<usize>,
    ) -> Result<Kept, OutputError> {
        let file = match load {
            Some(load) => format!("{row:07}_{load}.{}", self.ending()),
            None => format!("{row:07}.{}", self.ending()),
        };
        let step = shot.prepared.pressed().map(|(_, step)| step);
        self.write(records, row, &file, shot)?;
        if self.pressures {
            let [width, _] = shot.prepared.scene().camera.pixels;
            let name = format!("{}/{}", self.split(row), Self::pressure_file(&file));
            records.write_with(&name, |path| write_npy(path, width, &pressures(shot)))?;
        }
        Ok(Kept {
            file,
            load: load.zip(step).map(|(number, step)| KeptLoad {
                number,
                depth_mm: step.depth_mm,
                force_n: step.force_n,
                slide_mm: step.slide_mm,
                hold_s: step.hold_s,
            }),
            mm_per_pixel: shot.mm_per_pixel,
            streams: [shot.prepared.streams.light(), shot.prepared.streams.sensor()],
        })
    }

    /// Keeps the image without inclusions.
    pub(super) fn keep_baseline(&self, records: &Records, row: usize, shot: &Shot) -> Result<(), OutputError> {
        self.write(records, row, &self.baseline_file(row), shot)
    }

    fn write(&self, records: &Records, row: usize, file: &str, shot: &Shot) -> Result<(), OutputError> {
        records.write_with(&format!("{}/{file}", self.split(row)), |path| match self.format {
            Format::Png => shot.frame.write_png(path),
            Format::Exr => shot.write_radiance(path, "tirtouch sweep"),
            Format::Npy => write_npy(path, shot.outcome.film.width, &shot.outcome.film.mean),
        })
    }

    /// Keeps the masks of a point's images; `shot` is of any of them.
    pub(super) fn keep_masks(&self, records: &Records, record: &Record, shot: &Shot) -> Result<(), OutputError> {
        let [width, height] = shot.prepared.scene().camera.pixels;
        let all: BTreeMap<String, [f64; 2]> = (record.images.iter())
            .map(|kept| (Self::mask_file(record, kept), kept.load.map_or([0.0; 2], |load| load.slide_mm)))
            .collect();
        all.into_iter().try_for_each(|(file, slide_mm)| {
            let (name, mask) = (format!("{}/{file}", self.split(record.row)), mask(shot, slide_mm));
            records.write_with(&name, |path| write_png_grey(path, width, height, &mask, 8))
        })
    }
}

/// A file's name up to its first dot.
fn stem(file: &str) -> &str {
    file.split_once('.').map_or(file, |(stem, _)| stem)
}

/// 255 where a pixel sees a point of the touched face over an inclusion of a phantom that slid so far, else 0.
fn mask(shot: &Shot, slide_mm: [f64; 2]) -> Vec<u16> {
    let scene = shot.prepared.scene();
    let [width, height] = scene.camera.pixels.map(|pixels| pixels as usize);
    let (Some((pressed, _)), Ok(view)) = (shot.prepared.pressed(), view_of(scene)) else {
        return vec![0; width * height];
    };
    let inclusions = &pressed.setup.phantom.inclusions;
    let pixel = |k: usize| {
        let middle = [(k % width) as f64 + 0.5, (k / width) as f64 + 0.5];
        let over = view.touched_from_pixel(middle).is_some_and(|[x, y]| {
            let place = [x - slide_mm[0], y - slide_mm[1]];
            inclusions.iter().any(|one| is_over(one, place))
        });
        if over { 255 } else { 0 }
    };
    (0..width * height).map(pixel).collect()
}

/// Contact pressure where each pixel sees the touched face, kPa; 0 where it sees none.
fn pressures(shot: &Shot) -> Vec<f32> {
    let scene = shot.prepared.scene();
    let [width, height] = scene.camera.pixels.map(|pixels| pixels as usize);
    let (Some((pressed, step)), Ok(view)) = (shot.prepared.pressed(), view_of(scene)) else {
        return vec![0.0; width * height];
    };
    let pressure = pressure_at(pressed, step);
    let middle = |k: usize| [(k % width) as f64 + 0.5, (k / width) as f64 + 0.5];
    (0..width * height).map(|k| view.touched_from_pixel(middle(k)).map_or(0.0, &pressure) as f32).collect()
}

/// Whether a point of the face lies over an inclusion.
fn is_over(inclusion: &InclusionShape, [x, y]: [f64; 2]) -> bool {
    let [x, y] = [x - inclusion.center_mm[0], y - inclusion.center_mm[1]];
    match &inclusion.surface {
        Star::Ellipsoid { semi_axes_mm: [a, b, _] } => (x / a).powi(2) + (y / b).powi(2) <= 1.0,
        Star::Mesh(mesh) => mesh.triangles.iter().any(|corners| {
            let corner = |k: usize| mesh.vertices.get(corners[k] as usize).map_or([0.0; 2], |v| [v[0], v[1]]);
            let side = |k: usize| {
                let ([ax, ay], [bx, by]) = (corner(k), corner((k + 1) % 3));
                (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            };
            let sides = [side(0), side(1), side(2)];
            sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
        }),
    }
}

impl Sweep {
    /// Whether it keeps the radiance of its images.
    pub fn keeps_radiance(&self) -> bool {
        self.file.sweep.images.is_some_and(|images| images.format == Format::Exr)
    }

    /// Refuses a sweep that keeps no radiance.
    ///
    /// # Errors
    /// That, with its key.
    pub fn check_radiance(&self) -> Result<(), Invalid> {
        match self.keeps_radiance() {
            true => Ok(()),
            false => {
                let what = format!("of {} keeps no radiance, which is read here: format = \"exr\"", self.name);
                Err(Invalid::new("sweep.images", what))
            }
        }
    }

    /// Points whose images are kept, with them.
    pub fn kept<'a>(&'a self, records: &'a Records) -> impl Iterator<Item = (usize, Record)> + 'a {
        (0..self.plan.count()).filter_map(|row| {
            let record = self.record(records, row).filter(|record| record.status == State::Done)?;
            (!record.images.is_empty()).then_some((row, record))
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::TriangleMesh;
    use std::sync::Arc;

    #[test]
    fn a_point_lies_over_what_projects_on_it() {
        let at = |surface| InclusionShape { center_mm: [2.0, -1.0, 9.0], surface };
        let ellipsoid = at(Star::Ellipsoid { semi_axes_mm: [4.0, 1.0, 3.0] });
        assert!(is_over(&ellipsoid, [5.9, -1.0]) && !is_over(&ellipsoid, [2.0, 0.1]));
        // A tetrahedron over the triangle (0, 0), (4, 0), (0, 2).
        let vertices = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.5, -1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = at(Star::Mesh(Arc::new(TriangleMesh { vertices, triangles })));
        assert!(is_over(&mesh, [3.0, -0.6]) && !is_over(&mesh, [5.0, 0.5]) && !is_over(&mesh, [1.9, -1.0]));
    }
}
