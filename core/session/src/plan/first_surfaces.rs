//! What is first behind the middle of each pixel: fog, and the surface that ends it.

mod borders;
mod look;
mod node_fog;
mod regions;

use super::is_chosen;
use crate::camera::Camera;
use crate::eye::shown::{Fill, SmallLamps};
use crate::eye::starts::EyeStarts;
use crate::lamps::LampTree;
use crate::scene::Scene;
use crate::scene::media;
use borders::{blurred, is_black_or_edge};
use covbeam::{FilmLattice, FluenceGrid, ImageSpectrum, Knot, Medium};
use look::{Look, Looks};
use node_fog::{NodeFog, mean, spectrum};
use rayon::prelude::*;
use regions::{FITS, regions};
use std::collections::HashMap;
use std::sync::Arc;

/// Share of the passes in which pixels with nothing else to see look beyond the light that fog scatters.
const BLACK_DENSITY: f32 = 0.25;

/// Keeps the choice of pixels apart from others.
const SURFACE_PURPOSE: u64 = 0x5afa_ce00_0000;

/// What is first behind each pixel: fog, and the surface that ends it.
#[derive(Debug, PartialEq)]
pub struct FirstSurfaces {
    camera: Camera,
    /// At the nodes of the lattice; None where there is no fog before the first surface, or more than one piece. For each instant whose fog is
    /// another than that of those before it.
    fog: Vec<Vec<Option<NodeFog>>>,
    /// Whether there is any before the first surface, in any pixel.
    has_fog: bool,
    /// Of each pixel: whether it and those around it are black, or there is none, no fog before it sends out light, no lamp is seen there, and
    /// no silhouette crosses it.
    black: Vec<bool>,
    /// Of each pixel: whether a silhouette, the border of a shadow on it or that of a lamp crosses it.
    edge: Vec<bool>,
    /// Of each pixel: whether the border of a lamp that is seen crosses it, or an edge what lamps fill.
    lamp_border: Vec<bool>,
    /// Of each pixel: whether a lens blurs a silhouette into it. Empty: there is no lens, or no such pixel.
    blurred: Vec<bool>,
    regions: Arc<Vec<u32>>,
    lattice: FilmLattice,
}

impl FirstSurfaces {
    /// Looks at the scene through the middle of each pixel, and of the lens. None: `cancelled`, which is polled in
    /// each row of pixels, said yes.
    pub fn new(scene: &Scene, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let camera = scene.camera;
        let [width, height] = [camera.width, camera.height];
        let (starts, fogs, lamps) = (EyeStarts::new(scene), media::all(scene), LampTree::new(scene));
        let small = SmallLamps::new(scene);
        let looks: Option<Vec<Look>> = (0..width * height)
            .into_par_iter()
            .map(|pixel| {
                let (x, y) = (pixel % width, pixel / width);
                // Once a row.
                (x > 0 || !cancelled()).then(|| Look::new(scene, &fogs, &lamps, &small, &starts, [x, y]))
            })
            .collect();
        let looks = Looks { camera: &camera, fogs: &fogs, all: looks? };
        let mut regions = regions(&looks, cancelled)?;
        let blurred = blurred(&looks, &regions);
        regions.iter_mut().zip(&blurred).filter(|(_, blurred)| **blurred).for_each(|(region, _)| *region = 0);
        if cancelled() {
            return None;
        }
        let lattice = FilmLattice::new(width, height).expect(FITS);
        let at_node = |node| NodeFog::at(&looks, lattice.pixel(node), &regions);
        let fog = (0..lattice.node_count()).into_par_iter().map(at_node).collect();
        let marks = (0..width * height).into_par_iter().map(|pixel| {
            (pixel % width > 0 || !cancelled()).then(|| is_black_or_edge(&looks, pixel, &regions))
        });
        let (black, edge): (Vec<bool>, Vec<bool>) =
            marks.collect::<Option<Vec<(bool, bool)>>>()?.into_iter().unzip();
        let border = |(look, edge): (&Look, &bool)| match look.lamps {
            Fill::Empty => false,
            Fill::Even => *edge,
            Fill::Uneven => true,
        };
        let lamp_border = looks.all.iter().zip(&edge).map(border).collect();
        let has_fog = looks.all.iter().any(|look| look.fog.is_some());
        Some(Self {
            camera,
            fog: vec![fog],
            has_fog,
            black,
            edge,
            lamp_border,
            blurred,
            regions: Arc::new(regions),
            lattice,
        })
    }

    /// What is first behind each pixel at any of some instants, at least one, of pictures of one size. Its regions are where the fog that is seen
    /// is continuous at all of them; a silhouette crosses a pixel if it does at any.
    pub fn over(instants: Vec<Self>) -> Self {
        let pixels = instants[0].regions.len();
        let is_still = instants.iter().all(|instant| instant.regions == instants[0].regions);
        let regions = (!is_still).then(|| {
            let mut labels = HashMap::new();
            let label = |pixel: usize| {
                let regions: Vec<u32> = instants.iter().map(|instant| instant.regions[pixel]).collect();
                if regions.contains(&0) { 0 } else { *labels.entry(regions).or_insert(pixel as u32 + 1) }
            };
            Arc::new((0..pixels).map(label).collect())
        });
        let mut instants = instants.into_iter();
        let mut all = instants.next().expect("at least one");
        all.regions = regions.unwrap_or(all.regions);
        for instant in instants {
            all.has_fog |= instant.has_fog;
            all.black.iter_mut().zip(instant.black).for_each(|(all, black)| *all &= black);
            all.edge.iter_mut().zip(instant.edge).for_each(|(all, edge)| *all |= edge);
            all.lamp_border.iter_mut().zip(instant.lamp_border).for_each(|(all, border)| *all |= border);
            if all.blurred.len() < instant.blurred.len() {
                all.blurred.resize(pixels, false);
            }
            all.blurred.iter_mut().zip(instant.blurred).for_each(|(all, blurred)| *all |= blurred);
            if !all.fog.contains(&instant.fog[0]) {
                all.fog.extend(instant.fog);
            }
        }
        all
    }

    /// Whether there is fog before the first surface in any pixel.
    pub fn has_fog(&self) -> bool {
        self.has_fog
    }

    /// Whether a pass looks at what is beyond the fog in pixel (x, y), and at what this sends out: always where there is something to see in it or beside it, and at
    /// silhouettes, which cross pixels; else in a quarter of the passes, for what is smaller than a pixel.
    pub fn are_wanted(&self, x: u32, y: u32, pass: u32, seed: u32) -> bool {
        let density = if self.black[self.index(x, y)] { BLACK_DENSITY } else { 1.0 };
        is_chosen(density, [x, y], pass, seed, SURFACE_PURPOSE)
    }

    /// Whether a silhouette, the border of a shadow on a surface or that of a lamp crosses pixel (x, y).
    pub fn has_edge(&self, x: u32, y: u32) -> bool {
        self.edge[self.index(x, y)]
    }

    /// Whether the border of a lamp that is seen crosses pixel (x, y), or a silhouette hides a part of one.
    pub fn has_lamp_border(&self, x: u32, y: u32) -> bool {
        self.lamp_border[self.index(x, y)]
    }

    /// Whether the lens blurs a silhouette into pixel (x, y): it sees more than what is behind its middle.
    pub fn is_blurred(&self, x: u32, y: u32) -> bool {
        !self.blurred.is_empty() && self.blurred[self.index(x, y)]
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y * self.camera.width + x) as usize
    }

    /// Where the picture's spectrum is found.
    pub fn lattice(&self) -> &FilmLattice {
        &self.lattice
    }

    /// The regions of the picture, between silhouettes of surfaces and of the fog's bounds: equal where what is seen of the fog is continuous, 0
    /// at borders and where the lens blurs them.
    pub fn regions(&self) -> &Arc<Vec<u32>> {
        &self.regions
    }

    /// The spectrum of the first piece of fog at the nodes of the lattice: read off the grid, and that of how much fog is seen around. Of
    /// several instants it is the mean over their light.
    ///
    /// - `fogs`: the scene's media.
    pub fn spectra(&self, grid: &FluenceGrid, fogs: &[Medium]) -> Vec<ImageSpectrum> {
        let of_node = |knots: &mut Vec<Knot>, node: usize| match &self.fog[..] {
            [only] => spectrum(&only[node], grid, fogs, knots),
            all => mean(all.iter().map(|nodes| spectrum(&nodes[node], grid, fogs, knots))),
        };
        (0..self.lattice.node_count()).into_par_iter().map_init(Vec::new, of_node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;
    use crate::scene::made::{BOUND, Made, cuboid, parallel, point};

    /// A bar before fog, its left side at x.
    fn looks(x: f32) -> FirstSurfaces {
        let scene = Made::new(parallel([0.0, 0.0, -6.0], [0.0; 3], 4.0, [16, 8]))
            .fog(1.0, 0.0)
            .in_fog()
            .object(cuboid([x, -9.0, -1.0], [x + 2.0, 9.0, -0.5]), Material::Black)
            .light(point([0.0, 4.0, 0.0], 1.0))
            .scene();
        FirstSurfaces::new(&scene, &|| false).expect("never cancelled")
    }

    #[test]
    fn regions_over_instants_are_those_that_are_one_at_each() {
        let instants = [-2.5, -1.0, 0.0].map(looks);
        let all = FirstSurfaces::over([-2.5, -1.0, 0.0].map(looks).into());
        let regions = all.regions();
        let at = |pixel: usize| instants.each_ref().map(|instant| instant.regions[pixel]);
        for one in 0..regions.len() {
            assert_eq!(regions[one] == 0, at(one).contains(&0));
            for other in 0..one {
                let same = regions[one] != 0 && at(one) == at(other);
                assert_eq!(regions[one] == regions[other] && regions[one] != 0, same, "{one} and {other}");
            }
            let is_any =
                |of: fn(&FirstSurfaces) -> &Vec<bool>| instants.iter().any(|instant| of(instant)[one]);
            assert_eq!(all.edge[one], is_any(|instant| &instant.edge));
            assert_eq!(all.black[one], instants.iter().all(|instant| instant.black[one]));
        }
        // At the first, no silhouette is where the last has one.
        assert!((0..regions.len()).any(|pixel| at(pixel)[0] != 0 && regions[pixel] == 0));
        assert_eq!(all.fog.len(), 3);
    }

    /// Two fogs in one box of four metres, the border between them within a pixel, next to one or on its side: what sees both is in no region.
    #[test]
    fn fogs_side_by_side_have_a_border_between_them() {
        for (border, seen) in [(0.13_f32, [8, 9]), (0.01, [7, 8]), (0.0, [7, 8])] {
            // The camera's right hand is at -x.
            let x = 0.0 - border;
            let scene = Made::new(parallel([0.0, 0.0, -6.0], [0.0; 3], 2.0, [16, 8]))
                .fog(1.0, 0.0)
                .fog(0.1, 0.0)
                .filled(cuboid([-9.0, -9.0, 0.0], [x, 9.0, 4.0]), BOUND, 0)
                .filled(cuboid([x, -9.0, 0.0], [9.0, 9.0, 4.0]), BOUND, 1)
                .light(point([0.0, 4.0, 0.0], 1.0))
                .scene();
            let found = FirstSurfaces::new(&scene, &|| false).expect("never cancelled");
            for row in found.regions.chunks(16) {
                let (left, right) = (row[0], row[15]);
                assert!(left != 0 && right != 0 && left != right, "{border}: {row:?}");
                for (column, &region) in row.iter().enumerate() {
                    let expected = if column < seen[0] { left } else { right };
                    let is_border = seen.contains(&column) && region == 0;
                    assert!(region == expected || is_border, "{border}, {column}: {row:?}");
                }
                // What a pixel sees on both sides of its middle.
                let split = (8.0 + 4.0 * border).floor() as usize;
                assert!(border == 0.0 || row[split] == 0, "{border}: {row:?}");
            }
        }
    }

    #[test]
    fn instants_that_are_alike_are_as_one() {
        assert_eq!(FirstSurfaces::over(vec![looks(-1.0), looks(-1.0)]), looks(-1.0));
    }
}
