//! The page as a whole, from made-up outputs of every kind.

mod fixture;

use super::{Page, make};
use std::path::Path;
use tempfile::TempDir;

fn directory() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    fixture::write_all(dir.path());
    dir
}

fn page(dir: &Path) -> Page {
    make(dir, None).unwrap()
}

fn with_xml<T>(html: &str, look: impl FnOnce(&roxmltree::Document<'_>) -> T) -> T {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    look(&roxmltree::Document::parse_with_options(html, options).unwrap())
}

/// The complaint about a directory in which one file was changed by `change`.
fn complaint(file: &str, change: impl FnOnce(String) -> String) -> String {
    let dir = directory();
    let path = dir.path().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, change(text)).unwrap();
    match make(dir.path(), None) {
        Ok(_) => panic!("{file}: accepted"),
        Err(error) => format!("{error:#}"),
    }
}

#[test]
fn every_kind_of_experiment_has_its_section_and_figures() {
    let dir = directory();
    let page = page(dir.path());
    with_xml(&page.html, |xml| {
        let texts = |name: &str| -> Vec<String> {
            let all = xml.descendants().filter(|n| n.has_tag_name(name));
            all.map(|n| n.descendants().filter_map(|d| d.text().filter(|_| d.is_text())).collect()).collect()
        };
        assert_eq!(
            texts("h2"),
            [
                "How these figures were made",
                "Error surfaces",
                "Maps of convergence",
                "Sensitivity",
                "Comparison of methods",
                "Missions and observability",
                "Benchmarks"
            ]
        );
        let titles = texts("h3");
        for title in ["surface: surface weighted", "converge: converge published", "compare: compare", "trials: trials"]
        {
            assert!(titles.iter().any(|t| t.starts_with(title)), "{title} is not among {titles:?}");
        }
        assert!(texts("h4").iter().any(|t| t == "3-DOF, error geometric"));
        for figure in xml.descendants().filter(|n| n.has_tag_name("figure")) {
            let has = |name| figure.descendants().any(|n| n.has_tag_name(name));
            assert!(has("figcaption") && has("svg"), "a figure without caption or drawing");
        }
        assert!(texts("caption").iter().any(|t| t.starts_with("Gradient")), "no table for the gradient");
    });
    assert_eq!(page.ignored.len(), 1);
    assert!(page.ignored[0].0.ends_with("notes.txt"));
}

#[test]
fn the_page_needs_nothing_but_itself() {
    let dir = directory();
    let html = page(dir.path()).html;
    for forbidden in ["http://", "https://", "@import", "<link", "<img", "<iframe"] {
        assert!(!html.contains(forbidden), "{forbidden}");
    }
    assert!(html.match_indices("url(").all(|(i, _)| html[i..].starts_with("url(#")), "a url() that leads out");
    with_xml(&html, |xml| {
        let ids: Vec<&str> = xml.descendants().filter_map(|n| n.attribute("id")).collect();
        let leads = |n: roxmltree::Node<'_, '_>| n.attribute("href").or(n.attribute("src")).map(str::to_string);
        for target in xml.descendants().filter_map(leads) {
            assert!(target.strip_prefix('#').is_some_and(|id| ids.contains(&id)), "{target} leads nowhere in the page");
        }
    });
}

#[test]
fn what_comes_from_files_is_text_and_never_markup() {
    let dir = directory();
    let html = page(dir.path()).html;
    assert!(!html.contains("<script>alert"));
    assert!(html.contains("E_mod &lt;script&gt;alert('x')&lt;/script&gt; &amp; co"));
}

#[test]
fn every_cell_of_a_map_is_drawn_with_the_look_of_its_class() {
    let dir = directory();
    let csv = std::fs::read_to_string(dir.path().join("converge-published.csv")).unwrap();
    with_xml(&page(dir.path()).html, |xml| {
        let figures = xml.descendants().filter(|n| n.has_tag_name("svg"));
        let label = "Map of convergence, classes: converge: converge published";
        let map = figures.into_iter().find(|n| n.attribute("aria-label") == Some(label)).unwrap();
        for (class, look) in [("converged", "white"), ("direction", "grey"), ("failed", "black")] {
            let drawn =
                map.descendants().filter(|n| n.has_tag_name("rect") && n.attribute("class") == Some(look)).count();
            assert_eq!(drawn, csv.matches(&format!(",{class},")).count(), "{class}");
            assert!(drawn > 0);
        }
    });
}

#[test]
fn missions_are_counted_after_each_touch_and_one_by_one_where_wrong() {
    let dir = directory();
    let csv = std::fs::read_to_string(dir.path().join("trials.csv")).unwrap();
    let html = page(dir.path()).html;
    for cell in ["213 (71)", "82 (27.3)", "5 (1.7)", "260 (86.7)"] {
        assert!(html.contains(&format!("<td class=\"num\">{cell}</td>")), "{cell}");
    }
    let wrong = csv.matches(",wrong\n").count();
    assert!(wrong > 0 && html.contains(&format!("The {wrong} missions that are wrong or confidently wrong.")));
}

#[test]
fn what_is_not_there_is_named_in_one_line() {
    let dir = directory();
    for entry in std::fs::read_dir(dir.path()).unwrap() {
        let path = entry.unwrap().path();
        if !path.file_name().unwrap().to_string_lossy().starts_with("trials") {
            std::fs::remove_file(path).unwrap();
        }
    }
    let html = page(dir.path()).html;
    assert!(html.contains(
        "Not in this directory: error surfaces, maps of convergence, sensitivity, comparison of methods, benchmarks."
    ));
    assert!(html.contains("Missions and observability"));
}

#[test]
fn a_malformed_file_is_refused_by_file_line_column_and_what_was_expected() {
    let cases: [(&str, &str, &str, &str); 7] = [
        (
            "surface-weighted.csv",
            ",ok\n",
            ",\n",
            "surface-weighted.csv, line 2, column 5 (outcome): nothing there; expected ok",
        ),
        ("surface-weighted.csv", "error,outcome", "err,outcome", "surface-weighted.csv, line 1: no column 'error'"),
        (
            "surface-weighted.csv",
            ",,no inverse",
            ",0,no inverse",
            "(error): '0'; expected nothing, since the outcome is not ok",
        ),
        (
            "converge-published.csv",
            "failed",
            "lost",
            "column 4 (class): 'lost'; expected one of: converged, direction, failed",
        ),
        (
            "converge-published.csv",
            "\n0.1,",
            "\nabc,",
            "converge-published.csv, line 2, column 1 (x): 'abc'; expected a finite number",
        ),
        ("compare.csv", "budget,observable", "budget", "compare.csv, line 3, column 12: 11 fields; expected 12"),
        (
            "trials.json",
            "\"not_observable\": 286",
            "\"not_observable\": -1",
            "trials.json: statistics.by_touch: expected touches",
        ),
    ];
    for (file, from, to, due) in cases {
        let found = complaint(file, |text| text.replacen(from, to, 1));
        assert!(found.contains(due), "{found}\n  does not say: {due}");
        assert!(!found.contains('\n'), "{found}");
    }
    assert!(
        complaint("compare.json", |text| text.replace("\"title\"", "\"head\""))
            .contains("missing field `title` at line")
    );
    assert!(
        complaint("bench.json", |_| "{}".into()).contains("bench.json: expected figures: [{name, value, unit, note}]")
    );
}

#[test]
fn a_directory_without_experiments_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let error = make(dir.path(), None).err().unwrap().to_string();
    assert!(error.contains("no output of an experiment; expected pairs"), "{error}");
    let json = r#"{"experiment": "surface", "title": "t", "command": "c"}"#;
    std::fs::write(dir.path().join("lone.json"), json).unwrap();
    let error = make(dir.path(), None).err().unwrap().to_string();
    assert!(error.contains("lone.csv: no such file"), "{error}");
}

/// Writes the made-up outputs where `TACTUS_REPORT_FIXTURE` says, for looking at a page of them.
#[test]
#[ignore = "writes files for people to look at"]
fn write_the_fixture() {
    let dir = std::env::var("TACTUS_REPORT_FIXTURE").expect("TACTUS_REPORT_FIXTURE: a directory to write to");
    std::fs::create_dir_all(&dir).unwrap();
    fixture::write_all(Path::new(&dir));
}
