//! A scene of a finger that could not work stops the build: what its keys, each within its range, are together.

mod support;

/// Asserts that each scene, laid over a base, is refused in one line that contains some words.
fn refused(test: &str, base: &str, cases: &[(&str, &str)]) {
    for (own, expected) in cases {
        let text = format!("base = \"{base}\"\ntitle = \"own\"\n{own}");
        let problem = support::scene::load(&support::folder(test, &[base], &text), "own")
            .expect_err(own)
            .to_string();
        assert!(problem.starts_with("scene 'own': "), "{problem}");
        assert!(problem.contains(expected), "{own}: {problem}");
        assert_eq!(problem.lines().count(), 1, "{problem}");
    }
}

#[test]
fn an_assembly_that_opens_a_joint_names_the_other_one() {
    refused(
        "assembly",
        "p70",
        &[
            (
                "linkage.assembly = [\"counterclockwise\"]",
                "linkage 1 opens joint 2 as the motor closes, at rest by F' = -0.601: `linkage.assembly[0]` = \"counterclockwise\" must be \
                 \"clockwise\"",
            ),
            (
                "linkage.offset_deg = [-120]",
                "linkage 1 opens joint 2 as the motor closes, at rest by F' = -0.601: `linkage.assembly[0]` = \"clockwise\" must be \
                 \"counterclockwise\"",
            ),
            (
                "linkage.offset_deg = [180]\nlinkage.coupler_m = [0.08]",
                "and as `linkage.assembly[0]` = \"counterclockwise\" too: `linkage.offset_deg[0]` = 180",
            ),
        ],
    );
    refused(
        "assembly",
        "linkage3",
        &[
            (
                "linkage.assembly = [\"counterclockwise\", \"clockwise\"]",
                "linkage 1 opens joint 2 as the motor closes, at rest by F' = -0.481: `linkage.assembly[0]`",
            ),
            (
                "linkage.assembly = [\"clockwise\", \"counterclockwise\"]",
                "linkage 2 opens joint 3 as the motor closes, at rest by F' = -0.489: `linkage.assembly[1]`",
            ),
        ],
    );
}

/// The compiler would say so too, without a key.
#[test]
fn a_linkage_must_close_where_its_angle_counts_from_and_off_dead_points() {
    refused(
        "zero",
        "p70",
        &[
            (
                "linkage.coupler_m = [0.14]\nfinger.joint_min_deg = [-30, 20]\nfinger.rest_deg = [0, 20]",
                "linkage 1 does not close at theta_2 = 0 deg, from where the input link's angle counts: `linkage.coupler_m[0]` = 0.14 is \
                 out of range, allowed 0.019373 to 0.13937",
            ),
            (
                "linkage.coupler_m = [0.13937]",
                "linkage 1 is at a dead point at theta_2 = 0 deg: `linkage.coupler_m[0]` = 0.13937 must stay off 0.019373 and 0.139373 by \
                 4.0e-6",
            ),
        ],
    );
}
