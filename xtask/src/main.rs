//! Developer commands of the workspace, reached through the aliases in `.cargo/config.toml`.

mod mujoco;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo mujoco\n\n\
    mujoco   fetch libmujoco from its Python wheel with pip, into <target folder>/mujoco";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["mujoco"] => match mujoco::install() {
            Ok(path) => {
                println!("{}", path.display());
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        },
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}
