//! Values of a run preset that change during the run.

use std::path::Path;

use paid_physics::SceneConfig;
use paid_task::layers::{KeyError, Tree};
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::RunPreset;
use crate::style::AmpPreset;

/// Overrides that apply after a fraction of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// The share of the run that is over when it begins, above 0 and below 1: of the iterations or, if there is a limit, of the
    /// wall clock, whichever is further.
    pub from: f64,
    /// The values under their keys in the preset. They lie over those of earlier phases.
    #[serde(flatten)]
    pub values: Table,
}

impl RunPreset {
    /// The number of phases that have begun when `share` (0 to 1) of the run is over.
    pub fn phase(&self, share: f64) -> usize {
        self.phases.iter().filter(|phase| phase.from <= share).count()
    }

    /// The preset after `begun` of its phases have begun, without phases of its own.
    ///
    /// # Errors
    /// Phase, key, expected, found.
    ///
    /// # Panics
    /// If there are fewer phases.
    pub fn in_phase(&self, begun: usize) -> Result<Self, String> {
        self.after(begun).map_err(|error| error.to_string())
    }

    /// [`RunPreset::in_phase`], with the key apart.
    fn after(&self, begun: usize) -> Result<Self, KeyError> {
        let plain = Self { phases: Vec::new(), ..self.clone() };
        let Some(last) = begun.checked_sub(1) else { return Ok(plain) };
        let in_phase = |error: KeyError| KeyError { key: format!("phases.{last}.{}", error.key), ..error };
        let fail =
            |error: toml::ser::Error| KeyError { key: format!("phases.{last}"), message: error.to_string() };
        let mut tree = Tree::of(&plain).map_err(fail)?;
        for phase in &self.phases[..begun] {
            tree.lay(Tree::of(&phase.values).map_err(fail)?);
        }
        let preset: Self = tree.typed().map_err(in_phase)?;
        preset.check().map_err(in_phase)?;
        Ok(preset)
    }

    /// Checks order and keys of the phases, and that each gives a valid preset.
    pub(crate) fn check_phases(&self) -> Result<(), KeyError> {
        let mut before = 0.0;
        for (k, phase) in self.phases.iter().enumerate() {
            let wrong =
                |key: &str, message: String| Err(KeyError { key: format!("phases.{k}.{key}"), message });
            if !(phase.from > before && phase.from < 1.0) {
                return wrong(
                    "from",
                    format!("expected more than {before} and less than 1, found {}", phase.from),
                );
            }
            before = phase.from;
            let known = self.after(k + 1)?;
            let changed = if known.run == self.run { self.first_change(&known) } else { Some("run") };
            if let Some(key) = changed {
                return wrong(key, "expected what holds for the whole run, found a change".to_owned());
            }
        }
        Ok(())
    }

    /// The first key outside `run` that holds for a whole run, and has another value in `other`.
    fn first_change(&self, other: &Self) -> Option<&'static str> {
        let (seen, see) = (&self.task.observations, &other.task.observations);
        let of_amp = |of: fn(&AmpPreset, &AmpPreset) -> bool| match (&other.amp, &self.amp) {
            (Some(other), Some(own)) => of(other, own),
            (other, own) => other.is_none() && own.is_none(),
        };
        let fixed = [
            ("stage", other.stage == self.stage),
            ("robot", other.robot == self.robot),
            ("learn.actor", other.learn.actor == self.learn.actor),
            ("learn.critic", other.learn.critic == self.learn.critic),
            // The rate is where its schedule has brought it: a run continues from there.
            ("learn.ppo.learning_rate", other.learn.ppo.learning_rate == self.learn.ppo.learning_rate),
            ("task.name", other.task.name == self.task.name),
            ("task.observations.policy", see.policy == seen.policy),
            ("task.observations.critic", see.critic == seen.critic),
            ("task.observations.style", see.style == seen.style),
            // Networks and the ring of earlier pairs are taken over as they are.
            ("amp.own_critic", of_amp(|a, b| a.own_critic == b.own_critic)),
            ("amp.discriminator.hidden", of_amp(|a, b| a.discriminator.hidden == b.discriminator.hidden)),
            ("amp.discriminator.replay", of_amp(|a, b| a.discriminator.replay == b.discriminator.replay)),
            ("task.scene", same_but_for_the_step(&other.task.scene, &self.task.scene)),
        ];
        fixed.into_iter().find(|(_, same)| !same).map(|(key, _)| key)
    }

    /// Refuses to continue with this preset from a checkpoint of the preset `found`, if a value differs that holds for a whole run. Those of
    /// `run` may differ (resuming checks shards and motions itself), the robot may lie in another folder, and a control step may have other
    /// physics steps.
    ///
    /// # Errors
    /// Key, expected, found.
    pub(crate) fn check_same_run(&self, found: &Self) -> Result<(), KeyError> {
        let mut known = found.clone();
        if Path::new(&known.robot).file_name() == Path::new(&self.robot).file_name() {
            known.robot.clone_from(&self.robot);
        }
        if (known.task.control_dt_s() - self.task.control_dt_s()).abs() < 1e-9 {
            let (scene, own) = (&mut known.task.scene, &self.task.scene);
            (scene.physics_dt_s, scene.substeps) = (own.physics_dt_s, own.substeps);
        }
        let Some(key) = self.first_change(&known) else { return Ok(()) };
        let fail = |error: toml::ser::Error| KeyError { key: key.to_owned(), message: error.to_string() };
        let (own, other) = (Tree::of(self).map_err(fail)?, Tree::of(&known).map_err(fail)?);
        let below =
            |name: &str| name.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        let mut leaves = own.leaves().into_iter().chain(other.leaves()).map(|(name, ..)| name);
        let differs = |name: &String| below(name) && own.value(name) != other.value(name);
        let key = leaves.find(differs).unwrap_or_else(|| key.to_owned());
        let text =
            |tree: &Tree| tree.value(&key).map_or_else(|| "none".to_owned(), |value| value.to_string());
        let (expected, found) = (text(&own), text(&other));
        Err(KeyError {
            key,
            message: format!("expected {expected}, found {found}, which holds for the whole run"),
        })
    }
}

/// True if the scenes differ by no more than how many physics steps a control step has.
fn same_but_for_the_step(a: &SceneConfig, b: &SceneConfig) -> bool {
    let control = |scene: &SceneConfig| scene.physics_dt_s * scene.substeps as f64;
    let stepped = SceneConfig { physics_dt_s: b.physics_dt_s, substeps: b.substeps, ..a.clone() };
    stepped == *b && (control(a) - control(b)).abs() < 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "base = \"stage1\"
[[phases]]
from = 0.5
[phases.task.rewards]
body_pos = { weight = 3.0, sigma = 0.08 }
[[phases]]
from = 0.75
[phases.task.rewards]
body_pos = { sigma = 0.05 }
[phases.learn.ppo]
target_kl = 0.01
";

    fn preset(text: &str, sets: &[&str]) -> Result<RunPreset, String> {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, text).expect("write");
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        RunPreset::resolve(&path.to_string_lossy(), &sets).map_err(|error| error.to_string())
    }

    #[test]
    fn a_phase_lies_over_the_preset_and_the_phases_before_it() {
        let preset = preset(FILE, &[]).expect("resolves");
        let at = |share| preset.in_phase(preset.phase(share)).expect("valid");
        let body = |share| (at(share).task.rewards.body_pos.weight, at(share).task.rewards.body_pos.sigma);
        let first = &preset.task.rewards.body_pos;
        assert_eq!([0.0, 0.49].map(body), [(first.weight, first.sigma); 2]);
        assert_eq!([0.5, 0.74].map(body), [(3.0, 0.08); 2]);
        assert_eq!([0.75, 1.0].map(body), [(3.0, 0.05); 2]);
        assert_eq!(at(0.7).learn.ppo.target_kl, preset.learn.ppo.target_kl);
        assert_eq!(at(0.8).learn.ppo.target_kl, 0.01);
        assert_eq!(at(0.8).phases, []);
        let text = preset.to_toml().expect("writes");
        assert_eq!(RunPreset::from_resolved("saved", &text, &[]).expect("reads"), preset);
    }

    #[test]
    fn what_an_override_or_a_preset_above_says_holds_in_every_phase() {
        let below =
            FILE.replace("base = \"stage1\"", "base = \"stage1\"\nstage = \"mine\"\n[task]\nname = \"mine\"");
        let folder = tempfile::tempdir().expect("folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("write");
        write("below.toml", &below);
        write("above.toml", "base = \"below.toml\"\n[task.rewards]\nbody_pos = { weight = 9.0 }\n");
        let path = folder.path().join("above.toml");
        let sets = ["task.rewards.body_pos.sigma=0.2".to_owned()];
        let preset = RunPreset::resolve(&path.to_string_lossy(), &sets).expect("resolves");
        for begun in 0..3 {
            let body = preset.in_phase(begun).expect("valid").task.rewards.body_pos;
            assert_eq!((body.weight, body.sigma), (9.0, 0.2), "phase {begun}");
        }
        assert_eq!(preset.in_phase(2).expect("valid").learn.ppo.target_kl, 0.01);
        let none = RunPreset::resolve(&path.to_string_lossy(), &["phases=[]".to_owned()]).expect("resolves");
        assert_eq!(none.phases, []);
    }

    #[test]
    fn a_phase_may_take_more_physics_steps_for_the_same_control_step() {
        let finer = FILE.replace(
            "[phases.learn.ppo]\ntarget_kl = 0.01",
            "[phases.task.scene]\nphysics_dt_s = 0.0025\nsubsteps = 8",
        );
        let preset = preset(&finer, &[]).expect("20 ms, as before");
        let steps = |share| preset.in_phase(preset.phase(share)).expect("valid").task.scene.substeps;
        assert_eq!([0.6, 0.8].map(steps), [4, 8]);
    }

    #[test]
    fn a_phase_that_cannot_be_is_refused_before_the_run() {
        for (from, to, hint) in [
            ("from = 0.5", "from = 0.8", "phases.1.from: expected more than 0.8 and less than 1, found 0.75"),
            ("from = 0.75", "from = 1.0", "phases.1.from"),
            (
                "sigma = 0.05",
                "sgima = 0.05",
                "mine.toml:9: phases.1.task.rewards.body_pos.sgima: unknown key; did you mean 'task.rewards.body_pos.sigma'",
            ),
            (
                "sigma = 0.05",
                "sigma = -1.0",
                "phases.1.task.rewards.body_pos.sigma: expected a positive number, found -1",
            ),
            ("[phases.learn.ppo]\ntarget_kl = 0.01", "[phases.run]\nenvs = 640", "phases.1.run"),
            ("target_kl = 0.01", "learning_rate = 0.01", "phases.1.learn.ppo.learning_rate"),
            (
                "[phases.learn.ppo]\ntarget_kl = 0.01",
                "[phases.task.scene]\nball = true",
                "phases.1.task.scene",
            ),
            (
                "[phases.learn.ppo]\ntarget_kl = 0.01",
                "[phases.task.scene]\nsubsteps = 8",
                "phases.1.task.scene",
            ),
        ] {
            let text = FILE.replace(from, to);
            assert_ne!(text, FILE);
            let error = preset(&text, &[]).expect_err(to);
            assert!(error.contains(hint), "{to}: {error}");
        }
    }

    #[test]
    fn a_run_continues_with_another_length_and_not_with_other_networks() {
        let of = |sets: &[&str]| preset(FILE, sets).expect("resolves");
        let begun = of(&[]).in_phase(2).expect("valid");
        let resumed = |sets: &[&str]| {
            let now = of(sets).in_phase(2).expect("valid");
            now.check_same_run(&begun).map_err(|error| error.to_string())
        };
        assert_eq!(resumed(&[]), Ok(()));
        let length = ["run.iterations=9", "run.checkpoint_interval=3", "run.motions=elsewhere"];
        assert_eq!(resumed(&length), Ok(()));
        assert_eq!(resumed(&["learn.ppo.epochs=7", "learn.precision=f32"]), Ok(()));
        for (set, expected) in [
            (
                "learn.ppo.learning_rate=0.5",
                "learn.ppo.learning_rate: expected 0.5, found 0.001, which holds for the whole run",
            ),
            ("learn.actor.hidden=[24]", "learn.actor.hidden: expected [24], found [256, 128, 64]"),
            ("task.scene.solver_sweeps=9", "task.scene.solver_sweeps: expected 9, found "),
            (
                r#"task.observations.policy=["goal_pos", "ball_pos"]"#,
                r#"task.observations.policy: expected ["goal_pos", "ball_pos"], found ["reference_joint_pos""#,
            ),
        ] {
            let error = resumed(&[set]).expect_err(set);
            assert!(error.starts_with(expected), "{error}");
        }
        // A phase may change physics steps, so they are not what is reported.
        let mut finer = begun.clone();
        (finer.task.scene.physics_dt_s, finer.task.scene.substeps) = (0.0025, 8);
        assert_eq!(finer.check_same_run(&begun), Ok(()));
        finer.task.scene.solver_sweeps = 9;
        let error = finer.check_same_run(&begun).expect_err("another scene").to_string();
        assert!(error.starts_with("task.scene.solver_sweeps: expected 9, found "), "{error}");
        // The robot's file may lie in another folder.
        let (mut here, mut there) = (begun.clone(), begun.clone());
        (here.robot, there.robot) = ("robots/mine.toml".to_owned(), "../mine.toml".to_owned());
        assert_eq!(here.check_same_run(&there), Ok(()));
        there.robot = "other.toml".to_owned();
        let error = here.check_same_run(&there).expect_err("another robot").to_string();
        assert!(error.starts_with(r#"robot: expected "robots/mine.toml", found "other.toml""#), "{error}");
    }

    /// Networks with other inputs or layers cannot continue from the phase before.
    #[test]
    fn a_phase_keeps_what_networks_and_discriminator_see_and_how_they_are_made() {
        let of = |values: &str| preset(&format!("base = \"amp\"\n[[phases]]\nfrom = 0.5\n{values}\n"), &[]);
        of("[phases.amp]\nstyle = 1.0\n[phases.amp.discriminator]\nlearning_rate = 0.001")
            .expect("may change");
        for (table, key, value) in [
            ("task.observations", "policy", "[\"projected_gravity\", \"ball_pos\", \"goal_pos\"]"),
            ("task.observations", "critic", "[\"projected_gravity\", \"ball_pos\", \"goal_pos\"]"),
            ("task.observations", "style", "[\"joint_pos_rel\"]"),
            ("amp", "own_critic", "true"),
            ("amp.discriminator", "hidden", "[64]"),
            ("amp.discriminator", "replay", "5000"),
        ] {
            let error = of(&format!("[phases.{table}]\n{key} = {value}")).expect_err(key);
            let expected =
                format!("phases.0.{table}.{key}: expected what holds for the whole run, found a change");
            assert!(error.contains(&expected), "{error}");
        }
    }
}
