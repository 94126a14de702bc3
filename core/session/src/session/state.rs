//! The session's thread: what it keeps from task to task, and how it does them.

use super::info::{Chosen, Info};
use super::options::Options;
use super::sums::{self, Identity};
use super::tasks::{Done, Order, Shared, Task, locked};
use crate::film::passes::{PassRange, Passes};
use crate::film::samples::PassImage;
use crate::film::{Film, FilmError};
use crate::kind::{ByKind, Split};
use crate::pass::memory;
use crate::pass::{Instants, PassTimes};
use crate::pilot::defaults::{Given, complete_all};
use crate::plan::FirstSurfaces;
use crate::render::{Goal, Progress, RenderError, render};
use crate::scene::Scene;
use crate::settings::{Gather, Layers, Settings};
use crate::work::failure::{Failure, Result, invalid};
use crate::work::job::Job;
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// Refuses instants that cannot be of one picture.
pub(super) fn check_instants(instants: &[Arc<Scene>]) -> Result<()> {
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
        } else if scene.is_lit() != first.is_lit() {
            "light, or none, unlike the first"
        } else {
            continue;
        };
        return Err(invalid!("scenes[{number}]: {what}; give one scene at several instants"));
    }
    Ok(())
}

/// Refuses a picture that memory cannot hold.
pub(super) fn check_memory(scene: &Scene, photons: u32, kinds: bool) -> Result<()> {
    let (needed, available) = (memory::needed(scene, photons, kinds), memory::available());
    let Some(available) = available.filter(|available| needed > *available) else { return Ok(()) };
    let (width, height) = (scene.camera.width, scene.camera.height);
    let [needed, available] = [needed, available].map(|bytes| bytes as f64 / 1e9);
    Err(Failure::Memory(format!(
        "a picture of {width} x {height} pixels with {photons} light paths a pass needs about {needed:.2} GB of memory, and {available:.2} GB are \
         available"
    )))
}

/// Carries orders out until there is nobody to give any, or one has panicked.
pub(super) fn serve(mut scenes: Vec<Scene>, options: &Options, orders: &Receiver<Order>, shared: &Shared) {
    let mut state = None;
    let Ok(first) = orders.recv() else { return };
    let (start, job) = (Instant::now(), &first.job);
    let is_ready = job.run(|| {
        complete(&mut scenes, options.given.as_ref());
        job.go_on()?;
        let ready = State::new(&scenes, options, job)?;
        job.close()?;
        *locked(&shared.info) = ready.info(start.elapsed());
        state = Some(ready);
        Ok(Done::Nothing)
    });
    let (true, Some(mut state)) = (is_ready, state) else { return };
    for mut order in orders {
        let task = std::mem::replace(&mut order.task, Task::Prepare);
        let job = &order.job;
        if !job.run(|| state.work(task, job, shared)) {
            return;
        }
    }
}

/// Gives instants of which nobody has chosen the numbers theirs.
fn complete(scenes: &mut [Scene], given: Option<&Given>) {
    let Some(given) = given else { return };
    if scenes[0].is_lit() {
        complete_all(scenes, given);
    } else {
        scenes.iter_mut().for_each(|scene| scene.settings = given.settings);
    }
}

/// What the thread keeps from task to task.
struct State<'a> {
    /// One an instant.
    scenes: &'a [Scene],
    settings: Settings,
    /// Light paths of a pass that the settings ask for.
    most_photons: u32,
    /// Of all instants. None: no eye rays are planned, or nothing is lit.
    surfaces: Option<Arc<FirstSurfaces>>,
    /// What renders passes, and what renders plain ones. None until they are needed.
    renderers: [Option<Instants<'a>>; 2],
    film: Film,
    /// In the film.
    passes: Passes,
    first_pass: u32,
    identity: Identity,
    plain: bool,
}

impl<'a> State<'a> {
    fn new(scenes: &'a [Scene], options: &Options, job: &Job<Done>) -> Result<Self> {
        let (scene, mut settings) = (&scenes[0], options.settings);
        if settings.photons == 0 {
            settings.photons = scene.settings.light_paths(settings.guided);
        }
        if settings.gather == Gather::LightTrace {
            // It tells no kinds of light apart.
            settings.layers = Layers::Alike;
        }
        let surfaces = |scene| FirstSurfaces::new(scene, &|| job.is_cancelled()).ok_or(Failure::Cancelled);
        let surfaces = || scenes.iter().map(surfaces).collect::<Result<_>>().map(FirstSurfaces::over);
        let surfaces = (settings.planned && scene.is_lit()).then(surfaces).transpose()?.map(Arc::new);
        let mut state = Self {
            scenes,
            settings,
            most_photons: settings.photons,
            surfaces,
            renderers: Default::default(),
            film: Film::of_scene(scene),
            passes: Passes::default(),
            first_pass: options.first_pass,
            identity: options.identity,
            plain: false,
        };
        state.film = state.empty_film();
        Ok(state)
    }

    fn empty_film(&self) -> Film {
        let mut film = Film::of_scene(&self.scenes[0]);
        if self.settings.layers == Layers::EachKind {
            film.keep_kinds(Split::of_each_kind(&self.scenes[0]));
        }
        film
    }

    fn info(&self, prepared: Duration) -> Info {
        let scene = &self.scenes[0];
        let Settings { photons, layers, .. } = self.settings;
        Info {
            photons,
            most_photons: photons,
            memory: memory::needed(scene, photons, layers == Layers::EachKind),
            times: PassTimes { plan: prepared.as_secs_f64(), ..PassTimes::default() },
            chosen: Chosen {
                grid: scene.grid,
                schedule: scene.settings.schedule,
                photons: scene.settings.photons,
                guided_photons: scene.settings.guided_photons,
            },
            ..Info::default()
        }
    }

    fn work(&mut self, task: Task, job: &Job<Done>, shared: &Shared) -> Result<Done> {
        let lacks_passes = match task {
            Task::Picture => Some("a picture needs a pass; render one first"),
            Task::Save => Some("there are no sums without a pass; render one first"),
            _ => None,
        };
        if let Some(why) = lacks_passes.filter(|_| self.film.passes() == 0) {
            return Err(Failure::Order(format!("session: {why}")));
        }
        match task {
            Task::Prepare => Ok(Done::Nothing),
            Task::Pass => self.pass(job, shared).map(|()| Done::Nothing),
            Task::Until(goal) => self.until(&goal, job, shared),
            Task::Picture => self.picture(job, shared),
            Task::Save => {
                let bytes = sums::save(&self.origin(), &self.passes, &self.film);
                job.close()?;
                Ok(Done::Sums(bytes))
            }
            Task::Merge(bytes) => self.merge(&bytes, job, shared),
            Task::Restart { photons, plain } => {
                job.close()?;
                self.restart(photons, plain, shared);
                Ok(Done::Nothing)
            }
        }
    }

    fn restart(&mut self, photons: u32, plain: bool, shared: &Shared) {
        (self.settings.photons, self.plain) = (photons.clamp(1, self.most_photons), plain);
        (self.film, self.passes) = (self.empty_film(), Passes::default());
        let photons = self.settings.photons;
        self.renderers.iter_mut().flatten().for_each(|renderer| renderer.restart(photons));
        show(shared, &self.film, &self.passes);
        locked(&shared.info).photons = photons;
    }

    /// The pass of a number, from 0. Black where nothing is lit.
    fn image(
        &mut self,
        number: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let index = number + 1;
        if !self.scenes[0].is_lit() {
            let mut image = PassImage::black(&self.scenes[0].camera, index);
            if self.settings.layers == Layers::EachKind {
                image.kinds = vec![ByKind::default(); image.radiance.len()];
            }
            return Some((image, PassTimes::default()));
        }
        let settings = Settings { guided: self.settings.guided && !self.plain, ..self.settings };
        let renderer = &mut self.renderers[usize::from(self.plain)];
        if renderer.is_none() {
            *renderer = Some(Instants::new(self.scenes, settings, self.surfaces.clone(), cancelled)?);
        }
        renderer.as_mut()?.pass(index, cancelled)
    }

    fn pass(&mut self, job: &Job<Done>, shared: &Shared) -> Result<()> {
        let (start, number) = (Instant::now(), next(&self.passes, self.first_pass));
        let (image, times) = self.image(number, &|| job.is_cancelled()).ok_or(Failure::Cancelled)?;
        job.close()?;
        self.film.add(&image).map_err(|error| too_bright(&error))?;
        self.passes.add(&PassRange { start: number, end: number + 1 }.into());
        show(shared, &self.film, &self.passes);
        locked(&shared.info).add(&times, start.elapsed().as_secs_f64());
        Ok(())
    }

    fn until(&mut self, goal: &Goal, job: &Job<Done>, shared: &Shared) -> Result<Done> {
        let mut film = std::mem::replace(&mut self.film, Film::new(1, 1));
        let passes = RefCell::new(std::mem::take(&mut self.passes));
        let (latest, first) = (Cell::default(), self.first_pass);
        let pass = |_, cancelled: &(dyn Fn() -> bool + Sync)| {
            let number = next(&passes.borrow(), first);
            let (image, times) = self.image(number, cancelled)?;
            latest.set((number, times));
            Some((image, times))
        };
        let report = |progress: &Progress, film: &Film| {
            let (number, times) = latest.get();
            passes.borrow_mut().add(&PassRange { start: number, end: number + 1 }.into());
            show(shared, film, &passes.borrow());
            locked(&shared.info).add(&times, progress.last.as_secs_f64());
            Ok::<_, Infallible>(None)
        };
        let ended = render(&mut film, goal, Instant::now(), &|| job.is_cancelled(), pass, report);
        (self.film, self.passes) = (film, passes.into_inner());
        // The last pass of a picture that stays dark is not reported.
        if self.passes.count() < self.film.passes() {
            let (number, _) = latest.get();
            self.passes.add(&PassRange { start: number, end: number + 1 }.into());
            show(shared, &self.film, &self.passes);
        }
        match ended {
            Ok((end, _)) => Ok(Done::Reached(end)),
            Err(RenderError::Pass { source, .. }) => Err(too_bright(&source)),
            Err(RenderError::Report(never)) => match never {},
        }
    }

    fn origin(&self) -> sums::Origin {
        (self.identity, self.settings.photons, self.plain)
    }

    fn picture(&self, job: &Job<Done>, shared: &Shared) -> Result<Done> {
        let start = Instant::now();
        let made = self.film.picture_unless(&|| job.is_cancelled()).ok_or(Failure::Cancelled)?;
        job.close()?;
        let picture = Arc::new(made);
        *locked(&shared.picture) = Some(Arc::clone(&picture));
        locked(&shared.info).picture += start.elapsed().as_secs_f64();
        Ok(Done::Picture(picture))
    }

    fn merge(&mut self, bytes: &[u8], job: &Job<Done>, shared: &Shared) -> Result<Done> {
        let stored = sums::open(bytes, &self.origin())?;
        if let Some(range) = self.passes.overlap(&stored.passes) {
            return Err(Failure::Data(format!("sums: passes {range} are there already; merge others")));
        }
        // What is damaged is found out half-way.
        let mut film = self.film.clone();
        let added = stored.add_to(&mut film)?;
        job.close()?;
        self.film = film;
        self.passes.add(&added);
        show(shared, &self.film, &self.passes);
        Ok(Done::Nothing)
    }
}

/// Lets callers see other passes than before.
fn show(shared: &Shared, film: &Film, passes: &Passes) {
    locked(&shared.info).passes = film.passes();
    *locked(&shared.passes) = passes.clone();
    *locked(&shared.picture) = None;
}

/// The lowest number of a pass, from `first` on, that is not there.
fn next(passes: &Passes, first: u32) -> u32 {
    passes.gaps(PassRange { start: first, end: u32::MAX }).first().map_or(u32::MAX - 1, |gap| gap.start)
}

fn too_bright(error: &FilmError) -> Failure {
    invalid!("the scene's light or fog is beyond what single precision holds: {error}")
}
