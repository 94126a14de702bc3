//! What surfaces are made of.

pub(crate) mod kept;
pub(crate) mod microfacet;

use glam::Vec3;

/// What light does at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a scene holds few objects")]
pub enum Material {
    /// Smooth glass or water; only on closed shapes (sphere, box, closed mesh).
    Dielectric {
        /// Index of refraction inside, > 0; outside is the surrounding dielectric or 1.
        index: f32,
    },
    /// Perfect mirror.
    Mirror {
        /// Per channel, 0..=1.
        reflectance: Vec3,
    },
    /// Ideal diffuse, two-sided.
    Lambert {
        /// Per channel, 0..=1.
        albedo: Vec3,
    },
    /// Absorbs everything.
    Black,
    /// Lets all light go straight on, as if nothing were there: it bounds a medium. No silhouette, no event of a light or eye path.
    Clear,
    /// Any mixture of rough or smooth metal and glass, coats, diffuse reflection and transmission.
    Lobes(Lobes),
}

/// The ways in which a surface sends light on, as factors per channel of the lobes that it is the sum of, each 0..=1; what they leave is
/// absorbed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes {
    /// Lambert reflection.
    pub diffuse: Vec3,
    /// Lambert transmission: paper, leaves, lampshades.
    pub translucent: Vec3,
    /// Reflectance of a metal at normal incidence.
    pub metal: Vec3,
    /// And at grazing incidence; Schlick's curve lies between them.
    pub edge: Vec3,
    /// Factor on what a boundary of glass reflects by Fresnel's equations.
    pub glass_reflection: Vec3,
    /// And on what it refracts. With either of the two the object is a dielectric, closed, and may hold a medium.
    pub glass_transmission: Vec3,
    /// Factor on what a clear coat over the diffuse part reflects; the diffuse part gets what is left of it.
    pub coat: Vec3,
    /// Share that goes straight on, as if nothing were there.
    pub transparent: Vec3,
    /// The same of light on its way from a lamp, of which the other lobes lose nothing then; None: as of all light.
    pub shadow: Option<Vec3>,
    /// Index of refraction of glass and coat, > 0.
    pub index: f32,
    /// GGX's α of metal, glass and coat, 0..=1; 0: smooth.
    pub alpha: f32,
    /// Whether light that facets hide from each other goes on all the same, after many of them (Blender's *multiple scattering*): of metal and
    /// coat in the directions of what has met one, of glass as if they hid nothing; else it is lost.
    pub multiscatter: bool,
    /// What a host is asked for at each hit.
    pub asks: Asks,
}

/// What a host that keeps its own geometry is asked for where a material is met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Asks {
    /// Nothing: the material is the same everywhere.
    #[default]
    Nothing,
    /// Which lobes there are at the hit: [`HostScene::lobes`](crate::host::HostScene::lobes).
    Lobes,
    /// That, and the ways on, which a scattering function of the host's draws: [`HostScene::ways`](crate::host::HostScene::ways).
    Ways,
}

impl Lobes {
    /// Of a surface that absorbs everything.
    pub const NONE: Self = Self {
        diffuse: Vec3::ZERO,
        translucent: Vec3::ZERO,
        metal: Vec3::ZERO,
        edge: Vec3::ZERO,
        glass_reflection: Vec3::ZERO,
        glass_transmission: Vec3::ZERO,
        coat: Vec3::ZERO,
        transparent: Vec3::ZERO,
        shadow: None,
        index: 1.5,
        alpha: 0.0,
        multiscatter: false,
        asks: Asks::Nothing,
    };

    /// Most light, per channel, that all of them together may send on.
    pub fn most(&self) -> Vec3 {
        self.diffuse.max(self.coat)
            + self.translucent
            + self.metal.max(self.edge)
            + self.glass_reflection.max(self.glass_transmission)
            + self.transparent
    }

    /// Whether it bounds a dielectric.
    pub(crate) fn is_glass(&self) -> bool {
        self.glass_reflection.max(self.glass_transmission) != Vec3::ZERO
    }

    fn shines(&self) -> bool {
        self.is_glass() || self.metal.max(self.edge).max(self.coat) != Vec3::ZERO
    }

    /// Whether eye rays are followed from it.
    pub(crate) fn shows_through(&self) -> bool {
        self.shines() || self.transparent != Vec3::ZERO
    }

    /// Whether it is rough, so that light of a lamp leaves it in all directions.
    pub(crate) fn is_rough(&self) -> bool {
        self.alpha > 0.0 && self.shines()
    }
}

impl Material {
    /// The same in the plainest form, which paths treat best: most surfaces are of one lobe. What is nearly smooth is.
    pub fn of_lobes(mut lobes: Lobes) -> Self {
        if lobes.alpha < SMOOTH {
            lobes.alpha = 0.0;
        }
        if lobes.shadow == Some(lobes.transparent) {
            lobes.shadow = None;
        }
        if lobes.asks != Asks::Nothing || lobes.shadow.is_some() {
            return Self::Lobes(lobes);
        }
        let Lobes { diffuse, metal, edge, index, alpha, multiscatter, .. } = lobes;
        let alone = |of: Lobes| lobes == Lobes { index, alpha, multiscatter, ..of };
        let glass = Lobes { glass_reflection: Vec3::ONE, glass_transmission: Vec3::ONE, ..Lobes::NONE };
        if lobes.transparent.min_element() >= 1.0 {
            Self::Clear
        } else if alone(Lobes::NONE) {
            Self::Black
        } else if alone(Lobes { diffuse, ..Lobes::NONE }) {
            Self::Lambert { albedo: diffuse }
        } else if alone(Lobes { metal, edge, ..Lobes::NONE }) && metal == edge && alpha == 0.0 {
            Self::Mirror { reflectance: metal }
        } else if alone(glass) && alpha == 0.0 {
            if index == 1.0 { Self::Clear } else { Self::Dielectric { index } }
        } else {
            Self::Lobes(lobes)
        }
    }

    /// Whether it lets all light go straight on.
    pub fn is_clear(&self) -> bool {
        matches!(self, Self::Clear)
    }

    /// Whether light that goes through it is inside of glass then, if what it bounds is closed.
    pub(crate) fn has_inside(&self) -> bool {
        match self {
            Self::Dielectric { .. } => true,
            Self::Lobes(lobes) => lobes.glass_transmission != Vec3::ZERO,
            _ => false,
        }
    }

    /// The index of refraction of what the object is filled with; None: it is no dielectric.
    pub fn index(self) -> Option<f32> {
        match self {
            Self::Dielectric { index } => Some(index),
            Self::Lobes(lobes) if lobes.is_glass() => Some(lobes.index),
            _ => None,
        }
    }

    /// Whether it is a mirror or glass: a box of fog with the index of air is neither. Where an index of 1 would bend light, it is inside
    /// of one that does too.
    pub fn bends_light(self) -> bool {
        match self {
            Self::Mirror { .. } => true,
            Self::Dielectric { index } => index != 1.0,
            Self::Lobes(lobes) => lobes.shines() && lobes.alpha <= FOCUSING,
            Self::Black | Self::Clear | Self::Lambert { .. } => false,
        }
    }

    /// Share of the light that it reflects diffusely, or sends through itself.
    pub(crate) fn diffuse(self) -> Vec3 {
        match self {
            Self::Lambert { albedo } => albedo,
            Self::Lobes(lobes) => lobes.diffuse + lobes.translucent,
            _ => Vec3::ZERO,
        }
    }

    /// The same as a sum of lobes.
    pub(crate) fn lobes(&self) -> Lobes {
        match *self {
            Self::Lobes(lobes) => lobes,
            Self::Clear => Lobes { transparent: Vec3::ONE, ..Lobes::NONE },
            Self::Black => Lobes::NONE,
            Self::Lambert { albedo } => Lobes { diffuse: albedo, ..Lobes::NONE },
            Self::Mirror { reflectance } => Lobes { metal: reflectance, edge: reflectance, ..Lobes::NONE },
            Self::Dielectric { index } => {
                let (glass_reflection, glass_transmission) = (Vec3::ONE, Vec3::ONE);
                Lobes { glass_reflection, glass_transmission, index, ..Lobes::NONE }
            }
        }
    }

    /// What of it lets light go straight on that is on its way from a lamp.
    pub(crate) fn shadow(&self) -> Vec3 {
        match self {
            Self::Lobes(Lobes { shadow: Some(shadow), .. }) => *shadow,
            material => material.transparent(),
        }
    }

    /// What of it lets light go straight on.
    pub(crate) fn transparent(self) -> Vec3 {
        match self {
            Self::Lobes(lobes) => lobes.transparent,
            Self::Clear => Vec3::ONE,
            _ => Vec3::ZERO,
        }
    }
}

/// GGX's α below which a surface is smooth: it turns light by less than half a pixel of most pictures.
pub const SMOOTH: f32 = 1e-3;

/// From this α on a surface is no mirror and no clear glass: it spreads light over some 5°, and path tracers find its light.
pub(crate) const SHARP: f32 = 0.04;

/// Rougher surfaces than this one's α spread light over 10° and more, make no caustics, and their light is as smooth as what is scattered.
/// With spectra and eye rays of its own fog around a rough reflector (α = .2) has 3.5 times the variance at equal time, and fog among leaves
/// (α = .25) 1.6 times.
pub(crate) const FOCUSING: f32 = 0.12;
