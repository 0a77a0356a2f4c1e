"""A front end that speaks to a widget's kernel side as a view does."""

from __future__ import annotations

from typing import Any

from comm.base_comm import BaseComm

import vfwidget as vf


class FrontEnd(BaseComm):
    """Records what the kernel publishes, and speaks as a view does."""

    def __init__(self, **keywords: Any) -> None:
        self.sent: list[dict[str, Any]] = []
        super().__init__(**keywords)

    def publish_msg(self, msg_type: str, data: Any = None, **_: Any) -> None:
        if msg_type == "comm_msg":
            self.sent.append(data)

    def receive(self, **data: Any) -> None:
        self.handle_msg({"content": {"data": data}, "buffers": []})

    def custom(self, content: Any) -> None:
        self.receive(method="custom", content=content)

    def update(self, **state: Any) -> None:
        self.receive(method="update", state=state, buffer_paths=[])

    @property
    def replies(self) -> list[dict[str, Any]]:
        return [data["content"] for data in self.sent if data["method"] == "custom"]

    @property
    def state(self) -> dict[str, Any]:
        """The latest value the kernel sent of each trait."""
        updates = [data["state"] for data in self.sent if data["method"] == "update"]
        return {name: value for state in updates for name, value in state.items()}


def drag(editor: Any, handle: vf.Handle, x: float, y: float, **more: Any) -> dict[str, Any]:
    place = [handle.glyph, handle.contour, handle.segment, handle.t]
    message = {"type": "drag", "view": "v", "seq": 1, "phase": "move", "handle": place}
    editor.comm.custom(message | {"x": x, "y": y} | more)
    return editor.comm.replies[-1]
