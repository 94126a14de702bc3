//! What the caller builds a scene with.

use crate::describe::meshes::{Draft, MeshArrays};
use crate::work::GoOn;
use crate::work::failure::{Failure, Result, invalid};
use crate::work::job::Job;
use crate::work::threads;
use covbeam_geometry::instance::Instance;
use covbeam_geometry::instances::Instances;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Meshes and instances: first added, then built, then hit.
#[derive(Default)]
pub struct Geometry(Mutex<State>);

enum State {
    Open { drafts: Vec<Draft>, instances: Vec<Instance> },
    Building,
    Built(Arc<Instances>),
    Failed,
}

impl Default for State {
    fn default() -> Self {
        Self::Open { drafts: Vec::new(), instances: Vec::new() }
    }
}

impl Geometry {
    /// Copies a mesh. Returns its number and how many triangles of no area were dropped.
    pub fn add_mesh(&self, arrays: &MeshArrays) -> Result<(u32, usize)> {
        let draft = Draft::new(arrays)?;
        let mut state = self.locked();
        let State::Open { drafts, .. } = &mut *state else { return Err(too_late("meshes")) };
        let (number, dropped) = (drafts.len(), draft.dropped());
        let number = u32::try_from(number).map_err(|_| invalid!("a geometry has at most 2^32 meshes"))?;
        drafts.push(draft);
        Ok((number, dropped))
    }

    /// Places a mesh: see [`Instance::new`]; a material below 0 leaves the triangles theirs.
    pub fn add_instance(&self, mesh: u32, matrix: &[f64; 16], object: i32, material: i32) -> Result<()> {
        let mut state = self.locked();
        let State::Open { drafts, instances } = &mut *state else { return Err(too_late("instances")) };
        let Some(draft) = drafts.get(mesh as usize) else {
            return Err(invalid!(
                "mesh: {mesh}; give a number that add_mesh returned, there are {}",
                drafts.len()
            ));
        };
        // Hits give numbers back with the bits that they had.
        let material = u32::try_from(material).ok();
        let instance = Instance::new(mesh as usize, matrix, draft.bounds(), object as u32, material);
        instances.push(instance.map_err(|error| invalid!("{error}"))?);
        Ok(())
    }

    /// Builds the hierarchies, on native threads.
    ///
    /// # Errors
    /// They have been built before; `go_on` has said no, and then the geometry is of no more use.
    pub fn build(&self, go_on: GoOn) -> Result<()> {
        let job = self.start()?;
        let built = job.result(go_on, false);
        let mut state = self.locked();
        match built {
            Ok(instances) => *state = State::Built(Arc::new(instances)),
            Err(failure) => {
                *state = State::Failed;
                return Err(failure);
            }
        }
        Ok(())
    }

    fn start(&self) -> Result<Arc<Job<Instances>>> {
        let mut state = self.locked();
        let State::Open { drafts, instances } = &mut *state else { return Err(too_late("hierarchies")) };
        // Threads of their own, which are in nobody's way for as long as it takes them to leave off after the mesh that they are at.
        let pool = threads::pool(0, None)?;
        let (drafts, instances) = (std::mem::take(drafts), std::mem::take(instances));
        let job = Arc::<Job<Instances>>::default();
        let running = Arc::clone(&job);
        pool.spawn(move || {
            let build = |draft: Draft| running.go_on().map(|()| draft.build());
            // One mesh at a time: they differ in size. A panic is told to whoever waits.
            running.run(|| {
                let models = drafts.into_par_iter().with_max_len(1).map(build).collect::<Result<_>>()?;
                running.go_on()?;
                Ok(Instances::new(models, instances))
            });
        });
        *state = State::Building;
        Ok(job)
    }

    /// What has been built.
    pub fn built(&self) -> Result<Arc<Instances>> {
        match &*self.locked() {
            State::Built(scene) => Ok(scene.clone()),
            State::Failed => Err(Failure::Order("geometry: its build was stopped; make a new one".into())),
            _ => Err(Failure::Order("geometry: not built yet; call build first".into())),
        }
    }

    fn locked(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn too_late(what: &str) -> Failure {
    Failure::Order(format!("geometry: {what} come before the build; make a new geometry"))
}
