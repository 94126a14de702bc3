//! Scenes as a caller describes them: plain numbers, any of which may be wrong, checked and turned into the renderer's.
//!
//! What is wrong is refused with the name of its field, as the Python module has it: nothing here trusts a number, and what comes out
//! is what [`covbeam_session::scene::Scene`] promises to be.

mod camera;
mod extent;
mod fields;
mod lights;
mod materials;
mod volumes;

pub use camera::CameraFields;
pub use lights::{Light, LightFields};
pub use materials::MaterialFields;
pub use volumes::{Volume, VolumeFields};

use crate::failure::{Result, invalid};
use covbeam_geometry::instances::Instances;
use covbeam_session::pilot::defaults::{Given, NO_GRID};
use covbeam_session::scene::{GlowingFog, Light as RenderLight, Placed, PlacedObject, Scene, Sees, Shown};
use std::sync::Arc;
use volumes::Media;

/// All that a scene is made of but its geometry.
#[derive(Clone, Debug)]
pub struct Description<'a> {
    /// What the materials of hits are numbers of.
    pub materials: &'a [MaterialFields],
    /// Of each object, the number of the volume that fills it, or -1.
    pub object_volumes: &'a [i32],
    /// Of each object, not 0 if it has an inside.
    pub object_closed: &'a [u8],
    /// Media and where they are.
    pub volumes: Vec<Volume<'a>>,
    /// Number of the volume outside of all objects, or -1.
    pub world_volume: i32,
    /// Lights.
    pub lights: Vec<Light<'a>>,
    /// The camera.
    pub camera: CameraFields,
}

impl Description<'_> {
    /// The scene, without a grid and with settings that nobody has chosen yet. It has no lights if none reaches anything, and then no
    /// renderer can be made of it.
    pub fn scene(&self, geometry: Arc<Instances>) -> Result<Scene> {
        let camera = self.camera.camera()?;
        let materials = self.materials.iter().enumerate().map(|(index, fields)| fields.material(index));
        let materials = materials.collect::<Result<Vec<_>>>()?;
        let media = Media::new(&self.volumes, self.world_volume)?;
        let objects = self.objects(&media)?;
        let lit = extent::lit(&self.volumes, self.world_volume, &self.lights, &geometry, &camera);
        let mut lights = lights::lights(&self.lights, &media, &lit)?;
        lights.extend(GlowingFog::all(&media.all).map(RenderLight::Glow));
        let placed = match geometry.is_empty() {
            true => None,
            false => {
                let placed = Placed::new(geometry, materials, objects, media.fogs);
                Some(placed.map_err(|error| invalid!("{error}"))?)
            }
        };
        let Given { settings, .. } = Given::default();
        Ok(Scene {
            objects: Vec::new(),
            placed,
            lights,
            shown: Shown::default(),
            media: media.all,
            outside: media.outside,
            camera,
            grid: NO_GRID,
            settings,
            sees: Sees::FogAlone,
            notes: Vec::new(),
        })
    }

    fn objects(&self, media: &Media) -> Result<Vec<PlacedObject>> {
        let (volumes, closed) = (self.object_volumes, self.object_closed);
        if volumes.len() != closed.len() {
            let (given, wanted) = (closed.len(), volumes.len());
            return Err(invalid!("object_closed: {given} for {wanted} objects; give one each"));
        }
        let object = |(index, (&volume, &closed)): (usize, (&i32, &u8))| {
            let fog = match volume {
                -1 => None,
                _ => Some(media.place_of(volume).ok_or_else(|| {
                    invalid!(
                        "object_volumes[{index}]: {volume}; give -1, or the number of one of the {} volumes that is neither the \
                         world's nor a sum",
                        self.volumes.len()
                    )
                })?),
            };
            Ok(PlacedObject { fog, is_closed: closed != 0 })
        };
        volumes.iter().zip(closed).enumerate().map(object).collect()
    }
}
