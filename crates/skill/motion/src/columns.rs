//! Columns of a CSV file by their names.

/// What the columns before the joints hold, in the order of a row.
const BASE: [&str; 7] = [
    "position x",
    "position y",
    "position z",
    "quaternion x",
    "quaternion y",
    "quaternion z",
    "quaternion w",
];

/// For each number of a row (position x, y, z, quaternion x, y, z, w, joints in the order of `joints`) the column that holds it.
///
/// # Errors
/// What was expected and what was found: a name that means nothing here, a column that is missing, one that is there twice.
pub(crate) fn columns(names: &[&str], joints: &[String]) -> Result<Vec<usize>, (String, String)> {
    let mut places = vec![None; BASE.len() + joints.len()];
    for (column, name) in names.iter().enumerate() {
        let joint = joints.iter().position(|joint| joint == name).map(|j| BASE.len() + j);
        let Some(place) = joint.or_else(|| base_place(name)) else {
            let expected = "names of position (pos_x), quaternion (quat_w) and the robot's joints";
            return Err((expected.to_owned(), format!("'{name}' in column {}", column + 1)));
        };
        if let Some(first) = places[place].replace(column) {
            let found = format!("'{}' and '{name}'", names[first]);
            return Err(("one column a quantity".to_owned(), found));
        }
    }
    let all = |place: usize| places[place].ok_or_else(|| what(place, joints));
    (0..places.len())
        .map(all)
        .collect::<Result<_, _>>()
        .map_err(|missing| (format!("a column for {missing}"), format!("{} columns without it", names.len())))
}

fn what(place: usize, joints: &[String]) -> String {
    BASE.get(place).map_or_else(|| format!("'{}'", joints[place - BASE.len()]), |name| (*name).to_owned())
}

/// The place in [`BASE`] of a name such as `pos_x`, `root_translateX`, `qw`, `quat_w`, `base_rot_z` or `x`.
fn base_place(name: &str) -> Option<usize> {
    let name = name.split(['[', '(']).next()?.trim().trim_matches(['"', '\'']).to_lowercase();
    let axis = name.chars().last()?;
    let stem = name[..name.len() - axis.len_utf8()].trim_end_matches(['_', '.', ' ', '-']);
    let has = |words: &[&str]| words.iter().any(|word| stem.contains(word));
    let number = "xyzw".find(axis)?;
    if has(&["quat", "rot", "orient"]) || stem == "q" || stem.ends_with("_q") {
        Some(3 + number)
    } else if number < 3
        && (has(&["pos", "trans", "loc"]) || matches!(stem, "" | "p" | "t" | "root" | "base"))
    {
        Some(number)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints() -> Vec<String> {
        vec!["left_hip".to_owned(), "right_hip".to_owned()]
    }

    #[test]
    fn columns_are_found_by_name_in_any_order() {
        let names =
            ["pos_x", "pos_y", "pos_z", "quat_w", "quat_x", "quat_y", "quat_z", "right_hip", "left_hip"];
        assert_eq!(columns(&names, &joints()), Ok(vec![0, 1, 2, 4, 5, 6, 3, 8, 7]));
        let other =
            ["left_hip", "right_hip", "qx", "qy", "qz", "qw", "root_translateX", "root_translateY", "z [m]"];
        assert_eq!(columns(&other, &joints()), Ok(vec![6, 7, 8, 2, 3, 4, 5, 0, 1]));
    }

    #[test]
    fn a_name_that_means_nothing_and_a_missing_column_are_refused() {
        let names = ["x", "y", "z", "quat_0", "quat_1", "quat_2", "quat_3", "left_hip", "right_hip"];
        assert_eq!(columns(&names, &joints()).expect_err("refused").1, "'quat_0' in column 4");
        let euler = ["x", "y", "z", "rot_x", "rot_y", "rot_z", "left_hip", "right_hip"];
        assert_eq!(columns(&euler, &joints()).expect_err("refused").0, "a column for quaternion w");
        let twice = ["x", "pos_x", "z", "qx", "qy", "qz", "qw", "left_hip", "right_hip"];
        assert_eq!(columns(&twice, &joints()).expect_err("refused").1, "'x' and 'pos_x'");
    }
}
