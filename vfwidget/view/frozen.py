"""Dictionaries and lists that cannot be changed in place, which a trait would not notice."""

from __future__ import annotations

from typing import Any, NoReturn

from ..errors import SolveError


def _refuse(self: Any, *_: Any, **__: Any) -> NoReturn:
    raise SolveError(
        "The editor does not notice a change within one of its attributes. Assign a new value: "
        'editor.axes = {**editor.axes, "wght": 700}, or editor.pins = [*editor.pins, handle].'
    )


class FrozenDict(dict[Any, Any]):
    """A dictionary that cannot be changed; its copies can."""

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> Any:
        return dict, (dict(self),)


class FrozenList(list[Any]):
    """A list that cannot be changed; its copies can."""

    __setitem__ = __delitem__ = __iadd__ = __imul__ = _refuse
    append = extend = insert = pop = remove = clear = sort = reverse = _refuse

    def __reduce__(self) -> Any:
        return list, (list(self),)


def frozen(values: Any) -> Any:
    """A dictionary or list as one that cannot be changed, and so everything within it."""
    if isinstance(values, dict):
        return FrozenDict({key: frozen(value) for key, value in values.items()})
    if isinstance(values, list | tuple):
        return FrozenList(frozen(value) for value in values)
    return values
