//! Everything that a plan takes as it is, policies and clips, is read before anything is trained.

use std::path::Path;

use paid_eval::EvalError;
use paid_eval::likeness::load_clips;
use paid_eval::scene::Engines;
use paid_eval::subject::{PolicySource, SubjectSpec};
use paid_motion::MotionLibrary;
use paid_play::load_robot;
use paid_task::preset::KnowledgeMode;
use paid_train::setup::check_starts;

use super::contender::Contender;
use super::plan::{JudgePlan, wrong};
use super::{score, tracks};

impl Contender {
    /// Reads what it starts from, or what it is if it is not trained: the file, its networks, its robot, and the clips in `motions` (or its
    /// own). `robot` is that of the plan's training, if there is any.
    ///
    /// # Errors
    /// The first part that would fail once it is trained or scored.
    pub fn check(
        &self,
        judge: &JudgePlan,
        motions: Option<&Path>,
        robot: Option<&str>,
    ) -> Result<(), EvalError> {
        check_starts(&self.stages, self.from.as_deref())?;
        // Kicks are compared with the clips, also those of a policy that follows none.
        if let Some(last) = self.stages.last().filter(|_| judge.likeness_trials > 0 && !self.tracks) {
            let (model, spec) = load_robot(&last.robot)?;
            let rate_hz = 1.0 / last.task.control_dt_s();
            MotionLibrary::open(motions.unwrap_or(Path::new("")), &model, &spec, rate_hz)?;
        }
        let Some(policy) = &self.policy else { return Ok(()) };
        let source = PolicySource::read(policy)?;
        if let (Some(expected), Some(found)) = (robot, source.robot())
            && found != expected
        {
            let expected = format!("a policy of robot '{expected}', as in the plan's stages");
            return Err(wrong(
                "entry.policy",
                &expected,
                &format!("{} of robot '{found}'", policy.display()),
            ));
        }
        Engines::Mujoco.check()?;
        let spec = SubjectSpec { motions: motions.map(Path::to_owned), ..SubjectSpec::new(policy) };
        if self.tracks {
            tracks::subject(judge, &spec)?;
        } else {
            for &knowledge in &judge.knowledge {
                score::subject(judge, &spec, knowledge)?;
            }
            if judge.likeness_trials > 0 {
                load_clips(
                    &score::clips_folder(&spec)?,
                    &score::subject(judge, &spec, KnowledgeMode::Truth)?.setup,
                )?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::super::plan::Plan;
    use super::*;

    const PLAN: &str = r#"
        title = "ours and another"
        samples = 100000
        sets = ["learn.actor.hidden=[1]", "learn.critic.hidden=[1]"]

        [judge]
        knowledge = ["truth", "perceived"]

        [[entry]]
        name = "ours"
        from = "../crates/skill/train/tests/samples/stage1.safetensors"
        stages = [{ preset = "stage2" }]
    "#;

    const FROM: &str = "from = \"../crates/skill/train/tests/samples/stage1.safetensors\"";

    fn policies() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies")
    }

    /// Reads the entries of a plan with the committed policies.
    fn checked(plan: &str, motions: Option<&Path>) -> Result<(), String> {
        let plan: Plan = toml::from_str(plan).expect("reads");
        let set = motions.map(|folder| format!("run.motions={:?}", folder.display().to_string()));
        let contenders = plan.contenders(&policies(), set.as_deref()).expect("fits");
        let robot = contenders.iter().flat_map(|c| &c.stages).map(|preset| preset.robot.clone()).next();
        contenders.iter().try_for_each(|contender| {
            contender.check(&plan.judge, motions, robot.as_deref()).map_err(|error| error.to_string())
        })
    }

    #[test]
    fn a_policy_to_begin_with_has_the_networks_of_its_stage() {
        checked(PLAN, None).expect("fits");
        let error = checked(
            &PLAN.replace("../crates/skill/train/tests/samples/stage1.safetensors", "demo/README.md"),
            None,
        )
        .expect_err("no policy");
        assert!(error.contains("README.md"), "{error}");
        let other = PLAN.replace(
            "[{ preset = \"stage2\" }]",
            "[{ preset = \"stage2\", sets = [\"learn.actor.hidden=[2]\"] }]",
        );
        let error = checked(&other, None).expect_err("another network");
        assert!(error.contains("stage1.safetensors"), "{error}");
    }

    #[test]
    fn clips_of_another_robot_are_refused_whoever_needs_them() {
        let folder = tempfile::tempdir().expect("folder");
        // One joint instead of 29.
        let clip = "# fps: 50\n0,0,1,0,0,0,1,0.5\n0,0,1,0,0,0,1,0.5\n";
        fs::write(folder.path().join("kick.csv"), clip).expect("writes");
        let refused = |plan: &str| checked(plan, Some(folder.path())).expect_err("refused");
        assert!(refused(PLAN).contains("kick.csv"));
        // It follows none, but is compared with them.
        let free = PLAN
            .replace(FROM, "")
            .replace("\"stage2\"", "\"pure_rl\"")
            .replace("[judge]", "[judge]\nlikeness_trials = 1");
        assert!(refused(&free).contains("kick.csv"));
    }

    #[test]
    fn a_policy_as_it_is_must_be_one_that_can_be_judged() {
        let test = "a_policy_as_it_is_must_be_one_that_can_be_judged";
        let Some(_) = paid_testing::mujoco(test, paid_mujoco::Library::get()) else { return };
        let with = |policy: &str| format!("{PLAN}\n[[entry]]\nname = \"another\"\npolicy = \"{policy}\"\n");
        checked(&with("demo/policy.onnx"), None).expect("fits");
        let error = checked(&with("demo/README.md"), None).expect_err("no policy");
        assert!(error.contains("README.md"), "{error}");
        let error = checked(&with("../crates/skill/train/tests/samples/stage1.safetensors"), None)
            .expect_err("no ball");
        assert!(error.contains("expected one with a physical ball"), "{error}");

        // The same robot under another name is another one.
        let folder = tempfile::tempdir().expect("folder");
        let root = policies().join("..");
        fs::copy(root.join("configs/robots/g1.toml"), folder.path().join("twin.toml")).expect("copies");
        fs::copy(root.join("crates/base/robot/assets/g1.xml"), folder.path().join("twin.xml"))
            .expect("copies");
        let robot = format!("sets = ['robot={:?}', ", folder.path().join("twin.toml").display().to_string());
        let twin = with("demo/policy.onnx").replace("sets = [", &robot).replace(FROM, "");
        let error = checked(&twin, None).expect_err("another robot");
        assert!(
            error.contains("entry.policy: expected a policy of robot") && error.contains("twin.toml"),
            "{error}"
        );
    }
}
