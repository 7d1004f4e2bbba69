//! `--eyes`: onboard perception of a run, if the program was built with it.

use std::any::Any;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

use paid_runtime::eyes::Sensed;
use paid_runtime::runtime::Phase;
use paid_runtime::{LastWords, Player};
use paid_terminal::Failure;

use crate::args::NetworkArgs;

/// Perception, which ends when this is dropped; what to give the link to the robot; a line for each fault.
pub type Opened = (Box<dyn Any>, Sensed, Receiver<String>);

/// Opens perception that was checked, for a runtime in this phase.
pub type Open = Box<dyn FnOnce(Arc<Phase>, &LastWords) -> Result<Opened, Failure>>;

/// Refuses what can be refused before there is a robot.
///
/// # Errors
/// If a file is missing or does not fit.
#[cfg(feature = "perception")]
pub fn plan(file: &Path, player: &Arc<Player>, network: &NetworkArgs) -> Result<Open, Failure> {
    use paid_runtime::eyes::{Eyes, EyesConfig, EyesPlace};

    let place = EyesPlace { domain: network.domain, interface: network.interface };
    let config = EyesConfig::read(file)?;
    Eyes::check(&config, player, place)?;
    let player = Arc::clone(player);
    Ok(Box::new(move |phase, last_words| {
        let (eyes, lines) = Eyes::open(&config, &player, place, phase, last_words)?;
        let sensed = eyes.sensed();
        Ok((Box::new(eyes), sensed, lines))
    }))
}

/// Refuses.
///
/// # Errors
/// Always.
#[cfg(not(feature = "perception"))]
pub fn plan(_file: &Path, _player: &Arc<Player>, _network: &NetworkArgs) -> Result<Open, Failure> {
    Err(Failure::input(
        "--eyes: this program was built without onboard perception; build it with the cargo feature 'perception'",
    ))
}
