//! The built-in engine's task with MuJoCo's contacts.

use paid_mujoco::SceneOptions;
use paid_mujoco::contact::{builtin_kind, builtin_surface};
use paid_physics::{BallParams, Combine, ContactKind, Material};
use paid_task::TaskPreset;

/// `task` with the kind of contacts, the friction and the damping that `scene` has, as near as the built-in engine can follow: the
/// ball meets flat feet, as the vendor's are. Other shapes, the robot's bodies against one another and the physics step stay its own.
#[must_use]
pub fn like_mujoco(task: &TaskPreset, scene: &SceneOptions) -> TaskPreset {
    let mut task = task.clone();
    let kind = builtin_kind(scene, task.scene.physics_dt_s);
    task.contact_kind = ContactKind { foot_flatness: 1.0, ..kind };
    let even =
        |friction: f64| Material { static_friction: friction, dynamic_friction: friction, restitution: 0.0 };
    // With a ground of 1 that multiplies, the other surface decides, as with MuJoCo's priorities.
    task.scene.ground = even(1.0);
    task.scene.ground_friction_combine = Combine::Multiply;
    task.scene.ground_restitution_combine = Combine::Multiply;
    task.robot_material = even(scene.floor.friction[0]);
    task.ball_params.material = builtin_surface(scene);
    if !scene.ball.is_some_and(|ball| ball.damped) {
        task.ball_params = BallParams { linear_damping: 0.0, angular_damping: 0.0, ..task.ball_params };
    }
    task
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_have_mujocos_friction() {
        let task = TaskPreset::builtin("paper_stage2").expect("built in");
        let mut scene = SceneOptions::default();
        scene.floor.friction[0] = 0.6;
        let like = like_mujoco(&task, &scene);
        assert_eq!(like.scene.contact_with_ground(like.robot_material).dynamic_friction, 0.6);
        assert_eq!(like.scene.contact_with_ground(like.ball_params.material).static_friction, 0.8);
        assert_eq!(like.contact_kind.foot_flatness, 1.0);
        assert!(like.contact_kind.compliance.ball_robot.is_soft());
        assert_eq!(like.ball_params.angular_damping, 0.0);
        like.validate().expect("values in range");
    }
}
