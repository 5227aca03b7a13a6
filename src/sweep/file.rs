//! The file of a sweep: a scene, what varies, constraints, the design of points and what is measured.

use super::{Images, Measure};
use crate::output::{Item, OutputError, Records, Remedy};
use crate::scene::{
    DataFileError, Input, Invalid, LoadedScene, SceneError, at_its_place, load, parse, parse_file, preset, read_text,
};
use crate::vary::{Design, Plan, Point, Require, Vary};
use crate::version::{SOURCES, VERSION};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// A whole sweep file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// The scene, the design and how points are traced.
    pub sweep: Settings,
    /// What varies.
    #[serde(default)]
    pub vary: Vec<Vary>,
    /// What must hold of a point.
    #[serde(default)]
    pub require: Vec<Require>,
    /// What is measured.
    #[serde(default)]
    pub measure: Vec<Measure>,
}

/// The scene, the design and how points are traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What the sweep asks.
    #[serde(default)]
    pub description: String,
    /// The scene file, relative to this file, or `preset:NAME`.
    pub scene: String,
    /// Which points are computed.
    pub design: Design,
    /// Relative error of a lit pixel that each image is traced to. Default: as many samples as the scene says.
    pub target_error: Option<f64>,
    /// Seed of all random numbers. Default: the scene's.
    pub seed: Option<u32>,
    /// Whether points share their random numbers, so that their images differ by what varies and little noise. Default:
    /// `common`.
    #[serde(default)]
    pub random_numbers: RandomNumbers,
    /// Images that are kept, as a data set. Absent: none.
    pub images: Option<Images>,
}

/// Whether points share their random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RandomNumbers {
    /// All points draw the same; of `morris` and `saltelli` designs those of a trajectory or of a base point.
    #[default]
    Common,
    /// Each point draws its own.
    Own,
}

/// A sweep that has been read: its points are known, none is computed.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Name of the sweep; names the default output folder.
    pub name: String,
    /// The file.
    pub file: SweepFile,
    /// The file's text.
    pub text: String,
    /// The base scene.
    pub base: LoadedScene,
    /// Where the base scene lies, for messages and for the files that it names.
    pub base_file: PathBuf,
    /// The points.
    pub plan: Plan,
    /// The design's table, if it has one.
    table: Option<String>,
    /// Files that the scenes of its points name, and the base's.
    named: BTreeSet<PathBuf>,
}

/// Why a point is not computed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rejected {
    /// Its scene breaks a rule.
    Point(String),
    /// No point of the sweep makes a scene: a key that there is not, a value of the wrong kind.
    Sweep(Invalid),
}

/// The item that keeps a sweep's [`Place`].
const PLACE: &str = "place";

/// What is kept of a sweep beside its order.
#[derive(Debug, Serialize, Deserialize)]
struct Place {
    name: String,
    scene_file: PathBuf,
}

impl Place {
    /// What a folder says where none is kept.
    fn of(folder: &Path) -> Self {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { name, scene_file: folder.join("scene.toml") }
    }
}

/// Points that are looked at for one that makes a scene.
const MOST_LOOKED: usize = 1000;

/// Mistakes that all points of a sweep share.
const OF_ALL_POINTS: [&str; 4] = ["syntax", "unknown_key", "missing_key", "wrong_type"];

pub(super) fn rules(file: &SweepFile) -> Result<(), Invalid> {
    if let Some(images) = file.sweep.images.filter(|images| !(0.0..=1.0).contains(&images.test_share)) {
        let what = format!("must be from 0 to 1, is {}", images.test_share);
        return Err(Invalid::new("sweep.images.test_share", what));
    }
    if file.measure.is_empty() && file.sweep.images.is_none() {
        return Err(Invalid::new(
            "measure",
            "is missing: say what is measured; for example [[measure]] kind = \"mean_radiance\"",
        ));
    }
    if let Some(target) = file.sweep.target_error.filter(|target| !(*target > 0.0 && *target < 10.0)) {
        return Err(Invalid::new("sweep.target_error", format!("must be above 0 and below 10, is {target}")));
    }
    for (k, measure) in file.measure.iter().enumerate() {
        let at = |key: &str| format!("measure[{k}].{key}");
        match measure {
            Measure::Contrast { radius_mm, around_mm: [inner, outer], .. } => {
                if *radius_mm <= 0.0 {
                    return Err(Invalid::new(at("radius_mm"), format!("must be above 0, is {radius_mm}")));
                }
                if !(inner >= radius_mm && outer > inner) {
                    let what =
                        format!("must be [inner, outer] with {radius_mm} <= inner < outer, is [{inner}, {outer}]");
                    return Err(Invalid::new(at("around_mm"), what));
                }
            }
            Measure::Snr { radius_mm, .. } | Measure::Unevenness { radius_mm, .. } if *radius_mm <= 0.0 => {
                return Err(Invalid::new(at("radius_mm"), format!("must be above 0, is {radius_mm}")));
            }
            Measure::Paper { threshold_grey, .. } if *threshold_grey < 0.0 => {
                return Err(Invalid::new(at("threshold_grey"), format!("must be 0 or more, is {threshold_grey}")));
            }
            _ => {}
        }
        if file.measure[..k].iter().any(|other| other.columns() == measure.columns()) {
            let what = format!("measures {} a second time", measure.columns().join(", "));
            return Err(Invalid::new(format!("measure[{k}]"), what));
        }
    }
    Ok(())
}

impl Sweep {
    /// Whether images are traced.
    pub fn needs_light(&self) -> bool {
        self.file.sweep.images.is_some() || self.file.measure.iter().any(Measure::needs_light)
    }

    /// Whether images without inclusions are traced.
    pub fn needs_baseline(&self) -> bool {
        let kept = self.file.sweep.images.is_some_and(|images| images.baseline);
        kept || self.file.measure.iter().any(Measure::needs_baseline)
    }

    /// Reads a sweep file, its scene and its table.
    ///
    /// # Errors
    /// A file that cannot be read or is none, a rule that is broken, a key that leads nowhere in the scene.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::parse(&read_text(path)?, path)
    }

    /// The same of the text of a sweep file.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let file = parse_file::<SweepFile>(text, path, &schema(), rules)?.scene;
        let (base, base_file) = match file.sweep.scene.strip_prefix("preset:") {
            Some(name) => (preset(name)?, PathBuf::from(format!("{name}.toml"))),
            None => {
                let scene = beside(path, Path::new(&file.sweep.scene));
                if !scene.is_file() {
                    let what = format!("names {}, which is not a file", scene.display());
                    return Err(at_its_place(text, path, &Invalid::new("sweep.scene", what)));
                }
                (load(&scene)?, scene)
            }
        };
        Self::of(file, text, path, base, base_file)
    }

    /// The same of a scene that is there already, in place of the one that the text names.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn of_scene(text: &str, path: &Path, base: LoadedScene, base_file: PathBuf) -> Result<Self, SceneError> {
        Self::of(parse_file::<SweepFile>(text, path, &schema(), rules)?.scene, text, path, base, base_file)
    }

    fn of(file: SweepFile, text: &str, path: &Path, base: LoadedScene, base_file: PathBuf) -> Result<Self, SceneError> {
        let placed = |broken: Invalid| at_its_place(text, path, &broken);
        let table = match &file.sweep.design {
            Design::Csv { file } => {
                let input = Input::read(beside(path, file));
                let text = input.map_err(|error: DataFileError| error.to_string()).and_then(|input| {
                    String::from_utf8(input.bytes.to_vec()).map_err(|_| format!("{} is no UTF-8", file.display()))
                });
                Some(text.map_err(|why| placed(Invalid::new("sweep.design.file", why)))?)
            }
            _ => None,
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Self::new(stem, file, text.to_owned(), base, base_file, table).map_err(placed)
    }

    /// A sweep from its parts.
    ///
    /// # Errors
    /// A rule that is broken, with its key in the sweep's file.
    pub fn new(
        name: String,
        file: SweepFile,
        text: String,
        base: LoadedScene,
        base_file: PathBuf,
        table: Option<String>,
    ) -> Result<Self, Invalid> {
        rules(&file)?;
        let plan = Plan::new(&file.vary, &file.require, &file.sweep.design, table.as_deref())?;
        plan.check_places(&base.text)?;
        let named = base.scene.files().into_iter().map(|(_, file)| file.to_path_buf()).collect();
        let mut sweep = Self { name, file, text, base, base_file, plan, table, named };
        sweep.check_overridden()?;
        let taken = sweep.own_columns();
        if let Some((k, name)) = sweep.plan.names().enumerate().find(|(_, name)| taken.iter().any(|own| own == name)) {
            let what = format!("{name} is a column of the tables already");
            let of_vary = (k < sweep.file.vary.len()).then(|| format!("vary[{k}].name"));
            return Err(Invalid::new(of_vary.unwrap_or("sweep.design.file".into()), what));
        }
        if let Some(k) = sweep.file.measure.iter().position(Measure::needs_press)
            && sweep.base.scene.press.is_none()
        {
            return Err(Invalid::new(format!("measure[{k}].kind"), "needs a scene with a [press]"));
        }
        if sweep.file.sweep.images.is_some_and(|images| images.baseline || images.masks || images.pressures)
            && sweep.base.scene.press.is_none()
        {
            return Err(Invalid::new(
                "sweep.images",
                "has a baseline, masks or pressures, which need a scene with a [press]",
            ));
        }
        if let Some(k) = sweep.file.measure.iter().position(Measure::needs_baseline)
            && sweep.base.scene.press.is_none()
        {
            return Err(Invalid::new(format!("measure[{k}].kind"), "needs a scene with a [press] of inclusions"));
        }
        sweep.look_at_points()?;
        Ok(sweep)
    }

    /// Refuses a key that varies and changes nothing, since the sweep says it for all points.
    fn check_overridden(&self) -> Result<(), Invalid> {
        let asked = &self.file.sweep;
        let error = asked.target_error.is_some();
        let said = [
            ("render.seed", "sweep.seed", asked.seed.is_some()),
            ("render.target_error", "sweep.target_error", error),
            ("render.spp", "sweep.target_error", error),
            ("render.photons", "sweep.target_error", error),
        ];
        for (k, keys) in self.plan.keys().enumerate() {
            let varies = |key: &str| keys.iter().any(|one| one.to_string() == key);
            if let Some((key, by, _)) = said.iter().find(|(key, _, is_said)| *is_said && varies(key)) {
                return Err(Invalid::new(format!("vary[{k}].key"), format!("{key} changes nothing beside {by}")));
            }
        }
        Ok(())
    }

    /// Looks at one point of each set of values that are no numbers: reads the files that it names, and refuses what
    /// all points share.
    fn look_at_points(&mut self) -> Result<(), Invalid> {
        // How often each set of words was looked at without a scene.
        let (mut looked, mut broken, mut makes_scenes) = (HashMap::<Vec<String>, usize>::new(), None, false);
        for row in 0..self.plan.count() {
            let words = self.plan.words(row);
            if looked.get(&words).is_some_and(|times| *times >= MOST_LOOKED) {
                continue;
            }
            let Ok(point) = self.plan.point(row) else { continue };
            let found = self.scene(&point);
            makes_scenes |= !matches!(found, Err(Rejected::Sweep(_)));
            match found {
                Ok(loaded) => {
                    for (_, file) in loaded.scene.files() {
                        self.base.files.keep(file);
                        self.named.insert(file.to_path_buf());
                    }
                    looked.insert(words, MOST_LOOKED);
                }
                Err(Rejected::Sweep(why)) => {
                    let of_table = || Invalid::new("sweep.design.file", format!("row {row} {}", why.message));
                    broken = broken.or_else(|| Some(if self.table.is_some() { of_table() } else { why.clone() }));
                    *looked.entry(words).or_default() += 1;
                }
                // Other numbers may do.
                Err(Rejected::Point(_)) => {}
            }
            let seen: usize = looked.values().sum();
            match makes_scenes {
                true if !self.plan.has_words() => break,
                false if seen >= MOST_LOOKED => break,
                _ => {}
            }
        }
        match broken {
            Some(broken) if !makes_scenes => Err(broken),
            _ => Ok(()),
        }
    }

    /// The scene of a point.
    ///
    /// # Errors
    /// Why the point makes no valid scene.
    pub fn scene(&self, point: &Point) -> Result<LoadedScene, Rejected> {
        let text = self.plan.scene_text(&self.base.text, point).map_err(Rejected::Sweep)?;
        let mut loaded = parse(&text, &self.base_file).map_err(|error| {
            let key = error.key.clone().unwrap_or_default();
            match OF_ALL_POINTS.contains(&error.kind) {
                true => Rejected::Sweep(Invalid::new("vary", format!("makes no scene: {key}: {}", error.message))),
                false => Rejected::Point(format!("{key}: {}", error.message)),
            }
        })?;
        loaded.files = self.base.files.clone();
        Ok(loaded)
    }

    /// Reads a sweep file, or the sweep whose records a folder holds.
    ///
    /// # Errors
    /// As [`Self::load`] and [`Self::of_folder`].
    pub fn open(path: &Path) -> Result<Self, SweepFolderError> {
        match path.is_dir() {
            true => Ok(Self::of_folder(path)?.0),
            false => Ok(Self::load(path)?),
        }
    }

    /// The text of a point's scene file.
    ///
    /// # Errors
    /// A row that there is not; why the point makes no scene.
    pub fn scene_text(&self, row: usize) -> Result<String, NoScene> {
        if row >= self.plan.count() {
            return Err(NoScene::Row { row, points: self.plan.count() });
        }
        let rejected = |why: String| NoScene::Rejected { row, why };
        let point = self.plan.point(row).map_err(rejected)?;
        self.plan.scene_text(&self.base.text, &point).map_err(|broken| rejected(broken.to_string()))
    }

    /// Enters a folder as one worker of several, with a copy of the sweep and of its scene there. One that is not there
    /// yet is made; one that is there is gone on with where `resume` asks for it, or replaced by `force`.
    ///
    /// # Errors
    /// A file that its scenes name and that cannot be read; as [`Records::join`]; a file that cannot be written.
    pub fn enter(&self, folder: &Path, force: bool, resume: bool) -> Result<Records, OutputError> {
        if let Some(file) = self.named.iter().find(|file| self.base.files.open(file).is_err()) {
            let place = self.base.files.resolve(file);
            return Err(OutputError::refused(&place, "its scenes name it, and it cannot be read", Remedy::Mend));
        }
        let records = Records::join(folder, &self.order(), force, resume)?;
        records.keep_item(PLACE, &self.place())?;
        records.write("sweep.toml", &self.text)?;
        records.write("scene.toml", &self.base.text)?;
        Ok(records)
    }

    /// All that its records depend on.
    pub fn order(&self) -> Value {
        json!({
            "version": VERSION,
            "sources": SOURCES,
            "sweep": self.text,
            "scene": self.base.text,
            "inputs": self.base.files.hashes(self.named.iter().map(PathBuf::as_path)),
            "table": self.table,
        })
    }

    /// What may change from run to run: its name, and where its scene lies.
    fn place(&self) -> Place {
        // A preset has no place.
        let scene_file = match self.file.sweep.scene.starts_with("preset:") {
            true => self.base_file.clone(),
            false => std::path::absolute(&self.base_file).unwrap_or_else(|_| self.base_file.clone()),
        };
        Place { name: self.name.clone(), scene_file }
    }

    /// The sweep whose records a folder holds, and they. The files that its scene names are not there.
    ///
    /// # Errors
    /// A folder without records, or whose order is of no sweep.
    pub fn of_folder(folder: &Path) -> Result<(Self, Records), SweepFolderError> {
        let (records, order) = Records::read(folder)?;
        let strange = || SweepFolderError::Strange(folder.to_path_buf());
        let text = |key: &str| order.get(key).and_then(Value::as_str).map(str::to_owned);
        let (Some(sweep), Some(scene)) = (text("sweep"), text("scene")) else {
            return Err(strange());
        };
        let Place { name, scene_file: base_file } = match records.item(PLACE) {
            Item::There(place) => place,
            Item::Missing | Item::Damaged => Place::of(folder),
        };
        let file = parse_file::<SweepFile>(&sweep, &folder.join("sweep.toml"), &schema(), rules)?.scene;
        let base = parse(&scene, &base_file)?;
        let sweep = Self::new(name, file, sweep, base, base_file, text("table"));
        Ok((sweep.map_err(|_| strange())?, records))
    }
}

/// Why there is no scene of a point.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoScene {
    /// There is no such row.
    #[error("has {points} points, from 0; there is no row {row}")]
    Row {
        /// The row that was asked for.
        row: usize,
        /// Points of the sweep.
        points: usize,
    },
    /// The point makes no scene.
    #[error("point {row} makes no scene: {why}")]
    Rejected {
        /// Its row.
        row: usize,
        /// Why.
        why: String,
    },
}

/// Why a folder is not one of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepFolderError {
    /// It holds no records.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Its files are of another version.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its order is not one of a sweep.
    #[error("{}: holds records of something else than a sweep", .0.display())]
    Strange(PathBuf),
}

/// A file that a sweep file names.
fn beside(path: &Path, file: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(file)
}

/// The JSON schema (2020-12) of a sweep file.
pub fn schema() -> Value {
    schemars::schema_for!(SweepFile).to_value()
}
