//! Materials.

use super::fields::Fields;
use crate::material::Asks;
use crate::scene::{Lobes, Material};
use crate::work::failure::Result;

/// How a surface treats light: weights per channel of the lobes that it is the sum of. See MATERIAL in the extension's `host/scene.py`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialFields {
    /// Of Lambert reflection.
    pub diffuse: [f32; 3],
    /// Of Lambert transmission.
    pub translucent: [f32; 3],
    /// Reflectance of a microfacet mirror at normal incidence.
    pub metal: [f32; 3],
    /// And at grazing incidence.
    pub edge: [f32; 3],
    /// Factor on what a dielectric boundary reflects.
    pub glass_reflection: [f32; 3],
    /// And on what it transmits.
    pub glass_transmission: [f32; 3],
    /// Weight of a dielectric reflection over what is diffuse.
    pub coat: [f32; 3],
    /// Of light that goes straight on.
    pub transparent: [f32; 3],
    /// The same of light on its way from a lamp, of which the other lobes lose nothing then; None: as of all light.
    pub shadow: Option<[f32; 3]>,
    /// Refractive index of glass and coat, over that of the side that the normal points to.
    pub ior: f32,
    /// GGX's alpha of metal, glass and coat.
    pub roughness: f32,
    /// What a host is asked for at each hit; what is described is the most that any place has then.
    pub asks: Asks,
}

impl MaterialFields {
    /// - `has_host`: whether one keeps the geometry.
    pub(super) fn material(&self, index: usize, has_host: bool) -> Result<Material> {
        let fields = Fields::of("materials", index);
        if self.asks != Asks::Nothing && !has_host {
            return Err(fields.wrong("asks", self.asks, "Nothing where no host keeps the geometry"));
        }
        let weight = |name, value: [f32; 3]| fields.color(name, value.map(f64::from), 1.0);
        Ok(Material::of_lobes(Lobes {
            diffuse: weight("diffuse", self.diffuse)?,
            translucent: weight("translucent", self.translucent)?,
            metal: weight("metal", self.metal)?,
            edge: weight("edge", self.edge)?,
            glass_reflection: weight("glass_reflection", self.glass_reflection)?,
            glass_transmission: weight("glass_transmission", self.glass_transmission)?,
            coat: weight("coat", self.coat)?,
            transparent: weight("transparent", self.transparent)?,
            shadow: self.shadow.map(|shadow| weight("shadow", shadow)).transpose()?,
            index: fields.number("ior", self.ior.into(), 1e-3..=1e3)?,
            alpha: fields.number("roughness", self.roughness.into(), 0.0..=1.0)?,
            multiscatter: true,
            asks: self.asks,
        }))
    }

    /// The same on shapes, which glass fills even where its index of 1 bends nothing: it bounds what is inside.
    pub(super) fn on_shapes(&self, material: Material) -> Material {
        let is_glass = self.glass_transmission != [0.0; 3] && self.transparent != [1.0; 3];
        if is_glass && material.is_clear() { Material::Dielectric { index: 1.0 } } else { material }
    }
}
