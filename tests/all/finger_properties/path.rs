//! Properties of the contact path: energy, an independent contact with radius, derivatives.

use palpate::finger::Contact;
use proptest::prelude::*;

use super::setup::{AnyFinger, Pressed, pressed, risen};

/// The contact path does as much work at the input as the springs take up: friction there is none.
pub fn energy<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    contact: Contact,
    rise_share: f32,
) -> Result<(), TestCaseError> {
    const PIECES: u16 = 64;
    let Pressed {
        posture,
        torque_nm: torque,
        length_m: length,
        mut path,
        ..
    } = pressed(finger, share, contact)?;
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
pub fn touches<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError> {
    let (start, _, point) = risen(finger, share, contact, 0.2)?;
    let (posture, length, contact) = (start.posture, start.length_m, start.contact);
    let on = usize::from(contact.phalanx);
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
pub fn derivatives<const N: usize>(
    finger: &impl AnyFinger<N>,
    share: f32,
    contact: Contact,
) -> Result<(), TestCaseError> {
    let contact = Contact {
        // Room for differences on both sides.
        radius_m: contact.radius_m + 0.05,
        ..contact
    };
    let Pressed {
        posture,
        torque_nm: torque,
        length_m: length,
        contact,
        ..
    } = pressed(finger, share, contact)?;
    let rise = 0.2 * finger.parameters().stiffness_nm_per_rad[N - 1];
    // By way of a point between, as a fit follows it.
    let end = |contact: Contact| {
        let mut path = finger.path(&posture, torque, contact)?;
        finger.follow(&mut path, 0.4 * rise)?;
        finger.follow(&mut path, rise)
    };
    let rotation = |k: f32| {
        let moved = Contact {
            k_m: contact.k_m + k,
            ..contact
        };
        end(moved).map(|point| f64::from(point.rotation_rad))
    };
    let Some(point) = end(contact) else {
        return Err(TestCaseError::reject("does not press there or slides off"));
    };
    let largest = point.joints_rad.iter().fold(0.0f32, |m, x| m.max(x.abs()));
    let central = |step: f32| Some((rotation(step)? - rotation(-step)?) / (2.0 * f64::from(step)));
    // The step is small against the length and against the distance from the joint, on whose scale the rotation changes near it.
    let step = (0.02 * length).min(0.1 * contact.k_m);
    let (Some(wide), Some(narrow)) = (central(step), central(0.5 * step)) else {
        return Err(TestCaseError::reject("slides off beside it"));
    };
    let told = point.rotation_by_k_rad_per_m;
    let limit = (4.0 * narrow - wide) / 3.0;
    let rounding = 4e-6 * f64::from(largest / step);
    let off = (f64::from(told) - limit).abs();
    prop_assert!(
        off <= (narrow - wide).abs() + 1e-3 * limit.abs() + rounding,
        "{told} for {limit}, from {wide} and {narrow}, {contact:?}"
    );
    Ok(())
}
