//! What the tests of this crate share.

use std::path::Path;
use std::sync::Arc;

use paid_runtime::{Player, PlayerSpec};

/// The repository's own policy on the built-in kicks.
pub fn player() -> Arc<Player> {
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    let spec = PlayerSpec { policy, motions: None, sets: Vec::new() };
    Arc::new(Player::load(&spec).expect("the repository's policy"))
}
