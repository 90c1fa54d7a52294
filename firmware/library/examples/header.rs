//! Writes `include/tactus.h` anew: `cargo run --package tactus-library --example header`. A test sees that it was done.

use std::path::Path;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    match cbindgen::generate(root) {
        Ok(header) => {
            let changed = header.write_to_file(root.join("include/tactus.h"));
            println!("include/tactus.h: {}", if changed { "written anew" } else { "as it was" });
        }
        Err(error) => {
            eprintln!("no header: {error}");
            std::process::exit(1);
        }
    }
}
