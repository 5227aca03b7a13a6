//! Films of many seeds of one case, kept on disk as their replicates.

use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};
use tirtouch::film::{BlockAccumulator, Film};
use tirtouch::pipeline::{Order, Session};
use tirtouch::progress::Observer;
use tirtouch::scene::preset;
use tirtouch::trace::batch::{Batch, Work};
use tirtouch::trace::exitance::TouchedFace;
use tirtouch::trace::render::REPLICATES;
use tirtouch::trace::{Backend, BackendChoice, Devices, Integrator, Model, Precision};

/// A scene and how its light is found.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub scene: &'static str,
    pub integrator: Integrator,
    pub photons: u64,
    /// Columns and rows in place of the scene's own, over the same view.
    pub size: Option<[u32; 2]>,
}

impl Case {
    pub fn name(&self) -> String {
        let size = self.size.map_or_else(|| "full".to_owned(), |[columns, rows]| format!("{columns}x{rows}"));
        format!("{}-{}-{size}", self.scene, self.integrator.name())
    }

    fn model(&self) -> Result<Model<f64>> {
        let mut loaded = preset(self.scene)?;
        if let Some(size) = self.size {
            let camera = &mut loaded.scene.camera;
            camera.pixel_pitch_um *= f64::from(camera.pixels[0]) / f64::from(size[0]);
            camera.pixels = size;
        }
        if let Some(press) = &mut loaded.scene.press {
            press.estimate_error = false;
        }
        let order = Order::of(&loaded.scene);
        Ok(Session::from(Devices::cpu(Precision::F32)).prepare(loaded, &order, &mut |_| true)?.model)
    }
}

/// The films of seeds `0..count`: rendered on one device, or read where a run before has left them in `folder`.
pub struct Films {
    pub size: [u32; 2],
    samples: u32,
    files: Vec<PathBuf>,
}

impl Films {
    pub fn of(case: &Case, count: u32, spp: u32, folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder)?;
        let model = case.model()?;
        let files: Vec<PathBuf> =
            (0..count).map(|seed| folder.join(format!("{}-{spp}-{}-{seed}.f32", case.name(), case.photons))).collect();
        let mut backend = None;
        for (seed, file) in (0..).zip(&files) {
            if file.exists() {
                continue;
            }
            if backend.is_none() {
                backend = Some(Devices::open(BackendChoice::Auto, Precision::F32)?.load(&model)?);
            }
            let backend = backend.as_mut().context("a device")?;
            let replicates: Vec<f32> = render(&model, backend, case, seed, spp)?.concat();
            let whole = file.with_extension("part");
            std::fs::write(&whole, bytemuck::cast_slice(&replicates))?;
            std::fs::rename(&whole, file)?;
        }
        Ok(Self { size: model.camera.size, samples: spp, files })
    }

    /// A film as its file has it: without its groups.
    pub fn film(&self, seed: usize) -> Result<Film> {
        let bytes = std::fs::read(self.files.get(seed).context("no such seed")?)?;
        let values: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        let mut sum = BlockAccumulator::new(self.size[0], self.size[1]);
        for replicate in values.chunks_exact((self.size[0] * self.size[1]) as usize) {
            sum.add(&replicate.iter().map(|&v| f64::from(v)).collect::<Vec<_>>())?;
        }
        Ok(Film { groups: Vec::new(), samples: self.samples, ..sum.finish() })
    }
}

/// The replicates of one film, as `render` makes them, without their ledger.
fn render(model: &Model<f64>, backend: &mut Backend, case: &Case, seed: u32, spp: u32) -> Result<Vec<Vec<f32>>> {
    let integrator = case.integrator;
    let mut batch = Batch::new(model, backend, integrator, seed);
    let work = Work { spp: spp.div_ceil(REPLICATES), photons: case.photons.div_ceil(REPLICATES.into()) };
    let go_on: &mut Observer = &mut |_| true;
    let images: Vec<Vec<f64>> = if integrator == Integrator::Map {
        let face = TouchedFace::new(model);
        let maps =
            (0..REPLICATES).map(|k| batch.contact_light(k, work, &face, go_on)).collect::<Result<Vec<_>, _>>()?;
        let smoothing = face.choose(&maps);
        let texels = face.texels(&maps, smoothing);
        (0..).zip(&texels).map(|(k, texels)| batch.mapped(k, work, texels, go_on)).collect::<Result<_, _>>()?
    } else {
        (0..REPLICATES).map(|k| batch.replicate(k, work, go_on)).collect::<Result<_, _>>()?
    };
    Ok(images.into_iter().map(|image| image.into_iter().map(|v| v as f32).collect()).collect())
}
