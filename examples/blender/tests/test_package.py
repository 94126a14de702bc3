# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip as an artist gets it: checked, installed into a fresh profile, used, removed; and broken in all known ways.

COVBEAM_ZIP names the zip. Each test starts Blender (the bpy package of the Python that runs this) anew, with a
profile of its own.
"""

import contextlib
import ctypes
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

import bpy

ZIP = Path(os.environ["COVBEAM_ZIP"]).resolve()
BUILD = Path(__file__).resolve().parents[1] / "build.py"
SCRIPTS = Path(bpy.utils.system_resource("SCRIPTS"))
BLENDER_EXT = SCRIPTS / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"

MODULE = "bl_ext.user_default.covbeam"

#: What every program below begins with. The engine renders the factory's cube, filled with fog.
BEGIN = f"""
import os, sys, bpy
module = {MODULE!r}
zip_path = {str(ZIP)!r}

def install():
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)

def enable():
    # What Blender does when it starts; the bpy package does not read preferences.
    import addon_utils
    addon_utils.enable(module, default_set=True)

def extension(name):
    return __import__("importlib").import_module(module + "." + name)

def addons():
    return bpy.context.preferences.addons.keys()

def fog():
    material = bpy.data.objects["Cube"].data.materials[0]
    tree = material.node_tree
    tree.nodes.clear()
    volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])

def render(path):
    scene = bpy.context.scene
    scene.render.engine = "COVBEAM"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 2, 1000, 0.0
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)
"""

#: And what it ends with: the bpy package 4.2 crashes when Python ends (see harness.py); what counts is to get here.
END = """
print("alive", flush=True)
sys.stderr.flush()
os._exit(0)
"""

CAP_DAC_OVERRIDE = 1
PR_CAPBSET_DROP = 24


def obey_permissions():
    """Lets a program started by root obey the permissions of files, as everyone else's do."""
    if os.getuid() == 0:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


class InProfile(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.profile = self.folder / "profile"
        self.profile.mkdir()
        self.installed = self.profile / "extensions" / "user_default" / "covbeam"
        version = "python{}.{}".format(*sys.version_info[:2])
        self.site = self.profile / "extensions" / ".local" / "lib" / version / "site-packages"

    def run_blender(self, program, **options):
        """Runs a program in Blender; returns what it has printed. It must come to its end."""
        environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "COVBEAM_LIBRARY")}
        environment["BLENDER_USER_RESOURCES"] = str(self.profile)
        ended = subprocess.run(
            [sys.executable, "-c", BEGIN + program + END],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=120,
            **options,
        )
        self.assertEqual(ended.returncode, 0, ended.stdout)
        self.assertIn("alive", ended.stdout)
        return ended.stdout

    def assert_told(self, output, *words):
        """The output has all words, and no traceback."""
        for word in words:
            self.assertIn(word, output)
        self.assertNotIn("Traceback", output)


class Package(unittest.TestCase):
    def blender_ext(self, *arguments):
        ended = subprocess.run(
            [sys.executable, str(BLENDER_EXT), *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.assertEqual(ended.returncode, 0, ended.stdout)
        return ended.stdout

    def test_blenders_own_tool_accepts_the_zip(self):
        self.assertNotIn("warning", self.blender_ext("validate", ZIP).lower())

    def test_blenders_own_tool_builds_the_same_files(self):
        with tempfile.TemporaryDirectory() as folder:
            source, output = Path(folder) / "source", Path(folder) / "output"
            output.mkdir()
            with zipfile.ZipFile(ZIP) as archive:
                archive.extractall(source)
                names = {name: archive.read(name) for name in archive.namelist()}
            self.blender_ext("build", "--source-dir", source, "--output-dir", output)
            (built,) = output.glob("*.zip")
            with zipfile.ZipFile(built) as archive:
                self.assertEqual(
                    {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}, names
                )

    def test_the_zip_is_the_same_each_time(self):
        sys.path.insert(0, str(BUILD.parent))
        import build

        with tempfile.TemporaryDirectory() as folder:
            contents = {"b/c.py": b"x" * 1000, "a.py": b"y"}
            first, second = Path(folder) / "1.zip", Path(folder) / "2.zip"
            build.write_zip(first, contents)
            build.write_zip(second, dict(reversed(contents.items())))
            self.assertEqual(first.read_bytes(), second.read_bytes())

    def wheels(self, folder, *tags):
        """The zip's wheel under the names of other platforms."""
        with zipfile.ZipFile(ZIP) as archive:
            (name,) = (name for name in archive.namelist() if name.startswith("wheels/"))
            data = archive.read(name)
        start = Path(name).name.rsplit("-", 1)[0]
        paths = [Path(folder, f"{start}-{tag}.whl") for tag in tags]
        for path in paths:
            path.write_bytes(data)
        return paths

    def test_one_zip_is_for_all_platforms_that_wheels_are_for_and_updates_from_a_repository(self):
        import tomllib

        sys.path.insert(0, str(BUILD.parent))
        import build

        tags = ("manylinux_2_17_x86_64", "manylinux_2_28_aarch64", "macosx_11_0_arm64", "macosx_10_12_x86_64", "win_amd64", "win_arm64")
        platforms = ["linux-arm64", "linux-x64", "macos-arm64", "macos-x64", "windows-arm64", "windows-x64"]
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            made = build.build(Path(folder, "made"), self.wheels(folder, *tags))
            self.assertRegex(made.name, r"^covbeam-[0-9.]+\.zip$")
            self.assertNotIn("warning", self.blender_ext("validate", made).lower())
            with zipfile.ZipFile(made) as archive:
                archive.extractall(Path(folder, "source"))
                manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            self.assertEqual(manifest["platforms"], platforms)
            self.assertEqual(len(manifest["wheels"]), len(tags))
            # Blender's own tool finds one wheel for each.
            repository = Path(folder, "repository")
            repository.mkdir()
            self.blender_ext("build", "--source-dir", Path(folder, "source"), "--output-dir", repository, "--split-platforms")
            split = {path.stem.split("-", 2)[2].replace("_", "-"): path for path in repository.glob("*.zip")}
            self.assertEqual(sorted(split), platforms)
            for path in split.values():
                with zipfile.ZipFile(path) as archive:
                    self.assertEqual(len([name for name in archive.namelist() if name.endswith(".whl")]), 1)
            # A folder of zips that Blender installs and updates from.
            shutil.rmtree(repository)
            repository.mkdir()
            shutil.copy(made, repository)
            self.blender_ext("server-generate", "--repo-dir", repository)
            (listed,) = json.loads(Path(repository, "index.json").read_text())["data"]
            self.assertEqual((listed["id"], listed["platforms"]), ("covbeam", platforms))
            self.assertEqual((listed["archive_url"], listed["archive_size"]), (f"./{made.name}", made.stat().st_size))

    def test_wheels_that_do_not_go_together_are_refused_with_one_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            one, other, newer = self.wheels(folder, "manylinux_2_17_x86_64", "manylinux_2_28_x86_64", "win_amd64")
            newer = newer.rename(newer.with_name(f"covbeam-9.9.9-{newer.name.split('-', 2)[2]}"))
            text = Path(folder, "covbeam.zip")
            text.write_text("none")
            unknown, both, missing = self.wheels(folder, "musllinux_1_2_x86_64", "macosx_11_0_universal2", "win_arm64")
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
        self.assertEqual(len(wheels), 1)
        self.assertEqual(len(manifest["platforms"]), 1)
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
        with zipfile.ZipFile(ZIP) as archive, zipfile.ZipFile(other, "w") as copy:
            for name in archive.namelist():
                data = archive.read(name)
                if name == "blender_manifest.toml":
                    platforms = next(line for line in data.splitlines() if line.startswith(b"platforms"))
                    data = data.replace(platforms, b'platforms = ["windows-arm64"]')
                copy.writestr(name, data)
        output = self.run_blender(f"""
zip_path = {str(other)!r}
try:
    install()
except RuntimeError as error:
    print("raised:", error)
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
try:
    install()
except Exception as error:
    print("raised:", type(error).__name__, error)
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
