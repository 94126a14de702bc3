//! Options of a session.

use super::sums::Identity;
use crate::pilot::defaults::Given;
use crate::settings::{Method, Settings};
use crate::work::threads::Spawn;

/// How a session renders. The default is covbeam's method with what the scene asks for.
#[derive(Clone, Debug)]
pub struct Options {
    /// What is said of grid and render, for scenes of which nobody has chosen the numbers yet ([`Scene::complete`](crate::scene::Scene::complete)); None: they have them.
    pub given: Option<Given>,
    /// How pictures are made; 0 light paths a pass: as many as the scene says.
    pub settings: Settings,
    /// Number of the first pass, from 0: another machine may render others, and [`Session::merge`](super::Session::merge) adds its sums.
    pub first_pass: u32,
    /// Of scene and numbers, as the host knows them: sums of another one are refused.
    pub identity: Identity,
    /// Threads; 0 = one a core. Results do not depend on it.
    pub threads: u32,
    /// Who starts them; None: they are native threads of the library's.
    pub spawn: Option<Spawn>,
}

impl Default for Options {
    fn default() -> Self {
        let (given, settings) = (Some(Given::default()), Settings::of(Method::Covbeam, 0, 0));
        Self { given, settings, first_pass: 0, identity: Identity::default(), threads: 0, spawn: None }
    }
}
