//! The picture that a film's sums make.

mod blocks;

use super::{FITS, Film, FogLayer, UNITS};
use crate::color::luminance;
use crate::kind::Kind;
use crate::plan::LayerFilters;
use covbeam::{
    FILM_TILE, FILM_TILE_PIXELS, FilmEvidence, FilmFilterNode, FilmFilters, FilmNode, FilmPixel, FilmSample,
    FilmSums, ImageFilter, Reconstruction, standard_errors, verify_filters,
};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Asked often whether to give up.
type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// A finished picture, row by row from the upper left pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Radiance [W/(m² sr)], linear, Rec. 709 primaries.
    pub radiance: Vec<Vec3>,
    /// Standard error of each pixel's luminance, from the two halves of the passes; None for a single pass and for pictures of
    /// other programs.
    pub error: Option<Vec<f32>>,
    /// What the gather did; None for methods that gather nothing and for pictures of other programs.
    pub layers: Option<Layers>,
    /// Where the eye rays were; None if every pixel had one in each pass.
    pub maps: Option<Maps>,
    /// The picture's parts by kind of light, which add up to it; empty unless the film keeps them.
    pub kinds: Vec<(Kind, Vec<Vec3>)>,
}

impl Picture {
    /// Median over the lit pixels of the standard error over the luminance; None where the errors are not known or no pixel is lit.
    pub fn median_relative_error(&self) -> Option<f64> {
        let pixels = self.radiance.iter().zip(self.error.as_ref()?);
        let relative = pixels.filter_map(|(radiance, error)| {
            let luminance = luminance(*radiance);
            (luminance > 0.0).then(|| error / luminance)
        });
        let mut relative: Vec<f32> = relative.collect();
        let middle = relative.len() / 2;
        if relative.is_empty() {
            return None;
        }
        Some(f64::from(*relative.select_nth_unstable_by(middle, f32::total_cmp).1))
    }
}

/// How the beams around each pixel's eye ray were gathered; one value a pixel, 0 where no pair was accepted. Where not every pixel has an eye ray
/// in each pass, radius and σ are means over blocks of 8 x 8 pixels, bilinear between their middles.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Mean gather radius, weighted by contribution [scene unit].
    pub radius: Vec<f32>,
    /// Mean standard deviation of the fluence spectrum along the kernel axis, weighted by contribution
    /// [cycles / scene unit].
    pub sigma: Vec<f32>,
    /// Accepted pairs of beam and eye ray a pass.
    pub samples: Vec<f32>,
}

/// How the eye rays of a picture were spread and its fog filtered: the thesis' Figure 5.20. One value a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// The fog before the first surface, through the filters [W/(m² sr)].
    pub volume: Vec<Vec3>,
    /// By layer of light.
    pub layers: Vec<LayerMaps>,
}

impl Maps {
    /// Eye rays a pixel in the latest pass, of the layer that has most: what another wants sees the same ray.
    pub fn density(&self) -> Vec<f32> {
        let mut most = Vec::new();
        for layer in &self.layers {
            most.resize(layer.density.len(), 0.0);
            most.iter_mut().zip(layer.density.iter()).for_each(|(most, density)| *most = density.max(*most));
        }
        most
    }
}

/// The same of one layer: of all light, or of straight and of other light, ….
#[derive(Clone, Debug, PartialEq)]
pub struct LayerMaps {
    /// Its light; None: all light.
    pub kind: Option<Kind>,
    /// The filters of the latest pass, as far as the samples agree with them.
    pub filters: Vec<ImageFilter>,
    /// Eye rays a pixel in the latest pass.
    pub density: Arc<Vec<f32>>,
}

impl Film {
    /// The mean of the passes; black without any. Where not every pixel had an eye ray, the fog before the first surface is
    /// reconstructed with the filters of the latest pass, as far as the two halves of the passes agree with them.
    pub fn picture(&self) -> Picture {
        self.picture_unless(&|| false).expect("never cancelled")
    }

    /// The same; None: `cancelled`, which is polled many times each tenth of a second, said yes.
    pub fn picture_unless(&self, cancelled: Cancelled) -> Option<Picture> {
        let radiance =
            |pixels: &[FilmPixel]| -> Vec<Vec3> { pixels.par_iter().map(|pixel| pixel.radiance).collect() };
        let mut pixels = vec![FilmPixel::default(); self.pixels()];
        let mut kinds = self.own_kinds(cancelled)?;
        let mut layers = Vec::new();
        let brightness = self.brightness(cancelled)?;
        for (number, layer) in self.fog.iter().enumerate() {
            let of_layer = |kind: Kind| self.split.is_some_and(|split| split.of(kind) == number);
            let kind =
                kinds.iter_mut().find(|(kind, _)| of_layer(*kind)).map(|(_, light)| light.as_mut_slice());
            let verified = self.reconstruct(layer, &brightness, &mut pixels, kind, cancelled)?;
            layers.push(self.maps(layer, &verified, cancelled)?);
        }
        let maps = (!layers.is_empty()).then(|| Maps { volume: radiance(&pixels), layers });
        self.add_own(&mut pixels, cancelled)?;
        let error = self.errors(&pixels, cancelled)?;
        let radiance = radiance(&pixels);
        // Before the layers take their place.
        drop(pixels);
        let layers = if self.gather.is_empty() { None } else { Some(self.layers(cancelled)?) };
        let (width, height) = (self.width, self.height);
        Some(Picture { width, height, radiance, error, layers, maps, kinds })
    }

    /// What the gather did.
    fn layers(&self, cancelled: Cancelled) -> Option<Layers> {
        let passes = f64::from(self.passes.max(1));
        let samples = self.gather.par_iter().map(|sums| (sums[3] as f64 / UNITS / passes) as f32).collect();
        let [radius, sigma] = if self.fog.is_empty() {
            let share =
                |sum: i64, whole: i64| if whole == 0 { 0.0 } else { (sum as f64 / whole as f64) as f32 };
            [1, 2].map(|which| self.gather.par_iter().map(|sums| share(sums[which], sums[0])).collect())
        } else {
            blocks::means(&self.gather, self.width, cancelled)?
        };
        Some(Layers { radius, sigma, samples })
    }

    /// Standard errors of the pixels' luminance, where there are two halves of the passes.
    fn errors(&self, pixels: &[FilmPixel], cancelled: Cancelled) -> Option<Option<Vec<f32>>> {
        if self.odd_passes == 0 || self.odd_passes == self.passes {
            return Some(None);
        }
        let mut error = vec![0.0; pixels.len()];
        let rows = error.par_chunks_mut(self.width as usize).enumerate();
        rows.map(|(row, out)| {
            standard_errors(self.width, self.height, pixels, row as u32, out).expect(FITS);
            (!cancelled()).then_some(())
        })
        .collect::<Option<()>>()?;
        Some(Some(error))
    }

    /// Where a layer's eye rays were, and the filters that were found.
    fn maps(&self, layer: &FogLayer, verified: &[FilmFilterNode], cancelled: Cancelled) -> Option<LayerMaps> {
        let (width, height) = (self.width, self.height);
        let LayerFilters { kind, lattice, regions, density, .. } = &layer.latest;
        let filters = FilmFilters::of(*lattice, regions, verified).expect(FITS);
        let filter =
            |pixel| (pixel % width > 0 || !cancelled()).then(|| filters.filter(pixel % width, pixel / width));
        let filters: Option<Vec<ImageFilter>> = (0..width * height).into_par_iter().map(filter).collect();
        Some(LayerMaps { kind: *kind, filters: filters?, density: Arc::clone(density) })
    }

    /// A layer's samples, means over the passes.
    fn samples(&self, layer: &FogLayer) -> Vec<FilmSample> {
        let sums = layer.sums.par_iter().zip(&layer.density);
        sums.map(|(sums, density)| sums.sample(&self.unit, *density as f64 / UNITS)).collect()
    }

    /// The same, to be filtered.
    fn volume<'a>(
        &self,
        layer: &'a FogLayer,
        samples: &'a [FilmSample],
        nodes: &'a mut Vec<FilmNode>,
    ) -> Reconstruction<'a> {
        nodes.resize(Reconstruction::node_count(self.width, self.height), FilmNode::default());
        Reconstruction::new(self.width, self.height, samples, &layer.latest.regions, nodes).expect(FITS)
    }

    /// Of the fog's light of all layers at the nodes of the lattice, where there is more than one.
    fn brightness(&self, cancelled: Cancelled) -> Option<Vec<f32>> {
        let mut brightness = Vec::new();
        for layer in self.fog.iter().filter(|_| self.fog.len() > 1) {
            let (samples, mut nodes) = (self.samples(layer), Vec::new());
            let volume = self.volume(layer, &samples, &mut nodes);
            let predicted = layer.latest.filters();
            brightness.resize(layer.latest.nodes.len(), 0.0);
            let numbered = brightness.par_iter_mut().enumerate();
            let added = numbered.map(|(node, sum)| {
                *sum += predicted.evidence(node, &volume).brightness;
                (!cancelled()).then_some(())
            });
            added.collect::<Option<()>>()?;
        }
        Some(brightness)
    }

    /// Adds a layer of the fog before the first surface, also to a picture of its kind; returns its filters at the nodes of the lattice.
    fn reconstruct(
        &self,
        layer: &FogLayer,
        brightness: &[f32],
        pixels: &mut [FilmPixel],
        kind: Option<&mut [Vec3]>,
        cancelled: Cancelled,
    ) -> Option<Vec<FilmFilterNode>> {
        let width = self.width;
        let (samples, mut nodes) = (self.samples(layer), Vec::new());
        let volume = self.volume(layer, &samples, &mut nodes);

        let LayerFilters { lattice, regions, nodes, .. } = &layer.latest;
        let mut verified = nodes.to_vec();
        let predicted = layer.latest.filters();
        let evidence = (0..verified.len()).into_par_iter().map(|node| {
            let own = predicted.evidence(node, &volume);
            let own = own.beside(brightness.get(node).map_or(0.0, |all| all - own.brightness));
            (!cancelled()).then_some(own)
        });
        let evidence: Option<Vec<FilmEvidence>> = evidence.collect();
        verify_filters(lattice, &evidence?, &mut verified).expect(FITS);
        let filters = FilmFilters::of(*lattice, regions, &verified).expect(FITS);

        let tiles = (width * FILM_TILE) as usize;
        let add = |row: u32, pixels: &mut [FilmPixel], mut kind: Option<&mut [Vec3]>| {
            let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
            if cancelled() {
                return None;
            }
            for x in (0..width).step_by(FILM_TILE as usize) {
                volume.tile(x, row, &filters, &mut tile);
                for (y, tile) in tile.chunks(FILM_TILE as usize).enumerate() {
                    let line = y * width as usize;
                    for (x, found) in (x as usize..width as usize).zip(tile) {
                        let Some(pixel) = pixels.get_mut(line + x) else { continue };
                        pixel.radiance += found.radiance;
                        pixel.variance += found.variance;
                        pixel.difference += found.difference;
                        if let Some(kind) = &mut kind {
                            kind[line + x] += found.radiance;
                        }
                    }
                }
            }
            Some(())
        };
        let rows = pixels.par_chunks_mut(tiles).enumerate();
        let first = |row: usize| row as u32 * FILM_TILE;
        match kind {
            None => rows.try_for_each(|(row, pixels)| add(first(row), pixels, None)),
            Some(kind) => rows
                .zip(kind.par_chunks_mut(tiles))
                .try_for_each(|((row, pixels), kind)| add(first(row), pixels, Some(kind))),
        }?;
        Some(verified)
    }

    /// Adds the light that pixels keep to themselves.
    fn add_own(&self, pixels: &mut [FilmPixel], cancelled: Cancelled) -> Option<()> {
        if self.own.is_empty() {
            return Some(());
        }
        let samples = self.means(&self.own, |sums| sums);
        let filled = self.filled(&samples, cancelled)?;
        pixels.par_iter_mut().zip(&samples).zip(filled).for_each(|((pixel, own), radiance)| {
            pixel.radiance += radiance;
            pixel.difference += own.halves().map_or(0.0, |[odd, even]| odd - even);
        });
        Some(())
    }

    /// The same, a picture a kind.
    fn own_kinds(&self, cancelled: Cancelled) -> Option<Vec<(Kind, Vec<Vec3>)>> {
        let of_kind = |kind: Kind| {
            let samples = self.means(&self.kinds, |sums: &[FilmSums; 3]| &sums[kind as usize]);
            Some((kind, self.filled(&samples, cancelled)?))
        };
        self.split.iter().flat_map(|split| split.kinds()).map(of_kind).collect()
    }

    fn means<T: Sync>(&self, all: &[T], sums: impl Fn(&T) -> &FilmSums + Sync) -> Vec<FilmSample> {
        let mean = |sums: &FilmSums| sums.sample(&self.unit, f64::from(sums.rays()));
        all.par_iter().map(|of_pixel| mean(sums(of_pixel))).collect()
    }

    /// Radiance of samples over their numbers of rays. Pixels without an eye ray take that of the nearest ones as long as they have none.
    fn filled(&self, samples: &[FilmSample], cancelled: Cancelled) -> Option<Vec<Vec3>> {
        let own = |sample: &FilmSample| sample.radiance / sample.weight;
        let is_sparse = samples.par_iter().any(|sample| sample.weight == 0.0);
        let Some(layer) = self.fog.first().filter(|_| is_sparse) else {
            return Some(samples.par_iter().map(own).collect());
        };
        if samples.par_iter().all(|sample| sample.weight == 0.0) {
            return Some(vec![Vec3::ZERO; samples.len()]);
        }
        let mut nodes = vec![FilmNode::default(); Reconstruction::node_count(self.width, self.height)];
        let regions = &layer.latest.regions;
        let around = Reconstruction::new(self.width, self.height, samples, regions, &mut nodes).expect(FITS);
        let numbered = samples.par_iter().enumerate();
        let filled = numbered.map(|(index, sample)| {
            let (x, y) = (index as u32 % self.width, index as u32 / self.width);
            if x == 0 && cancelled() {
                return None;
            }
            Some(if sample.weight > 0.0 { own(sample) } else { around.nearby(x, y) })
        });
        filled.collect()
    }
}
