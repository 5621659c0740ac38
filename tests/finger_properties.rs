//! Properties of any finger: forward then inverse, scaling, monotony, energy, an independent contact with radius.

mod finger_support;

use finger_support::{linkage2, linkage3, tendon2, tendon3, within};
use palpate::finger::{
    Class, Configuration, Contact, Finger, Mechanics, Parameters, Tendon, Transmission,
};
use palpate::sensing::location::{
    BranchSense, Cable, JointTwo, NoJointSensor, Rigid, Series, places,
};
use palpate::sensing::step;
use proptest::prelude::*;

/// A contact posture: torque as a share of the softest spring; rejects where there is none, as without a spring at joint 1.
fn preshaped<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
) -> Result<(Configuration<N>, f32), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let springs = finger.parameters().stiffness_nm_per_rad;
    let torque = share * springs.into_iter().fold(f32::INFINITY, f32::min);
    match finger.free_at_torque(torque, &finger.rest()) {
        Some(posture) => Ok((posture, torque)),
        None => Err(TestCaseError::reject("no posture")),
    }
}

/// Forward then inverse returns the place, by both solvers; every candidate presses and lies on its phalanx.
fn round_trip<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    phalanx: u8,
    at: f32,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(phalanx)
        .expect("it has that phalanx");
    let k_m = at * length;
    if finger
        .path(
            &posture,
            torque,
            Contact {
                phalanx,
                k_m,
                radius_m: 0.0,
            },
        )
        .is_none()
    {
        return Err(TestCaseError::reject("does not press there"));
    }
    let compliance = finger
        .contact_compliance(&posture, torque, phalanx, k_m)
        .expect("a contact that presses");
    let peak = finger
        .stiffest_m(&posture, torque, phalanx)
        .unwrap_or(f32::INFINITY);
    // Around the stiffest place of phalanx 3 and of an eliminated joint, C has a smooth minimum: k is only as good as
    // the root of the rounding there.
    let tolerance = if N == 3 && (k_m - peak).abs() < 0.05 * length {
        0.05
    } else {
        2e-3
    };
    for answer in [
        finger.locate(&posture, torque, compliance),
        finger.locate_closed(&posture, torque, compliance),
    ] {
        for candidate in answer.candidates() {
            let on = finger
                .phalanx_length_m(candidate.phalanx)
                .expect("a phalanx it has");
            prop_assert!(candidate.k_m > 0.0 && candidate.k_m <= on);
            let contact = Contact {
                phalanx: candidate.phalanx,
                k_m: candidate.k_m,
                radius_m: 0.0,
            };
            prop_assert!(
                finger.path(&posture, torque, contact).is_some(),
                "{candidate:?} does not press"
            );
            let again = finger
                .contact_compliance(&posture, torque, candidate.phalanx, candidate.k_m)
                .expect("a value");
            let proximal = finger
                .proximal_compliance(&posture, torque)
                .expect("a value");
            prop_assert!(
                (again - compliance).abs() <= 2e-5 * proximal.max(compliance),
                "{again} {compliance}"
            );
        }
        if answer.class() == Class::Proximal {
            continue;
        }
        let found = answer
            .candidates()
            .iter()
            .any(|c| c.phalanx == phalanx && (c.k_m - k_m).abs() <= tolerance * length);
        prop_assert!(found, "{k_m} on {phalanx} not in {answer:?}");
    }
    Ok(())
}

/// C falls from the joint to the stiffest place and rises beyond; C_prox at the joint; never above C_free.
fn monotone<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    phalanx: u8,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(phalanx)
        .expect("it has that phalanx");
    let peak = finger.stiffest_m(&posture, torque, phalanx);
    let proximal = finger
        .proximal_compliance(&posture, torque)
        .expect("stable");
    let mut before = None;
    for i in 1..=60u8 {
        let k_m = length * f32::from(i) / 60.0;
        if finger
            .path(
                &posture,
                torque,
                Contact {
                    phalanx,
                    k_m,
                    radius_m: 0.0,
                },
            )
            .is_none()
        {
            before = None;
            continue;
        }
        let c = finger
            .contact_compliance(&posture, torque, phalanx, k_m)
            .expect("it presses");
        if let Some(free) = finger.free_compliance(&posture, torque) {
            prop_assert!(c <= free * 1.00001, "{c} above the free finger's {free}");
        }
        if let (Some((k_before, c_before)), Some(peak)) = (before, peak) {
            let slack = 3e-6 * proximal;
            let falls: bool = k_m <= peak;
            let rises: bool = k_before >= peak;
            prop_assert!(
                !(falls && peak > 0.0) || c <= c_before + slack,
                "rises before {peak} at {k_m}"
            );
            prop_assert!(
                !(rises && peak > 0.0) || c >= c_before - slack,
                "falls beyond {peak} at {k_m}"
            );
        }
        before = Some((k_m, c));
    }
    Ok(())
}

/// The contact path does as much work at the input as the springs take up: friction there is none.
fn energy<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    contact: Contact,
    rise_share: f32,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    const PIECES: u16 = 64;
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(contact.phalanx)
        .expect("it has that phalanx");
    let contact = Contact {
        k_m: contact.k_m * length,
        radius_m: contact.radius_m * length,
        ..contact
    };
    let Some(mut path) = finger.path(&posture, torque, contact) else {
        return Err(TestCaseError::reject("does not press there"));
    };
    let springs = finger.parameters().stiffness_nm_per_rad;
    let rise = rise_share
        * springs
            .into_iter()
            .filter(|k| *k > 0.0)
            .fold(f32::INFINITY, f32::min);
    let (mut work, mut spring) = (0.0f64, 0.0f64);
    let (mut before, mut turned) = (f64::from(torque), 0.0f64);
    let mut end = None;
    for i in 1..=PIECES {
        let more = rise * f32::from(i) / f32::from(PIECES);
        let Some(point) = finger.follow(&mut path, more) else {
            break;
        };
        let now = f64::from(torque) + f64::from(more);
        work += 0.5 * (before + now) * (f64::from(point.rotation_rad) - turned);
        (before, turned) = (now, f64::from(point.rotation_rad));
        prop_assert!(point.k_now_m > 0.0 && point.k_now_m <= length && point.force_n >= 0.0);
        prop_assert!(point.compliance_rad_per_nm >= 0.0);
        end = Some(point);
    }
    let Some(end) = end else {
        return Err(TestCaseError::reject("slides off at once"));
    };
    let rests = finger.parameters().rest_rad;
    for (((angle, rest), stiffness), change) in posture
        .rad()
        .iter()
        .zip(rests)
        .zip(springs)
        .zip(end.joints_rad)
    {
        let (stretch, change) = (f64::from(*angle) - f64::from(rest), f64::from(change));
        spring += f64::from(stiffness) * change * (stretch + 0.5 * change);
    }
    let scale = work.abs().max(1e-4 * f64::from(rise) * f64::from(rise));
    prop_assert!(
        (work - spring).abs() <= 2e-3 * scale,
        "work {work:e}, springs {spring:e}"
    );
    Ok(())
}

/// The phalanx's line stays at its distance from the cylinder's centre, which stays where it was: plane geometry in f64.
fn touches<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let (posture, torque) = preshaped(finger, share)?;
    let on = usize::from(contact.phalanx);
    let length = finger.parameters().lengths_m[on - 1];
    let contact = Contact {
        k_m: contact.k_m * length,
        radius_m: contact.radius_m * length,
        ..contact
    };
    let Some(mut path) = finger.path(&posture, torque, contact) else {
        return Err(TestCaseError::reject("does not press there"));
    };
    let rise = 0.2 * finger.parameters().stiffness_nm_per_rad[N - 1];
    let Some(point) = finger.follow(&mut path, rise) else {
        return Err(TestCaseError::reject("slides off"));
    };
    // Centre of the cylinder for a contact at k: joint, along the phalanx, along its normal.
    let centre = |change: &dyn Fn(usize) -> f64, k: f64| {
        let (mut x, mut y, mut angle) = (0.0, 0.0, 0.0);
        for i in 0..on {
            angle += f64::from(posture.rad()[i]) + change(i);
            let along = if i + 1 == on {
                k
            } else {
                f64::from(finger.parameters().lengths_m[i])
            };
            x += along * angle.cos();
            y += along * angle.sin();
        }
        (
            x - f64::from(contact.radius_m) * angle.sin(),
            y + f64::from(contact.radius_m) * angle.cos(),
        )
    };
    let was = centre(&|_| 0.0, contact.k_m.into());
    let is = centre(&|i| point.joints_rad[i].into(), point.k_now_m.into());
    let off = (is.0 - was.0).hypot(is.1 - was.1);
    prop_assert!(
        off <= 2e-6 * f64::from(length + contact.radius_m),
        "the centre moved by {off:e}"
    );
    Ok(())
}

/// The derivatives of the rotation by place and radius are those that differences of whole paths tend to.
fn derivatives<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger.parameters().lengths_m[usize::from(contact.phalanx) - 1];
    let contact = Contact {
        k_m: contact.k_m * length,
        // Room for differences on both sides.
        radius_m: (contact.radius_m + 0.05) * length,
        ..contact
    };
    let rise = 0.2 * finger.parameters().stiffness_nm_per_rad[N - 1];
    // By way of a point between, as a fit follows it.
    let end = |contact: Contact| {
        let mut path = finger.path(&posture, torque, contact)?;
        finger.follow(&mut path, 0.4 * rise)?;
        finger.follow(&mut path, rise)
    };
    let rotation = |k: f32, radius: f32| {
        let moved = Contact {
            k_m: contact.k_m + k,
            radius_m: contact.radius_m + radius,
            ..contact
        };
        end(moved).map(|point| f64::from(point.rotation_rad))
    };
    let Some(point) = end(contact) else {
        return Err(TestCaseError::reject("does not press there or slides off"));
    };
    let largest = point.joints_rad.iter().fold(0.0f32, |m, x| m.max(x.abs()));
    for (told, along) in [
        (point.rotation_by_k_rad_per_m, (1.0, 0.0)),
        (point.rotation_by_radius_rad_per_m, (0.0, 1.0)),
    ] {
        let central = |step: f32| {
            let there = rotation(along.0 * step, along.1 * step)?;
            let back = rotation(-along.0 * step, -along.1 * step)?;
            Some((there - back) / (2.0 * f64::from(step)))
        };
        let step = 0.02 * length;
        let (Some(wide), Some(narrow)) = (central(step), central(0.5 * step)) else {
            return Err(TestCaseError::reject("slides off beside it"));
        };
        let limit = (4.0 * narrow - wide) / 3.0;
        let rounding = 4e-6 * f64::from(largest / step);
        let off = (f64::from(told) - limit).abs();
        prop_assert!(
            off <= (narrow - wide).abs() + 1e-3 * limit.abs() + rounding,
            "{told} for {limit}, from {wide} and {narrow}, {contact:?}"
        );
    }
    Ok(())
}

/// A step made by the path is located by the estimator, with radius and cable.
fn step_round_trip<const N: usize, T>(
    finger: &Finger<N, T>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError>
where
    T: Transmission<N>,
    Finger<N, T>: Mechanics<Configuration = Configuration<N>>,
{
    let (posture, torque) = preshaped(finger, share)?;
    let length = finger
        .phalanx_length_m(contact.phalanx)
        .expect("it has that phalanx");
    let contact = Contact {
        k_m: contact.k_m * length,
        radius_m: contact.radius_m * length,
        ..contact
    };
    let peak = finger
        .stiffest_m(&posture, torque, contact.phalanx)
        .unwrap_or(f32::INFINITY);
    // There the rotation has its minimum over k: rounding decides whether the measured one is reached at all.
    if (contact.k_m - peak).abs() < if N == 3 { 0.1 } else { 0.02 } * length {
        return Err(TestCaseError::reject("the stiffest place"));
    }
    let Some(mut path) = finger.path(&posture, torque, contact) else {
        return Err(TestCaseError::reject("does not press there"));
    };
    let rise_nm = 0.15 * finger.parameters().stiffness_nm_per_rad[N - 1];
    let Some(point) = finger.follow(&mut path, rise_nm) else {
        return Err(TestCaseError::reject("slides off"));
    };
    let cable = Cable::new(4.0).expect("in range");
    let rotation_rad = point.rotation_rad + rise_nm * cable.compliance_rad_per_nm();
    let measured = step::Measured {
        rise_nm,
        rotation_rad,
        radius_m: contact.radius_m,
    };
    let found = step::places(finger, &posture, torque, &measured, &cable, &NoJointSensor);
    let near = |k: f32| (k - contact.k_m).abs() <= 2e-3 * length;
    prop_assert!(
        found
            .iter()
            .any(|c| c.phalanx == contact.phalanx && near(c.k_m)),
        "{contact:?} not in {found:?}"
    );
    Ok(())
}

fn contact_on(phalanges: u8) -> impl Strategy<Value = Contact> {
    (
        2..=phalanges,
        within(0.05, 0.95),
        prop_oneof![Just(0.0f32), within(0.02, 0.4)],
    )
        .prop_map(|(phalanx, k_m, radius_m)| Contact {
            phalanx,
            k_m,
            radius_m,
        })
}

macro_rules! properties {
    ($($module:ident: $finger:expr, $phalanges:expr;)*) => { $(mod $module {
        use super::*;
        proptest! {
            #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

            #[test]
            fn forward_then_inverse(f in $finger, share in within(0.0, 0.5), phalanx in 2..=$phalanges, at in within(0.02, 0.98)) {
                round_trip(&f, share, phalanx, at)?;
            }

            #[test]
            fn compliance_is_monotone_on_either_side(f in $finger, share in within(0.0, 0.5), phalanx in 2..=$phalanges) {
                monotone(&f, share, phalanx)?;
            }

            #[test]
            fn work_becomes_spring_energy(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                energy(&f, share, contact, 0.3)?;
            }

            #[test]
            fn the_cylinder_stays_where_it_is(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                touches(&f, share, contact)?;
            }

            #[test]
            fn derivatives_are_limits_of_differences(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                derivatives(&f, share, contact)?;
            }

            #[test]
            fn a_step_is_located(f in $finger, share in within(0.0, 0.5), contact in contact_on($phalanges)) {
                step_round_trip(&f, share, contact)?;
            }
        }
    })* };
}

properties! {
    two_tendon: tendon2(), 2u8;
    two_linkage: linkage2(), 2u8;
    three_tendon: tendon3(), 3u8;
    three_linkage: linkage3(), 3u8;
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Lengths in other units and springs in other units give the same finger.
    #[test]
    fn units_do_not_matter(f in linkage2(), share in within(0.0, 0.5), at in within(0.1, 0.9), metre in -9i32..9, newton in -5i32..5) {
        let (metre, torque_unit) = (2.0f32.powi(metre), 4.0f32.powi(newton));
        let p = *f.parameters();
        let levers = f.transmission().stages()[0].levers();
        let scaled = palpate::finger::Levers {
            driving_m: levers.driving_m * metre,
            coupler_m: levers.coupler_m * metre,
            driven_m: levers.driven_m * metre,
            ..levers
        };
        let other = Finger::<2, palpate::finger::Linkage<1>>::new(
            Parameters {
                lengths_m: p.lengths_m.map(|l| l * metre),
                stiffness_nm_per_rad: p.stiffness_nm_per_rad.map(|k| k * torque_unit),
                ..p
            },
            [scaled],
        ).expect("the same finger in other units");
        let (here, torque) = preshaped(&f, share)?;
        let (there, torque_there) = preshaped(&other, share)?;
        let k = at * p.lengths_m[1];
        let c = f.contact_compliance(&here, torque, 2, k).expect("stable");
        let c_there = other.contact_compliance(&there, torque_there, 2, k * metre).expect("stable");
        // Powers of two change no digit, nor do powers of four under the root.
        prop_assert_eq!(c, c_there * torque_unit);
        let places = f.locate(&here, torque, c);
        let places_there = other.locate(&there, torque_there, c_there);
        prop_assert_eq!(places.class(), places_there.class());
        for (a, b) in places.candidates().iter().zip(places_there.candidates()) {
            prop_assert_eq!(a.k_m * metre, b.k_m);
        }
    }

    /// The free finger found by its input angle is the one found by its torque.
    #[test]
    fn angle_and_torque_agree(f in linkage3(), share in within(0.0, 0.5)) {
        let (at, torque) = preshaped(&f, share)?;
        let free = f.free_at_angle(f.input_angle_rad(&at), &f.rest()).expect("a posture it just had");
        let scale = f.parameters().stiffness_nm_per_rad[2];
        prop_assert!((free.torque_nm - torque).abs() <= 3e-6 * scale, "{} {torque}", free.torque_nm);
    }

    /// A cable in series is taken off, and theta_2's sign leaves the right side of e_2.
    #[test]
    fn cable_and_joint_sensor(f in tendon2(), at in within(0.05, 0.95), stiffness in within(0.5, 50.0)) {
        let posture = f.rest();
        let k = at * f.parameters().lengths_m[1];
        let cable = Cable::new(stiffness).expect("in range");
        let c = f.contact_compliance(&posture, 0.0, 2, k).expect("stable");
        let peak = f.stiffest_m(&posture, 0.0, 2).unwrap_or(f32::INFINITY);
        if c < 1e-4 * cable.compliance_rad_per_nm() {
            return Err(TestCaseError::reject("the cable is all that is measured"));
        }
        let change_rad = if k > peak { -0.01 } else { 0.01 };
        let sense = JointTwo { change_rad, noise_rad: 0.003 };
        let answer = places(&f, &posture, 0.0, c + cable.compliance_rad_per_nm(), &cable, &sense);
        prop_assert_eq!(answer.candidates().len(), 1);
        let found = answer.candidates()[0];
        prop_assert_eq!(found.beyond_stiffest, k > peak);
        prop_assert!((found.k_m - k).abs() <= 2e-2 * f.parameters().lengths_m[1], "{} {k}", found.k_m);
        let silent = JointTwo { change_rad, noise_rad: 0.02 };
        prop_assert!(found.phalanx == 2 && silent.allows(&found) && NoJointSensor.allows(&found));
        prop_assert_eq!(core::mem::size_of_val(&(Rigid, NoJointSensor)), 0);
    }
}

/// Table I of the paper: K_a = 0.519630 for its three-phalanx tendon finger (7).
#[test]
fn the_papers_k_a() {
    let rest = [core::f32::consts::FRAC_PI_6; 3];
    let finger = Finger::<3, Tendon<3>>::new(
        Parameters {
            lengths_m: [1.0, 0.75, 0.5],
            stiffness_nm_per_rad: [1.0; 3],
            rest_rad: rest,
            range_rad: [[0.0, 3.0]; 3],
        },
        [0.1, 0.08, 0.06, 0.04],
    )
    .expect("Table I");
    let free = finger
        .free_at_angle(2.5, &finger.rest())
        .expect("within its stops");
    let k_a = finger.expected_k_a(&free).expect("it has springs");
    assert!((k_a - 0.519_630).abs() < 1e-6, "{k_a}");
}
