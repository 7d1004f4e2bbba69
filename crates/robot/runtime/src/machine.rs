//! Which G1 it is, by the `mode_machine` in its states (the vendor's description of the G1, read 2026-11-28).

/// The G1 that the robot's files describe.
pub const MODE_MACHINE_G1: u8 = 5;
/// The robots that a policy can move: 29 joints and a free waist. `configs/robots/g1.toml` has what differs between them.
pub const KNOWN: [u8; 5] = [MODE_MACHINE_G1, 11, 13, 15, 18];

/// [`KNOWN`] in words.
pub(crate) const EXPECTED: &str = "5, 11, 13, 15 or 18 (a G1 with 29 joints and a free waist)";

/// What the robot is.
pub(crate) fn words(mode_machine: u8) -> &'static str {
    match mode_machine {
        MODE_MACHINE_G1 => "a G1 with 29 joints",
        11 => "a G1 with 29 joints, hip pitch with the gear of 22.5",
        13 => "a G1 with 29 joints, wrists with the motor 5010",
        15 => "a G1 with 29 joints, hip pitch with the gear of 22.5, wrists with the motor 5010",
        18 => "a G1 with 29 joints and a head of two, which stays as it is",
        1 | 4 | 10 => "a G1 with 23 joints, which lacks joints that the policy moves",
        3 | 6 | 12 | 14 | 16 => {
            "a G1 whose waist is locked, so that it cannot turn and lean as the policy asks; unlock it as the vendor describes"
        }
        2 => "a prototype of the G1 with 29 joints, whose motors are not known here",
        9 => "the two arms of a G1 alone",
        _ => "another robot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_robot::RobotSpec;

    #[test]
    fn the_known_robots_are_those_of_the_robots_file_and_a_refused_one_is_named() {
        assert_eq!(RobotSpec::g1().mode_machines, KNOWN);
        for known in KNOWN {
            assert!(words(known).starts_with("a G1 with 29 joints") && EXPECTED.contains(&known.to_string()));
        }
        assert!(words(12).contains("waist is locked") && words(10).contains("23 joints"));
    }
}
