//! Saves the work now and then, so that what ends the program costs seconds of a long render, not all of it.

use super::job::{Job, Target};
use covbeam_render::files::output::OutputError;
use covbeam_session::film::Film;
use covbeam_session::render::Progress;
use std::time::{Duration, Instant};

/// When something is saved next.
struct Clock {
    next: Instant,
    every: Duration,
    /// Saving takes at most one part in so many of the time.
    share: u32,
    /// How long it took the last time.
    took: Duration,
    /// Passes in what was saved; 0: nothing was.
    passes: u32,
}

impl Clock {
    /// Saved after the first pass for the first time.
    fn new(every: Duration, share: u32) -> Self {
        Self { next: Instant::now(), every, share, took: Duration::ZERO, passes: 0 }
    }

    /// Does nothing if the film has no other passes than were saved: who asks for the end while it is saved waits once.
    fn save(
        &mut self,
        film: &Film,
        save: impl FnOnce() -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        if film.passes() == self.passes {
            return Ok(());
        }
        let start = Instant::now();
        save()?;
        self.passes = film.passes();
        self.took = start.elapsed();
        self.next = Instant::now() + self.every.max(self.took * self.share);
        Ok(())
    }
}

/// The picture, and the shard that the render goes on from.
pub(super) struct Saving<'a> {
    job: &'a Job,
    picture: Clock,
    shard: Clock,
    /// Passes in the shard; None: it may hold anything, and is replaced.
    stored: Option<u32>,
}

impl<'a> Saving<'a> {
    const PICTURE_EVERY: Duration = Duration::from_secs(10);
    const SHARD_EVERY: Duration = Duration::from_secs(60);

    /// `checkpoint`: time between two shards, where the user gives one; `stored`: passes in the shard that this goes on from, None: in any
    /// that is there.
    pub(super) fn new(job: &'a Job, checkpoint: Option<Duration>, stored: Option<u32>) -> Self {
        let shard = match checkpoint {
            Some(every) => Clock::new(every, 0),
            None => Clock::new(Self::SHARD_EVERY, 100),
        };
        Self { job, picture: Clock::new(Self::PICTURE_EVERY, 20), shard, stored }
    }

    /// How long saving takes, if it was time to.
    pub(super) fn after_pass(
        &mut self,
        progress: &Progress,
        film: &Film,
    ) -> Result<Option<Duration>, OutputError> {
        let goal = &self.job.goal;
        // The end of the render saves all anyway.
        let ends = progress.reaches(goal)
            || goal.time.is_some_and(|time| progress.elapsed + 2 * progress.saving + progress.last > time);
        let now = Instant::now();
        let (picture, shard) = (now >= self.picture.next, now >= self.shard.next);
        if ends || !(picture || shard) {
            return Ok(None);
        }
        if let (true, Target::Picture(files)) = (picture, &self.job.target) {
            self.picture.save(film, || files.save(film))?;
        }
        if shard {
            self.save_shard(film)?;
        }
        Ok(Some(self.picture.took + self.shard.took))
    }

    /// Saves the picture and the shard.
    pub(super) fn save_all(&mut self, film: &Film) -> Result<(), OutputError> {
        // The work first: a picture can be made of it again.
        self.save_shard(film)?;
        match &self.job.target {
            Target::Picture(files) => self.picture.save(film, || files.save(film)),
            Target::Piece(_) => Ok(()),
        }
    }

    fn save_shard(&mut self, film: &Film) -> Result<(), OutputError> {
        self.shard.save(film, || self.job.save_shard(film, self.stored))?;
        self.stored = Some(film.passes());
        Ok(())
    }
}
