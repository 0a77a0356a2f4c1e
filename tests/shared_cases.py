"""Cases of the variation maths that the Python and the JavaScript tests share."""

from __future__ import annotations

import json
from pathlib import Path

CASES = json.loads((Path(__file__).parents[1] / "js/tests/cases.json").read_text("utf-8"))
