//! Prints how fast the world and the mental rollout run. `cargo run --release --example bench_world`.
fn main() {
    tactus_sim_host::bench::bench_world();
    tactus_sim_host::bench::bench_rollout();
}
