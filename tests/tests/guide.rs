//! The guide's commands do what it says.

use std::path::Path;
use tactus_tests::guide::{self, FOLDER, WITH_CAN};

/// What the guide's commands leave behind, told by it or here to be looked at.
const LEFT: &[&str] =
    &["run.json", "run.mcap", "tables", "run.html", "trials.csv", "my_scene.toml", "compare.csv", "report.html"];

#[test]
fn every_command_of_the_guide_runs_and_leaves_what_it_says() {
    let folder = format!("{}/guide", env!("CARGO_TARGET_TMPDIR"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder).expect("a folder");
    let here: Vec<&str> = guide::commands().into_iter().filter(|command| !command.starts_with(WITH_CAN)).collect();
    assert!(here.len() > 12, "{here:?}");
    for command in here {
        guide::run(&command.replace(FOLDER, &folder));
    }
    for name in LEFT {
        assert!(Path::new(&folder).join(name).exists(), "{name}");
    }
}
