//! Developer commands of the workspace, reached through the aliases in `.cargo/config.toml`.

mod mujoco;
mod pictures;
#[cfg(test)]
mod readme;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask mujoco | pictures [OPTIONS]\n\n\
    mujoco     fetch libmujoco from its Python wheel with pip, into <target folder>/mujoco\n\
    pictures   make the README's pictures again; 'cargo xtask pictures --help' lists its options";

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
        ["pictures", ref options @ ..] => pictures::command(options),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}
