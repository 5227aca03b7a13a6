//! The command `tirtouch`.

fn main() -> std::process::ExitCode {
    tirtouch::cli::main()
}
