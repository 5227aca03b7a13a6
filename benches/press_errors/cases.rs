//! Presses that nobody chose.

use super::layers;
use anyhow::Result;
use tirtouch::camera::noise::PixelRandom;
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, InclusionShape, PhantomMesh, PhantomShape, Resolution, Star};
use tirtouch::mechanics::press::{Load, SensorBody, Setup, TIME_STEPS};

/// A press with what the study knows of it.
pub struct Case {
    pub setup: Setup,
    pub words: String,
    /// A flat punch on a layer: its radius over the layer's height, and Poisson's ratio.
    pub punch: Option<[f64; 2]>,
}

/// Draws of one case.
struct Draw(PixelRandom);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    /// One of the default's fineness times `fineness`, a sixth of them divided by 3 in place of 2, a sixth not at all.
    fn resolution(&mut self, fineness: f64) -> (Resolution, &'static str) {
        let subdivision = self.one_of([1.0, 2.0, 2.0, 2.0, 2.0, 3.0]);
        let base = Resolution::PLANE.finer(fineness * Resolution::PLANE.subdivision as f64 / subdivision);
        let divided = [", undivided", "", ", divided by 3"];
        (Resolution { subdivision: subdivision as usize, ..base }, divided[subdivision as usize - 1])
    }

    fn one_of<const N: usize>(&mut self, values: [f64; N]) -> f64 {
        values[((self.0.uniform() * N as f64) as usize).min(N - 1)]
    }
}

impl Case {
    /// Case `number`: every third is a flat punch, the others go round grips and sensors.
    pub fn new(seed: u32, number: u32) -> Result<Self> {
        let mut draw = Draw(PixelRandom::new(seed, number));
        if number % 3 == 2 { Ok(Self::punch(&mut draw)) } else { Self::phantom(&mut draw, number) }
    }

    /// A flat punch on a layer.
    fn punch(draw: &mut Draw) -> Self {
        let a_over_h = draw.between(0.2f64.ln(), 3f64.ln()).exp();
        let poisson = if draw.chance(0.4) { 0.5 } else { draw.between(0.3, 0.5) };
        let fineness = draw.one_of([0.5, 0.75, 1.0]);
        let (resolution, divided) = draw.resolution(fineness);
        let words = format!("flat punch, a/h {a_over_h:.2}, nu {poisson:.3}, fineness {fineness}{divided}");
        let setup = layers::rounded(&layers::one(a_over_h, poisson), resolution);
        Self { setup, words, punch: Some([a_over_h, poisson]) }
    }

    /// Case `number` in three dimensions: a disc, a square or a rectangle tied to a phantom. Half have a ball off the
    /// axis or a tilt, the others are a quarter of a phantom with a ball on the axis or none.
    pub fn solid(seed: u32, number: u32) -> Result<Self> {
        let draw = &mut Draw(PixelRandom::new(seed, number));
        let placed = draw.chance(0.5);
        let (offset, tilt) = (draw.between(1.0, 6.0), draw.between(0.3, 1.5));
        let tilted = placed && draw.chance(0.5);
        let base = Self::phantom(draw, 2 * number)?;
        let narrow = 9.0 + draw.between(0.0, 4.0);
        let size_mm = [44.0, 44.0];
        let mut setup = Setup { kinematics: Kinematics::ThreeDimensional, ..base.setup };
        let (PhantomShape::Cylinder { height_mm, .. } | PhantomShape::Block { height_mm, .. }) = setup.phantom.shape;
        let footprint = match number % 3 {
            0 => Footprint::Round { radius_mm: 12.0 },
            1 => Footprint::Rectangle { half_widths_mm: [12.0; 2] },
            _ => Footprint::Rectangle { half_widths_mm: [13.0, narrow] },
        };
        if let Footprint::Rectangle { .. } = footprint {
            setup.phantom.shape = PhantomShape::Block { size_mm, height_mm };
        }
        let (sensor, named) = match setup.sensor {
            SensorBody::Layers { layers, .. } => (SensorBody::Layers { layers, edge_radius_mm: 0.5 }, "soft, rim 0.5"),
            SensorBody::Rigid { .. } | SensorBody::Indenter(_) => {
                (SensorBody::Rigid { edge_radius_mm: 0.0 }, "rigid, sharp")
            }
        };
        setup.sensor = sensor;
        let fineness = draw.one_of([0.5, 0.65]);
        setup.phantom.footprint = footprint;
        setup.phantom.resolution = Resolution::SOLID.finer(fineness);
        setup.phantom.symmetry = [!placed, true];
        if placed && !tilted {
            setup.phantom.inclusions.iter_mut().for_each(|ball| ball.center_mm[0] += offset);
        }
        setup.tilt_deg = [0.0, if tilted { tilt } else { 0.0 }];
        let what = match footprint {
            Footprint::Round { .. } => "disc".into(),
            Footprint::Rectangle { half_widths_mm: [x, y] } => format!("{:.0} x {:.0} mm", 2.0 * x, 2.0 * y),
        };
        let place = match (tilted, placed) {
            (true, _) => format!("tilted {tilt:.1} deg"),
            (false, true) => format!("off the axis by {offset:.1} mm"),
            (false, false) => "centred".into(),
        };
        let words = format!("{what}, {place}, {named}, {:.2?}, fineness {fineness}", setup.load);
        Ok(Self { setup, words, punch: None })
    }

    /// A phantom on a sensor of 15 mm.
    fn phantom(draw: &mut Draw, number: u32) -> Result<Self> {
        let tied = number.is_multiple_of(2);
        let (soft, linear) = (draw.chance(0.5), draw.chance(0.5));
        let poisson = draw.one_of([0.3, 0.4, 0.45, 0.49, 0.4999, 0.5]);
        let material = |youngs: f64| {
            if linear { Material::linear(youngs, poisson) } else { Material::neo_hookean(youngs, poisson) }
        };
        let height_mm = draw.between(18.0, 30.0);
        let (diameter, top) = (draw.between(4.0, 10.0), draw.between(2.5, 7.0));
        let ball = InclusionShape {
            center_mm: [0.0, 0.0, top + diameter / 2.0],
            surface: Star::Ellipsoid { semi_axes_mm: [diameter / 2.0; 3] },
        };
        let (body_kpa, lump_kpa) = (draw.between(3.0, 10.0), draw.between(20.0, 150.0));
        let with_ball = draw.chance(0.5);
        let mut phantom_materials = vec![material(body_kpa)?];
        if with_ball {
            phantom_materials.push(material(lump_kpa)?);
        }
        let rim = if tied { draw.one_of([0.0, 0.0, 0.0, 0.5]) } else { draw.one_of([0.3, 0.5, 1.0]) };
        let layers = [(5.0, 15.0), (3.0, 30.0), (2.0, 60.0)].map(|(h, youngs)| Ok((h, material(youngs)?)));
        let layers = layers.into_iter().collect::<Result<Vec<_>>>()?;
        let rubbing = draw.one_of([0.0, 0.1, 0.3, 0.6]);
        let grip = match tied {
            true => Grip::Bonded,
            false if rubbing == 0.0 => Grip::Frictionless,
            false => Grip::Coulomb(rubbing),
        };
        let depth_mm = draw.between(0.25f64.ln(), 4f64.ln()).exp();
        let fineness = draw.one_of(if tied { [0.5, 0.5, 1.0, 1.5] } else { [0.5, 0.5, 0.5, 1.0] });
        let (resolution, divided) = draw.resolution(fineness);
        let setup = Setup {
            kinematics: Kinematics::Axisymmetric,
            pressure: PressureOrder::Linear,
            phantom: PhantomMesh {
                shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm },
                inclusions: with_ball.then_some(ball).into_iter().collect(),
                footprint: Footprint::Round { radius_mm: 15.0 },
                symmetry: [true, true],
                resolution,
                offset_mm: [0.0; 2],
                layers_mm: Vec::new(),
            },
            phantom_materials,
            sensor: match soft {
                true => SensorBody::Layers { layers, edge_radius_mm: rim },
                false => SensorBody::Rigid { edge_radius_mm: rim },
            },
            grip,
            load: Load::Depths(vec![depth_mm]),
            seconds_per_mm: None,
            hold_s: 0.0,
            time_steps: TIME_STEPS,
            tilt_deg: [0.0; 2],
        };
        let words = format!(
            "{} {}, rim {rim}, {}, nu {poisson}, {}{depth_mm:.2} mm, fineness {fineness}{divided}",
            match grip {
                Grip::Bonded => "tied".into(),
                Grip::Frictionless => "sliding".into(),
                Grip::Coulomb(friction) => format!("friction {friction}"),
            },
            if soft { "soft" } else { "rigid" },
            if linear { "linear" } else { "neo-Hookean" },
            if with_ball { format!("ball {diameter:.1} mm, ") } else { String::new() },
        );
        Ok(Self { setup, words, punch: None })
    }
}
