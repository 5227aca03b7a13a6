//! A sweep as one job array of Slurm. Records are all that its tasks share: one that was preempted, killed or lost with
//! its node is sent again and goes on.

use std::path::Path;

/// The job's script. Each of `tasks` tasks computes its part of the points of `folder`, whose order is there already.
pub fn job(name: &str, program: &Path, folder: &Path, tasks: u32) -> String {
    let plain: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || "-_.".contains(*c)).collect();
    let quoted = |path: &Path| format!("'{}'", path.display().to_string().replace('\'', "'\\''"));
    let (program, folder) = (quoted(program), quoted(folder));
    format!(
        "#!/bin/bash\n\
         #SBATCH --job-name=tirtouch-{plain}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=job-%a.log\n\
         # Sent again (sbatch job.sh, in this folder), it computes what is missing.\n\
         exec {program} sweep run {folder} --shard \"$SLURM_ARRAY_TASK_ID/{tasks}\" --quiet \"$@\"\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_quoted_and_names_are_plain() {
        let script = job("a b'; rm", Path::new("/opt/it's/tirtouch"), Path::new("/tmp/out put"), 8);
        assert!(script.contains("--job-name=tirtouch-abrm\n"), "{script}");
        assert!(script.contains("exec '/opt/it'\\''s/tirtouch' sweep run '/tmp/out put' --shard"), "{script}");
    }
}
