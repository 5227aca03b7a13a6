//! `sweep`: many points of one scene, none lost.

use super::command::{command_line, described, program};
use super::flags::Backend;
use super::job::watched;
use super::{Common, Failure, Outcome, Talk, note, print};
use crate::output::leftovers::leftovers;
use crate::output::{RESULT, Records};
use crate::pages::sweep::{text, write};
use crate::pipeline::Session;
use crate::scene::open;
use crate::sweep::slurm;
use crate::sweep::{NoScene, Options, Parts, Status, Sweep, by_hand, run};
use crate::trace::{Devices, Precision};
use clap::{Args, Subcommand, ValueEnum as _};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

/// Compute many points of a scene: keys that vary, figures of each, records that a later run goes on with.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct SweepCommand {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    by_hand: ByHand,
}

/// A sweep without a file: keys and what is measured.
#[derive(Debug, Args)]
struct ByHand {
    /// Scene file, or preset:NAME: a sweep without a file of its own.
    #[arg(required = true)]
    scene: Option<PathBuf>,
    /// A key and its values: KEY=VALUE, KEY=A,B,C or KEY=FROM:TO:POINTS; may be given again.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    set: Vec<String>,
    /// What is measured: a kind, or a kind with its keys as in 'contrast radius_mm=4'; may be given again.
    #[arg(long, value_name = "KIND", default_value = "mean_radiance")]
    measure: Vec<String>,
    #[command(flatten)]
    how: How,
}

#[derive(Debug, Subcommand)]
enum What {
    Run(RunSweep),
    /// How far the sweep of a folder is, from whatever records are there.
    Status(OfFolder),
    /// Write the tables and the report of whatever records a folder has.
    Collect(OfFolder),
    Scene(SceneOf),
}

/// Compute the points of a sweep that have no record yet, and write the tables.
#[derive(Debug, Args)]
struct RunSweep {
    /// Sweep file, or the folder of a sweep to go on with.
    sweep: PathBuf,
    #[command(flatten)]
    how: How,
}

/// How points are computed.
#[derive(Debug, Args)]
pub(super) struct How {
    /// Folder of the records [default: out/NAME].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on with the records of the folder, beside other workers if there are any.
    #[arg(long)]
    resume: bool,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Compute points that failed again.
    #[arg(long)]
    retry: bool,
    /// Only the part K of N of the points.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    /// What computes them: this machine, or a job array of Slurm.
    #[arg(long, value_enum, default_value_t)]
    engine: Engine,
    /// Tasks of the job array.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=10_000),
        allow_negative_numbers = true
    )]
    tasks: u32,
    /// Send the job array, too.
    #[arg(long)]
    submit: bool,
    /// Threads that press beside the one that traces [default: half of the cores].
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=256),
        allow_negative_numbers = true
    )]
    workers: Option<u32>,
    /// Where to trace.
    #[arg(long, value_enum, default_value_t)]
    backend: Backend,
    #[command(flatten)]
    pub(super) talk: Talk,
}

/// A folder with records.
#[derive(Debug, Args)]
struct OfFolder {
    /// Folder of a sweep.
    folder: PathBuf,
    #[command(flatten)]
    talk: Talk,
}

/// Print the scene of one point: a scene file of its own.
#[derive(Debug, Args)]
struct SceneOf {
    /// Folder of a sweep, or a sweep file.
    sweep: PathBuf,
    /// Row of the point, from 0.
    row: usize,
}

/// What computes the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum Engine {
    /// This machine.
    #[default]
    Local,
    /// A job array of Slurm.
    Slurm,
}

/// Part K of N.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shard(u32, u32);

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((k, n)) if (1..=n).contains(&k) => Ok(Self(k, n)),
            _ => Err("it must be K/N with K from 1 to N, as in 3/8"),
        }
    }
}

impl SweepCommand {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        match &self.what {
            Some(What::Run(run)) => run.run(),
            Some(What::Status(of)) => of.status(),
            Some(What::Collect(of)) => of.collect(),
            Some(What::Scene(of)) => of.print(),
            None => self.by_hand.how.run(&self.by_hand.sweep()?, None),
        }
    }
}

impl ByHand {
    fn sweep(&self) -> Result<Sweep, Failure> {
        let scene = self.scene.as_deref().unwrap_or(Path::new(""));
        let (base, file) = open(scene)?;
        let usage = |flag: &str, text: &str, why: &str| Failure::usage(format!("`{flag} {text}`: {why}"));
        let vary = self.set.iter().map(|text| by_hand::vary(text).map_err(|why| usage("--set", text, &why)));
        let measure =
            self.measure.iter().map(|text| by_hand::measure(text).map_err(|why| usage("--measure", text, &why)));
        let (vary, measure) = (vary.collect::<Result<_, _>>()?, measure.collect::<Result<_, _>>()?);
        let name = format!("{}-sweep", base.scene.name);
        by_hand::sweep(name, scene, vary, measure, base, file).map_err(|broken| Failure::usage(broken.to_string()))
    }
}

impl RunSweep {
    fn run(&self) -> Result<Outcome, Failure> {
        if !self.sweep.is_dir() {
            return self.how.run(&Sweep::load(&self.sweep)?, None);
        }
        if self.how.out.is_some() || self.how.force {
            let message =
                format!("{}: is the folder of a sweep; it takes neither --out nor --force", self.sweep.display());
            return Err(Failure::usage(message).in_file(&self.sweep));
        }
        self.how.run(&Sweep::of_folder(&self.sweep)?.0, Some(&self.sweep))
    }
}

impl How {
    /// Computes a sweep, in a folder that is there already or in one of its own.
    fn run(&self, sweep: &Sweep, there: Option<&Path>) -> Result<Outcome, Failure> {
        let start = Instant::now();
        let own = || self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&sweep.name));
        let place = there.map_or_else(own, Path::to_path_buf);
        let resume = self.resume || there.is_some();
        if self.engine == Engine::Slurm {
            return self.send(sweep, &place, resume);
        }
        let (records, before) = self.compute(sweep, &place, resume)?;
        let status = write(sweep, &records, &command_line())?;
        let result = described(status.run_json(sweep, start.elapsed().as_secs_f64(), before), Some(&place));
        records.write(RESULT, &format!("{result:#}\n"))?;
        self.talk.tell(&result, text(sweep, &status, &place.display().to_string()))
    }
}

impl How {
    /// Computes what a folder of a sweep lacks; gives its records, and how many points had ended before.
    fn compute(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<(Records, usize), Failure> {
        let devices = Devices::open(self.backend.choice(), Precision::F32)?;
        if let (Some(notice), false) = (devices.notice(), self.talk.quiet) {
            note(notice);
        }
        let records = self.records(sweep, place, resume)?;
        let before = Status::of(sweep, &records).ended();
        let workers = self.workers.map_or(Options::default().workers, |workers| workers as usize);
        let options = Options { workers, shard: self.shard.map(|Shard(k, n)| (k, n)), retry: self.retry };
        let session = Session::from(devices);
        watched(self.talk.quiet, |observe| run(sweep, &records, &session, options, observe))?;
        Ok((records, before))
    }

    /// Does with the sweeps of a larger work, in folders of `out`, what is asked for.
    pub(super) fn parts<T>(
        &self,
        out: &Path,
        work: impl FnOnce(&mut Parts<'_, Failure>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        work(&mut Parts::new(out, &mut |sweep, place| self.part(sweep, place)))
    }

    /// Computes a part of a larger work, here or by a job array.
    fn part(&self, sweep: &Sweep, place: &Path) -> Result<Status, Failure> {
        let records = match self.engine {
            Engine::Local => self.compute(sweep, place, place.is_dir())?.0,
            Engine::Slurm => {
                let (records, job, sent) = self.job(sweep, place, place.is_dir())?;
                note(&sent.unwrap_or_else(|| unsent(place, job.tasks)));
                records
            }
        };
        Ok(Status::of(sweep, &records))
    }

    /// The folder that was asked for, or another.
    pub(super) fn place_or(&self, other: impl FnOnce() -> PathBuf) -> PathBuf {
        self.out.clone().unwrap_or_else(other)
    }

    /// What of this a single job has.
    pub(super) fn as_common(&self) -> Common {
        Common {
            out: self.out.clone(),
            force: self.force,
            backend: self.backend,
            talk: self.talk.clone(),
            ..Common::default()
        }
    }

    fn records(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<Records, Failure> {
        let records = sweep.enter(place, self.force, resume)?;
        leftovers().keep(format!("what was done is in {}: go on with --resume", place.display()));
        Ok(records)
    }

    /// What each task of a job array is to be told of how points are computed.
    fn of_tasks(&self) -> Vec<String> {
        let backend = self.backend.to_possible_value().filter(|_| self.backend != Backend::default());
        let backend = backend.map(|value| format!("--backend {}", value.get_name()));
        let workers = self.workers.map(|workers| format!("--workers {workers}"));
        let retry = self.retry.then(|| "--retry".to_owned());
        [backend, workers, retry].into_iter().flatten().collect()
    }

    /// Makes the folder with a job for Slurm, and sends it where that is asked for: then also what Slurm says.
    fn job(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<(Records, slurm::Job, Option<String>), Failure> {
        let records = self.records(sweep, place, resume)?;
        let job = slurm::Job::write(sweep, &records, place, self.tasks, (&program()?, &self.of_tasks()))?;
        let sent = self.submit.then(|| job.submit().map(|said| format!("{}: {said}", place.display()))).transpose()?;
        Ok((records, job, sent))
    }

    /// The same, and tells of it.
    fn send(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<Outcome, Failure> {
        let (records, job, sent) = self.job(sweep, place, resume)?;
        let said = sent.unwrap_or_else(|| unsent(place, job.tasks));
        let mut result = Status::of(sweep, &records).json(sweep);
        (result["tasks"], result["sent"]) = (json!(job.tasks), json!(self.submit));
        let result = described(result, Some(place));
        self.talk.tell(result, said)
    }
}

fn unsent(place: &Path, tasks: u32) -> String {
    format!("{}: {tasks} tasks; `sbatch job.sh` in it sends them", place.display())
}

impl OfFolder {
    fn status(&self) -> Result<Outcome, Failure> {
        let (sweep, records) = Sweep::of_folder(&self.folder)?;
        self.tell(&sweep, &Status::of(&sweep, &records))
    }

    fn collect(&self) -> Result<Outcome, Failure> {
        let (sweep, records) = Sweep::of_folder(&self.folder)?;
        let status = write(&sweep, &records, &command_line())?;
        self.tell(&sweep, &status)
    }

    fn tell(&self, sweep: &Sweep, status: &Status) -> Result<Outcome, Failure> {
        self.talk.tell(
            described(status.json(sweep), Some(&self.folder)),
            text(sweep, status, &self.folder.display().to_string()),
        )
    }
}

impl SceneOf {
    fn print(&self) -> Result<Outcome, Failure> {
        let scene = Sweep::open(&self.sweep)?.scene_text(self.row).map_err(|error| {
            let words = format!("{}: {error}", self.sweep.display());
            let failure = match error {
                NoScene::Row { .. } => Failure::usage(words),
                NoScene::Rejected { .. } => Failure::input(words),
            };
            failure.in_file(&self.sweep)
        })?;
        print(&scene)?;
        Ok(Outcome::Done)
    }
}
