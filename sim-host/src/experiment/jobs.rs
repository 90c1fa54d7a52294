//! Many independent jobs: on several threads, with progress and time left, kept on disk as they finish, so that an
//! interrupted experiment goes on where it was.
//!
//! Results come in order of their index whatever the number of threads. Beside the file of the results, `FILE.partial`
//! holds the settings and each finished job, a JSON line each; it goes when the results are written.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// How to work.
#[derive(Clone, Debug)]
pub struct Work<'a> {
    /// What one job is called in the progress line: "starts".
    pub unit: &'static str,
    /// Threads; 0 = one per processor.
    pub threads: usize,
    /// No progress line.
    pub quiet: bool,
    /// Everything that the results depend on: results of other settings are not taken up.
    pub settings: &'a Value,
    /// File that the results will be written to; without one, nothing is kept on the way.
    pub results: Option<&'a Path>,
}

#[derive(Serialize, Deserialize)]
struct Finished<T> {
    index: usize,
    result: T,
}

/// Carries out jobs `0..count`; their results in that order.
///
/// # Errors
/// The first error of a job; the partial file cannot be read or written, or holds other settings. Finished jobs stay in
/// the partial file.
pub fn run<T: Serialize + DeserializeOwned + Send>(
    work: &Work<'_>,
    count: usize,
    job: impl Fn(usize) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let (mut done, journal) = match work.results {
        Some(results) => {
            // A bad path must not cost an hour: it is tried before the work.
            OpenOptions::new()
                .append(true)
                .create(true)
                .open(results)
                .with_context(|| format!("--csv {}", results.display()))?;
            let (done, journal) = resume::<T>(&partial_path(results), work.settings, count)?;
            (done, Some(Mutex::new(journal)))
        }
        None => (BTreeMap::new(), None),
    };
    let bar = if work.quiet { ProgressBar::hidden() } else { ProgressBar::new(count as u64) };
    bar.set_style(ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {}, {{eta}} left", work.unit))?);
    bar.set_position(done.len() as u64);
    let left: Vec<usize> = (0..count).filter(|index| !done.contains_key(index)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(work.threads).build()?;
    let fresh: Vec<(usize, T)> = pool.install(|| {
        left.into_par_iter()
            .with_max_len(1)
            .map(|index| {
                let result = job(index)?;
                let result = match &journal {
                    Some(journal) => keep(journal, index, result)?,
                    None => result,
                };
                bar.inc(1);
                Ok((index, result))
            })
            .collect::<anyhow::Result<_>>()
    })?;
    bar.finish_and_clear();
    done.extend(fresh);
    Ok(done.into_values().collect())
}

/// Forgets the journal: the results are written.
///
/// # Errors
/// The file cannot be removed.
pub fn forget(results: &Path) -> anyhow::Result<()> {
    let partial = partial_path(results);
    std::fs::remove_file(&partial).with_context(|| partial.display().to_string())
}

/// The journal of an experiment whose results go to `results`.
pub fn partial_path(results: &Path) -> PathBuf {
    let mut name = results.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

/// What a journal holds already, and the journal to go on with.
fn resume<T: DeserializeOwned>(
    path: &Path,
    settings: &Value,
    count: usize,
) -> anyhow::Result<(BTreeMap<usize, T>, File)> {
    let named = || path.display().to_string();
    let text = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
        read => read.with_context(named)?,
    };
    // What follows the last line's end was being written when the experiment was interrupted.
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let mut lines = whole.lines().enumerate();
    let mut done = BTreeMap::new();
    if let Some((_, first)) = lines.next() {
        let expected = settings.to_string();
        anyhow::ensure!(
            first == expected,
            "{}: begun with other settings ({first}); expected {expected}, or no such file",
            named()
        );
    }
    for (number, line) in lines {
        let entry: Finished<T> =
            serde_json::from_str(line).with_context(|| format!("{}: line {}", named(), number + 1))?;
        anyhow::ensure!(entry.index < count, "{}: line {}: job {} of {count}", named(), number + 1, entry.index);
        done.insert(entry.index, entry.result);
    }
    let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(path).with_context(named)?;
    file.set_len(whole.len() as u64)?;
    std::io::Seek::seek(&mut file, std::io::SeekFrom::End(0))?;
    if whole.is_empty() {
        writeln!(file, "{settings}")?;
    }
    Ok((done, file))
}

fn keep<T: Serialize>(journal: &Mutex<File>, index: usize, result: T) -> anyhow::Result<T> {
    let entry = Finished { index, result };
    let line = serde_json::to_string(&entry)? + "\n";
    // A thread that panicked while it wrote has left half a line at worst, and the next start drops that.
    let mut file = journal.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    file.write_all(line.as_bytes())?;
    Ok(entry.result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("tactus-jobs-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn work<'a>(settings: &'a Value, results: Option<&'a Path>, threads: usize) -> Work<'a> {
        Work { unit: "jobs", threads, quiet: true, settings, results }
    }

    #[test]
    fn results_come_in_order_whatever_the_number_of_threads() {
        let settings = Value::Null;
        let squares = |threads| run(&work(&settings, None, threads), 50, |i| Ok(i * i)).unwrap();
        assert_eq!(squares(1), squares(4));
        assert_eq!(squares(3)[7], 49);
    }

    #[test]
    fn an_interrupted_experiment_goes_on_where_it_was() {
        let folder = folder("resume");
        let (file, settings) = (folder.join("r.csv"), serde_json::json!({ "seed": 1, "x": [0.12_f32, 1.0_f32 / 3.0] }));
        let carried_out = AtomicUsize::new(0);
        let job = |until: usize| {
            let carried_out = &carried_out;
            move |i: usize| {
                anyhow::ensure!(i < until, "power cut");
                carried_out.fetch_add(1, Ordering::Relaxed);
                Ok(i as f32 / 7.0)
            }
        };
        assert!(run(&work(&settings, Some(&file), 1), 10, job(6)).is_err());
        // The power went in the middle of a line.
        let mut journal = OpenOptions::new().append(true).open(partial_path(&file)).unwrap();
        write!(journal, "{{\"index\":9,\"res").unwrap();
        let all = run(&work(&settings, Some(&file), 1), 10, job(10)).unwrap();
        assert_eq!(carried_out.load(Ordering::Relaxed), 10, "no job twice");
        assert_eq!(all, (0..10).map(|i| i as f32 / 7.0).collect::<Vec<_>>());
        forget(&file).unwrap();
        assert!(!partial_path(&file).exists());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn results_of_other_settings_are_not_taken_up() {
        let folder = folder("settings");
        let file = folder.join("r.csv");
        let (one, two) = (serde_json::json!({ "seed": 1 }), serde_json::json!({ "seed": 2 }));
        run(&work(&one, Some(&file), 1), 2, Ok).unwrap();
        let error = run(&work(&two, Some(&file), 1), 2, Ok).unwrap_err().to_string();
        assert!(error.contains("r.csv.partial") && error.contains("other settings"), "{error}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
