"""A font from a URL, within a time limit and a size limit."""

from __future__ import annotations

import queue
import threading
import time
import urllib.error
import urllib.request
from http.client import HTTPException, HTTPMessage
from typing import IO

from ..errors import FontError
from ..limits import limits

SCHEMES = ("http://", "https://")
PIECE_BYTES = 2**16


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follows redirects to http and https only; the base class also follows them to ftp."""

    def redirect_request(
        self,
        req: urllib.request.Request,
        fp: IO[bytes],
        code: int,
        msg: str,
        headers: HTTPMessage,
        newurl: str,
    ) -> urllib.request.Request | None:
        if not newurl.lower().startswith(SCHEMES):
            raise urllib.error.URLError(f"a redirect to {newurl[:200]} is not followed")
        return super().redirect_request(req, fp, code, msg, headers, newurl)


def download(url: str) -> bytes:
    """Fetch a URL.

    Parameters
    ----------
    url : str
        An address that starts with ``http://`` or ``https://``.

    Returns
    -------
    bytes
        At most one byte more than ``limits.font_file_bytes``.

    Raises
    ------
    FontError
        The download failed, was incomplete, or took longer than ``limits.download_seconds``.
    """
    # A server can delay each line and each byte, and a look-up of a name has no time limit. So
    # another thread waits for them, and this one waits for that thread no longer than the limit.
    answers: queue.Queue[bytes | Exception] = queue.Queue()
    deadline = time.monotonic() + limits.download_seconds
    threading.Thread(target=_answer, args=(url, deadline, answers), daemon=True).start()
    try:
        answer = answers.get(timeout=limits.download_seconds)
    except queue.Empty:
        answer = _too_slow()
    if isinstance(answer, bytes):
        return answer
    reason = f"{type(answer).__name__}: {answer}" if str(answer) else type(answer).__name__
    raise FontError(f"Could not download {url[:200]} ({reason}).") from answer


def _answer(url: str, deadline: float, answers: queue.Queue[bytes | Exception]) -> None:
    try:
        answers.put(_fetch(url, deadline))
    except (OSError, ValueError, HTTPException) as error:
        answers.put(error)


def _fetch(url: str, deadline: float) -> bytes:
    opener = urllib.request.build_opener(_Redirects)
    with opener.open(url, timeout=limits.download_seconds) as response:
        length = response.length  # None if the server does not announce it
        most = limits.font_file_bytes + 1
        data = bytearray()
        while len(data) < most and len(data) != length:
            piece = response.read1(PIECE_BYTES)
            if time.monotonic() > deadline:
                raise _too_slow()
            if not piece:
                break
            data += piece
    if length is not None and len(data) < min(length, most):
        raise OSError(f"the server announced {length} bytes and sent {len(data)}")
    return bytes(data[:most])


def _too_slow() -> TimeoutError:
    return TimeoutError(
        f"it took longer than {limits.download_seconds:g} s; "
        "if the server is slow, raise vfwidget.limits.download_seconds"
    )
