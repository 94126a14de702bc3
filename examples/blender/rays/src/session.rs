//! Renders a scene pass by pass, on native threads.

use crate::failure::{Failure, Result, invalid};
use crate::job::Job;
use crate::picture::Picture;
use crate::threads;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_session::film::Film;
use covbeam_session::film::samples::PassImage;
use covbeam_session::pass::memory;
use covbeam_session::pass::{Instants, PassTimes};
use covbeam_session::pilot::defaults::{Cells, Given, complete_all};
use covbeam_session::plan::FirstSurfaces;
use covbeam_session::scene::{MAX_PHOTONS, Scene};
use covbeam_session::settings::{Method, Settings};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How to render. See Settings in the extension's `host/session.py`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsFields {
    /// Of the kernels in the first pass \[m\]; 0 = the scene's own.
    pub radius: f64,
    /// Relative bias that kernels and filters of the first pass may cause.
    pub quality: f64,
    /// The same picture for the same seed.
    pub seed: u32,
    /// Light paths a pass; 0 = the scene's own.
    pub photons: u32,
    /// Voxels along the longest side of the grid; 0 = the scene's own.
    pub grid: u32,
    /// Largest number of scatterings and reflections of light, -1 for any.
    pub bounces: i32,
    /// Not 0: fog behind the first surface is rendered too, through glass and in mirrors.
    pub beyond: u32,
    /// Threads; 0 = one a core.
    pub threads: u32,
}

/// Voxels along a side of the grid.
const MOST_VOXELS: u32 = 256;

impl SettingsFields {
    fn given(&self) -> Result<Given> {
        let Self { radius, quality, seed, photons, grid, bounces, threads, .. } = *self;
        let wrong = |name: &str, value: &dyn std::fmt::Display, wanted: &str| {
            Err(invalid!("settings.{name}: {value}; give {wanted}"))
        };
        if !(radius == 0.0 || (1e-9..=f64::from(MAX_COORDINATE)).contains(&radius)) {
            return wrong("radius", &radius, "a number from 1e-9 to 1e9, or 0 for the scene's own");
        }
        if !(1e-6..=1.0).contains(&quality) {
            return wrong("quality", &quality, "a number from 1e-6 to 1");
        }
        if photons > MAX_PHOTONS {
            return wrong(
                "photons",
                &photons,
                &format!("a number from 1 to {MAX_PHOTONS}, or 0 for the scene's own"),
            );
        }
        if grid > MOST_VOXELS {
            return wrong(
                "grid",
                &grid,
                &format!("a number from 1 to {MOST_VOXELS}, or 0 for the scene's own"),
            );
        }
        if bounces < -1 {
            return wrong("bounces", &bounces, "a number from 0 on, or -1 for any");
        }
        if threads > threads::MOST {
            return wrong(
                "threads",
                &threads,
                &format!("a number from 1 to {}, or 0 for one a core", threads::MOST),
            );
        }
        let mut given = Given {
            cells: (grid > 0).then_some(Cells::Longest(grid)),
            photons: (photons > 0).then_some(photons),
            radius: (radius > 0.0).then_some(radius as f32),
            ..Given::default()
        };
        // Of a scene that is dark.
        given.settings.guided_photons = given.photons.unwrap_or(given.settings.guided_photons);
        given.settings.seed = seed;
        given.settings.schedule.error = quality as f32;
        given.settings.bounces = u32::try_from(bounces).ok();
        Ok(given)
    }
}

/// What passes and pictures have taken \[s\], by part.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Light paths.
    pub photons: f64,
    /// What some of them carry.
    pub fields: f64,
    /// What is kept of that in voxels.
    pub grid: f64,
    /// Hierarchies of beams.
    pub beams: f64,
    /// Where eye rays and light paths are needed.
    pub plan: f64,
    /// Eye rays, and the beams around them.
    pub gather: f64,
    /// Pictures.
    pub picture: f64,
}

impl Times {
    /// Adds a pass that has taken so long on all threads.
    fn add(&mut self, pass: &PassTimes, seconds: f64) {
        let scale = seconds / pass.total().max(f64::MIN_POSITIVE);
        self.photons += scale * pass.trace;
        self.fields += scale * pass.light_fields;
        self.grid += scale * pass.grid;
        self.beams += scale * pass.build;
        self.plan += scale * pass.plan;
        self.gather += scale * pass.gather;
    }
}

/// Where a session stands.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SessionInfo {
    /// What has been spent.
    pub times: Times,
    /// Accepted pairs of beam and eye ray, of all passes.
    pub pairs: u64,
    /// What light and picture are expected to take at most \[bytes\].
    pub memory: u64,
    /// Passes done.
    pub passes: u32,
    /// Light paths of a pass.
    pub photons: u32,
    /// Those that the settings ask for.
    pub most_photons: u32,
}

/// What a session can be told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// To get ready, which it does unasked.
    Prepare,
    /// The next pass.
    Pass,
    /// A picture of the passes done.
    Picture,
}

/// A render. What it is told is done on a thread of its own, one thing after the other; what was stopped leaves no trace.
pub struct Session {
    orders: Sender<Order>,
    shared: Arc<Shared>,
    job: Mutex<Option<Arc<Job<()>>>>,
    pixel_count: usize,
}

/// What the session's thread and its caller both see.
#[derive(Default)]
struct Shared {
    info: Mutex<SessionInfo>,
    picture: Mutex<Option<Picture>>,
}

enum Order {
    Do(Task, Arc<Job<()>>),
    Restart(u32, bool),
}

impl Drop for Order {
    fn drop(&mut self) {
        // Nothing happens if it was carried out.
        if let Self::Do(_, job) = self {
            let message = "session: it was stopped before it was ready, or has failed; make a new one";
            job.end(Err(Failure::Order(message.into())));
        }
    }
}

impl Session {
    /// A session of a scene at one instant or more, while a shutter is open: each is in as many passes, and what moves is blurred. It begins
    /// to get ready for its first pass: wait for that, as for all that is started. Stopped before, it can only be dropped.
    pub fn new(instants: &[Arc<Scene>], settings: &SettingsFields) -> Result<Self> {
        let given = settings.given()?;
        check_instants(instants)?;
        let scene = &instants[0];
        check_memory(scene, settings.photons)?;
        let (pool, beyond) = (threads::pool(settings.threads)?, settings.beyond != 0);
        let (orders, received) = channel();
        let shared = Arc::<Shared>::default();
        let pixel_count = scene.camera.width as usize * scene.camera.height as usize;
        let scenes = instants.iter().map(|scene| scene.as_ref().clone()).collect();
        let seen = Arc::clone(&shared);
        pool.spawn(move || serve(scenes, &given, beyond, &received, &seen));
        let session = Self { orders, shared, job: Mutex::default(), pixel_count };
        session.order(Task::Prepare, &mut lock(&session.job));
        Ok(session)
    }

    /// Starts a task.
    pub fn start(&self, task: Task) -> Result<()> {
        let mut current = lock(&self.job);
        if current.is_some() {
            return Err(Failure::Order("session: work goes on; wait for its end, or stop it".into()));
        }
        if task == Task::Picture && self.info().passes == 0 {
            return Err(Failure::Order("session: a picture needs a pass; start one first".into()));
        }
        self.order(task, &mut current);
        Ok(())
    }

    fn order(&self, task: Task, current: &mut Option<Arc<Job<()>>>) {
        let job = Arc::<Job<()>>::default();
        *current = Some(Arc::clone(&job));
        // Dropped if there is no thread any more, which ends the job.
        drop(self.orders.send(Order::Do(task, job)));
    }

    /// Waits for the end of what was started, at most this long; true = it has been reached.
    pub fn wait(&self, longest: Duration) -> Result<bool> {
        let job = lock(&self.job).clone();
        let job = job.ok_or_else(|| Failure::Order("session: no work goes on; start some".into()))?;
        let Some(result) = job.wait(longest) else { return Ok(false) };
        *lock(&self.job) = None;
        result.map(|()| true)
    }

    /// Stops what goes on, without waiting for its threads. Where a pass is being added up, it is done when this returns.
    pub fn stop(&self) {
        let job = lock(&self.job).take();
        job.into_iter().for_each(|job| job.cancel());
    }

    /// Forgets all passes; those to come have so many light paths, at least one and at most those of the settings. Plain ones do without a
    /// pilot that learns where light paths are needed: that is a first look, to be seen soon.
    pub fn restart(&self, photons: u32, plain: bool) -> Result<()> {
        if lock(&self.job).is_some() {
            return Err(Failure::Order("session: work goes on; wait for its end, or stop it".into()));
        }
        let mut info = lock(&self.shared.info);
        let photons = photons.clamp(1, info.most_photons);
        drop(self.orders.send(Order::Restart(photons, plain)));
        (info.passes, info.photons) = (0, photons);
        Ok(())
    }

    /// Where it stands.
    pub fn info(&self) -> SessionInfo {
        *lock(&self.shared.info)
    }

    /// Of a picture.
    pub fn pixel_count(&self) -> usize {
        self.pixel_count
    }

    /// The picture that was made last; given once.
    pub fn picture(&self) -> Result<Picture> {
        let picture = lock(&self.shared.picture).take();
        picture.ok_or_else(|| Failure::Order("session: no picture has been made; start one".into()))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.stop();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Refuses instants that cannot be of one picture.
fn check_instants(instants: &[Arc<Scene>]) -> Result<()> {
    let Some(first) = instants.first() else { return Err(invalid!("scenes: none; give at least one")) };
    if !instants.len().is_power_of_two() {
        return Err(invalid!("scenes: {}; give a power of two of them", instants.len()));
    }
    let size = |scene: &Scene| (scene.camera.width, scene.camera.height);
    for (number, scene) in instants.iter().enumerate() {
        let what = if size(scene) != size(first) {
            "a picture of another size"
        } else if scene.media.len() != first.media.len() {
            "another number of volumes"
        } else if scene.lights_fog() != first.lights_fog() {
            "light in fog, or none, unlike the first"
        } else {
            continue;
        };
        return Err(invalid!("scenes[{number}]: {what}; give one scene at several instants"));
    }
    Ok(())
}

/// Refuses a picture that memory cannot hold.
fn check_memory(scene: &Scene, photons: u32) -> Result<()> {
    let (needed, available) = (memory::needed(scene, photons, false), memory::available());
    let Some(available) = available.filter(|available| needed > *available) else { return Ok(()) };
    let (width, height) = (scene.camera.width, scene.camera.height);
    let [needed, available] = [needed, available].map(|bytes| bytes as f64 / 1e9);
    Err(Failure::Memory(format!(
        "a picture of {width} x {height} pixels with {photons} light paths a pass needs about {needed:.2} GB of memory, and {available:.2} GB are \
         available"
    )))
}

/// The session's thread: carries orders out until there is nobody to give any.
fn serve(mut scenes: Vec<Scene>, given: &Given, beyond: bool, orders: &Receiver<Order>, shared: &Shared) {
    let mut state = None;
    let Ok(first) = orders.recv() else { return };
    let Order::Do(_, job) = &first else { return };
    let start = Instant::now();
    let ready = job.run(|| {
        let scenes = &mut scenes;
        if scenes[0].lights_fog() {
            complete_all(scenes, given);
        } else {
            scenes.iter_mut().for_each(|scene| scene.settings = given.settings);
        }
        job.go_on()?;
        let ready = State::new(scenes, beyond, job)?;
        job.close()?;
        let photons = ready.photons;
        *lock(&shared.info) = SessionInfo {
            memory: memory::needed(&ready.scenes[0], photons, false),
            photons,
            most_photons: photons,
            times: Times { plan: start.elapsed().as_secs_f64(), ..Times::default() },
            ..SessionInfo::default()
        };
        state = Some(ready);
        Ok(())
    });
    let (true, Some(mut state)) = (ready, state) else { return };
    for order in orders {
        match &order {
            Order::Restart(photons, plain) => state.restart(*photons, *plain),
            Order::Do(task, job) => {
                let done = job.run(|| match task {
                    Task::Prepare => Ok(()),
                    Task::Pass => state.pass(job, shared),
                    Task::Picture => state.picture(job, shared),
                });
                if !done {
                    return;
                }
            }
        }
    }
}

/// What the thread keeps from order to order.
struct State<'a> {
    /// One an instant.
    scenes: &'a [Scene],
    /// Whether what is behind the first surface is rendered.
    beyond: bool,
    /// Of all instants. None: nothing lights any fog.
    surfaces: Option<Arc<FirstSurfaces>>,
    /// What renders passes, and what renders plain ones. None until they are needed.
    renderers: [Option<Instants<'a>>; 2],
    film: Film,
    /// Light paths of a pass.
    photons: u32,
    plain: bool,
}

impl<'a> State<'a> {
    fn new(scenes: &'a [Scene], beyond: bool, job: &Job<()>) -> Result<Self> {
        let surfaces = |scene| FirstSurfaces::new(scene, &|| job.is_cancelled()).ok_or(Failure::Cancelled);
        let surfaces = || scenes.iter().map(surfaces).collect::<Result<_>>().map(FirstSurfaces::over);
        let surfaces = scenes[0].lights_fog().then(surfaces).transpose()?.map(Arc::new);
        let photons = scenes[0].settings.guided_photons;
        Ok(Self {
            scenes,
            beyond,
            surfaces,
            renderers: Default::default(),
            film: Film::of_scene(&scenes[0]),
            photons,
            plain: false,
        })
    }

    fn restart(&mut self, photons: u32, plain: bool) {
        (self.photons, self.plain) = (photons, plain);
        self.film = Film::of_scene(&self.scenes[0]);
        self.renderers.iter_mut().flatten().for_each(|renderer| renderer.restart(photons));
    }

    /// What renders passes; None: they are black.
    fn renderer(&mut self, job: &Job<()>) -> Result<Option<&mut Instants<'a>>> {
        let Some(surfaces) = self.surfaces.as_ref() else { return Ok(None) };
        let Self { scenes, beyond, photons, plain, .. } = *self;
        let renderer = &mut self.renderers[usize::from(plain)];
        if renderer.is_none() {
            let settings = Settings {
                guided: !plain,
                first_apart: true,
                beyond,
                ..Settings::of(Method::Covbeam, photons, scenes[0].settings.seed)
            };
            let surfaces = Some(Arc::clone(surfaces));
            let made = Instants::new(scenes, settings, surfaces, &|| job.is_cancelled());
            *renderer = Some(made.ok_or(Failure::Cancelled)?);
        }
        Ok(renderer.as_mut())
    }

    fn pass(&mut self, job: &Job<()>, shared: &Shared) -> Result<()> {
        let (start, index) = (Instant::now(), self.film.passes() + 1);
        let (image, times) = match self.renderer(job)? {
            Some(renderer) => renderer.pass(index, &|| job.is_cancelled()).ok_or(Failure::Cancelled)?,
            None => (PassImage::black(&self.scenes[0].camera, index), PassTimes::default()),
        };
        job.close()?;
        let wrong =
            |error| invalid!("the scene's light or fog is beyond what single precision holds: {error}");
        self.film.add(&image).map_err(wrong)?;
        let mut info = lock(&shared.info);
        info.times.add(&times, start.elapsed().as_secs_f64());
        info.pairs += times.pairs;
        info.passes = self.film.passes();
        Ok(())
    }

    fn picture(&self, job: &Job<()>, shared: &Shared) -> Result<()> {
        let start = Instant::now();
        let made = self.film.picture_unless(&|| job.is_cancelled()).ok_or(Failure::Cancelled)?;
        let picture = Picture::new(made);
        job.close()?;
        *lock(&shared.picture) = Some(picture);
        lock(&shared.info).times.picture += start.elapsed().as_secs_f64();
        Ok(())
    }
}
