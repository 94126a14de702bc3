//! How a picture is made: the catalogue of methods, and what each is made of.

use crate::gather::march::Marching;
use crate::kind::Split;
use crate::paths::operators::Operator;
use crate::plan::radius::RadiusRule;
use crate::random::Emission;
use crate::scene::Scene;

/// The catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain progressive photon beams: one radius for all beams of a pass, an eye ray through every pixel.
    Plain,
    /// The thesis: beams as wide as the covariance of the light allows, an eye ray through every pixel.
    Thesis,
    /// The default: the thesis, and straight light by shadow rays, light paths where the picture needs them, few eye rays where the
    /// covariance says that the picture is smooth, filters between them.
    Covbeam,
    /// Unbiased connections of every path segment and diffuse vertex with the camera; blind to what is seen through glass. For pinholes
    /// ([`crate::camera::Camera::is_pinhole`]): pictures of other cameras are black.
    LightTrace,
    /// Light scattered once, by shadow rays from places along the eye rays.
    March,
}

/// What eye rays gather.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gather {
    /// Beams, all as wide as the pass says.
    Plain,
    /// Beams as wide as the covariance allows.
    Adaptive,
    /// Nothing: light paths are connected with the camera.
    LightTrace,
    /// Light scattered once.
    March,
}

/// Layers of light: each has spectra, eye rays and filters of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layers {
    /// One, with one width for beams of all kinds of light.
    Alike,
    /// One; focused light has narrower kernels where filters smooth the noise, and the disks of its photons follow how dense they are.
    Together,
    /// As before, and straight light apart. A layer of its own for it costs a tenth of a pass, and has .7 to 1.3 times the error.
    StraightApart,
    /// One for each kind of light that the scene can have, for a film that keeps them apart.
    EachKind,
}

impl Layers {
    /// In a scene; None: kinds are not told apart.
    pub(crate) fn split(self, scene: &Scene) -> Option<Split> {
        match self {
            Self::Alike => None,
            Self::Together => Some(Split::TOGETHER),
            Self::StraightApart => Some(Split::STRAIGHT_APART),
            Self::EachKind => Some(Split::of_each_kind(scene)),
        }
    }
}

/// How a picture is made: chosen before the first pass. [`Settings::of`] has those of a method; change what is to be otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What eye rays gather.
    pub gather: Gather,
    /// Light paths a pass, >= 1. Guided ones that leave few beams are up to 8 times as many.
    pub photons: u32,
    /// Another seed gives another noise, the same seed the same bits.
    pub seed: u32,
    /// How light paths are drawn.
    pub emission: Emission,
    /// Whether light paths go where the picture needs them, after a pilot that depends on scene and seed alone. For [`Gather::Adaptive`].
    pub guided: bool,
    /// Whether straight light comes from shadow rays. For [`Gather::Adaptive`].
    pub shadow_rays: bool,
    /// Layers of light. For [`Gather::Adaptive`].
    pub layers: Layers,
    /// Whether there are few eye rays where the covariance grid says that the picture is smooth, with filters between them (thesis 5.3.2); kernel
    /// radii are then looked up only in passes where spectra may make them three times as wide as the pass' own, and layer σ is 0 in the others.
    /// Methods without a grid, and scenes without fog before the first surface that is more than a bound of fog, have an eye ray through every
    /// pixel all the same.
    pub planned: bool,
    /// Whether planned passes keep the fog before the first surface apart always: where no pixel's middle sees any, with an eye ray through
    /// each pixel; and tell its layer σ where kernels look nothing up, too.
    pub first_apart: bool,
    /// Whether there is light from the first surface on that is more than a bound of fog; what the fog before it sends out is there always.
    pub beyond: bool,
    /// What kernel radii come from. With a rule other than [`RadiusRule::Bias`] the layer σ of the picture is the one that gives the same radii
    /// by that rule, and a pass that is asked for out of order traces all light paths of the earlier ones. For [`Gather::Adaptive`].
    pub radius_rule: RadiusRule,
    /// How places along eye rays are chosen. For [`Gather::March`].
    pub marching: Marching,
    /// An operator that is left out of all light fields, to see what it buys.
    pub left_out: Option<Operator>,
}

impl Settings {
    /// Those of a method.
    pub fn of(method: Method, photons: u32, seed: u32) -> Self {
        let is_default = method == Method::Covbeam;
        Self {
            gather: match method {
                Method::Plain => Gather::Plain,
                Method::Thesis | Method::Covbeam => Gather::Adaptive,
                Method::LightTrace => Gather::LightTrace,
                Method::March => Gather::March,
            },
            photons,
            seed,
            emission: Emission::LowDiscrepancy,
            guided: is_default,
            shadow_rays: is_default,
            layers: if is_default { Layers::Together } else { Layers::Alike },
            planned: is_default,
            first_apart: false,
            beyond: true,
            radius_rule: RadiusRule::Bias,
            marching: Marching::default(),
            left_out: None,
        }
    }

    /// Those of a method, with as many light paths a pass as the scene says.
    pub fn of_scene(method: Method, scene: &Scene, seed: u32) -> Self {
        Self::of(method, scene.settings.light_paths(method == Method::Covbeam), seed)
    }

    /// Whether light leaves its spectra in a grid.
    pub(crate) fn has_grid(&self) -> bool {
        matches!(self.gather, Gather::Adaptive | Gather::March)
    }
}
