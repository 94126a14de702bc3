//! What the caller builds a scene with.

use crate::failure::{Failure, Result, invalid};
use crate::job::Job;
use crate::mesh::{Draft, MeshArrays};
use crate::threads;
use covbeam_geometry::instance::Instance;
use covbeam_geometry::instances::Instances;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Meshes and instances: first added, then built, then hit.
#[derive(Default)]
pub struct Geometry(Mutex<State>);

enum State {
    Open { drafts: Vec<Draft>, instances: Vec<Instance> },
    Building(Arc<Job<Instances>>),
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

    /// Starts building the hierarchies.
    pub fn build(&self) -> Result<()> {
        let mut state = self.locked();
        let State::Open { drafts, instances } = &mut *state else { return Err(too_late("hierarchies")) };
        let (drafts, instances) = (std::mem::take(drafts), std::mem::take(instances));
        let job = Arc::<Job<Instances>>::default();
        // Threads of their own, which are in nobody's way for as long as it takes them to stop.
        let (running, pool) = (Arc::clone(&job), threads::pool(0)?);
        pool.spawn(move || {
            let build = |draft: Draft| running.go_on().map(|()| draft.build());
            // One mesh at a time: they differ in size. A panic is told to whoever waits.
            running.run(|| {
                let models = drafts.into_par_iter().with_max_len(1).map(build).collect::<Result<_>>()?;
                running.go_on()?;
                Ok(Instances::new(models, instances))
            });
        });
        *state = State::Building(job);
        Ok(())
    }

    /// Waits for the end of the build, at most this long; true = it has been reached.
    pub fn wait(&self, longest: Duration) -> Result<bool> {
        let job = match &*self.locked() {
            State::Building(job) => job.clone(),
            _ => return Err(Failure::Order("geometry: no build goes on; call build first".into())),
        };
        match job.wait(longest) {
            None => Ok(false),
            Some(Ok(scene)) => {
                *self.locked() = State::Built(Arc::new(scene));
                Ok(true)
            }
            Some(Err(failure)) => {
                *self.locked() = State::Failed;
                Err(failure)
            }
        }
    }

    /// Stops a build: the threads leave off after the mesh that they are at, for which this does not wait.
    pub fn cancel(&self) {
        let mut state = self.locked();
        if let State::Building(job) = &*state {
            job.cancel();
            *state = State::Failed;
        }
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

impl Drop for Geometry {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn too_late(what: &str) -> Failure {
    Failure::Order(format!("geometry: {what} come before the build; make a new geometry"))
}
