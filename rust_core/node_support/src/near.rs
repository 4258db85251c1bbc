//! Names that a user may have meant.

/// Names in an answer that lists them.
const MAX_NAMES: usize = 3;

/// The names that are most like `name`: almost spelt so, or with it as a part.
pub fn near<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    let distance = |other: &str| {
        let other = other.to_lowercase();
        // A single letter is a part of most names.
        let is_part = other.contains(&wanted) || (wanted.contains(&other) && 2 * other.len() >= wanted.len());
        if is_part {
            1
        } else {
            strsim::osa_distance(&wanted, &other)
        }
    };
    let mut near: Vec<&str> = names.into_iter().filter(|other| distance(other) <= name.len().div_ceil(3)).collect();
    near.sort_by_key(|other| distance(other));
    near.truncate(MAX_NAMES);
    near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_almost_spelt_so_or_longer() {
        let frames = ["base_link", "torso_lift_link", "head_pan_link", "map"];
        assert_eq!(near("torso_lft_link", frames), ["torso_lift_link"]);
        assert_eq!(near("torso_lift", frames), ["torso_lift_link"]);
        assert_eq!(near("gripper", frames), [""; 0]);
        assert_eq!(near("Mpa", frames), ["map"]);
        assert_eq!(near("lidar_link", ["a", "l"]), [""; 0]);
    }
}
