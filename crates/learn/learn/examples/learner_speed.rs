//! Prints the learner's speed: `cargo run --release -p paid-learn --example learner_speed -- [threads] [seconds]`.

use paid_learn::bench::{BenchSize, bench};
use paid_learn::{LearnConfig, LstmConfig, NetworkConfig, NetworkKind, PpoConfig, Precision};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let threads: usize = arguments.next().map_or(Ok(1), |x| x.parse())?;
    let seconds: f64 = arguments.next().map_or(Ok(2.0), |x| x.parse())?;
    let both = |network: NetworkConfig| LearnConfig {
        actor: network.clone(),
        critic: network,
        ppo: PpoConfig::default(),
        precision: Precision::Auto,
    };
    let lstm = |layers| NetworkConfig {
        kind: NetworkKind::Lstm,
        hidden: vec![128, 64, 32],
        lstm: LstmConfig { layers, size: 128 },
        ..NetworkConfig::default()
    };
    let size = BenchSize { policy_obs: 160, critic_obs: 290, actions: 29, shards: 4, envs: 512, threads };
    let cases =
        [("MLP 256-128-64", NetworkConfig::default()), ("LSTM 1x128", lstm(1)), ("LSTM 2x128", lstm(2))];
    for (name, network) in cases {
        let b = bench(&both(network), size, seconds)?;
        println!(
            "{name}, {threads} threads: update {:.0} samples/s ({:.1} GFLOP/s, gemm alone {:.1}), collect {:.0} samples/s",
            b.update_samples_per_s, b.update_gflop_per_s, b.peak_gflop_per_s, b.collect_samples_per_s
        );
    }
    Ok(())
}
