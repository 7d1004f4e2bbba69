//! The robot's mirror image in its x-z plane: left and right change places.

use thiserror::Error;

use crate::RobotModel;

/// A part that has no image.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{kind} '{name}' has no image '{image}'")]
pub struct MirrorError {
    /// `joint` or `body`.
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// The name that its image would have.
    pub image: String,
}

/// The name of a part on the other side: `left_` and `right_` at its beginning are exchanged.
pub fn mirrored_name(name: &str) -> String {
    match (name.strip_prefix("left_"), name.strip_prefix("right_")) {
        (Some(rest), _) => format!("right_{rest}"),
        (_, Some(rest)) => format!("left_{rest}"),
        _ => name.to_owned(),
    }
}

/// For each of `names` the index of its image among them.
///
/// # Errors
/// The first without one; `kind` is what the error calls it.
pub fn mirrored_names(kind: &'static str, names: &[String]) -> Result<Vec<usize>, MirrorError> {
    let image = |name: &String| {
        let image = mirrored_name(name);
        let index = names.iter().position(|n| *n == image);
        index.ok_or_else(|| MirrorError { kind, name: name.clone(), image })
    };
    names.iter().map(image).collect()
}

impl RobotModel {
    /// For each joint its image and the sign of its angle there: the image's angle is the sign times this one's. A mirror in the x-z plane
    /// turns an axis (x, y, z) into (-x, y, -z).
    ///
    /// # Errors
    /// A joint without an image.
    pub fn mirrored_joints(&self) -> Result<Vec<(usize, f64)>, MirrorError> {
        let images = mirrored_names("joint", &self.joint_names())?;
        let sign = |(joint, &image): (usize, &usize)| {
            let ([x, y, z], axis) = (self.joints[joint].axis, self.joints[image].axis);
            (image, (-x * axis[0] + y * axis[1] - z * axis[2]).signum())
        };
        Ok(images.iter().enumerate().map(sign).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_of_a_joint_is_on_the_other_side_and_rolls_and_turns_the_other_way() {
        let model = RobotModel::g1();
        let joints = model.mirrored_joints().expect("symmetric");
        let image = |name: &str| {
            let (image, sign) = joints[model.joint_index(name).expect("a joint")];
            (model.joints[image].name.as_str(), sign)
        };
        assert_eq!(image("left_hip_pitch_joint"), ("right_hip_pitch_joint", 1.0));
        assert_eq!(image("right_hip_roll_joint"), ("left_hip_roll_joint", -1.0));
        assert_eq!(image("waist_yaw_joint"), ("waist_yaw_joint", -1.0));
        assert_eq!(image("waist_pitch_joint"), ("waist_pitch_joint", 1.0));
        for (joint, &(image, sign)) in joints.iter().enumerate() {
            assert_eq!(joints[image], (joint, sign), "twice mirrored is itself");
        }
    }

    #[test]
    fn a_name_without_an_image_is_named() {
        let names = ["left_hand".to_owned(), "head".to_owned()];
        let error = mirrored_names("body", &names).expect_err("one-handed").to_string();
        assert_eq!(error, "body 'left_hand' has no image 'right_hand'");
        assert_eq!(mirrored_names("body", &names[1..]), Ok(vec![0]));
    }
}
