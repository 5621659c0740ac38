//! Random fingers that can be built, in the manner of the reference files.

use palpate::finger::{Assembly, Direct, Finger, Levers, Linkage, Parameters, ReturnCable, Tendon};
use proptest::prelude::*;

/// Stops wide enough for any posture here.
const STOPS: [f32; 2] = [-3.0, 3.0];

/// Numbers evenly spread over a range. (proptest's own float ranges sometimes fail an assertion of theirs.)
pub fn within(low: f32, high: f32) -> impl Strategy<Value = f32> + Clone {
    (0..=u16::MAX).prop_map(move |i| low + (high - low) * (f32::from(i) / f32::from(u16::MAX)))
}

fn parameters<const N: usize>(
    lengths: [f32; N],
    stiffness: [f32; N],
    rest: [f32; N],
    stops: [f32; 2],
) -> Parameters<N> {
    Parameters {
        lengths_m: lengths,
        stiffness_nm_per_rad: stiffness,
        rest_rad: rest,
        range_rad: [stops; N],
    }
}

/// Stiffnesses; every fourth finger has no spring at joint 1.
fn stiffness<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    (prop::array::uniform::<_, N>(within(0.3, 2.0)), 0..4u8).prop_map(|(mut k, springless)| {
        if springless == 0 {
            k[0] = 0.0;
        }
        k
    })
}

/// A finger of two phalanges with tendon.
pub fn tendon2() -> impl Strategy<Value = Finger<2, Tendon<2>>> {
    (
        prop::array::uniform2(within(0.4, 1.4)),
        stiffness(),
        prop::array::uniform2(within(0.05, 0.7)),
        within(0.3, 0.9),
    )
        .prop_map(|(l, k, rest, ratio)| {
            Finger::new(parameters(l, k, rest, STOPS), [0.1, 0.1 * ratio]).expect("in range")
        })
}

/// A finger that a return cable opens.
pub fn return2() -> impl Strategy<Value = Finger<2, Tendon<2>, ReturnCable>> {
    (
        prop::array::uniform2(within(0.4, 1.4)),
        prop::array::uniform3(within(0.1, 1.0)),
        within(0.3, 0.9),
    )
        .prop_map(|(l, [more, torque_nm, stiffness_nm_per_rad], closing)| {
            let parameters = parameters(l, [0.0; 2], [0.0; 2], [0.0, 2.5]);
            let cable = ReturnCable {
                ratio: closing + more,
                torque_nm,
                stiffness_nm_per_rad,
            };
            Finger::returned(parameters, [0.1, 0.1 * closing], cable).expect("in range")
        })
}

/// A finger with a motor at every joint, as the first one sees it.
pub fn direct<const N: usize>() -> impl Strategy<Value = Finger<N, Direct<N>>> {
    (
        prop::array::uniform::<_, N>(within(0.4, 1.4)),
        stiffness(),
        prop::array::uniform::<_, N>(within(0.05, 0.7)),
    )
        .prop_map(|(l, k, rest)| Finger::new(parameters(l, k, rest, STOPS), ()).expect("in range"))
}

/// A finger of three phalanges with tendon.
pub fn tendon3() -> impl Strategy<Value = Finger<3, Tendon<3>>> {
    (
        prop::array::uniform3(within(0.4, 1.4)),
        stiffness(),
        prop::array::uniform3(within(0.05, 0.5)),
        within(0.4, 0.9),
        within(0.4, 0.9),
    )
        .prop_map(|(l, k, rest, r2, r4)| {
            Finger::new(
                parameters(l, k, rest, STOPS),
                [0.1, 0.1 * r2, 0.06, 0.06 * r4],
            )
            .expect("in range")
        })
}

fn levers(ground: f32, shape: [f32; 3], offset_rad: f32) -> Levers {
    let [a, b, c] = shape.map(|share| share * ground);
    Levers {
        driving_m: a,
        coupler_m: b,
        driven_m: c,
        offset_rad,
        assembly: Assembly::Clockwise,
    }
}

fn shape() -> impl Strategy<Value = [f32; 3]> {
    (within(0.55, 0.75), within(1.08, 1.2), within(0.28, 0.36)).prop_map(|(a, b, c)| [a, b, c])
}

/// A finger of two phalanges with linkage.
pub fn linkage2() -> impl Strategy<Value = Finger<2, Linkage<1>>> {
    (
        prop::array::uniform2(within(0.4, 1.4)),
        stiffness(),
        prop::array::uniform2(within(0.05, 0.7)),
        shape(),
        within(1.95, 2.2),
    )
        .prop_filter_map("does not close", |(l, k, rest, shape, psi)| {
            Finger::new(
                parameters(l, k, rest, [-0.6, 2.0]),
                [levers(l[0], shape, psi)],
            )
            .ok()
        })
}

/// A finger of three phalanges with linkage.
pub fn linkage3() -> impl Strategy<Value = Finger<3, Linkage<2>>> {
    let shapes = (shape(), shape(), within(1.95, 2.2), within(1.95, 2.2));
    (
        prop::array::uniform3(within(0.4, 1.4)),
        stiffness(),
        prop::array::uniform3(within(0.05, 0.4)),
        shapes,
    )
        .prop_filter_map("does not close", |(l, k, rest, (s1, s2, p1, p2))| {
            let design = [levers(l[0], s1, p1), levers(l[1], s2, p2)];
            Finger::new(parameters(l, k, rest, [-0.4, 1.2]), design).ok()
        })
}

/// Deviates of a normal distribution: sums of twelve uniform ones.
pub struct Noise(pub u64);

impl Noise {
    pub fn deviate(&mut self) -> f32 {
        let uniform = |_| {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..12).map(uniform).sum::<f32>() - 6.0
    }
}
