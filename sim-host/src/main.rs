//! The `tactus` command.

fn main() -> std::process::ExitCode {
    tactus_sim_host::cli::main(std::env::args_os())
}
