//! A scene with a wrong value stops the build with key, value and range: the reader is the one that the build scripts use.

mod support;

use std::path::PathBuf;

use support::scene;

/// A folder with the defaults, p70, tendon2 and one more scene.
fn folder(test: &str, own: &str) -> PathBuf {
    support::folder(test, &["p70", "tendon2"], own)
}

fn problem(test: &str, own: &str) -> String {
    let result = scene::load(&folder(test, own), "own");
    result.expect_err(own).to_string()
}

#[test]
fn a_value_out_of_range_is_named_with_its_range() {
    for (own, expected) in [
        (
            "motor.resistance_ohm = 1000",
            "`motor.resistance_ohm` = 1000 is out of range, allowed 0.1 to 500",
        ),
        // Together they would make 0.001 V of an ampere.
        (
            "sense.resistor_ohm = 10\nsense.mirror_a_per_a = 1e-4",
            "`sense.resistor_ohm` = 10 is out of range, allowed 100 to 10000000",
        ),
        (
            "motor.resistance_ohm = nan",
            "`motor.resistance_ohm` = NaN is out of range, allowed 0.1 to 500",
        ),
        (
            "finger.length_m = [0.09, 70]",
            "`finger.length_m[1]` = 70 is out of range, allowed 0.005 to 0.5",
        ),
        (
            "finger.length_m = [0.9, 0.07]",
            "`finger.length_m[0]` = 0.9 is out of range, allowed 0.005 to 0.5",
        ),
        (
            "finger.length_m = [0.09, 0.004]",
            "`finger.length_m[1]` = 0.004 is out of range, allowed 0.005 to 0.5",
        ),
        (
            "finger.spring_nm_per_rad = [0, 0]",
            "`finger.spring_nm_per_rad[1]` = 0 is out of range, allowed 0.000001 to 1000",
        ),
        (
            "finger.rest_deg = [-40, 0]",
            "`finger.rest_deg[0]` = -40 is out of range, allowed -30 to 150",
        ),
        (
            "finger.mass_kg = [0.009, 11]",
            "`finger.mass_kg[1]` = 11 is out of range, allowed 0 to 10",
        ),
        (
            "finger.mass_kg = [0.009]",
            "`finger.mass_kg` has 1 values, expected 2",
        ),
        (
            "finger.mounting_deg = 270",
            "`finger.mounting_deg` = 270 is out of range, allowed -180 to 180",
        ),
        (
            "finger.mass_kg = [0.009, 0.007]",
            "`finger.mounting_deg` is missing: `finger.mass_kg` and `finger.mounting_deg` belong together",
        ),
        ("finger.mounting_deg = 0", "`finger.mass_kg` is missing"),
        (
            "finger.mass_kg = [0.009, 0.007]\nfinger.mounting_deg = 0",
            "`finger.mass_kg` = [0.009, 0.007] is only possible with a spring at joint 1 or [return_cable]",
        ),
        // Ranges that depend on other values.
        (
            "limits.current_a = 0.21",
            "`limits.current_a` = 0.21 is out of range, allowed 0.001 to 0.2",
        ),
        (
            "limits.current_trip_a = 0.5",
            "`limits.current_trip_a` = 0.5 is out of range, allowed 0.001 to 0.461",
        ),
        (
            "motion.closing_rad_per_s = 0.9",
            "`motion.closing_rad_per_s` = 0.9 is out of range, allowed 0.02 to 0.8",
        ),
        (
            "limits.supply_max_v = 24",
            "`limits.supply_max_v` = 24 is out of range, allowed 9 to 18.333",
        ),
        (
            "travel.free_rad = 1.7",
            "`travel.free_rad` = 1.7 is out of range, allowed 0.01 to 1.58",
        ),
        (
            "hall = { fitted = true, max_rad = 2.8 }",
            "`hall.max_rad` = 2.8 is out of range, allowed -0.434 to 2.734",
        ),
        (
            // 0.1 ohm at 100 V/V: 165 mA either way.
            "shunt = { fitted = true, gain_v_per_v = 100 }",
            "`limits.current_trip_a` = 0.25 is out of range, allowed 0.001 to 0.15675",
        ),
        (
            "finger.hidden_base = true\noptions.second_contact = true",
            "`options.second_contact` = true is not possible with `finger.hidden_base`",
        ),
        (
            "finger.rest_deg = [0, -5]\noptions.contact_changes = true",
            "`options.contact_changes` = true is not possible with [return_cable] or a spring at rest beyond its stop",
        ),
        (
            "finger.rest_deg = [0, -5]\noptions.object_stiffness = true",
            "`options.object_stiffness` = true is not possible with [return_cable] or a spring at rest beyond its stop",
        ),
        (
            "options = { object_stiffness = true, second_contact = true }",
            "`options.second_contact` = true is not possible with `options.object_stiffness` = true",
        ),
        (
            "sensing.object_compliance_sigma_m_per_n = 0",
            "`sensing.object_compliance_sigma_m_per_n` = 0 is out of range, allowed 0.000001 to 1",
        ),
        (
            // Entered in mrad.
            "sensing.worm_error_rad = 2",
            "`sensing.worm_error_rad` = 2 is out of range, allowed 0 to 0.02",
        ),
        (
            "finger.joint_min_deg = [-30, 10]\nfinger.rest_deg = [0, -85]",
            "`finger.rest_deg[1]` = -85 is out of range, allowed -80 to 120",
        ),
        (
            "return_cable.tension_n = 3",
            "`return_cable.pulley_m` is missing: it has no default",
        ),
        (
            "return_cable = { pulley_m = [0.01, 0.01], tension_n = 3, stiffness_n_per_m = 200 }",
            "[return_cable] is only possible in a finger of two phalanges with [tendon]",
        ),
        (
            "sensing.leverage_sigma = 0.05",
            "`sensing.leverage_sigma` = 0.05 must be 0 with [direct], and with [linkage] in a finger of two phalanges",
        ),
        (
            "finger.hidden_base = 1",
            "`finger.hidden_base` = 1 must be true or false",
        ),
        (
            "finger.spring_nm_per_rad = [0.02, 0.05]",
            "`sensing.preload_nm` = 0.0004 must be 0 where joint 1 has a spring",
        ),
        (
            "finger.spring_nm_per_rad = [0.02, 0.05]\nsensing.preload_nm = 0.0",
            "`sensing.preload_sigma_nm` = 0.0004 must be 0 where joint 1 has a spring",
        ),
        (
            "finger.rest_deg = [0, 5]",
            "`sensing.preload_nm` = 0.0004 must be 0 where joint 1 has a spring or the finger a return cable, or a joint rests above `finger.joint_min_deg`",
        ),
        (
            "limits = { supply_min_v = 20, supply_max_v = 28 }",
            "`limits.supply_max_v` = 28 is out of range, allowed 20 to 18.333: `limits.supply_min_v` to `sense.reference_v` / \
             `supply.divider`",
        ),
        (
            "motor.torque_constant_nm_per_a = 0.1",
            "`motion.closing_rad_per_s` = 0.3 is out of range, allowed 0 to 0.093047: of `limits.duty` x `limits.supply_max_v` = \
             14.25 V, `motion.free_current_a` takes 2.34 V through `motor.resistance_ohm`; the rest turns a motor of this \
             `motor.torque_constant_nm_per_a` no faster",
        ),
        (
            "motor.resistance_ohm = 400",
            "`motion.closing_rad_per_s` = 0.3 is out of range, allowed 0 to 0: of `limits.duty` x",
        ),
        (
            "motor.torque_constant_nm_per_a = 1e-3",
            "`sensing.probe_torque_nm` = 0.35 is out of range",
        ),
    ] {
        let problem = problem("ranges", &format!("base = \"p70\"\ntitle = \"own\"\n{own}"));
        assert!(problem.starts_with("scene 'own': "), "{problem}");
        assert!(problem.contains(expected), "{own}: {problem}");
    }
}

#[test]
fn a_linkage_that_does_not_close_names_the_link() {
    let problem = problem(
        "open",
        "base = \"p70\"\ntitle = \"own\"\nlinkage.coupler_m = [0.2]",
    );
    assert!(
        problem.contains("linkage 1 does not close at theta_2 = 0 deg"),
        "{problem}"
    );
    assert!(
        problem
            .contains("`linkage.coupler_m[0]` = 0.2 is out of range, allowed 0.019373 to 0.13937"),
        "{problem}"
    );
}

#[test]
fn what_is_not_a_key_or_not_a_number_is_told() {
    let told = |own: &str| problem("keys", &format!("base = \"p70\"\ntitle = \"own\"\n{own}"));
    let unknown = told("motor.resistence_ohm = 3");
    assert!(
        unknown.contains("unknown key `motor.resistence_ohm`; [motor] has: "),
        "{unknown}"
    );
    assert!(
        unknown.contains("motor.resistance_ohm") || unknown.contains("resistance_ohm"),
        "{unknown}"
    );
    let unknown = told("moter.resistance_ohm = 3");
    assert!(
        unknown.contains("unknown section [moter]; there are: finger, "),
        "{unknown}"
    );
    assert!(told("motor.resistance_ohm = \"big\"").contains("must be a number from 0.1 to 500"));
    assert!(
        told("finger.length_m = [0.09]")
            .contains("`finger.length_m` has 1 numbers, expected 2 or 3")
    );
    assert!(
        told("finger.length_m = 0.09")
            .contains("`finger.length_m` = 0.09 must be a list of 2 or 3 numbers")
    );
    let none = problem("none", "title = \"own\"\n[finger]\nrest_deg = [0, 0]");
    assert!(none.contains("`finger.length_m` is missing"), "{none}");
    assert!(
        told("linkage.assembly = [\"up\"]").contains("must be one of: clockwise, counterclockwise")
    );
    assert!(
        told("tendon = { pulley_m = [0.009, 0.0072] }\nlinkage = {}").contains("one transmission")
    );
    assert!(
        told("direct = { backlash_deg = [0.3, 0.3] }")
            .contains("`direct.backlash_deg` has 2 values, expected 1")
    );
    assert_eq!(
        problem("base", "base = \"nothing\""),
        "scene 'own': `base` = \"nothing\" is no scene; there are: p70, tendon2"
    );
    assert!(problem("circle", "base = \"own\"\ntitle = \"own\"").contains("circle"));
    let bare = problem(
        "bare",
        "title = \"own\"\n[finger]\nlength_m = [0.08, 0.06]\n[tendon]\npulley_m = [0.009, 0.0072]",
    );
    assert!(
        bare.contains("`finger.spring_nm_per_rad` is missing"),
        "{bare}"
    );
}

/// Cargo shows the first line of what a build script says, and the file may be a copy that its user does not know.
#[test]
fn what_is_no_toml_is_explained_in_one_line_without_the_copys_path() {
    let told = problem(
        "syntax",
        "base = \"p70\"\n[finger\nlength_m = [0.08, 0.06]\n",
    );
    assert!(
        told.starts_with("scene 'own': TOML parse error at line 2, column 8: unclosed table"),
        "{told}"
    );
    assert_eq!(told.lines().count(), 1, "{told}");
}

#[test]
fn a_finger_of_ones_own_takes_base_and_defaults() {
    let own = "base = \"p70\"\ntitle = \"own\"\nfinger.length_m = [0.08, 0.06]\n[linkage]\ndriving_m = [0.05]\ncoupler_m = [0.09]\n";
    let scene = scene::load(&folder("own", own), "own").expect("a valid scene");
    assert_eq!(scene.list("finger.length_m"), [0.08, 0.06]);
    assert_eq!(scene.list("linkage.driven_m"), [0.030], "of the base");
    assert_eq!(scene.number("gearhead.ratio"), 64.0, "by default");
    let tendon = "base = \"p70\"\ntitle = \"own\"\n[tendon]\npulley_m = [0.009, 0.0072]\n";
    let scene = scene::load(&folder("tendon", tendon), "own").expect("a valid scene");
    assert!(scene.has("tendon") && !scene.has("linkage"));
    let direct = "base = \"tendon2\"\ntitle = \"own\"\n[direct]\nbacklash_deg = [0.3]\n[sensing]\nleverage_sigma = 0\n";
    let scene = scene::load(&folder("direct", direct), "own").expect("a valid scene");
    assert!(scene.has("direct") && !scene.has("tendon"));
}

#[test]
fn dimensions_change_with_what_a_stored_record_depends_on_and_with_nothing_else() {
    let of = |name: &str, own: &str| {
        let folder = folder(name, &format!("base = \"p70\"\n{own}"));
        scene::load(&folder, "own").expect(own).dimensions()
    };
    let p70 = of("dimensions", "");
    for own in [
        "finger.length_m = [0.09, 0.0701]",
        "finger.spring_nm_per_rad = [0.0, 0.08]",
        "finger.half_thickness_m = 0.007",
        "travel.free_rad = 1.25",
        "motor.torque_constant_nm_per_a = 9e-3",
        "motion.closing_rad_per_s = 0.31",
        "encoder.counts_per_rev = 512",
        "worm.efficiency = 0.46",
        "cable.fitted = false",
        "sense.resistor_ohm = 6700",
        "shunt.fitted = true",
        "sensing.pin_radius_m = 0.004",
        "sensing.torque_factor = 0.9",
        "sensing.torque_factor_sigma = 0.1",
        "sensing.cable_sigma_rad_per_nm = 0.1",
        "sensing.cable_stiffening_per_nm = 0.1",
        "sensing.cable_stiffening_sigma_per_nm = 0.1",
        "sensing.joint_friction_nm = 0.3e-3",
        "sensing.preload_nm = 0.5e-3",
    ] {
        assert_ne!(of("dimensions", own), p70, "{own}");
    }
    // Where joint 2 rests at 110 degrees either assembly closes it.
    let folded = "sensing = { preload_nm = 0, preload_sigma_nm = 0 }\nfinger.rest_deg = [0, 110]\nlinkage.assembly";
    let [clockwise, counterclockwise] = ["clockwise", "counterclockwise"]
        .map(|word| of("dimensions", &format!("{folded} = [\"{word}\"]")));
    assert_ne!(clockwise, counterclockwise);
    for own in [
        "gearhead.ratio = 64.0",
        "motion.hold_force_n = 2.0",
        "sensing.wanted_sigma_m = 0.5e-3",
        "limits.current_a = 0.125",
        "motor.ambient_c = 30",
    ] {
        assert_eq!(of("dimensions", own), p70, "{own}");
    }
}
