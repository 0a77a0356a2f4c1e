"""Every notebook runs without messages and in time, and is committed without outputs."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from docs.gallery import sockets_in

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))
SECONDS = 280
CELL_SECONDS = 200
"""Less than for a whole notebook, so that an error names the cell that does not end."""
NOWHERE = "http://127.0.0.1:9"
ABSOLUTE_PATH = re.compile(r"""(?:^|[\s"'`(=])(?:/\w[\w.-]*/|~/|[A-Za-z]:\\|file:)""", re.MULTILINE)


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request: pytest.FixtureRequest) -> Any:
    return nbformat.read(request.param, as_version=nbformat.NO_CONVERT)


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


def marked(path: Path) -> Any:
    # One notebook shows that kernels work at all; the slow run executes the others.
    marks = [] if path == NOTEBOOKS[0] else [pytest.mark.slow]
    return pytest.param(path, marks=marks, id=path.stem)


@pytest.mark.timeout(SECONDS)
@pytest.mark.parametrize("path", [marked(path) for path in NOTEBOOKS])
def test_it_runs_without_messages_on_stderr(path: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(path, as_version=nbformat.NO_CONVERT)
    environment = os.environ | {
        # Import the same copy of the package as the tests.
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        # Also show warnings that Python hides outside of __main__.
        "PYTHONWARNINGS": "default",
        "IPYTHONDIR": str(tmp_path),
        "http_proxy": NOWHERE,
        "https_proxy": NOWHERE,
    }
    # The kernel chooses its own backend, which puts figures into the notebook.
    environment.pop("MPLBACKEND", None)
    # The path of a socket has to be short.
    with TemporaryDirectory() as sockets:
        client = NotebookClient(
            notebook,
            timeout=CELL_SECONDS,
            kernel_name="python3",
            resources={"metadata": {"path": str(tmp_path)}},
            config=sockets_in(sockets),
        )
        client.execute(env=environment)
    said = [
        output.text
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if output.output_type == "stream" and output.name == "stderr"
    ]
    assert not said, "\n".join(said)


def test_it_is_committed_without_outputs(notebook: Any) -> None:
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.id for cell in code if cell.outputs or cell.execution_count is not None] == []
    assert notebook.metadata.kernelspec.name == "python3"


def test_it_names_no_absolute_path(notebook: Any) -> None:
    found = [path for cell in notebook.cells for path in ABSOLUTE_PATH.findall(cell.source)]
    assert found == []
