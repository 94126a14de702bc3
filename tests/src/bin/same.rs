//! Whether a host's picture has the bits of the reference renderer's: `same SCENE.toml PASSES PICTURE.pfm`.

use covbeam_tests::session_picture::session_picture;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, passes, picture] = &arguments[..] else {
        return Err("usage: same SCENE.toml PASSES PICTURE.pfm".into());
    };
    let (head, ours) = session_picture(Path::new(scene), passes.parse()?)?;
    let file = std::fs::read(picture)?;
    let theirs = file.strip_prefix(head.as_bytes()).ok_or("not a picture of this size")?;
    let differing = ours.chunks(12).zip(theirs.chunks(12)).filter(|(a, b)| a != b).count();
    if ours.len() != theirs.len() || differing > 0 {
        return Err(format!("{differing} of {} pixels differ", ours.len() / 12).into());
    }
    println!("same: {} pixels of {passes} passes, bit for bit", ours.len() / 12);
    Ok(())
}
