//! Three joints held by one contact on the third phalanx (docs/MECHANICS.md#contact-stiffness).
//!
//! With p the contact's moment arms and p x x a cross product, C = (p x x)^T H (p x x) / p^T adj(H) p; it also holds
//! without a spring at joint 1, where H has no inverse.

use super::quadratic::{Quadratic, QuadraticContact};
use super::two_joint::Roots;

/// The stiffness problem of a contact on phalanx 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeJointContact {
    /// Moment arm of joint 1 beyond that of joint 3: l_1 cos(theta_2 + theta_3) + l_2 cos theta_3, metre.
    pub d1_m: f32,
    /// Moment arm of joint 2 beyond that of joint 3: l_2 cos theta_3, metre.
    pub d2_m: f32,
    /// Transmission factor x_2.
    pub x2: f32,
    /// Transmission factor x_3.
    pub x3: f32,
    /// Stiffness K_1 = H_11; may be 0.
    pub k1: f32,
    /// H_22.
    pub h22: f32,
    /// H_23.
    pub h23: f32,
    /// H_33.
    pub h33: f32,
}

impl ThreeJointContact {
    /// u^T adj(H') v, over joints 2 and 3.
    fn adj(&self, u: [f32; 2], v: [f32; 2]) -> f32 {
        self.h33 * u[0] * v[0] - self.h23 * (u[0] * v[1] + u[1] * v[0]) + self.h22 * u[1] * v[1]
    }

    /// u^T H' v, over joints 2 and 3.
    fn form(&self, u: [f32; 2], v: [f32; 2]) -> f32 {
        self.h22 * u[0] * v[0] + self.h23 * (u[0] * v[1] + u[1] * v[0]) + self.h33 * u[1] * v[1]
    }

    /// det(H'), over joints 2 and 3; positive where the finger is stable.
    pub fn determinant(&self) -> f32 {
        self.h22 * self.h33 - self.h23 * self.h23
    }

    /// p x x at `k`: grouped so that k multiplies a difference of transmission factors.
    fn motion(&self, k: f32) -> [f32; 3] {
        let Self {
            d1_m: d1,
            d2_m: d2,
            x2,
            x3,
            ..
        } = *self;
        [
            d2 * x3 + k * (x3 - x2),
            k * (1.0 - x3) - d1 * x3,
            (d1 * x2 - d2) + k * (x2 - 1.0),
        ]
    }

    /// Compliance 1/K_c of a contact at `k_m` (18); `None` for values that do not give one.
    pub fn compliance(&self, k_m: f32) -> Option<f32> {
        QuadraticContact::compliance(self, k_m)
    }

    /// A closing finger presses at `k_m`: df/dT_a > 0 (docs/MECHANICS.md#contact-stiffness).
    pub fn presses(&self, k_m: f32) -> bool {
        QuadraticContact::presses(self, k_m)
    }

    /// Place of the stiffest contact on phalanx 3, the counterpart of e_2: the one stationary point of C(k) where a
    /// closing finger presses. It may lie off the phalanx; `None` where C(k) has none.
    pub fn stiffest_m(&self) -> Option<f32> {
        QuadraticContact::stiffest_m(self)
    }

    /// Both roots in closed form, whether on the phalanx or not, sorted by the side of the stiffest place.
    pub fn closed(&self, compliance: f32) -> Roots {
        QuadraticContact::closed(self, compliance)
    }

    /// Both roots on a phalanx of length `length_m` by bisection, one either side of the stiffest place: what the firmware
    /// asks.
    pub fn bisected(&self, compliance: f32, length_m: f32) -> Roots {
        QuadraticContact::bisected(self, compliance, length_m)
    }
}

impl QuadraticContact for ThreeJointContact {
    /// (p x x)^T H (p x x) at `k`.
    fn softness(&self, k: f32) -> f32 {
        let [v1, v2, v3] = self.motion(k);
        self.k1 * v1 * v1 + self.form([v2, v3], [v2, v3])
    }

    /// p^T adj(H) p at `k`.
    fn energy(&self, k: f32) -> f32 {
        let (p1, p) = (self.d1_m + k, [self.d2_m + k, k]);
        self.determinant() * p1 * p1 + self.k1 * self.adj(p, p)
    }

    /// p^T adj(H) x at `k`: positive where a closing finger presses (df/dT_a > 0).
    fn pressing(&self) -> [f32; 2] {
        let (x, m) = ([self.x2, self.x3], self.determinant());
        let at_joint = m * self.d1_m + self.k1 * self.adj([self.d2_m, 0.0], x);
        [at_joint, m + self.k1 * self.adj([1.0, 1.0], x)]
    }

    /// dC/dk = -(l0 + l1 k) times something positive wherever a closing finger presses.
    ///
    /// C_free - C = (p^T adj(H) x)^2 / (det(H) p^T adj(H) p) is the squared cosine between x and the line of p in the
    /// metric of H^-1: along a line it has one peak. K_1 is divided out, so that the limit K_1 = 0 stays.
    fn slope(&self) -> (f32, f32) {
        let (d1, x) = (self.d1_m, [self.x2, self.x3]);
        let (d, one) = ([self.d2_m, 0.0], [1.0, 1.0]);
        let away = [d[0] - d1, -d1];
        let m = self.determinant();
        let l0 = m * self.adj(away, [d[0] - d1 * x[0], -d1 * x[1]])
            + self.k1 * (self.adj(one, x) * self.adj(d, d) - self.adj(d, x) * self.adj(d, one));
        let l1 = m * self.adj(away, [1.0 - x[0], 1.0 - x[1]])
            + self.k1 * (self.adj(one, x) * self.adj(d, one) - self.adj(d, x) * self.adj(one, one));
        (l0, l1)
    }

    /// softness - C energy, expanded in k - `about`.
    fn residual(&self, compliance: f32, about: f32) -> Quadratic {
        let v0 = self.motion(about);
        let v1 = [self.x3 - self.x2, 1.0 - self.x3, self.x2 - 1.0];
        let (tail0, tail1) = ([v0[1], v0[2]], [v1[1], v1[2]]);
        let (p1, p, one) = (self.d1_m + about, [self.d2_m + about, about], [1.0, 1.0]);
        let (m, k1) = (self.determinant(), self.k1);
        [
            k1 * v0[0] * v0[0] + self.form(tail0, tail0)
                - compliance * (m * p1 * p1 + k1 * self.adj(p, p)),
            k1 * v0[0] * v1[0] + self.form(tail0, tail1)
                - compliance * (m * p1 + k1 * self.adj(p, one)),
            k1 * v1[0] * v1[0] + self.form(tail1, tail1)
                - compliance * (m + k1 * self.adj(one, one)),
        ]
    }
}
