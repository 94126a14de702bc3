//! Light transport in a scene: what light goes through, how much paths may weigh, and what acts on light
//! fields.

use crate::paths::operators::Operator;
use crate::paths::weight::Limits;
use crate::scene::{Scene, media};
use crate::surface::origin::Origin;
use covbeam::{Density, Medium};

/// What is the same for all light paths of a scene.
pub(super) struct Transport<'a> {
    pub(super) scene: &'a Scene,
    /// By region.
    pub(super) fogs: Vec<Medium<'a>>,
    /// Where the pinhole is.
    pub(super) camera: Origin,
    pub(super) limits: Limits,
    /// Whether all rays see everything alike, and lamps light everything.
    pub(super) is_plain: bool,
    /// None: all operators act.
    pub(super) left_out: Option<Operator>,
}

impl<'a> Transport<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            fogs: media::all(scene),
            camera: Origin::new(scene, scene.camera.position),
            limits: Limits::new(scene),
            is_plain: scene.is_plain(),
            left_out: None,
        }
    }

    /// Whether an operator acts on light fields.
    #[inline]
    pub(super) fn acts(&self, operator: Operator) -> bool {
        self.left_out != Some(operator)
    }

    /// The medium as it acts on light fields.
    #[inline]
    pub(super) fn acting<'m>(&self, fog: &Medium<'m>) -> Medium<'m> {
        let density = if self.acts(Operator::Attenuation) { fog.density } else { Density::Uniform };
        Medium { density, ..*fog }
    }
}
