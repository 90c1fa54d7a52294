//! The page as a whole, from a small recording; and its script, against its sources.

use super::packed::Packed;
use super::page::{Heading, page};
use super::payload::{Belief, Contacts, Frames, Mark, MarkKind, Payload};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("view")
}

/// What the list beside the script says: file (relative to its sources) and SHA-256.
fn listed() -> Vec<(String, String)> {
    let lines = include_str!("page.sha256").lines();
    lines.map(|line| line.split_once("  ").unwrap()).map(|(sum, path)| (path.to_owned(), sum.to_owned())).collect()
}

#[test]
fn the_script_is_what_its_sources_give() {
    for (path, sum) in listed() {
        let bytes =
            std::fs::read(sources().join(&path)).unwrap_or_else(|error| panic!("sim-host/view/{path}: {error}"));
        let found: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(found, sum, "sim-host/view/{path} has changed: run `cargo xtask page`");
    }
}

#[test]
fn no_source_is_missing_in_the_list() {
    let listed: BTreeSet<String> = listed().into_iter().map(|(path, _)| path).collect();
    let files = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(sources().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        entries
            .filter(|path| path.is_file())
            .map(|path| format!("{folder}{}", path.file_name().unwrap().to_string_lossy()))
            .collect()
    };
    for file in files("").into_iter().chain(files("src/")) {
        assert!(
            listed.contains(&file),
            "sim-host/view/{file} is not in sim-host/src/view/page.sha256: run `cargo xtask page`"
        );
    }
    assert!(listed.contains("../src/view/page.js"));
}

#[test]
fn the_script_carries_the_licence_of_its_library_and_ends_no_tag() {
    let script = include_str!("page.js");
    let licence = include_str!("../../view/LICENSE-three.txt");
    assert!(licence.contains("The MIT License") && script.contains(licence));
    assert!(!script.contains("</script"), "the page would end there");
}

fn payload(text: &str) -> Payload {
    let none = || Packed::quantised(&[]);
    Payload {
        duration_s: 1.0,
        colour_map: Vec::new(),
        bright_n_cm2: 1.0,
        frames: Frames { times_s: none(), names: Vec::new(), poses: Vec::new() },
        palm: 0,
        bodies: Vec::new(),
        belief: Belief { times_s: none(), poses: none(), covariances: none(), radius_m: 0.1 },
        goal: None,
        pads: Vec::new(),
        contacts: Contacts { times_s: none(), starts: none(), points_m: none(), arrows_m: none() },
        plots: Vec::new(),
        phases: Vec::new(),
        marks: vec![Mark { at_s: 0.5, kind: MarkKind::Other, text: text.to_owned() }],
    }
}

#[test]
fn texts_of_a_recording_stay_texts() {
    let text = "</script><img src=x onerror=alert(1)>";
    let heading = Heading {
        title: text.to_owned(),
        facts: vec![(text.to_owned(), text.to_owned())],
        warning: Some(text.to_owned()),
    };
    let page = page(&heading, &payload(text)).unwrap();
    assert!(!page.contains("<img"), "a text became a tag");
    let from = page.find("id=\"run\">").unwrap() + "id=\"run\">".len();
    let json = &page[from..from + page[from..].find("</script>").unwrap()];
    let read: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(read["marks"][0]["text"], text);
}

#[test]
fn the_page_names_nothing_outside_itself() {
    let page = page(&Heading { title: "t".into(), facts: Vec::new(), warning: None }, &payload("")).unwrap();
    let markup = &page[..page.find("id=\"run\"").unwrap()];
    for forbidden in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!markup.contains(forbidden), "{forbidden}");
    }
}
