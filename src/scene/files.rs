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
        let indenter = self.press.as_ref().and_then(|press| press.indenter.as_ref());
        files.extend(indenter.and_then(|indenter| indenter_file("press.indenter.file", indenter)));
        files
    }
}

impl ScanScene {
    /// Key and path (as written) of every file that the scene names.
    pub fn files(&self) -> Vec<(String, &Path)> {
        let mut files = phantom_files(&self.phantom);
        files.extend(indenter_file("scan.indenter.file", &self.scan.indenter));
        files
    }
}

fn indenter_file<'a>(key: &str, indenter: &'a Indenter) -> Option<(String, &'a Path)> {
    match indenter {
        Indenter::Table { file } => Some((key.to_owned(), file.as_path())),
        Indenter::Round { .. } | Indenter::RoundedFlat { .. } => None,
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
