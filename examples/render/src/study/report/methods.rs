//! The methods that a report compares: one table.

use covbeam_session::plan::radius::RadiusRule;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};

/// A method as the report knows it.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    /// Name, on the command line, in plots and in files.
    pub name: &'static str,
    /// What it is, for a reader.
    pub about: &'static str,
    /// Its colour everywhere, sRGB, of the palette of Okabe and Ito, which all eyes can tell apart.
    pub color: [u8; 3],
    method: Method,
    radius_rule: RadiusRule,
}

impl Compared {
    /// What makes a picture of `scene` by it, with the scene's light paths a pass.
    pub fn settings(&self, scene: &Scene, seed: u32) -> Settings {
        Settings { radius_rule: self.radius_rule, ..Settings::of_scene(self.method, scene, seed) }
    }

    /// The method of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.iter().find(|method| method.name == name)
    }
}

/// All methods. The first one is what the others are compared with.
pub const METHODS: &[Compared] = &[
    Compared {
        name: "plain",
        about: "plain progressive photon beams: one radius for all beams, an eye ray through every pixel in each pass",
        color: [213, 94, 0],
        method: Method::Plain,
        radius_rule: RadiusRule::Bias,
    },
    Compared {
        name: "thesis",
        about: "beams as wide as the covariance of the light allows, an eye ray through every pixel in each pass",
        color: [0, 158, 115],
        method: Method::Thesis,
        radius_rule: RadiusRule::Bias,
    },
    Compared {
        name: "covbeam",
        about: "what covbeam render does: straight light by shadow rays, light paths where the picture needs them, few eye rays where the \
                covariance says that the picture is smooth, and filters between them",
        color: [0, 114, 178],
        method: Method::Covbeam,
        radius_rule: RadiusRule::Bias,
    },
    Compared {
        name: "least-error",
        about: "as thesis, but kernels as wide as the sum of squared bias and variance is least",
        color: [230, 159, 0],
        method: Method::Thesis,
        radius_rule: RadiusRule::LeastError,
    },
    Compared {
        name: "density",
        about: "as thesis, but kernels as wide as the beams around are sparse, without any covariance",
        color: [204, 121, 167],
        method: Method::Thesis,
        radius_rule: RadiusRule::BeamDensity,
    },
];
