//! Promise: `include/tactus.h` is what cbindgen makes of the sources as they are.

use std::path::Path;

#[test]
fn the_committed_header_is_the_generated_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut generated = Vec::new();
    cbindgen::generate(root).expect("the sources are what cbindgen understands").write(&mut generated);
    let generated = String::from_utf8(generated).expect("text");
    let committed = std::fs::read_to_string(root.join("include/tactus.h")).expect("include/tactus.h is there");
    if let Some((line, (is, should))) =
        committed.lines().zip(generated.lines()).enumerate().find(|(_, (is, should))| is != should)
    {
        panic!(
            "include/tactus.h is out of date at line {}: `{is}` should be `{should}`; write it anew with: cargo run \
             --package tactus-library --example header",
            line + 1
        );
    }
    assert_eq!(committed.len(), generated.len(), "include/tactus.h is shorter or longer than it should be");
}

#[test]
fn every_name_that_c_sees_is_ours() {
    let header =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("include/tactus.h")).expect("there");
    for line in header.lines() {
        if let Some(name) = line.strip_prefix("#define ") {
            assert!(name.starts_with("TACTUS_"), "{line}");
        }
        if let Some(name) = line.strip_prefix("typedef struct ") {
            assert!(name.starts_with("Tactus"), "{line}");
        }
    }
}
