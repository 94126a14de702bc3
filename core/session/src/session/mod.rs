//! A session: the passes and pictures of a scene, on native threads of its own.

mod info;
mod options;
mod served;
mod state;
mod sums;
mod tasks;

pub use info::{Chosen, Info};
pub use options::Options;
pub use sums::Identity;

use crate::film::Picture;
use crate::film::passes::Passes;
use crate::render::{End, Goal};
use crate::scene::Scene;
use crate::session::state::serve;
use crate::settings::{Layers, Settings};
use crate::work::failure::{Failure, Result};
use crate::work::job::Job;
use crate::work::{self, GoOn};
use served::Served;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use tasks::{Done, Order, Shared, Task, locked};

/// A render. What it is told is done on a thread of its own, one thing after the other, while the caller waits; what was stopped leaves no trace.
pub struct Session {
    orders: Sender<Order>,
    shared: Arc<Shared>,
    /// What goes on.
    current: Mutex<Option<Arc<Job<Done>>>>,
    size: [u32; 2],
    settings: Settings,
    /// Dropped after `orders`, without which the thread ends.
    _served: Served,
}

impl Session {
    /// A session of a scene at one instant or more, while a shutter is open: each is in as many passes, and what moves is blurred. Returns when it
    /// is ready for its first pass: numbers are chosen. The pilot, which takes a second or so, is part of the first pass that is not plain.
    ///
    /// # Errors
    /// Instants that are none, no power of two, or not of one scene; a picture that memory cannot hold; `go_on` has said no.
    pub fn new(instants: &[Arc<Scene>], options: Options, go_on: GoOn) -> Result<Self> {
        state::check_instants(instants)?;
        let camera = &instants[0].camera;
        let kinds = options.settings.layers == Layers::EachKind;
        state::check_memory(&instants[0], options.settings.photons, kinds)?;
        let (size, settings) = ([camera.width, camera.height], options.settings);
        let pool = work::threads::pool(options.threads, options.spawn.as_ref())?;
        let (orders, received) = channel();
        let shared = Arc::<Shared>::default();
        let scenes = instants.iter().map(|scene| scene.as_ref().clone()).collect();
        let seen = Arc::clone(&shared);
        let is_hosted =
            instants.iter().any(|scene| scene.placed.as_ref().is_some_and(|placed| placed.host().is_some()));
        let served = Served::start(pool, is_hosted, move || serve(scenes, &options, &received, &seen));
        let session = Self { orders, shared, current: Mutex::default(), size, settings, _served: served };
        session.done(Task::Prepare, go_on)?;
        Ok(session)
    }

    /// Renders the next pass: the one of the lowest number, from the first on, that it does not hold.
    ///
    /// # Errors
    /// `go_on` has said no: the pass is lost, those before are kept. A pass may have numbers that single precision cannot hold.
    pub fn pass(&self, go_on: GoOn) -> Result<()> {
        self.done(Task::Pass, go_on).map(drop)
    }

    /// Renders passes until a goal is reached; how it ended.
    ///
    /// # Errors
    /// As [`Session::pass`].
    pub fn until(&self, goal: Goal, go_on: GoOn) -> Result<End> {
        match self.done(Task::Until(goal), go_on)? {
            Done::Reached(end) => Ok(end),
            _ => unreachable!("the answer to another task"),
        }
    }

    /// The picture of the passes done, at least one. Made once, and kept until there is another pass.
    ///
    /// # Errors
    /// There is no pass; `go_on` has said no.
    pub fn picture(&self, go_on: GoOn) -> Result<Arc<Picture>> {
        if let Some(picture) = locked(&self.shared.picture).clone() {
            return Ok(picture);
        }
        match self.done(Task::Picture, go_on)? {
            Done::Picture(picture) => Ok(picture),
            _ => unreachable!("the answer to another task"),
        }
    }

    /// The exact sums of the passes done, as bytes: the same for the same passes, whoever has rendered them in whatever order.
    ///
    /// # Errors
    /// There is no pass; `go_on` has said no.
    pub fn save(&self, go_on: GoOn) -> Result<Vec<u8>> {
        match self.done(Task::Save, go_on)? {
            Done::Sums(bytes) => Ok(bytes),
            _ => unreachable!("the answer to another task"),
        }
    }

    /// Adds sums that [`Session::save`] gave, here or elsewhere: of the same scene and settings, and of other passes. Pictures have the same bits as
    /// if all passes had been rendered here.
    ///
    /// # Errors
    /// [`Failure::Data`]: the bytes are no sums, damaged, or of another picture, or hold passes that are there already. Nothing has changed then.
    pub fn merge(&self, bytes: &[u8], go_on: GoOn) -> Result<()> {
        self.done(Task::Merge(bytes.to_vec()), go_on).map(drop)
    }

    /// Forgets all passes; those to come have so many light paths, at least one and at most those of the settings. Plain ones do without a
    /// pilot that learns where light paths are needed: that is a first look, to be seen soon.
    ///
    /// # Errors
    /// Another call goes on.
    pub fn restart(&self, photons: u32, plain: bool) -> Result<()> {
        self.done(Task::Restart { photons, plain }, &mut || true).map(drop)
    }

    /// Where it stands.
    pub fn info(&self) -> Info {
        *locked(&self.shared.info)
    }

    /// The passes that it holds.
    pub fn passes(&self) -> Passes {
        locked(&self.shared.passes).clone()
    }

    /// Those that it was made with; 0 light paths a pass: as many as the scene says.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Has a task done while this thread asks whether to go on.
    fn done(&self, task: Task, go_on: GoOn) -> Result<Done> {
        // The passes of a goal come one by one: those that are done count.
        let keeps_work = matches!(task, Task::Until(_));
        let job = Arc::<Job<Done>>::default();
        {
            let mut current = locked(&self.current);
            if current.is_some() {
                return Err(Failure::Busy("session: busy, another call on it has not returned yet".into()));
            }
            *current = Some(Arc::clone(&job));
        }
        let _ending = Ending(self);
        // Dropped if there is no thread any more, which ends the job.
        drop(self.orders.send(Order { task, job: Arc::clone(&job) }));
        job.result(go_on, keeps_work)
    }
}

/// Nothing goes on any more once this is dropped.
struct Ending<'a>(&'a Session);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        if let Some(job) = locked(&self.0.current).take() {
            // Of a `go_on` that has panicked.
            job.cancel();
        }
    }
}
