//! Descriptions of scenes by a host: plain numbers, any of which may be wrong, checked and turned into a [`Scene`].
//!
//! What is wrong is refused with the name of its field: nothing here trusts a number, and what comes out is what [`Scene`] promises to be.

mod camera;
pub mod cast;
mod extent;
mod fields;
pub mod geometry;
mod lights;
mod materials;
mod meshes;
mod shapes;
mod volumes;

pub use camera::CameraFields;
pub use lights::{Light, LightFields, LightKind};
pub use materials::MaterialFields;
pub use meshes::MeshArrays;
pub use shapes::ShapeFields;
pub use volumes::{LobeFields, Volume, VolumeFields};

use crate::host::{Host, HostScene};
use crate::light::shown::Shown;
use crate::object::geometry::Surfaces;
use crate::pilot::defaults::{Given, NO_GRID};
use crate::scene::{GlowingFog, Light as SceneLight, Placed, PlacedObject, Scene, Sees, nest};
use crate::work::failure::{Result, invalid};
use covbeam_geometry::instances::Instances;
use fields::Fields;
use std::sync::Arc;
use volumes::Media;

/// All that a scene is made of but its placed meshes. Copied by [`Description::scene`].
#[derive(Clone, Debug)]
pub struct Description<'a> {
    /// What the materials of meshes, instances and shapes are numbers of.
    pub materials: Vec<MaterialFields>,
    /// What the objects of instances are numbers of.
    pub objects: Vec<ObjectFields>,
    /// Spheres, boxes and rectangles.
    pub shapes: Vec<ShapeFields>,
    /// Media and where they are.
    pub volumes: Vec<Volume<'a>>,
    /// Number of the volume outside of all objects and shapes, or -1.
    pub world_volume: i32,
    /// Lights.
    pub lights: Vec<Light<'a>>,
    /// The camera.
    pub camera: CameraFields,
    /// What pictures show.
    pub sees: Sees,
}

/// What instances of one number have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectFields {
    /// Number of the volume that fills it, or -1.
    pub volume: i32,
    /// Whether it has an inside: fog inside of what is of glass is kept apart from that outside.
    pub is_closed: bool,
    /// Rays that do not see it: the bits of [`Rays`](crate::scene::Rays).
    pub hidden_from: u32,
    /// Which set it is in, for lamps that light some only: below 64.
    pub light_set: u32,
    /// And for those of which some only cast shadows.
    pub shadow_set: u32,
}

impl Description<'_> {
    /// The scene, without a grid and with settings that nobody has chosen yet ([`Scene::complete`]). It has no lights if none reaches
    /// anything, and then no renderer can be made of it.
    ///
    /// # Errors
    /// [`Failure::Invalid`](crate::work::failure::Failure::Invalid) names the field, what it is, and what to give.
    pub fn scene(&self, geometry: Arc<Instances>) -> Result<Scene> {
        self.scene_on((!geometry.is_empty()).then_some(Surfaces::Built(geometry)))
    }

    /// The same with the geometry of a host, which keeps its own: [`HostScene`].
    ///
    /// # Errors
    /// As [`Description::scene`]; its bounds are not finite, or the wrong way round.
    pub fn scene_of_host(&self, host: Arc<dyn HostScene>) -> Result<Scene> {
        let surfaces = Surfaces::Host(Host::new(host, self.objects.len(), self.materials.len()));
        if surfaces.bounds().is_none() {
            return Err(invalid!(
                "geometry.bounds: not finite, or the wrong way round; give a box around all of it"
            ));
        }
        self.scene_on(Some(surfaces))
    }

    fn scene_on(&self, surfaces: Option<Surfaces>) -> Result<Scene> {
        let camera = self.camera.camera()?;
        let host = surfaces.as_ref().and_then(Surfaces::host);
        if camera.is_own && host.is_none() {
            return Err(invalid!("camera.is_own: true; give false where no host keeps the geometry"));
        }
        let made = |(index, fields): (usize, &MaterialFields)| fields.material(index, host.is_some());
        let materials = self.materials.iter().enumerate().map(made);
        let materials = materials.collect::<Result<Vec<_>>>()?;
        let in_shapes: Vec<i32> = self.shapes.iter().map(|shape| shape.volume).collect();
        let media = Media::new(&self.volumes, self.world_volume, &in_shapes)?;
        let placed_objects = self.objects(&media)?;
        let of_shapes = self.materials.iter().zip(&materials).map(|(fields, made)| fields.on_shapes(*made));
        let of_shapes: Vec<_> = of_shapes.collect();
        let shape = |(index, fields): (usize, &ShapeFields)| fields.object(index, &of_shapes, &media);
        let mut objects = self.shapes.iter().enumerate().map(shape).collect::<Result<Vec<_>>>()?;
        nest(&mut objects);
        let bounds = extent::bounds(surfaces.as_ref().and_then(Surfaces::bounds), &objects);
        let lit = extent::lit(&self.volumes, self.world_volume, &self.lights, (bounds, &objects), &camera);
        let lights::Lights { mut lights, visible, links } = lights::lights(&self.lights, &media, &lit, host)?;
        media.check_height(bounds, &lights, &camera)?;
        let shown = Shown::new(&lights, |number| visible[number]);
        lights.extend(GlowingFog::all(&media.all).map(SceneLight::Glow));
        let placed = surfaces.map(|surfaces| Placed::of(surfaces, materials, placed_objects, media.fogs));
        let placed = placed.transpose().map_err(|error| invalid!("{error}"))?;
        let Given { settings, .. } = Given::default();
        Ok(Scene {
            objects,
            placed,
            lights,
            shown,
            links,
            media: media.all,
            outside: media.outside,
            camera,
            grid: NO_GRID,
            settings,
            sees: self.sees,
            notes: Vec::new(),
        })
    }

    fn objects(&self, media: &Media) -> Result<Vec<PlacedObject>> {
        let object = |(index, given): (usize, &ObjectFields)| {
            let ObjectFields { volume, is_closed, .. } = *given;
            let fields = Fields::of("objects", index);
            let fog = match volume {
                -1 => None,
                _ => Some(media.place_of(volume).ok_or_else(|| {
                    invalid!(
                        "objects[{index}].volume: {volume}; give -1, or the number of one of the {} volumes that is neither the \
                         world's nor a sum, and fills no shape",
                        self.volumes.len()
                    )
                })?),
            };
            let heed = fields.heed(given.hidden_from, given.light_set, given.shadow_set)?;
            Ok(PlacedObject { fog, is_closed, heed })
        };
        self.objects.iter().enumerate().map(object).collect()
    }
}
