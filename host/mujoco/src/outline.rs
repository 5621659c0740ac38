//! Objects as prisms: from the outline to the text of a box or a mesh.

use palpate_plant::Point;

/// Half the depth of an object across the plane, metre.
pub(crate) const HALF_DEPTH_M: f64 = 0.05;

/// Mean of the corners.
pub(crate) fn middle(corners: &[Point]) -> Point {
    let share = 1.0 / corners.len().max(1) as f64;
    corners
        .iter()
        .fold([0.0; 2], |[x, y], c| [x + share * c[0], y + share * c[1]])
}

/// Width, height and direction of a rectangle; `None` for another outline.
pub(crate) fn rectangle(corners: &[Point]) -> Option<[f64; 3]> {
    let [a, b, c, d] = corners else { return None };
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    let (width, height) = (u[0].hypot(u[1]), v[0].hypot(v[1]));
    let skew = u[0] * v[0] + u[1] * v[1];
    let open = (a[0] + c[0] - b[0] - d[0]).hypot(a[1] + c[1] - b[1] - d[1]);
    (skew.abs() < 1e-9 * width * height && open < 1e-9).then(|| [width, height, u[1].atan2(u[0])])
}

/// A prism about its middle: a box where the outline is a rectangle, else the hull of its corners.
pub(crate) fn polygon(corners: &[Point], mass: f64) -> String {
    match rectangle(corners) {
        Some([width, height, turn]) => format!(
            r#"<geom name="object" type="box" size="{} {} {HALF_DEPTH_M}" euler="0 0 {turn}" mass="{mass}"/>"#,
            0.5 * width,
            0.5 * height
        ),
        None => format!(r#"<geom name="object" type="mesh" mesh="object" mass="{mass}"/>"#),
    }
}

/// The asset of an outline that is no rectangle.
pub(crate) fn mesh(corners: &[Point]) -> String {
    let [x, y] = middle(corners);
    let vertices: Vec<String> = corners
        .iter()
        .flat_map(|c| {
            [-HALF_DEPTH_M, HALF_DEPTH_M].map(|z| format!("{} {} {z}", c[0] - x, c[1] - y))
        })
        .collect();
    format!(
        r#"<asset><mesh name="object" vertex="{}"/></asset>"#,
        vertices.join(" ")
    )
}
