//! Objects of the paper's 40 distal grasps: ten objects, among them thin cylinders, squares and a plane.

use palpate_plant::Shape;

/// An object with a name for the tables.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name.
    pub name: &'static str,
    /// Outline.
    pub shape: Shape,
    /// Length of the flat side that lies flush on the phalanx, metre; 0 for a point of contact.
    pub flush_m: f64,
}

/// Side of the plane: almost the whole phalanx. A larger one would lie on the proximal phalanx as well, which is in line
/// with the distal one while the prototype closes free.
const PLANE_M: f64 = 0.060;

/// The ten objects.
#[must_use]
pub fn ten() -> Vec<Object> {
    let cylinder = |name, diameter_m| Object {
        name,
        shape: Shape::Cylinder { diameter_m },
        flush_m: 0.0,
    };
    let square = |name, side_m, angle_deg: f64| Object {
        name,
        shape: Shape::square(side_m, angle_deg),
        flush_m: if angle_deg == 0.0 { side_m } else { 0.0 },
    };
    vec![
        cylinder("cylinder 3 mm", 0.003),
        cylinder("cylinder 6 mm", 0.006),
        cylinder("cylinder 12 mm", 0.012),
        cylinder("cylinder 20 mm", 0.020),
        cylinder("cylinder 30 mm", 0.030),
        cylinder("cylinder 40 mm", 0.040),
        square("square 10 mm, flush", 0.010, 0.0),
        square("square 15 mm, on its edge", 0.015, 45.0),
        square("square 25 mm, turned 20 deg", 0.025, 20.0),
        Object {
            name: "plane 60 mm, flush",
            shape: Shape::rectangle(PLANE_M, 0.03, 0.0),
            flush_m: PLANE_M,
        },
    ]
}

/// Where a contact that begins at `k_m` is felt once the torque rises: a flush side is felt at one of its ends, or at
/// e_2 where that lies between them (docs/MECHANICS.md#observability).
#[must_use]
pub fn felt_m(object: &Object, k_m: f64, length_m: f64, equilibrium_m: f64) -> f64 {
    if object.flush_m == 0.0 {
        return k_m;
    }
    let upper = (k_m + 0.5 * object.flush_m).min(length_m);
    let lower = (k_m - 0.5 * object.flush_m).max(0.0);
    if upper <= equilibrium_m {
        upper
    } else if lower >= equilibrium_m {
        lower
    } else {
        equilibrium_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_a_flush_side() {
        let objects = ten();
        let square = objects
            .iter()
            .find(|o| o.name.starts_with("square 10"))
            .unwrap();
        assert!(
            (felt_m(square, 0.03, 0.07, 0.076) - 0.035).abs() < 1e-12,
            "upper end below e_2"
        );
        assert!(
            (felt_m(square, 0.06, 0.07, 0.04) - 0.055).abs() < 1e-12,
            "lower end beyond e_2"
        );
        assert!(
            (felt_m(square, 0.04, 0.07, 0.04) - 0.04).abs() < 1e-12,
            "e_2 itself"
        );
        let plane = objects.last().unwrap();
        assert!(
            (felt_m(plane, 0.05, 0.07, 0.076) - 0.07).abs() < 1e-12,
            "the tip against a plane"
        );
        assert!((felt_m(&objects[0], 0.03, 0.07, 0.076) - 0.03).abs() < 1e-12);
    }

    #[test]
    fn there_are_ten_with_names_of_their_own() {
        let mut names: Vec<_> = ten().iter().map(|object| object.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 10);
    }
}
