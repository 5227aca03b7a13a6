//! The files that a scene names.

use super::{InclusionBody, Indenter, Pattern, Phantom, Pressure, ScanScene, Scene, Shape};
use std::path::Path;

impl Scene {
    /// Key and path (as written) of every file that the scene names.
    pub fn files(&self) -> Vec<(String, &Path)> {
        let mut files = Vec::new();
        for (index, led) in self.led.iter().enumerate() {
            if let Pattern::Ies { file } = &led.pattern {
                files.push((format!("led[{index}].pattern.file"), file.as_path()));
            }
        }
        if let Shape::HeightMap { file, .. } | Shape::Mesh { file, .. } = &self.touch.shape {
            files.push(("touch.shape.file".to_owned(), file.as_path()));
        }
        if let Some(contact) = &self.touch.contact
            && let Pressure::Table { file, .. } | Pressure::Map { file, .. } = &contact.pressure
        {
            files.push(("touch.contact.pressure.file".to_owned(), file.as_path()));
        }
        files.extend(self.phantom.iter().flat_map(phantom_files));
        files
    }
}

impl ScanScene {
    /// Key and path (as written) of every file that the scene names.
    pub fn files(&self) -> Vec<(String, &Path)> {
        let mut files = phantom_files(&self.phantom);
        if let Indenter::Table { file } = &self.scan.indenter {
            files.push(("scan.indenter.file".to_owned(), file.as_path()));
        }
        files
    }
}

fn phantom_files(phantom: &Phantom) -> Vec<(String, &Path)> {
    let bodies = phantom.inclusion.iter().enumerate();
    let meshes = bodies.filter_map(|(index, one)| match &one.shape {
        InclusionBody::Mesh { file, .. } => Some((format!("phantom.inclusion[{index}].shape.file"), file.as_path())),
        InclusionBody::Sphere { .. } | InclusionBody::Ellipsoid { .. } => None,
    });
    meshes.collect()
}
