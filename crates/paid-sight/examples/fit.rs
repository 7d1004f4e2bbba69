//! The constants of the noise from files of finds: `cargo run -p paid-sight --example fit -- CSV ...`.

use std::path::Path;

use paid_sight::fit::{fit, read};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut finds = Vec::new();
    for file in std::env::args().skip(1) {
        finds.extend(read(Path::new(&file))?);
    }
    let fitted = fit(&finds)?;
    let noise = paid_perceive::EyesPreset::default().noise();
    let scale = fitted.scale(&finds, |speed, distance| noise.deviation(speed, distance));
    println!("{scale:.2} times the noise of training\n{}", serde_json::to_string_pretty(&fitted)?);
    Ok(())
}
