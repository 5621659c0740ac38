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

/// Asserts that each scene, laid over a base, is accepted.
fn accepted(test: &str, base: &str, cases: &[&str]) {
    for own in cases {
        let text = format!("base = \"{base}\"\ntitle = \"own\"\n{own}");
        support::scene::load(&support::folder(test, &[base], &text), "own").expect(own);
    }
}

#[test]
fn a_joint_that_its_own_motor_holds_must_be_able_to_open() {
    let why = "allowed -44 to 120: with [direct] a contact pushes joint 2 open, which cannot give way at its opening stop";
    refused(
        "held",
        "direct2",
        &[
            // Preloaded.
            ("finger.rest_deg = [0, -57]", why),
            ("finger.rest_deg = [0, -45]", why),
            (
                "finger.rest_deg = [0, -44.5]",
                "`finger.rest_deg[1]` = -44.5 is out of range",
            ),
        ],
    );
    accepted("held", "direct2", &["finger.rest_deg = [0, -44]"]);
}

#[test]
fn a_travel_beyond_a_joints_stop_names_the_joint() {
    let first = "joint 1 comes to `finger.joint_max_deg[0]` = 80 deg before the input link to its stop: `travel.stop_rad` = ";
    for (base, stop) in [("p70", "1.6"), ("direct2", "1.6"), ("return2", "1.8")] {
        let expected = format!("{first}{stop} is out of range, allowed 0 to 1.3963");
        let own = "finger.joint_max_deg = [80, 110]";
        refused("travel", base, &[(own, &expected)]);
    }
    // Both at their stops at once.
    accepted("travel", "p70", &["finger.joint_max_deg = [91.67, 120]"]);
    accepted(
        "travel",
        "p70",
        &["finger.joint_min_deg = [-30, 0]\nfinger.joint_max_deg = [92, 120]"],
    );
    refused(
        "travel",
        "p70",
        &[
            // It opens to its stop, not to zero.
            (
                "finger.joint_min_deg = [10, 0]\nfinger.rest_deg = [10, 0]\nfinger.joint_max_deg = [100, 120]",
                "`travel.stop_rad` = 1.6 is out of range, allowed 0 to 1.5708",
            ),
            (
                "travel = { stop_rad = 2.9, free_rad = 1.5 }",
                "`travel.stop_rad` = 2.9 is out of range, allowed 1.5 to 2.8",
            ),
        ],
    );
    // Springs share the travel out: half of 1 / 1.64 of it, less 0.1 for what the weight may do.
    for (base, own, expected) in [
        (
            "tendon2",
            "finger.joint_max_deg = [150, 80]",
            "joint 2 comes to `finger.joint_max_deg[1]` = 80 deg before the input link to its stop: `travel.stop_rad` = 2.2",
        ),
        (
            "linkage3",
            "finger.joint_max_deg = [60, 100, 100]",
            "joint 1 comes to `finger.joint_max_deg[0]` = 60 deg before the input link to its stop: `travel.stop_rad` = 1.8",
        ),
    ] {
        refused("travel", base, &[(own, expected)]);
    }
}

#[test]
fn springs_that_the_motor_cannot_close_are_told_with_both_torques() {
    // N mm for N m. 100 N m/rad at both joints of factors 1 and 0.8: 210 / 1.64.
    refused(
        "stiff",
        "tendon2",
        &[(
            "finger.spring_nm_per_rad = [100, 100]",
            "`finger.spring_nm_per_rad` = [100.0, 100.0] take 128",
        )],
    );
    refused(
        "stiff",
        "linkage3",
        &[(
            "finger.spring_nm_per_rad = [1, 1, 1]",
            "N m at `travel.free_rad` = 1.7: `motion.free_current_a` = 0.08 gives 0.2887 N m without friction",
        )],
    );
    // (35 + 200 x 0.017) N on 10 mm.
    refused(
        "stiff",
        "return2",
        &[(
            "return_cable.tension_n = 35",
            "[return_cable] takes 0.3840 N m at `travel.free_rad` = 1.7: `motion.free_current_a` = 0.08 gives 0.2887 N m",
        )],
    );
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

/// 0.6 V and 1 V/rad at 2.634 rad give 3.234 V, which is 3.2340002 in single precision: the firmware would not start.
#[test]
fn a_joint_sensor_is_refused_as_the_firmware_would() {
    refused(
        "hall",
        "tendon2",
        &[
            (
                "hall = { fitted = true, zero_v = 0.6, max_rad = 2.634 }",
                "`hall.max_rad` = 2.634 is out of range by a rounding: the sensor gives 3.2340002 V there, allowed 0.066 to 3.234 V in the firmware's single precision",
            ),
            (
                "hall = { fitted = true, min_rad = 0.9 }",
                "`hall.min_rad` = 0.9 is out of range, allowed -3.2 to 0.5236: joint 2 rests at 30 deg",
            ),
            (
                "hall = { fitted = true, max_rad = 0.5 }",
                "`hall.max_rad` = 0.5 is out of range, allowed 0.5236 to 3.2: joint 2 rests at 30 deg",
            ),
        ],
    );
}

/// A rounding less than the limit in double precision, a rounding more in the firmware's.
#[test]
fn ends_of_ranges_are_those_of_the_firmwares_arithmetic() {
    refused(
        "rounding",
        "tendon2",
        &[
            (
                "limits = { current_trip_a = 0.362, current_a = 0.2896 }",
                "`limits.current_a` = 0.2896 is out of range by a rounding, allowed 0.001 to 0.28959998 in the firmware's single precision",
            ),
            (
                "motion.rest_rad = 0.43\ntravel.free_rad = 0.48",
                "`travel.free_rad` = 0.48 is out of range by a rounding, allowed 0.48000002 to 2.8",
            ),
        ],
    );
    accepted(
        "rounding",
        "tendon2",
        &["limits = { current_trip_a = 0.3, current_a = 0.24 }"],
    );
}

#[test]
fn units_and_stops_by_mistake_are_told_with_what_they_must_be() {
    refused(
        "units",
        "tendon2",
        &[
            // Radians.
            (
                "finger.joint_min_deg = [-0.5, -0.5]\nfinger.joint_max_deg = [2.6, 2.1]\nfinger.rest_deg = [0.5, 0.5]",
                "`finger.joint_max_deg[0]` = 2.6 is out of range, allowed 4.5 to 180 degrees: the closing stop lies 5 or more above \
                 `finger.joint_min_deg[0]` = -0.5",
            ),
            // The stops' lists in each other's place.
            (
                "finger.joint_min_deg = [150, 120]\nfinger.joint_max_deg = [-30, -30]",
                "`finger.joint_max_deg[0]` = -30 is out of range, allowed 155 to 180 degrees: the closing stop",
            ),
            // Gram.
            (
                "finger.mass_kg = [9, 6.75]",
                "`finger.mass_kg[0]` = 9 is out of range, allowed 0 to 0.9: a phalanx has at most 10 kg/m",
            ),
            (
                "finger.spring_nm_per_rad = [0, 0]",
                "`finger.spring_nm_per_rad[1]` = 0 is out of range, allowed 0.000001 to 1000: only joint 1 may be without a spring",
            ),
            // Millimetre.
            (
                "tendon.pulley_m = [9, 7.2]",
                "`tendon.pulley_m[0]` = 9 is out of range, allowed 0.0001 to 1",
            ),
            (
                "finger.length_m = [-0.09, 0.0675]",
                "`finger.length_m[0]` = -0.09 is out of range, allowed 0.005 to 0.5",
            ),
        ],
    );
}

/// The path to the closing stop, the posture that everything counts from, and a lever's angle in radians: such a linkage closes as well.
#[test]
fn values_that_would_only_show_in_places_are_refused() {
    let stop = "is out of range, allowed 0.01 to 1.58: a free closing ends 0.02 or more before `travel.stop_rad` = 1.6";
    let radians = "is out of range, allowed 0, or -180 to 180 degrees but for those between -3.1416 and 3.1416: they are taken for radians";
    let opens = ": without a spring at joint 1 the finger opens to theta_1 = 0, or to its opening stop above that";
    refused(
        "shown",
        "p70",
        &[
            (
                "travel.free_rad = 1.6",
                &format!("`travel.free_rad` = 1.6 {stop}"),
            ),
            (
                "travel.free_rad = 1.59",
                &format!("`travel.free_rad` = 1.59 {stop}"),
            ),
            (
                "finger.rest_deg = [20, 0]",
                &format!("`finger.rest_deg[0]` = 20 is out of range, allowed 0 to 0{opens}"),
            ),
            (
                "finger.joint_min_deg = [10, 0]\nfinger.rest_deg = [20, 0]\nfinger.joint_max_deg = [110, 120]",
                &format!("`finger.rest_deg[0]` = 20 is out of range, allowed 10 to 10{opens}"),
            ),
            (
                "linkage.offset_deg = [2.0944]",
                &format!("`linkage.offset_deg[0]` = 2.0944 {radians}"),
            ),
            (
                "linkage.offset_deg = [-1.5]",
                &format!("`linkage.offset_deg[0]` = -1.5 {radians}"),
            ),
        ],
    );
    refused(
        "shown",
        "direct2",
        &[(
            "finger.rest_deg = [-10, 30]",
            "`finger.rest_deg[0]` = -10 is out of range, allowed 0 to 0",
        )],
    );
    refused(
        "shown",
        "linkage3",
        &[(
            "linkage.offset_deg = [120, 2.0944]",
            &format!("`linkage.offset_deg[1]` = 2.0944 {radians}"),
        )],
    );
    accepted("shown", "p70", &["travel.free_rad = 1.58"]);
    // A spring at joint 1 rests where it was built to.
    accepted("shown", "tendon2", &["finger.rest_deg = [20, 30]"]);
}

#[test]
fn what_is_in_the_wrong_place_is_told_with_its_own() {
    refused(
        "places",
        "tendon2",
        &[
            (
                "tension_n = 3.5",
                "unknown key `tension_n`, which belongs to [return_cable]; the sections are: ",
            ),
            (
                "tendon.length_m = [0.09, 0.0675]",
                "unknown key `tendon.length_m`, which belongs to [finger]; [tendon] has: pulley_m",
            ),
            (
                "finger.pulley_m = [0.009, 0.0072]",
                "unknown key `finger.pulley_m`, which belongs to [return_cable] or [tendon]; [finger] has: ",
            ),
            ("motor = 3", "`motor` = 3 must be a section, [motor]"),
            (
                "tendon.pulley_m = [0.009, 0.0072, 0.0054]",
                "`tendon.pulley_m` has 3 values, expected 2 in a finger of 2 phalanges",
            ),
        ],
    );
    let text = "base = \"tendon2\"\ntitle = \"\"\"two\nlines\"\"\"";
    let problem = support::scene::load(&support::folder("places", &["tendon2"], text), "own");
    let problem = problem.expect_err(text).to_string();
    assert!(problem.contains("must be a text of one line"), "{problem}");
    assert_eq!(problem.lines().count(), 1, "{problem}");
}
