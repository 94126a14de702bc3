//! What the columns along the beams of a map are computed from.

use super::cancel::{Poll, STRETCH, Stop};
use super::room::{fitted, tabulate, with_room};
use crate::beam::Beam;
use crate::medium::{Column, Density, ExponentialDensity, Knot, Medium, PhaseFunction, PhaseShare};
use crate::pair::along_beam;
use crate::voxels::GridLayout;
use glam::Vec3;
use std::vec::Vec;

/// Beams whose tables lie in one array: so long an array is cheap to move when it grows.
const BUNCH: usize = 1 << 12;

/// Which medium a map was built in.
#[derive(Clone, PartialEq)]
pub(super) struct MediumKey {
    coefficients: [Vec3; 2],
    phase: PhaseFunction,
    more: Vec<PhaseShare>,
    exponential: Option<ExponentialDensity>,
    voxels: Option<(GridLayout, usize)>,
}

impl MediumKey {
    pub(super) fn of(medium: &Medium) -> Self {
        let (mut exponential, mut voxels) = (None, None);
        match &medium.density {
            Density::Uniform => {}
            Density::Exponential(density) => exponential = Some(*density),
            Density::Grid(grid) => voxels = Some(grid.identity()),
        }
        let coefficients = [medium.scattering, medium.absorption];
        Self { coefficients, phase: medium.phase, more: medium.more.to_vec(), exponential, voxels }
    }
}

/// The columns along all beams. A homogeneous medium stores nothing.
#[derive(Clone)]
pub(super) enum BeamColumns {
    Uniform,
    /// The density at each beam's origin.
    Exponential(Vec<f32>),
    /// A bunch for every [`BUNCH`] beams.
    Tables(Vec<Bunch>),
}

/// Tables of columns one after the other; that of beam i is `first[i]..first[i + 1]`.
#[derive(Clone)]
pub(super) struct Bunch {
    knots: Vec<Knot>,
    first: Vec<u32>,
}

impl Bunch {
    /// - `knots`: memory for the tables before they are as long as they will be.
    fn new(beams: &[Beam], medium: &Medium, knots: &mut Vec<Knot>, poll: &mut Poll) -> Result<Self, Stop> {
        let mut first = with_room(beams.len() + 1)?;
        knots.clear();
        first.push(0);
        for &Beam { origin, direction, length, .. } in beams {
            let before = knots.len();
            tabulate(knots, medium, (origin, direction), length)?;
            let bytes = size_of_val(&knots[..]);
            first.push(u32::try_from(knots.len()).map_err(|_| Stop::OutOfMemory { bytes })?);
            // Long ways in which few knots are left count, too.
            poll.spend(knots.len() - before + 100, 100)?;
        }
        Ok(Self { knots: fitted(knots, poll)?, first })
    }
}

/// The column up to `distance` on beam `index`. (A column that is returned is put together in memory, which costs a pair 15 ns.)
#[inline(always)]
pub(super) fn up_to(bunches: &[Bunch], distance: f32, index: usize) -> f32 {
    let Bunch { knots, first } = &bunches[index / BUNCH];
    let at = index % BUNCH;
    along_beam(&Column::Knots(&knots[first[at] as usize..first[at + 1] as usize]), distance)
}

impl BeamColumns {
    pub(super) fn new(beams: &[Beam], medium: &Medium, poll: &mut Poll) -> Result<Self, Stop> {
        let density = &medium.density;
        match density {
            Density::Uniform => Ok(Self::Uniform),
            Density::Exponential(_) => {
                let mut densities = with_room(beams.len())?;
                for stretch in beams.chunks(STRETCH) {
                    poll.spend(stretch.len(), 20)?;
                    densities.extend(stretch.iter().map(|beam| density.at(beam.origin)));
                }
                Ok(Self::Exponential(densities))
            }
            Density::Grid(_) => {
                let (mut bunches, mut knots) = (with_room(beams.len().div_ceil(BUNCH))?, Vec::new());
                for bunch in beams.chunks(BUNCH) {
                    bunches.push(Bunch::new(bunch, medium, &mut knots, poll)?);
                }
                Ok(Self::Tables(bunches))
            }
        }
    }

    /// Bytes held.
    pub(super) fn memory(&self) -> usize {
        match self {
            Self::Uniform => 0,
            Self::Exponential(densities) => densities.capacity() * size_of::<f32>(),
            Self::Tables(bunches) => {
                let bytes = |bunch: &Bunch| {
                    bunch.knots.capacity() * size_of::<Knot>() + bunch.first.capacity() * size_of::<u32>()
                };
                bunches.capacity() * size_of::<Bunch>() + bunches.iter().map(bytes).sum::<usize>()
            }
        }
    }
}
