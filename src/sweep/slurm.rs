//! A sweep as one job array of Slurm. Records are all that its tasks share: one that was preempted, killed or lost with
//! its node is sent again and goes on.

use super::Sweep;
use crate::output::{OutputError, Records};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Why a job could not be made or sent.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// Its script could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The system does not say where something is, or has no Slurm.
    #[error("{what}: {error}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What the system says.
        error: std::io::Error,
    },
    /// Slurm does not take it.
    #[error("sbatch: {0}")]
    Refused(String),
}

/// A job array in the folder of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// How many tasks it has.
    pub tasks: u32,
    folder: PathBuf,
}

impl Job {
    /// Writes `job.sh` of at most so many tasks, each of which runs `program`, the command `tirtouch`, with these
    /// flags.
    ///
    /// # Errors
    /// A script that cannot be written; a folder whose place the system does not say.
    pub fn write(
        sweep: &Sweep,
        records: &Records,
        place: &Path,
        tasks: u32,
        (program, flags): (&Path, &[String]),
    ) -> Result<Self, JobError> {
        let folder = std::path::absolute(place);
        let folder = folder.map_err(|error| JobError::System { what: "the folder's place", error })?;
        let tasks = tasks.min(u32::try_from(sweep.plan.count()).unwrap_or(u32::MAX));
        records.write("job.sh", &job(&sweep.name, program, &folder, tasks, flags))?;
        Ok(Self { tasks, folder })
    }

    /// Sends it: what `sbatch` says.
    ///
    /// # Errors
    /// No `sbatch`, or one that refuses.
    pub fn submit(&self) -> Result<String, JobError> {
        let sent = Command::new("sbatch").arg("job.sh").current_dir(&self.folder).output();
        let sent = sent.map_err(|error| JobError::System { what: "sbatch", error })?;
        let words = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        if sent.status.success() { Ok(words(&sent.stdout)) } else { Err(JobError::Refused(words(&sent.stderr))) }
    }
}

/// The job's script. Each of `tasks` tasks computes its part of the points of `folder`, whose order is there already.
fn job(name: &str, program: &Path, folder: &Path, tasks: u32, flags: &[String]) -> String {
    let plain: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || "-_.".contains(*c)).collect();
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', "'\\''"));
    let (program, folder) = (quoted(program), quoted(folder));
    let flags: String = flags.iter().map(|flag| format!(" {flag}")).collect();
    format!(
        "#!/bin/bash\n\
         #SBATCH --job-name=tirtouch-{plain}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=job-%a.log\n\
         # Sent again (sbatch job.sh, in this folder), it computes what is missing.\n\
         exec {program} sweep run {folder} --shard \"$SLURM_ARRAY_TASK_ID/{tasks}\" --quiet{flags} \"$@\"\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_quoted_and_names_are_plain() {
        let script =
            job("a b'; rm", Path::new("/opt/it's/tirtouch"), Path::new("/tmp/out put"), 8, &["--retry".into()]);
        assert!(script.contains("--job-name=tirtouch-abrm\n"), "{script}");
        assert!(script.contains("exec '/opt/it'\\''s/tirtouch' sweep run '/tmp/out put' --shard"), "{script}");
        assert!(script.contains(" --quiet --retry \"$@\"\n"), "{script}");
    }
}
