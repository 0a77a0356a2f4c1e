"""Former names of public keywords keep working for one version, with a warning."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from .errors import warn_caller

Named = TypeVar("Named", bound=Callable[..., Any])


def renamed(**names: str) -> Callable[[Named], Named]:
    """Decorate a function or a class so that it takes former names of its keywords.

    A class keeps the former names as read-only attributes too.

    Parameters
    ----------
    **names : str
        Each former name, and the present one: ``@renamed(measure="width")``.

    Raises
    ------
    TypeError
        When the decorated function is called with a former and its present name at once.

    Warns
    -----
    DeprecationWarning
        When it is called with a former name.
    """

    def decorate(function: Named) -> Named:
        if isinstance(function, type):
            for old, new in names.items():
                setattr(function, old, _former_attribute(old, new))
            function.__init__ = decorate(function.__init__)  # type: ignore[misc]
            return function

        @wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            for old in names.keys() & kwargs.keys():
                new = names[old]
                if new in kwargs:
                    raise TypeError(f"{new}= and its former name {old}= are both given.")
                kwargs[new] = kwargs.pop(old)
                warn_renamed(f"{old}=", f"{new}=")
            return function(*args, **kwargs)

        return call  # type: ignore[return-value]

    return decorate


def _former_attribute(old: str, new: str) -> property:
    def read(self: Any) -> Any:
        warn_renamed(old, new)
        return getattr(self, new)

    return property(read, doc=f"The former name of :attr:`{new}`.")


def warn_renamed(old: str, new: str) -> None:
    """Issue a :class:`DeprecationWarning` at the line of code that called into this package."""
    warn_caller(f"{old} is now called {new}.", DeprecationWarning)
