# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip as an artist gets it: checked, installed into a fresh profile, used, removed; and broken in all known ways.

COVBEAM_ZIP names the zip. Each test starts Blender (the bpy package of the Python that runs this) anew, with a
profile of its own.
"""

import contextlib
import io
import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

from in_profile import BLENDER_EXT, ZIP, InProfile, obey_permissions

BUILD = Path(__file__).resolve().parents[1] / "build.py"
sys.path.insert(0, str(BUILD.parent))
import build


def blender_ext(*arguments):
    """What Blender's own tool prints."""
    ended = subprocess.run(
        [sys.executable, str(BLENDER_EXT), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    if ended.returncode != 0:
        raise AssertionError(ended.stdout)
    return ended.stdout


def wheels_for(folder, *tags):
    """The zip's wheel for this machine under the names of other platforms."""
    with zipfile.ZipFile(ZIP) as archive:
        (name,) = (name for name in archive.namelist() if "linux" in name and name.endswith(f"{platform.machine()}.whl"))
        data = archive.read(name)
    start = Path(name).name.rsplit("-", 1)[0]
    paths = [Path(folder, f"{start}-{tag}.whl") for tag in tags]
    for path in paths:
        path.write_bytes(data)
    return paths


def newer_wheel(wheel):
    """A copy of a wheel and its library whose version begins with 9."""
    version = wheel.name.split("-")[1]
    newer = "9" + version[1:]
    contents = {}
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            end = "\0" if "libcovbeam" in name else ""
            data = archive.read(name)
            if end or ".dist-info/" in name:
                data = data.replace(f"{version}{end}".encode(), f"{newer}{end}".encode())
            contents[name.replace(f"-{version}.", f"-{newer}.")] = data
    path = wheel.with_name(wheel.name.replace(version, newer))
    build.write_zip(path, contents)
    return path


def copy_zip(path, change_manifest, names=lambda name: name):
    """A copy of the zip with another manifest, and files under other names."""
    with zipfile.ZipFile(ZIP) as archive, zipfile.ZipFile(path, "w") as copy:
        for name in archive.namelist():
            data = archive.read(name)
            copy.writestr(names(name), change_manifest(data.decode()).encode() if name == "blender_manifest.toml" else data)


class Package(unittest.TestCase):
    def test_blenders_own_tool_accepts_the_zip(self):
        self.assertNotIn("warning", blender_ext("validate", ZIP).lower())

    def test_blenders_own_tool_builds_the_same_files(self):
        with tempfile.TemporaryDirectory() as folder:
            source, output = Path(folder) / "source", Path(folder) / "output"
            output.mkdir()
            with zipfile.ZipFile(ZIP) as archive:
                archive.extractall(source)
                names = {name: archive.read(name) for name in archive.namelist()}
            blender_ext("build", "--source-dir", source, "--output-dir", output)
            (built,) = output.glob("*.zip")
            with zipfile.ZipFile(built) as archive:
                self.assertEqual(
                    {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}, names
                )

    def test_the_zip_is_the_same_each_time(self):
        with tempfile.TemporaryDirectory() as folder:
            contents = {"b/c.py": b"x" * 1000, "a.py": b"y"}
            first, second = Path(folder) / "1.zip", Path(folder) / "2.zip"
            build.write_zip(first, contents)
            build.write_zip(second, dict(reversed(contents.items())))
            self.assertEqual(first.read_bytes(), second.read_bytes())

    def test_one_zip_is_for_all_platforms_that_wheels_are_for_and_updates_from_a_repository(self):
        import tomllib

        tags = ("manylinux_2_17_x86_64", "manylinux_2_28_aarch64", "macosx_11_0_arm64", "macosx_10_12_x86_64", "win_amd64", "win_arm64")
        platforms = ["linux-arm64", "linux-x64", "macos-arm64", "macos-x64", "windows-arm64", "windows-x64"]
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            made = build.build(Path(folder, "made"), wheels_for(folder, *tags))
            self.assertRegex(made.name, r"^covbeam-[0-9.]+\.zip$")
            self.assertNotIn("warning", blender_ext("validate", made).lower())
            with zipfile.ZipFile(made) as archive:
                archive.extractall(Path(folder, "source"))
                manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            self.assertEqual(manifest["platforms"], platforms)
            self.assertEqual(len(manifest["wheels"]), len(tags))
            # Blender's own tool finds one wheel for each.
            repository = Path(folder, "repository")
            repository.mkdir()
            blender_ext("build", "--source-dir", Path(folder, "source"), "--output-dir", repository, "--split-platforms")
            split = {path.stem.split("-", 2)[2].replace("_", "-"): path for path in repository.glob("*.zip")}
            self.assertEqual(sorted(split), platforms)
            for path in split.values():
                with zipfile.ZipFile(path) as archive:
                    self.assertEqual(len([name for name in archive.namelist() if name.endswith(".whl")]), 1)
            # A folder of zips that Blender installs and updates from.
            shutil.rmtree(repository)
            repository.mkdir()
            shutil.copy(made, repository)
            blender_ext("server-generate", "--repo-dir", repository)
            (listed,) = json.loads(Path(repository, "index.json").read_text())["data"]
            self.assertEqual((listed["id"], listed["platforms"]), ("covbeam", platforms))
            self.assertEqual((listed["archive_url"], listed["archive_size"]), (f"./{made.name}", made.stat().st_size))

    def test_wheels_that_do_not_go_together_are_refused_with_one_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            one, other, newer = wheels_for(folder, "manylinux_2_17_x86_64", "manylinux_2_28_x86_64", "win_amd64")
            newer = newer.rename(newer.with_name(f"covbeam-9.9.9-{newer.name.split('-', 2)[2]}"))
            text = Path(folder, "covbeam.zip")
            text.write_text("none")
            unknown, both, missing = wheels_for(folder, "musllinux_1_2_x86_64", "macosx_11_0_universal2", "win_arm64")
            missing.unlink()
            for words, wheels in {
                "are for the same platform": [one, other],
                "are of versions": [one, newer],
                "covbeam.zip is no wheel of covbeam's": [text],
                "win_arm64.whl is no wheel of covbeam's": [missing],
                "no name for the platform of covbeam-.*musllinux": [unknown],
                "no name for the platform of covbeam-.*universal2": [both],
            }.items():
                ended = subprocess.run(
                    [sys.executable, str(BUILD), "--output", folder, *map(str, wheels)], stderr=subprocess.PIPE, text=True
                )
                self.assertEqual(ended.returncode, 1)
                self.assertRegex(ended.stderr, rf"\Abuild.py: .*{words}.*\.\n\Z")

    def test_the_manifest_names_what_the_zip_has_and_where_it_runs(self):
        import tomllib

        with zipfile.ZipFile(ZIP) as archive:
            manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            wheels = [f"./{name}" for name in archive.namelist() if name.startswith("wheels/")]
            python = [name for name in archive.namelist() if name.endswith(".py")]
            for name in python:
                self.assertTrue(archive.read(name).startswith(b"# SPDX-License-Identifier: GPL-3.0-or-later\n"), name)
        self.assertEqual(sorted(manifest["wheels"]), wheels)
        self.assertGreater(len(wheels), 0)
        self.assertEqual(len(manifest["platforms"]), len(wheels))
        self.assertEqual(manifest["blender_version_min"], "4.2.0")


class Life(InProfile):
    def test_install_enable_render_disable_uninstall(self):
        output = self.run_blender("""
install()
print("enabled:", module in addons(), hasattr(bpy.types.Scene, "covbeam"))
import covbeam
print("from:", covbeam.__file__)
fog()
render("picture.png")
print("rendered:", os.path.getsize("picture.png") > 0, extension("latest").get().outcome)
bpy.context.scene.render.engine = "CYCLES"
bpy.context.scene.cycles.samples = 1
bpy.context.scene.covbeam.folder = os.path.abspath("beams")
# The factory's world shines, and its light in fog is not Covbeam's.
print("beams:", bpy.ops.covbeam.add_beams(replace=True), os.listdir("beams"))
bpy.ops.render.render(write_still=True)
bpy.ops.covbeam.remove_beams()
bpy.ops.preferences.addon_disable(module=module)
print("disabled:", module in addons(), hasattr(bpy.types.Scene, "covbeam"))
engines = [engine for engine in bpy.types.RenderEngine.__subclasses__() if engine.is_registered]
print("engine:", "COVBEAM" in [getattr(engine, "bl_idname", None) for engine in engines])
directory = bpy.context.preferences.extensions.repos["User Default"].directory
bpy.ops.extensions.package_uninstall(repo_directory=directory, pkg_id="covbeam")
""")
        self.assert_told(
            output,
            "enabled: True True",
            "rendered: True Outcome.DONE",
            "beams: {'FINISHED'} ['beams_ViewLayer_0001.exr']",
            "disabled: False False",
            "engine: False",
        )
        self.assertIn(f"from: {self.site / 'covbeam' / '__init__.py'}", output)
        self.assertFalse(self.installed.exists())
        self.assertFalse((self.site / "covbeam").exists())

    def test_an_installed_extension_works_after_a_restart(self):
        self.run_blender("install()")
        output = self.run_blender("""
enable()
print("enabled:", module in addons())
fog()
render("picture.png")
""")
        self.assert_told(output, "enabled: True")
        self.assertTrue((self.folder / "picture.png").exists())

    def test_a_second_install_takes_the_place_of_the_first(self):
        output = self.run_blender(
            "install(); install(); fog(); render('picture.png'); print(list(addons()).count(module))"
        )
        self.assert_told(output, "\n1\n")


class Repository(InProfile):
    """A folder of zips with an index, to which an artist has been given the address."""

    # From any repository Blender installs only when access to the network is allowed, be its address a file. So it must know no
    # other one. Each program adds it anew, as the bpy package does not read preferences.
    BEGIN = """
module = "bl_ext.fog.covbeam"
preferences = bpy.context.preferences
repos = preferences.extensions.repos
while len(repos): repos.remove(repos[0])
preferences.system.use_online_access = True
bpy.ops.preferences.extension_repo_add(name="fog", remote_url={url!r}, type="REMOTE")

def sync():
    bpy.ops.extensions.repo_sync_all()

def upgrade():
    bpy.ops.extensions.package_upgrade_all()

def install():
    bpy.ops.extensions.package_install(repo_index=repos.find("fog"), pkg_id="covbeam", enable_on_install=True)

def try_render():
    try:
        render("picture.png")
        import covbeam
        print("rendered:", os.path.getsize("picture.png") > 0, extension("latest").get().outcome, covbeam.__version__)
    except RuntimeError as error:
        print("raised:", error)

def tell():
    import tomllib
    with open(os.path.join(repos["fog"].directory, "covbeam", "blender_manifest.toml"), "rb") as file:
        print("installed:", tomllib.load(file)["version"], module in addons())
"""

    def setUp(self):
        super().setUp()
        self.served = self.folder / "Licht und Größe"
        self.begin = self.BEGIN.format(url=(self.served / "index.json").as_uri())

    def serve(self, *wheels):
        """Puts a zip with these wheels in the place of what the folder has, and writes the index, as RELEASING.md says."""
        shutil.rmtree(self.served, ignore_errors=True)
        with contextlib.redirect_stdout(io.StringIO()):
            build.build(self.served, wheels)
        self.assertNotIn("WARN", blender_ext("server-generate", "--repo-dir", self.served))

    def test_a_repository_installs_and_updates(self):
        here, other = wheels_for(self.folder, "manylinux_2_17_x86_64", "win_amd64")
        version = here.name.split("-")[1]
        newer = "9" + version[1:]
        self.serve(here, other)
        installed = self.run_blender(self.begin + "sync(); install(); upgrade(); tell(); fog(); try_render()")
        words = ("No installed packages to update", f"installed: {version} True", f"rendered: True Outcome.DONE {version}")
        self.assert_told(installed, *words)
        # The library that was loaded stays until Blender ends, and is not used by an add-on of another version.
        self.serve(newer_wheel(here), newer_wheel(other))
        updated = self.run_blender(self.begin + "enable(); sync(); upgrade(); tell(); fog(); try_render()")
        told = f"raised: Error: Covbeam: Restart Blender: it still runs the library of Covbeam {version}, and {newer} is installed."
        self.assert_told(updated, f"installed: {newer} True", told)
        restarted = self.run_blender(self.begin + "enable(); tell(); fog(); try_render()")
        self.assert_told(restarted, f"installed: {newer} True", f"rendered: True Outcome.DONE {newer}")

    def test_a_repository_with_nothing_for_this_system_installs_nothing(self):
        self.serve(*wheels_for(self.folder, "win_amd64"))
        output = self.run_blender(self.begin + """
sync()
install()
print("enabled:", module in addons(), os.path.exists(os.path.join(repos["fog"].directory, "covbeam")))
""")
        self.assert_told(output, 'Package "covbeam", found but not compatible with this system', "enabled: False False")


class Broken(InProfile):
    """Something is wrong: what the artist reads when the add-on is enabled, used, and in its preferences and panels."""

    def after_breaking(self, program, before=""):
        """Installs, breaks the installation by `program` between two starts of Blender, and uses it: what is read."""
        self.run_blender("install()")
        program()
        return self.use(before)

    def use(self, before=""):
        output = self.run_blender(
            before
            + """
class Layout:
    # Stands in for the layout of a panel: prints what would be drawn.
    def column(self, **given): return self
    def label(self, text="", **given): print("drawn:", text)

enable()
fog()
try:
    render("picture.png")
except RuntimeError as error:
    print("raised:", error)
problem = extension("requirements").found()
print("panel:", problem)
class Self: layout = Layout()
extension("preferences").CovbeamPreferences.draw(Self, bpy.context)
"""
        )
        read = " ".join(line.removeprefix("drawn: ") for line in output.splitlines() if line.startswith("drawn: "))
        for place in ("raised: Error: Covbeam: ", "panel: "):
            self.assertIn(place, output)
            # Only long words are broken where lines end.
            told = output.split(place, 1)[1].splitlines()[0]
            self.assertEqual(told.replace(" ", ""), read.replace(" ", ""))
        self.assertNotIn("Traceback", output)
        return read

    def library(self):
        return next((self.site / "covbeam").glob("libcovbeam.*"))

    def test_a_missing_library(self):
        read = self.after_breaking(lambda: self.library().unlink())
        self.assertIn("module covbeam.session does not run here", read)
        self.assertIn("Install from Disk", read)

    def test_a_damaged_library(self):
        read = self.after_breaking(lambda: self.library().write_text("no library"))
        self.assertIn("module covbeam.session does not run here", read)
        self.assertIn("damaged", read)

    def test_a_library_for_another_processor(self):
        def other_processor():
            path = self.library()
            data = bytearray(path.read_bytes())
            # e_machine of the ELF header: that of a SPARC.
            data[18:20] = (2).to_bytes(2, "little")
            path.write_bytes(data)

        self.assertIn("for another system", self.after_breaking(other_processor))

    def change(self, file, before, after):
        """Changes the text of a file of the module."""
        path = self.site / "covbeam" / file
        text = path.read_text()
        self.assertEqual(text.count(before), 1)
        path.write_text(text.replace(before, after))

    def test_a_library_with_another_abi(self):
        read = self.after_breaking(lambda: self.change("_abi.py", "\nABI_VERSION = ", "\nABI_VERSION = 999 + "))
        self.assertIn("of another version", read)
        self.assertRegex(read, "ABI 10[0-9][0-9]|ABI 999")

    def test_a_library_that_lacks_a_function(self):
        read = self.after_breaking(lambda: self.change("_session_abi.py", "\nPROTOTYPES = {", '\nPROTOTYPES = {"covbeam_nothing": "",'))
        self.assertIn("of another version", read)
        self.assertIn("covbeam_nothing", read)

    def test_a_library_of_another_version_than_its_module(self):
        def other_version():
            (path,) = self.site.glob("covbeam-*.dist-info/METADATA")
            path.write_text(re.sub("(?m)^Version: .*$", "Version: 9.9.9", path.read_text()))

        read = self.after_breaking(other_version)
        self.assertRegex(read, r"^Restart Blender: it still runs the library of Covbeam [0-9.]+, and 9\.9\.9 is installed\. ")
        self.assertIn("Install from Disk", read)

    def test_a_zip_whose_wheel_is_for_another_system_but_says_nothing_of_it(self):
        other = self.folder / "other.zip"

        def renamed(text):
            return re.sub("manylinux_[0-9]+_[0-9]+_x86_64", "win_amd64", text)

        copy_zip(other, renamed, renamed)
        self.run_blender(f"zip_path = {str(other)!r}; install()")
        read = self.use()
        self.assertIn("not installed completely", read)
        self.assertIn("its module covbeam is missing", read)
        self.assertIn("install the zip made for this system", read)

    def test_a_missing_wheel(self):
        read = self.after_breaking(lambda: shutil.rmtree(self.site / "covbeam"))
        self.assertIn("not installed completely", read)
        self.assertIn("its module covbeam is missing", read)

    def test_no_numpy(self):
        read = self.after_breaking(lambda: None, before="sys.modules['numpy'] = None\n")
        self.assertIn("numpy is missing", read)

    def test_a_blender_that_is_too_old(self):
        # Before 4.2 there are no extensions: an artist copies the folder to where add-ons are.
        with zipfile.ZipFile(ZIP) as archive:
            archive.extractall(self.profile / "scripts" / "addons" / "covbeam")
        (self.profile / "scripts" / "addons" / "covbeam" / "blender_manifest.toml").unlink()
        output = self.run_blender("""
class App:
    version = (4, 1, 1)
    def __getattr__(self, name): return getattr(app, name)
app, bpy.app = bpy.app, App()
import addon_utils
print("enabled:", addon_utils.enable("covbeam") is not None, hasattr(bpy.types.Scene, "covbeam"))
class Layout:
    def column(self, **given): return self
    def label(self, text="", **given): print(text)
class Self: layout = Layout()
import covbeam as addon
addon.preferences.CovbeamPreferences.draw(Self, bpy.context)
addon_utils.disable("covbeam")
""")
        self.assert_told(output, "enabled: True False", "Covbeam needs Blender 4.2 or newer")

    def test_a_zip_for_another_system_is_refused_by_blender(self):
        other = self.folder / "other.zip"
        copy_zip(other, lambda manifest: re.sub("(?m)^platforms = .*$", 'platforms = ["windows-arm64"]', manifest))
        output = self.run_blender(f"""
zip_path = {str(other)!r}
refused()
print("enabled:", module in addons())
""")
        self.assert_told(output, "enabled: False", "windows-arm64")


class ReadOnly(InProfile):
    def lock(self, folder):
        paths = [folder, *folder.rglob("*")]
        for path in paths:
            if path.is_dir():
                path.chmod(0o555)
                self.addCleanup(path.chmod, 0o755)

    def test_installing_into_a_read_only_profile_is_told_and_blender_lives(self):
        (self.profile / "extensions" / "user_default").mkdir(parents=True)
        self.lock(self.profile)
        output = self.run_blender(
            """
refused()
print("enabled:", module in addons())
bpy.ops.mesh.primitive_cube_add()
""",
            preexec_fn=obey_permissions,
        )
        self.assertIn("enabled: False", output)
        self.assertRegex(output, "(?i)permission denied|read-only")

    def test_an_installed_extension_renders_in_a_read_only_profile(self):
        self.run_blender("install()")
        self.lock(self.profile)
        output = self.run_blender(
            """
enable()
fog()
render("picture.png")
print("rendered:", os.path.getsize("picture.png") > 0)
bpy.context.scene.render.engine = "CYCLES"
bpy.context.scene.covbeam.folder = os.path.join(os.environ["BLENDER_USER_RESOURCES"], "beams")
try:
    bpy.ops.covbeam.add_beams()
except RuntimeError as error:
    print("raised:", error)
""",
            preexec_fn=obey_permissions,
        )
        self.assert_told(
            output,
            "rendered: True",
            "raised: Error: Nothing can be written into",
            "Permission denied",
            "set another Folder",
        )


if __name__ == "__main__":
    unittest.main()
