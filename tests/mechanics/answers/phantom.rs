//! The shipped phantom, neo-Hookean, pressed by 1, 2 and 4 mm on the soft sensor. Its answer is a finer mesh.

use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::press::error_estimate::difference;
use tirtouch::mechanics::press::{Face, Pressed, Setup};
use tirtouch::scene::preset;

/// The default resolution divides by 2. Inclusion: 8 mm, 120 kPa, 5 mm deep to its top.
pub fn setup(inclusion: bool, subdivision: usize) -> Setup {
    let mut setup = press_setup(&preset("phantom-size-8mm").unwrap()).unwrap();
    if !inclusion {
        setup.phantom.inclusions.clear();
        setup.phantom_materials.truncate(1);
    }
    setup.phantom.resolution.subdivision = subdivision;
    setup
}

/// Errors of the last step against a finer mesh: of the pressure, rms over 0.8 of the footprint, and of the force.
pub fn errors(pressed: &Pressed, finer: &Pressed) -> Option<[f64; 2]> {
    let (step, truth) = pressed.steps.iter().zip(&finer.steps).next_back()?;
    let rms = difference(&Face::of(pressed, step), &Face::of(finer, truth));
    Some([rms, step.force_n / truth.force_n - 1.0])
}
