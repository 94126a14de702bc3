//! How much memory a picture needs, and how much there is: asked before the work, not found out after a minute of it.

use crate::scene::Scene;

/// Bytes a pixel of the film's sums (120) and of the plan (17), and what the allocator keeps for the next picture.
const FILM_BYTES_A_PIXEL: u64 = 155;
/// Bytes a pixel of a picture while it is made, to which the allocator adds a few. (Measured, with those of the film, at 1920 x 1080 and
/// 3840 x 2160.) The eye rays of a pass take 80 at most.
const PICTURE_BYTES_A_PIXEL: u64 = 90;
/// Bytes a pixel more of a film that keeps the kinds of light apart, and of its picture.
const KINDS_BYTES_A_PIXEL: u64 = 310;

/// Of a light path's beams while their hierarchy is built, and of the program itself.
const BYTES_A_PATH: u64 = 2000;
const BYTES_ALWAYS: u64 = 30_000_000;

/// Bytes that rendering a scene is expected to take at most, with `photons` light paths a pass; `kinds`: whether the film keeps the kinds of
/// light apart.
pub fn needed(scene: &Scene, photons: u32, kinds: bool) -> u64 {
    let pixels = u64::from(scene.camera.width) * u64::from(scene.camera.height);
    let layers = if kinds { 3 } else { 1 };
    let cells = scene.grid.cell_count() as u64 * 84 * layers;
    // No beams are left when the picture is made.
    let most = (pixels * PICTURE_BYTES_A_PIXEL).max(u64::from(photons) * BYTES_A_PATH);
    let film = pixels * (FILM_BYTES_A_PIXEL + if kinds { KINDS_BYTES_A_PIXEL } else { 0 });
    BYTES_ALWAYS + film + most + cells
}

/// Bytes that this process may still take: what the system has available, within the limits of its control group and of its address space;
/// None where the system does not tell.
pub fn available() -> Option<u64> {
    let number = |path: &str| std::fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let free = line("/proc/meminfo", "MemAvailable:").map(|kibibytes| kibibytes * 1024);
    let group = number("/sys/fs/cgroup/memory.max")
        .map(|most| most.saturating_sub(number("/sys/fs/cgroup/memory.current").unwrap_or(0)));
    let space = line("/proc/self/limits", "Max address space").map(|most| {
        most.saturating_sub(line("/proc/self/status", "VmSize:").map_or(0, |kibibytes| kibibytes * 1024))
    });
    [free, group, space].into_iter().flatten().min()
}

/// Largest resident set of this process so far \[bytes\]; None where the system does not tell.
pub fn peak() -> Option<u64> {
    line("/proc/self/status", "VmHWM:").map(|kibibytes| kibibytes * 1024)
}

/// The number after `start` in a file of such lines.
fn line(path: &str, start: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(start))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linux_machine_says_how_much_memory_it_has() {
        if cfg!(target_os = "linux") {
            assert!(available().is_some_and(|bytes| bytes > 1 << 20));
        }
    }
}
