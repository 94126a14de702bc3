//! A picture in the making: passes by one of two methods, and the tone-mapped mean.

use crate::eye::{KINDS, Size, TILE, Tile};
use crate::film::{Film, Plan};
use crate::photons::{pixel_numbers, trace};
use crate::scene::{Scene, Settings};
use crate::straight::straight_light;
use covbeam::{
    Beam, BeamMap, CovarianceGrid, FluenceCell, FluenceGrid, GatherScratch, Gathered, GridCell, GridLayout,
    KernelShape, Schedule, Vec3,
};
use libm::powf;

/// Voxels of the covariance grid, over all that is seen.
const VOXELS: GridLayout =
    GridLayout { min: Vec3::new(-3.6, -3.0, -4.6), max: Vec3::new(3.6, 3.0, 3.8), cells: [48, 40, 56] };

/// Kernels of covbeam: smallest and largest radius, and the relative bias of a pair.
const ADAPTIVE: Schedule =
    Schedule { shape: KernelShape::Epanechnikov, radius: 0.02, alpha: 0.8, max_radius: 0.12, error: 0.02 };

/// What covbeam has besides: the covariance grid, sums over all passes and their means, and the plan of eye
/// rays that comes from it.
struct Frequencies {
    sums: Vec<GridCell>,
    means: Vec<FluenceCell>,
    plan: Plan,
}

impl Frequencies {
    fn new(scene: &Scene, size: Size) -> Self {
        let count = VOXELS.cell_count();
        Self {
            sums: vec![GridCell::default(); count],
            means: vec![FluenceCell::default(); count],
            plan: Plan::new(scene, size),
        }
    }

    fn covariances(&mut self) -> CovarianceGrid<'_> {
        CovarianceGrid::new(VOXELS, &mut self.sums).expect("a cell a voxel")
    }

    /// Looks at the light fields deposited so far, and lays out the pass.
    fn resolve(&mut self, scene: &Scene, size: Size, pass: u32, photons: u32) {
        let Self { sums, means, plan } = self;
        let grid = CovarianceGrid::new(VOXELS, sums).expect("a cell a voxel");
        grid.resolve(means).expect("a mean a voxel");
        plan.lay_out(scene, &fluence(means), size, pass, photons);
    }
}

fn fluence(means: &[FluenceCell]) -> FluenceGrid<'_> {
    FluenceGrid::new(VOXELS, means).expect("a mean a voxel")
}

/// A progressive picture of one scene by one method.
pub struct View {
    scene: Scene,
    photons: u32,
    schedule: Schedule,
    size: Size,
    film: Film,
    /// As it was made last.
    picture: Vec<Vec3>,
    /// None for plain beams.
    frequencies: Option<Frequencies>,
    beams: Vec<Beam>,
    scratch: GatherScratch,
    tile: Tile,
    /// Eye rays of all passes, and pairs of beam and eye ray that they gathered.
    counts: [u64; 2],
}

impl View {
    /// A picture without a pass.
    ///
    /// - `width`, `height` \[pixels\]: rounded down to multiples of 32, at least 32.
    pub fn new(settings: &Settings, width: u32, height: u32) -> Self {
        let [width, height] = [width, height].map(|side| (side / TILE).max(1) * TILE);
        let size = Size { width, height };
        let scene = Scene::new(settings);
        let plain = Schedule { radius: settings.plain_radius, max_radius: settings.plain_radius, ..ADAPTIVE };
        Self {
            photons: settings.photons,
            schedule: if settings.adaptive { ADAPTIVE } else { plain },
            size,
            film: Film::new(size, 1.0 / scene.exposure()),
            picture: vec![Vec3::ZERO; size.pixels()],
            frequencies: settings.adaptive.then(|| Frequencies::new(&scene, size)),
            beams: Vec::new(),
            scratch: GatherScratch::default(),
            tile: Tile::default(),
            counts: [0; 2],
            scene,
        }
    }

    /// Adds a pass: traces its photons, builds the map of beams and gathers them; covbeam resolves the grid
    /// and chooses the eye rays between.
    pub fn pass(&mut self) {
        let (number, size) = (self.film.passes() + 1, self.size);
        let mut beams = std::mem::take(&mut self.beams);
        beams.clear();
        let grid = self.frequencies.as_mut().map(Frequencies::covariances);
        trace(&self.scene, number, self.photons, &mut beams, grid);
        if let Some(frequencies) = &mut self.frequencies {
            frequencies.resolve(&self.scene, size, number, self.photons);
            self.film.begin_pass(&frequencies.plan.densities);
        } else {
            self.film.begin_pass(&vec![1.0; size.pixels()]);
        }
        let map = BeamMap::build(beams, self.schedule.kernel(number, None).max_radius, &self.scene.fog);
        for y in (0..size.height).step_by(TILE as usize) {
            for x in (0..size.width).step_by(TILE as usize) {
                self.gather_tile(&map, [x, y]);
            }
        }
        self.beams = map.into_beams();
    }

    fn gather_tile(&mut self, map: &BeamMap, corner: [u32; 2]) {
        let Self { scene, schedule, size, film, frequencies, scratch, tile, counts, .. } = self;
        let pass = film.passes();
        let frequencies = frequencies.as_ref();
        let kernel = schedule.kernel(pass, frequencies.map(|found| fluence(&found.means)));
        let chooses = |pixel| frequencies.is_none_or(|found| found.plan.chooses(*size, pixel, pass));
        tile.trace(scene, *size, corner, pixel_numbers(scene.seed, pass), chooses);
        for (kind, pieces) in tile.pieces.iter().enumerate() {
            let rays: Vec<_> = pieces.iter().map(|piece| piece.ray).collect();
            let mut gathered = vec![Gathered::default(); rays.len()];
            map.gather(&scene.fog, &rays, &kernel, &mut gathered, scratch).expect("the map's own medium");
            for (piece, found) in pieces.iter().zip(&gathered) {
                let mut radiance = found.radiance;
                if frequencies.is_some() {
                    let numbers = [pass, (piece.pixel * KINDS + kind) as u32];
                    radiance += straight_light(scene, &piece.ray, numbers);
                }
                match kind {
                    0 => film.add_fog(piece.pixel, radiance),
                    _ => film.add_ball(piece.pixel, piece.weight * radiance),
                }
                counts[0] += 1;
                counts[1] += u64::from(found.pairs);
            }
        }
    }

    /// Passes so far.
    pub fn passes(&self) -> u32 {
        self.film.passes()
    }

    /// Eye rays of all passes, and pairs of beam and eye ray that they gathered.
    pub fn counts(&self) -> [u64; 2] {
        self.counts
    }

    /// Makes the picture of the passes so far: radiance \[W/(m² sr)\] of each pixel, rows from the top. With
    /// covbeam's filters that takes longer than a pass.
    pub fn picture(&mut self) -> &[Vec3] {
        match &self.frequencies {
            Some(frequencies) => self.film.filtered(&frequencies.plan, &mut self.picture),
            None => self.film.mean(&mut self.picture),
        }
        &self.picture
    }

    /// Writes the picture that was made last as the screen shows it: exposed, tone mapped, sRGB, four bytes a
    /// pixel.
    pub fn tone_map(&self, out: &mut Vec<u8>) {
        let exposure = self.scene.exposure();
        out.clear();
        for &radiance in &self.picture {
            let [red, green, blue] = (exposure * radiance).to_array().map(shown);
            out.extend([red, green, blue, 255]);
        }
    }
}

/// Filmic tone curve (K. Narkowicz's fit of ACES), then sRGB's transfer function (IEC 61966-2-1).
fn shown(value: f32) -> u8 {
    let curve = value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14);
    let linear = curve.min(1.0);
    let encoded =
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * powf(linear, 1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}
