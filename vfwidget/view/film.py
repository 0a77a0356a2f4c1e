"""The data that the player's view needs to draw an animation by itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array
from ..export.svg import path_data
from ..motion.animation import Animation
from ..motion.tracks import drawn_box, letter_tracks, user_coordinates


def describe_film(animation: Animation) -> dict[str, Any]:
    """Describe the frames of an animation, with arrays as float32 buffers.

    Parameters
    ----------
    animation : Animation

    Returns
    -------
    dict
        The value of the ``_film`` trait; ``js/README.md`` describes its entries.
    """
    users = user_coordinates(animation)
    pictures = [path_data(contours) for contours in animation.scenery]
    different = list(dict.fromkeys(pictures))
    index = {picture: i for i, picture in enumerate(different)}
    return {
        "times": (animation.times - animation.times[0]).tolist(),
        "vector_count": users.shape[1],
        "letter_count": animation.offsets.shape[1],
        "axes": _buffer(users),
        "offsets": _buffer(animation.offsets),
        "rotations": _buffer(animation.rotations),
        "box": list(drawn_box(animation, letter_tracks(animation))),
        "obstacles": different,
        "scene": [index[picture] for picture in pictures],
    }


def _buffer(values: Array) -> bytes:
    return np.ascontiguousarray(values, dtype="<f4").tobytes()
