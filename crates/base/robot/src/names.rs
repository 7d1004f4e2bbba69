//! Suggestions for misspelled names.

/// The candidate that differs least from `name`, if it is near enough to be a likely typing error.
///
/// ```
/// assert_eq!(paid_robot::names::nearest("left_kne", &["left_knee", "waist"]), Some("left_knee"));
/// ```
pub fn nearest<'a, S: AsRef<str>>(name: &str, candidates: &'a [S]) -> Option<&'a str> {
    let best = candidates
        .iter()
        .map(|c| (strsim::levenshtein(name, c.as_ref()), c.as_ref()))
        .min_by_key(|(d, _)| *d)?;
    (best.0 <= (name.chars().count() / 2).max(1)).then_some(best.1)
}

/// " (did you mean 'x'?)", or nothing.
pub(crate) fn hint<S: AsRef<str>>(name: &str, candidates: &[S]) -> String {
    nearest(name, candidates).map_or_else(String::new, |n| format!(" (did you mean '{n}'?)"))
}

/// True if `name` matches `pattern`, in which each `*` stands for any characters, also none.
pub(crate) fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(rest) = name.strip_prefix(parts.next().unwrap_or("")) else { return false };
    let mut rest = rest;
    let mut tail = None;
    for part in parts {
        if let Some(middle) = tail.replace(part) {
            let Some(at) = str::find(rest, middle) else { return false };
            rest = &rest[at + middle.len()..];
        }
    }
    tail.map_or(rest.is_empty(), |tail| rest.ends_with(tail))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_a_strange_one_is_not() {
        let names = ["left_knee_joint", "right_knee_joint", "waist_yaw_joint"];
        assert_eq!(nearest("left_kne_joint", &names), Some("left_knee_joint"));
        assert_eq!(nearest("xyz", &names), None);
    }

    #[test]
    fn a_star_stands_for_any_characters() {
        assert!(matches("*_knee_joint", "left_knee_joint"));
        assert!(matches("left_*", "left_knee_joint"));
        assert!(matches("*_hip_*_joint", "left_hip_yaw_joint"));
        assert!(matches("*", "x"));
        assert!(matches("a*a", "aa"));
        assert!(!matches("a*a", "a"));
        assert!(!matches("left_knee", "left_knee_joint"));
        assert!(!matches("*_hip_*_yaw", "left_hip_yaw_joint"));
        assert!(!matches("*knee", "left_knee_joint"));
    }
}
