//! `sweep`: many points of one scene, none lost.

use super::command::{command_line, described, program};
use super::flags::{Backend, Place};
use super::job::watched;
use super::{Common, Failure, Outcome, Talk, note, write_exactly};
use crate::output::leftovers::leftovers;
use crate::output::{RESULT, Records};
use crate::pages::sweep::{text, write};
use crate::pipeline::Session;
use crate::scene::open;
use crate::sweep::slurm;
use crate::sweep::{Options, Parts, Shard, Status, Sweep, by_hand, run};
use crate::trace::BackendChoice;
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::{Path, PathBuf};
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
    #[command(flatten)]
    pub(super) place: Place,
    /// Go on with the records of the folder, beside other workers if there are any.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Compute points that failed again.
    #[arg(long)]
    retry: bool,
    /// Only the part K of N of the points.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    /// What computes them: this machine, or a job array of Slurm.
    #[arg(long, value_enum, default_value_t)]
    engine: Engine,
    /// Tasks of the job array [default: 16].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    tasks: Option<u32>,
    /// Send the job array, too.
    #[arg(long)]
    submit: bool,
    /// Threads that press beside the one that traces [default: half of the cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    workers: Option<u32>,
    #[command(flatten)]
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

impl SweepCommand {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        match &self.what {
            Some(What::Run(run)) => run.run(),
            Some(What::Status(of)) => of.tell(false),
            Some(What::Collect(of)) => of.tell(true),
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
        if self.how.place.out.is_some() || self.how.place.force {
            let why = "the folder of a sweep takes neither --out nor --force";
            return Err(Failure::usage(format!("{}: {why}", self.sweep.display())).in_file(&self.sweep));
        }
        self.how.run(&Sweep::of_folder(&self.sweep)?.0, Some(&self.sweep))
    }
}

impl How {
    /// Computes a sweep, in a folder that is there already or in one of its own.
    fn run(&self, sweep: &Sweep, there: Option<&Path>) -> Result<Outcome, Failure> {
        let start = Instant::now();
        let place = there.map_or_else(|| self.place.named(&sweep.name), Path::to_path_buf);
        let resume = self.resume || there.is_some();
        if self.engine == Engine::Slurm {
            let (records, tasks, said) = self.job(sweep, &place, resume)?;
            let mut result = Status::of(sweep, &records).run_json(sweep, start.elapsed().as_secs_f64(), 0);
            (result["tasks"], result["sent"]) = (json!(tasks), json!(self.submit));
            return self.talk.tell(described(result, Some(&place)), said);
        }
        let (records, computed) = self.compute(sweep, &place, resume)?;
        let status = write(sweep, &records, &command_line())?;
        let result = described(status.run_json(sweep, start.elapsed().as_secs_f64(), computed), Some(&place));
        records.write(RESULT, &format!("{result:#}\n"))?;
        status.nothing(sweep, &records).map_err(|why| Failure::input(format!("{}: {why}", place.display())))?;
        self.talk.tell(&result, text(sweep, &status, &place.display().to_string()))
    }

    /// Flags that are of one engine alone.
    fn check(&self) -> Result<(), Failure> {
        let wrong = match self.engine {
            Engine::Slurm if self.shard.is_some() => "each task of a job array has its own `--shard`",
            Engine::Local if self.submit || self.tasks.is_some() => "`--submit` and `--tasks` want `--engine slurm`",
            _ => return Ok(()),
        };
        Err(Failure::usage(wrong))
    }

    /// Computes what a folder of a sweep lacks; gives its records, and how many points this run computed.
    fn compute(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<(Records, usize), Failure> {
        let devices = self.backend.open(self.talk.quiet)?;
        let records = self.records(sweep, place, resume)?;
        let workers = self.workers.map_or(Options::default().workers, |workers| workers as usize);
        let options = Options { workers, shard: self.shard, retry: self.retry };
        let session = Session::from(devices);
        let computed = watched(self.talk.quiet, |observe| run(sweep, &records, &session, options, observe))?;
        Ok((records, computed))
    }

    /// The folder of a larger work, which is always gone on with.
    pub(super) fn folder_of_parts(&self, name: &str) -> Result<PathBuf, Failure> {
        let out = self.place.named(name);
        if self.place.force && out.is_dir() {
            let why = "what is there is always gone on with, and --force replaces nothing; remove it to begin anew";
            return Err(Failure::usage(format!("{}: {why}", out.display())).in_file(&out));
        }
        Ok(out)
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
        sweep.check_radiance().map_err(|broken| Failure::input(broken.to_string()).at_key(broken.key))?;
        let records = match self.engine {
            Engine::Local => self.compute(sweep, place, place.is_dir())?.0,
            Engine::Slurm => {
                let (records, _, said) = self.job(sweep, place, place.is_dir())?;
                note(&said);
                records
            }
        };
        Ok(Status::of(sweep, &records))
    }

    /// What of this a single job has.
    pub(super) fn as_common(&self) -> Common {
        let Self { place, backend, talk, .. } = self;
        Common { place: place.clone(), backend: *backend, talk: talk.clone(), ..Common::default() }
    }

    fn records(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<Records, Failure> {
        self.check()?;
        let records = sweep.enter(place, self.place.force, resume)?;
        leftovers().keep(format!("what was done is in {}: go on with --resume", place.display()));
        Ok(records)
    }

    /// What each task of a job array is to be told of how points are computed.
    fn of_tasks(&self) -> Vec<String> {
        let backend = self.backend.backend;
        let backend = (backend != BackendChoice::Auto).then(|| format!("--backend {}", backend.name()));
        let workers = self.workers.map(|workers| format!("--workers {workers}"));
        let retry = self.retry.then(|| "--retry".to_owned());
        [backend, workers, retry].into_iter().flatten().collect()
    }

    /// Makes the folder with a job for Slurm, and sends it where that is asked for; with what is said of it.
    fn job(&self, sweep: &Sweep, place: &Path, resume: bool) -> Result<(Records, u32, String), Failure> {
        let records = self.records(sweep, place, resume)?;
        let tasks = self.tasks.unwrap_or(16);
        let job = slurm::Job::write(sweep, &records, place, tasks, (&program()?, &self.of_tasks()))?;
        let by_hand = || format!("{} tasks; `sbatch job.sh` in it sends them", job.tasks);
        let said = if self.submit { job.submit()? } else { by_hand() };
        Ok((records, job.tasks, format!("{}: {said}", place.display())))
    }
}

impl OfFolder {
    /// Says how far it is, after the tables and the report are written where they are asked for.
    fn tell(&self, writes: bool) -> Result<Outcome, Failure> {
        let (sweep, records) = Sweep::of_folder(&self.folder)?;
        let whole = || Ok(Status::of(&sweep, &records));
        let status = if writes { write(&sweep, &records, &command_line()) } else { whole() }?;
        let words = text(&sweep, &status, &self.folder.display().to_string());
        self.talk.tell(described(status.json(&sweep), Some(&self.folder)), words)
    }
}

impl SceneOf {
    fn print(&self) -> Result<Outcome, Failure> {
        let scene = Sweep::open(&self.sweep)?.scene_text(self.row);
        write_exactly(&scene.map_err(|error| Failure::of_point(&error, &self.sweep))?)?;
        Ok(Outcome::Done)
    }
}
