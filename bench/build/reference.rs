//! All places on one phalanx where a contact shows a compliance, in f64, from the reduced data alone: the reference for
//! rows whose reduced data are rounded to f32. Checked against the 50-digit files while the rows are built.

/// Real roots of a + b k + c k^2 = 0 without cancellation.
fn quadratic([a, b, c]: [f64; 3]) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < -1e-13 * b * b {
        return Vec::new();
    }
    // A double root (C = 0 at the stiffest point) may come out a rounding below zero.
    let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    [q / c, a / q]
        .into_iter()
        .filter(|k| k.is_finite())
        .collect()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn form(m: &[[f64; 3]; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3)
        .map(|i| (0..3).map(|j| a[i] * m[i][j] * b[j]).sum::<f64>())
        .sum()
}

/// The posture and stiffness of a finger with three phalanges; one with two has a third that nothing moves.
pub struct Finger {
    /// Moment arms of a contact at the joint of its phalanx: p = d + k e.
    pub d: [f64; 3],
    /// 1 for the joints up to the phalanx in contact.
    pub e: [f64; 3],
    /// Transmission factors.
    pub x: [f64; 3],
    /// H = K - G.
    pub h: [[f64; 3]; 3],
}

impl Finger {
    /// Places with 0 < k < infinity where a contact shows `compliance` and presses while the finger closes.
    ///
    /// Minimum of the energy on the plane p . theta' = 0: C = x . H^-1 x - (p . H^-1 x)^2 / (p . H^-1 p), with the inverse
    /// replaced by the adjoint where K_1 may be 0: (p x x) . H (p x x) = C p . adj(H) p.
    pub fn places(&self, compliance: f64) -> Vec<f64> {
        let h = &self.h;
        let mut adjoint = [[0.0; 3]; 3];
        for (i, row) in adjoint.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let (a, b, c, d) = ((j + 1) % 3, (j + 2) % 3, (i + 1) % 3, (i + 2) % 3);
                *entry = h[a][c] * h[b][d] - h[a][d] * h[b][c];
            }
        }
        let (at_d, at_e) = (cross(self.d, self.x), cross(self.e, self.x));
        let mut roots = quadratic([
            form(h, at_d, at_d) - compliance * form(&adjoint, self.d, self.d),
            2.0 * (form(h, at_d, at_e) - compliance * form(&adjoint, self.d, self.e)),
            form(h, at_e, at_e) - compliance * form(&adjoint, self.e, self.e),
        ]);
        roots.retain(|&k| {
            let p = core::array::from_fn(|i| self.d[i] + k * self.e[i]);
            k > 0.0 && form(&adjoint, p, self.x) > 0.0
        });
        roots.sort_by(f64::total_cmp);
        roots
    }
}
