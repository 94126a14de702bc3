//! What is first behind the middle of each pixel: fog, and the surface that ends it.

use super::bend::{Bend, bend};
use super::blurred::blurred;
use super::is_chosen;
use crate::camera::Camera;
use crate::eye::shown::{Fill, Pixels, SmallLamps};
use crate::eye::sight::{FirstFog, Sight};
use crate::eye::starts::EyeStarts;
use crate::eye::straight_irradiance;
use crate::lamps::{LampTree, MOST_ASKED};
use crate::scene::media;
use crate::scene::optics::{Interior, facing_normal};
use crate::scene::{MediumId, Scene};
use covbeam::{
    EyeRay, FilmLattice, FluenceGrid, ImageSpectrum, Knot, Medium, PixelStep, RegionNode, film_regions,
    part_regions,
};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f32::consts::PI;
use std::sync::Arc;

/// A shadow's border crosses a pixel around which straight light varies by more than this.
const EDGE: f32 = 0.5;

/// Of many lamps only those with such a share of a place's light have borders of shadows that are looked for: without one the others hardly
/// change it, and the noise of choosing among them would pass for borders.
const LEAST_SHARE: f32 = 0.125;

/// Share of the passes in which pixels with nothing else to see look beyond the light that fog scatters.
const BLACK_DENSITY: f32 = 0.25;

/// Keeps the choice of pixels apart from others.
const SURFACE_PURPOSE: u64 = 0x5afa_ce00_0000;

/// Share by which starts of the fog may differ that count as one.
const SAME_START: f32 = 1e-4;

const FITS: &str = "a scene's picture is not too large";

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

/// The first piece of fog of a node of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NodeFog {
    ray: EyeRay,
    steps: [PixelStep; 2],
    medium: MediumId,
    /// Of how much of it the pixels around see.
    bend: Bend,
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
        let seen = Seen { camera: &camera, fogs: &fogs, looks: looks? };
        let mut regions = seen.regions(cancelled)?;
        let blurred = seen.blurred(&regions);
        regions.iter_mut().zip(&blurred).filter(|(_, blurred)| **blurred).for_each(|(region, _)| *region = 0);
        if cancelled() {
            return None;
        }
        let lattice = FilmLattice::new(width, height).expect(FITS);
        let fog =
            (0..lattice.node_count()).into_par_iter().map(|node| seen.fog(lattice.pixel(node), &regions));
        let fog = fog.collect();
        let marks = (0..width * height)
            .into_par_iter()
            .map(|pixel| (pixel % width > 0 || !cancelled()).then(|| seen.is_black_or_edge(pixel, &regions)));
        let (black, edge): (Vec<bool>, Vec<bool>) =
            marks.collect::<Option<Vec<(bool, bool)>>>()?.into_iter().unzip();
        let border = |(look, edge): (&Look, &bool)| match look.lamps {
            Fill::Empty => false,
            Fill::Even => *edge,
            Fill::Uneven => true,
        };
        let lamp_border = seen.looks.iter().zip(&edge).map(border).collect();
        let has_fog = seen.looks.iter().any(|look| look.fog.is_some());
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

/// The spectrum of a node's fog.
fn spectrum(
    node: &Option<NodeFog>,
    grid: &FluenceGrid,
    fogs: &[Medium],
    knots: &mut Vec<Knot>,
) -> ImageSpectrum {
    let Some(NodeFog { ray, steps, medium, bend }) = node else { return ImageSpectrum::default() };
    let fog = &fogs[*medium as usize];
    let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
    let mut spectrum = ImageSpectrum::along(ray, steps, grid, fog, &column);
    if spectrum.weight > 0.0 {
        spectrum.xx += bend.xx;
        spectrum.xy += bend.xy;
        spectrum.yy += bend.yy;
    }
    spectrum
}

/// The spectrum of the mean of several lights.
fn mean(spectra: impl ExactSizeIterator<Item = ImageSpectrum>) -> ImageSpectrum {
    let count = spectra.len() as f32;
    let sum = spectra.fold(ImageSpectrum::default(), |sum, one| ImageSpectrum {
        xx: sum.xx + one.weight * one.xx,
        xy: sum.xy + one.weight * one.xy,
        yy: sum.yy + one.weight * one.yy,
        weight: sum.weight + one.weight,
    });
    if sum.weight > 0.0 {
        let ImageSpectrum { xx, xy, yy, weight } = sum;
        ImageSpectrum { xx: xx / weight, xy: xy / weight, yy: yy / weight, weight: weight / count }
    } else {
        ImageSpectrum::default()
    }
}

/// What is first behind a pixel.
struct Look {
    fog: Option<FirstFog>,
    /// Of the first surface, as [`Camera::depth_along`] counts it; infinite where there is none.
    depth: f32,
    /// Of the fog's start; infinite where there is none.
    start: f32,
    is_black: bool,
    /// Straight light on the surface, up to a factor, and that of lamps before it.
    lit: f32,
    /// What lamps fill of the pixel.
    lamps: Fill,
}

impl Look {
    /// - `[x, y]`: the pixel.
    fn new(
        scene: &Scene,
        fogs: &[Medium],
        lamps: &LampTree,
        small: &SmallLamps,
        starts: &EyeStarts,
        [x, y]: [u32; 2],
    ) -> Self {
        let (camera, start) = (&scene.camera, &starts.middle(x, y));
        let Sight { fog, glows, end, surface } = Sight::new(scene, start);
        let lamps_seen = Pixels { scene, small, starts }.fill([x, y]);
        let depth = |distance: f32| camera.near + distance * camera.depth_along(start.direction);
        let shown = scene.shown.undimmed(scene, small, start, end, surface.as_ref().map(|(hit, _)| hit));
        let is_black = !glows
            && shown == Vec3::ZERO
            && lamps_seen != Fill::Uneven
            && surface.as_ref().is_none_or(|(hit, _)| !scene.shows(scene.material(hit)));
        let surface = surface.filter(|_| scene.shows_surfaces());
        let of_surface =
            surface.map_or(0.0, |(hit, interior)| lit(scene, fogs, lamps, interior, start.direction, &hit));
        let lit = of_surface + PI * shown.element_sum();
        let begins = fog.map_or(f32::INFINITY, |fog| depth(fog.from));
        Self { fog, depth: depth(end), start: begins, is_black, lit, lamps: lamps_seen }
    }
}

/// What is first behind all pixels.
struct Seen<'a> {
    camera: &'a Camera,
    fogs: &'a [Medium<'a>],
    looks: Vec<Look>,
}

impl Seen<'_> {
    /// The picture's regions: of the depth of surfaces, and of where fog starts and which.
    fn regions(&self, cancelled: &dyn Fn() -> bool) -> Option<Vec<u32>> {
        let of = |depth: &dyn Fn(&Look) -> f32| {
            let depth: Vec<f32> = self.looks.iter().map(depth).collect();
            let mut regions = vec![0; depth.len()];
            let mut nodes = vec![RegionNode::default(); depth.len()];
            let Camera { width, height, .. } = *self.camera;
            film_regions(width, height, &depth, &mut regions).expect(FITS);
            part_regions(width, height, &depth, &mut regions, &mut nodes).expect(FITS);
            regions
        };
        let surfaces = of(&|look| look.depth);
        let kind = |look: &Look| look.fog.map(|fog| (fog.medium, fog.is_alone));
        let starts = self.looks.iter().map(|look| look.start);
        let [least, most] = starts.fold([f32::INFINITY, 0.0], |[a, b], start| [start.min(a), start.max(b)]);
        let is_even = self.looks.iter().all(|look| kind(look) == kind(&self.looks[0]));
        if is_even && (most - least <= SAME_START * most || least == f32::INFINITY) {
            return Some(surfaces);
        }
        if cancelled() {
            return None;
        }
        // Where the fog starts it has a silhouette, too. Fog around the camera starts nearer than anything.
        let fog = of(&|look| look.start.max(f32::MIN_POSITIVE));
        let mut labels = HashMap::new();
        let numbered = surfaces.iter().zip(&fog).zip(&self.looks).zip(1..);
        let labelled = numbered.map(|(((surface, fog), look), number)| match (*surface, *fog) {
            (0, _) | (_, 0) => 0,
            pair => *labels.entry((pair, kind(look))).or_insert(number),
        });
        let mut labelled: Vec<u32> = labelled.collect();
        // Fogs side by side start and end as far away as each other, and where one begins pixels see both.
        let width = self.camera.width;
        for (pixel, label) in (0..).zip(&mut labelled) {
            let mut around = around(self.camera, pixel % width, pixel / width);
            let own = kind(&self.looks[pixel as usize]);
            if around.any(|other| kind(&self.looks[other]) != own) {
                *label = 0;
            }
        }
        Some(labelled)
    }

    /// Which pixels the lens blurs a border into; empty: none.
    fn blurred(&self, regions: &[u32]) -> Vec<bool> {
        let size = [self.camera.width, self.camera.height];
        // More than the whole picture is no wider.
        let most = size[0].max(size[1]) as f32;
        if self.camera.lens.is_none() {
            return Vec::new();
        }
        let nearest = |look: &Look| match look.fog {
            Some(fog) if fog.from > 0.0 => look.depth.min(look.start),
            // Fog around the camera is no thing that could be blurred.
            _ => look.depth,
        };
        let blur = self.looks.par_iter().map(|look| self.camera.blur(nearest(look)).min(most));
        let blur: Vec<f32> = blur.collect();
        if blur.iter().all(|blur| *blur == 0.0) { Vec::new() } else { blurred(size, regions, &blur) }
    }

    /// The fog at a node of the lattice, if a spectrum can be known there.
    fn fog(&self, [x, y]: [u32; 2], regions: &[u32]) -> Option<NodeFog> {
        let fog = self.look(x, y).fog.filter(|fog| fog.is_alone)?;
        let steps = self.camera.pixel_steps(x as f32 + 0.5, y as f32 + 0.5);
        let steps = steps.map(|step| PixelStep {
            origin: step.origin + fog.from * step.direction,
            direction: step.direction,
        });
        Some(NodeFog {
            ray: self.ray(x, y, &fog),
            steps,
            medium: fog.medium,
            bend: self.bend([x, y], regions),
        })
    }

    /// Of how much fog is seen around a pixel; 0 beside other regions, and at the picture's border.
    fn bend(&self, [x, y]: [u32; 2], regions: &[u32]) -> Bend {
        let Camera { width, height, .. } = *self.camera;
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            return Bend::default();
        }
        let region = |x: u32, y: u32| regions[(y * width + x) as usize];
        let is_inside = region(x, y) != 0
            && (y - 1..=y + 1).all(|row| (x - 1..=x + 1).all(|column| region(column, row) == region(x, y)));
        let seen = |x: u32, y: u32| self.fog_seen(x, y);
        if !is_inside || !(seen(x, y) > 0.0) {
            return Bend::default();
        }
        bend([y - 1, y, y + 1].map(|row| [x - 1, x, x + 1].map(|column| seen(column, row))))
    }

    /// Share of the light on the way through the first fog that this takes.
    fn fog_seen(&self, x: u32, y: u32) -> f32 {
        let Some(first) = self.look(x, y).fog else { return 0.0 };
        let (ray, fog) = (self.ray(x, y, &first), &self.fogs[first.medium as usize]);
        let mut knots = Vec::new();
        let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut knots);
        let column = column.at(ray.length);
        let taken = |extinction: f32| if extinction > 0.0 { -(-extinction * column).exp_m1() } else { 0.0 };
        fog.extinction().to_array().map(taken).iter().sum::<f32>() / 3.0
    }

    fn ray(&self, x: u32, y: u32, fog: &FirstFog) -> EyeRay {
        let (origin, direction) = self.camera.ray(x as f32 + 0.5, y as f32 + 0.5, [0.0; 2]);
        EyeRay { origin: origin + fog.from * direction, direction, length: fog.to - fog.from }
    }

    fn look(&self, x: u32, y: u32) -> &Look {
        &self.looks[(y * self.camera.width + x) as usize]
    }

    fn is_black_or_edge(&self, pixel: u32, regions: &[u32]) -> (bool, bool) {
        let has_silhouette = regions[pixel as usize] == 0;
        let around = || around(self.camera, pixel % self.camera.width, pixel / self.camera.width);
        let [least, most] = around().fold([f32::INFINITY, 0.0], |[least, most], pixel| {
            [self.looks[pixel].lit.min(least), self.looks[pixel].lit.max(most)]
        });
        let is_black = !has_silhouette && around().all(|pixel| self.looks[pixel].is_black);
        (is_black, has_silhouette || least < EDGE * most)
    }
}

/// Straight light on a surface, seen from where the ray to it starts, up to a factor.
fn lit(
    scene: &Scene,
    fogs: &[Medium],
    lamps: &LampTree,
    interior: Interior,
    direction: Vec3,
    hit: &Hit,
) -> f32 {
    let albedo = scene.material(hit).diffuse();
    if albedo == Vec3::ZERO {
        return 0.0;
    }
    let normal = facing_normal(hit, direction);
    let start = hit.leave(normal);
    let mut asked = lamps.on_surface(hit.position, normal, 0.5);
    if lamps.is_drawn_on_surfaces() {
        asked.retain(|(_, stands_for)| *stands_for <= 1.0 / (LEAST_SHARE * MOST_ASKED as f32));
    }
    let sum = straight_irradiance(scene, fogs, interior, start, &asked, |light| {
        let (density, from) = light.flux_density(start, [0.0; 2]);
        (density * (from - start).normalize_or_zero().dot(normal).max(0.0), from)
    });
    (albedo * sum).element_sum()
}

/// The numbers of a pixel and of the eight around it.
fn around(camera: &Camera, x: u32, y: u32) -> impl Iterator<Item = usize> {
    let Camera { width, height, .. } = *camera;
    let near = |at: u32, end: u32| at.saturating_sub(1)..=(at + 1).min(end - 1);
    near(y, height).flat_map(move |y| near(x, width).map(move |x| (y * width + x) as usize))
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
