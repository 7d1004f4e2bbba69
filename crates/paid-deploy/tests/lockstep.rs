//! Runtime and virtual robot in step.

use std::sync::Arc;

use paid_deploy::sim::{MatchOptions, play_match};
use paid_deploy::{Player, PlayerSpec};

#[test]
#[ignore = "experiment"]
fn experiment() {
    let shared = std::env::var("PAID_SHARED").expect("shared");
    let sets: Vec<String> = std::env::var("SETS").map(|s| s.split(',').map(str::to_owned).collect()).unwrap_or_default();
    let spec = PlayerSpec {
        policy: std::env::var("POLICY").unwrap_or("../../policies/paid13_long/stage2.safetensors".into()).into(),
        motions: Some(format!("{shared}/data/motions/paid").into()),
        sets,
    };
    let player = Arc::new(Player::load(&spec).expect("player"));
    for seed in 0..std::env::var("SEEDS").map(|s| s.parse().unwrap()).unwrap_or(1) {
        let mut options = MatchOptions::default();
        if let Ok(path) = std::env::var("LIMITS") {
            options.lockstep.limits = paid_deploy::Limits::read(path.as_ref()).expect("limits");
        }
        options.lockstep.seed = seed;
        let result = play_match(&player, &options, None, |k| println!("{k:?}"));
        match result {
            Ok(r) => {
                println!("goals {} of {} stopped {:?} peak {:?} seconds {}", r.goals(), r.kicks.len(), r.stopped, r.peak, r.seconds);
                if std::env::var("EVENTS").is_ok() { for e in r.events { println!("{e:?}"); } }
            }
            Err(e) => println!("error {e}"),
        }
    }
}
