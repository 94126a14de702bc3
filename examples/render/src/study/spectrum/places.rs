//! Where to look, if the user does not say.

use super::walk::{center_of, index_of};
use super::{Analysis, Bounds, Line, Origin, Point, Voxel, walk::voxel_size};
use covbeam_session::scene::{Light, Scene};

/// The brightest voxel of what came by mirrors and glass alone, which is a caustic; without such light, the centre of
/// gravity of the light that comes straight from the lights.
pub fn focus(analysis: &Analysis) -> [u32; 3] {
    let caustic = brightest(analysis, Origin::Specular);
    caustic.unwrap_or_else(|| {
        let mut sum = [0.0; 3];
        let mut total = 0.0;
        for voxel in &analysis.voxels {
            let weight = voxel.energy * f64::from(voxel.origins[Origin::Direct as usize]);
            total += weight;
            for (sum, cell) in sum.iter_mut().zip(voxel.cell) {
                *sum += weight * f64::from(cell);
            }
        }
        let middle = analysis.layout.cells.map(|n| n / 2);
        if total > 0.0 { sum.map(|sum| (sum / total).round() as u32) } else { middle }
    })
}

/// Lines along the three axes through the whole grid and the [`focus`].
pub fn default_lines(analysis: &Analysis) -> Vec<Line> {
    let center = center_of(&analysis.layout, focus(analysis)).as_vec3();
    let through = |axis: usize| {
        let (mut from, mut to) = (center, center);
        (from[axis], to[axis]) = (analysis.layout.min[axis], analysis.layout.max[axis]);
        Line { from, to }
    };
    (0..3).map(through).collect()
}

/// As in Figure 5.18: smooth light, the border of a shadow or of a light's cone, and a caustic. Kinds that the scene
/// does not have are left out.
pub fn default_points(analysis: &Analysis, scene: &Scene) -> Vec<Point> {
    let bounds = Bounds::of_voxel_edges(&voxel_size(&analysis.layout));
    // Largest measured deviation in lower bounds; None where one was left out, also at the border of the grid.
    let roughest = |voxel: &Voxel| {
        let sigma = |axis: usize| Some(voxel.axes[axis].measured?.sigma / bounds[axis].low);
        Some(sigma(0)?.max(sigma(1)?).max(sigma(2)?))
    };
    let smooth = |voxel: &Voxel| (roughest(voxel)? <= 1.0).then_some(voxel.fluence);
    // Where direct light begins: the largest jump between two neighbours, in proportion. Not next to a light, where it
    // falls off as steeply.
    let size = voxel_size(&analysis.layout);
    let far = |voxel: &Voxel| {
        let apart = |light: &Light| light.position().as_dvec3().distance(voxel.center);
        scene.lights.iter().all(|light| apart(light) > 4.0 * size.max_element())
    };
    let direct = |cell: [u32; 3]| {
        let voxel = &analysis.voxels[index_of(&analysis.layout, cell)];
        voxel.fluence * f64::from(voxel.origins[Origin::Direct as usize])
    };
    let edge = |voxel: &Voxel| {
        roughest(voxel)?;
        let jump = |axis: usize| {
            let (mut before, mut after) = (voxel.cell, voxel.cell);
            (before[axis], after[axis]) = (before[axis] - 1, after[axis] + 1);
            (direct(after) - direct(before)).abs() / (direct(after) + direct(before))
        };
        let lit = voxel.bright && voxel.origins[Origin::Direct as usize] > 0.1;
        (lit && far(voxel)).then(|| (0..3).map(jump).fold(0.0, f64::max))
    };
    let point = |name: &str, cell: Option<[u32; 3]>| cell.map(|cell| Point { name: name.to_owned(), cell });
    [
        point("smooth", largest(analysis, smooth)),
        point("border", largest(analysis, edge)),
        point("caustic", brightest(analysis, Origin::Specular)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The voxel with the most light of one origin; None where there is none.
fn brightest(analysis: &Analysis, origin: Origin) -> Option<[u32; 3]> {
    let bright = |voxel: &Voxel| voxel.energy * f64::from(voxel.origins[origin as usize]);
    largest(analysis, |voxel| Some(bright(voxel)).filter(|energy| *energy > 0.0))
}

fn largest(analysis: &Analysis, value: impl Fn(&Voxel) -> Option<f64>) -> Option<[u32; 3]> {
    let found = analysis.voxels.iter().filter_map(|voxel| Some((voxel.cell, value(voxel)?)));
    found.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(cell, _)| cell)
}
