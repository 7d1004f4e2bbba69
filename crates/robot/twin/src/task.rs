//! The task that a player's policy was trained in: the virtual robot's ground and ball are that task's.

use paid_runtime::Player;
use paid_task::TaskPreset;
use paid_train::TrainedPolicy;

use crate::TwinError;

/// The task of a player's policy, with the player's changes.
///
/// # Errors
/// If the policy's file can no longer be read, or its preset is not one of this program.
pub fn trained_task(player: &Player) -> Result<TaskPreset, TwinError> {
    let trained = TrainedPolicy::load(&player.path).map_err(TwinError::simulation)?;
    trained.preset.task.with_overrides(&player.sets).map_err(TwinError::simulation)
}
