//! The posterior of a contact's place from a torque-angle curve, by brute force: every place on a grid, every radius on a
//! grid, the other unknowns by Gauss-Newton from numerical derivatives at each of them, all in f64.
//!
//! What it assumes of unknowns and noise is what `palpate::sensing::locator` states (docs/BOUNDS.md#estimation-from-recordings);
//! how it computes shares nothing with it: the finger is [`Rolling`], derivatives are differences, and the correlated noise is
//! one covariance matrix.

use nalgebra::{DMatrix, DVector};

use super::measured::{BESIDE, Curve, Noise, Place, Priors, predicted};
use super::rolling::Rolling;

/// Steps of Gauss-Newton at a node of the grid at most, and the change at which they end, in deviations.
const STEPS: usize = 6;
const SETTLED: f64 = 0.05;
/// Step of the numerical derivatives, in deviations of an unknown.
const DIFFERENCE: f64 = 1e-3;
/// A grid over the posterior's mass.
struct Grid {
    places: usize,
    /// Every how manyth radius.
    stride: usize,
    /// Nodes less likely than the best by this logarithm are outside of the next grid: more where the nodes are coarse,
    /// because the best may be between them.
    hopeless: f64,
}
const GRIDS: [Grid; 3] = [
    Grid {
        places: 36,
        stride: 4,
        hopeless: 60.0,
    },
    Grid {
        places: 14,
        stride: 4,
        hopeless: 20.0,
    },
    Grid {
        places: 21,
        stride: 2,
        hopeless: 0.0,
    },
];
/// Added to an object's radius before its logarithm is taken, metre: that is spread evenly between the least and the largest one.
pub const OFFSET_M: f64 = 0.003;
const RADII: usize = 9;

/// What a curve tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posterior {
    /// Mean of the place, metre.
    pub k_m: f64,
    /// Its standard deviation, metre.
    pub sigma_m: f64,
    /// The likeliest node.
    pub best: Place,
    /// Squared whitened residuals there.
    pub chi_square: f64,
}

/// The unknowns at one node, whitened, and how likely it is.
#[derive(Clone, Debug)]
struct Node {
    place: Place,
    z: [f64; BESIDE],
    ln_evidence: f64,
    chi_square: f64,
}

/// What is known before a place is assumed.
struct Given<'a> {
    rolling: &'a Rolling,
    curve: &'a Curve,
    noise: &'a Noise,
    priors: &'a Priors,
    /// Covariance of the residuals but for what depends on the unknowns, which is on its diagonal.
    covariance: DMatrix<f64>,
}

/// The model at given unknowns, whitened.
struct Linear {
    residual: DVector<f64>,
    slopes: DMatrix<f64>,
    information: DMatrix<f64>,
    /// Logarithm of the determinant of the noise's covariance.
    ln_noise: f64,
}

/// Of a matrix with this Cholesky factor.
fn ln_determinant(lower: &DMatrix<f64>) -> f64 {
    2.0 * lower.diagonal().map(f64::ln).sum()
}

impl Given<'_> {
    /// A node of the grid over radii.
    fn radius_m(&self, index: usize) -> f64 {
        let [low, high] = (self.priors.object_m).map(|radius_m| (radius_m + OFFSET_M).ln());
        (low + (high - low) * index as f64 / (RADII - 1) as f64).exp() - OFFSET_M
    }

    fn predicted(&self, place: &Place, z: &[f64; BESIDE]) -> Option<Vec<f64>> {
        let (values, height_m) = (self.priors.values(z), self.priors.half_thickness_m);
        predicted(self.rolling, self.curve, place, height_m, &values)
    }

    /// The unknowns beside a place that explain the curve best, from a start.
    fn fitted(&self, place: Place, start: &[f64; BESIDE]) -> Option<Node> {
        let bounds = self.priors.bounds();
        let (mut z, mut linear) = (*start, self.linearized(&place, start)?);
        for _ in 0..STEPS {
            let right = linear.slopes.tr_mul(&linear.residual) - DVector::from_column_slice(&z);
            let change = self.step(&linear.information, right, &z)?;
            let before = z;
            for unknown in 0..BESIDE {
                let [low, high] = bounds[unknown];
                z[unknown] = (z[unknown] + change[unknown]).clamp(low, high);
            }
            linear = self.linearized(&place, &z)?;
            let moved = z.iter().zip(before).map(|(z, before)| (z - before).abs());
            if moved.fold(0.0, f64::max) < SETTLED {
                break;
            }
        }
        let ln_information = ln_determinant(&linear.information.cholesky()?.unpack());
        let chi_square = linear.residual.norm_squared();
        let priors: f64 = z.iter().map(|z| z * z).sum();
        Some(Node {
            place,
            z,
            ln_evidence: -0.5 * (chi_square + priors + linear.ln_noise + ln_information),
            chi_square,
        })
    }

    /// Whitened residuals at given unknowns, and the whitened model's derivatives.
    fn linearized(&self, place: &Place, z: &[f64; BESIDE]) -> Option<Linear> {
        let samples = &self.curve.samples;
        let n = samples.len();
        let here = self.predicted(place, z)?;
        let onset_rad = self.priors.values(z)[0];
        let lower = (self.noise).whitening(&self.covariance, self.curve, onset_rad, &here)?;
        let residual = DVector::from_fn(n, |i, _| samples[i].excess_nm - here[i]);
        let mut slopes = DMatrix::zeros(n, BESIDE);
        for unknown in 0..BESIDE {
            let mut beside = *z;
            // Away from a bound.
            let step = if z[unknown] > 0.0 {
                -DIFFERENCE
            } else {
                DIFFERENCE
            };
            beside[unknown] += step;
            let there = self.predicted(place, &beside)?;
            let column = DVector::from_fn(n, |i, _| (there[i] - here[i]) / step);
            slopes.set_column(unknown, &lower.solve_lower_triangular(&column)?);
        }
        Some(Linear {
            residual: lower.solve_lower_triangular(&residual)?,
            information: slopes.tr_mul(&slopes) + DMatrix::identity(BESIDE, BESIDE),
            slopes,
            ln_noise: ln_determinant(&lower),
        })
    }

    /// A step of Gauss-Newton; what stands at its bound and pushes against it stays there.
    fn step(
        &self,
        information: &DMatrix<f64>,
        mut right: DVector<f64>,
        z: &[f64; BESIDE],
    ) -> Option<DVector<f64>> {
        let mut matrix = information.clone();
        for (unknown, [low, high]) in self.priors.bounds().into_iter().enumerate() {
            let lower = z[unknown] <= low && right[unknown] < 0.0;
            if lower || (z[unknown] >= high && right[unknown] > 0.0) {
                matrix.row_mut(unknown).fill(0.0);
                matrix.column_mut(unknown).fill(0.0);
                matrix[(unknown, unknown)] = 1.0;
                right[unknown] = 0.0;
            }
        }
        Some(matrix.cholesky()?.solve(&right))
    }

    /// All nodes of places by radii; each starts from its neighbour's unknowns.
    fn grid(&self, places: &[f64], stride: usize) -> Vec<Node> {
        let mut nodes: Vec<Node> = Vec::new();
        for index in (0..RADII).step_by(stride) {
            let mut start = [0.0; BESIDE];
            for &k_m in places {
                let object_m = self.radius_m(index);
                if let Some(node) = self.fitted(Place { k_m, object_m }, &start) {
                    start = node.z;
                    nodes.push(node);
                }
            }
        }
        nodes
    }
}

fn likeliest(nodes: &[Node]) -> Option<&Node> {
    nodes
        .iter()
        .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))
}

/// Mean and deviation of the place over nodes of equal prior weight.
fn moments(nodes: &[Node]) -> Option<(f64, f64)> {
    let best = likeliest(nodes)?.ln_evidence;
    let (mut total, mut first, mut second) = (0.0, 0.0, 0.0);
    for node in nodes {
        let weight = (node.ln_evidence - best).exp();
        total += weight;
        first += weight * node.place.k_m;
        second += weight * node.place.k_m * node.place.k_m;
    }
    let mean = first / total;
    Some((mean, (second / total - mean * mean).max(0.0).sqrt()))
}

impl Posterior {
    /// Of a curve of a contact on phalanx 2; `None` where no contact there explains it.
    #[must_use]
    pub fn of(rolling: &Rolling, curve: &Curve, noise: &Noise, priors: &Priors) -> Option<Self> {
        let given = Given {
            rolling,
            curve,
            noise,
            priors,
            covariance: noise.covariance(curve),
        };
        let [mut low_m, mut high_m] = [0.0, rolling.distal_m];
        let mut nodes = Vec::new();
        for grid in GRIDS {
            let width_m = (high_m - low_m) / grid.places as f64;
            let places: Vec<f64> = (0..grid.places)
                .map(|i| low_m + width_m * (i as f64 + 0.5))
                .collect();
            nodes = given.grid(&places, grid.stride);
            let best = likeliest(&nodes)?.ln_evidence;
            let mass = nodes
                .iter()
                .filter(|n| n.ln_evidence > best - grid.hopeless);
            let places = mass.map(|node| node.place.k_m);
            let (least, most) = places.fold((f64::INFINITY, 0.0_f64), |(least, most), k_m| {
                (least.min(k_m), most.max(k_m))
            });
            low_m = (least - width_m).max(0.0);
            high_m = (most + width_m).min(rolling.distal_m);
        }
        let (k_m, sigma_m) = moments(&nodes)?;
        let best = likeliest(&nodes)?;
        Some(Self {
            k_m,
            sigma_m,
            best: best.place,
            chi_square: best.chi_square,
        })
    }
}
